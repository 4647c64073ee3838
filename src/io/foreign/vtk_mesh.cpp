// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK

#include "io/foreign/vtk_mesh.h"

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkMultiPieceDataSet.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkRectilinearGrid.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <utility>

#include "data/cell_builder.h"
#include "io/core/samples.h"
#include "io/foreign/vtk_reading.h"
#include "io/vtk/vtk_cells.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

DataArray positions_of_points(const std::string& source, vtkPoints* points) {
  vtkDataArray* const data = points != nullptr ? points->GetData() : nullptr;
  DataArray positions;
  positions.num_components = 3;
  positions.num_tuples = data != nullptr ? data->GetNumberOfTuples() : 0;
  if (positions.num_tuples == 0) return positions;
  if (data->GetNumberOfComponents() != 3) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: points: {} components: expected 3", source,
                                                    data->GetNumberOfComponents()));
  }
  const auto type = scalar_type_of(data->GetDataType());
  if (type && is_floating(*type)) {
    positions.type = *type;
    positions.bytes = share(
        data, checked_num_bytes(source + ": points", std::array{positions.num_tuples}, *type, 3));
    return positions;
  }
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(positions.num_tuples) * 3);
  for (vtkIdType i = 0; i < positions.num_tuples; ++i) {
    for (int axis = 0; axis < 3; ++axis) values.push_back(data->GetComponent(i, axis));
  }
  positions.type = ScalarType::kFloat64;
  positions.bytes = bytes_owning(std::move(values));
  return positions;
}

// Of a grid whose points follow from their numbers.
DataArray positions_of_grid(vtkDataSet* grid) {
  DataArray positions;
  positions.type = ScalarType::kFloat64;
  positions.num_components = 3;
  positions.num_tuples = grid->GetNumberOfPoints();
  std::vector<double> values(static_cast<std::size_t>(positions.num_tuples) * 3);
  for (vtkIdType i = 0; i < positions.num_tuples; ++i)
    grid->GetPoint(i, values.data() + static_cast<std::size_t>(i) * 3);
  positions.bytes = bytes_owning(std::move(values));
  return positions;
}

class CellReader {
 public:
  CellReader(const std::string& source, std::int64_t num_nodes)
      : source_(source), num_nodes_(num_nodes) {}

  // `types` is a VTK type per cell, or empty: all are `type`.
  void append(vtkCellArray* array, vtkUnsignedCharArray* types, int type) {
    if (array == nullptr || array->GetNumberOfCells() == 0) return;
    if (types != nullptr && types->GetNumberOfTuples() != array->GetNumberOfCells()) {
      fail(fmt::format("{} types for {} cells", types->GetNumberOfTuples(),
                       array->GetNumberOfCells()));
    }
    if (array->IsStorage64Bit())
      append_as(array->GetOffsetsArray64(), array->GetConnectivityArray64(), types, type);
    else
      append_as(array->GetOffsetsArray32(), array->GetConnectivityArray32(), types, type);
  }

  Cells finish() && { return std::move(cells_).finish(); }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: cells: {}", source_, what));
  }

  template <typename Ids>
  void append_as(Ids* offsets, Ids* ids, vtkUnsignedCharArray* types, int type) {
    const vtkIdType num_ids = ids->GetNumberOfValues();
    const auto first = static_cast<std::int64_t>(cells_.connectivity.size());
    cells_.connectivity.reserve(static_cast<std::size_t>(first + num_ids));
    for (vtkIdType i = 0; i < num_ids; ++i) {
      const auto node = static_cast<std::int64_t>(ids->GetValue(i));
      if (node < 0 || node >= num_nodes_) {
        fail(fmt::format("connectivity[{}] = {}: the mesh has {} nodes", i, node, num_nodes_));
      }
      cells_.connectivity.push_back(static_cast<std::uint32_t>(node));
    }
    const vtkIdType num_cells = offsets->GetNumberOfValues() - 1;
    for (vtkIdType c = 0; c < num_cells; ++c) {
      const auto begin = static_cast<std::int64_t>(offsets->GetValue(c));
      const auto end = static_cast<std::int64_t>(offsets->GetValue(c + 1));
      if (begin < 0 || end < begin || end > num_ids) {
        fail(fmt::format("offsets[{}] = {}: expected {} to {}", c, end,
                         std::max<std::int64_t>(begin, 0), num_ids));
      }
      int own_type = types != nullptr ? types->GetValue(c) : type;
      if (types == nullptr && own_type == VTK_POLYGON && end - begin == 3) own_type = VTK_TRIANGLE;
      if (types == nullptr && own_type == VTK_POLYGON && end - begin == 4) own_type = VTK_QUAD;
      cells_.offsets.push_back(first + end);
      cells_.types.push_back(cell_type_of_vtk(own_type));
      if (own_type == VTK_PIXEL && end - begin == 4) {
        const auto corner = cells_.connectivity.begin() + first + begin;
        std::swap(corner[2], corner[3]);
      }
    }
  }

  const std::string& source_;
  std::int64_t num_nodes_;
  data::CellBuilder cells_;
};

