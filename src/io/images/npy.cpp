// SPDX-License-Identifier: Apache-2.0
#include "io/images/npy.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "io/core/atomic_file.h"
#include "io/core/axis_order.h"
#include "io/core/chunked_array.h"
#include "io/core/samples.h"
#include "io/images/npy_header.h"
#include "io/points/npy_points.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

std::string shape_text(const NpyHeader& header) {
  return fmt::format("({})", fmt::join(header.shape, ", "));
}

// Chunks are runs of samples as they lie in the file, of about so many bytes.
constexpr std::int64_t kNpyChunkBytes = std::int64_t{1} << 20;

std::vector<std::int64_t> chunk_of(const NpyHeader& header, ScalarType type) {
  const std::size_t rank = header.shape.size();
  std::vector<std::int64_t> chunk(rank, 1);
  auto num_bytes = static_cast<std::int64_t>(size_of(type));
  for (std::size_t i = 0; i < rank; ++i) {
    const std::size_t a = header.is_fortran_order ? i : rank - 1 - i;
    chunk[a] = std::clamp<std::int64_t>(kNpyChunkBytes / num_bytes, 1, header.shape[a]);
    num_bytes *= chunk[a];
    if (chunk[a] < header.shape[a]) break;
  }
  return chunk;
}

}  // namespace

bool looks_like_npy(std::string_view start) noexcept { return start.starts_with(kNpyMagic); }

std::string npy_axes(const std::string& name, const NpyHeader& header, const ReadOptions& options) {
  if (!options.raw.axis_order.empty()) {
    std::string order = order_with_passed_axes(options.raw.axis_order, header.shape);
    check_axis_order(name, order, header.shape);
    return order;
  }
  const auto usual = usual_axis_order(header.shape);
  if (usual && header.shape.size() > 2) return *usual;
  throw Error(
      ErrorCode::kUnsupported,
      fmt::format(
          "{}: shape: {}: expected (z, y, x), (z, y, x, component) with 2 to 4, 6 or 9 "
          "components, (time, z, y, x) with components or without, or (time, channel, z, y, "
          "x), besides axes of one entry; or (N, 3) or (N, 4) for more than {} points; "
          "--axis-order, as tczyx or yx, says which axis is which",
          name, shape_text(header), kMaxUnclearPoints));
}

ChunkedArray npy_array(const std::shared_ptr<const ByteSource>& source, const NpyHeader& header,
                       const std::string& axes, std::vector<std::string>& notes) {
  const NpyType type = npy_type_of(source->name(), header.descr);
  ChunkedArray array;
  array.where = source->name();
  array.axes = axes;
  array.shape = header.shape;
  array.type = type.type;
  array.short_float = type.short_float;
  array.is_big_endian = type.is_big_endian;
  array.is_first_fastest = header.is_fortran_order;
  check_npy_size(*source, header, type,
                 checked_num_bytes(source->name() + ": shape", array.shape, type.type));
  array.chunk = chunk_of(header, type.type);
  check_chunked(array);
  array.read = [source, header, chunk = array.chunk, size = size_of(type.type)](
                   std::span<const std::int64_t> number, std::span<std::byte> out) {
    // The chunk's samples lie behind each other, from the first of them on.
    const std::size_t rank = chunk.size();
    std::int64_t first = 0, num_there = 1, stride = 1;
    for (std::size_t i = 0; i < rank; ++i) {
      const std::size_t a = header.is_fortran_order ? i : rank - 1 - i;
      const std::int64_t begin = number[a] * chunk[a];
      first += begin * stride;
      stride *= header.shape[a];
      num_there *= std::min(chunk[a], header.shape[a] - begin);
    }
    source->read(header.data_offset + first * static_cast<std::int64_t>(size),
                 out.first(static_cast<std::size_t>(num_there) * size));
    return true;
  };
  if (auto note = type.note(source->name())) notes.push_back(std::move(*note));
  return array;
}

Dataset read_npy(const ByteSource& source, const ReadOptions& options) {
  const NpyHeader header = read_npy_header(source);
  const bool has_order = !options.raw.axis_order.empty();
  if (!has_order && is_npy_of_points(header.shape)) return read_npy_points(source, options);
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "NPY";
  if (options.raw.spacing)
    dataset.lattice.world_from_index.linear() = options.raw.spacing->asDiagonal();
  check_geometry("spacing", dataset.lattice.world_from_index);
  const std::string axes = npy_axes(source.name(), header, options);
  if (!has_order && axes.size() > 3) {
    dataset.notes.push_back(fmt::format("{}: shape {} taken as {}; --axis-order says another",
                                        source.name(), shape_text(header), axis_names(axes)));
  }
  // Samples that stay in the file keep it open.
  const std::shared_ptr<const ByteSource> kept =
      options.may_stay_in_file
          ? std::shared_ptr<const ByteSource>(open_file(source.name()))
          : std::shared_ptr<const ByteSource>(&source, [](const ByteSource*) {});
  const ChunkedArray array = npy_array(kept, header, axes, dataset.notes);
  read_chunked({array}, options, dataset);
  return dataset;
}

std::string npy_header(ScalarType type, std::span<const std::int64_t> shape) {
  static constexpr const char* kCodes[] = {"u1", "i1", "u2", "i2", "u4",
                                           "i4", "u8", "i8", "f4", "f8"};
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
