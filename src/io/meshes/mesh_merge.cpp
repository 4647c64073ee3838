// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <span>
#include <unordered_map>
#include <utility>

#include "data/bookkeeping.h"
#include "data/cell_builder.h"
#include "data/names_text.h"
#include "io/core/samples.h"
#include "io/meshes/mesh_parts.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

using Place = std::array<double, 3>;

struct PlaceHash {
  std::size_t operator()(const Place& place) const noexcept {
    std::uint64_t hash = 0x9e3779b97f4a7c15U;
    for (const double x : place) {
      // A multiplication by an odd number and a shift mix all bits into the low ones.
      hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0xff51afd7ed558ccdU;
      hash ^= hash >> 32U;
    }
    return static_cast<std::size_t>(hash);
  }
};

// Zero has two signs and is one place.
Place place_of(const DataArray& positions, std::int64_t node) {
  Place place;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t i = static_cast<std::size_t>(node) * 3 + axis;
    if (positions.type == ScalarType::kFloat32) {
      float value = 0;
      std::memcpy(&value, positions.bytes.view.data() + i * sizeof(float), sizeof(float));
      place[axis] = static_cast<double>(value) + 0.0;
    } else {
      std::memcpy(&place[axis], positions.bytes.view.data() + i * sizeof(double), sizeof(double));
      place[axis] += 0.0;
    }
  }
  return place;
}

bool is_same_array(const DataArray& a, const DataArray& b) {
  return a.name == b.name && a.is_cell_data == b.is_cell_data && a.type == b.type &&
         a.num_components == b.num_components;
}

// Names of the blocks in the order they come.
std::vector<std::string> block_names(const std::vector<MeshPart>& parts) {
  std::vector<std::string> names;
  for (const MeshPart& part : parts) {
    if (std::find(names.begin(), names.end(), part.block) == names.end())
      names.push_back(part.block);
  }
  return names;
}

struct BlockSize {
  std::int64_t num_nodes = 0;
  std::int64_t num_cells = 0;
};

BlockSize size_of_block(const std::vector<MeshPart>& parts, const std::string& name) {
  BlockSize size;
  for (const MeshPart& part : parts) {
    if (part.block != name) continue;
    size.num_nodes += part.num_nodes();
    size.num_cells += part.cells.count();
  }
  return size;
}

void keep_block(std::vector<MeshPart>& parts, const std::string& name) {
  std::erase_if(parts, [&](const MeshPart& part) { return part.block != name; });
}

// The arrays that every part has. One without cells has no cell arrays to have.
std::vector<DataArray> shared_arrays(const std::vector<MeshPart>& parts) {
  std::vector<DataArray> shared;
  for (const MeshPart& candidate_part : parts) {
    for (const DataArray& array : candidate_part.arrays) {
      const auto has = [&](const MeshPart& part) {
        return (array.is_cell_data && part.cells.count() == 0) ||
               std::any_of(part.arrays.begin(), part.arrays.end(),
                           [&](const DataArray& a) { return is_same_array(a, array); });
      };
      const bool is_known = std::any_of(shared.begin(), shared.end(), [&](const DataArray& a) {
        return is_same_array(a, array);
      });
      if (!is_known && std::all_of(parts.begin(), parts.end(), has)) shared.push_back(array);
    }
  }
  return shared;
}

bool has_data(const std::vector<DataArray>& arrays) {
  return std::any_of(arrays.begin(), arrays.end(),
                     [](const DataArray& array) { return !data::is_bookkeeping(array); });
}

