// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_filters.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "io/core/decompressors.h"
#include "io/core/lzf.h"
#include "io/core/numbers.h"
#include "io/foreign/bitshuffle.h"
#include "io/foreign/hdf5_handle.h"
#include "io/zarr/zarr_codecs.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// By their registered numbers [HDF5 filters].
constexpr H5Z_filter_t kBzip2Filter = 307, kLzfFilter = 32000, kBloscFilter = 32001,
                       kLz4Filter = 32004, kBitshuffleFilter = 32008, kZstdFilter = 32015;

// The reader works on one thread, and the library keeps what it calls in tables of its own.
std::size_t chunk_bytes = 0;  // of a chunk, unpacked; 0: not known
std::size_t most_bytes = 0;   // that a filter may make of it; 0: not known
std::string last_error;

using PackedBytes = std::span<const std::byte>;
using FilterValues = std::span<const unsigned>;  // that the file keeps for the filter
using Unpacked = std::vector<std::byte>;

[[noreturn]] void refuse_chunk(const std::string& what) {
  throw Error(ErrorCode::kFileFormat, what);
}

// A size that a chunk claims, if it is one that it can have.
std::size_t believed(std::uint64_t size) {
  const std::uint64_t most = most_bytes > 0 ? most_bytes : std::uint64_t{1} << 31U;
  if (size > most) refuse_chunk(fmt::format("a chunk says that it stands for {} bytes", size));
  return static_cast<std::size_t>(size);
}

// That of the chunk, where the data do not say theirs.
std::size_t known_size() {
  if (chunk_bytes == 0) refuse_chunk("the size of chunks is not known");
  return chunk_bytes;
}

Unpacked unpacked(ZarrCodec codec, PackedBytes packed, std::uint64_t size) {
  Unpacked out(believed(size));
  unpack_zarr_chunk("a chunk", packed, {codec}, out);
  return out;
}

Unpacked undo_lzf(PackedBytes packed, FilterValues) {
  const auto size = lzf_size(packed);
  if (!size) refuse_chunk("a chunk's LZF data are broken");
  Unpacked out(believed(*size));
  unpack_lzf(packed, out);
  return out;
}

Unpacked undo_bzip2(PackedBytes packed, FilterValues) {
  return unpacked(ZarrCodec::kBzip2, packed, known_size());
}

// Its size is the second number in Blosc's header of 16 bytes.
Unpacked undo_blosc(PackedBytes packed, FilterValues) {
  if (packed.size() < 16) refuse_chunk("a chunk's Blosc data end early");
  return unpacked(ZarrCodec::kBlosc, packed, number_at<std::uint32_t>(packed.data() + 4, false));
}

Unpacked undo_zstd(PackedBytes packed, FilterValues) {
  return unpacked(ZarrCodec::kZstd, packed, known_size());
}

// A block of LZ4's, whose size is known.
void undo_lz4_block(PackedBytes packed, std::span<std::byte> out) {
  Unpacked with_size(4 + packed.size());  // as numcodecs writes it
  for (unsigned i = 0; i < 4; ++i) with_size[i] = std::byte(out.size() >> 8 * i & 255U);
  std::copy(packed.begin(), packed.end(), with_size.begin() + 4);
  unpack_zarr_chunk("a chunk", with_size, {ZarrCodec::kLz4}, out);
}

// Takes a number of big endian off the front.
template <typename T>
T take(PackedBytes& packed) {
  if (packed.size() < sizeof(T)) refuse_chunk("a chunk ends early");
  const T value = number_at<T>(packed.data(), true);
  packed = packed.subspan(sizeof(T));
  return value;
}

PackedBytes take(PackedBytes& packed, std::size_t size) {
  if (packed.size() < size) refuse_chunk("a chunk ends early");
  const PackedBytes front = packed.first(size);
  packed = packed.subspan(size);
  return front;
}

// The size, that of blocks, and blocks with their packed sizes, of which one as large as the block
// is not packed.
Unpacked undo_lz4(PackedBytes packed, FilterValues) {
  Unpacked out(believed(take<std::uint64_t>(packed)));
  const std::size_t block = take<std::uint32_t>(packed);
  if (block == 0 && !out.empty()) refuse_chunk("a chunk has blocks of no size");
  for (std::size_t at = 0; at < out.size(); at += block) {
    const std::span<std::byte> to = std::span(out).subspan(at, std::min(block, out.size() - at));
    const PackedBytes from = take(packed, take<std::uint32_t>(packed));
    if (from.size() == to.size())
      std::copy(from.begin(), from.end(), to.begin());
    else
      undo_lz4_block(from, to);
  }
  return out;
}

// What the filter's numbers say of bitshuffled chunks.
struct Bitshuffled {
  std::size_t item_size = 1;
  std::size_t block = 0;  // items in a block
  enum class Packing { kNone, kLz4, kZstd } packing = Packing::kNone;
};

