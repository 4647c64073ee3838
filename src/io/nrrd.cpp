// SPDX-License-Identifier: Apache-2.0
#include "io/nrrd.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <filesystem>
#include <limits>
#include <utility>

#include "io/decode.h"
#include "io/nrrd_header.h"
#include "io/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

enum class AxisRole { kSpatial, kTime, kComponents };

// What the header's axes are in a lattice.
struct VolumeAxes {
  std::vector<std::size_t> spatial;  // two or three, fastest first
  int num_components = 1;
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
            "expected 2 or 3 spatial axes after at most one of components",
            header.axes.size()));
  }
  VolumeAxes result;
  for (std::size_t i = 0; i < header.axes.size(); ++i) {
    const NrrdAxis& axis = header.axes[i];
    const AxisRole role = role_of(header, axis);
    if (role == AxisRole::kSpatial) {
      result.spatial.push_back(i);
    } else if (axis.size > 1 && (i != 0 || role == AxisRole::kTime)) {
      throw_unsupported(
          name,
          fmt::format(
              "axis {} of {} ({} samples, kind '{}') is not spatial: only the first axis may be, "
              "and then holds components",
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

// The slice of a 2-D file gets a third axis normal to it, as long as the shorter of its own two.
void complete_plane(Mat3& axes) {
  const Vec3 normal = axes.col(0).stableNormalized().cross(axes.col(1).stableNormalized());
  axes.col(2) = normal * std::min(axes.col(0).stableNorm(), axes.col(1).stableNorm());
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

// How the samples are spread over files: every part holds the same number of bytes.
struct DataParts {
  std::int64_t count = 1;
  std::int64_t num_bytes_each = 0;
  std::string layout_each;
};

DataParts divide(const std::string& name, const NrrdHeader& header, std::int64_t num_bytes) {
  std::vector<std::int64_t> sizes;
  for (const NrrdAxis& axis : header.axes) sizes.push_back(axis.size);
  DataParts parts{1, num_bytes, layout_text(sizes, header.type)};
  if (!header.files) return parts;
  parts.count = header.files->count;
  const auto dimension = static_cast<int>(sizes.size());
  const int subdimension =
      header.files->subdimension.value_or(parts.count == 1 ? dimension : dimension - 1);
  if (subdimension == dimension) {
    // Slabs of equal thickness along the slowest axis.
    if (sizes.back() % parts.count != 0) {
      throw Error(
          ErrorCode::kFileFormat,
          fmt::format("{}: data file: {} files cannot share the {} slices of sizes {} evenly", name,
                      parts.count, sizes.back(), dims_text(sizes)));
    }
    sizes.back() /= parts.count;
  } else {
    const std::int64_t num_needed =
        *checked_product(std::span(sizes).subspan(static_cast<std::size_t>(subdimension)));
    if (num_needed != parts.count) {
      throw Error(
          ErrorCode::kFileFormat,
          fmt::format("{}: data file: names {} files, sizes {} with {} axes in each need {}", name,
                      parts.count, dims_text(sizes), subdimension, num_needed));
    }
    sizes.resize(static_cast<std::size_t>(subdimension));
  }
  parts.num_bytes_each = num_bytes / parts.count;
  parts.layout_each = layout_text(sizes, header.type);
  return parts;
}

// The offset behind `count` lines from `offset`.
std::int64_t skip_lines(const std::string& header_name, const ByteSource& source,
                        std::int64_t offset, std::int64_t count) {
  constexpr std::int64_t kChunk = std::int64_t{1} << 16;
  for (std::int64_t skipped = 0; skipped < count;) {
    const std::string chunk = source.text(offset, kChunk);
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

// Reads all parts of the data, one behind the other.
class DataReader {
 public:
  DataReader(const ByteSource& source, NrrdHeader& header, const Opener& open,
             const ReadOptions& options)
      : source_(source), header_(header), open_(open), options_(options) {}

  Bytes run(std::int64_t num_bytes) {
    const DataParts parts = divide(source_.name(), header_, num_bytes);
    wanted_.num_bytes = parts.num_bytes_each;
    wanted_.num_skipped = header_.byte_skip;
    wanted_.type = header_.type;
    wanted_.header = source_.name();
    wanted_.layout = parts.layout_each;
    // All parts are looked at before memory is taken for the first: a missing slice is found at
    // once.
    std::int64_t num_stored = 0;
    for (std::int64_t i = 0; i < parts.count; ++i) {
      visit(i, [&](const ByteSource& part, std::int64_t offset) {
        check_plausible(part, offset, header_.encoding, wanted_);
        num_stored += part.size() - offset;
      });
      if (options_.stop.stop_requested())
        throw Error(ErrorCode::kCancelled, "reading: stopped by the caller");
    }
    SampleBuffer samples;
    if (header_.encoding == Encoding::kRaw) samples.reserve(num_bytes);
    ReadProgress progress(options_, num_stored);
    for (std::int64_t i = 0; i < parts.count; ++i) {
      visit(i, [&](const ByteSource& part, std::int64_t offset) {
        append_decoded(part, offset, header_.encoding, wanted_, samples, progress, header_.notes);
      });
    }
    fix_byte_order(samples);
    return samples.release();
  }

 private:
  template <typename Visitor>
  void visit(std::int64_t index, const Visitor& visitor) {
    if (!header_.files) {
      visitor(source_, skip_lines(source_.name(), source_, header_.data_offset, header_.line_skip));
      return;
    }
    const auto part = open_beside(header_.files->name(index));
    visitor(*part, skip_lines(source_.name(), *part, 0, header_.line_skip));
  }

  std::unique_ptr<ByteSource> open_beside(const std::string& name) const {
    const std::string path = path_beside(source_.name(), name);
    if (path == std::filesystem::path(source_.name()).lexically_normal()) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: data file: '{}': is the header itself", source_.name(), name));
    }
    try {
      return open_(path);
    } catch (const Error& error) {
      throw Error(error.code(), fmt::format("{}: data file: {}", source_.name(), error.what()));
    }
  }

  void fix_byte_order(SampleBuffer& samples) {
    const std::size_t sample_size = size_of(header_.type);
    if (header_.encoding == Encoding::kText || sample_size == 1) return;
    if (!header_.is_big_endian) {
      header_.notes.push_back(fmt::format("{}: no field 'endian' for {} samples: taken as little",
                                          source_.name(), name_of(header_.type)));
    }
    const bool is_native_big = std::endian::native == std::endian::big;
    if (header_.is_big_endian.value_or(false) != is_native_big)
      swap_bytes(samples.bytes(), sample_size);
  }

  const ByteSource& source_;
  NrrdHeader& header_;
  const Opener& open_;
  const ReadOptions& options_;
  WantedSamples wanted_;
};

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
  array.bytes = DataReader(source, header, open, options).run(num_bytes);
  dataset.arrays.push_back(std::move(array));
  shorten_notes(header.notes);
  dataset.notes = std::move(header.notes);
  return dataset;
}

}  // namespace ovoid::io