void read_cells(const std::string& source, vtkDataSet* data, MeshPart& part) {
  const auto set_dims = [&](const int* dims) {
    for (std::size_t axis = 0; axis < 3; ++axis) part.cells.dims[axis] = dims[axis];
  };
  if (auto* const grid = vtkStructuredGrid::SafeDownCast(data))
    return set_dims(grid->GetDimensions());
  if (auto* const grid = vtkRectilinearGrid::SafeDownCast(data))
    return set_dims(grid->GetDimensions());
  if (auto* const grid = vtkImageData::SafeDownCast(data)) return set_dims(grid->GetDimensions());
  CellReader reader(source, part.num_nodes());
  if (auto* const grid = vtkUnstructuredGrid::SafeDownCast(data)) {
    reader.append(grid->GetCells(), grid->GetCellTypesArray(), VTK_EMPTY_CELL);
  } else if (auto* const poly = vtkPolyData::SafeDownCast(data)) {
    part.is_surface =
        poly->GetNumberOfLines() + poly->GetNumberOfPolys() + poly->GetNumberOfStrips() > 0;
    reader.append(poly->GetVerts(), nullptr, VTK_POLY_VERTEX);
    reader.append(poly->GetLines(), nullptr, VTK_POLY_LINE);
    reader.append(poly->GetPolys(), nullptr, VTK_POLYGON);
    reader.append(poly->GetStrips(), nullptr, VTK_TRIANGLE_STRIP);
  } else {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: holds a {}, which is not read", source, data->GetClassName()));
  }
  part.cells = std::move(reader).finish();
}

void append_parts(const std::string& source, vtkDataObject* data, const std::string& block,
                  std::vector<MeshPart>& parts, std::vector<std::string>& notes) {
  if (data == nullptr) return;
  if (auto* const leaf = vtkDataSet::SafeDownCast(data)) {
    if (leaf->GetNumberOfPoints() == 0) return;
    parts.push_back(part_of(source, leaf, notes));
    parts.back().block = block;
    return;
  }
  if (auto* const pieces = vtkMultiPieceDataSet::SafeDownCast(data)) {
    for (unsigned i = 0; i < pieces->GetNumberOfPieces(); ++i)
      append_parts(source, pieces->GetPieceAsDataObject(i), block, parts, notes);
    return;
  }
  auto* const blocks = vtkMultiBlockDataSet::SafeDownCast(data);
  if (blocks == nullptr) return;  // tables and the like
  for (unsigned i = 0; i < blocks->GetNumberOfBlocks(); ++i) {
    const char* const own = blocks->HasMetaData(i) != 0
                                ? blocks->GetMetaData(i)->Get(vtkCompositeDataSet::NAME())
                                : nullptr;
    std::string name = block.empty() ? block : block + '/';
    name += own != nullptr && *own != '\0' ? std::string(own) : std::to_string(i);
    append_parts(source, blocks->GetBlock(i), name, parts, notes);
  }
}

}  // namespace

MeshPart part_of(const std::string& source, vtkDataSet* data, std::vector<std::string>& notes) {
  MeshPart part;
  part.source = source;
  if (data == nullptr || data->GetNumberOfPoints() == 0) return part;
  auto* const points = vtkPointSet::SafeDownCast(data);
  part.positions = points != nullptr ? positions_of_points(source, points->GetPoints())
                                     : positions_of_grid(data);
  read_cells(source, data, part);
  const auto add = [&](vtkFieldData* fields, std::int64_t num_expected, bool is_cell_data) {
    for (VtkArray& array : numbers_of(source, fields, num_expected, is_cell_data)) {
      if (array.numbers)
        part.arrays.push_back(std::move(*array.numbers));
      else
        notes.push_back(std::move(array.note));
    }
  };
  add(data->GetPointData(), part.num_nodes(), false);
  add(data->GetCellData(), part.cells.count(), true);
  if (vtkDataArray* const time = data->GetFieldData()->GetArray("TimeValue");
      time != nullptr && time->GetNumberOfTuples() == 1) {
    part.time = time->GetComponent(0, 0);
  }
  return part;
}

std::vector<MeshPart> parts_of(const std::string& source, vtkDataObject* data,
                               std::vector<std::string>& notes) {
  std::vector<MeshPart> parts;
  append_parts(source, data, "", parts, notes);
  return parts;
}

}  // namespace ovoid::io

#endif
