// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "io/core/axis_order.h"
#include "io/core/cf_conventions.h"
#include "io/core/chunked_array.h"
#include "io/core/point_arrays.h"
#include "io/core/samples.h"
#include "io/core/samples_in_file.h"
#include "io/foreign/hdf5_attributes.h"
#include "io/foreign/hdf5_file.h"
#include "io/foreign/hdf5_storage.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// What the axes of an array are; none if it is no volume.
std::optional<std::string> grid_axes(const Hdf5Dataset& dataset, const std::string& asked) {
  const auto& dims = dataset.dims;
  if (!dataset.type || dims.size() < 2 || *std::min_element(dims.begin(), dims.end()) < 1)
    return std::nullopt;
  const std::optional<std::string> axes = asked.empty()                 ? usual_axis_order(dims)
                                          : dims.size() == asked.size() ? std::optional(asked)
                                                                        : std::nullopt;
  if (!axes || (asked.empty() && dims.size() < 3)) return std::nullopt;
  // A mesh's or table's columns are no volume: two axes at least have more than one sample.
  int num_long = 0;
  for (const char letter : {'x', 'y', 'z'}) {
    const auto place = axis_place(*axes, letter);
    if (place && dims[*place] > 1) ++num_long;
  }
  return num_long >= 2 ? axes : std::nullopt;
}

// Axes whose samples lie as a dataset has them.
bool is_plain(const std::string& axes) { return axes == "zyx" || axes == "zyxc"; }

// The sizes along x, y, z and time.
std::array<std::int64_t, 4> sizes_of(const Hdf5Dataset& dataset, const std::string& axes) {
  std::array<std::int64_t, 4> sizes{1, 1, 1, 1};
  constexpr std::string_view kLetters = "xyzt";
  for (std::size_t i = 0; i < sizes.size(); ++i)
    if (const auto place = axis_place(axes, kLetters[i])) sizes[i] = dataset.dims[*place];
  return sizes;
}

class Hdf5GridReader {
 public:
  Hdf5GridReader(const ByteSource& source, const ReadOptions& options)
      : source_(source), options_(options), file_(source.name(), Hdf5Extent::kMaxRank) {}

