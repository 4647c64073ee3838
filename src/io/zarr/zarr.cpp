// SPDX-License-Identifier: Apache-2.0
#include "io/zarr/zarr.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "io/core/axis_order.h"
#include "io/core/cf_grid.h"
#include "io/core/cf_places.h"
#include "io/core/samples.h"
#include "io/core/signatures.h"
#include "io/zarr/ome_images.h"
#include "io/zarr/zarr_array.h"
#include "io/zarr/zarr_cf.h"
#include "io/zarr/zarr_places.h"
#include "io/zarr/zarr_store.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

namespace fs = std::filesystem;

constexpr int kMostDepth = 16;              // of groups in groups
constexpr std::size_t kMostNodes = 10'000;  // that are looked at
constexpr std::size_t kMostImages = 1000;

bool begins_with_zip_magic(std::string_view start) { return start.starts_with("PK\x03\x04"); }

// An image, and the group that it is the image of.
struct FoundImage {
  std::string key;
  OmeImage image;
};

class ZarrReader {
 public:
  ZarrReader(const ByteSource& source, const ReadOptions& options, const Opener& open)
      : options_(options) {
    dataset_.format = "Zarr";
    if (begins_with_zip_magic(source.text(0, 4))) {
      dataset_.source = source.name();
      store_ = open_zarr_zip(source, open);
      return;
    }
    folder_ = fs::path(source.name()).parent_path().string();
    dataset_.source = folder_.empty() ? source.name() : folder_;
    store_ = open_zarr_folder(folder_.empty() ? "." : folder_, open);
  }

  Dataset run() {
    const auto root = find_zarr_node(*store_, "", &dataset_.notes);
    if (!root)
      fail(ErrorCode::kFileFormat, "has no .zarray, .zgroup or zarr.json, which describe it");
    if (root->is_array)
      read_array(*root);
    else if (const std::vector<OmeImage> images = ome_images(*root); !images.empty())
      read_images(images);
    else
      read_group();
    return std::move(dataset_);
  }

 private:
  [[noreturn]] void fail(ErrorCode code, const std::string& what) const {
    throw Error(code, fmt::format("{}: {}", dataset_.source, what));
  }
  void note(const std::string& what) {
    dataset_.notes.push_back(fmt::format("{}: {}", dataset_.source, what));
  }

  // --- images -----------------------------------------------------------------------------------

  // The root's: a block for each resolution.
  void read_images(const std::vector<OmeImage>& images) {
    std::vector<std::pair<const OmeImage*, const OmeLevel*>> levels;
    for (const OmeImage& image : images)
      for (const OmeLevel& level : image.levels) levels.emplace_back(&image, &level);
    if (levels.size() > 1) {
      for (const auto& [image, level] : levels)
        dataset_.blocks.push_back({level->path, describe(level->path)});
    }
    const std::size_t chosen = choose_block(
        images.size() > 1 ? "images and resolutions" : "resolutions", "the finest of the first");
    read_level("", *levels[chosen].first, *levels[chosen].second);
  }

  // "1024x1024x60 uint16", as far as an array says it.
  std::string describe(const std::string& key) const {
    try {
      const auto node = find_zarr_node(*store_, key);
      if (!node || !node->is_array) return "is not there";
      const ChunkedArray array = zarr_array(store_, *node);
      return fmt::format("({}) {}", fmt::join(array.shape, ", "), name_of(array.type));
    } catch (const Error&) {
      return "cannot be read";
    }
  }

  // Of dataset_.blocks the one asked for, or the first.
  std::size_t choose_block(const std::string& what, const std::string& which) {
    const auto& blocks = dataset_.blocks;
    if (blocks.empty()) return 0;
    std::size_t chosen = 0;
    if (!options_.block.empty()) {
      const auto named = std::find_if(blocks.begin(), blocks.end(), [&](const DatasetBlock& block) {
        return block.name == options_.block;
      });
      if (named == blocks.end()) {
        constexpr std::size_t kListed = 20;
        std::string known;
        for (std::size_t i = 0; i < std::min(kListed, blocks.size()); ++i)
          known += fmt::format(" '{}'", blocks[i].name);
        if (blocks.size() > kListed) known += fmt::format(" and {} more", blocks.size() - kListed);
        fail(ErrorCode::kInvalidArgument,
             fmt::format("block '{}': expected one of{}", options_.block, known));
      }
      chosen = static_cast<std::size_t>(named - blocks.begin());
    } else {
      note(fmt::format("holds {} {}, '{}' is read, {}; choose with --block", blocks.size(), what,
                       blocks[0].name, which));
    }
    dataset_.block = blocks[chosen].name;
    return chosen;
  }

