// SPDX-License-Identifier: Apache-2.0
#include "io/images/nrrd.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "io/core/decode.h"
#include "io/core/length_units.h"
#include "io/core/sample_parts.h"
#include "io/core/samples.h"
#include "io/core/strided_step.h"
#include "io/core/text_scanner.h"
#include "io/images/data_files.h"
#include "io/images/nrrd_header.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

enum class AxisRole { kSpatial, kTime, kList, kComponents };

// What the header's axes are in a lattice.
struct VolumeAxes {
  std::vector<std::size_t> spatial;              // two or three, fastest first
  std::optional<std::size_t> components, steps;  // of more than one sample
  int num_components = 1;
  std::int64_t num_steps = 1;
};

bool has_no_kind(const NrrdAxis& axis) {
  return axis.kind.empty() || axis.kind == "???" || axis.kind == "none";
}

bool is_domain(const NrrdAxis& axis) { return axis.kind == "domain" || axis.kind == "space"; }

[[noreturn]] void throw_unsupported(const std::string& name, const std::string& what) {
  throw Error(ErrorCode::kUnsupported, fmt::format("{}: {}", name, what));
}

// In a space of four dimensions an axis lies in the first three, or along the fourth.
AxisRole role_of_direction(const std::string& name, const NrrdAxis& axis) {
  if (axis.fourth.value_or(0) == 0) return AxisRole::kSpatial;
  if (Eigen::Map<const Vec3>(axis.direction->data()).isZero(0)) return AxisRole::kTime;
  throw_unsupported(name,
                    "space directions: an axis is aslant on the fourth dimension: expected axes "
                    "in the first three, and perhaps one along the fourth");
}

AxisRole role_of(const std::string& name, NrrdHeader& header, std::size_t index) {
  const NrrdAxis& axis = header.axes[index];
  if (axis.direction) return role_of_direction(name, axis);
  if (axis.kind == "time") return AxisRole::kTime;
  // The layers of a segmentation are a list, too, and one data set.
  if (axis.kind == "list" && !header.is_segmentation) return AxisRole::kList;
  if (!has_no_kind(axis) && !is_domain(axis)) return AxisRole::kComponents;
  if (!header.has_directions) return AxisRole::kSpatial;
  // As programs order them: the values of a sample first, steps last.
  if (index == 0 || index + 1 < header.axes.size() || axis.size == 1) return AxisRole::kComponents;
  header.notes.push_back(
      fmt::format("{}: axis {} ({} samples) has neither direction nor kind: "
                  "taken as steps",
                  name, index, axis.size));
  return AxisRole::kList;
}

// The one axis of those; none of none.
std::optional<std::size_t> only_axis(const std::string& name, const NrrdHeader& header,
                                     const std::vector<std::size_t>& indices) {
  if (indices.empty()) return std::nullopt;
  if (indices.size() == 1) return indices[0];
  throw_unsupported(
      name,
      fmt::format("axes {} (kind '{}') and {} (kind '{}') of {} are both not spatial: expected "
                  "2 or 3 spatial axes, one of components and one of time or a list",
                  indices[0], header.axes[indices[0]].kind, indices[1],
                  header.axes[indices[1]].kind, header.axes.size()));
}

VolumeAxes find_axes(const std::string& name, NrrdHeader& header) {
  const bool is_told =
      header.has_directions || std::any_of(header.axes.begin(), header.axes.end(),
                                           [](const NrrdAxis& axis) { return !has_no_kind(axis); });
  if (header.axes.size() > 3 && !is_told) {
    throw_unsupported(
        name,
        fmt::format(
            "{} axes, and neither 'kinds' nor 'space directions' says which of them are spatial: "
            "expected 2 or 3 spatial axes, one of components and one of time or a list",
            header.axes.size()));
  }
  VolumeAxes result;
  std::vector<std::size_t> times, lists, components;
  for (std::size_t i = 0; i < header.axes.size(); ++i) {
    const AxisRole role = role_of(name, header, i);
    if (role == AxisRole::kSpatial) result.spatial.push_back(i);
    if (header.axes[i].size == 1) continue;
    if (role == AxisRole::kTime) times.push_back(i);
    if (role == AxisRole::kList) lists.push_back(i);
    if (role == AxisRole::kComponents) components.push_back(i);
  }
  // A list within data in time is one of components.
  if (!times.empty()) components.insert(components.end(), lists.begin(), lists.end());
  const bool is_fourth_of_space = result.spatial.size() == 4 && !header.has_directions &&
                                  is_domain(header.axes[result.spatial.back()]);
  if (is_fourth_of_space) {
    const std::size_t last = result.spatial.back();
    result.spatial.pop_back();
    if (header.axes[last].size > 1) times.push_back(last);
    header.notes.push_back(
        fmt::format("{}: has four spatial axes: axis {} is taken as steps", name, last));
  }
  result.components = only_axis(name, header, components);
  result.steps = only_axis(name, header, times.empty() ? lists : times);
  if (result.spatial.size() < 2 || result.spatial.size() > 3) {
    throw_unsupported(name,
                      fmt::format("has {} spatial axes: expected 2 or 3", result.spatial.size()));
  }
  if (result.components)
    result.num_components = static_cast<int>(header.axes[*result.components].size);
  if (result.steps) result.num_steps = header.axes[*result.steps].size;
  check_num_steps(name, result.num_steps);
  return result;
}

