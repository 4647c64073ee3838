// SPDX-License-Identifier: Apache-2.0
// What microscopes' programs write: Imaris' files .ims [Imaris], and those of BigDataViewer
// [BigDataViewer], which Fiji's stitching and tracking use. Both have groups for resolutions, time
// points and channels, in another order.
#ifdef OVOID_IO_HDF5
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "data/names_text.h"
#include "data/shown_step.h"
#include "io/core/numbers.h"
#include "io/core/sample_parts.h"
#include "io/core/samples.h"
#include "io/foreign/hdf5_dialects.h"
#include "io/foreign/hdf5_volumes.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// The number that follows a word: "TimePoint 12", "t00012"; nothing for another text.
std::optional<std::int64_t> number_after(std::string_view text, std::string_view word) {
  if (!text.starts_with(word)) return std::nullopt;
  return exact_number<std::int64_t>(text.substr(word.size()));
}

// The parts of a path, without the empty one in front.
std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts;
  for (std::size_t at = 1; at <= path.size();) {
    const std::size_t end = std::min(path.find('/', at), path.size());
    parts.push_back(path.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

// One volume of a series: which resolution, time point and channel.
struct Stack {
  const Hdf5Dataset* dataset = nullptr;
  std::int64_t channel = 0;
};
using TimePoints = std::map<std::int64_t, std::vector<Stack>>;  // by their numbers
using Resolutions = std::map<std::int64_t, TimePoints>;         // 0 is the finest

bool is_stack(const Hdf5Dataset& dataset) {
  return dataset.type && dataset.dims.size() == 3 &&
         *std::min_element(dataset.dims.begin(), dataset.dims.end()) > 0;
}

// What both have in common.
class StackReader {
 public:
  StackReader(const Hdf5File& file, const ReadOptions& options, const char* format)
      : file_(file), options_(options) {
    dataset_.source = file.source().name();
    dataset_.format = format;
  }

 protected:
  using NameOf = std::function<std::string(std::int64_t channel)>;
  using SizesOf = std::function<std::vector<std::int64_t>(const Stack&)>;

  void note(const std::string& what) {
    dataset_.notes.push_back(fmt::format("{}: {}", dataset_.source, what));
  }

  // The one of options.block, or the finest.
  const TimePoints& choose(const Resolutions& resolutions, std::string_view word) {
    std::vector<std::string> names;
    for (const auto& [number, points] : resolutions) {
      names.push_back(fmt::format("{}{}", word, number));
      const auto& dims = points.begin()->second.front().dataset->dims;
      if (resolutions.size() > 1)
        dataset_.blocks.push_back(
            {names.back(), fmt::format("{}x{}x{} samples", dims[2], dims[1], dims[0])});
    }
    if (resolutions.size() > 1) dataset_.block = names.front();
    if (options_.block.empty() || resolutions.size() == 1) return resolutions.begin()->second;
    const auto asked = std::find(names.begin(), names.end(), options_.block);
    if (asked == names.end()) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: block '{}': no such resolution: it has {}", dataset_.source,
                              options_.block, data::names_text(names)));
    }
    dataset_.block = *asked;
    return std::next(resolutions.begin(), asked - names.begin())->second;
  }

  // The step of options, or the first that varies.
  Dataset read_step(const TimePoints& points, const NameOf& name_of, const SizesOf& sizes_of) {
    const auto num_steps = std::ssize(points);
    check_num_steps(dataset_.source, num_steps);
    dataset_.num_steps = num_steps;
    const auto read = [&](std::int64_t step) {
      return read_point(std::next(points.begin(), step)->second, step, name_of, sizes_of);
    };
    if (options_.step) check_step(dataset_.source, *options_.step, num_steps);
    if (options_.step || num_steps == 1) return read(options_.step.value_or(0));
    return data::shown_step(dataset_.source, num_steps, options_.array, read);
  }

  const Hdf5File& file_;
  const ReadOptions& options_;
  Dataset dataset_;

 private:
  Dataset read_point(const std::vector<Stack>& stacks, std::int64_t step, const NameOf& name_of,
                     const SizesOf& sizes_of) const {
    std::vector<Hdf5Volume> volumes;
    std::vector<std::string> names;
    for (const Stack& stack : stacks) {
      names.push_back(name_of(stack.channel));
      const bool is_asked =
          options_.array == names.back() || stack.dataset->path.ends_with("/" + options_.array);
      if (!options_.array.empty() && !is_asked) continue;
      volumes.push_back({stack.dataset, options_.array.empty() ? names.back() : options_.array,
                         "zyx", sizes_of(stack)});
    }
    if (volumes.empty()) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: array '{}': no such channel: it has {}", dataset_.source,
                              options_.array, data::names_text(names)));
    }
    if (!options_.array.empty()) volumes.resize(1);
    Dataset dataset = dataset_;
    const auto sizes_read = [](const Hdf5Volume& volume) {
      return volume.sizes.empty() ? volume.dataset->dims : volume.sizes;
    };
    for (const Hdf5Volume& volume : volumes) {
      if (sizes_read(volume) == sizes_read(volumes[0])) continue;
      dataset.notes.push_back(fmt::format(
          "{}: '{}' has {} samples, '{}' {}: channels of one size are read together, others by "
          "--array",
          dataset_.source, volume.dataset->path, dims_text(sizes_read(volume)),
          volumes[0].dataset->path, dims_text(sizes_read(volumes[0]))));
    }
    std::erase_if(volumes, [first = sizes_read(volumes[0]), &sizes_read](const Hdf5Volume& volume) {
      return sizes_read(volume) != first;
    });
    ReadOptions own = options_;
    own.step.reset();
    read_hdf5_volumes(file_, volumes, own, dataset);
    dataset.num_steps = dataset_.num_steps;
    dataset.step = step;
    return dataset;
  }
};

