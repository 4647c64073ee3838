// SPDX-License-Identifier: Apache-2.0
#include "io/images/nifti.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "io/core/sample_parts.h"
#include "io/core/samples.h"
#include "io/images/nifti_header.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

NiftiHeader read_header(const ByteSource& source, Encoding encoding) {
  constexpr std::size_t kSize = kNifti2Size;
  return parse_nifti_header(source.name(), encoding == Encoding::kGzip ? gzip_start(source, kSize)
                                                                       : source.text(0, kSize));
}

// Step along an axis; where the file states none that could be one, 1.
double step_along(const NiftiHeader& header, std::size_t axis) {
  const double step = std::abs(header.pixdim[axis + 1]);
  return step > 0 && std::isfinite(step) ? step : 1.0;
}

// Spacing alone, the first sample at the origin: the format's method 1.
Affine3 spacing_transform(const NiftiHeader& header) {
  Affine3 transform = Affine3::Identity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    transform.linear()(i, i) = step_along(header, axis);
  }
  return transform;
}

// Rotation, spacing and offset: method 2.
Affine3 qform_transform(const NiftiHeader& header) {
  Vec3 v(header.quaternion.data());  // b c d
  double a = 1.0 - v.squaredNorm();
  // Rounded to float32, half a turn may come out longer than 1.
  constexpr double kSmallest = 1e-7;
  if (a < kSmallest) {
    v /= v.stableNorm();
    a = 0;
  } else {
    a = std::sqrt(a);
  }
  Affine3 transform = spacing_transform(header);
  Mat3 rotation = Eigen::Quaterniond(a, v[0], v[1], v[2]).toRotationMatrix();
  if (header.pixdim[0] < 0) rotation.col(2) *= -1;
  transform.linear() = rotation * transform.linear();
  transform.translation() = Vec3(header.qform_offset.data());
  return transform;
}

// Any affine map: method 3.
Affine3 sform_transform(const NiftiHeader& header) {
  Affine3 transform = Affine3::Identity();
  Mat3 linear;
  for (std::size_t row = 0; row < 3; ++row) {
    const auto i = static_cast<Eigen::Index>(row);
    linear.row(i) = Eigen::Map<const Eigen::RowVector3d>(header.sform[row].data());
    transform.translation()[i] = header.sform[row][3];
  }
  // A single slice need not say what lies behind it.
  if (header.dims[2] == 1 && linear.col(2).isZero(0)) complete_plane(linear);
  transform.linear() = linear;
  return transform;
}

bool is_usable(const Affine3& transform) {
  try {
    check_geometry("", transform);
    return true;
  } catch (const Error&) {
    return false;
  }
}

// How far the same sample lies apart in two transforms, at most: at a corner.
double distance(const Affine3& a, const Affine3& b, const Index3& dims) {
  double greatest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 index = Vec3::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      if ((corner >> axis & 1) != 0)
        index[axis] = static_cast<double>(dims[static_cast<std::size_t>(axis)] - 1);
    }
    greatest = std::max(greatest, (a * index - b * index).stableNorm());
  }
  return greatest;
}

// The best of the transforms that the header has.
void place(const NiftiHeader& header, Dataset& dataset) {
  const std::string& name = dataset.source;
  const auto usable = [&](int code, const char* form, const Affine3& transform) {
    if (code <= 0) return false;
    if (is_usable(transform)) return true;
    dataset.notes.push_back(
        fmt::format("{}: {} is degenerate or not finite and is not used", name, form));
    return false;
  };
  const Affine3 sform = sform_transform(header);
  const Affine3 qform = qform_transform(header);
  const bool has_sform = usable(header.sform_code, "sform", sform);
  const bool has_qform = usable(header.qform_code, "qform", qform);
  LatticeGeometry& lattice = dataset.lattice;
  lattice.world_from_index = has_sform ? sform : has_qform ? qform : spacing_transform(header);
  dataset.space = has_sform || has_qform ? Space::kRas : Space::kNone;
  if (!has_sform || !has_qform) return;
  // Both are rounded to float32, and the rotation once more when the quaternion was made.
  constexpr double kSame = 0.01;
  const double apart = distance(sform, qform, lattice.dims);
  if (apart > kSame * lattice.spacing().minCoeff()) {
    dataset.notes.push_back(fmt::format(
        "{}: sform and qform place samples up to {:.3g} apart: sform is taken", name, apart));
  }
}

void note_unit(const NiftiHeader& header, Dataset& dataset) {
  const int unit = header.units & 7;
  if (unit != 1 && unit != 3) return;
  dataset.notes.push_back(fmt::format("{}: lengths are in {}, as the file has them", dataset.source,
                                      unit == 1 ? "metres" : "micrometres"));
}

// In seconds where the file names a unit of time, else as it counts them; none if the fourth axis
// is something else.
std::vector<double> step_times(const NiftiHeader& header) {
  double seconds = 1;
  switch (header.units & 0x38) {
    case 0:
    case 8:
      break;
    case 16:
      seconds = 1e-3;
      break;
    case 24:
      seconds = 1e-6;
      break;
    default:
      return {};
  }
  const double step = header.pixdim[4];
  std::vector<double> times;
  if (header.dims[3] == 1 || !(step > 0) || !std::isfinite(step) ||
      !std::isfinite(header.time_offset))
    return times;
  for (std::int64_t i = 0; i < header.dims[3]; ++i)
    times.push_back(seconds * (header.time_offset + step * static_cast<double>(i)));
  if (!std::isfinite(times.back())) times.clear();
  return times;
}

