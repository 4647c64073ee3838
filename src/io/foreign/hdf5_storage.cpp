// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_storage.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>

#include "io/core/decompressors.h"
#include "io/foreign/hdf5_file.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

[[noreturn]] void fail_storage(const Hdf5Extent& extent, const std::string& what,
                               ErrorCode code = ErrorCode::kFileFormat) {
  throw Error(code, fmt::format("{}: {}", extent.where, what));
}

// How a dataset in chunks lies in the file.
struct ChunkLayout {
  std::array<hsize_t, H5S_MAX_RANK> sizes{};  // of a chunk, along each axis
  std::int64_t num_bytes = 0;                 // of a chunk, unpacked
  double num_chunks = 1;  // sizes are checked one by one; their product may be anything
};

// Filters that may expand a file more than deflate does, or that others provide, are refused.
void check_filters(hid_t plist, const Hdf5Extent& extent) {
  const int num_filters = std::max(0, H5Pget_nfilters(plist));
  for (int i = 0; i < num_filters; ++i) {
    unsigned flags = 0, config = 0;
    std::size_t num_values = 0;
    char name[64] = "";
    const H5Z_filter_t filter = H5Pget_filter2(plist, static_cast<unsigned>(i), &flags, &num_values,
                                               nullptr, sizeof(name), name, &config);
    if (filter == H5Z_FILTER_DEFLATE || filter == H5Z_FILTER_SHUFFLE ||
        filter == H5Z_FILTER_FLETCHER32)
      continue;
    name[sizeof(name) - 1] = '\0';
    fail_storage(extent,
                 fmt::format("is compressed by filter {} ({}): expected deflate, shuffle or "
                             "fletcher32: repack it with h5repack -f GZIP=4",
                             filter, name),
                 ErrorCode::kUnsupported);
  }
}

ChunkLayout chunk_layout(hid_t plist, const Hdf5Extent& extent) {
  ChunkLayout layout;
  auto& chunk = layout.sizes;
  if (H5Pget_chunk(plist, H5S_MAX_RANK, chunk.data()) != static_cast<int>(extent.dims.size()))
    fail_storage(extent, "its chunks have another number of axes");
  double num_bytes = static_cast<double>(extent.item_size());
  for (std::size_t axis = 0; axis < extent.dims.size(); ++axis) {
    if (chunk[axis] < 1 || chunk[axis] > static_cast<hsize_t>(kMaxAxisSize))
      fail_storage(extent, fmt::format("has chunks of {} along axis {}", chunk[axis], axis));
    const auto size = static_cast<std::int64_t>(chunk[axis]);
    const std::int64_t num_along = (extent.dims[axis] - 1) / size + 1;
    layout.num_chunks *= static_cast<double>(num_along);
    num_bytes *= static_cast<double>(size);
  }
  if (num_bytes > static_cast<double>(kMaxNumBytes)) fail_storage(extent, "has chunks without end");
  layout.num_bytes = static_cast<std::int64_t>(num_bytes);
  check_filters(plist, extent);
  return layout;
}

// What is left out would be read as the fill value.
void check_written(hid_t dataset, const Hdf5Extent& extent, const ChunkLayout& layout) {
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  hsize_t num_written = 0;
  if (H5Dget_num_chunks(dataset, space.get(), &num_written) < 0)
    fail_storage(extent, "its chunks are not found: is the file damaged?");
  if (static_cast<double>(num_written) < layout.num_chunks)
    fail_storage(
        extent,
        fmt::format("{:.0f} of its {:.0f} chunks were never written",
                    layout.num_chunks - static_cast<double>(num_written), layout.num_chunks),
        ErrorCode::kUnsupported);
}

void check_contiguous(hid_t dataset, const Hdf5Extent& extent, const ByteSource& source) {
  const haddr_t offset = H5Dget_offset(dataset);
  if (offset == HADDR_UNDEF) fail_storage(extent, "was never written", ErrorCode::kUnsupported);
  if (offset > static_cast<haddr_t>(source.size()) ||
      extent.num_bytes() > source.size() - static_cast<std::int64_t>(offset)) {
    fail_storage(extent, fmt::format("claims {} bytes at byte {}, more than a file of {} bytes can "
                                     "hold",
                                     extent.num_bytes(), offset, source.size()));
  }
}

