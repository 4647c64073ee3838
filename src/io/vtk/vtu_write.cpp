// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/vtu_write.h"

#include <fmt/format.h>

#include <cstdint>
#include <span>
#include <vector>

#include "io/core/samples.h"
#include "io/vtk/vtk_cells.h"
#include "io/vtk/xml_array_file.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

[[noreturn]] void refuse_mesh(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

// The cells as VTK's three columns.
struct VtkCells {
  std::vector<std::int64_t> connectivity;
  std::vector<std::int64_t> offsets;  // one past the end of each
  std::vector<std::uint8_t> types;
};

VtkCells hexahedra(const Index3& dims) {
  VtkCells cells;
  const auto node = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return i + dims[0] * (j + dims[1] * k);
  };
  for (std::int64_t k = 0; k + 1 < dims[2]; ++k) {
    for (std::int64_t j = 0; j + 1 < dims[1]; ++j) {
      for (std::int64_t i = 0; i + 1 < dims[0]; ++i) {
        for (const std::int64_t up : {k, k + 1}) {
          cells.connectivity.insert(
              cells.connectivity.end(),
              {node(i, j, up), node(i + 1, j, up), node(i + 1, j + 1, up), node(i, j + 1, up)});
        }
        cells.offsets.push_back(static_cast<std::int64_t>(cells.connectivity.size()));
        cells.types.push_back(vtk_cell(CellType::kHexahedron).number);
      }
    }
  }
  return cells;
}

VtkCells explicit_cells(const Cells& from, std::int64_t num_nodes) {
  VtkCells cells;
  const auto num_cells = from.types.size();
  if (from.offsets.size() != num_cells + (num_cells > 0 || !from.offsets.empty() ? 1 : 0))
    refuse_mesh(fmt::format("cells: {} offsets, must be one more than the {} types",
                            from.offsets.size(), num_cells));
  for (std::size_t c = 0; c < num_cells; ++c) {
    const std::int64_t begin = from.offsets[c], end = from.offsets[c + 1];
    if (begin < 0 || end < begin || end > static_cast<std::int64_t>(from.connectivity.size()))
      refuse_mesh(fmt::format("cell {}: nodes {} to {}, must rise within {}", c, begin, end,
                              from.connectivity.size()));
    const VtkCell type = vtk_cell(from.types[c]);
    const bool fits = type.num_nodes == 0 || end - begin == type.num_nodes;
    cells.types.push_back(fits ? type.number : VtkCell{}.number);
    cells.offsets.push_back(end - (num_cells > 0 ? from.offsets[0] : 0));
    for (std::int64_t n = begin; n < end; ++n) {
      const std::uint32_t node = from.connectivity[static_cast<std::size_t>(n)];
      if (node >= num_nodes)
        refuse_mesh(fmt::format("cell {}: node {}, must be under {}", c, node, num_nodes));
      cells.connectivity.push_back(node);
    }
  }
  return cells;
}

VtkCells vtk_cells(const Dataset& dataset) {
  const Cells& cells = dataset.cells;
  const std::int64_t num_nodes = dataset.num_positions();
  if (!cells.is_structured()) return explicit_cells(cells, num_nodes);
  if (num_samples(cells.dims) != num_nodes)
    refuse_mesh(fmt::format("cells: {} x {} x {} nodes, the mesh has {}", cells.dims[0],
                            cells.dims[1], cells.dims[2], num_nodes));
  return hexahedra(cells.dims);
}

void check_tuples(const DataArray& array, std::int64_t expected, const char* noun) {
  const std::string where =
      array.name.empty() ? "positions" : fmt::format("array '{}'", array.name);
  const std::int64_t size[] = {expected};
  const std::int64_t num_bytes =
      expected == 0 ? 0 : checked_num_bytes(where, size, array.type, array.num_components);
  if (array.num_tuples == expected && array.num_components >= 1 &&
      static_cast<std::int64_t>(array.bytes.view.size()) == num_bytes) {
    return;
  }
  refuse_mesh(fmt::format("{}: has {} tuples in {} bytes, must have {} in {} bytes, one per {}",
                          where, array.num_tuples, array.bytes.view.size(), expected, num_bytes,
                          noun));
}

void add_arrays(XmlArrayFile& file, const Dataset& dataset, bool is_cell_data, std::int64_t count) {
  const char* const section = is_cell_data ? "CellData" : "PointData";
  file.text(fmt::format("      <{}>\n", section));
  for (const DataArray& array : dataset.arrays) {
    if (array.is_cell_data != is_cell_data) continue;
    check_tuples(array, count, is_cell_data ? "cell" : "node");
    file.array(array);
  }
  file.text(fmt::format("      </{}>\n", section));
}

}  // namespace

void write_vtu(const Dataset& dataset, const std::string& path, const std::stop_token& stop) {
  const std::int64_t num_nodes = dataset.num_positions();
  if (num_nodes < 1) refuse_mesh("positions: there are none to write");
  if (dataset.positions.num_components != 3 || !is_floating(dataset.positions.type))
    refuse_mesh("positions: must be three floats each");
  check_tuples(dataset.positions, num_nodes, "node");
  const VtkCells cells = vtk_cells(dataset);
  const auto num_cells = static_cast<std::int64_t>(cells.types.size());

  XmlArrayFile file("UnstructuredGrid", XmlArrayFile::Packing::kPlain);
  file.text(
      fmt::format("  <UnstructuredGrid>\n    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
                  num_nodes, num_cells));
  add_arrays(file, dataset, false, num_nodes);
  add_arrays(file, dataset, true, num_cells);
  file.text("      <Points>\n");
  file.array("Points", dataset.positions.type, 3, dataset.positions.bytes.view);
  file.text("      </Points>\n      <Cells>\n");
  file.array("connectivity", ScalarType::kInt64, 1, std::as_bytes(std::span(cells.connectivity)));
  file.array("offsets", ScalarType::kInt64, 1, std::as_bytes(std::span(cells.offsets)));
  file.array("types", ScalarType::kUInt8, 1, std::as_bytes(std::span(cells.types)));
  file.text("      </Cells>\n    </Piece>\n  </UnstructuredGrid>\n");
  file.write(path, stop);
}

}  // namespace ovoid::io
