// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_storage.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <span>

#include "io/core/decompressors.h"
#include "io/foreign/hdf5_file.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kChecksumSize = 4;

[[noreturn]] void fail_storage(const Hdf5Extent& extent, const std::string& what,
                               ErrorCode code = ErrorCode::kFileFormat) {
  throw Error(code, fmt::format("{}: {}", extent.where, what));
}

using Axes = std::array<std::int64_t, Hdf5Extent::kMaxRank>;

// How a dataset in chunks lies in the file. Axes before the dataset's first have one sample.
struct ChunkLayout {
  Axes dims{1, 1, 1, 1};              // of the dataset
  Axes size{1, 1, 1, 1};              // of a chunk
  Axes count{1, 1, 1, 1};             // of chunks, along each axis
  std::size_t first_axis = 0;         // of the dataset's own
  std::int64_t num_bytes = 0;         // of a chunk, unpacked
  std::vector<H5Z_filter_t> filters;  // as they are applied on writing

  // Sizes are checked one by one; their product may be anything. Returns at most `most` + 1.
  std::int64_t num_chunks(std::int64_t most) const noexcept {
    std::int64_t product = 1;
    for (const std::int64_t n : count) {
      if (n > most / product) return most + 1;
      product *= n;
    }
    return product;
  }
};

ChunkLayout chunk_layout(hid_t plist, const Hdf5Extent& extent) {
  ChunkLayout layout;
  std::array<hsize_t, H5S_MAX_RANK> chunk{};
  if (H5Pget_chunk(plist, H5S_MAX_RANK, chunk.data()) != static_cast<int>(extent.dims.size()))
    fail_storage(extent, "its chunks have another number of axes");
  layout.first_axis = Hdf5Extent::kMaxRank - extent.dims.size();
  double num_bytes = static_cast<double>(extent.item_size());
  for (std::size_t axis = 0; axis < extent.dims.size(); ++axis) {
    if (chunk[axis] < 1 || chunk[axis] > static_cast<hsize_t>(kMaxAxisSize))
      fail_storage(extent, fmt::format("has chunks of {} along axis {}", chunk[axis], axis));
    const std::size_t a = layout.first_axis + axis;
    layout.dims[a] = extent.dims[axis];
    layout.size[a] = static_cast<std::int64_t>(chunk[axis]);
    layout.count[a] = (layout.dims[a] - 1) / layout.size[a] + 1;
    num_bytes *= static_cast<double>(chunk[axis]);
  }
  if (num_bytes > static_cast<double>(kMaxNumBytes)) fail_storage(extent, "has chunks without end");
  layout.num_bytes = extent.item_size();
  for (const std::int64_t size : layout.size) layout.num_bytes *= size;
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

// A chunk into its place; what of it lies outside the dataset is left out.
void place_chunk(const Hdf5Extent& extent, const ChunkLayout& layout, const Axes& first,
                 const std::vector<std::byte>& bytes, std::byte* to) {
  const std::int64_t item = extent.item_size();
  Axes count{};  // of samples within the dataset
  for (std::size_t a = 0; a < count.size(); ++a)
    count[a] = std::min(layout.size[a], layout.dims[a] - first[a]);
  for (std::int64_t i = 0; i < count[0] * count[1] * count[2]; ++i) {
    const std::int64_t y = i % count[2], z = i / count[2] % count[1], w = i / count[2] / count[1];
    const std::int64_t from = (w * layout.size[1] + z) * layout.size[2] + y;
    const std::int64_t row =
        ((first[0] + w) * layout.dims[1] + first[1] + z) * layout.dims[2] + first[2] + y;
    std::memcpy(to + (row * layout.dims[3] + first[3]) * item,
                bytes.data() + from * layout.size[3] * item,
                static_cast<std::size_t>(count[3] * item));
  }
}

void read_chunks(hid_t dataset, const Hdf5Extent& extent, const ByteSource& source, std::byte* to,
                 ReadProgress& progress) {
  const Hdf5Handle plist(H5Dget_create_plist(dataset), H5Pclose);
  const ChunkLayout layout = chunk_layout(plist.get(), extent);
  std::vector<std::byte> bytes;
  const std::int64_t num_chunks = layout.num_chunks(kMaxNumBytes);
  for (std::int64_t i = 0; i < num_chunks; ++i) {
    Axes first{};
    std::array<hsize_t, Hdf5Extent::kMaxRank> at{};
    std::int64_t rest = i;
    for (std::size_t a = first.size(); a-- > 0;) {
      first[a] = rest % layout.count[a] * layout.size[a];
      rest /= layout.count[a];
      if (a >= layout.first_axis) at[a - layout.first_axis] = static_cast<hsize_t>(first[a]);
    }
    const auto fail = [&](const char* what, ErrorCode code = ErrorCode::kFileFormat) {
      fail_storage(extent,
                   fmt::format("the chunk at {} {}",
                               fmt::join(at.data(), at.data() + extent.dims.size(), ", "), what),
                   code);
    };
    unsigned skipped = 0;
    haddr_t offset = HADDR_UNDEF;
    hsize_t size = 0;
    if (H5Dget_chunk_info_by_coord(dataset, at.data(), &skipped, &offset, &size) < 0)
      fail("is not found");
    if (offset == HADDR_UNDEF) fail("was never written", ErrorCode::kUnsupported);
    if (offset > static_cast<haddr_t>(source.size()) ||
        size > static_cast<hsize_t>(source.size()) - offset)
      fail("ends behind the file");
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
      layout.num_chunks(source.size() / 8) <= source.size() / 8)
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
