// SPDX-License-Identifier: Apache-2.0
#include "io/xdmf/xdmf.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <system_error>
#include <utility>

#include "io/core/numbers.h"
#include "io/core/samples.h"
#include "io/core/signatures.h"
#include "io/core/text_scanner.h"
#include "io/formats.h"
#include "io/input_files.h"
#include "io/meshes/lattice_set.h"
#include "io/meshes/mesh_parts.h"
#include "io/meshes/mesh_steps.h"
#include "io/reader/reader_session.h"
#include "io/xdmf/xdmf_grid.h"
#include "io/xdmf/xdmf_items.h"
#include "io/xdmf/xdmf_tree.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kMostGrids = 100'000;
constexpr int kDeepestGrid = 16;  // grids within grids

// Files that items of the tree name, each once.
std::set<std::string> xdmf_files(const XdmfTree& tree) {
  std::set<std::string> files;
  for (const XdmfNode item : tree.elements()) {
    if (!tree.attribute(item, {"Reference"}).empty()) continue;
    if (is_xdmf_hdf5(tree, item)) files.insert(xdmf_hdf5_name(tree, item).file);
    if (is_xdmf_binary(tree, item)) files.insert(xdmf_binary_name(tree, item));
  }
  for (const std::string& file : tree.included_files()) files.insert(file);
  return files;
}

// Pieces say the same.
void leave_each_once(std::vector<std::string>& notes) {
  std::set<std::string> known;
  std::erase_if(notes, [&](const std::string& note) { return !known.insert(note).second; });
}

class XdmfReader {
 public:
  XdmfReader(const ByteSource& source, const ReadOptions& options, const Opener& open)
      : source_(source), options_(options), open_(open), tree_(source, open) {}

  bool has_hdf5() const {
    const std::vector<XdmfNode> all = tree_.elements();
    return std::any_of(all.begin(), all.end(),
                       [&](XdmfNode item) { return is_xdmf_hdf5(tree_, item); });
  }

  Dataset run() {
    dataset_.source = source_.name();
    dataset_.format = "XDMF";
    const std::vector<XdmfNode> domains = tree_.children(tree_.root(), "Domain");
    if (domains.empty()) tree_.fail(tree_.root(), "has no Domain");
    const std::vector<XdmfNode> grids = tree_.children(domains[0], "Grid");
    if (grids.empty()) tree_.fail(domains[0], "has no Grid");
    if (grids.size() > 1) options_.block.clear();
    const XdmfNode chosen = grids[choose(grids)];
    const XdmfNode series = series_of(chosen, 0);
    std::vector<XdmfNode> steps{chosen};
    if (series) steps = tree_.children(series, "Grid");
    if (steps.empty()) tree_.fail(chosen, "has no grids");
    num_steps_ = steps.size();
    return read_mesh_step(
        source_.name(), static_cast<std::int64_t>(steps.size()),
        times_of(series ? series : chosen, steps), options_,
        [&](std::int64_t step) { return read_step(chosen, static_cast<std::size_t>(step)); });
  }

 private:
  std::string grid_type(XdmfNode grid) const {
    const std::string type = lower(tree_.attribute(grid, {"GridType", "Type"}));
    return type.empty() ? "uniform" : type;
  }

  bool is_temporal(XdmfNode grid) const {
    return grid_type(grid) == "collection" &&
           lower(tree_.attribute(grid, {"CollectionType"})) == "temporal";
  }

  // The temporal collection whose grids are the steps: the grid itself, or the first within it.
  XdmfNode series_of(XdmfNode grid, int depth) const {
    if (is_temporal(grid)) return grid;
    if (grid_type(grid) == "uniform" || depth == kDeepestGrid) return {};
    for (const XdmfNode inner : tree_.children(grid, "Grid"))
      if (const XdmfNode series = series_of(inner, depth + 1)) return series;
    return {};
  }

  bool has_attributes(XdmfNode grid) const {
    const auto inner = grid.children();
    return std::any_of(inner.begin(), inner.end(), [&](XdmfNode child) {
      return xml_name(child) == "Attribute" || (xml_name(child) == "Grid" && has_attributes(child));
    });
  }

