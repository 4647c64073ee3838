// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_storage.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>

#include "io/core/decompressors.h"
#include "io/foreign/hdf5_file.h"
#include "io/foreign/hdf5_filters.h"
#include "io/foreign/hdf5_types.h"
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

ChunkLayout chunk_layout(hid_t plist, const Hdf5Extent& extent) {
  ChunkLayout layout;
  auto& chunk = layout.sizes;
  if (H5Pget_chunk(plist, H5S_MAX_RANK, chunk.data()) != static_cast<int>(extent.dims.size()))
    fail_storage(extent, "its chunks have another number of axes");
  auto num_bytes = static_cast<double>(extent.type.stored_size());
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
  return layout;
}

// Throws if the file's index of chunks is damaged.
double num_unwritten(hid_t dataset, const Hdf5Extent& extent, const ChunkLayout& layout) {
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  hsize_t num_written = 0;
  if (H5Dget_num_chunks(dataset, space.get(), &num_written) < 0)
    fail_storage(extent, "its chunks are not found: is the file damaged?");
  return std::max(layout.num_chunks - static_cast<double>(num_written), 0.0);
}

// Chunks and all that they claim, and whether they were written: what was not is the fill value.
void check_chunks(hid_t dataset, const Hdf5Extent& extent, const ChunkLayout& layout,
                  std::int64_t ratio, std::int64_t file_size) {
  const auto size = static_cast<double>(file_size), stored = static_cast<double>(layout.num_bytes);
  // What the filters do at best, and 8 bytes of index for each chunk. The fill value may stand for
  // any number of samples; a claim is believed up to what files have that hold something.
  constexpr double kAlways = 64 << 20, kMostOfByte = 65536, kMostChunks = 1 << 20;
  const double most = size * static_cast<double>(ratio);
  const double most_in_all =
      extent.may_have_gaps ? std::max(most, kAlways + kMostOfByte * size) : most;
  const double most_chunks = extent.may_have_gaps ? std::max(size / 8, kMostChunks) : size / 8;
  const auto refuse_claim = [&] {
    fail_storage(extent,
                 fmt::format("claims {} bytes in chunks of {}, more than a file of {} bytes "
                             "can hold",
                             extent.num_stored_bytes(), layout.num_bytes, file_size));
  };
  if (static_cast<double>(extent.num_stored_bytes()) > most_in_all ||
      layout.num_chunks > most_chunks)
    refuse_claim();
  const double num_gaps = num_unwritten(dataset, extent, layout);
  if (num_gaps > 0 && (!extent.may_have_gaps || num_gaps >= layout.num_chunks)) {
    fail_storage(
        extent,
        fmt::format("{:.0f} of its {:.0f} chunks were never written", num_gaps, layout.num_chunks),
        ErrorCode::kUnsupported);
  }
  if ((layout.num_chunks - num_gaps) * stored > std::max(most, size)) refuse_claim();
}

void check_contiguous(hid_t dataset, const Hdf5Extent& extent, const ByteSource& source) {
  const haddr_t offset = H5Dget_offset(dataset);
  if (offset == HADDR_UNDEF) fail_storage(extent, "was never written", ErrorCode::kUnsupported);
  if (offset > static_cast<haddr_t>(source.size()) ||
      extent.num_stored_bytes() > source.size() - static_cast<std::int64_t>(offset)) {
    fail_storage(extent, fmt::format("claims {} bytes at byte {}, more than a file of {} bytes can "
                                     "hold",
                                     extent.num_stored_bytes(), offset, source.size()));
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
    if (static_cast<std::int64_t>(H5Dget_storage_size(dataset)) != extent.num_stored_bytes())
      fail_storage(extent, "has another size than it claims");
    return;
  }
  if (kind != H5D_CHUNKED) fail_storage(extent, "lies in an unknown way", ErrorCode::kUnsupported);
  const ChunkLayout layout = chunk_layout(plist.get(), extent);
  const std::int64_t ratio = check_hdf5_filters(plist.get(), extent.where);
  check_chunks(dataset, extent, layout, ratio, source.size());
}

std::int64_t num_hdf5_gaps(hid_t dataset, const Hdf5Extent& extent) {
  const Hdf5Handle plist(H5Dget_create_plist(dataset), H5Pclose);
  if (H5Pget_layout(plist.get()) != H5D_CHUNKED) return 0;
  return static_cast<std::int64_t>(
      num_unwritten(dataset, extent, chunk_layout(plist.get(), extent)));
}

std::vector<std::int64_t> hdf5_chunk_sizes(hid_t dataset, const Hdf5Extent& extent) {
  std::vector<std::int64_t> sizes(extent.dims.size(), 1);
  const Hdf5Handle plist(H5Dget_create_plist(dataset), H5Pclose);
  if (H5Pget_layout(plist.get()) != H5D_CHUNKED) return sizes;
  const ChunkLayout layout = chunk_layout(plist.get(), extent);
  std::transform(layout.sizes.begin(), layout.sizes.begin() + std::ssize(sizes), sizes.begin(),
                 [](hsize_t size) { return static_cast<std::int64_t>(size); });
  return sizes;
}