// --- Imaris -------------------------------------------------------------------------------------

class ImarisReader : public StackReader {
 public:
  ImarisReader(const Hdf5File& file, const ReadOptions& options)
      : StackReader(file, options, "HDF5 grid (Imaris)"),
        data_("/" + file.text("/", "DataSetDirectoryName").value_or("DataSet")),
        info_("/" + file.text("/", "DataSetInfoDirectoryName").value_or("DataSetInfo")) {}

  Dataset run() {
    for (const Hdf5Dataset& dataset : file_.datasets()) {
      if (!dataset.path.starts_with(data_ + "/") || dataset.name != "Data" || !is_stack(dataset))
        continue;
      const std::vector<std::string> parts = parts_of(dataset.path.substr(data_.size()));
      if (parts.size() != 4) continue;
      const auto level = number_after(parts[0], "ResolutionLevel "),
                 point = number_after(parts[1], "TimePoint "),
                 channel = number_after(parts[2], "Channel ");
      if (level && point && channel) resolutions_[*level][*point].push_back({&dataset, *channel});
    }
    if (resolutions_.empty()) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: is Imaris', but has no '{}/ResolutionLevel 0/TimePoint 0/"
                              "Channel 0/Data'",
                              dataset_.source, data_));
    }
    TimePoints points = choose(resolutions_, "ResolutionLevel ");
    for (auto& [number, stacks] : points)
      std::sort(stacks.begin(), stacks.end(),
                [](const Stack& a, const Stack& b) { return a.channel < b.channel; });
    set_times(points);
    Dataset dataset = read_step(
        points, [&](std::int64_t channel) { return channel_name(channel, points); },
        [&](const Stack& stack) { return image_sizes(stack); });
    place(dataset);
    return dataset;
  }

 private:
  std::optional<double> number(const std::string& object, const std::string& name) const {
    const auto text = file_.text(object, name);
    return text ? parse_real(*text) : std::nullopt;
  }

  // Unlike the dataset, the image ends where no whole chunk does.
  std::vector<std::int64_t> image_sizes(const Stack& stack) const {
    static constexpr std::array<const char*, 3> kNames{"ImageSizeZ", "ImageSizeY", "ImageSizeX"};
    std::vector<std::int64_t> sizes = stack.dataset->dims;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto told = number(stack.dataset->group, kNames[axis]);
      if (!told) continue;
      if (!(*told >= 1 && *told <= static_cast<double>(sizes[axis]) &&
            *told == std::floor(*told))) {
        throw Error(ErrorCode::kFileFormat,
                    fmt::format("{}: '{}': {} = {:g}: expected 1 to {}", dataset_.source,
                                stack.dataset->group, kNames[axis], *told, sizes[axis]));
      }
      sizes[axis] = static_cast<std::int64_t>(*told);
    }
    return sizes == stack.dataset->dims ? std::vector<std::int64_t>() : sizes;
  }

  // As people have called it, if no other is called so.
  std::string channel_name(std::int64_t channel, const TimePoints& points) const {
    const auto named = [&](std::int64_t number) {
      return file_.text(fmt::format("{}/Channel {}", info_, number), "Name").value_or("");
    };
    const std::string name = named(channel);
    const std::vector<Stack>& all = points.begin()->second;
    const auto count = std::count_if(
        all.begin(), all.end(), [&](const Stack& stack) { return named(stack.channel) == name; });
    const bool is_own = !name.empty() && name != "(name not specified)" && count == 1;
    return is_own ? name : fmt::format("Channel {}", channel);
  }

  // From one outer edge of the image to the other.
  void place(Dataset& dataset) const {
    const std::string image = info_ + "/Image";
    Vec3 lo, spacing;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto min = number(image, fmt::format("ExtMin{}", axis)),
                 max = number(image, fmt::format("ExtMax{}", axis));
      if (!min || !max || !(*min < *max)) {
        dataset.notes.push_back(
            fmt::format("{}: '{}' does not say ExtMin{} and ExtMax{}, from the "
                        "less to the greater: the spacing is 1",
                        dataset.source, image, axis, axis));
        return;
      }
      const auto a = static_cast<Eigen::Index>(axis);
      spacing[a] = (*max - *min) / static_cast<double>(dataset.lattice.dims[axis]);
      lo[a] = *min;
    }
    dataset.lattice.world_from_index.linear() = spacing.asDiagonal();
    dataset.lattice.world_from_index.translation() = lo + spacing / 2;
    check_geometry(dataset.source + ": extents", dataset.lattice.world_from_index);
    const auto unit = file_.text(image, "Unit");
    if (unit && !unit->empty() && *unit != "mm")
      dataset.notes.push_back(
          fmt::format("{}: lengths are in {}, as the file has them", dataset.source, *unit));
  }

  // "2017-05-03 10:24:00.500", as seconds since the first.
  static std::optional<double> seconds_of(const std::string& text) {
    constexpr std::string_view kForm = "0000-00-00 00:00:00";
    if (text.size() < kForm.size()) return std::nullopt;
    const auto part = [&](std::size_t at, std::size_t size) {
      return exact_number<int>(std::string_view(text).substr(at, size));
    };
    const auto year = part(0, 4), month = part(5, 2), day = part(8, 2), hour = part(11, 2),
               minute = part(14, 2);
    const auto second = parse_real(std::string_view(text).substr(17));
    if (!year || !month || !day || !hour || !minute || !second) return std::nullopt;
    const std::chrono::year_month_day date{std::chrono::year(*year),
                                           std::chrono::month(static_cast<unsigned>(*month)),
                                           std::chrono::day(static_cast<unsigned>(*day))};
    if (!date.ok()) return std::nullopt;
    const double days = static_cast<double>(std::chrono::sys_days(date).time_since_epoch().count());
    return ((days * 24 + *hour) * 60 + *minute) * 60 + *second;
  }

  void set_times(const TimePoints& points) {
    if (points.size() < 2) return;
    std::vector<double> times;
    for (const auto& [number, stacks] : points) {
      const auto text = file_.text(info_ + "/TimeInfo", fmt::format("TimePoint{}", number + 1));
      const auto time = text ? seconds_of(*text) : std::nullopt;
      if (!time) return;
      times.push_back(*time);
    }
    const double first = times.front();
    for (double& time : times) time -= first;
    // Some programs write one date for all.
    const auto later = [](double a, double b) { return !(a < b); };
    if (std::adjacent_find(times.begin(), times.end(), later) != times.end()) return;
    dataset_.times = std::move(times);
    dataset_.time_unit = "s";
  }

  std::string data_, info_;  // groups
  Resolutions resolutions_;
};