  // Of several grids of the domain, the one that is read.
  std::size_t choose(const std::vector<XdmfNode>& grids) {
    if (grids.size() == 1) return 0;
    std::set<std::string> names;
    for (std::size_t i = 0; i < grids.size(); ++i) {
      const std::string told = tree_.attribute(grids[i], {"Name"});
      const std::string base = told.empty() ? fmt::format("grid {}", i + 1) : told;
      std::string name = base;
      for (int n = 2; !names.insert(name).second; ++n) name = fmt::format("{} {}", base, n);
      dataset_.blocks.push_back(
          {name, is_temporal(grids[i])
                     ? fmt::format("{} time steps", tree_.children(grids[i], "Grid").size())
                     : grid_type(grids[i]).substr(0, 40)});
    }
    if (wanted_block_.empty()) {
      const auto is_told = [&](XdmfNode grid) { return has_attributes(grid); };
      const auto first = std::find_if(grids.begin(), grids.end(), is_told);
      const auto chosen =
          static_cast<std::size_t>(first == grids.end() ? 0 : first - grids.begin());
      dataset_.block = dataset_.blocks[chosen].name;
      // Others without arrays are meshes that it refers to.
      if (std::count_if(grids.begin(), grids.end(), is_told) != 1) {
        dataset_.notes.push_back(
            fmt::format("{}: holds {} grids, '{}' is read; choose with --block", source_.name(),
                        grids.size(), dataset_.block));
      }
      return chosen;
    }
    for (std::size_t i = 0; i < grids.size(); ++i) {
      dataset_.block = wanted_block_;
      if (dataset_.blocks[i].name == wanted_block_) return i;
    }
    std::string known;
    for (const DatasetBlock& block : dataset_.blocks) known += fmt::format(" '{}'", block.name);
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: block '{}': no such grid: expected one of{}", source_.name(),
                            wanted_block_, known));
  }

  // --- time
  // ---------------------------------------------------------------------------------------

  // The first Time that stands in the grid itself.
  static XdmfNode time_element(XdmfNode grid) {
    return grid.find_child([](XdmfNode child) { return xml_name(child) == "Time"; });
  }

  std::optional<double> time_of(XdmfNode grid) const {
    const XdmfNode time = time_element(grid);
    if (!time) {
      // Of a collection, that of its first grid.
      const XdmfNode first =
          grid.find_child([](XdmfNode child) { return xml_name(child) == "Grid"; });
      return first ? time_of(first) : std::nullopt;
    }
    return parse_real(tree_.attribute(time, {"Value"}));
  }

  // Empty unless all steps have one.
  std::vector<double> times_of(XdmfNode grid, const std::vector<XdmfNode>& steps) const {
    if (steps.size() > static_cast<std::size_t>(kMostGrids))
      tree_.refuse(grid, fmt::format("has more than {} steps", kMostGrids));
    std::vector<double> times;
    if (is_temporal(grid)) times = listed_times(grid, steps.size());
    if (!times.empty()) return times;
    for (const XdmfNode step : steps) {
      const auto time = time_of(step);
      if (!time) return {};
      times.push_back(*time);
    }
    return times;
  }

  // A list of all, or start, stride and count.
  std::vector<double> listed_times(XdmfNode collection, std::size_t count) const {
    const XdmfNode time = time_element(collection);
    if (!time) return {};
    const std::string type = lower(tree_.attribute(time, {"TimeType", "Type"}));
    const std::vector<XdmfNode> items = tree_.children(time, "DataItem");
    if ((type != "list" && type != "hyperslab") || items.size() != 1) return {};
    ReadProgress progress(options_, 0);
    const XdmfNumbers numbers = XdmfItems(tree_, open_, progress).read(items[0]);
    std::vector<double> times;
    for (std::int64_t i = 0; i < std::min<std::int64_t>(numbers.count(), kMostGrids); ++i)
      times.push_back(numbers.number(i));
    if (type == "hyperslab" && times.size() == 3) {
      const double start = times[0], stride = times[1];
      times.clear();
      for (std::size_t i = 0; i < count; ++i)
        times.push_back(start + stride * static_cast<double>(i));
    }
    if (times.size() != count)
      tree_.fail(time,
                 fmt::format("has {} times: the collection has {} grids", times.size(), count));
    return times;
  }

  // --- one step
  // -----------------------------------------------------------------------------------

  // The uniform grids that it is made of at a step.
  void add_leaves(XdmfNode grid, int depth, std::size_t step, bool is_step,
                  std::vector<XdmfNode>& leaves) const {
    const std::string type = grid_type(grid);
    if (type == "uniform") {
      leaves.push_back(grid);
      if (leaves.size() > static_cast<std::size_t>(kMostGrids))
        tree_.refuse(grid, fmt::format("is one of more than {} grids", kMostGrids));
      return;
    }
    if (type != "collection" && type != "tree") {
      tree_.refuse(grid, fmt::format("is of GridType '{}', which is not read: expected Uniform, "
                                     "Collection or Tree",
                                     type.substr(0, 40)));
    }
    if (depth == kDeepestGrid) tree_.refuse(grid, "is too deep");
    const std::vector<XdmfNode> grids = tree_.children(grid, "Grid");
    if (!is_temporal(grid)) {
      for (const XdmfNode inner : grids) add_leaves(inner, depth + 1, step, is_step, leaves);
      return;
    }
    if (is_step) tree_.refuse(grid, "holds time steps within a time step");
    if (grids.size() != num_steps_)
      tree_.refuse(grid, fmt::format("holds {} time steps: another collection has {}", grids.size(),
                                     num_steps_));
    add_leaves(grids[step], depth + 1, step, true, leaves);
  }

  Dataset read_step(XdmfNode grid, std::size_t step) {
    std::vector<XdmfNode> leaves;
    add_leaves(grid, 0, step, false, leaves);
    if (leaves.empty()) tree_.fail(grid, "has no grids");
    Dataset dataset = dataset_;
    ReadOptions quiet = options_;
    quiet.progress = {};
    ReadProgress progress(quiet, 0);
    const XdmfItems items(tree_, open_, progress);
    std::vector<XdmfGrid> grids;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      grids.push_back(read_xdmf_grid(tree_, items, leaves[i], options_.array, dataset.notes));
      if (leaves.size() == 1) break;
      std::string& block = grids.back().part.block;
      block = tree_.attribute(leaves[i], {"Name"});
      if (block.empty()) block = fmt::format("grid {}", i + 1);
    }
    leave_each_once(dataset.notes);
    if (grids.size() == 1 && grids[0].lattice)
      return lattice_of_grid(std::move(dataset), std::move(grids[0]), leaves[0]);
    // Of several grids of the domain the one that was chosen is all that there is.
    std::vector<DatasetBlock> blocks = std::move(dataset.blocks);
    std::string block = std::move(dataset.block);
    dataset.blocks.clear();
    dataset.block.clear();
    dataset = dataset_of_grids(std::move(dataset), std::move(grids));
    if (!blocks.empty()) {
      dataset.blocks = std::move(blocks);
      dataset.block = std::move(block);
    }
    return dataset;
  }

  Dataset dataset_of_grids(Dataset dataset, std::vector<XdmfGrid> grids) const {
    const auto part_of = [](XdmfGrid& grid) {
      return LatticePart{grid.part.block, std::move(*grid.lattice), std::move(grid.part.arrays)};
    };
    if (std::all_of(grids.begin(), grids.end(),
                    [](const XdmfGrid& grid) { return grid.lattice.has_value(); })) {
      std::vector<LatticePart> parts;
      parts.reserve(grids.size());
      for (XdmfGrid& grid : grids) parts.push_back(part_of(grid));
      return dataset_of_lattices(std::move(dataset), std::move(parts), options_);
    }
    std::vector<MeshPart> parts;
    parts.reserve(grids.size());
    for (XdmfGrid& grid : grids)
      parts.push_back(grid.lattice ? mesh_part_of(part_of(grid)) : std::move(grid.part));
    return mesh_of_parts(std::move(dataset), std::move(parts), options_);
  }

  Dataset lattice_of_grid(Dataset dataset, XdmfGrid grid, XdmfNode element) const {
    dataset.kind = DatasetKind::kLattice;
    dataset.lattice = std::move(*grid.lattice);
    dataset.arrays = std::move(grid.part.arrays);
    if (dataset.arrays.empty()) tree_.fail(element, "has no array of numbers at nodes or cells");
    if (!options_.array.empty()) static_cast<void>(dataset.array(options_.array));
    shorten_notes(dataset.notes);
    return dataset;
  }

  const ByteSource& source_;
  ReadOptions options_;
  std::string wanted_block_ = options_.block;
  const Opener& open_;
  XdmfTree tree_;
  Dataset dataset_;
  std::size_t num_steps_ = 1;
};

}  // namespace

