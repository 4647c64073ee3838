// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/mesh_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <span>

#include "data/cell_builder.h"
#include "io/core/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

[[noreturn]] void fail_mesh(const std::string& where, const std::string& what,
                            ErrorCode code = ErrorCode::kFileFormat) {
  throw Error(code, fmt::format("{}: {}", where, what));
}

void check_explicit_cells(const std::string& where, const MeshPart& part) {
  const Cells& cells = part.cells;
  if (cells.types.empty() && cells.offsets.empty() && cells.connectivity.empty()) return;
  if (cells.offsets.size() != cells.types.size() + 1 || cells.offsets.front() != 0) {
    fail_mesh(where, fmt::format("cells: {} offsets for {} types: expected one more, from 0",
                                 cells.offsets.size(), cells.types.size()));
  }
  const auto num_entries = static_cast<std::int64_t>(cells.connectivity.size());
  for (std::size_t c = 0; c < cells.types.size(); ++c) {
    const std::int64_t begin = cells.offsets[c], end = cells.offsets[c + 1];
    if (end < begin || end > num_entries) {
      fail_mesh(where, fmt::format("cells: offsets[{}] = {}: expected {} to {}", c + 1, end, begin,
                                   num_entries));
    }
    const int needed = num_corners(cells.types[c]);
    if (needed != 0 && end - begin < needed) {
      fail_mesh(where, fmt::format("cells: cell {} has {} nodes: its type needs {}", c, end - begin,
                                   needed));
    }
  }
  if (cells.offsets.back() != num_entries) {
    fail_mesh(where, fmt::format("cells: the last ends at {} of {} node numbers",
                                 cells.offsets.back(), num_entries));
  }
  for (std::size_t i = 0; i < cells.connectivity.size(); ++i) {
    if (cells.connectivity[i] < part.num_nodes()) continue;
    fail_mesh(where, fmt::format("cells: connectivity[{}] = {}: the mesh has {} nodes", i,
                                 cells.connectivity[i], part.num_nodes()));
  }
}

template <typename T>
void check_finite_as(const std::string& where, const DataArray& positions) {
  const std::byte* const bytes = positions.bytes.view.data();
  for (std::size_t i = 0; i < static_cast<std::size_t>(positions.num_tuples) * 3; ++i) {
    T value = 0;
    std::memcpy(&value, bytes + i * sizeof(T), sizeof(T));
    if (std::isfinite(value)) continue;
    fail_mesh(where, fmt::format("points: point {} has {} = {}: expected a finite number", i / 3,
                                 "xyz"[i % 3], value));
  }
}

void check_finite(const std::string& where, const DataArray& positions) {
  if (positions.bytes.view.size() !=
      static_cast<std::uint64_t>(positions.num_tuples) * 3 * size_of(positions.type))
    fail_mesh(where, fmt::format("points: {} bytes for {} points", positions.bytes.view.size(),
                                 positions.num_tuples));
  if (positions.type == ScalarType::kFloat32) return check_finite_as<float>(where, positions);
  check_finite_as<double>(where, positions);
}

std::span<const std::uint8_t> ghost_flags(const MeshPart& part, const char* name,
                                          bool is_cell_data) {
  for (const DataArray& array : part.arrays) {
    if (array.name != name || array.is_cell_data != is_cell_data) continue;
    if (array.type != ScalarType::kUInt8 || array.num_components != 1) continue;
    return {reinterpret_cast<const std::uint8_t*>(array.bytes.view.data()),
            array.bytes.view.size()};
  }
  return {};
}

// The tuples of `array` that are kept.
DataArray kept_tuples(const DataArray& array, const std::vector<bool>& is_kept,
                      std::int64_t num_kept) {
  const std::size_t size = size_of(array.type) * static_cast<std::size_t>(array.num_components);
  SampleBuffer buffer;
  const std::int64_t num_bytes = num_kept * static_cast<std::int64_t>(size);
  const std::span<std::byte> out = buffer.extend(num_bytes, num_bytes);
  std::size_t next = 0;
  for (std::size_t i = 0; i < is_kept.size(); ++i) {
    if (!is_kept[i]) continue;
    std::memcpy(out.data() + next, array.bytes.view.data() + i * size, size);
    next += size;
  }
  DataArray result = array;
  result.num_tuples = num_kept;
  result.bytes = buffer.release();
  return result;
}

