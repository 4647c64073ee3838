// SPDX-License-Identifier: Apache-2.0
#include "io/zarr/zarr_codecs.h"

#include <blosc.h>
#include <fmt/format.h>
#include <lz4.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "io/core/decompressors.h"
#include "io/core/numbers.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

[[noreturn]] void fail_chunk(const std::string& where, const std::string& what) {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", where, what));
}

[[noreturn]] void fail_size(const std::string& where, const char* codec, std::size_t wanted) {
  fail_chunk(where,
             fmt::format("its {} data do not unpack to the {} bytes of a chunk", codec, wanted));
}

// zlib's or libbz2's, one stream that ends.
template <typename Decompressor>
void unpack_stream(const std::string& where, std::span<const std::byte> packed,
                   std::span<std::byte> out) {
  Decompressor decompressor;
  auto& stream = decompressor.stream;
  const auto take = [](auto& next, auto& left, auto* data, std::size_t size) {
    next = reinterpret_cast<std::remove_reference_t<decltype(next)>>(data);
    left = static_cast<std::remove_reference_t<decltype(left)>>(size);
  };
  take(stream.next_in, stream.avail_in, const_cast<std::byte*>(packed.data()), packed.size());
  take(stream.next_out, stream.avail_out, out.data(), out.size());
  std::byte more{};  // beyond a chunk's bytes: what unpacks to more is seen, not stored
  bool is_beyond = false;
  while (!decompressor.ended) {
    const auto left_before = stream.avail_in;
    const auto room_before = stream.avail_out;
    if (const std::string wrong = decompressor.step(); !wrong.empty())
      fail_chunk(where, fmt::format("its {} data are {}", Decompressor::kName, wrong));
    if (decompressor.ended) break;
    const bool is_full = stream.avail_out == 0;
    if (is_full && is_beyond) fail_size(where, Decompressor::kName, out.size());
    if (is_full) {
      take(stream.next_out, stream.avail_out, &more, 1);
      is_beyond = true;
      continue;
    }
    if (stream.avail_in == left_before && stream.avail_out == room_before)
      fail_chunk(where, fmt::format("its {} data end early", Decompressor::kName));
  }
  const std::size_t beyond = is_beyond ? 1 - static_cast<std::size_t>(stream.avail_out) : 0;
  if (beyond != 0 || (!is_beyond && stream.avail_out != 0))
    fail_size(where, Decompressor::kName, out.size());
}

void unpack_blosc(const std::string& where, std::span<const std::byte> packed,
                  std::span<std::byte> out) {
  std::size_t size = 0;
  if (packed.size() < BLOSC_MIN_HEADER_LENGTH ||
      blosc_cbuffer_validate(packed.data(), packed.size(), &size) != 0)
    fail_chunk(where, "its Blosc data are broken");
  if (size != out.size()) fail_size(where, "Blosc", out.size());
  const int written = blosc_decompress_ctx(packed.data(), out.data(), out.size(), 1);
  if (written == static_cast<int>(out.size())) return;
  const char* const library = blosc_cbuffer_complib(packed.data());
  fail_chunk(where, fmt::format("its Blosc data ({}) are broken",
                                library != nullptr ? library : "of no known compressor"));
}

void unpack_zstd(const std::string& where, std::span<const std::byte> packed,
                 std::span<std::byte> out) {
  const std::size_t size = ZSTD_decompress(out.data(), out.size(), packed.data(), packed.size());
  if (ZSTD_isError(size) != 0 || size != out.size()) fail_size(where, "Zstandard", out.size());
}

// numcodecs puts the size in front, 4 bytes, little endian.
void unpack_lz4(const std::string& where, std::span<const std::byte> packed,
                std::span<std::byte> out) {
  constexpr std::size_t kSize = 4;
  constexpr auto kMost = static_cast<std::size_t>(std::numeric_limits<int>::max());
  if (packed.size() < kSize || packed.size() > kMost ||
      number_at<std::uint32_t>(packed.data(), false) != out.size())
    fail_size(where, "LZ4", out.size());
  const int size = LZ4_decompress_safe(
      reinterpret_cast<const char*>(packed.data() + kSize), reinterpret_cast<char*>(out.data()),
      static_cast<int>(packed.size() - kSize), static_cast<int>(out.size()));
  if (size != static_cast<int>(out.size())) fail_size(where, "LZ4", out.size());
}

// Castagnoli's polynomial, reflected [RFC 3720].
std::uint32_t crc32c(std::span<const std::byte> bytes) {
  static const std::array<std::uint32_t, 256> kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit) value = value >> 1 ^ ((value & 1) != 0 ? 0x82f63b78U : 0U);
      table[i] = value;
    }
    return table;
  }();
  std::uint32_t sum = ~0U;
  for (const std::byte b : bytes)
    sum = sum >> 8 ^ kTable[(sum ^ std::to_integer<unsigned>(b)) & 255];
  return ~sum;
}

}  // namespace

ZarrCodec zarr_codec_called(const std::string& where, const std::string& name) {
  static constexpr std::pair<const char*, ZarrCodec> kNames[] = {
      {"gzip", ZarrCodec::kGzip},   {"zlib", ZarrCodec::kGzip}, {"bz2", ZarrCodec::kBzip2},
      {"blosc", ZarrCodec::kBlosc}, {"zstd", ZarrCodec::kZstd}, {"lz4", ZarrCodec::kLz4},
  };
  for (const auto& [known, codec] : kNames)
    if (name == known) return codec;
  throw Error(
      ErrorCode::kUnsupported,
      fmt::format("{}: is packed by '{}': expected blosc, gzip, zlib, zstd, lz4, bz2 or none",
                  where, name.substr(0, 40)));
}

void unpack_zarr_chunk(const std::string& where, std::span<const std::byte> packed,
                       const ZarrPacking& packing, std::span<std::byte> out) {
  if (packing.has_checksum) {
    constexpr std::size_t kSum = 4;
    if (packed.size() < kSum) fail_chunk(where, "is shorter than its checksum");
    const auto stored = number_at<std::uint32_t>(&packed[packed.size() - kSum], false);
    packed = packed.first(packed.size() - kSum);
    if (crc32c(packed) != stored) fail_chunk(where, "its checksum is wrong");
  }
  switch (packing.codec) {
    case ZarrCodec::kGzip:
      return unpack_stream<Inflater>(where, packed, out);
    case ZarrCodec::kBzip2:
      return unpack_stream<Bunzipper>(where, packed, out);
    case ZarrCodec::kBlosc:
      return unpack_blosc(where, packed, out);
    case ZarrCodec::kZstd:
      return unpack_zstd(where, packed, out);
    case ZarrCodec::kLz4:
      return unpack_lz4(where, packed, out);
    case ZarrCodec::kNone:
      break;
  }
  if (packed.size() != out.size()) {
    fail_chunk(where, fmt::format("has {} bytes, a chunk takes {}", packed.size(), out.size()));
  }
  std::copy(packed.begin(), packed.end(), out.begin());
}

}  // namespace ovoid::io
