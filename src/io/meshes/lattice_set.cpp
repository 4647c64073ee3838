// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/lattice_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <type_traits>
#include <utility>

#include "data/scalar_visit.h"
#include "io/core/memory.h"
#include "io/core/point_arrays.h"
#include "io/core/samples.h"
#include "io/meshes/mesh_blocks.h"
#include "io/vtk/lattice_pieces.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// How far, in spacings, a sample may lie from where the lattice of another part has one.
constexpr double kSameLatticePlace = 1e-3;

Index3 num_cells_of(const Index3& dims) {
  Index3 cells = dims;
  for (std::int64_t& size : cells) size = std::max<std::int64_t>(1, size - 1);
  return cells;
}

bool has_arrays(const std::vector<LatticePart>& parts, bool is_cell_data) {
  return std::any_of(parts.begin(), parts.end(), [&](const LatticePart& part) {
    return std::any_of(part.arrays.begin(), part.arrays.end(), [&](const DataArray& array) {
      return array.is_cell_data == is_cell_data && array.name != kGhostArray;
    });
  });
}

// Where the first sample of `part` is in the lattice of `whole`; nothing if no sample is there.
std::optional<Index3> place_in(const LatticeGeometry& whole, const LatticeGeometry& part) {
  const Mat3 axes = whole.world_from_index.linear();
  for (int axis = 0; axis < 3; ++axis) {
    const double length = axes.col(axis).norm();
    const auto last = static_cast<double>(part.dims[static_cast<std::size_t>(axis)] - 1);
    const Vec3 step = part.world_from_index.linear().col(axis) - axes.col(axis);
    if (!(step.norm() * std::max(1.0, last) <= kSameLatticePlace * length)) return std::nullopt;
  }
  const Vec3 index =
      axes.inverse() * (part.world_from_index.translation() - whole.world_from_index.translation());
  Index3 place{};
  for (int axis = 0; axis < 3; ++axis) {
    const double nearest = std::round(index[axis]);
    if (!(std::abs(index[axis] - nearest) <= kSameLatticePlace) ||
        std::abs(nearest) > static_cast<double>(kMaxAxisSize))
      return std::nullopt;
    place[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(nearest);
  }
  return place;
}

// The parts within one lattice; nothing if they lie in none.
std::optional<LatticeInPieces> common_lattice(const std::string& source,
                                              const std::vector<LatticePart>& parts) {
  LatticeInPieces layout;
  for (const LatticePart& part : parts) {
    const auto place = place_in(parts.front().lattice, part.lattice);
    if (!place) return std::nullopt;
    LatticePiece piece{fmt::format("{}: '{}'", source, part.block), {}};
    for (std::size_t a = 0; a < 3; ++a) {
      piece.extent.lo[a] = (*place)[a];
      piece.extent.hi[a] = (*place)[a] + part.lattice.dims[a] - 1;
    }
    layout.pieces.push_back(std::move(piece));
  }
  layout.whole = layout.pieces.front().extent;
  for (const LatticePiece& piece : layout.pieces) {
    for (std::size_t a = 0; a < 3; ++a) {
      layout.whole.lo[a] = std::min(layout.whole.lo[a], piece.extent.lo[a]);
      layout.whole.hi[a] = std::max(layout.whole.hi[a], piece.extent.hi[a]);
    }
  }
  return layout;
}

// Is each sample, or cell, of the whole in a piece? Where the whole has one sample along an axis it
// has a cell, a piece of one sample elsewhere has none.
bool is_filled(const LatticeInPieces& layout, bool by_cells) {
  const auto sizes_of = [&](const VtkExtent& extent) {
    Index3 sizes = extent.dims();
    for (std::size_t a = 0; by_cells && a < 3; ++a)
      if (layout.whole.lo[a] < layout.whole.hi[a]) --sizes[a];
    return sizes;
  };
  const Index3 all = sizes_of(layout.whole);
  // What the pieces hold was read: the flags are no more than that.
  const auto total = checked_product(all);
  std::int64_t sum = 0;
  for (const LatticePiece& piece : layout.pieces) {
    const std::int64_t count = num_samples(sizes_of(piece.extent));
    if (count == 0) return false;  // its flat cells are in no lattice of cells
    sum += count;
  }
  if (!total || sum < *total) return false;
  std::vector<bool> is_there(static_cast<std::size_t>(*total));
  for (const LatticePiece& piece : layout.pieces) {
    const Index3 own = sizes_of(piece.extent);
    for (std::int64_t z = 0; z < own[2]; ++z) {
      for (std::int64_t y = 0; y < own[1]; ++y) {
        const std::int64_t first = ((z + piece.extent.lo[2] - layout.whole.lo[2]) * all[1] + y +
                                    piece.extent.lo[1] - layout.whole.lo[1]) *
                                       all[0] +
                                   piece.extent.lo[0] - layout.whole.lo[0];
        std::fill_n(is_there.begin() + first, own[0], true);
      }
    }
  }
  return std::find(is_there.begin(), is_there.end(), false) == is_there.end();
}

Dataset one_lattice(Dataset dataset, LatticeInPieces layout, std::vector<LatticePart> parts) {
  LatticeAssembly assembly(dataset.source, std::move(layout));
  for (std::size_t i = 0; i < parts.size(); ++i) {
    Dataset piece;
    piece.kind = DatasetKind::kLattice;
    piece.lattice = parts[i].lattice;
    piece.arrays = std::move(parts[i].arrays);
    if (assembly.add(i, piece)) continue;
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: lies in no lattice with those before", assembly.pieces()[i].path));
  }
  if (parts.size() > 1)
    dataset.notes.push_back(
        fmt::format("{}: {} lattices are put together to one", dataset.source, parts.size()));
  return assembly.finish(std::move(dataset));
}

// --- boxes
// ---------------------------------------------------------------------------------------

bool runs_along_axes(const LatticeGeometry& lattice) {
  const Mat3 axes = lattice.world_from_index.linear();
  return axes.isDiagonal(1e-9) && axes.diagonal().minCoeff() > 0;
}

double cell_volume(const LatticePart& part) {
  return std::abs(part.lattice.world_from_index.linear().determinant());
}

bool have_one_size(const LatticePart& a, const LatticePart& b) {
  const double first = cell_volume(a), second = cell_volume(b);
  return std::abs(first - second) <= kSameLatticePlace * std::max(first, second);
}

// Levels by the sizes of cells, of which the largest is 0.
std::vector<int> levels_of(const std::vector<LatticePart>& parts) {
  std::vector<std::size_t> order(parts.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return cell_volume(parts[a]) > cell_volume(parts[b]);
  });
  std::vector<int> levels(parts.size());
  int level = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i > 0 && !have_one_size(parts[order[i - 1]], parts[order[i]])) ++level;
    levels[order[i]] = level;
  }
  return levels;
}

