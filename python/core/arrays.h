// SPDX-License-Identifier: Apache-2.0
// Arrays of numpy as a dataset's, and back, without copies.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstdint>
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
  // What a stored number s stands for: s * value_scale + value_offset.
  double value_scale = 1.0;
  double value_offset = 0.0;
};

// The cells of a mesh, as VTK has them; or, with `dims`, structured and without the arrays.
struct MeshCells {
  pybind11::array types;         // [num_cells] uint8: VTK's numbers
  pybind11::array offsets;       // [num_cells + 1] int64, rising from 0
  pybind11::array connectivity;  // [offsets.back()] uint32: node numbers; kept by the dataset
  Index3 dims{0, 0, 0};          // nodes along i, j, k
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

// `positions` as for particles; one tuple of each array for each node, or cell where is_cell_data.
// Throws Error(kInvalidArgument) for arrays of other types or lengths; node numbers and offsets are
// believed, as models and writers look for themselves.
std::shared_ptr<const Dataset> make_mesh(const std::string& source,
                                         const pybind11::array& positions, const MeshCells& cells,
                                         const std::vector<NamedArray>& arrays);

// What a dataset is besides its arrays.
struct Facts {
  std::string format;  // empty: as it is
  std::string space;   // "none", "LPS", "RAS"
  std::vector<std::string> notes;
};

// The same arrays, with facts of their own. Throws Error(kInvalidArgument) for another space.
std::shared_ptr<const Dataset> with_facts(const Dataset& dataset, const Facts& facts);

// The memory of a dataset's array, which lives as long as the result: [num_tuples] or [num_tuples,
// num_components], read only. None for what has stayed in its file.
pybind11::object to_numpy(const DataArray& array);

// The node numbers of a mesh's cells; empty of structured ones and of other data.
pybind11::array node_numbers(const std::shared_ptr<const Dataset>& dataset);

// The same of floats that `owner` keeps.
pybind11::array float_view(const std::vector<float>& values,
                           const std::vector<pybind11::ssize_t>& shape,
                           const std::shared_ptr<const void>& owner);

// A copy, [counts.size()].
pybind11::array copy_of(const std::vector<std::uint64_t>& counts);

}  // namespace ovoid::python
