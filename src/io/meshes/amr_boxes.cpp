// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/amr_boxes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include "io/core/samples.h"
#include "io/meshes/mesh_parts.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

void check_grid(const AmrGrid& grid) {
  const auto num_cells = checked_product(grid.num_cells);
  const bool has_size = grid.spacing.minCoeff() > 0 && grid.spacing.allFinite() &&
                        grid.origin.allFinite() && num_cells && *num_cells > 0;
  if (!has_size) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: a grid of {} cells with edges {:g}, {:g}, {:g}: expected at least "
                            "one, with edges > 0",
                            grid.source, dims_text(grid.num_cells), grid.spacing[0],
                            grid.spacing[1], grid.spacing[2]));
  }
  for (const DataArray& array : grid.arrays) {
    const auto num_bytes = static_cast<std::uint64_t>(array.num_tuples) *
                           static_cast<std::uint64_t>(array.num_components) * size_of(array.type);
    if (array.num_tuples == *num_cells && array.bytes.view.size() == num_bytes) continue;
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: array '{}': {} tuples for {} cells", grid.source, array.name,
                            array.num_tuples, *num_cells));
  }
}

// The cells of `grid` along `axis` whose centres lie in `finer`: first and behind the last.
std::array<std::int64_t, 2> covered(const AmrGrid& grid, const AmrGrid& finer, int axis) {
  const auto a = static_cast<std::size_t>(axis);
  const double lo = (finer.origin[axis] - grid.origin[axis]) / grid.spacing[axis];
  const double size = finer.spacing[axis] * static_cast<double>(finer.num_cells[a]);
  const double hi = lo + size / grid.spacing[axis];
  const auto bounded = [&](double index) {
    return static_cast<std::int64_t>(
        std::clamp(std::ceil(index - 0.5), 0.0, static_cast<double>(grid.num_cells[a])));
  };
  return {bounded(lo), bounded(hi)};
}

// Which cells of a grid stand for themselves.
std::vector<bool> visible_cells(const AmrGrid& grid, const std::vector<AmrGrid>& grids) {
  const auto [nx, ny, nz] = grid.num_cells;
  std::vector<bool> is_visible(static_cast<std::size_t>(nx * ny * nz), true);
  for (const AmrGrid& finer : grids) {
    if (finer.level <= grid.level) continue;
    const auto x = covered(grid, finer, 0), y = covered(grid, finer, 1),
               z = covered(grid, finer, 2);
    for (std::int64_t k = z[0]; k < z[1]; ++k) {
      for (std::int64_t j = y[0]; j < y[1]; ++j) {
        for (std::int64_t i = x[0]; i < x[1]; ++i)
          is_visible[static_cast<std::size_t>(i + nx * (j + ny * k))] = false;
      }
    }
  }
  for (const DataArray& array : grid.arrays) {
    if (array.name != kGhostArray || array.type != ScalarType::kUInt8) continue;
    for (std::size_t c = 0; c < is_visible.size(); ++c) {
      if ((std::to_integer<unsigned>(array.bytes.view[c]) & kUnseenCell) != 0)
        is_visible[c] = false;
    }
  }
  return is_visible;
}

const DataArray* find_like(const AmrGrid& grid, const DataArray& like) {
  for (const DataArray& array : grid.arrays) {
    if (array.name == like.name && array.type == like.type &&
        array.num_components == like.num_components)
      return &array;
  }
  return nullptr;
}

DataArray vectors(std::string name, std::vector<double> values) {
  DataArray array;
  array.name = std::move(name);
  array.type = ScalarType::kFloat64;
  array.num_components = 3;
  array.num_tuples = static_cast<std::int64_t>(values.size() / 3);
  array.bytes = bytes_owning(std::move(values));
  return array;
}

