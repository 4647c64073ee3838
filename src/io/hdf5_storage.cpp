// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/hdf5_storage.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <span>

#include "io/decompressors.h"
#include "io/hdf5_file.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kChecksumSize = 4;

[[noreturn]] void fail_storage(const Hdf5Extent& extent, const std::string& what,
                               ErrorCode code = ErrorCode::kFileFormat) {
  throw Error(code, fmt::format("{}: {}", extent.where, what));
}

// How a dataset in chunks lies in the file.
struct ChunkLayout {
  std::array<std::int64_t, 2> size{1, 1};   // rows and columns of a chunk
  std::array<std::int64_t, 2> count{1, 1};  // of chunks, along each
  std::int64_t num_bytes = 0;               // of a chunk, unpacked
  std::vector<H5Z_filter_t> filters;        // as they are applied on writing
};

ChunkLayout chunk_layout(hid_t plist, const Hdf5Extent& extent) {
  ChunkLayout layout;
  std::array<hsize_t, H5S_MAX_RANK> chunk{};
  if (H5Pget_chunk(plist, H5S_MAX_RANK, chunk.data()) != extent.rank)
    fail_storage(extent, "its chunks have another number of axes");
  const std::array<std::int64_t, 2> dims{extent.rows, extent.columns};
  double num_bytes = static_cast<double>(extent.item_size());
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(extent.rank); ++axis) {
    if (chunk[axis] < 1 || chunk[axis] > static_cast<hsize_t>(kMaxAxisSize))
      fail_storage(extent, fmt::format("has chunks of {} along axis {}", chunk[axis], axis));
    layout.size[axis] = static_cast<std::int64_t>(chunk[axis]);
    layout.count[axis] = (dims[axis] + layout.size[axis] - 1) / layout.size[axis];
    num_bytes *= static_cast<double>(chunk[axis]);
  }
  if (num_bytes > static_cast<double>(kMaxNumBytes)) fail_storage(extent, "has chunks without end");
  layout.num_bytes = layout.size[0] * layout.size[1] * extent.item_size();
  const int num_filters = std::max(0, H5Pget_nfilters(plist));
  for (int i = 0; i < num_filters; ++i) {
    unsigned flags = 0, config = 0;
    std::size_t num_values = 0;
    char name[64] = "";
    const H5Z_filter_t filter = H5Pget_filter2(plist, static_cast<unsigned>(i), &flags, &num_values,
                                               nullptr, sizeof(name), name, &config);
    if (filter != H5Z_FILTER_DEFLATE && filter != H5Z_FILTER_SHUFFLE &&
        filter != H5Z_FILTER_FLETCHER32) {
      name[sizeof(name) - 1] = '\0';
      fail_storage(extent,
                   fmt::format("is compressed by filter {} ({}): expected deflate, shuffle or "
                               "fletcher32: repack it with h5repack -f GZIP=4",
                               filter, name),
                   ErrorCode::kUnsupported);
    }
    layout.filters.push_back(filter);
  }
  return layout;
}

std::int64_t contiguous_offset(hid_t dataset, const Hdf5Extent& extent, const ByteSource& source) {
  const haddr_t offset = H5Dget_offset(dataset);
  if (offset == HADDR_UNDEF) fail_storage(extent, "was never written", ErrorCode::kUnsupported);
  if (offset > static_cast<haddr_t>(source.size()) ||
      extent.num_bytes() > source.size() - static_cast<std::int64_t>(offset)) {
    fail_storage(extent, fmt::format("claims {} bytes at byte {}, more than a file of {} bytes can "
                                     "hold",
                                     extent.num_bytes(), offset, source.size()));
  }
  return static_cast<std::int64_t>(offset);
}

// zlib data; at most `most` bytes come of them.
std::vector<std::byte> inflate_chunk(const Hdf5Extent& extent, std::vector<std::byte>& packed,
                                     std::int64_t most) {
  // Not what the header claims, but what the bytes can become.
  const auto possible = static_cast<std::int64_t>(packed.size()) * kMaxDeflateRatio + 64;
  std::vector<std::byte> out(static_cast<std::size_t>(std::min(most, possible)) + 1);
  Inflater inflater;
  inflater.stream.next_in = reinterpret_cast<Bytef*>(packed.data());
  inflater.stream.avail_in = static_cast<uInt>(packed.size());
  inflater.stream.next_out = reinterpret_cast<Bytef*>(out.data());
  inflater.stream.avail_out = static_cast<uInt>(out.size());
  const std::string problem = inflater.step();
  if (!problem.empty() || !inflater.ended) {
    fail_storage(extent, fmt::format("a chunk is broken: {}",
                                     problem.empty() ? "it ends too early" : problem));
  }
  out.resize(out.size() - inflater.stream.avail_out);
  return out;
}

