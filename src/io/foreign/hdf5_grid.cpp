// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/core/axis_order.h"
#include "io/core/cf_conventions.h"
#include "io/core/json_file.h"
#include "io/core/samples.h"
#include "io/foreign/hdf5_attributes.h"
#include "io/foreign/hdf5_file.h"
#include "io/foreign/hdf5_storage.h"
#include "io/foreign/hdf5_volumes.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// An array that may be a volume.
struct Grid {
  const Hdf5Dataset* dataset = nullptr;
  std::string axes;                // what its axes are
  bool are_told = false;           // by the file, or who asks
  std::vector<double> spacings{};  // along its axes, as its tags say; 0: unknown
};

// The sizes along x, y, z and time.
std::array<std::int64_t, 4> sizes_of(const Grid& grid) {
  std::array<std::int64_t, 4> sizes{1, 1, 1, 1};
  constexpr std::string_view kLetters = "xyzt";
  for (std::size_t i = 0; i < sizes.size(); ++i)
    if (const auto place = axis_place(grid.axes, kLetters[i]))
      sizes[i] = grid.dataset->dims[*place];
  return sizes;
}

// A mesh's or table's columns are no volume: two axes at least have more than one sample.
bool is_volume(const Grid& grid) {
  const auto sizes = sizes_of(grid);
  return std::count_if(sizes.begin(), sizes.begin() + 3, [](auto size) { return size > 1; }) >= 2;
}

// Letters that say all axes, among them y and x, each once.
bool are_axes(const std::string& letters, std::size_t rank) {
  return letters.size() == rank && axis_place(letters, 'x') && axis_place(letters, 'y') &&
         std::all_of(letters.begin(), letters.end(), [&](char letter) {
           return std::count(letters.begin(), letters.end(), letter) == 1;
         });
}

// Vigra's and ilastik's tags: JSON with a key and, where it is known, a resolution for each axis.
void take_axis_tags(const std::string& text, Grid& grid) {
  const Json tags = Json::parse(text, nullptr, false);
  if (!tags.is_object() || !tags.contains("axes") || !tags["axes"].is_array()) return;
  std::string letters;
  std::vector<double> spacings;
  for (const Json& axis : tags["axes"]) {
    if (!axis.is_object() || !axis.contains("key") || !axis["key"].is_string()) return;
    const auto letter = axis_called(axis["key"].get<std::string>());
    if (!letter) return;
    letters += *letter;
    const bool has_resolution = axis.contains("resolution") && axis["resolution"].is_number();
    const double resolution = has_resolution ? axis["resolution"].get<double>() : 0;
    spacings.push_back(resolution > 0 && std::isfinite(resolution) ? resolution : 0);
  }
  if (!are_axes(letters, grid.dataset->dims.size())) return;
  grid.axes = letters;
  grid.spacings = spacings;
}

// What the file says of the axes: tags, or HDF5's own labels of dimensions.
void take_labels(const Hdf5File& file, Grid& grid) {
  if (const auto tags = file.text(grid.dataset->path, "axistags")) take_axis_tags(*tags, grid);
  if (!grid.axes.empty()) return;
  std::string letters;
  for (const std::string& label : file.texts(grid.dataset->path, "DIMENSION_LABELS")) {
    const auto letter = axis_called(label);
    if (!letter) return;
    letters += *letter;
  }
  if (are_axes(letters, grid.dataset->dims.size())) grid.axes = letters;
}

// What the axes of an array are, as `asked`, the file or the usual order says; nothing if it is no
// volume.
std::optional<Grid> grid_of(const Hdf5File& file, const Hdf5Dataset& dataset,
                            const std::string& asked) {
  const auto& dims = dataset.dims;
  if (!dataset.type || dims.size() < 2 || *std::min_element(dims.begin(), dims.end()) < 1)
    return std::nullopt;
  Grid grid{&dataset, {}};
  if (asked.empty()) {
    take_labels(file, grid);
  } else {
    if (dims.size() != asked.size()) return std::nullopt;
    grid.axes = asked;
  }
  grid.are_told = !grid.axes.empty();
  if (!grid.are_told && dims.size() > 2) grid.axes = usual_axis_order(dims).value_or("");
  if (grid.axes.empty() || !is_volume(grid)) return std::nullopt;
  return grid;
}