void keep_tuples(MeshPart& part, bool is_cell_data, const std::vector<bool>& is_kept,
                 std::int64_t num_kept) {
  for (DataArray& array : part.arrays) {
    if (array.is_cell_data == is_cell_data) array = kept_tuples(array, is_kept, num_kept);
  }
}

void keep_cells(MeshPart& part, const std::vector<bool>& is_kept, std::int64_t num_kept) {
  make_explicit(part);
  data::CellBuilder kept;
  for (std::size_t c = 0; c < is_kept.size(); ++c) {
    if (!is_kept[c]) continue;
    const auto begin = static_cast<std::size_t>(part.cells.offsets[c]);
    const auto end = static_cast<std::size_t>(part.cells.offsets[c + 1]);
    kept.add(part.cells.types[c], part.cells.connectivity.view().subspan(begin, end - begin));
  }
  part.cells = std::move(kept).finish();
  keep_tuples(part, true, is_kept, num_kept);
}

}  // namespace

bool is_ghost_array(const DataArray& array) noexcept {
  return array.name == kGhostArray || array.name == kOldGhostArray;
}

int num_corners(CellType type) noexcept {
  switch (type) {
    case CellType::kVertex:
      return 1;
    case CellType::kLine:
      return 2;
    case CellType::kTriangle:
      return 3;
    case CellType::kQuad:
    case CellType::kTetrahedron:
      return 4;
    case CellType::kPyramid:
      return 5;
    case CellType::kWedge:
      return 6;
    case CellType::kHexahedron:
    case CellType::kVoxel:
      return 8;
    case CellType::kQuadraticTetrahedron:
      return 10;
    case CellType::kQuadraticPyramid:
      return 13;
    case CellType::kQuadraticWedge:
      return 15;
    case CellType::kQuadraticHexahedron:
      return 20;
    case CellType::kTriQuadraticHexahedron:
      return 27;
    case CellType::kPolyLine:
    case CellType::kOther:
      return 0;
  }
  return 0;
}

void check_mesh(const std::string& where, const MeshPart& part) {
  if (part.num_nodes() < 1) fail_mesh(where, "has no points");
  if (part.num_nodes() > std::numeric_limits<std::uint32_t>::max())
    fail_mesh(where, fmt::format("has {} points: at most 2^32 - 1 are read", part.num_nodes()),
              ErrorCode::kUnsupported);
  if (part.positions.num_components != 3 || !is_floating(part.positions.type))
    fail_mesh(where, "points: expected three floating-point coordinates each");
  check_finite(where, part.positions);
  if (part.cells.is_structured()) {
    const auto expected = checked_product(part.cells.dims);
    if (part.cells.dims[1] < 1 || part.cells.dims[2] < 1 || expected != part.num_nodes()) {
      fail_mesh(where, fmt::format("has {} points, dimensions {} need another number",
                                   part.num_nodes(), dims_text(part.cells.dims)));
    }
  } else {
    check_explicit_cells(where, part);
  }
  for (const DataArray& array : part.arrays) {
    const std::int64_t expected = array.is_cell_data ? part.cells.count() : part.num_nodes();
    const auto num_bytes = static_cast<std::uint64_t>(array.num_tuples) *
                           static_cast<std::uint64_t>(array.num_components) * size_of(array.type);
    if (array.num_tuples == expected && array.bytes.view.size() == num_bytes) continue;
    fail_mesh(where,
              fmt::format("array '{}': {} tuples: the mesh has {} {}", array.name, array.num_tuples,
                          expected, array.is_cell_data ? "cells" : "points"));
  }
}

bool is_point_set(const MeshPart& part) {
  return !part.cells.is_structured() &&
         std::all_of(part.cells.types.begin(), part.cells.types.end(),
                     [](CellType type) { return type == CellType::kVertex; });
}