Bitshuffled described(FilterValues values) {
  constexpr std::size_t kItemSize = 2, kBlock = 3, kPacking = 4;
  const auto value = [&](std::size_t i) { return i < values.size() ? values[i] : 0U; };
  Bitshuffled chunk;
  chunk.item_size = value(kItemSize);
  chunk.block = value(kBlock);
  if (value(kPacking) == 2) chunk.packing = Bitshuffled::Packing::kLz4;
  if (value(kPacking) == 3) chunk.packing = Bitshuffled::Packing::kZstd;
  if (chunk.item_size == 0 || chunk.item_size > 4096 || (value(kPacking) & ~3U) != 0 ||
      value(kPacking) == 1)
    refuse_chunk("a chunk is bitshuffled in an unknown way");
  return chunk;
}

// Blocks of items, the last a multiple of eight, and the rest as it is.
Unpacked undo_bitshuffle(PackedBytes packed, FilterValues values) {
  Bitshuffled chunk = described(values);
  const bool is_packed = chunk.packing != Bitshuffled::Packing::kNone;
  std::uint64_t size = packed.size();
  if (is_packed) {
    size = take<std::uint64_t>(packed);
    chunk.block = take<std::uint32_t>(packed) / chunk.item_size;
  }
  // What its library takes without another wish: 8 KiB, at least 128 items.
  if (chunk.block == 0) chunk.block = std::max<std::size_t>(8192 / chunk.item_size / 8 * 8, 128);
  if (chunk.block % 8 != 0) refuse_chunk("a chunk is bitshuffled in blocks of an unknown size");
  Unpacked out(believed(size)), block;
  const std::size_t num_items = out.size() / chunk.item_size;
  std::size_t at = 0;
  for (std::size_t item = 0; item + 8 <= num_items;) {
    const std::size_t count = std::min(chunk.block, (num_items - item) / 8 * 8);
    const std::span<std::byte> to = std::span(out).subspan(at, count * chunk.item_size);
    PackedBytes bits;
    if (is_packed) {
      const PackedBytes from = take(packed, take<std::uint32_t>(packed));
      block.resize(to.size());
      if (chunk.packing == Bitshuffled::Packing::kLz4)
        undo_lz4_block(from, block);
      else
        unpack_zarr_chunk("a chunk", from, {ZarrCodec::kZstd}, block);
      bits = block;
    } else {
      bits = take(packed, to.size());
    }
    unshuffle_bits(bits, chunk.item_size, to);
    item += count;
    at += to.size();
  }
  const PackedBytes rest = take(packed, out.size() - at);
  std::copy(rest.begin(), rest.end(), out.begin() + static_cast<std::ptrdiff_t>(at));
  return out;
}

// The library's way to call a filter: the chunk in *buffer, which is replaced. 0 is a failure.
template <Unpacked (*kUndo)(PackedBytes, FilterValues)>
std::size_t filter_chunk(unsigned flags, std::size_t num_values, const unsigned values[],
                         std::size_t num_bytes, std::size_t* buffer_size, void** buffer) noexcept {
  if ((flags & H5Z_FLAG_REVERSE) == 0) return 0;  // nothing is written through these
  try {
    const Unpacked out =
        kUndo({static_cast<const std::byte*>(*buffer), num_bytes}, {values, num_values});
    if (out.empty()) return 0;
    void* const memory = std::malloc(out.size());  // which the library frees
    if (memory == nullptr) return 0;
    std::memcpy(memory, out.data(), out.size());
    std::free(*buffer);
    *buffer = memory;
    *buffer_size = out.size();
    return out.size();
  } catch (const std::exception& error) {
    last_error = error.what();
    return 0;
  }
}

template <Unpacked (*kUndo)(PackedBytes, FilterValues)>
void use(H5Z_filter_t number, const char* name) {
  H5Z_class2_t filter_class{};
  filter_class.version = H5Z_CLASS_T_VERS;
  filter_class.id = number;
  filter_class.decoder_present = 1;
  filter_class.name = name;
  filter_class.filter = filter_chunk<kUndo>;
  H5Zregister(&filter_class);
}

// Names of registered filters that files without the filter's own name have.
std::string_view registered_name(H5Z_filter_t number) {
  static constexpr std::pair<H5Z_filter_t, std::string_view> kNames[] = {
      {H5Z_FILTER_SZIP, "szip"},
      {305, "LZO"},
      {kBzip2Filter, "bzip2"},
      {kLzfFilter, "LZF"},
      {kBloscFilter, "Blosc"},
      {32003, "Snappy"},
      {kLz4Filter, "LZ4"},
      {kBitshuffleFilter, "bitshuffle"},
      {32013, "ZFP"},
      {32014, "FPZIP"},
      {kZstdFilter, "Zstandard"},
      {32017, "SZ"},
      {32019, "JPEG"},
      {32024, "SZ3"},
      {32026, "Blosc2"},
      {32028, "FLAC"}};
  for (const auto& [known, name] : kNames)
    if (known == number) return name;
  return "";
}