// Fills dataset.blocks and leaves the parts that are read.
void choose_blocks(Dataset& dataset, std::vector<MeshPart>& parts, const ReadOptions& options) {
  const std::vector<std::string> names = block_names(parts);
  if (names.size() < 2) return;
  for (const std::string& name : names) {
    const BlockSize size = size_of_block(parts, name);
    dataset.blocks.push_back(
        {name, fmt::format("{} points, {} cells", size.num_nodes, size.num_cells)});
  }
  if (!options.block.empty()) {
    if (std::find(names.begin(), names.end(), options.block) == names.end()) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: block '{}': not there: expected one of {}", dataset.source,
                              options.block, data::names_text(names)));
    }
    keep_block(parts, options.block);
    dataset.block = options.block;
    return;
  }
  if (has_data(shared_arrays(parts))) {
    dataset.notes.push_back(fmt::format("{}: all {} blocks are read; choose one with --block",
                                        dataset.source, names.size()));
    return;
  }
  const auto largest =
      std::max_element(names.begin(), names.end(), [&](const std::string& a, const std::string& b) {
        const BlockSize left = size_of_block(parts, a), right = size_of_block(parts, b);
        return std::pair(left.num_cells, left.num_nodes) <
               std::pair(right.num_cells, right.num_nodes);
      });
  keep_block(parts, *largest);
  dataset.block = *largest;
  dataset.notes.push_back(
      fmt::format("{}: its {} blocks share no array: the largest, '{}', is read; choose with "
                  "--block",
                  dataset.source, names.size(), *largest));
}

// Takes out the arrays that are not in all parts, which is told.
void leave_shared_arrays(Dataset& dataset, std::vector<MeshPart>& parts) {
  if (parts.size() < 2) return;
  const std::vector<DataArray> shared = shared_arrays(parts);
  std::vector<std::string> dropped;
  for (MeshPart& part : parts) {
    std::erase_if(part.arrays, [&](const DataArray& array) {
      const bool is_shared = std::any_of(shared.begin(), shared.end(), [&](const DataArray& a) {
        return is_same_array(a, array);
      });
      if (!is_shared && std::find(dropped.begin(), dropped.end(), array.name) == dropped.end())
        dropped.push_back(array.name);
      return !is_shared;
    });
  }
  for (const std::string& name : dropped) {
    dataset.notes.push_back(
        fmt::format("{}: array '{}' is left out: not every piece or block has "
                    "it with the same type",
                    dataset.source, name));
  }
}

// Appends meshes to one, node for node and cell for cell.
class Merger {
 public:
  explicit Merger(const std::vector<MeshPart>& parts) : parts_(parts) {}