  void read_level(const std::string& group, const OmeImage& image, const OmeLevel& level) {
    const std::string key = zarr_key(group, level.path);
    const auto node = find_zarr_node(*store_, key);
    if (!node || !node->is_array) {
      fail(ErrorCode::kFileFormat,
           fmt::format("its description names the array '{}', which is not there", key));
    }
    read_as_level(*node, image, level);
  }

  void read_as_level(const ZarrNode& node, const OmeImage& image, const OmeLevel& level) {
    dataset_.format = "OME-Zarr";
    ChunkedArray array = zarr_array(store_, node);
    array.axes = image.axes;
    array.channels = image.channels;
    for (Channel& channel : array.channels) leave_out_whole_range(array.type, channel.display);
    if (array.shape.size() != image.axes.size()) {
      fail(ErrorCode::kFileFormat, fmt::format("array '{}' has {} axes, its image {}: {}", node.key,
                                               array.shape.size(), image.axes.size(), image.axes));
    }
    if (!options_.raw.axis_order.empty()) {
      check_axis_order(array.where, options_.raw.axis_order, array.shape);
      array.axes = options_.raw.axis_order;
    }
    check_chunked(array);
    read_chunked({array}, options_, dataset_);
    place_ome_level(image, level, dataset_);
    place_as_asked();
  }

  // --- arrays -----------------------------------------------------------------------------------

  // The root is an array: a level of the image of the folder above, or by itself.
  void read_array(const ZarrNode& root) {
    if (!folder_.empty() && read_as_level_of_parent(root)) return;
    read_arrays({root});
  }

  // Only the description of the folders above is looked at, as the name of a level's folder says
  // too little to place its samples.
  bool read_as_level_of_parent(const ZarrNode& root) {
    std::error_code error;
    fs::path above = fs::absolute(folder_, error).lexically_normal();
    if (!above.has_filename()) above = above.parent_path();  // "a.zarr/0/"
    std::string path;
    constexpr int kMostAbove = 2;
    for (int i = 0; i < kMostAbove && !error && above.has_filename(); ++i) {
      path = path.empty() ? above.filename().string()
                          : fmt::format("{}/{}", above.filename().string(), path);
      above = above.parent_path();
      std::vector<OmeImage> images;
      try {
        const auto group = find_zarr_node(*open_zarr_folder(above.string(), open_file), "");
        if (group && !group->is_array) images = ome_images(*group);
      } catch (const Error&) {
        continue;  // what is above may be broken, or not for us
      }
      for (const OmeImage& image : images) {
        for (const OmeLevel& level : image.levels) {
          if (level.path != path) continue;
          read_as_level(root, image, level);
          return true;
        }
      }
    }
    return false;
  }

  // --- groups -----------------------------------------------------------------------------------

  void read_group() {
    std::vector<FoundImage> images;
    std::vector<ZarrNode> arrays;
    std::size_t num_nodes = 0;
    walk("", 0, num_nodes, images, arrays);
    if (!images.empty()) {
      if (images.size() > 1) {
        for (const FoundImage& found : images)
          dataset_.blocks.push_back(
              {found.key, describe(zarr_key(found.key, found.image.levels[0].path))});
      }
      const FoundImage& chosen = images[choose_block("images", "the first")];
      read_level(chosen.key, chosen.image, chosen.image.levels[0]);
      return;
    }
    read_arrays(arrays);
  }