void read_scale(const NiftiHeader& header, Dataset& dataset, DataArray& array) {
  if (header.slope == 0 || header.num_channels > 1) return;
  if (!std::isfinite(header.slope) || !std::isfinite(header.intercept)) {
    dataset.notes.push_back(fmt::format("{}: scl_slope {} and scl_inter {} are not used",
                                        dataset.source, header.slope, header.intercept));
    return;
  }
  array.value_scale = header.slope;
  array.value_offset = header.intercept;
}

// The samples' file of a pair, compressed or not.
std::unique_ptr<ByteSource> open_image(const std::string& header_name, const Opener& open) {
  const std::string path = nifti_image_path(header_name);
  if (path == header_name) {
    throw Error(
        ErrorCode::kFileFormat,
        fmt::format("{}: is the header of a pair: expected a name that ends in .hdr", header_name));
  }
  for (const std::string& candidate : {path, path + ".gz"}) {
    try {
      return open(candidate);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kFileNotFound)
        throw Error(error.code(), fmt::format("{}: {}", header_name, error.what()));
    }
  }
  throw Error(ErrorCode::kFileNotFound,
              fmt::format("{}: its samples are in {} or {}.gz: neither can be opened", header_name,
                          path, path));
}

SampleParts find_parts(const ByteSource& source, Encoding encoding, const NiftiHeader& header,
                       const Opener& open, std::int64_t num_bytes, const std::string& layout) {
  SampleParts parts;
  parts.encoding = encoding;
  parts.each = {num_bytes, header.vox_offset, header.type, source.name(), layout};
  if (header.is_pair) {
    const std::string start = open_image(source.name(), open)->text(0, 2);
    parts.encoding = start == "\x1f\x8b" ? Encoding::kGzip : Encoding::kRaw;
  }
  parts.open = [&source, &open, is_pair = header.is_pair](std::int64_t) {
    SamplePart part;
    part.source = &source;
    if (is_pair) {
      part.owned = open_image(source.name(), open);
      part.source = part.owned.get();
    }
    return part;
  };
  return parts;
}

int count_components(const std::string& name, const NiftiHeader& header) {
  constexpr std::int64_t kMost = 1'000'000;
  const std::int64_t count = header.dims[4];
  if (count > kMost || (count > 1 && header.num_channels > 1)) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: dim[5] = {}: expected at most {} components", name, count,
                            header.num_channels > 1 ? 1 : kMost));
  }
  return static_cast<int>(count) * header.num_channels;
}

}  // namespace

std::string nifti_image_path(const std::string& header_path) {
  std::string path = header_path;
  if (path.ends_with(".gz")) path.resize(path.size() - 3);
  const bool is_upper = path.ends_with(".HDR");
  if (!is_upper && !path.ends_with(".hdr")) return header_path;
  return path.substr(0, path.size() - 4) + (is_upper ? ".IMG" : ".img");
}

Dataset read_nifti(const ByteSource& source, Encoding encoding, const ReadOptions& options,
                   const Opener& open) {
  const std::string& name = source.name();
  const NiftiHeader header = read_header(source, encoding);
  Dataset dataset;
  dataset.source = name;
  dataset.format = fmt::format("NIfTI-{}", header.version);
  const int num_components = count_components(name, header);
  const auto sizes = std::span(header.dims).first(4);
  const std::int64_t num_bytes =
      checked_num_bytes(name + ": dim", sizes, header.type, num_components);
  dataset.lattice.dims = {header.dims[0], header.dims[1], header.dims[2]};
  place(header, dataset);
  check_geometry(name + ": pixdim", dataset.lattice.world_from_index);
  note_unit(header, dataset);
  check_num_steps(name + ": dim[4]", header.dims[3]);

  DataArray array;
  array.name = header.intent_name.empty() ? "values" : header.intent_name;
  array.type = header.type;
  array.num_components = num_components;
  array.num_tuples = num_samples(dataset.lattice.dims);
  read_scale(header, dataset, array);
  StepLayout layout;
  layout.num_steps = header.dims[3];
  layout.num_bytes = num_bytes / layout.num_steps;
  layout.type = header.type;
  layout.num_components = array.num_components;
  layout.order =
      header.num_channels > 1 ? StepLayout::Order::kInterleaved : StepLayout::Order::kPlanar;
  layout.is_big_endian = header.is_big_endian;
  const std::string text =
      layout_text(sizes.first(layout.num_steps > 1 ? 4 : 3), header.type, array.num_components);
  StepSamples samples = read_step(find_parts(source, encoding, header, open, num_bytes, text),
                                  layout, options, dataset.notes);
  array.bytes = std::move(samples.bytes);
  array.stored = std::move(samples.stored);
  dataset.num_steps = layout.num_steps;
  dataset.step = samples.step;
  dataset.times = step_times(header);
  dataset.arrays.push_back(std::move(array));
  return dataset;
}

}  // namespace ovoid::io