// Do a sample's components lie behind each other, and the steps?
bool are_in_order(const VolumeAxes& axes) {
  return (!axes.components || *axes.components < axes.spatial.front()) &&
         (!axes.steps || *axes.steps > axes.spatial.back());
}

// Step from sample to sample, and place of the first one, along an axis that has no direction.
std::pair<double, double> step_and_start(const NrrdAxis& axis) {
  double step = axis.spacing.value_or(1.0);
  if (!axis.spacing && axis.min && axis.max) {
    const auto intervals = static_cast<double>(
        axis.is_node_centered ? std::max<std::int64_t>(axis.size - 1, 1) : axis.size);
    step = (*axis.max - *axis.min) / intervals;
  }
  if (!axis.min) return {step, 0.0};
  return {step, axis.is_node_centered ? *axis.min : *axis.min + step / 2};
}

LatticeGeometry read_geometry(const std::string& name, NrrdHeader& header, const VolumeAxes& axes) {
  LatticeGeometry lattice;
  lattice.dims = {1, 1, 1};
  Mat3 linear = Mat3::Identity();
  Vec3 origin = Vec3::Zero();
  for (std::size_t i = 0; i < axes.spatial.size(); ++i) {
    const NrrdAxis& axis = header.axes[axes.spatial[i]];
    const auto column = static_cast<Eigen::Index>(i);
    lattice.dims[i] = axis.size;
    if (axis.direction) {
      linear.col(column) = Eigen::Map<const Vec3>(axis.direction->data());
    } else {
      const auto [step, start] = step_and_start(axis);
      linear.col(column) = Vec3::Unit(column) * step;
      origin[column] = start;
    }
    if (!axis.direction && axis.min && !axis.is_node_centered && !header.has_centers) {
      header.notes.push_back(fmt::format(
          "{}: 'axis mins' without 'centers': taken as the outer faces of the samples' cells",
          name));
    }
  }
  if (header.origin) origin = Eigen::Map<const Vec3>(header.origin->data());
  if (axes.spatial.size() == 2) complete_plane(linear);
  lattice.world_from_index.linear() = linear;
  lattice.world_from_index.translation() = origin;
  check_geometry(
      fmt::format("{}: {}", name, header.has_directions ? "space directions" : "spacings"),
      lattice.world_from_index);
  return lattice;
}

Space read_space(const std::string& name, NrrdHeader& header) {
  if (header.space.starts_with("left-posterior-superior")) return Space::kLps;
  if (header.space.starts_with("right-anterior-superior")) return Space::kRas;
  if (header.space.starts_with("3D-left-handed") ||
      header.space.starts_with("left-anterior-superior")) {
    header.notes.push_back(fmt::format(
        "{}: space '{}' is left-handed and kept as it is: patient space none", name, header.space));
  }
  return Space::kNone;
}

