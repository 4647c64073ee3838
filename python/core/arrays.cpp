// SPDX-License-Identifier: Apache-2.0
#include "arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::python {
namespace {

namespace py = pybind11;

constexpr ScalarType kTypes[] = {ScalarType::kUInt8,  ScalarType::kInt8,   ScalarType::kUInt16,
                                 ScalarType::kInt16,  ScalarType::kUInt32, ScalarType::kInt32,
                                 ScalarType::kUInt64, ScalarType::kInt64,  ScalarType::kFloat32,
                                 ScalarType::kFloat64};

[[noreturn]] void refuse(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

std::optional<ScalarType> type_of(const py::dtype& dtype) {
  for (const ScalarType type : kTypes) {
    if (dtype.is(py::dtype(name_of(type)))) return type;
  }
  // numpy has several types of one size: long and long long.
  for (const ScalarType type : kTypes) {
    const py::dtype same(name_of(type));
    if (same.kind() == dtype.kind() && same.itemsize() == dtype.itemsize() &&
        py::bool_(dtype.attr("isnative")))
      return type;
  }
  return std::nullopt;
}

// Keeps a Python object; may be let go by any thread.
std::shared_ptr<const void> held(py::object object) {
  const auto let_go = [](const py::object* kept) {
    if (Py_IsInitialized() == 0) return;  // the process ends, and with it all objects
    const py::gil_scoped_acquire locked;
    delete kept;
  };
  return std::shared_ptr<const py::object>(new py::object(std::move(object)), let_go);
}

Bytes shared_bytes(const py::array& values) {
  const auto* const data = static_cast<const std::byte*>(values.data());
  return {held(values), {data, static_cast<std::size_t>(values.nbytes())}};
}

DataArray data_array(const NamedArray& named, std::int64_t num_tuples) {
  const std::optional<ScalarType> type = type_of(named.values.dtype());
  if (!type || (named.values.flags() & py::array::c_style) == 0) {
    refuse(fmt::format("array '{}': expected numbers of one of the library's types in C order",
                       named.name));
  }
  const std::int64_t size = named.values.size();
  if (num_tuples == 0 || size == 0 || size % num_tuples != 0) {
    refuse(fmt::format("array '{}': holds {} values, expected one or more for each of {} places",
                       named.name, size, num_tuples));
  }
  DataArray array;
  array.name = named.name;
  array.type = *type;
  array.num_components = static_cast<int>(size / num_tuples);
  array.num_tuples = num_tuples;
  array.unit = named.unit;
  array.is_cell_data = named.is_cell_data;
  array.bytes = shared_bytes(named.values);
  return array;
}

std::shared_ptr<Dataset> empty_lattice(const std::string& source, const Index3& dims,
                                       const std::array<std::array<double, 4>, 3>& matrix) {
  auto dataset = std::make_shared<Dataset>();
  dataset->source = source;
  dataset->format = "array";
  dataset->lattice = geometry_of(dims, matrix);
  return dataset;
}

}  // namespace

LatticeGeometry geometry_of(const Index3& dims,
                            const std::array<std::array<double, 4>, 3>& matrix) {
  LatticeGeometry geometry;
  geometry.dims = dims;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      geometry.world_from_index.matrix()(row, column) =
          matrix[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
    }
  }
  return geometry;
}

std::shared_ptr<const Dataset> make_lattice(const std::string& source, const Index3& dims,
                                            const std::array<std::array<double, 4>, 3>& matrix,
                                            const std::vector<NamedArray>& arrays) {
  auto dataset = empty_lattice(source, dims, matrix);
  for (const NamedArray& named : arrays)
    dataset->arrays.push_back(data_array(named, num_samples(dims)));
  return dataset;
}

std::shared_ptr<const Dataset> make_lattice_of(const Dataset& read, const std::string& source,
                                               const Index3& dims,
                                               const std::array<std::array<double, 4>, 3>& matrix,
                                               const std::string& name, const std::string& unit) {
  if (read.arrays.size() != 1 || read.arrays[0].num_tuples != num_samples(dims))
    refuse(fmt::format("array '{}': holds other samples than were expected", name));
  auto dataset = empty_lattice(source, dims, matrix);
  dataset->arrays = read.arrays;
  dataset->arrays[0].name = name;
  dataset->arrays[0].unit = unit;
  return dataset;
}

std::shared_ptr<const Dataset> make_particles(const std::string& source, const py::array& positions,
                                              const std::vector<NamedArray>& arrays) {
  if (positions.ndim() != 2 || positions.shape(1) != 3) refuse("xyz: expected the shape (n, 3)");
  auto dataset = std::make_shared<Dataset>();
  dataset->source = source;
  dataset->format = "array";
  dataset->kind = DatasetKind::kParticles;
  dataset->positions = data_array({"xyz", positions, "", false}, positions.shape(0));
  if (!is_floating(dataset->positions.type)) refuse("xyz: expected floats");
  for (const NamedArray& named : arrays)
    dataset->arrays.push_back(data_array(named, positions.shape(0)));
  return dataset;
}

py::object to_numpy(const DataArray& array) {
  if (array.stored) return py::none();
  std::vector<py::ssize_t> shape{array.num_tuples};
  if (array.num_components != 1) shape.push_back(array.num_components);
  using Owner = std::shared_ptr<const void>;
  const py::capsule keeper(new Owner(array.bytes.owner),
                           [](void* owner) { delete static_cast<Owner*>(owner); });
  py::array values(py::dtype(name_of(array.type)), shape, array.bytes.view.data(), keeper);
  values.attr("setflags")(py::arg("write") = false);
  return values;
}

py::array float_view(const std::vector<float>& values, std::vector<py::ssize_t> shape,
                     const std::shared_ptr<const void>& owner) {
  using Owner = std::shared_ptr<const void>;
  const py::capsule keeper(new Owner(owner), [](void* kept) { delete static_cast<Owner*>(kept); });
  py::array view(py::dtype::of<float>(), std::move(shape), values.data(), keeper);
  view.attr("setflags")(py::arg("write") = false);
  return view;
}

}  // namespace ovoid::python