void add_places(Dataset& dataset, const std::vector<AmrGrid>& grids,
                const std::vector<std::vector<bool>>& visible) {
  std::vector<double> centers, sizes;
  for (std::size_t g = 0; g < grids.size(); ++g) {
    const AmrGrid& grid = grids[g];
    for (std::size_t c = 0; c < visible[g].size(); ++c) {
      if (!visible[g][c]) continue;
      auto rest = static_cast<std::int64_t>(c);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto index = static_cast<double>(rest % grid.num_cells[axis]);
        rest /= grid.num_cells[axis];
        const auto a = static_cast<Eigen::Index>(axis);
        centers.push_back(grid.origin[a] + (index + 0.5) * grid.spacing[a]);
        sizes.push_back(grid.spacing[a]);
      }
    }
  }
  dataset.positions = vectors("positions", std::move(centers));
  dataset.box_sizes = vectors("box_sizes", std::move(sizes));
}

// One array of the visible cells of all grids.
DataArray gathered(const DataArray& like, const std::vector<AmrGrid>& grids,
                   const std::vector<std::vector<bool>>& visible, std::int64_t num_visible) {
  const std::size_t size = size_of(like.type) * static_cast<std::size_t>(like.num_components);
  const std::int64_t num_bytes = num_visible * static_cast<std::int64_t>(size);
  SampleBuffer buffer;
  std::byte* out = buffer.extend(num_bytes, num_bytes).data();
  for (std::size_t g = 0; g < grids.size(); ++g) {
    const std::byte* const from = find_like(grids[g], like)->bytes.view.data();
    for (std::size_t c = 0; c < visible[g].size(); ++c) {
      if (!visible[g][c]) continue;
      std::memcpy(out, from + c * size, size);
      out += size;
    }
  }
  DataArray result = like;
  result.num_tuples = num_visible;
  result.is_cell_data = false;  // a tuple per position
  result.bytes = buffer.release();
  return result;
}

}  // namespace

Dataset boxes_of_grids(Dataset dataset, const std::vector<AmrGrid>& grids,
                       const ReadOptions& options) {
  if (grids.empty())
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has no grids", dataset.source));
  std::vector<std::vector<bool>> visible;
  std::int64_t num_visible = 0, num_cells = 0;
  int num_levels = 1;
  for (const AmrGrid& grid : grids) {
    check_grid(grid);
    num_levels = std::max(num_levels, grid.level + 1);
    num_cells += *checked_product(grid.num_cells);
  }
  if (num_cells > std::numeric_limits<std::uint32_t>::max()) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: {} cells: at most 2^32 - 1 are read", dataset.source, num_cells));
  }
  for (const AmrGrid& grid : grids) {
    visible.push_back(visible_cells(grid, grids));
    num_visible += std::count(visible.back().begin(), visible.back().end(), true);
  }
  if (num_visible == 0)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: all cells are hidden", dataset.source));
  dataset.kind = DatasetKind::kBoxes;
  dataset.notes.push_back(
      fmt::format("{}: {} grids on {} levels: {} of {} cells are covered by finer ones or hidden",
                  dataset.source, grids.size(), num_levels, num_cells - num_visible, num_cells));
  add_places(dataset, grids, visible);
  for (const DataArray& array : grids.front().arrays) {
    if (is_ghost_array(array)) continue;
    const bool is_in_all = std::all_of(grids.begin(), grids.end(), [&](const AmrGrid& grid) {
      return find_like(grid, array) != nullptr;
    });
    if (is_in_all)
      dataset.arrays.push_back(gathered(array, grids, visible, num_visible));
    else
      dataset.notes.push_back(
          fmt::format("{}: array '{}' is left out: not every grid has it with the same type",
                      dataset.source, array.name));
  }
  if (dataset.arrays.empty()) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: has no array of numbers that all grids have", dataset.source));
  }
  if (!options.array.empty()) dataset.array(options.array);  // throws if it is not there
  shorten_notes(dataset.notes);
  return dataset;
}

}  // namespace ovoid::io
