// SPDX-License-Identifier: Apache-2.0
// Arrays of numpy as a dataset's, and back, without copies.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "ovoid/dataset.h"

namespace ovoid::python {

// An array with its place in a dataset. `values`: in C order, of the machine's byte order and of
// one of the library's types; the dataset keeps it.
struct NamedArray {
  std::string name;
  pybind11::array values;  // [num_tuples] or [num_tuples, num_components], or as many in all
  std::string unit;
  bool is_cell_data = false;
};

// `matrix`: world_from_index by rows, its last column the first sample's place.
LatticeGeometry geometry_of(const Index3& dims, const std::array<std::array<double, 4>, 3>& matrix);

// Throws
// Error(kInvalidArgument) for another number of values than samples, other types and orders.
std::shared_ptr<const Dataset> make_lattice(const std::string& source, const Index3& dims,
                                            const std::array<std::array<double, 4>, 3>& matrix,
                                            const std::vector<NamedArray>& arrays);

// The same of samples that were left in a file: the only array of `read`, by another name. Throws
// Error(kInvalidArgument) for another number of samples.
std::shared_ptr<const Dataset> make_lattice_of(const Dataset& read, const std::string& source,
                                               const Index3& dims,
                                               const std::array<std::array<double, 4>, 3>& matrix,
                                               const std::string& name, const std::string& unit);

// `positions`: [n, 3] float32 or float64.
std::shared_ptr<const Dataset> make_particles(const std::string& source,
                                              const pybind11::array& positions,
                                              const std::vector<NamedArray>& arrays);

// The memory of a dataset's array, which lives as long as the result: [num_tuples] or [num_tuples,
// num_components], read only. None for what has stayed in its file.
pybind11::object to_numpy(const DataArray& array);

// The same of floats that `owner` keeps.
pybind11::array float_view(const std::vector<float>& values, std::vector<pybind11::ssize_t> shape,
                           const std::shared_ptr<const void>& owner);

}  // namespace ovoid::python
