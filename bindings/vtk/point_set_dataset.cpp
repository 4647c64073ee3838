// SPDX-License-Identifier: Apache-2.0
#include "point_set_dataset.h"

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "ovoid/error.h"

namespace ovoid::mappers {
namespace {

struct CellShape {
  CellType type = CellType::kOther;
  int least_nodes = 0;
};

CellShape shape_of(int vtk_type) {
  switch (vtk_type) {
    case VTK_VERTEX:
    case VTK_POLY_VERTEX:
      return {CellType::kVertex, 1};
    case VTK_LINE:
      return {CellType::kLine, 2};
    case VTK_TRIANGLE:
      return {CellType::kTriangle, 3};
    case VTK_PIXEL:  // its corners are put into a quad's order
    case VTK_QUAD:
      return {CellType::kQuad, 4};
    case VTK_TETRA:
      return {CellType::kTetrahedron, 4};
    case VTK_VOXEL:
      return {CellType::kVoxel, 8};
    case VTK_HEXAHEDRON:
      return {CellType::kHexahedron, 8};
    case VTK_WEDGE:
      return {CellType::kWedge, 6};
    case VTK_PYRAMID:
      return {CellType::kPyramid, 5};
    case VTK_QUADRATIC_TETRA:
      return {CellType::kQuadraticTetrahedron, 10};
    case VTK_QUADRATIC_HEXAHEDRON:
      return {CellType::kQuadraticHexahedron, 20};
    case VTK_QUADRATIC_WEDGE:
      return {CellType::kQuadraticWedge, 15};
    case VTK_QUADRATIC_PYRAMID:
      return {CellType::kQuadraticPyramid, 13};
    case VTK_TRIQUADRATIC_HEXAHEDRON:
      return {CellType::kTriQuadraticHexahedron, 27};
    default:
      return {};
  }
}

[[noreturn]] void fail(vtkPointSet* points, const std::string& what) {
  throw Error(ErrorCode::kInvalidArgument, fmt::format("{}: {}", points->GetClassName(), what));
}

void require_values(vtkPointSet* points, const DrawnValues& drawn) {
  if (drawn.array == nullptr)
    fail(points, "no scalars are active: expected some, or SelectScalarArray");
}

DataArray triples(const char* name, std::vector<double> values) {
  DataArray array;
  const auto owner = std::make_shared<const std::vector<double>>(std::move(values));
  array.name = name;
  array.type = ScalarType::kFloat64;
  array.num_components = 3;
  array.num_tuples = static_cast<std::int64_t>(owner->size()) / 3;
  array.bytes = {owner, std::as_bytes(std::span(*owner))};
  return array;
}

DataArray positions_of(vtkPointSet* points, const Affine3& world_from_data) {
  vtkDataArray* const data = points->GetPoints()->GetData();
  const bool is_floating_data =
      data->GetDataType() == VTK_FLOAT || data->GetDataType() == VTK_DOUBLE;
  if (is_floating_data && world_from_data.isApprox(Affine3::Identity(), 0.0)) {
    DataArray shared = shared_array(data, false);
    shared.name = "positions";
    return shared;
  }
  std::vector<double> moved;
  moved.reserve(static_cast<std::size_t>(data->GetNumberOfValues()));
  for (vtkIdType i = 0; i < data->GetNumberOfTuples(); ++i) {
    const Vec3 place = world_from_data * Vec3(data->GetTuple3(i));
    moved.insert(moved.end(), place.begin(), place.end());
  }
  return triples("positions", std::move(moved));
}

// The flags, if there is one for each.
vtkUnsignedCharArray* of_length(vtkIdType expected, vtkUnsignedCharArray* flags) {
  return flags != nullptr && flags->GetNumberOfTuples() == expected ? flags : nullptr;
}

// Which cells belong here: not those that VTK hides, or that another piece has, too.
std::vector<vtkIdType> cells_to_draw(vtkUnstructuredGrid* grid) {
  constexpr unsigned kLeftOut = vtkDataSetAttributes::DUPLICATECELL |
                                vtkDataSetAttributes::REFINEDCELL |
                                vtkDataSetAttributes::HIDDENCELL;
  const vtkIdType num_nodes = grid->GetNumberOfPoints();
  vtkUnsignedCharArray* const cells =
      of_length(grid->GetNumberOfCells(), grid->GetCellGhostArray());
  vtkUnsignedCharArray* const nodes = of_length(num_nodes, grid->GetPointGhostArray());
  std::vector<vtkIdType> kept;
  kept.reserve(static_cast<std::size_t>(grid->GetNumberOfCells()));
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
    if (cells != nullptr && (cells->GetValue(c) & kLeftOut) != 0) continue;
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    grid->GetCells()->GetCellAtId(c, count, ids);
    const bool has_hidden = nodes != nullptr && std::any_of(ids, ids + count, [&](vtkIdType id) {
                              return id >= 0 && id < num_nodes &&
                                     (nodes->GetValue(id) & vtkDataSetAttributes::HIDDENPOINT) != 0;
                            });
    if (count > 0 && !has_hidden) kept.push_back(c);
  }
  return kept;
}

Cells cells_of(vtkUnstructuredGrid* grid, const std::vector<vtkIdType>& kept) {
  std::vector<CellType> types;
  std::vector<std::int64_t> offsets{0};
  std::vector<std::uint32_t> connectivity;
  types.reserve(kept.size());
  offsets.reserve(kept.size() + 1);
  connectivity.reserve(static_cast<std::size_t>(grid->GetCells()->GetNumberOfConnectivityIds()));
  const vtkIdType num_nodes = grid->GetNumberOfPoints();
  for (const vtkIdType c : kept) {
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    grid->GetCells()->GetCellAtId(c, count, ids);
    const int vtk_type = grid->GetCellType(c);
    const CellShape shape = shape_of(vtk_type);
    if (count < shape.least_nodes)
      fail(grid,
           fmt::format("cell {} has {} points: its type needs {}", c, count, shape.least_nodes));
    for (vtkIdType i = 0; i < count; ++i) {
      if (ids[i] < 0 || ids[i] >= num_nodes)
        fail(grid, fmt::format("cell {} has the point {}: there are {}", c, ids[i], num_nodes));
      connectivity.push_back(static_cast<std::uint32_t>(ids[i]));
    }
    if (vtk_type == VTK_PIXEL) std::swap(connectivity.end()[-1], connectivity.end()[-2]);
    types.push_back(shape.type);
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  Cells cells;
  cells.types = std::move(types);
  cells.offsets = std::move(offsets);
  cells.connectivity = std::move(connectivity);
  return cells;
}

// The values of the cells that are drawn.
DataArray values_of(const DrawnValues& drawn, const std::vector<vtkIdType>& kept) {
  if (!drawn.is_cell_data ||
      static_cast<vtkIdType>(kept.size()) == drawn.array->GetNumberOfTuples())
    return shared_array(drawn.array, drawn.is_cell_data);
  vtkNew<vtkIdList> ids;
  ids->SetNumberOfIds(static_cast<vtkIdType>(kept.size()));
  std::copy(kept.begin(), kept.end(), ids->GetPointer(0));
  const auto values = vtkSmartPointer<vtkDataArray>::Take(
      vtkDataArray::CreateDataArray(drawn.array->GetDataType()));
  values->SetName(drawn.array->GetName());
  values->SetNumberOfComponents(drawn.array->GetNumberOfComponents());
  values->SetNumberOfTuples(ids->GetNumberOfIds());
  drawn.array->GetTuples(ids, values);
  return shared_array(values, true);
}

// Voxels with values of their own are the boxes of an adaptive grid, which meet where their sizes
// differ, too. None of turned ones.
std::vector<double> box_edges(vtkUnstructuredGrid* grid, const std::vector<vtkIdType>& kept,
                              const Affine3& world_from_data) {
  std::vector<double> edges;
  if (!world_from_data.linear().isDiagonal()) return edges;
  for (const vtkIdType c : kept) {
    if (grid->GetCellType(c) != VTK_VOXEL) return {};
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    grid->GetCells()->GetCellAtId(c, count, ids);
    const Vec3 first(grid->GetPoint(ids[0])), last(grid->GetPoint(ids[7]));
    const Vec3 edge = (world_from_data.linear() * (last - first)).cwiseAbs();
    edges.insert(edges.end(), edge.begin(), edge.end());
  }
  return edges;
}

void make_boxes(vtkUnstructuredGrid* grid, const std::vector<vtkIdType>& kept,
                const Affine3& world_from_data, std::vector<double> edges, Dataset& dataset) {
  std::vector<double> centers;
  centers.reserve(edges.size());
  for (const vtkIdType c : kept) {
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    grid->GetCells()->GetCellAtId(c, count, ids);
    const Vec3 first(grid->GetPoint(ids[0])), last(grid->GetPoint(ids[7]));
    const Vec3 center = world_from_data * Vec3(0.5 * (first + last));
    centers.insert(centers.end(), center.begin(), center.end());
  }
  dataset.kind = DatasetKind::kBoxes;
  dataset.cells = {};
  dataset.positions = triples("positions", std::move(centers));
  dataset.box_sizes = triples("sizes", std::move(edges));
  dataset.arrays.front().is_cell_data = false;  // one for each box
}

// Points without cells around them.
void make_particles(vtkPointSet* points, const DrawnValues& drawn, Dataset& dataset) {
  if (drawn.is_cell_data)
    fail(points, fmt::format("array '{}' belongs to cells, but points are drawn: no cell encloses "
                             "anything",
                             dataset.arrays.front().name));
  dataset.kind = DatasetKind::kParticles;
  dataset.cells = {};
}

}  // namespace

Dataset point_set_dataset(vtkPointSet* points, const DrawnValues& drawn,
                          const Affine3& world_from_data) {
  if (points->GetNumberOfPoints() < 1) fail(points, "has no points");
  if (points->GetNumberOfPoints() > std::numeric_limits<std::uint32_t>::max())
    fail(points, fmt::format("has {} points: at most 2^32 - 1", points->GetNumberOfPoints()));
  Dataset dataset;
  dataset.source = points->GetClassName();
  dataset.format = "VTK";
  dataset.positions = positions_of(points, world_from_data);
  if (auto* const grid = vtkStructuredGrid::SafeDownCast(points)) {
    if (grid->HasAnyBlankCells() || grid->HasAnyBlankPoints())
      fail(points, "has blanked points or cells; make it a vtkUnstructuredGrid (vtkAppendFilter)");
    dataset.kind = DatasetKind::kMesh;
    for (std::size_t axis = 0; axis < 3; ++axis)
      dataset.cells.dims[axis] = grid->GetDimensions()[axis];
    require_values(points, drawn);
    dataset.arrays = {shared_array(drawn.array, drawn.is_cell_data)};
    return dataset;
  }
  auto* const grid = vtkUnstructuredGrid::SafeDownCast(points);
  if (grid == nullptr && points->GetNumberOfCells() > 0 && !points->IsA("vtkPolyData"))
    fail(points, "is not drawn; expected vtkUnstructuredGrid, vtkStructuredGrid or vtkPolyData");
  const std::vector<vtkIdType> kept = grid != nullptr && grid->GetCells() != nullptr
                                          ? cells_to_draw(grid)
                                          : std::vector<vtkIdType>();
  dataset.kind = DatasetKind::kMesh;
  if (!kept.empty()) dataset.cells = cells_of(grid, kept);
  const auto types = dataset.cells.types.view();
  const bool are_particles = std::all_of(types.begin(), types.end(),
                                         [](CellType type) { return type == CellType::kVertex; });
  if (!are_particles) require_values(points, drawn);
  if (drawn.array != nullptr) dataset.arrays = {values_of(drawn, kept)};
  if (are_particles) {
    make_particles(points, drawn, dataset);
  } else if (drawn.is_cell_data) {
    std::vector<double> edges = box_edges(grid, kept, world_from_data);
    if (!edges.empty()) make_boxes(grid, kept, world_from_data, std::move(edges), dataset);
  }
  return dataset;
}

}  // namespace ovoid::mappers
