// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/mesh_blocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <compare>
#include <numeric>
#include <utility>

#include "data/bookkeeping.h"
#include "data/names_text.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Names of the blocks in the order they come.
std::vector<std::string> block_names(std::span<const PartOutline> parts) {
  std::vector<std::string> names;
  for (const PartOutline& part : parts) {
    if (std::find(names.begin(), names.end(), part.block) == names.end())
      names.push_back(part.block);
  }
  return names;
}

struct BlockSize {
  std::int64_t num_nodes = 0;
  std::int64_t num_cells = 0;
};

BlockSize size_of_block(std::span<const PartOutline> parts, const std::string& name) {
  BlockSize size;
  for (const PartOutline& part : parts) {
    if (part.block != name) continue;
    size.num_nodes += part.num_nodes;
    size.num_cells += part.num_cells;
  }
  return size;
}

std::vector<std::size_t> parts_of_block(std::span<const PartOutline> parts,
                                        const std::string& name) {
  std::vector<std::size_t> numbers;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (parts[p].block == name) numbers.push_back(p);
  }
  return numbers;
}

bool has(const PartOutline& part, const DataArray& array) {
  return (array.is_cell_data && part.num_cells == 0) ||
         std::any_of(part.arrays.begin(), part.arrays.end(),
                     [&](const DataArray& a) { return is_same_array(a, array); });
}

bool all_have(std::span<const PartOutline> parts, const DataArray& array) {
  return std::all_of(parts.begin(), parts.end(),
                     [&](const PartOutline& part) { return has(part, array); });
}

bool share_data(std::span<const PartOutline> parts) {
  return std::any_of(parts.begin(), parts.end(), [&](const PartOutline& part) {
    return std::any_of(part.arrays.begin(), part.arrays.end(), [&](const DataArray& array) {
      return !data::is_bookkeeping(array) && all_have(parts, array);
    });
  });
}

// What a block is wanted for.
struct BlockWorth {
  bool has_data = false;
  bool has_volume = false;
  auto operator<=>(const BlockWorth&) const = default;
};

BlockWorth worth_of(std::span<const PartOutline> parts, const std::string& name) {
  std::vector<PartOutline> own;
  for (const std::size_t p : parts_of_block(parts, name)) own.push_back(parts[p]);
  return {share_data(own), std::any_of(own.begin(), own.end(),
                                       [](const PartOutline& part) { return part.has_volume; })};
}

// Of blocks that share no array: those that are worth most.
std::vector<std::string> worthiest_blocks(std::span<const PartOutline> parts,
                                          const std::vector<std::string>& names) {
  std::vector<std::string> worthiest;
  BlockWorth greatest;
  for (const std::string& name : names) {
    const BlockWorth worth = worth_of(parts, name);
    if (worth < greatest) continue;
    if (worth > greatest) worthiest.clear();
    greatest = worth;
    worthiest.push_back(name);
  }
  // Of those without data nothing can be chosen by size: the whole is seen.
  if (!greatest.has_data) return worthiest;
  std::vector<PartOutline> own;
  for (const PartOutline& part : parts) {
    if (std::find(worthiest.begin(), worthiest.end(), part.block) != worthiest.end())
      own.push_back(part);
  }
  if (share_data(own)) return worthiest;
  return {*std::max_element(
      worthiest.begin(), worthiest.end(), [&](const std::string& a, const std::string& b) {
        const BlockSize left = size_of_block(parts, a), right = size_of_block(parts, b);
        return std::pair(left.num_cells, left.num_nodes) <
               std::pair(right.num_cells, right.num_nodes);
      })};
}

bool encloses_volume(CellType type) {
  switch (type) {
    case CellType::kVertex:
    case CellType::kLine:
    case CellType::kPolyLine:
    case CellType::kTriangle:
    case CellType::kQuad:
      return false;
    default:
      return true;  // also of others, polyhedra among them
  }
}

bool has_volume(const Cells& cells) {
  if (cells.is_structured())
    return std::all_of(cells.dims.begin(), cells.dims.end(), [](auto dim) { return dim > 1; });
  return std::any_of(cells.types.begin(), cells.types.end(), encloses_volume);
}

}  // namespace

PartOutline outline_of(const MeshPart& part) {
  PartOutline outline{part.block, part.num_nodes(), part.cells.count(), part.arrays,
                      has_volume(part.cells)};
  for (DataArray& array : outline.arrays) array.bytes = {};
  return outline;
}

bool is_same_array(const DataArray& a, const DataArray& b) noexcept {
  return a.name == b.name && a.is_cell_data == b.is_cell_data && a.type == b.type &&
         a.num_components == b.num_components;
}

std::vector<std::size_t> choose_blocks(Dataset& dataset, std::span<const PartOutline> parts,
                                       const ReadOptions& options) {
  std::vector<std::size_t> all(parts.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const std::vector<std::string> names = block_names(parts);
  if (names.size() < 2) return all;
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
    dataset.block = options.block;
    return parts_of_block(parts, options.block);
  }
  if (share_data(parts)) {
    dataset.notes.push_back(fmt::format("{}: all {} blocks are read; choose one with --block",
                                        dataset.source, names.size()));
    return all;
  }
  const std::vector<std::string> worthiest = worthiest_blocks(parts, names);
  if (worthiest.size() == names.size()) {
    dataset.notes.push_back(
        fmt::format("{}: all {} blocks are read, none of which has an array; "
                    "choose one with --block",
                    dataset.source, names.size()));
    return all;
  }
  if (worthiest.size() == 1) dataset.block = worthiest.front();
  dataset.notes.push_back(
      fmt::format("{}: its {} blocks share no array: {} read, as {} most to show; choose with "
                  "--block",
                  dataset.source, names.size(),
                  data::names_text(worthiest) + (worthiest.size() == 1 ? " is" : " are"),
                  worthiest.size() == 1 ? "it has" : "they have"));
  std::vector<std::size_t> chosen;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (std::find(worthiest.begin(), worthiest.end(), parts[p].block) != worthiest.end())
      chosen.push_back(p);
  }
  return chosen;
}

bool are_chosen_by_headers(std::span<const PartOutline> parts, const ReadOptions& options) {
  return !options.block.empty() || block_names(parts).size() < 2 || share_data(parts);
}

std::vector<DataArray> shared_arrays(Dataset& dataset, std::span<const PartOutline> parts) {
  std::vector<DataArray> shared;
  std::vector<std::string> dropped;
  for (const PartOutline& part : parts) {
    for (const DataArray& array : part.arrays) {
      const bool is_known = std::any_of(shared.begin(), shared.end(), [&](const DataArray& a) {
        return is_same_array(a, array);
      });
      if (is_known) continue;
      if (all_have(parts, array)) {
        shared.push_back(array);
      } else if (std::find(dropped.begin(), dropped.end(), array.name) == dropped.end()) {
        dropped.push_back(array.name);
      }
    }
  }
  for (const std::string& name : dropped) {
    dataset.notes.push_back(
        fmt::format("{}: array '{}' is left out: not every piece or block has "
                    "it with the same type",
                    dataset.source, name));
  }
  return shared;
}

}  // namespace ovoid::io