// The offset behind `count` lines from `offset`.
std::int64_t skip_lines(const std::string& header_name, const ByteSource& source,
                        std::int64_t offset, std::int64_t count) {
  constexpr std::int64_t kLineChunk = std::int64_t{1} << 16;
  for (std::int64_t skipped = 0; skipped < count;) {
    const std::string chunk = source.text(offset, kLineChunk);
    if (chunk.empty()) {
      throw Error(ErrorCode::kFileFormat, fmt::format("{}: line skip: {} lines, {} has only {}",
                                                      header_name, count, source.name(), skipped));
    }
    std::size_t position = 0;
    while (skipped < count) {
      const auto end = chunk.find('\n', position);
      if (end == std::string::npos) {
        position = chunk.size();
        break;
      }
      position = end + 1;
      ++skipped;
    }
    offset += static_cast<std::int64_t>(position);
  }
  return offset;
}

// Where the samples are. The result refers to all arguments.
SampleParts find_parts(const ByteSource& source, const NrrdHeader& header, const Opener& open,
                       std::int64_t num_bytes) {
  std::vector<std::int64_t> sizes;
  for (const NrrdAxis& axis : header.axes) sizes.push_back(axis.size);
  const std::string where = source.name() + ": data file";
  DataParts divided{1, num_bytes, layout_text(sizes, header.type)};
  if (header.files) divided = divide_samples(where, *header.files, sizes, header.type, num_bytes);
  // Of text, bytes are skipped as they stand in the file.
  const bool is_text = header.encoding == Encoding::kText || header.encoding == Encoding::kHex;
  SampleParts parts;
  parts.count = divided.count;
  parts.encoding = header.encoding;
  parts.each = {divided.num_bytes_each, is_text ? 0 : header.byte_skip, header.type, source.name(),
                divided.layout_each};
  parts.open = [&source, &header, &open, where, is_text](std::int64_t index) {
    SamplePart part;
    part.source = &source;
    part.offset = header.data_offset;
    if (header.files) {
      part.owned = open_data_file(source, where, header.files->name(index), open);
      part.source = part.owned.get();
      part.offset = 0;
    }
    part.offset = skip_lines(source.name(), *part.source, part.offset, header.line_skip);
    if (is_text) part.offset = std::min(part.offset + header.byte_skip, part.source->size());
    return part;
  };
  return parts;
}

// The value of a key of 3D Slicer's.
std::string key_of(const NrrdHeader& header, const std::string& key) {
  const auto found = header.sequence_keys.find(key);
  return found == header.sequence_keys.end() ? std::string() : found->second;
}

// What 3D Slicer says of the frames: of a sequence between blanks, of its older multivolumes
// between commas. Empty if it says nothing, or not a number for each.
std::vector<double> frame_times(const NrrdHeader& header, std::size_t axis) {
  std::string text = key_of(header, fmt::format("axis {} index values", axis));
  const std::string type = lower(key_of(header, fmt::format("axis {} index type", axis)));
  if (!type.empty() && type != "numeric" && type != "time") return {};
  if (text.empty()) text = key_of(header, "MultiVolume.FrameLabels");
  std::replace(text.begin(), text.end(), ',', ' ');
  std::vector<double> times;
  for (const std::string_view word : words(text)) {
    const auto time = parse_number<double>(word);
    if (!time) return {};
    times.push_back(*time);
  }
  return static_cast<std::int64_t>(times.size()) == header.axes[axis].size ? times
                                                                           : std::vector<double>();
}

// The times of the steps and their unit, where the header says them.
void read_times(const NrrdHeader& header, const VolumeAxes& axes, Dataset& dataset) {
  if (!axes.steps) return;
  const NrrdAxis& axis = header.axes[*axes.steps];
  std::vector<double> times = frame_times(header, *axes.steps);
  std::optional<std::pair<double, double>> even;  // step and start
  if (axis.direction) {
    even = {*axis.fourth, header.origin_fourth.value_or(0)};
  } else if (axis.kind == "time" && (axis.spacing || (axis.min && axis.max))) {
    even = step_and_start(axis);
  }
  if (times.empty() && even) {
    for (std::int64_t i = 0; i < axis.size; ++i)
      times.push_back(even->second + even->first * static_cast<double>(i));
  }
  if (times.empty()) return;
  const bool are_rising =
      std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) == times.end() &&
      std::all_of(times.begin(), times.end(), [](double time) { return std::isfinite(time); });
  if (!are_rising) {
    dataset.notes.push_back(
        fmt::format("{}: the times of its steps do not rise: steps are numbered", dataset.source));
    return;
  }
  dataset.times = std::move(times);
  dataset.time_unit = axis.unit;
  if (axis.direction && header.space_units.size() == 4) dataset.time_unit = header.space_units[3];
  if (dataset.time_unit.empty())
    dataset.time_unit = key_of(header, "MultiVolume.FrameIdentifyingDICOMTagUnits");
}