  MeshPart run() {
    merge_nodes();
    if (num_nodes_ > std::numeric_limits<std::uint32_t>::max()) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("mesh: {} points in all: at most 2^32 - 1 are read", num_nodes_));
    }
    MeshPart result;
    const bool are_float32 = std::all_of(parts_.begin(), parts_.end(), [](const MeshPart& part) {
      return part.positions.type == ScalarType::kFloat32;
    });
    result.positions = are_float32 ? merged_positions<float>(ScalarType::kFloat32)
                                   : merged_positions<double>(ScalarType::kFloat64);
    result.cells = merged_cells();
    for (const DataArray& array : shared_arrays(parts_))
      result.arrays.push_back(merged_array(array));
    result.is_surface = std::all_of(parts_.begin(), parts_.end(),
                                    [](const MeshPart& part) { return part.is_surface; });
    return result;
  }

  std::int64_t num_merged() const noexcept { return num_merged_; }

 private:
  struct Owner {
    std::uint32_t node = 0;
    std::uint32_t part = 0;
  };

  // Two nodes of one part at the same place may be the two sides of a crack and stay two.
  void merge_nodes() {
    std::unordered_map<Place, Owner, PlaceHash> owners;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const std::int64_t count = parts_[p].num_nodes();
      std::vector<std::uint32_t>& numbers = numbers_.emplace_back();
      std::vector<bool>& is_new = is_new_.emplace_back();
      numbers.reserve(static_cast<std::size_t>(count));
      for (std::int64_t i = 0; i < count; ++i) {
        const auto next = static_cast<std::uint32_t>(num_nodes_);
        const Owner own{next, static_cast<std::uint32_t>(p)};
        const auto [found, is_first] = owners.try_emplace(place_of(parts_[p].positions, i), own);
        const bool is_merged = !is_first && found->second.part != p;
        numbers.push_back(is_merged ? found->second.node : next);
        is_new.push_back(!is_merged);
        num_nodes_ += is_merged ? 0 : 1;
        num_merged_ += is_merged ? 1 : 0;
      }
    }
  }

  template <typename T>
  DataArray merged_positions(ScalarType type) const {
    std::vector<T> values;
    values.reserve(static_cast<std::size_t>(num_nodes_) * 3);
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      for (std::int64_t i = 0; i < parts_[p].num_nodes(); ++i) {
        if (!is_new_[p][static_cast<std::size_t>(i)]) continue;
        for (const double x : place_of(parts_[p].positions, i)) values.push_back(static_cast<T>(x));
      }
    }
    DataArray result = parts_.front().positions;
    result.type = type;
    result.num_tuples = num_nodes_;
    result.bytes = bytes_owning(std::move(values));
    return result;
  }

  Cells merged_cells() const {
    data::CellBuilder result;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const Cells& cells = parts_[p].cells;
      const auto begin = static_cast<std::int64_t>(result.connectivity.size());
      for (const std::uint32_t node : cells.connectivity)
        result.connectivity.push_back(numbers_[p][node]);
      result.types.insert(result.types.end(), cells.types.begin(), cells.types.end());
      for (std::size_t c = 1; c < cells.offsets.size(); ++c)
        result.offsets.push_back(begin + cells.offsets[c]);
    }
    if (result.types.empty()) return {};
    return std::move(result).finish();
  }

  DataArray merged_array(const DataArray& like) const {
    const std::size_t size = size_of(like.type) * static_cast<std::size_t>(like.num_components);
    DataArray result = like;
    result.num_tuples = 0;
    SampleBuffer buffer;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      for (const DataArray& array : parts_[p].arrays) {
        if (!is_same_array(array, like)) continue;
        append_tuples(array, p, size, buffer, result.num_tuples);
        break;  // a name that stands twice
      }
    }
    result.bytes = buffer.release();
    return result;
  }

  void append_tuples(const DataArray& array, std::size_t part, std::size_t size,
                     SampleBuffer& buffer, std::int64_t& num_tuples) const {
    const auto num_bytes = static_cast<std::int64_t>(array.bytes.view.size());
    std::byte* out = buffer.extend(num_bytes, num_bytes).data();
    std::int64_t num_taken = 0;
    for (std::int64_t i = 0; i < array.num_tuples; ++i) {
      if (!array.is_cell_data && !is_new_[part][static_cast<std::size_t>(i)]) continue;
      std::memcpy(out, array.bytes.view.data() + static_cast<std::size_t>(i) * size, size);
      out += size;
      ++num_taken;
    }
    buffer.shrink(num_bytes - num_taken * static_cast<std::int64_t>(size));
    num_tuples += num_taken;
  }

  const std::vector<MeshPart>& parts_;
  std::vector<std::vector<std::uint32_t>> numbers_;  // per part: its nodes' numbers in the whole
  std::vector<std::vector<bool>> is_new_;            // per part: the node is not another's
  std::int64_t num_nodes_ = 0;
  std::int64_t num_merged_ = 0;
};

// Points with vertices, or with nothing between them. Arrays of vertices that are the points, one
// for one, become arrays of points.
void make_particles(Dataset& dataset, MeshPart& whole) {
  const Cells& cells = whole.cells;
  bool is_one_to_one = !whole.is_surface && cells.count() == whole.num_nodes();
  for (std::size_t c = 0; is_one_to_one && c < cells.connectivity.size(); ++c)
    is_one_to_one = cells.connectivity[c] == c;
  if (whole.is_surface && cells.count() > 0) {
    dataset.notes.push_back(fmt::format(
        "{}: its {} lines and polygons enclose no volume and are left out: its points are read",
        dataset.source, cells.count()));
  }
  std::erase_if(whole.arrays, [&](DataArray& array) {
    if (!array.is_cell_data) return false;
    array.is_cell_data = false;
    if (is_one_to_one) return false;
    dataset.notes.push_back(
        fmt::format("{}: array '{}' is left out: it belongs to cells, points "
                    "are read",
                    dataset.source, array.name));
    return true;
  });
  whole.cells = {};
}

