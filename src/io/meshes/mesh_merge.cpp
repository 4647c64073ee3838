// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <functional>
#include <limits>
#include <span>
#include <unordered_map>
#include <utility>

#include "data/cell_builder.h"
#include "io/core/samples.h"
#include "io/meshes/mesh_blocks.h"
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

// Appends meshes to one, node for node and cell for cell.
class Merger {
 public:
  // `arrays`: that all parts have, in their order.
  Merger(const std::vector<MeshPart>& parts, const std::vector<DataArray>& arrays)
      : parts_(parts), arrays_(arrays) {}

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
    for (const DataArray& array : arrays_) result.arrays.push_back(merged_array(array));
    result.is_surface = std::all_of(parts_.begin(), parts_.end(),
                                    [](const MeshPart& part) { return part.is_surface; });
    return result;
  }

  std::int64_t num_merged() const noexcept { return num_merged_; }

  // DatasetShare::nodes, with the parts' numbers among all parts.
  std::vector<std::uint64_t> numbers_of_nodes(std::span<const std::size_t> part_numbers) const {
    std::vector<std::uint64_t> numbers;
    numbers.reserve(static_cast<std::size_t>(num_nodes_));
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      for (std::size_t i = 0; i < is_new_[p].size(); ++i) {
        if (is_new_[p][i]) numbers.push_back((std::uint64_t{part_numbers[p]} << 32U) + i);
      }
    }
    return numbers;
  }

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
    DataArray result;
    if (!parts_.empty()) result = parts_.front().positions;
    result.num_components = 3;
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
        if (result.unit.empty()) result.unit = array.unit;
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
  const std::vector<DataArray>& arrays_;
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

// Whether something is left of the part once it is checked; adds what is left out.
bool check_part(const Dataset& dataset, MeshPart& part, std::int64_t& num_dropped) {
  check_mesh(part.source.empty() ? dataset.source : part.source, part);
  const bool had_cells = part.cells.count() > 0;
  const std::int64_t num_gone = drop_ghosts(part);
  num_dropped += num_gone;
  return num_gone == 0 || (had_cells ? part.cells.count() > 0 : part.num_nodes() > 0);
}

void note_on_dropped(Dataset& dataset, std::int64_t num_dropped) {
  if (num_dropped == 0) return;
  dataset.notes.push_back(fmt::format("{}: {} hidden or duplicate cells or points are left out",
                                      dataset.source, num_dropped));
}

// Leaves the parts that have something to show.
void check_parts(Dataset& dataset, std::vector<MeshPart>& parts) {
  std::int64_t num_dropped = 0;
  std::erase_if(parts, [](const MeshPart& part) { return part.num_nodes() == 0; });
  if (parts.empty())
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has no points", dataset.source));
  std::erase_if(parts, [&](MeshPart& part) { return !check_part(dataset, part, num_dropped); });
  if (parts.empty()) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: all {} cells or points are hidden or duplicates of other pieces'",
                            dataset.source, num_dropped));
  }
  note_on_dropped(dataset, num_dropped);
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

// A mesh without arrays has a surface to show: its values are zeros.
void require_values(Dataset& dataset, const ReadOptions& options) {
  if (!dataset.arrays.empty() || dataset.kind != DatasetKind::kMesh) return;
  if (!options.array.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: array '{}': not there: the mesh has no array of numbers at its "
                            "points or cells",
                            dataset.source, options.array));
  }
  dataset.arrays = {zeros_at_nodes(dataset)};
  if (options.faces) return;
  dataset.notes.push_back(
      fmt::format("{}: has no array of numbers at its points or cells: its surface can be drawn, "
                  "without values",
                  dataset.source));
}

// What is asked for has to be there. Particles keep what says how large and heavy they are.
void leave_wanted_array(Dataset& dataset, const std::string& wanted) {
  if (wanted.empty()) return;
  DataArray array = dataset.array(wanted);
  if (dataset.kind == DatasetKind::kParticles) return;
  dataset.arrays.clear();
  dataset.arrays.push_back(std::move(array));
}

// Whose part each is: runs of them with about as many cells.
int owner_of(std::int64_t cells_before, std::int64_t num_cells, int count) {
  const double place = static_cast<double>(cells_before) / static_cast<double>(num_cells);
  return std::min(static_cast<int>(place * count), count - 1);
}