// The first bytes of all items lie together, then the second ones, and so on.
std::vector<std::byte> unshuffle(const std::vector<std::byte>& bytes, std::size_t item_size) {
  std::vector<std::byte> out = bytes;  // what is left of the last item stays in place
  const std::size_t count = bytes.size() / item_size;
  for (std::size_t b = 0; b < item_size; ++b)
    for (std::size_t i = 0; i < count; ++i) out[i * item_size + b] = bytes[b * count + i];
  return out;
}

// Undoes the filters, the last one first.
void unfilter(const Hdf5Extent& extent, const ChunkLayout& layout, unsigned skipped,
              std::vector<std::byte>& bytes) {
  for (std::size_t i = layout.filters.size(); i-- > 0;) {
    if (i < 32 && (skipped >> i & 1U) != 0) continue;
    if (layout.filters[i] == H5Z_FILTER_FLETCHER32) {
      bytes.resize(bytes.size() - std::min<std::size_t>(bytes.size(), kChecksumSize));
    } else if (layout.filters[i] == H5Z_FILTER_SHUFFLE) {
      bytes = unshuffle(bytes, static_cast<std::size_t>(extent.item_size()));
    } else {
      const auto num_checksums = static_cast<std::int64_t>(layout.filters.size());
      bytes = inflate_chunk(extent, bytes, layout.num_bytes + num_checksums * kChecksumSize);
    }
  }
  if (static_cast<std::int64_t>(bytes.size()) != layout.num_bytes) {
    fail_storage(extent,
                 fmt::format("a chunk has {} bytes: expected {}", bytes.size(), layout.num_bytes));
  }
}

// A chunk into its place among the rows; what of it lies outside the dataset is left out.
void place_chunk(const Hdf5Extent& extent, const ChunkLayout& layout,
                 const std::array<std::int64_t, 2>& first, const std::vector<std::byte>& bytes,
                 std::byte* to) {
  const std::int64_t item = extent.item_size();
  const std::int64_t rows = std::min(layout.size[0], extent.rows - first[0]);
  const std::int64_t columns = std::min(layout.size[1], extent.columns - first[1]);
  for (std::int64_t row = 0; row < rows; ++row) {
    std::memcpy(to + ((first[0] + row) * extent.columns + first[1]) * item,
                bytes.data() + row * layout.size[1] * item,
                static_cast<std::size_t>(columns * item));
  }
}

void read_chunks(hid_t dataset, const Hdf5Extent& extent, const ByteSource& source, std::byte* to,
                 ReadProgress& progress) {
  const Hdf5Handle plist(H5Dget_create_plist(dataset), H5Pclose);
  const ChunkLayout layout = chunk_layout(plist.get(), extent);
  std::vector<std::byte> bytes;
  for (std::int64_t i = 0; i < layout.count[0] * layout.count[1]; ++i) {
    const std::array<std::int64_t, 2> first{i / layout.count[1] * layout.size[0],
                                            i % layout.count[1] * layout.size[1]};
    const std::array<hsize_t, 2> at{static_cast<hsize_t>(first[0]), static_cast<hsize_t>(first[1])};
    unsigned skipped = 0;
    haddr_t offset = HADDR_UNDEF;
    hsize_t size = 0;
    if (H5Dget_chunk_info_by_coord(dataset, at.data(), &skipped, &offset, &size) < 0)
      fail_storage(extent, fmt::format("the chunk at row {} is not found", first[0]));
    if (offset == HADDR_UNDEF) {
      fail_storage(extent, fmt::format("the chunk at row {} was never written", first[0]),
                   ErrorCode::kUnsupported);
    }
    if (offset > static_cast<haddr_t>(source.size()) ||
        size > static_cast<hsize_t>(source.size()) - offset)
      fail_storage(extent, fmt::format("the chunk at row {} ends behind the file", first[0]));
    bytes.resize(static_cast<std::size_t>(size));
    source.read(static_cast<std::int64_t>(offset), bytes);
    unfilter(extent, layout, skipped, bytes);
    place_chunk(extent, layout, first, bytes, to);
    progress.advance(static_cast<std::int64_t>(bytes.size()));
  }
}

}  // namespace

