// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/image_ghosts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "data/scalar_visit.h"
#include "io/core/memory.h"
#include "io/core/samples.h"
#include "io/meshes/mesh_parts.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Which points or cells, x fastest; empty: none.
using Mask = std::vector<bool>;

// An axis of one sample has one cell.
Index3 cells_of(const Index3& dims) {
  Index3 cells = dims;
  for (std::int64_t& count : cells) count = std::max<std::int64_t>(count - 1, 1);
  return cells;
}

Mask flagged(const Dataset& dataset, bool are_cells, std::int64_t count, unsigned bits) {
  for (const DataArray& array : dataset.arrays) {
    const bool is_ghosts = array.name == kGhostArray && array.is_cell_data == are_cells &&
                           array.num_components == 1 && size_of(array.type) == 1 &&
                           array.num_tuples == count;
    if (!is_ghosts) continue;
    Mask mask(static_cast<std::size_t>(count));
    bool has_any = false;
    for (std::size_t i = 0; i < mask.size(); ++i) {
      mask[i] = (std::to_integer<unsigned>(array.bytes.view[i]) & bits) != 0;
      has_any = has_any || mask[i];
    }
    return has_any ? mask : Mask();
  }
  return {};
}

// Calls with (cell, point) for every corner of every cell.
template <typename Visit>
void for_each_corner(const Index3& dims, const Visit& visit) {
  const Index3 cells = cells_of(dims);
  std::size_t cell = 0;
  for (std::int64_t z = 0; z < cells[2]; ++z) {
    for (std::int64_t y = 0; y < cells[1]; ++y) {
      for (std::int64_t x = 0; x < cells[0]; ++x, ++cell) {
        for (unsigned corner = 0; corner < 8; ++corner) {
          const std::int64_t i = std::min(x + (corner & 1U), dims[0] - 1);
          const std::int64_t j = std::min(y + (corner >> 1U & 1U), dims[1] - 1);
          const std::int64_t k = std::min(z + (corner >> 2U), dims[2] - 1);
          visit(cell, static_cast<std::size_t>((k * dims[1] + j) * dims[0] + i));
        }
      }
    }
  }
}

// A cell with a hidden point is not seen, nor is a point that no seen cell has.
void spread(const Index3& dims, Mask& points, Mask& cells) {
  if (points.empty() && cells.empty()) return;
  const bool are_cells_hidden = !cells.empty();
  cells.resize(static_cast<std::size_t>(*checked_product(cells_of(dims))));
  if (!points.empty()) {
    for_each_corner(dims, [&](std::size_t cell, std::size_t point) {
      if (points[point]) cells[cell] = true;
    });
  }
  if (!are_cells_hidden) return;
  Mask is_seen(static_cast<std::size_t>(*checked_product(dims)));
  for_each_corner(dims, [&](std::size_t cell, std::size_t point) {
    if (!cells[cell]) is_seen[point] = true;
  });
  if (points.empty()) points.resize(is_seen.size());
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = points[i] || !is_seen[i];
}

template <typename T, typename Value>
Bytes with_missing(const DataArray& array, const Mask& hidden) {
  SampleBuffer buffer;
  const auto width = static_cast<std::size_t>(array.num_components);
  const auto size = static_cast<std::int64_t>(hidden.size() * width * sizeof(Value));
  std::byte* const to = buffer.extend(size, size).data();
  for (std::size_t i = 0; i < hidden.size() * width; ++i) {
    T sample;
    std::memcpy(&sample, array.bytes.view.data() + i * sizeof(T), sizeof(T));
    const Value value =
        hidden[i / width] ? std::numeric_limits<Value>::quiet_NaN() : static_cast<Value>(sample);
    std::memcpy(to + i * sizeof(Value), &value, sizeof(Value));
  }
  return buffer.release();
}

void hide(Dataset& dataset, DataArray& array, const Mask& hidden) {
  if (hidden.size() != static_cast<std::size_t>(array.num_tuples)) return;
  const std::string where = fmt::format("{}: array '{}'", dataset.source, array.name);
  data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    constexpr bool is_wide = sizeof(T) >= 4 && !std::is_same_v<T, float>;
    using Value = std::conditional_t<is_wide, double, float>;
    constexpr ScalarType kType = is_wide ? ScalarType::kFloat64 : ScalarType::kFloat32;
    require_memory(
        where, array.num_tuples * array.num_components * static_cast<std::int64_t>(sizeof(Value)));
    array.bytes = with_missing<T, Value>(array, hidden);
    if (array.type == kType) return;
    dataset.notes.push_back(fmt::format("{}: {} becomes {}, which has missing values", where,
                                        name_of(array.type), name_of(kType)));
    array.type = kType;
  });
}

std::int64_t count_of(const Mask& mask) { return std::count(mask.begin(), mask.end(), true); }

}  // namespace

void hide_ghosts(Dataset& dataset) {
  const Index3 dims = dataset.lattice.dims;
  const std::int64_t num_points = checked_product(dims).value_or(0);
  const std::int64_t num_cells = checked_product(cells_of(dims)).value_or(0);
  Mask points = flagged(dataset, false, num_points, kHiddenPoint);
  Mask cells = flagged(dataset, true, num_cells, kRefinedCell | kHiddenCell);
  std::erase_if(dataset.arrays, [](const DataArray& array) { return is_ghost_array(array); });
  if (dataset.arrays.empty()) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: has no array of numbers but its ghosts", dataset.source));
  }
  spread(dims, points, cells);
  if (points.empty() && cells.empty()) return;
  dataset.notes.push_back(
      fmt::format("{}: {} samples and {} cells are hidden ({}): they are missing", dataset.source,
                  count_of(points), count_of(cells), kGhostArray));
  for (DataArray& array : dataset.arrays) hide(dataset, array, array.is_cell_data ? cells : points);
}

}  // namespace ovoid::io
