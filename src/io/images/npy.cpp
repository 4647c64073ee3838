// SPDX-License-Identifier: Apache-2.0
#include "io/images/npy.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <vector>

#include "io/core/atomic_file.h"
#include "io/core/axis_order.h"
#include "io/core/chunked_array.h"
#include "io/core/sample_parts.h"
#include "io/core/samples.h"
#include "io/core/short_floats.h"
#include "io/images/npy_header.h"
#include "io/points/npy_points.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Fortran order, first axis fastest, to C order, last axis fastest.
Bytes reverse_axes(SampleBuffer& samples, const std::vector<std::int64_t>& shape,
                   std::size_t item_size) {
  SampleBuffer result;
  const auto size = samples.size();
  const auto to = result.extend(size, size);
  const auto from = samples.bytes();
  // In memory the shape reads, slowest first, (c, x, y, z) and shall become (z, y, x, c): for every
  // (c, y), an x-z plane is transposed.
  const std::int64_t nz = shape[0], ny = shape[1], nx = shape[2],
                     nc = shape.size() == 4 ? shape[3] : 1;
  std::vector<std::byte> rows(static_cast<std::size_t>(nx * nz) * item_size);
  std::vector<std::byte> columns(rows.size());
  for (std::int64_t c = 0; c < nc; ++c) {
    for (std::int64_t y = 0; y < ny; ++y) {
      for (std::int64_t x = 0; x < nx; ++x) {
        std::memcpy(
            rows.data() + static_cast<std::size_t>(x * nz) * item_size,
            from.data() + static_cast<std::size_t>(((c * nx + x) * ny + y) * nz) * item_size,
            static_cast<std::size_t>(nz) * item_size);
      }
      transpose_items(rows.data(), columns.data(), nx, nz, item_size);
      for (std::int64_t z = 0; z < nz; ++z) {
        for (std::int64_t x = 0; x < nx; ++x) {
          std::memcpy(
              to.data() + static_cast<std::size_t>(((z * ny + y) * nx + x) * nc + c) * item_size,
              columns.data() + static_cast<std::size_t>(z * nx + x) * item_size, item_size);
        }
      }
    }
  }
  return result.release();
}

// (time, z, y, x), or (time, z, y, x, component)?
bool has_steps(const std::vector<std::int64_t>& shape) {
  return (shape.size() == 4 && !is_component_axis(shape[3])) ||
         (shape.size() == 5 && is_component_axis(shape[4]));
}

// One of the steps, which are read without the others.
Dataset read_npy_step(const ByteSource& source, const NpyHeader& header,
                      const ReadOptions& options) {
  const auto& shape = header.shape;
  const std::string text = fmt::format("({})", fmt::join(shape, ", "));
  const NpyType type = npy_type_of(source.name(), header.descr);
  if (header.is_fortran_order) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: shape {} in Fortran order: expected C order of data in time",
                            source.name(), text));
  }
  const std::int64_t num_bytes = checked_num_bytes(source.name() + ": shape", shape, type.type);
  check_num_steps(source.name() + ": shape", shape[0]);
  check_npy_size(source, header, type, num_bytes);
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "NPY";
  dataset.lattice.dims = {shape[3], shape[2], shape[1]};
  if (options.raw.spacing)
    dataset.lattice.world_from_index.linear() = options.raw.spacing->asDiagonal();
  check_geometry("spacing", dataset.lattice.world_from_index);
  StepLayout layout;
  layout.num_steps = shape[0];
  layout.num_bytes = num_bytes / shape[0];
  layout.type = type.type;
  layout.num_components = shape.size() == 5 ? static_cast<int>(shape[4]) : 1;
  layout.is_big_endian = type.is_big_endian;
  SampleParts parts;
  parts.each = {num_bytes, 0, type.type, source.name(), text};
  parts.open = [&source, &header](std::int64_t) {
    SamplePart part;
    part.source = &source;
    part.offset = header.data_offset;
    return part;
  };
  dataset.notes.push_back(
      shape.size() == 5
          ? fmt::format("{}: shape {} taken as (time, z, y, x, component)", source.name(), text)
          : fmt::format("{}: shape {} taken as (time, z, y, x): {} is no number of components, "
                        "which are 1 to 4, 6 or 9; --axis-order says another",
                        source.name(), text, shape[3]));
  if (auto note = type.note(source.name())) dataset.notes.push_back(std::move(*note));
  StepSamples samples = read_step(parts, layout, options, dataset.notes);
  dataset.num_steps = layout.num_steps;
  dataset.step = samples.step;
  dataset.arrays.push_back({"values", type.type, layout.num_components,
                            num_samples(dataset.lattice.dims), "", false, samples.bytes});
  dataset.arrays.back().stored = std::move(samples.stored);
  widen_short_floats(type.short_float, dataset.arrays.back());
  return dataset;
}

Dataset describe(const ByteSource& source, const NpyHeader& header, const ReadOptions& options) {
  const auto& shape = header.shape;
  const std::string text = fmt::format("({})", fmt::join(shape, ", "));
  if (shape.size() != 3 && shape.size() != 4) {
    throw Error(
        ErrorCode::kUnsupported,
        fmt::format("{}: shape: {}: expected (z, y, x), (z, y, x, component) with 1 to 4, 6 "
                    "or 9 components, (time, z, y, x) or (time, z, y, x, component), or "
                    "(N, 3) or (N, 4) for more than {} points",
                    source.name(), text, kMaxUnclearPoints));
  }
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "NPY";
  dataset.lattice.dims = {shape[2], shape[1], shape[0]};
  if (options.raw.spacing)
    dataset.lattice.world_from_index.linear() = options.raw.spacing->asDiagonal();
  check_geometry("spacing", dataset.lattice.world_from_index);
  if (shape.size() == 4) {
    dataset.notes.push_back(
        fmt::format("{}: shape {} taken as (z, y, x, component)", source.name(), text));
  }
  return dataset;
}