std::optional<Hdf5Type> hdf5_type_of(hid_t type) {
  const std::array<std::pair<hid_t, Hdf5Type>, 20> types{{
      {H5T_IEEE_F32LE, {ScalarType::kFloat32, false}},
      {H5T_IEEE_F32BE, {ScalarType::kFloat32, true}},
      {H5T_IEEE_F64LE, {ScalarType::kFloat64, false}},
      {H5T_IEEE_F64BE, {ScalarType::kFloat64, true}},
      {H5T_STD_U8LE, {ScalarType::kUInt8, false}},
      {H5T_STD_U8BE, {ScalarType::kUInt8, true}},
      {H5T_STD_I8LE, {ScalarType::kInt8, false}},
      {H5T_STD_I8BE, {ScalarType::kInt8, true}},
      {H5T_STD_U16LE, {ScalarType::kUInt16, false}},
      {H5T_STD_U16BE, {ScalarType::kUInt16, true}},
      {H5T_STD_I16LE, {ScalarType::kInt16, false}},
      {H5T_STD_I16BE, {ScalarType::kInt16, true}},
      {H5T_STD_U32LE, {ScalarType::kUInt32, false}},
      {H5T_STD_U32BE, {ScalarType::kUInt32, true}},
      {H5T_STD_I32LE, {ScalarType::kInt32, false}},
      {H5T_STD_I32BE, {ScalarType::kInt32, true}},
      {H5T_STD_U64LE, {ScalarType::kUInt64, false}},
      {H5T_STD_U64BE, {ScalarType::kUInt64, true}},
      {H5T_STD_I64LE, {ScalarType::kInt64, false}},
      {H5T_STD_I64BE, {ScalarType::kInt64, true}},
  }};
  for (const auto& [known, result] : types)
    if (H5Tequal(type, known) > 0) return result;
  return std::nullopt;
}

void check_hdf5_storage(hid_t dataset, const Hdf5Extent& extent, const ByteSource& source) {
  const Hdf5Handle plist(H5Dget_create_plist(dataset), H5Pclose);
  if (!plist.is_open()) fail_storage(extent, "is broken");
  const H5D_layout_t kind = H5Pget_layout(plist.get());
  if (H5Pget_external_count(plist.get()) > 0 || kind == H5D_VIRTUAL)
    fail_storage(extent, "lies in other files, which are not read", ErrorCode::kUnsupported);
  if (kind == H5D_CONTIGUOUS) {
    contiguous_offset(dataset, extent, source);
    return;
  }
  if (kind == H5D_COMPACT) {
    if (static_cast<std::int64_t>(H5Dget_storage_size(dataset)) != extent.num_bytes())
      fail_storage(extent, "has another size than it claims");
    return;
  }
  if (kind != H5D_CHUNKED) fail_storage(extent, "lies in an unknown way", ErrorCode::kUnsupported);
  const ChunkLayout layout = chunk_layout(plist.get(), extent);
  // Deflate's best, whatever the filters are, and 8 bytes of index for each chunk.
  const std::int64_t most = source.size() * kMaxDeflateRatio;
  if (extent.num_bytes() <= most && layout.num_bytes <= most &&
      layout.count[0] <= source.size() / 8 / layout.count[1])
    return;
  fail_storage(extent, fmt::format("claims {} bytes in chunks of {}, more than a file of {} bytes "
                                   "can hold",
                                   extent.num_bytes(), layout.num_bytes, source.size()));
}

void read_hdf5_storage(hid_t dataset, const Hdf5Extent& extent, const ByteSource& source,
                       std::byte* to, ReadProgress& progress) {
  const std::span<std::byte> all(to, static_cast<std::size_t>(extent.num_bytes()));
  const Hdf5Handle plist(H5Dget_create_plist(dataset), H5Pclose);
  const H5D_layout_t kind = H5Pget_layout(plist.get());
  if (kind == H5D_CONTIGUOUS) {
    const std::int64_t offset = contiguous_offset(dataset, extent, source);
    for (std::int64_t done = 0; done < extent.num_bytes();) {
      const std::int64_t piece = std::min(ReadProgress::kChunk, extent.num_bytes() - done);
      source.read(offset + done,
                  all.subspan(static_cast<std::size_t>(done), static_cast<std::size_t>(piece)));
      progress.advance(piece);
      done += piece;
    }
  } else if (kind == H5D_CHUNKED) {
    read_chunks(dataset, extent, source, to, progress);
  } else {
    // In the object's own header, as it is: no conversion.
    const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
    if (H5Dread(dataset, type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, to) < 0)
      fail_storage(extent, "cannot be read: is the file damaged?");
    progress.advance(extent.num_bytes());
  }
  if (extent.type.is_big_endian != (std::endian::native == std::endian::big))
    swap_bytes(all, size_of(extent.type.type));
}

}  // namespace ovoid::io
#endif
