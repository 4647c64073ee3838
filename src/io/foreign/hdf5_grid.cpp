// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "io/core/point_arrays.h"
#include "io/core/samples.h"
#include "io/core/samples_in_file.h"
#include "io/foreign/hdf5_attributes.h"
#include "io/foreign/hdf5_file.h"
#include "io/foreign/hdf5_storage.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Vectors, colours and tensors have so many; any other last axis of four is one of samples.
bool is_component_count(std::int64_t size) noexcept {
  return (1 <= size && size <= 4) || size == 6 || size == 9;
}

// A mesh's or table's columns are no volume: two axes at least have more than one sample.
bool is_grid(const Hdf5Dataset& dataset) {
  const auto& dims = dataset.dims;
  if (!dataset.type || (dims.size() != 3 && !(dims.size() == 4 && is_component_count(dims[3]))))
    return false;
  if (*std::min_element(dims.begin(), dims.end()) < 1) return false;
  return std::count_if(dims.begin(), dims.begin() + 3, [](std::int64_t dim) { return dim > 1; }) >=
         2;
}

bool is_same_size(const Hdf5Dataset& a, const Hdf5Dataset& b) {
  return std::equal(a.dims.begin(), a.dims.begin() + 3, b.dims.begin());
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
    const auto& dims = chosen[0]->dims;
    dataset_.lattice.dims = {dims[2], dims[1], dims[0]};
    std::int64_t total = 0;
    for (const Hdf5Dataset* grid : chosen) total += file_.num_bytes(*grid);
    ReadProgress progress(options_, total);
    for (const Hdf5Dataset* grid : chosen) add(*grid, progress);
    check_geometry(source_.name() + ": spacing", dataset_.lattice.world_from_index);
    return std::move(dataset_);
  }

 private:
  std::vector<const Hdf5Dataset*> choose() const {
    std::vector<const Hdf5Dataset*> grids;
    for (const Hdf5Dataset& dataset : file_.datasets())
      if (is_grid(dataset)) grids.push_back(&dataset);
    if (!options_.array.empty()) return named(grids);
    for (const Hdf5Dataset* grid : grids)
      if (!is_same_size(*grid, *grids[0])) refuse_choice(grids);
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

  void add(const Hdf5Dataset& grid, ReadProgress& progress) {
    const std::string where = fmt::format("{}: '{}'", source_.name(), grid.path);
    const Hdf5Handle stored(H5Dopen2(opened_.get(), grid.path.c_str(), H5P_DEFAULT), H5Dclose);
    if (!stored.is_open()) throw Error(ErrorCode::kFileFormat, fmt::format("{} is broken", where));
    checked_num_bytes(where, grid.dims, grid.type->type);
    const Hdf5Extent extent{where, *grid.type, grid.dims};
    check_hdf5_storage(stored.get(), extent, source_);
    // Called as it was asked for: that is how it is looked for.
    DataArray array{options_.array.empty() ? grid.path.substr(1) : options_.array,
                    extent.type.type,
                    grid.dims.size() == 4 ? static_cast<int>(grid.dims[3]) : 1,
                    num_samples(dataset_.lattice.dims),
                    "",
                    false,
                    {}};
    array.unit = hdf5_text(stored.get(), "units").value_or("");
    scale(stored.get(), array);
    if (dataset_.arrays.empty()) place(stored.get(), grid.path);
    if (array.num_components == 1 &&
        stays_in_file(extent.type.type, extent.num_bytes(), options_)) {
      if (const auto at = place_of_hdf5_storage(opened_.get(), stored.get(), extent)) {
        array.stored = samples_told(*at);
        dataset_.arrays.push_back(std::move(array));
        return;
      }
    }
    std::byte* to = nullptr;
    array = new_array(std::move(array), to);
    read_hdf5_storage(stored.get(), extent, to, progress);
    dataset_.arrays.push_back(std::move(array));
  }

  // netCDF's words for what a stored number stands for.
  static void scale(hid_t stored, DataArray& array) {
    const std::vector<double> factor = hdf5_numbers(stored, "scale_factor", 1);
    const std::vector<double> offset = hdf5_numbers(stored, "add_offset", 1);
    if (factor.size() == 1 && std::isfinite(factor[0]) && factor[0] != 0)
      array.value_scale = factor[0];
    if (offset.size() == 1 && std::isfinite(offset[0])) array.value_offset = offset[0];
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
    place_by_coordinates(path);
  }

  // The places along an axis, from the dataset called like it beside the array: its first and their
  // distance, if they are even.
  std::optional<std::pair<double, double>> coordinates(const std::string& group,
                                                       std::size_t axis) const {
    static const std::array<std::vector<const char*>, 3> kNames{
        {{"x", "lon", "longitude"},
         {"y", "lat", "latitude"},
         {"z", "lev", "level", "depth", "height", "altitude"}}};
    const auto count = static_cast<std::size_t>(dataset_.lattice.dims[axis]);
    for (const char* const name : kNames[axis]) {
      const std::vector<double> places = file_.numbers(group, name);
      if (places.size() != count || count < 2) continue;
      const double step = (places.back() - places.front()) / static_cast<double>(count - 1);
      constexpr double kUneven = 1e-3;  // of a step; coordinates are often float32
      bool is_even = std::isfinite(step) && step != 0;
      for (std::size_t i = 0; is_even && i < count; ++i) {
        const double even = places[0] + static_cast<double>(i) * step;
        is_even = std::abs(places[i] - even) <= kUneven * std::abs(step);
      }
      if (is_even) return std::pair(places[0], step);
    }
    return std::nullopt;
  }

  void place_by_coordinates(const std::string& path) {
    const std::string group = path.substr(0, path.rfind('/'));
    Vec3 origin, spacing;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto found = coordinates(group, axis);
      if (!found) return;
      origin[static_cast<Eigen::Index>(axis)] = found->first;
      spacing[static_cast<Eigen::Index>(axis)] = found->second;
    }
    dataset_.lattice.world_from_index.linear() = spacing.asDiagonal();
    dataset_.lattice.world_from_index.translation() = origin;
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
