// SPDX-License-Identifier: Apache-2.0
#include "arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
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

// Bytes of a value. pybind11 before 2.12 looks for them where numpy 2 keeps something else, and so
// nothing here may ask it for sizes or for strides.
py::ssize_t size_of_value(const py::dtype& dtype) {
  return dtype.attr("itemsize").cast<py::ssize_t>();
}

// Values in C order that `keeper` keeps, read only.
py::array view_of(const py::dtype& dtype, const std::vector<py::ssize_t>& shape, const void* values,
                  const py::capsule& keeper) {
  std::vector<py::ssize_t> strides(shape.size(), size_of_value(dtype));
  for (std::size_t i = shape.size(); i-- > 1;) strides[i - 1] = strides[i] * shape[i];
  py::array view(dtype, shape, strides, values, keeper);
  view.attr("setflags")(py::arg("write") = false);
  return view;
}

std::optional<ScalarType> type_of(const py::dtype& dtype) {
  for (const ScalarType type : kTypes) {
    if (dtype.is(py::dtype(name_of(type)))) return type;
  }
  // numpy has several types of one size: long and long long.
  for (const ScalarType type : kTypes) {
    const py::dtype same(name_of(type));
    if (same.kind() == dtype.kind() && size_of_value(same) == size_of_value(dtype) &&
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
  const py::ssize_t size = values.size() * size_of_value(values.dtype());
  return {held(values), {data, static_cast<std::size_t>(size)}};
}

void require_tuples(const NamedArray& named, std::int64_t num_tuples) {
  const std::int64_t size = named.values.size();
  if (num_tuples > 0 && size > 0 && size % num_tuples == 0) return;
  refuse(fmt::format("array '{}': holds {} values, expected one or more for each of {} places",
                     named.name, size, num_tuples));
}

DataArray data_array(const NamedArray& named, std::int64_t num_tuples) {
  const std::optional<ScalarType> type = type_of(named.values.dtype());
  if (!type || (named.values.flags() & py::array::c_style) == 0) {
    refuse(fmt::format("array '{}': expected numbers of one of the library's types in C order",
                       named.name));
  }
  require_tuples(named, num_tuples);
  DataArray array;
  array.name = named.name;
  array.type = *type;
  array.num_components = static_cast<int>(named.values.size() / num_tuples);
  array.num_tuples = num_tuples;
  array.unit = named.unit;
  array.is_cell_data = named.is_cell_data;
  array.value_scale = named.value_scale;
  array.value_offset = named.value_offset;
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

DataArray positions_of(const py::array& positions) {
  if (positions.ndim() != 2 || positions.shape(1) != 3) refuse("xyz: expected the shape (n, 3)");
  DataArray array = data_array({"xyz", positions, ""}, positions.shape(0));
  if (!is_floating(array.type)) refuse("xyz: expected floats");
  return array;
}

// A type by VTK's number.
CellType cell_type_of(unsigned vtk_type) {
  switch (vtk_type) {
    case 1:
    case 2:  // several points
      return CellType::kVertex;
    case 3:
      return CellType::kLine;
    case 4:
      return CellType::kPolyLine;
    case 5:
      return CellType::kTriangle;
    case 8:  // a pixel, whose corners are in a quad's order by now
    case 9:
      return CellType::kQuad;
    case 10:
      return CellType::kTetrahedron;
    case 11:
      return CellType::kVoxel;
    case 12:
      return CellType::kHexahedron;
    case 13:
      return CellType::kWedge;
    case 14:
      return CellType::kPyramid;
    case 24:
      return CellType::kQuadraticTetrahedron;
    case 25:
      return CellType::kQuadraticHexahedron;
    case 26:
      return CellType::kQuadraticWedge;
    case 27:
      return CellType::kQuadraticPyramid;
    case 29:
      return CellType::kTriQuadraticHexahedron;
    default:
      return CellType::kOther;
  }
}

// The numbers of an array that has that type already, kept by it.
template <typename T>
SharedValues<T> shared_values(const py::array& array) {
  if (!array.dtype().equal(py::dtype::of<T>()) || (array.flags() & py::array::c_style) == 0)
    refuse("cells: arrays of another type or order");
  const Bytes bytes = shared_bytes(array);
  return {bytes.owner,
          {static_cast<const T*>(array.data()), static_cast<std::size_t>(array.size())}};
}

Cells cells_of(const MeshCells& given) {
  Cells cells;
  cells.dims = given.dims;
  if (cells.is_structured()) return cells;
  std::vector<CellType> types;
  for (const std::uint8_t type : shared_values<std::uint8_t>(given.types))
    types.push_back(cell_type_of(type));
  cells.types = std::move(types);
  cells.offsets = shared_values<std::int64_t>(given.offsets);
  cells.connectivity = shared_values<std::uint32_t>(given.connectivity);
  if (cells.offsets.size() != cells.types.size() + 1 ||
      cells.offsets.back() != static_cast<std::int64_t>(cells.connectivity.size()))
    refuse("cells: types, offsets and node numbers of other lengths");
  return cells;
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
  Index3 num_cells = dims;  // along an axis of one sample they are flat
  for (std::int64_t& count : num_cells) count = std::max<std::int64_t>(count - 1, 1);
  for (const NamedArray& named : arrays) {
    dataset->arrays.push_back(
        data_array(named, num_samples(named.is_cell_data ? num_cells : dims)));
  }
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
  auto dataset = std::make_shared<Dataset>();
  dataset->source = source;
  dataset->format = "array";
  dataset->kind = DatasetKind::kParticles;
  dataset->positions = positions_of(positions);
  for (const NamedArray& named : arrays)
    dataset->arrays.push_back(data_array(named, positions.shape(0)));
  return dataset;
}

std::shared_ptr<const Dataset> make_mesh(const std::string& source, const py::array& positions,
                                         const MeshCells& cells,
                                         const std::vector<NamedArray>& arrays) {
  auto dataset = std::make_shared<Dataset>();
  dataset->source = source;
  dataset->format = "array";
  dataset->kind = DatasetKind::kMesh;
  dataset->positions = positions_of(positions);
  dataset->positions.name = "positions";
  dataset->cells = cells_of(cells);
  for (const NamedArray& named : arrays) {
    dataset->arrays.push_back(
        data_array(named, named.is_cell_data ? dataset->cells.count() : positions.shape(0)));
  }
  return dataset;
}

std::shared_ptr<const Dataset> with_facts(const Dataset& dataset, const Facts& facts) {
  auto same = std::make_shared<Dataset>(dataset);
  if (!facts.format.empty()) same->format = facts.format;
  constexpr Space kSpaces[] = {Space::kNone, Space::kLps, Space::kRas};
  const auto* const found = std::find_if(std::begin(kSpaces), std::end(kSpaces),
                                         [&](Space s) { return facts.space == name_of(s); });
  if (found == std::end(kSpaces))
    refuse(fmt::format("space = '{}': expected LPS or RAS", facts.space));
  same->space = *found;
  same->notes.insert(same->notes.end(), facts.notes.begin(), facts.notes.end());
  return same;
}

py::object to_numpy(const DataArray& array) {
  if (array.stored) return py::none();
  std::vector<py::ssize_t> shape{array.num_tuples};
  if (array.num_components != 1) shape.push_back(array.num_components);
  using Owner = std::shared_ptr<const void>;
  const py::capsule keeper(new Owner(array.bytes.owner),
                           [](void* owner) { delete static_cast<Owner*>(owner); });
  return view_of(py::dtype(name_of(array.type)), shape, array.bytes.view.data(), keeper);
}

py::array node_numbers(const std::shared_ptr<const Dataset>& dataset) {
  using Owner = std::shared_ptr<const Dataset>;
  const py::capsule keeper(new Owner(dataset),
                           [](void* kept) { delete static_cast<Owner*>(kept); });
  const std::span<const std::uint32_t> nodes = dataset->cells.connectivity.view();
  return view_of(py::dtype::of<std::uint32_t>(), {static_cast<py::ssize_t>(nodes.size())},
                 nodes.data(), keeper);
}

py::array float_view(const std::vector<float>& values, const std::vector<py::ssize_t>& shape,
                     const std::shared_ptr<const void>& owner) {
  using Owner = std::shared_ptr<const void>;
  const py::capsule keeper(new Owner(owner), [](void* kept) { delete static_cast<Owner*>(kept); });
  return view_of(py::dtype::of<float>(), shape, values.data(), keeper);
}

py::array copy_of(const std::vector<std::uint64_t>& counts) {
  const auto size = static_cast<py::ssize_t>(counts.size());
  return py::array_t<std::uint64_t>({size}, {py::ssize_t{sizeof(std::uint64_t)}}, counts.data());
}

}  // namespace ovoid::python