void make_explicit(MeshPart& part) {
  if (!part.cells.is_structured()) return;
  const Index3 dims = part.cells.dims;
  // The corners of a cell as steps along i, j, k, in VTK's order for 3, 2, 1 and 0 axes.
  constexpr std::array<std::array<int, 3>, 8> kCorners{
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};
  constexpr std::array<CellType, 4> kTypes{CellType::kVertex, CellType::kLine, CellType::kQuad,
                                           CellType::kHexahedron};
  const std::array<std::int64_t, 3> strides{1, dims[0], dims[0] * dims[1]};
  std::vector<std::int64_t> axes;  // strides of the axes with more than one node
  Index3 num_cells{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    num_cells[axis] = std::max<std::int64_t>(dims[axis] - 1, 1);
    if (dims[axis] > 1) axes.push_back(strides[axis]);
  }
  std::vector<std::int64_t> corners;
  for (std::size_t i = 0; i < std::size_t{1} << axes.size(); ++i) {
    std::int64_t corner = 0;
    for (std::size_t axis = 0; axis < axes.size(); ++axis) corner += kCorners[i][axis] * axes[axis];
    corners.push_back(corner);
  }
  data::CellBuilder cells;
  for (std::int64_t k = 0; k < num_cells[2]; ++k) {
    for (std::int64_t j = 0; j < num_cells[1]; ++j) {
      for (std::int64_t i = 0; i < num_cells[0]; ++i) {
        const std::int64_t first = i + strides[1] * j + strides[2] * k;
        for (const std::int64_t corner : corners)
          cells.connectivity.push_back(static_cast<std::uint32_t>(first + corner));
        cells.end_cell(kTypes[axes.size()]);
      }
    }
  }
  part.cells = std::move(cells).finish();
}

std::int64_t drop_ghosts(MeshPart& part) {
  const std::span<const std::uint8_t> nodes = ghost_flags(part, kGhostArray, false);
  const std::span<const std::uint8_t> cells = ghost_flags(part, kGhostArray, true);
  const std::span<const std::uint8_t> levels = ghost_flags(part, kOldGhostArray, true);
  const std::int64_t num_cells = part.cells.count();
  std::int64_t num_dropped = 0;
  const bool has_empty = std::adjacent_find(part.cells.offsets.begin(), part.cells.offsets.end()) !=
                         part.cells.offsets.end();
  if (num_cells > 0 && (!cells.empty() || !nodes.empty() || !levels.empty() || has_empty)) {
    const auto is_hidden = [&](std::uint32_t node) { return (nodes[node] & kHiddenPoint) != 0; };
    const bool has_hidden =
        std::any_of(nodes.begin(), nodes.end(), [](unsigned f) { return (f & kHiddenPoint) != 0; });
    if (has_hidden) make_explicit(part);
    std::vector<bool> is_kept(static_cast<std::size_t>(num_cells), true);
    for (std::size_t c = 0; c < is_kept.size(); ++c) {
      if (!cells.empty() && (cells[c] & kUnseenCell) != 0) is_kept[c] = false;
      if (!levels.empty() && levels[c] > 0) is_kept[c] = false;
      if (has_empty && part.cells.offsets[c] == part.cells.offsets[c + 1]) is_kept[c] = false;
      if (has_hidden && is_kept[c]) {
        const auto begin = part.cells.connectivity.begin();
        is_kept[c] = !std::any_of(begin + part.cells.offsets[c], begin + part.cells.offsets[c + 1],
                                  is_hidden);
      }
      num_dropped += is_kept[c] ? 0 : 1;
    }
    if (num_dropped > 0) keep_cells(part, is_kept, num_cells - num_dropped);
  } else if (num_cells == 0 && !nodes.empty()) {
    std::vector<bool> is_kept(nodes.size());
    for (std::size_t i = 0; i < is_kept.size(); ++i) {
      is_kept[i] = (nodes[i] & (kDuplicatePoint | kHiddenPoint)) == 0;
      num_dropped += is_kept[i] ? 0 : 1;
    }
    if (num_dropped > 0) {
      const std::int64_t num_kept = part.num_nodes() - num_dropped;
      keep_tuples(part, false, is_kept, num_kept);
      part.positions = kept_tuples(part.positions, is_kept, num_kept);
    }
  }
  std::erase_if(part.arrays, is_ghost_array);
  return num_dropped;
}

}  // namespace ovoid::io