// Do two of different sizes share more than a face?
bool do_levels_overlap(const std::vector<LatticePart>& parts) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const LatticeGeometry& a = parts[i].lattice;
    const Vec3 a_end = a.index_position({a.dims[0] - 1, a.dims[1] - 1, a.dims[2] - 1});
    for (std::size_t j = 0; j < i; ++j) {
      if (have_one_size(parts[i], parts[j])) continue;
      const LatticeGeometry& b = parts[j].lattice;
      const Vec3 b_end = b.index_position({b.dims[0] - 1, b.dims[1] - 1, b.dims[2] - 1});
      const Vec3 lo = (a.world_from_index.translation()).cwiseMax(b.world_from_index.translation());
      const Vec3 hi = (a.world_from_index * a_end).cwiseMin(b.world_from_index * b_end);
      const Vec3 least = kSameLatticePlace * a.world_from_index.linear().diagonal();
      bool is_apart = false;
      for (int axis = 0; axis < 3; ++axis) {
        const bool is_flat = a.dims[static_cast<std::size_t>(axis)] == 1;
        is_apart = is_apart || hi[axis] - lo[axis] < (is_flat ? -least[axis] : least[axis]);
      }
      if (!is_apart) return true;
    }
  }
  return false;
}

template <class T>
void fill_means(const DataArray& array, const Index3& dims, std::byte* to, ScalarType type) {
  const Index3 cells = num_cells_of(dims);
  const std::int64_t components = array.num_components;
  std::int64_t out = 0;
  for (std::int64_t z = 0; z < cells[2]; ++z)
    for (std::int64_t y = 0; y < cells[1]; ++y)
      for (std::int64_t x = 0; x < cells[0]; ++x)
        for (std::int64_t c = 0; c < components; ++c, ++out) {
          double sum = 0;
          for (unsigned corner = 0; corner < 8; ++corner) {
            const std::int64_t i = std::min<std::int64_t>(x + (corner & 1U), dims[0] - 1),
                               j = std::min<std::int64_t>(y + (corner >> 1U & 1U), dims[1] - 1),
                               k = std::min<std::int64_t>(z + (corner >> 2U), dims[2] - 1);
            sum += static_cast<double>(data::load_scalar<T>(
                array.bytes.view.data(), ((k * dims[1] + j) * dims[0] + i) * components + c));
          }
          const double mean = sum / 8;
          if (type == ScalarType::kFloat32) {
            const auto value = static_cast<float>(mean);
            std::memcpy(to + static_cast<std::size_t>(out) * sizeof(value), &value, sizeof(value));
          } else {
            std::memcpy(to + static_cast<std::size_t>(out) * sizeof(mean), &mean, sizeof(mean));
          }
        }
}