  void walk(const std::string& key, int depth, std::size_t& num_nodes,
            std::vector<FoundImage>& images, std::vector<ZarrNode>& arrays) {
    for (const std::string& name : store_->folders_in(key)) {
      if (++num_nodes > kMostNodes || images.size() == kMostImages) return;
      auto node = find_zarr_node(*store_, zarr_key(key, name));
      if (!node) continue;
      if (node->is_array) {
        arrays.push_back(std::move(*node));
        continue;
      }
      std::vector<OmeImage> found = ome_images(*node);
      if (!found.empty())
        images.push_back({node->key, std::move(found.front())});
      else if (depth + 1 < kMostDepth)
        walk(node->key, depth + 1, num_nodes, images, arrays);
    }
  }

  // --- arrays by themselves ---------------------------------------------------------------------

  struct FoundArray {
    ChunkedArray array;
    const ZarrNode* node;
  };

  // Those that may be volumes and are asked for.
  std::vector<FoundArray> volumes_of(const std::vector<ZarrNode>& nodes) {
    std::vector<FoundArray> found;
    for (const ZarrNode& node : nodes) {
      if (nodes.size() > 1 && !is_asked_for(node)) continue;
      try {
        ChunkedArray array = zarr_array(store_, node);
        const auto num_long = std::count_if(array.shape.begin(), array.shape.end(),
                                            [](std::int64_t size) { return size > 1; });
        // A group's coordinates and tables are no volumes.
        if (nodes.size() > 1 && (array.shape.size() < 2 || num_long < 2)) continue;
        if (!node.key.empty()) array.name = node.key;
        if (nodes.size() > 1 && !options_.array.empty()) array.name = options_.array;
        array.axes = axes_of(array, node);
        check_chunked(array);
        found.push_back({std::move(array), &node});
      } catch (const Error& error) {
        if (nodes.size() == 1 || !options_.array.empty()) throw;
        note(fmt::format("'{}' is left out: {}", node.key, error.what()));
      }
    }
    return found;
  }

  // By its path, or its name.
  bool is_asked_for(const ZarrNode& node) const {
    const std::string& asked = options_.array;
    return asked.empty() || node.key == asked || "/" + node.key == asked ||
           node.key.ends_with("/" + asked);
  }

  std::string axes_of(const ChunkedArray& array, const ZarrNode& node) {
    const std::string& asked = options_.raw.axis_order;
    if (!asked.empty()) {
      check_axis_order(array.where, asked, array.shape);
      return asked;
    }
    const CfVariable& variable = file_->variable_of(node);
    const CfCoordinates coordinates = finder_->of(variable);
    const std::string told = cf_told_axes(file_->description(), variable, coordinates);
    if (told.size() == array.shape.size() && axis_place(told, 'x') && axis_place(told, 'y'))
      return cf_axes(file_->description(), variable, coordinates);
    const auto usual = usual_axis_order(array.shape);
    if (!usual) {
      fail(ErrorCode::kUnsupported,
           fmt::format("array '{}' has {} axes: expected 2 to 5", node.key, array.shape.size()));
    }
    if (usual->size() > 3) {
      note(fmt::format("shape ({}) taken as {}: say which axis is which with --axis-order",
                       fmt::join(array.shape, ", "), *usual));
    }
    return *usual;
  }