// With time or channels.
bool is_other(const Grid& grid) {
  return axis_place(grid.axes, 't') || (axis_place(grid.axes, 'c') && !grid.axes.ends_with('c'));
}

class Hdf5GridReader {
 public:
  Hdf5GridReader(const Hdf5File& file, const ReadOptions& options)
      : source_(file.source()), options_(options), file_(file) {}

  std::optional<Dataset> run() {
    const std::vector<Grid> chosen = choose();
    if (chosen.empty()) return std::nullopt;
    dataset_.source = source_.name();
    dataset_.format = "HDF5 grid";
    std::vector<Hdf5Volume> volumes;
    for (const Grid& grid : chosen) {
      const std::string where = fmt::format("{}: '{}'", source_.name(), grid.dataset->path);
      if (!options_.raw.axis_order.empty())
        check_axis_order(where, grid.axes, grid.dataset->dims);
      else if (!grid.are_told && is_other(grid))
        dataset_.notes.push_back(
            fmt::format("{}: shape ({}) taken as {}: say which axis is which with --axis-order",
                        where, fmt::join(grid.dataset->dims, ", "), grid.axes));
      // Called as it was asked for: that is how it is looked for.
      volumes.push_back({grid.dataset,
                         options_.array.empty() ? grid.dataset->path.substr(1) : options_.array,
                         grid.axes});
    }
    read_hdf5_volumes(file_, volumes, options_, dataset_);
    place(chosen);
    if (dataset_.num_steps > 1) set_times(group_of(chosen[0].dataset->path));
    check_geometry(source_.name() + ": spacing", dataset_.lattice.world_from_index);
    note_left_out();
    return std::move(dataset_);
  }