// --- BigDataViewer ------------------------------------------------------------------------------

// "/t00012/s03/0/cells": time point, setup, resolution.
struct CellsPath {
  std::int64_t point = 0, setup = 0, level = 0;
};

std::optional<CellsPath> cells_path(const Hdf5Dataset& dataset) {
  if (dataset.name != "cells" || !is_stack(dataset)) return std::nullopt;
  const std::vector<std::string> parts = parts_of(dataset.path);
  if (parts.size() != 4) return std::nullopt;
  const auto point = number_after(parts[0], "t"), setup = number_after(parts[1], "s"),
             level = number_after(parts[2], "");
  if (!point || !setup || !level) return std::nullopt;
  return CellsPath{*point, *setup, *level};
}

class BigDataViewerReader : public StackReader {
 public:
  BigDataViewerReader(const Hdf5File& file, const ReadOptions& options)
      : StackReader(file, options, "HDF5 grid (BigDataViewer)") {}

  std::optional<Dataset> run() {
    Resolutions resolutions;
    for (const Hdf5Dataset& dataset : file_.datasets())
      if (const auto path = cells_path(dataset))
        resolutions[path->level][path->point].push_back({&dataset, path->setup});
    if (resolutions.empty()) return std::nullopt;
    const TimePoints& points = choose(resolutions, "");
    const auto setup_name = [](std::int64_t setup) { return fmt::format("s{:02}", setup); };
    Dataset dataset =
        read_step(points, setup_name, [](const Stack&) { return std::vector<std::int64_t>(); });
    place(points.begin()->second.front().channel, dataset);
    // Its samples are unsigned, and kept in the type of signed ones.
    for (DataArray& array : dataset.arrays)
      if (array.type == ScalarType::kInt16) array.type = ScalarType::kUInt16;
    dataset.notes.push_back(fmt::format(
        "{}: setups (channels, angles, tiles) and where they lie stand in the XML file beside it, "
        "which is not read: distances are those of samples of the finest resolution; --spacing "
        "says others",
        dataset.source));
    return dataset;
  }

 private:
  // How many samples of the finest resolution one stands for: x, y, z.
  void place(std::int64_t setup, Dataset& dataset) const {
    const std::vector<double> all = file_.numbers(fmt::format("/s{:02}", setup), "resolutions");
    const auto level =
        dataset.block.empty() ? 0 : exact_number<std::int64_t>(dataset.block).value_or(0);
    const auto at = static_cast<std::size_t>(3 * level);
    if (at + 3 > all.size()) return;
    const Vec3 factors(all[at], all[at + 1], all[at + 2]);
    if (!(factors.minCoeff() > 0) || !factors.allFinite()) return;
    dataset.lattice.world_from_index.linear() = factors.asDiagonal();
    dataset.lattice.world_from_index.translation() = (factors - Vec3::Ones()) / 2;
  }
};

}  // namespace

std::optional<Dataset> read_imaris(const Hdf5File& file, const ReadOptions& options) {
  if (!file.text("/", "ImarisDataSet") && !file.text("/", "ImarisVersion")) return std::nullopt;
  return ImarisReader(file, options).run();
}

std::optional<Dataset> read_big_data_viewer(const Hdf5File& file, const ReadOptions& options) {
  return BigDataViewerReader(file, options).run();
}

}  // namespace ovoid::io
#endif