// Of an array of samples: the mean of each cell's corners.
DataArray means_of_corners(const DataArray& array, const Index3& dims) {
  DataArray means = array;
  means.type = array.type == ScalarType::kFloat32 ? ScalarType::kFloat32 : ScalarType::kFloat64;
  means.is_cell_data = true;
  means.num_tuples = num_samples(num_cells_of(dims));
  means.bytes = {};
  std::byte* to = nullptr;
  means = new_array(std::move(means), to);
  data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    fill_means<T>(array, dims, to, means.type);
  });
  return means;
}

// Hides cells that lie in an earlier grid of the same level: layers that processes share.
void hide_doubled(std::vector<AmrGrid>& grids) {
  for (std::size_t g = 0; g < grids.size(); ++g) {
    AmrGrid& grid = grids[g];
    std::vector<std::uint8_t> flags;
    for (std::size_t other = 0; other < g; ++other) {
      if (grids[other].level != grid.level) continue;
      std::array<std::int64_t, 3> first{}, end{};
      bool is_apart = false;
      for (std::size_t a = 0; a < 3; ++a) {
        const auto axis = static_cast<Eigen::Index>(a);
        const double lo = (grids[other].origin[axis] - grid.origin[axis]) / grid.spacing[axis];
        const auto size = static_cast<double>(grids[other].num_cells[a]);
        const auto bounded = [&](double index) {
          return static_cast<std::int64_t>(
              std::clamp(std::ceil(index - 0.5), 0.0, static_cast<double>(grid.num_cells[a])));
        };
        first[a] = bounded(lo);
        end[a] = bounded(lo + size);
        is_apart = is_apart || first[a] >= end[a];
      }
      if (is_apart) continue;
      flags.resize(static_cast<std::size_t>(num_samples(grid.num_cells)));
      for (std::int64_t z = first[2]; z < end[2]; ++z)
        for (std::int64_t y = first[1]; y < end[1]; ++y)
          std::fill_n(flags.begin() + (z * grid.num_cells[1] + y) * grid.num_cells[0] + first[0],
                      end[0] - first[0], std::uint8_t{1});
    }
    if (flags.empty()) continue;
    for (const DataArray& array : grid.arrays) {
      if (array.name != kGhostArray || array.type != ScalarType::kUInt8) continue;
      for (std::size_t c = 0; c < flags.size(); ++c)
        flags[c] |= std::to_integer<std::uint8_t>(array.bytes.view[c]);
    }
    std::erase_if(grid.arrays, [](const DataArray& array) { return array.name == kGhostArray; });
    const auto count = static_cast<std::int64_t>(flags.size());
    grid.arrays.push_back(
        {kGhostArray, ScalarType::kUInt8, 1, count, "", true, bytes_owning(std::move(flags))});
  }
}