// At best, of what each filter unpacks. Szip stands for 64 blocks of 32 zeros of 8 bytes by one
// byte; a chunk of one number may be all that scale-offset keeps, and so with Zstandard and Blosc,
// whose own best is 128 KiB in three bytes.
std::int64_t most_of_byte(H5Z_filter_t number) {
  constexpr std::int64_t kZstdRatio = (128 << 10) / 3 + 1;
  switch (number) {
    case H5Z_FILTER_SHUFFLE:
    case H5Z_FILTER_FLETCHER32:
      return 1;
    case H5Z_FILTER_NBIT:
      return 64;
    case kLzfFilter:
      return static_cast<std::int64_t>(kMaxLzfRatio);
    case kLz4Filter:
      return 255;
    case H5Z_FILTER_SZIP:
      return 64 * 32 * 8;
    case H5Z_FILTER_SCALEOFFSET:
    case kBloscFilter:
    case kZstdFilter:
    case kBitshuffleFilter:
    case kBzip2Filter:
      return kZstdRatio;
    default:
      return kMaxDeflateRatio;
  }
}

[[noreturn]] void refuse_filter(const std::string& where, H5Z_filter_t number,
                                const std::string& told) {
  const std::string_view known = registered_name(number);
  const std::string name = known.empty() ? told : std::string(known);
  // h5repack leaves out what it cannot unpack, and says nothing.
  throw Error(ErrorCode::kUnsupported,
              fmt::format("{}: is compressed by filter {}{}, which is not read: copy it where it "
                          "can be, in Python: import h5py, hdf5plugin; a = h5py.File('in.h5'); "
                          "h5py.File('out.h5', 'w').create_dataset('data', data=a[PATH][...])",
                          where, number, name.empty() ? "" : " (" + name + ")"));
}

}  // namespace

void use_hdf5_filters() {
  static bool are_used = false;
  if (std::exchange(are_used, true)) return;
  H5PLset_loading_state(0);  // no code from the folders of plugins
  use<undo_bzip2>(kBzip2Filter, "bzip2");
  use<undo_lzf>(kLzfFilter, "lzf");
  use<undo_blosc>(kBloscFilter, "blosc");
  use<undo_lz4>(kLz4Filter, "lz4");
  use<undo_bitshuffle>(kBitshuffleFilter, "bitshuffle");
  use<undo_zstd>(kZstdFilter, "zstd");
}

std::int64_t check_hdf5_filters(hid_t creation, const std::string& where) {
  use_hdf5_filters();
  constexpr std::int64_t kMost = 1 << 20;  // of several together
  std::int64_t ratio = 1;
  for (int i = 0; i < H5Pget_nfilters(creation); ++i) {
    unsigned flags = 0, config = 0;
    std::size_t num_values = 0;
    std::array<char, 64> name{};
    const H5Z_filter_t number =
        H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &num_values, nullptr,
                       name.size(), name.data(), &config);
    name.back() = '\0';
    unsigned can = 0;
    if (number < 0 || H5Zfilter_avail(number) <= 0 || H5Zget_filter_info(number, &can) < 0 ||
        (can & H5Z_FILTER_CONFIG_DECODE_ENABLED) == 0)
      refuse_filter(where, number, name.data());
    ratio = std::min(ratio * most_of_byte(number), kMost);
  }
  return ratio;
}

Hdf5Unpacking::Hdf5Unpacking(hid_t dataset, std::int64_t item_size) {
  last_error.clear();
  most_bytes = chunk_bytes = 0;
  const Hdf5Handle creation(H5Dget_create_plist(dataset), H5Pclose);
  std::array<hsize_t, H5S_MAX_RANK> sizes{};
  if (H5Pget_layout(creation.get()) != H5D_CHUNKED) return;
  const int rank = H5Pget_chunk(creation.get(), H5S_MAX_RANK, sizes.data());
  auto num_bytes = static_cast<hsize_t>(item_size);
  for (int axis = 0; axis < rank; ++axis) num_bytes *= sizes[static_cast<std::size_t>(axis)];
  constexpr std::size_t kChecksums = 64;  // of filters that went before
  most_bytes = num_bytes + kChecksums;
  chunk_bytes = num_bytes;
}

Hdf5Unpacking::~Hdf5Unpacking() { most_bytes = chunk_bytes = 0; }

const std::string& Hdf5Unpacking::error() noexcept { return last_error; }

}  // namespace ovoid::io
#endif