  std::optional<Dataset> run() {
    const std::vector<const Hdf5Dataset*> chosen = choose();
    if (chosen.empty()) return std::nullopt;
    opened_ = {H5Fopen(source_.name().c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
    if (!opened_.is_open()) return std::nullopt;
    dataset_.source = source_.name();
    dataset_.format = "HDF5 grid";
    const std::string axes = axes_of(*chosen[0]);
    const auto sizes = sizes_of(*chosen[0], axes);
    dataset_.lattice.dims = {sizes[0], sizes[1], sizes[2]};
    if (std::all_of(chosen.begin(), chosen.end(),
                    [this](const Hdf5Dataset* grid) { return is_plain(axes_of(*grid)); })) {
      std::int64_t total = 0;
      for (const Hdf5Dataset* grid : chosen) total += file_.num_bytes(*grid);
      ReadProgress progress(options_, total);
      for (const Hdf5Dataset* grid : chosen) add(*grid, progress);
    } else {
      add_in_order(chosen);
    }
    check_geometry(source_.name() + ": spacing", dataset_.lattice.world_from_index);
    return std::move(dataset_);
  }

 private:
  std::string axes_of(const Hdf5Dataset& grid) const {
    return *grid_axes(grid, options_.raw.axis_order);
  }

  std::vector<const Hdf5Dataset*> choose() const {
    std::vector<const Hdf5Dataset*> grids;
    for (const Hdf5Dataset& dataset : file_.datasets())
      if (grid_axes(dataset, options_.raw.axis_order)) grids.push_back(&dataset);
    if (!options_.array.empty()) return named(grids);
    // Those with time or channels where there are no others, unless the order is asked for.
    const auto is_other = [this](const Hdf5Dataset* grid) { return !is_plain(axes_of(*grid)); };
    if (options_.raw.axis_order.empty() && !std::all_of(grids.begin(), grids.end(), is_other))
      std::erase_if(grids, is_other);
    for (const Hdf5Dataset* grid : grids) {
      if (sizes_of(*grid, axes_of(*grid)) != sizes_of(*grids[0], axes_of(*grids[0])))
        refuse_choice(grids);
    }
    return grids;
  }

  // By its path, or the name that one alone has.
  std::vector<const Hdf5Dataset*> named(const std::vector<const Hdf5Dataset*>& grids) const {
    const std::string& asked = options_.array;
    const std::string path = asked.starts_with('/') ? asked : "/" + asked;
    std::vector<const Hdf5Dataset*> found;
    for (const Hdf5Dataset* grid : grids) {
      if (grid->path == path) return {grid};
      if (grid->name == asked) found.push_back(grid);
    }
    if (found.size() > 1) refuse_choice(found);
    return found;
  }

  [[noreturn]] void refuse_choice(const std::vector<const Hdf5Dataset*>& grids) const {
    constexpr std::size_t kListed = 8;
    std::string list;
    for (std::size_t i = 0; i < std::min(kListed, grids.size()); ++i)
      list += fmt::format("{}'{}' [{}]", i == 0 ? "" : ", ", grids[i]->path,
                          fmt::join(grids[i]->dims, ", "));
    if (grids.size() > kListed) list += fmt::format(" and {} more", grids.size() - kListed);
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("{}: holds several grids: {}: choose one with --array", source_.name(), list));
  }

  // Called as it was asked for: that is how it is looked for.
  std::string name_of_grid(const Hdf5Dataset& grid) const {
    return options_.array.empty() ? grid.path.substr(1) : options_.array;
  }

  Hdf5Handle open_grid(const std::string& where, const Hdf5Dataset& grid) const {
    Hdf5Handle stored(H5Dopen2(opened_.get(), grid.path.c_str(), H5P_DEFAULT), H5Dclose);
    if (!stored.is_open()) throw Error(ErrorCode::kFileFormat, fmt::format("{} is broken", where));
    checked_num_bytes(where, grid.dims, grid.type->type);
    check_hdf5_storage(stored.get(), {where, *grid.type, grid.dims}, source_);
    return stored;
  }

  std::string where_of(const Hdf5Dataset& grid) const {
    return fmt::format("{}: '{}'", source_.name(), grid.path);
  }

  void add(const Hdf5Dataset& grid, ReadProgress& progress) {
    const std::string where = where_of(grid);
    const Hdf5Handle stored = open_grid(where, grid);
    const Hdf5Extent extent{where, *grid.type, grid.dims};
    DataArray array{name_of_grid(grid),
                    extent.type.type,
                    grid.dims.size() == 4 ? static_cast<int>(grid.dims[3]) : 1,
                    num_samples(dataset_.lattice.dims),
                    "",
                    false,
                    {}};
    if (dataset_.arrays.empty()) place(stored.get(), grid.path);
    if (array.num_components == 1 &&
        stays_in_file(extent.type.type, extent.num_bytes(), options_)) {
      if (const auto at = place_of_hdf5_storage(opened_.get(), stored.get(), extent)) {
        array.stored = samples_told(*at);
        apply_cf(stored.get(), where, array);
        dataset_.arrays.push_back(std::move(array));
        return;
      }
    }
    std::byte* to = nullptr;
    array = new_array(std::move(array), to);
    read_hdf5_storage(stored.get(), extent, to, progress);
    apply_cf(stored.get(), where, array);
    dataset_.arrays.push_back(std::move(array));
  }

  // With time or channels, or in an order that was asked for: one step, from the rows that it lies
  // in.
  void add_in_order(const std::vector<const Hdf5Dataset*>& grids) {
    std::vector<ChunkedArray> arrays;
    std::vector<std::shared_ptr<const Hdf5Handle>> handles;
    std::mutex mutex;  // the library's build for one thread
    ReadOptions quiet = options_;
    quiet.progress = {};
    ReadProgress progress(quiet, 0);
    for (const Hdf5Dataset* grid : grids) {
      ChunkedArray array;
      array.where = where_of(*grid);
      array.name = name_of_grid(*grid);
      array.axes = axes_of(*grid);
      if (!options_.raw.axis_order.empty())
        check_axis_order(array.where, array.axes, grid->dims);
      else
        dataset_.notes.push_back(
            fmt::format("{}: shape ({}) taken as {}: say which axis is which with --axis-order",
                        array.where, fmt::join(grid->dims, ", "), array.axes));
      array.shape = array.chunk = grid->dims;
      array.chunk[0] = 1;
      array.type = grid->type->type;
      array.is_big_endian = std::endian::native == std::endian::big;  // as rows are read
      check_chunked(array);
      const auto stored = std::make_shared<const Hdf5Handle>(open_grid(array.where, *grid));
      handles.push_back(stored);
      array.read = [&mutex, &progress, stored,
                    extent = Hdf5Extent{array.where, *grid->type, grid->dims}](
                       std::span<const std::int64_t> number, std::span<std::byte> out) {
        const std::scoped_lock lock(mutex);
        read_hdf5_rows(stored->get(), extent, number[0], out, progress);
        return true;
      };
      arrays.push_back(std::move(array));
    }
    ReadOptions own = options_;
    own.array.clear();
    own.may_stay_in_file = false;
    read_chunked(arrays, own, dataset_);
    std::size_t next = 0;
    for (std::size_t i = 0; i < arrays.size(); ++i) {
      for (std::int64_t c = 0; c < arrays[i].num_channels(); ++c, ++next) {
        apply_cf(handles[i]->get(), arrays[i].where, dataset_.arrays[next]);
      }
    }
    place(handles[0]->get(), grids[0]->path);
    set_times(group_of(grids[0]->path));
  }

  // As Hdf5File::numbers() takes it; "" is the root.
  static std::string group_of(const std::string& path) { return path.substr(0, path.rfind('/')); }

  void set_times(const std::string& group) {
    for (const char* const name : {"time", "t"}) {
      std::vector<double> times = file_.numbers(group, name);
      if (times.empty() || !dataset_.times.empty()) continue;
      const std::string path = fmt::format("{}/{}", group, name);
      const Hdf5Handle stored(H5Dopen2(opened_.get(), path.c_str(), H5P_DEFAULT), H5Dclose);
      const std::string units =
          stored.is_open() ? hdf5_text(stored.get(), "units").value_or("") : "";
      set_cf_times(std::move(times), units, dataset_);
    }
  }

  void apply_cf(hid_t stored, const std::string& where, DataArray& array) {
    CfNumbers numbers;
    for (const char* const name : {"_FillValue", "missing_value"}) {
      const std::vector<double> missing = hdf5_numbers(stored, name, 1);
      numbers.missing.insert(numbers.missing.end(), missing.begin(), missing.end());
    }
    const auto number = [&](const char* name) -> std::optional<double> {
      const std::vector<double> values = hdf5_numbers(stored, name, 1);
      return values.size() == 1 ? std::optional(values[0]) : std::nullopt;
    };
    numbers.scale_factor = number("scale_factor");
    numbers.add_offset = number("add_offset");
    numbers.units = hdf5_text(stored, "units").value_or("");
    apply_cf_numbers(where, numbers, array, dataset_.notes);
  }

  // Attributes in the order of the array's axes: z, y, x.
  void place(hid_t stored, const std::string& path) {
    static constexpr std::pair<const char*, const char*> kSpacings[] = {
        {"element_size_um", "um"}, {"resolution", ""}, {"spacing", ""}, {"voxel_size", ""}};
    const auto three = [&](const char* name) -> std::optional<Vec3> {
      const std::vector<double> numbers = hdf5_numbers(stored, name, 3);
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
      return;
    }
    place_beside(path);
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
  Hdf5File file_;
  Hdf5Handle opened_;
  Dataset dataset_;
};

}  // namespace

std::optional<Dataset> read_hdf5_grid(const ByteSource& source, const ReadOptions& options) {
  return Hdf5GridReader(source, options).run();
}

}  // namespace ovoid::io
#endif