// Filters that our own unpacking knows: shuffle before deflate, either or neither.
bool set_filters(hid_t plist, ChunkedStorage& chunked) {
  for (int i = 0; i < H5Pget_nfilters(plist); ++i) {
    unsigned flags = 0, config = 0;
    std::size_t num_values = 0;
    const H5Z_filter_t filter = H5Pget_filter2(plist, static_cast<unsigned>(i), &flags, &num_values,
                                               nullptr, 0, nullptr, &config);
    if (filter == H5Z_FILTER_SHUFFLE && !chunked.is_shuffled && !chunked.is_deflated) {
      chunked.is_shuffled = true;
    } else if (filter == H5Z_FILTER_DEFLATE && !chunked.is_deflated) {
      chunked.is_deflated = true;
    } else {
      return false;
    }
  }
  return true;
}

std::optional<ChunkedStorage> chunked_storage(hid_t dataset, hid_t plist,
                                              const Hdf5Extent& extent) {
  ChunkedStorage chunked;
  const ChunkLayout layout = chunk_layout(plist, extent);
  if (layout.num_bytes > ChunkedStorage::kMostChunkBytes ||
      layout.num_chunks > static_cast<double>(ChunkedStorage::kMostChunks) ||
      !set_filters(plist, chunked))
    return std::nullopt;
  std::array<hsize_t, H5S_MAX_RANK> sizes{};
  H5Pget_chunk(plist, H5S_MAX_RANK, sizes.data());
  chunked.dims = extent.dims;
  const std::size_t rank = extent.dims.size();
  for (std::size_t a = 0; a < rank; ++a)
    chunked.chunk.push_back(static_cast<std::int64_t>(sizes[a]));
  std::array<hsize_t, H5S_MAX_RANK> at{};
  while (at[0] < static_cast<hsize_t>(extent.dims[0])) {
    unsigned skipped_filters = 0;
    haddr_t address = HADDR_UNDEF;
    hsize_t size = 0;
    if (H5Dget_chunk_info_by_coord(dataset, at.data(), &skipped_filters, &address, &size) < 0 ||
        skipped_filters != 0 || address == HADDR_UNDEF ||
        address > static_cast<haddr_t>(kMaxNumBytes) || size > static_cast<hsize_t>(kMaxNumBytes))
      return std::nullopt;
    chunked.chunks.push_back({static_cast<std::int64_t>(address), static_cast<std::int64_t>(size)});
    for (std::size_t a = rank; a-- > 0;) {
      at[a] += sizes[a];
      if (at[a] < static_cast<hsize_t>(extent.dims[a]) || a == 0) break;
      at[a] = 0;
    }
  }
  return chunked;
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
    check_contiguous(dataset, extent, source);
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
  const std::int64_t most_chunks = source.size() / 8;
  if (extent.num_bytes() <= most && layout.num_bytes <= most &&
      layout.num_chunks <= static_cast<double>(most_chunks))
    return check_written(dataset, extent, layout);
  fail_storage(extent, fmt::format("claims {} bytes in chunks of {}, more than a file of {} bytes "
                                   "can hold",
                                   extent.num_bytes(), layout.num_bytes, source.size()));
}

std::int64_t hdf5_run_at_once(hid_t dataset, const Hdf5Extent& extent, std::size_t axis) {
  const Hdf5Handle plist(H5Dget_create_plist(dataset), H5Pclose);
  const H5D_layout_t kind = H5Pget_layout(plist.get());
  const std::int64_t size = extent.dims[axis];
  if (kind == H5D_COMPACT) return size;
  const std::int64_t unit =
      kind == H5D_CHUNKED ? static_cast<std::int64_t>(chunk_layout(plist.get(), extent).sizes[axis])
                          : std::int64_t{1};
  const std::int64_t wanted =
      ReadProgress::kChunk / std::max<std::int64_t>(1, extent.num_bytes() / size);
  return std::min(size, std::max<std::int64_t>(1, wanted / unit) * unit);
}