bool is_xdmf(const ByteSource& source, std::string_view start) {
  if (start.find("<Xdmf") != std::string_view::npos) return true;
  // A long comment may stand before it.
  const std::string ending = ending_of(source.name());
  return (ending == ".xdmf" || ending == ".xmf") && trimmed(start).starts_with('<');
}

Dataset read_xdmf(const ByteSource& source, const ReadOptions& options, const Opener& open) {
  XdmfReader reader(source, options, open);
  if (!has_xdmf_hdf5() && reader.has_hdf5()) {
    if (has_library("HDF5")) return read_foreign("XDMF", source.name(), {source.name()}, options);
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: its numbers are in HDF5: this build has no HDF5", source.name()));
  }
  return reader.run();
}

std::vector<std::string> xdmf_companions(const ByteSource& source) {
  std::vector<std::string> files;
  try {
    const Opener open = opener_of_named_files(source.name(), {});
    for (const std::string& file : xdmf_files(XdmfTree(source, open))) {
      std::error_code ignored;
      if (std::filesystem::is_regular_file(file, ignored)) files.push_back(file);
    }
  } catch (const Error&) {
    // What is broken is told by who reads it.
  }
  return files;
}

std::optional<double> time_of_xdmf(const ByteSource& source) {
  const Opener open = opener_of_named_files(source.name(), {});
  const XdmfTree tree(source, open);
  for (const XdmfNode element : tree.elements())
    if (xml_name(element) == "Time") return parse_real(tree.attribute(element, {"Value"}));
  return std::nullopt;
}

}  // namespace ovoid::io