Dataset boxes_of_lattices(Dataset dataset, const std::vector<LatticePart>& parts,
                          const ReadOptions& options) {
  const std::vector<int> levels = levels_of(parts);
  std::vector<AmrGrid> grids;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!runs_along_axes(parts[i].lattice)) {
      throw Error(
          ErrorCode::kUnsupported,
          fmt::format("{}: '{}' is one of {} lattices of different spacing or with gaps, and "
                      "does not run along the world's axes: expected positive spacings",
                      dataset.source, parts[i].block, parts.size()));
    }
    grids.push_back(amr_grid_of_lattice(fmt::format("{}: '{}'", dataset.source, parts[i].block),
                                        levels[i], parts[i]));
  }
  hide_doubled(grids);
  if (has_arrays(parts, false)) {
    dataset.notes.push_back(fmt::format(
        "{}: values of nodes are drawn as boxes, by the mean of each cell's corners: the {} "
        "lattices do not lie in one",
        dataset.source, parts.size()));
  }
  return boxes_of_grids(std::move(dataset), grids, options);
}

}  // namespace

AmrGrid amr_grid_of_lattice(const std::string& source, int level, const LatticePart& part) {
  AmrGrid grid;
  grid.source = source;
  grid.level = level;
  grid.origin = part.lattice.world_from_index.translation();
  grid.spacing = part.lattice.world_from_index.linear().diagonal();
  grid.num_cells = num_cells_of(part.lattice.dims);
  for (int axis = 0; axis < 3; ++axis) {
    // A flat cell lies around its plane.
    if (part.lattice.dims[static_cast<std::size_t>(axis)] == 1)
      grid.origin[axis] -= 0.5 * grid.spacing[axis];
  }
  for (const DataArray& array : part.arrays) {
    if (array.is_cell_data)
      grid.arrays.push_back(array);
    else if (array.name != kGhostArray)
      grid.arrays.push_back(means_of_corners(array, part.lattice.dims));
  }
  return grid;
}

MeshPart mesh_part_of(LatticePart part) {
  const Index3& dims = part.lattice.dims;
  require_memory(part.block, checked_num_bytes(part.block, dims, ScalarType::kFloat64, 3));
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(3 * num_samples(dims)));
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    for (std::int64_t y = 0; y < dims[1]; ++y) {
      for (std::int64_t x = 0; x < dims[0]; ++x) {
        const Vec3 index(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
        const Vec3 place = part.lattice.world_from_index * index;
        values.insert(values.end(), place.begin(), place.end());
      }
    }
  }
  MeshPart mesh;
  mesh.block = std::move(part.block);
  mesh.positions = {"positions", ScalarType::kFloat64,           3, num_samples(dims), "",
                    false,       bytes_owning(std::move(values))};
  mesh.cells.dims = dims;
  mesh.arrays = std::move(part.arrays);
  return mesh;
}

Dataset dataset_of_lattices(Dataset dataset, std::vector<LatticePart> parts,
                            const ReadOptions& options) {
  if (parts.empty())
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has no grids", dataset.source));
  Dataset whole = dataset;
  std::vector<PartOutline> outlines;
  for (const LatticePart& part : parts) {
    outlines.push_back({part.block, num_samples(part.lattice.dims),
                        num_samples(num_cells_of(part.lattice.dims)), part.arrays});
    for (DataArray& array : outlines.back().arrays) array.bytes = {};
  }
  std::vector<LatticePart> chosen;
  for (const std::size_t p : choose_blocks(whole, outlines, options)) chosen.push_back(parts[p]);
  auto layout = common_lattice(dataset.source, chosen);
  const bool has_cells = has_arrays(chosen, true), has_nodes = has_arrays(chosen, false);
  if (layout && (!has_nodes || is_filled(*layout, false)) &&
      (!has_cells || is_filled(*layout, true))) {
    whole = one_lattice(std::move(whole), std::move(*layout), std::move(chosen));
    if (!options.array.empty()) static_cast<void>(whole.array(options.array));
    return whole;
  }
  if (has_cells || do_levels_overlap(chosen))
    return boxes_of_lattices(std::move(whole), chosen, options);
  const LatticeGeometry first = parts.front().lattice;
  std::vector<MeshPart> meshes;
  for (LatticePart& part : parts) {
    // Nodes that two parts share have to come out at the same place to the last bit.
    if (const auto place = place_in(first, part.lattice)) {
      part.lattice.world_from_index = first.world_from_index;
      part.lattice.world_from_index.translate(Vec3(static_cast<double>((*place)[0]),
                                                   static_cast<double>((*place)[1]),
                                                   static_cast<double>((*place)[2])));
    }
    meshes.push_back(mesh_part_of(std::move(part)));
  }
  return mesh_of_parts(std::move(dataset), std::move(meshes), options);
}

}  // namespace ovoid::io
