// SPDX-License-Identifier: Apache-2.0
#include "io/images/metaimage.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "io/core/decode.h"
#include "io/core/sample_parts.h"
#include "io/core/samples.h"
#include "io/images/data_files.h"
#include "io/images/metaimage_header.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Time must not lean into space, nor space into time.
void check_time_axis(const std::string& name, const MetaImageHeader& header) {
  constexpr std::size_t kTime = 3;
  if (header.sizes.size() <= kTime) return;
  for (std::size_t i = 0; i < kTime; ++i) {
    if (header.directions[4 * i + kTime] == 0 && header.directions[4 * kTime + i] == 0) continue;
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: TransformMatrix: the fourth axis is not apart from the others: "
                            "expected time",
                            name));
  }
}

LatticeGeometry read_lattice(const std::string& name, const MetaImageHeader& header) {
  LatticeGeometry lattice;
  lattice.dims = {1, 1, 1};
  Mat3 linear = Mat3::Identity();
  Vec3 origin = Vec3::Zero();
  const std::size_t num_axes = header.sizes.size();
  const std::size_t num_spatial = std::min<std::size_t>(num_axes, 3);
  for (std::size_t axis = 0; axis < num_spatial; ++axis) {
    const auto column = static_cast<Eigen::Index>(axis);
    lattice.dims[axis] = header.sizes[axis];
    origin[column] = header.offset[axis];
    linear.col(column).setZero();
    for (std::size_t i = 0; i < num_spatial; ++i) {
      linear(static_cast<Eigen::Index>(i), column) =
          header.directions[axis * num_axes + i] * header.spacing[axis];
    }
  }
  if (num_spatial == 2) complete_plane(linear);
  lattice.world_from_index.linear() = linear;
  lattice.world_from_index.translation() = origin;
  check_geometry(name + ": TransformMatrix or ElementSpacing", lattice.world_from_index);
  return lattice;
}

// Where the samples are. The result refers to all arguments.
SampleParts find_parts(const ByteSource& source, const MetaImageHeader& header, const Opener& open,
                       std::int64_t num_bytes) {
  const std::string where = source.name() + ": ElementDataFile";
  std::vector<std::int64_t> sizes = header.sizes;
  DataParts divided{1, num_bytes, layout_text(sizes, header.type, header.num_channels)};
  if (header.files) {
    divided = divide_samples(where, *header.files, sizes, header.type, num_bytes);
    if (header.num_channels > 1) divided.layout_each += fmt::format(" x {}", header.num_channels);
  }
  SampleParts parts;
  parts.count = divided.count;
  parts.encoding = !header.is_binary      ? Encoding::kText
                   : header.is_compressed ? Encoding::kGzip
                                          : Encoding::kRaw;
  parts.each = {divided.num_bytes_each, header.header_size < 0 ? -1 : 0, header.type, source.name(),
                divided.layout_each};
  parts.open = [&source, &header, &open, where](std::int64_t index) {
    SamplePart part;
    part.source = &source;
    part.offset = header.data_offset;
    if (header.files) {
      part.owned = open_data_file(source, where, header.files->name(index), open);
      part.source = part.owned.get();
      part.offset = std::max<std::int64_t>(0, header.header_size);
    }
    part.offset = std::min(part.offset, part.source->size());
    if (header.files && header.files->count > 1) return part;
    if (header.compressed_size > part.source->size() - part.offset) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: CompressedDataSize: {} bytes, {} holds {}", source.name(),
                              header.compressed_size, part.source->name(),
                              part.source->size() - part.offset));
    }
    return part;
  };
  return parts;
}

bool is_big_endian(const std::string& name, MetaImageHeader& header) {
  if (!header.is_big_endian && header.is_binary && size_of(header.type) > 1) {
    header.notes.push_back(
        fmt::format("{}: no field 'BinaryDataByteOrderMSB' for {} samples: taken as little", name,
                    name_of(header.type)));
  }
  return header.is_big_endian.value_or(false);
}

}  // namespace

Dataset read_metaimage(const ByteSource& source, const ReadOptions& options, const Opener& open) {
  const std::string& name = source.name();
  MetaImageHeader header = read_metaimage_header(source);
  check_time_axis(name, header);
  const std::int64_t num_bytes =
      checked_num_bytes(name + ": DimSize", header.sizes, header.type, header.num_channels);
  Dataset dataset;
  dataset.source = name;
  dataset.format = "MetaImage";
  dataset.lattice = read_lattice(name, header);
  dataset.space = Space::kLps;
  dataset.num_steps = header.sizes.size() > 3 ? header.sizes[3] : 1;
  check_num_steps(name + ": DimSize", dataset.num_steps);

  DataArray array;
  array.name = header.name.empty() ? "values" : header.name;
  array.type = header.type;
  array.num_components = header.num_channels;
  array.num_tuples = num_samples(dataset.lattice.dims);
  array.value_scale = header.value_scale;
  array.value_offset = header.value_offset;
  StepLayout layout;
  layout.num_steps = dataset.num_steps;
  layout.num_bytes = num_bytes / dataset.num_steps;
  layout.type = header.type;
  layout.num_components = header.num_channels;
  layout.is_big_endian = is_big_endian(name, header);
  StepSamples samples =
      read_step(find_parts(source, header, open, num_bytes), layout, options, header.notes);
  array.bytes = std::move(samples.bytes);
  array.stored = std::move(samples.stored);
  dataset.step = samples.step;
  for (std::int64_t i = 0; dataset.num_steps > 1 && i < dataset.num_steps; ++i)
    dataset.times.push_back(header.offset[3] + header.spacing[3] * static_cast<double>(i));
  dataset.arrays.push_back(std::move(array));
  shorten_notes(header.notes);
  dataset.notes = std::move(header.notes);
  return dataset;
}

}  // namespace ovoid::io