// Axes in the order that is asked for. Chunks are planes of the two that vary fastest.
Dataset read_npy_in_order(const ByteSource& source, const NpyHeader& header,
                          const ReadOptions& options) {
  const NpyType type = npy_type_of(source.name(), header.descr);
  ChunkedArray array;
  array.where = source.name();
  array.axes = options.raw.axis_order;
  array.shape = header.shape;
  array.type = type.type;
  array.short_float = type.short_float;
  array.is_big_endian = type.is_big_endian;
  array.is_first_fastest = header.is_fortran_order;
  check_axis_order(source.name(), array.axes, array.shape);
  check_npy_size(source, header, type,
                 checked_num_bytes(source.name() + ": shape", array.shape, type.type));
  const std::size_t rank = array.shape.size();
  array.chunk.assign(rank, 1);
  for (std::size_t i = 0; i < 2; ++i) {
    const std::size_t a = header.is_fortran_order ? i : rank - 1 - i;
    array.chunk[a] = array.shape[a];
  }
  check_chunked(array);
  // Samples that stay in the file keep it open.
  const std::shared_ptr<const ByteSource> own =
      options.may_stay_in_file ? open_file(source.name()) : nullptr;
  array.read = [&source, own, offset = header.data_offset, shape = array.shape, chunk = array.chunk,
                is_first_fastest = array.is_first_fastest](std::span<const std::int64_t> number,
                                                           std::span<std::byte> out) {
    std::int64_t plane = 0;  // its number
    for (std::size_t i = 0; i < shape.size(); ++i) {
      const std::size_t a = is_first_fastest ? shape.size() - 1 - i : i;
      if (chunk[a] == 1) plane = plane * shape[a] + number[a];
    }
    const auto size = static_cast<std::int64_t>(out.size());
    (own ? *own : source).read(offset + plane * size, out);
    return true;
  };
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "NPY";
  if (options.raw.spacing)
    dataset.lattice.world_from_index.linear() = options.raw.spacing->asDiagonal();
  check_geometry("spacing", dataset.lattice.world_from_index);
  if (auto note = type.note(source.name())) dataset.notes.push_back(std::move(*note));
  read_chunked({array}, options, dataset);
  return dataset;
}

}  // namespace

Dataset read_npy(const ByteSource& source, const ReadOptions& options) {
  const NpyHeader start = read_npy_header(source);
  if (!options.raw.axis_order.empty()) return read_npy_in_order(source, start, options);
  if (is_npy_of_points(start.shape)) return read_npy_points(source, options);
  if (has_steps(start.shape)) return read_npy_step(source, start, options);
  Dataset dataset = describe(source, start, options);
  NpySamples read = read_npy_samples(source, options);
  const NpyHeader& header = read.header;
  const NpyType& type = read.type;
  DataArray array{"values", type.type, 1, num_samples(dataset.lattice.dims), "", false, {}};
  if (header.shape.size() == 4) array.num_components = static_cast<int>(header.shape[3]);
  array.bytes = header.is_fortran_order
                    ? reverse_axes(read.samples, header.shape, size_of(type.type))
                    : read.samples.release();
  widen_short_floats(type.short_float, array);
  if (auto note = type.note(source.name())) dataset.notes.push_back(std::move(*note));
  dataset.arrays.push_back(std::move(array));
  return dataset;
}

std::string npy_header(ScalarType type, std::span<const std::int64_t> shape) {
  static constexpr const char* kCodes[] = {"u1", "i1", "u2", "i2", "u4",
                                           "i4", "u8", "i8", "f4", "f8"};
  static_assert(std::size(kCodes) == static_cast<std::size_t>(ScalarType::kFloat64) + 1);
  const char* const order = size_of(type) == 1                           ? "|"
                            : std::endian::native == std::endian::little ? "<"
                                                                         : ">";
  std::string dict = fmt::format("{{'descr': '{}{}', 'fortran_order': False, 'shape': ({}{}), }}",
                                 order, kCodes[static_cast<std::size_t>(type)],
                                 fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
  // Samples start at a multiple of 64 bytes.
  constexpr std::size_t kPrefix = 10;
  dict.append(63 - (kPrefix + dict.size()) % 64, ' ');
  dict += '\n';
  std::string result(kNpyMagic);
  result +=
      {'\x01', '\x00', static_cast<char>(dict.size() % 256), static_cast<char>(dict.size() / 256)};
  return result + dict;
}

void write_npy(const Index3& dims, const DataArray& array, const std::string& path,
               const std::stop_token& stop) {
  std::vector<std::int64_t> shape{dims[2], dims[1], dims[0]};
  if (array.num_components > 1) shape.push_back(array.num_components);
  AtomicFile file(path, stop);
  file.write(npy_header(array.type, shape));
  file.write(array.bytes.view.data(), array.bytes.view.size());
  file.commit();
}

}  // namespace ovoid::io