// A part as its outline says it is.
void require_outline(const Dataset& dataset, const MeshPart& part, const PartOutline& outline,
                     const std::vector<DataArray>& arrays) {
  const std::string& where = part.source.empty() ? dataset.source : part.source;
  if (part.num_nodes() != outline.num_nodes || part.cells.count() != outline.num_cells)
    throw Error(
        ErrorCode::kFileFormat,
        fmt::format("{}: has {} points and {} cells: its header says {} and {}", where,
                    part.num_nodes(), part.cells.count(), outline.num_nodes, outline.num_cells));
  for (const DataArray& array : arrays) {
    if (array.is_cell_data && outline.num_cells == 0) continue;
    if (std::none_of(part.arrays.begin(), part.arrays.end(),
                     [&](const DataArray& a) { return is_same_array(a, array); }))
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: array '{}': is not what its header says", where, array.name));
  }
}

}  // namespace

Dataset mesh_of_parts(Dataset dataset, std::vector<MeshPart> parts, const ReadOptions& options) {
  check_parts(dataset, parts);
  if (dataset.times.empty() && dataset.num_steps == 1 && parts.front().time)
    dataset.times.push_back(*parts.front().time);
  std::vector<PartOutline> outlines;
  outlines.reserve(parts.size());
  for (const MeshPart& part : parts) outlines.push_back(outline_of(part));
  std::vector<MeshPart> chosen;
  std::vector<PartOutline> chosen_outlines;
  for (const std::size_t p : choose_blocks(dataset, outlines, options)) {
    chosen.push_back(std::move(parts[p]));
    chosen_outlines.push_back(std::move(outlines[p]));
  }
  parts = std::move(chosen);
  const std::vector<DataArray> arrays = shared_arrays(dataset, chosen_outlines);
  MeshPart whole;
  if (parts.size() == 1) {
    whole = std::move(parts.front());
  } else {
    for (MeshPart& part : parts) make_explicit(part);
    Merger merger(parts, arrays);
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
  require_values(dataset, options);
  leave_wanted_array(dataset, options.array);
  shorten_notes(dataset.notes);
  return dataset;
}

Dataset mesh_share_of_parts(Dataset dataset, std::span<const PartOutline> outlines,
                            const std::function<MeshPart(std::size_t)>& read,
                            const ReadOptions& options) {
  const RowShare& share = options.share.value();
  std::vector<PartOutline> chosen;
  std::vector<std::size_t> numbers;
  for (const std::size_t p : choose_blocks(dataset, outlines, options)) {
    if (outlines[p].num_nodes == 0) continue;
    numbers.push_back(p);
    chosen.push_back(outlines[p]);
  }
  const std::vector<DataArray> arrays = shared_arrays(dataset, chosen);
  std::int64_t num_cells = 0;
  for (const PartOutline& part : chosen) num_cells += part.num_cells;
  if (num_cells == 0)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has no cells", dataset.source));
  std::vector<MeshPart> parts;
  std::vector<std::size_t> part_numbers;
  std::int64_t before = 0, first = 0, num_dropped = 0;
  for (std::size_t p = 0; p < chosen.size(); ++p) {
    const int owner = owner_of(before, num_cells, share.count);
    if (owner < share.number) first = before + chosen[p].num_cells;
    before += chosen[p].num_cells;
    if (owner != share.number) continue;
    MeshPart part = read(numbers[p]);
    require_outline(dataset, part, chosen[p], arrays);
    if (p == 0 && part.time) dataset.times.push_back(*part.time);
    if (!check_part(dataset, part, num_dropped)) continue;
    make_explicit(part);
    parts.push_back(std::move(part));
    part_numbers.push_back(p);
  }
  note_on_dropped(dataset, num_dropped);
  Merger merger(parts, arrays);
  MeshPart own = merger.run();
  dataset.kind = DatasetKind::kMesh;
  dataset.share = DatasetShare{first, num_cells, merger.numbers_of_nodes(part_numbers)};
  dataset.positions = std::move(own.positions);
  dataset.positions.name = "positions";
  dataset.cells = std::move(own.cells);
  dataset.arrays = std::move(own.arrays);
  require_values(dataset, options);
  leave_wanted_array(dataset, options.array);
  shorten_notes(dataset.notes);
  return dataset;
}

}  // namespace ovoid::io