// Leaves the parts that have something to show.
void check_parts(Dataset& dataset, std::vector<MeshPart>& parts) {
  std::int64_t num_dropped = 0;
  bool has_points = false;
  std::erase_if(parts, [&](MeshPart& part) {
    if (part.num_nodes() == 0) return true;
    has_points = true;
    check_mesh(part.source.empty() ? dataset.source : part.source, part);
    const bool had_cells = part.cells.count() > 0;
    const std::int64_t num_gone = drop_ghosts(part);
    num_dropped += num_gone;
    return num_gone > 0 && (had_cells ? part.cells.count() == 0 : part.num_nodes() == 0);
  });
  if (!has_points)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has no points", dataset.source));
  if (parts.empty()) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: all {} cells or points are hidden or duplicates of other pieces'",
                            dataset.source, num_dropped));
  }
  if (num_dropped > 0) {
    dataset.notes.push_back(fmt::format("{}: {} hidden or duplicate cells or points are left out",
                                        dataset.source, num_dropped));
  }
}

// What stands for the values of a mesh that has none.
DataArray zeros_at_nodes(const Dataset& dataset) {
  DataArray array;
  array.name = "nothing";
  array.num_tuples = dataset.num_positions();
  const auto zeros =
      std::make_shared<const std::vector<float>>(static_cast<std::size_t>(array.num_tuples));
  array.bytes = {zeros, std::as_bytes(std::span(*zeros))};
  return array;
}

// What is asked for has to be there. Particles keep what says how large and heavy they are.
void leave_wanted_array(Dataset& dataset, const std::string& wanted) {
  if (wanted.empty()) return;
  DataArray array = dataset.array(wanted);
  if (dataset.kind == DatasetKind::kParticles) return;
  dataset.arrays.clear();
  dataset.arrays.push_back(std::move(array));
}

}  // namespace

Dataset mesh_of_parts(Dataset dataset, std::vector<MeshPart> parts, const ReadOptions& options) {
  check_parts(dataset, parts);
  if (dataset.times.empty() && dataset.num_steps == 1 && parts.front().time)
    dataset.times.push_back(*parts.front().time);
  choose_blocks(dataset, parts, options);
  leave_shared_arrays(dataset, parts);
  MeshPart whole;
  if (parts.size() == 1) {
    whole = std::move(parts.front());
  } else {
    for (MeshPart& part : parts) make_explicit(part);
    Merger merger(parts);
    whole = merger.run();
    if (merger.num_merged() > 0) {
      dataset.notes.push_back(fmt::format("{}: {} points at places of other pieces are merged",
                                          dataset.source, merger.num_merged()));
    }
  }
  const bool are_points = (whole.is_surface && !options.faces) || is_point_set(whole);
  dataset.kind = are_points ? DatasetKind::kParticles : DatasetKind::kMesh;
  if (are_points) make_particles(dataset, whole);
  dataset.positions = std::move(whole.positions);
  dataset.positions.name = "positions";
  dataset.cells = std::move(whole.cells);
  dataset.arrays = std::move(whole.arrays);
  if (options.faces && dataset.arrays.empty()) dataset.arrays = {zeros_at_nodes(dataset)};
  if (dataset.kind == DatasetKind::kMesh && dataset.arrays.empty()) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: has no array of numbers at its points or cells", dataset.source));
  }
  leave_wanted_array(dataset, options.array);
  shorten_notes(dataset.notes);
  return dataset;
}

}  // namespace ovoid::io