void read_hdf5_columns(hid_t dataset, const Hdf5Extent& extent, std::int64_t first,
                       std::span<std::byte> out, ReadProgress& progress) {
  if (out.empty()) return;
  const auto num_bytes = static_cast<std::int64_t>(out.size());
  const std::array start{hsize_t{0}, static_cast<hsize_t>(first)};
  const std::array count{static_cast<hsize_t>(extent.dims[0]),
                         static_cast<hsize_t>(num_bytes / (extent.dims[0] * extent.item_size()))};
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);  // as it is: no conversion
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  const Hdf5Handle memory(H5Screate_simple(2, count.data(), nullptr), H5Sclose);
  if (H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(),
                          nullptr) < 0 ||
      H5Dread(dataset, type.get(), memory.get(), space.get(), H5P_DEFAULT, out.data()) < 0)
    fail_storage(extent, "cannot be read: is the file damaged?");
  progress.advance(num_bytes);
  if (extent.type.is_big_endian != (std::endian::native == std::endian::big))
    swap_bytes(out, size_of(extent.type.type));
}

std::optional<StoredPlace> place_of_hdf5_storage(hid_t file, hid_t dataset,
                                                 const Hdf5Extent& extent) {
  // Addresses count from behind a block of the user's, by some versions of the library.
  const Hdf5Handle creation(H5Fget_create_plist(file), H5Pclose);
  hsize_t user_block = 0;
  if (H5Pget_userblock(creation.get(), &user_block) < 0 || user_block != 0) return std::nullopt;
  const Hdf5Handle plist(H5Dget_create_plist(dataset), H5Pclose);
  StoredPlace place{extent.type.type, extent.type.is_big_endian, 0, extent.num_bytes()};
  if (H5Pget_layout(plist.get()) == H5D_CONTIGUOUS) {
    place.offset = static_cast<std::int64_t>(H5Dget_offset(dataset));
    return place;
  }
  if (H5Pget_layout(plist.get()) != H5D_CHUNKED) return std::nullopt;
  auto chunked = chunked_storage(dataset, plist.get(), extent);
  if (!chunked) return std::nullopt;
  place.chunked = std::make_shared<const ChunkedStorage>(std::move(*chunked));
  return place;
}

void read_hdf5_rows(hid_t dataset, const Hdf5Extent& extent, std::int64_t first,
                    std::span<std::byte> out, ReadProgress& progress) {
  const std::int64_t row_size = extent.num_bytes() / extent.dims[0];
  const std::int64_t num_rows = static_cast<std::int64_t>(out.size()) / row_size;
  const std::int64_t step = hdf5_run_at_once(dataset, extent, 0);
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);  // as it is: no conversion
  std::array<hsize_t, Hdf5Extent::kMaxRank> start{}, count{};
  std::copy(extent.dims.begin(), extent.dims.end(), count.begin());
  for (std::int64_t row = 0, num = 0; row < num_rows; row += num) {
    const std::int64_t at = first + row;
    num = std::min(step - at % step, num_rows - row);  // up to where chunks end
    start[0] = static_cast<hsize_t>(at);
    count[0] = static_cast<hsize_t>(num);
    const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
    const Hdf5Handle memory(
        H5Screate_simple(static_cast<int>(extent.dims.size()), count.data(), nullptr), H5Sclose);
    const bool is_all = num == extent.dims[0];  // of a single number, too, which has no axes
    if ((!is_all && H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr,
                                        count.data(), nullptr) < 0) ||
        H5Dread(dataset, type.get(), is_all ? H5S_ALL : memory.get(),
                is_all ? H5S_ALL : space.get(), H5P_DEFAULT, out.data() + row * row_size) < 0)
      fail_storage(extent, "cannot be read: is the file damaged?");
    progress.advance(num * row_size);
  }
  if (extent.type.is_big_endian != (std::endian::native == std::endian::big))
    swap_bytes(out, size_of(extent.type.type));
}

void read_hdf5_storage(hid_t dataset, const Hdf5Extent& extent, std::byte* to,
                       ReadProgress& progress) {
  read_hdf5_rows(dataset, extent, 0, {to, static_cast<std::size_t>(extent.num_bytes())}, progress);
}

}  // namespace ovoid::io
#endif