void tell(const NrrdHeader& header, const VolumeAxes& axes, Dataset& dataset) {
  const std::vector<std::string>& units = header.space_units;
  const std::string unit = plain_unit(
      header.has_directions && !units.empty() ? units[0] : header.axes[axes.spatial[0]].unit);
  if (!unit.empty() && unit != "mm" && unit != "???") {
    dataset.notes.push_back(
        fmt::format("{}: lengths are in {}, as the file has them", dataset.source, unit));
  }
  if (!header.has_turned_frame || !axes.components) return;
  const std::string& kind = header.axes[*axes.components].kind;
  if (kind.find("vector") != std::string::npos || kind.find("gradient") != std::string::npos ||
      kind.find("normal") != std::string::npos || kind.find("matrix") != std::string::npos) {
    dataset.notes.push_back(fmt::format(
        "{}: 'measurement frame' is not applied: vectors are as they are stored", dataset.source));
  }
}

// Samples whose components or steps are not where they are read fastest.
StridedLayout strided_layout(const NrrdHeader& header, const VolumeAxes& axes,
                             const StepLayout& layout) {
  StridedLayout result{{},
                       layout.type,
                       layout.num_components,
                       layout.num_steps,
                       layout.num_bytes,
                       layout.is_big_endian};
  const auto size = static_cast<std::int64_t>(size_of(layout.type));
  std::int64_t stride = size * layout.num_components;
  std::size_t next = 0;  // of the spatial axes
  for (std::size_t i = 0; i < header.axes.size(); ++i) {
    StridedLayout::Axis axis{header.axes[i].size, 0, axes.steps == i};
    if (axes.components == i) axis.to_stride = size;
    if (next < axes.spatial.size() && axes.spatial[next] == i) {
      axis.to_stride = stride;
      stride *= axis.count;
      ++next;
    }
    result.axes.push_back(axis);
  }
  return result;
}

bool is_big_endian(const std::string& name, NrrdHeader& header) {
  if (!header.is_big_endian && header.encoding != Encoding::kText && size_of(header.type) > 1) {
    header.notes.push_back(fmt::format("{}: no field 'endian' for {} samples: taken as little",
                                       name, name_of(header.type)));
  }
  return header.is_big_endian.value_or(false);
}

}  // namespace

Dataset read_nrrd(const ByteSource& source, const ReadOptions& options, const Opener& open) {
  NrrdHeader header = read_nrrd_header(source);
  const VolumeAxes axes = find_axes(source.name(), header);
  std::vector<std::int64_t> sizes;
  for (const NrrdAxis& axis : header.axes) sizes.push_back(axis.size);
  const std::int64_t num_bytes = checked_num_bytes(source.name() + ": sizes", sizes, header.type);

  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "NRRD";
  dataset.lattice = read_geometry(source.name(), header, axes);
  dataset.space = read_space(source.name(), header);
  DataArray array;
  array.name = header.content.empty() ? "values" : header.content;
  array.type = header.type;
  array.num_components = axes.num_components;
  array.num_tuples = num_samples(dataset.lattice.dims);
  array.unit = header.unit;
  StepLayout layout;
  layout.num_steps = axes.num_steps;
  layout.num_bytes = num_bytes / axes.num_steps;
  layout.type = header.type;
  layout.num_components = axes.num_components;
  layout.is_big_endian = is_big_endian(source.name(), header);
  const SampleParts parts = find_parts(source, header, open, num_bytes);
  StepSamples samples =
      are_in_order(axes)
          ? read_step(parts, layout, options, header.notes)
          : read_strided_step(parts, strided_layout(header, axes, layout), options, header.notes);
  array.bytes = std::move(samples.bytes);
  array.stored = std::move(samples.stored);
  dataset.num_steps = axes.num_steps;
  dataset.step = samples.step;
  dataset.arrays.push_back(std::move(array));
  read_times(header, axes, dataset);
  tell(header, axes, dataset);
  dataset.notes.insert(dataset.notes.begin(), header.notes.begin(), header.notes.end());
  shorten_notes(dataset.notes);
  return dataset;
}

}  // namespace ovoid::io