  void read_arrays(const std::vector<ZarrNode>& nodes) {
    file_.emplace(dataset_.source, store_, nodes);
    finder_.emplace(file_->description());
    std::vector<FoundArray> found = volumes_of(nodes);
    if (found.empty()) {
      fail(options_.array.empty() ? ErrorCode::kUnsupported : ErrorCode::kInvalidArgument,
           options_.array.empty()
               ? fmt::format("holds no array of two axes or more that is read, of {} in all",
                             nodes.size())
               : fmt::format("array '{}': no such array: expected one of{}", options_.array,
                             keys_of(nodes)));
    }
    const auto is_like_first = [&](const FoundArray& one) {
      return one.array.dims() == found[0].array.dims() &&
             one.array.size_of_axis('t') == found[0].array.size_of_axis('t');
    };
    if (!std::all_of(found.begin(), found.end(), is_like_first)) {
      std::vector<ZarrNode> volumes;
      volumes.reserve(found.size());
      for (const FoundArray& one : found) volumes.push_back(*one.node);
      fail(ErrorCode::kInvalidArgument,
           fmt::format("holds arrays of several sizes: choose one with --array:{}",
                       keys_of(volumes)));
    }
    std::vector<ChunkedArray> arrays;
    arrays.reserve(found.size());
    for (FoundArray& one : found) {
      one.array.type = cf_type(file_->variable_of(*one.node).attributes, one.array.type);
      arrays.push_back(std::move(one.array));
    }
    const CfVariable& first = file_->variable_of(*found[0].node);
    const CfCoordinates coordinates = finder_->of(first);
    std::optional<CfPlaces> places;
    const bool has_places = std::any_of(coordinates.begin(), coordinates.end(),
                                        [](const CfVariable* one) { return one != nullptr; });
    if (has_places && !options_.raw.spacing)
      places = cf_places(*file_, first, arrays[0].axes, coordinates, dataset_.notes);
    // A channel is asked for by its own name; here the array's was.
    ReadOptions options = options_;
    if (nodes.size() > 1) options.array.clear();
    options.may_stay_in_file = options.may_stay_in_file && (!places || places->are_even);
    read_chunked(arrays, options, dataset_);
    apply_attributes(found, arrays);
    CfTimes times = cf_times(*file_, arrays[0].axes, coordinates);
    set_cf_times(std::move(times.times), times.units, dataset_);
    if (places) place_by_cf(*places, dataset_);
    if (dataset_.kind == DatasetKind::kLattice) place_as_asked();
  }

  void apply_attributes(const std::vector<FoundArray>& found,
                        const std::vector<ChunkedArray>& arrays) {
    std::size_t next = 0;
    for (std::size_t i = 0; i < arrays.size(); ++i) {
      const CfNumbers numbers =
          cf_numbers(file_->variable_of(*found[i].node).attributes, arrays[i].type, file_->fill());
      for (std::int64_t c = 0; c < arrays[i].num_channels() && next < dataset_.arrays.size(); ++c) {
        if (dataset_.arrays[next].name != arrays[i].channel_name(c)) continue;
        apply_cf_numbers(arrays[i].where, numbers, dataset_.arrays[next++], dataset_.notes);
      }
    }
  }

  static std::string keys_of(const std::vector<ZarrNode>& nodes) {
    constexpr std::size_t kListed = 20;
    std::string list;
    for (std::size_t i = 0; i < std::min(kListed, nodes.size()); ++i)
      list += fmt::format(" '{}'", nodes[i].key);
    if (nodes.size() > kListed) list += fmt::format(" and {} more", nodes.size() - kListed);
    return list;
  }

  void place_as_asked() {
    if (options_.raw.spacing)
      dataset_.lattice.world_from_index.linear() = options_.raw.spacing->asDiagonal();
    check_geometry(options_.raw.spacing ? "spacing" : dataset_.source + ": spacing",
                   dataset_.lattice.world_from_index);
  }

  const ReadOptions& options_;
  std::shared_ptr<const ZarrStore> store_;
  std::string folder_;              // of the root; empty within a zip file
  std::optional<ZarrCfFile> file_;  // of arrays by themselves
  std::optional<CfCoordinateFinder> finder_;
  Dataset dataset_;
};

}  // namespace

bool is_zarr(const ByteSource& source, std::string_view start) {
  const std::string name = fs::path(source.name()).filename().string();
  if (is_zarr_description(name) || name == ".zattrs") return true;
  return begins_with_zip_magic(start) && is_zarr_zip(source);
}

std::string zarr_description_of(const std::string& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return path;
  for (const char* const file : {".zarray", ".zgroup", "zarr.json"}) {
    const fs::path description = fs::path(path) / file;
    if (fs::is_regular_file(description, ignored)) return description.string();
  }
  fs::path plain(path);
  if (!plain.has_filename()) plain = plain.parent_path();  // "a.zarr/"
  if (plain.extension() != ".zarr") return path;
  throw Error(
      ErrorCode::kFileFormat,
      fmt::format("{}: has no .zarray, .zgroup or zarr.json, which describe a Zarr folder", path));
}

Dataset read_zarr(const ByteSource& source, const ReadOptions& options, const Opener& open) {
  return ZarrReader(source, options, open).run();
}

}  // namespace ovoid::io