 private:
  std::vector<Grid> choose() const {
    std::vector<Grid> grids;
    for (const Hdf5Dataset& dataset : file_.datasets())
      if (auto grid = grid_of(file_, dataset, options_.raw.axis_order))
        grids.push_back(std::move(*grid));
    std::vector<const Hdf5Dataset*> datasets;
    if (!options_.array.empty()) {
      for (const Grid& grid : grids) datasets.push_back(grid.dataset);
      const Hdf5Dataset* const named = hdf5_named(file_, options_.array, datasets);
      std::erase_if(grids, [&](const Grid& grid) { return grid.dataset != named; });
      return grids;
    }
    // Those with time or channels where there are no others, unless the order is asked for.
    if (options_.raw.axis_order.empty() && !std::all_of(grids.begin(), grids.end(), is_other))
      std::erase_if(grids, is_other);
    for (const Grid& grid : grids) datasets.push_back(grid.dataset);
    for (const Grid& grid : grids) {
      if (sizes_of(grid) == sizes_of(grids[0])) continue;
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: holds several grids: {}: choose one with --array",
                              source_.name(), hdf5_list(datasets)));
    }
    return grids;
  }

  // Volumes by their sizes that hold no numbers: they would be looked for.
  void note_left_out() {
    if (!options_.array.empty()) return;
    for (const Hdf5Dataset& dataset : file_.datasets()) {
      if (dataset.type || dataset.dims.size() < 3 || dataset.type_text == "references" ||
          dataset.type_text == "text")
        continue;
      dataset_.notes.push_back(fmt::format("{}: '{}' is left out: it holds {}", source_.name(),
                                           dataset.path, dataset.type_text));
    }
    shorten_notes(dataset_.notes);
  }

  // As Hdf5File::numbers() takes it; "" is the root.
  static std::string group_of(const std::string& path) { return path.substr(0, path.rfind('/')); }

  void set_times(const std::string& group) {
    for (const char* const name : {"time", "t"}) {
      std::vector<double> times = file_.numbers(group, name);
      if (times.empty() || !dataset_.times.empty()) continue;
      const std::string path = fmt::format("{}/{}", group, name);
      set_cf_times(std::move(times), file_.text(path, "units").value_or(""), dataset_);
    }
  }

  // The first array whose attributes or tags say it; else datasets beside the first.
  void place(const std::vector<Grid>& grids) {
    for (const Grid& grid : grids)
      if (place_by_attributes(grid.dataset->path) || place_by_tags(grid)) return;
    place_beside(grids[0].dataset->path);
  }

  bool place_by_tags(const Grid& grid) {
    Vec3 spacing(0, 0, 0);
    constexpr std::string_view kLetters = "xyz";
    for (std::size_t i = 0; i < 3 && !grid.spacings.empty(); ++i)
      if (const auto place = axis_place(grid.axes, kLetters[i]))
        spacing[static_cast<Eigen::Index>(i)] = grid.spacings[*place];
    if (!(spacing.maxCoeff() > 0)) return false;
    // An axis without one has one sample, or is as fine as the finest.
    const double most = spacing.maxCoeff();
    const double least = (spacing.array() == 0).select(most, spacing).minCoeff();
    dataset_.lattice.world_from_index.linear() =
        (spacing.array() == 0).select(least, spacing).matrix().asDiagonal();
    dataset_.notes.push_back(fmt::format("{}: the spacing is the axistags' of '{}'", source_.name(),
                                         grid.dataset->path));
    return true;
  }

  // Attributes in the order of the array's axes: z, y, x.
  bool place_by_attributes(const std::string& path) {
    static constexpr std::pair<const char*, const char*> kSpacings[] = {
        {"element_size_um", "um"}, {"resolution", ""}, {"spacing", ""}, {"voxel_size", ""}};
    const Hdf5Handle stored = file_.object(path);
    const auto three = [&](const char* name) -> std::optional<Vec3> {
      const std::vector<double> numbers = hdf5_numbers(stored.get(), name, 3);
      if (numbers.size() != 3) return std::nullopt;
      const Vec3 values(numbers[2], numbers[1], numbers[0]);
      if (!values.allFinite()) return std::nullopt;
      return values;
    };
    for (const auto& [name, unit] : kSpacings) {
      const auto spacing = three(name);
      if (!spacing || !(spacing->minCoeff() > 0)) continue;
      dataset_.lattice.world_from_index.linear() = spacing->asDiagonal();
      dataset_.notes.push_back(fmt::format("{}: the spacing is {} of '{}', taken as z, y, x{}{}",
                                           source_.name(), name, path, *unit != '\0' ? ", in " : "",
                                           unit));
      if (const auto origin = three("offset"))
        dataset_.lattice.world_from_index.translation() = *origin;
      return true;
    }
    return false;
  }

  // The places along an axis, from a dataset beside the array that is called like it.
  std::vector<double> coordinates(const std::string& group, std::size_t axis) const {
    static const std::array<std::vector<const char*>, 3> kNames{
        {{"x", "lon", "longitude"},
         {"y", "lat", "latitude"},
         {"z", "lev", "level", "depth", "height", "altitude"}}};
    for (const char* const name : kNames[axis]) {
      std::vector<double> places = file_.numbers(group, name);
      if (static_cast<std::int64_t>(places.size()) == dataset_.lattice.dims[axis] &&
          even_places(places))
        return places;
    }
    return {};
  }

  void place_beside(const std::string& path) {
    const std::string group = group_of(path);
    if (!place_by_coordinates({coordinates(group, 0), coordinates(group, 1), coordinates(group, 2)},
                              dataset_))
      return;
    dataset_.notes.push_back(
        fmt::format("{}: samples lie where the datasets beside '{}' that are "
                    "called like axes say",
                    source_.name(), path));
  }

  const ByteSource& source_;
  const ReadOptions& options_;
  const Hdf5File& file_;
  Dataset dataset_;
};

}  // namespace

std::optional<Dataset> read_hdf5_grid(const Hdf5File& file, const ReadOptions& options) {
  return Hdf5GridReader(file, options).run();
}

}  // namespace ovoid::io
#endif