std::int64_t hdf5_run_at_once(hid_t dataset, const Hdf5Extent& extent, std::size_t axis) {
  const Hdf5Handle plist(H5Dget_create_plist(dataset), H5Pclose);
  const H5D_layout_t kind = H5Pget_layout(plist.get());
  const std::int64_t size = extent.dims[axis];
  if (kind == H5D_COMPACT) return size;
  const std::int64_t unit = hdf5_chunk_sizes(dataset, extent)[axis];
  const std::int64_t wanted =
      ReadProgress::kChunk / std::max<std::int64_t>(1, extent.num_bytes() / size);
  return std::min(size, std::max<std::int64_t>(1, wanted / unit) * unit);
}

namespace {

// The selected numbers, as they become.
void read_selected(hid_t dataset, const Hdf5Extent& extent, hid_t memory, hid_t space,
                   std::span<std::byte> out) {
  const Hdf5Type& known = extent.type;
  const Hdf5Handle stored(H5Dget_type(dataset), H5Tclose);  // as it is: no conversion
  const bool is_short = known.short_float != ShortFloat::kNone;
  std::vector<std::byte> bits(is_short ? out.size() / 2 : 0);
  const std::span<std::byte> to = is_short ? std::span(bits) : out;
  const hid_t type = known.converted_size > 0 ? hdf5_native_type(known.type) : stored.get();
  const Hdf5Unpacking unpacking(dataset, extent.type.stored_size());
  if (H5Dread(dataset, type, memory, space, H5P_DEFAULT, to.data()) < 0) {
    fail_storage(extent,
                 fmt::format("cannot be read: {}is the file damaged?",
                             Hdf5Unpacking::error().empty() ? "" : Hdf5Unpacking::error() + ": "));
  }
  if (known.converted_size > 0) return;
  if (known.is_big_endian != (std::endian::native == std::endian::big))
    swap_bytes(to, is_short ? 2 : size_of(known.type));
  if (is_short) widen(bits, known.short_float, out.data());
}

}  // namespace

void read_hdf5_box(hid_t dataset, const Hdf5Extent& extent, std::span<const std::int64_t> first,
                   std::span<const std::int64_t> count, std::span<std::byte> out,
                   ReadProgress& progress) {
  if (out.empty()) return;
  if (std::equal(count.begin(), count.end(), extent.dims.begin(), extent.dims.end())) {
    // All, also of a single number, which has no axes.
    read_selected(dataset, extent, H5S_ALL, H5S_ALL, out);
  } else {
    std::array<hsize_t, Hdf5Extent::kMaxRank> start{}, size{};
    std::copy(first.begin(), first.end(), start.begin());
    std::copy(count.begin(), count.end(), size.begin());
    const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
    const Hdf5Handle memory(H5Screate_simple(static_cast<int>(count.size()), size.data(), nullptr),
                            H5Sclose);
    if (H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, size.data(),
                            nullptr) < 0)
      fail_storage(extent, "cannot be read: is the file damaged?");
    read_selected(dataset, extent, memory.get(), space.get(), out);
  }
  progress.advance(static_cast<std::int64_t>(out.size()));
}

void read_hdf5_columns(hid_t dataset, const Hdf5Extent& extent, std::int64_t first,
                       std::span<std::byte> out, ReadProgress& progress) {
  const auto num_bytes = static_cast<std::int64_t>(out.size());
  const std::array start{std::int64_t{0}, first};
  const std::array count{extent.dims[0], num_bytes / (extent.dims[0] * extent.item_size())};
  read_hdf5_box(dataset, extent, start, count, out, progress);
}

std::optional<StoredPlace> place_of_hdf5_storage(hid_t file, hid_t dataset,
                                                 const Hdf5Extent& extent) {
  // Addresses count from behind a block of the user's, by some versions of the library.
  const Hdf5Handle creation(H5Fget_create_plist(file), H5Pclose);
  hsize_t user_block = 0;
  if (H5Pget_userblock(creation.get(), &user_block) < 0 || user_block != 0) return std::nullopt;
  // What is widened or converted is no longer the file's.
  if (extent.type.stored_size() != extent.item_size() || extent.type.converted_size > 0)
    return std::nullopt;
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
  std::vector<std::int64_t> start(extent.dims.size(), 0), count = extent.dims;
  for (std::int64_t row = 0, num = 0; row < num_rows; row += num) {
    start[0] = first + row;
    num = std::min(step - start[0] % step, num_rows - row);  // up to where chunks end
    count[0] = num;
    read_hdf5_box(dataset, extent, start, count,
                  out.subspan(static_cast<std::size_t>(row * row_size),
                              static_cast<std::size_t>(num * row_size)),
                  progress);
  }
}

void read_hdf5_storage(hid_t dataset, const Hdf5Extent& extent, std::byte* to,
                       ReadProgress& progress) {
  read_hdf5_rows(dataset, extent, 0, {to, static_cast<std::size_t>(extent.num_bytes())}, progress);
}

}  // namespace ovoid::io
#endif
