// SPDX-License-Identifier: Apache-2.0
#include "io/images/nrrd.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "io/core/decode.h"
#include "io/core/sample_parts.h"
#include "io/core/samples.h"
#include "io/images/data_files.h"
#include "io/images/nrrd_header.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

enum class AxisRole { kSpatial, kTime, kComponents };

// What the header's axes are in a lattice.
struct VolumeAxes {
  std::vector<std::size_t> spatial;  // two or three, fastest first
  int num_components = 1;
  std::int64_t num_steps = 1;  // samples of the slowest axis, if that is time or a list
};

AxisRole role_of(const NrrdHeader& header, const NrrdAxis& axis) {
  if (header.has_directions) {
    if (axis.direction) return AxisRole::kSpatial;
  } else if (axis.kind.empty() || axis.kind == "domain" || axis.kind == "space" ||
             axis.kind == "???" || axis.kind == "none") {
    return AxisRole::kSpatial;
  }
  return axis.kind == "time" ? AxisRole::kTime : AxisRole::kComponents;
}

[[noreturn]] void throw_unsupported(const std::string& name, const std::string& what) {
  throw Error(ErrorCode::kUnsupported, fmt::format("{}: {}", name, what));
}

VolumeAxes find_axes(const std::string& name, const NrrdHeader& header) {
  const bool is_told =
      header.has_directions ||
      std::any_of(header.axes.begin(), header.axes.end(), [](const NrrdAxis& axis) {
        return !axis.kind.empty() && axis.kind != "???" && axis.kind != "none";
      });
  if (header.axes.size() > 3 && !is_told) {
    throw_unsupported(
        name,
        fmt::format(
            "{} axes, and neither 'kinds' nor 'space directions' says which of them are spatial: "
            "expected 2 or 3 spatial axes after at most one of components, and then perhaps time",
            header.axes.size()));
  }
  VolumeAxes result;
  for (std::size_t i = 0; i < header.axes.size(); ++i) {
    const NrrdAxis& axis = header.axes[i];
    const AxisRole role = role_of(header, axis);
    const bool is_slowest = i > 0 && i + 1 == header.axes.size();
    if (role == AxisRole::kSpatial) {
      result.spatial.push_back(i);
    } else if (is_slowest && (role == AxisRole::kTime || axis.kind == "list")) {
      result.num_steps = axis.size;
      check_num_steps(name, axis.size);
    } else if (axis.size > 1 && (i != 0 || role == AxisRole::kTime)) {
      throw_unsupported(
          name, fmt::format("axis {} of {} ({} samples, kind '{}') is not spatial: the first axis "
                            "may hold components, and the last may be time or a list",
                            i, header.axes.size(), axis.size, axis.kind));
    } else if (i == 0) {
      result.num_components = static_cast<int>(axis.size);
    }
  }
  if (result.spatial.size() < 2 || result.spatial.size() > 3) {
    throw_unsupported(name,
                      fmt::format("has {} spatial axes: expected 2 or 3", result.spatial.size()));
  }
  return result;
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

// Times of the steps, where the axis of time says them.
std::vector<double> step_times(const NrrdHeader& header, std::int64_t num_steps) {
  const NrrdAxis& axis = header.axes.back();
  std::vector<double> times;
  if (num_steps == 1 || axis.kind != "time" || (!axis.spacing && !(axis.min && axis.max)))
    return times;
  const auto [step, start] = step_and_start(axis);
  for (std::int64_t i = 0; i < num_steps; ++i)
    times.push_back(start + step * static_cast<double>(i));
  return times;
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
  StepSamples samples =
      read_step(find_parts(source, header, open, num_bytes), layout, options, header.notes);
  array.bytes = std::move(samples.bytes);
  array.stored = std::move(samples.stored);
  dataset.num_steps = axes.num_steps;
  dataset.step = samples.step;
  dataset.times = step_times(header, axes.num_steps);
  dataset.arrays.push_back(std::move(array));
  shorten_notes(header.notes);
  dataset.notes = std::move(header.notes);
  return dataset;
}

}  // namespace ovoid::io
