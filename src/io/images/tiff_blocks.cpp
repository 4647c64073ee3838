// SPDX-License-Identifier: Apache-2.0
#include "io/images/tiff_blocks.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include "io/core/decompressors.h"
#include "io/core/samples.h"

namespace ovoid::io {
namespace {

constexpr const char* kTooFew = "holds less than its part of the page";

// Codes of 9 to 12 bits, the highest bit first. A code's string is that of another code and one
// byte more.
class LzwTable {
 public:
  static constexpr unsigned kClear = 256, kEnd = 257, kSize = 4096;

  LzwTable() {
    for (unsigned i = 0; i < 256; ++i) {
      last_[i] = static_cast<std::uint8_t>(i);
      length_[i] = 1;
    }
  }

  unsigned next() const noexcept { return next_; }
  int width() const noexcept { return width_; }
  std::size_t length(unsigned code) const noexcept { return length_[code]; }
  void clear() noexcept {
    next_ = kEnd + 1;
    width_ = 9;
  }
  void add(unsigned prefix, std::uint8_t last) noexcept {
    if (next_ == kSize) return;
    prefix_[next_] = static_cast<std::uint16_t>(prefix);
    last_[next_] = last;
    length_[next_] = static_cast<std::uint16_t>(length_[prefix] + 1);
    // Codes grow one entry early, as the first encoder did it.
    if (++next_ == (1U << width_) - 1 && width_ < 12) ++width_;
  }
  // The front of the string of `code` that fits; returns its first byte.
  std::uint8_t write(unsigned code, std::span<std::byte> out) const noexcept {
    for (std::size_t at = length_[code]; at > 1; --at, code = prefix_[code])
      if (at <= out.size()) out[at - 1] = static_cast<std::byte>(last_[code]);
    if (!out.empty()) out[0] = static_cast<std::byte>(last_[code]);
    return last_[code];
  }

 private:
  std::array<std::uint16_t, kSize> prefix_{}, length_{};
  std::array<std::uint8_t, kSize> last_{};
  unsigned next_ = kEnd + 1;
  int width_ = 9;
};

std::string unpack_lzw(std::span<const std::byte> packed, std::span<std::byte> out) {
  constexpr unsigned kNone = LzwTable::kSize;
  LzwTable table;
  std::uint32_t window = 0;
  int num_bits = 0;
  unsigned before = kNone;
  std::size_t in = 0, at = 0;
  while (at < out.size()) {
    while (num_bits < table.width()) {
      if (in == packed.size()) return kTooFew;
      window = window << 8U | static_cast<std::uint32_t>(packed[in++]);
      num_bits += 8;
    }
    num_bits -= table.width();
    const unsigned code = window >> num_bits & ((1U << table.width()) - 1);
    if (code == LzwTable::kEnd) return kTooFew;
    if (code == LzwTable::kClear) {
      table.clear();
      before = kNone;
      continue;
    }
    const std::span<std::byte> rest = out.subspan(at);
    if (before == kNone ? code >= 256 : code > table.next()) return "has an LZW code of nothing";
    if (before == kNone) {
      rest[0] = static_cast<std::byte>(code);
      at += 1;
    } else if (code < table.next()) {
      const std::uint8_t first = table.write(code, rest);
      at += std::min(table.length(code), rest.size());
      table.add(before, first);
    } else {  // the string that this code itself adds: the one before, and its first byte once more
      if (table.next() == LzwTable::kSize) return "has an LZW code of nothing";
      const std::uint8_t first = table.write(before, rest);
      const std::size_t length = table.length(before);
      if (length < rest.size()) rest[length] = static_cast<std::byte>(first);
      at += std::min(length + 1, rest.size());
      table.add(before, first);
    }
    before = code;
  }
  return {};
}

std::string unpack_bits(std::span<const std::byte> packed, std::span<std::byte> out) {
  std::size_t in = 0, at = 0;
  while (at < out.size()) {
    if (in == packed.size()) return kTooFew;
    // A byte with sign.
    const auto byte = static_cast<unsigned>(packed[in++]);
    const int head = byte < 128 ? static_cast<int>(byte) : static_cast<int>(byte) - 256;
    if (head == -128) continue;
    const auto count = static_cast<std::size_t>(head < 0 ? 1 - head : 1 + head);
    const std::size_t used = std::min(count, out.size() - at);
    if ((head < 0 ? 1 : used) > packed.size() - in) return kTooFew;
    if (head < 0) {
      std::memset(&out[at], static_cast<int>(packed[in++]), used);
    } else {
      std::memcpy(&out[at], &packed[in], used);
      in += std::min(count, packed.size() - in);
    }
    at += used;
  }
  return {};
}

std::string inflate_block(std::span<const std::byte> packed, std::span<std::byte> out) {
  Inflater inflater;
  inflater.stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data()));
  inflater.stream.next_out = reinterpret_cast<Bytef*>(out.data());
  // zlib counts in 32 bits.
  constexpr std::size_t kMost = std::size_t{1} << 30;
  std::size_t in_left = packed.size(), out_left = out.size();
  while (out_left > 0) {
    const std::size_t in = std::min(in_left, kMost), room = std::min(out_left, kMost);
    inflater.stream.avail_in = static_cast<uInt>(in);
    inflater.stream.avail_out = static_cast<uInt>(room);
    if (const std::string wrong = inflater.step(); !wrong.empty()) return "zlib: " + wrong;
    const std::size_t used = in - inflater.stream.avail_in, made = room - inflater.stream.avail_out;
    in_left -= used;
    out_left -= made;
    if (out_left > 0 && (inflater.ended || (used == 0 && made == 0))) return kTooFew;
  }
  return {};
}

std::string unpack_zstandard(std::span<const std::byte> packed, std::span<std::byte> out) {
  // By parts: a writer's last block may hold more than the page.
  ZSTD_DStream* const stream = ZSTD_createDStream();
  if (stream == nullptr) return "is packed, and memory is short";
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  ZSTD_outBuffer to{out.data(), out.size(), 0};
  std::string wrong;
  while (to.pos < to.size && wrong.empty()) {
    const std::size_t before = in.pos + to.pos;
    const std::size_t left = ZSTD_decompressStream(stream, &to, &in);
    if (ZSTD_isError(left) != 0)
      wrong = fmt::format("Zstandard: {}", ZSTD_getErrorName(left));
    else if (to.pos < to.size && (left == 0 || in.pos + to.pos == before))
      wrong = kTooFew;
  }
  ZSTD_freeDStream(stream);
  return wrong;
}

template <typename T>
void sum_differences(std::span<std::byte> row, std::size_t num_in_row, std::size_t stride) {
  for (std::size_t i = stride; i < num_in_row; ++i) {
    T before, here;
    std::memcpy(&before, &row[(i - stride) * sizeof(T)], sizeof(T));
    std::memcpy(&here, &row[i * sizeof(T)], sizeof(T));
    here = static_cast<T>(here + before);
    std::memcpy(&row[i * sizeof(T)], &here, sizeof(T));
  }
}

// The bytes of a row's floats stand highest first: all the highest, then the next. They come out in
// native byte order. `spare` is as long as the row.
void join_float_bytes(std::span<std::byte> row, std::size_t num_in_row, std::size_t size,
                      std::span<std::byte> spare) {
  std::copy(row.begin(), row.end(), spare.begin());
  for (std::size_t b = 0; b < size; ++b) {
    const std::size_t to = std::endian::native == std::endian::little ? size - 1 - b : b;
    for (std::size_t i = 0; i < num_in_row; ++i) row[i * size + to] = spare[b * num_in_row + i];
  }
}

}  // namespace

std::string tiff_compression_name(int compression) {
  switch (compression) {
    case 2:
    case 3:
    case 4:
      return "CCITT (fax)";
    case 6:
      return "JPEG of the old kind";
    case kTiffJpeg:
      return "JPEG";
    case 33003:
    case 33005:
    case 34712:
      return "JPEG 2000";
    case 34661:
      return "JBIG";
    case 34887:
      return "LERC";
    case 34925:
      return "LZMA";
    case 50001:
      return "WebP";
    default:
      return fmt::format("of kind {}", compression);
  }
}

bool is_read_compression(int compression) noexcept {
  return compression == kTiffPlain || compression == kTiffLzw || compression == kTiffDeflate ||
         compression == kTiffOldDeflate || compression == kTiffPackBits ||
         compression == kTiffZstandard || compression == kTiffJpeg;
}

std::int64_t max_tiff_ratio(int compression) noexcept {
  if (compression == kTiffPlain) return 1;
  if (compression == kTiffPackBits) return 64;
  if (compression == kTiffZstandard) return (128 << 10) / 3 + 1;
  if (compression == kTiffJpeg) return 32 * 32 * 4 * 8 / 10 + 1;
  return compression == kTiffLzw ? 4096 * 8 / 12 + 1 : kMaxDeflateRatio;
}

std::string unpack_tiff(int compression, std::span<const std::byte> packed,
                        std::span<std::byte> out) {
  if (compression == kTiffLzw) {
    // The first code clears the table; of the kind before TIFF 5 its bits are the other way round.
    if (packed.size() > 1 && packed[0] == std::byte{0} &&
        (packed[1] & std::byte{1}) != std::byte{0})
      return "is packed by LZW of the old kind, which is not read";
    return unpack_lzw(packed, out);
  }
  if (compression == kTiffPackBits) return unpack_bits(packed, out);
  if (compression == kTiffZstandard) return unpack_zstandard(packed, out);
  if (compression != kTiffPlain) return inflate_block(packed, out);
  if (packed.size() < out.size()) return kTooFew;
  std::copy_n(packed.begin(), out.size(), out.begin());
  return {};
}

void finish_tiff_rows(int predictor, const TiffRows& rows, std::span<std::byte> bytes) {
  const auto size = static_cast<std::size_t>(rows.bits / 8);
  const auto stride = static_cast<std::size_t>(rows.num_samples);
  std::vector<std::byte> spare(predictor == 3 ? rows.row_size : 0);
  const bool is_swapped = rows.is_big_endian != (std::endian::native == std::endian::big);
  if (is_swapped && predictor != 3 && rows.bits % 8 == 0 && size > 1) swap_bytes(bytes, size);
  if (predictor == 1) return;
  for (std::size_t at = 0; at < bytes.size(); at += rows.row_size) {
    const std::span<std::byte> row = bytes.subspan(at, rows.row_size);
    if (predictor == 3) {
      sum_differences<std::uint8_t>(row, row.size(), stride);
      join_float_bytes(row, rows.num_in_row, size, spare);
    } else if (size == 1) {
      sum_differences<std::uint8_t>(row, rows.num_in_row, stride);
    } else if (size == 2) {
      sum_differences<std::uint16_t>(row, rows.num_in_row, stride);
    } else if (size == 4) {
      sum_differences<std::uint32_t>(row, rows.num_in_row, stride);
    } else {
      sum_differences<std::uint64_t>(row, rows.num_in_row, stride);
    }
  }
}

void spread_tiff_bits(std::span<const std::byte> row, int bits, unsigned most,
                      std::span<std::byte> out) {
  const std::size_t size = bits > 8 ? 2 : 1;
  const unsigned mask = (1U << bits) - 1;
  std::uint32_t window = 0;
  int num_bits = 0;
  std::size_t in = 0;
  for (std::size_t at = 0; at < out.size(); at += size) {
    while (num_bits < bits) {
      window = window << 8U | static_cast<std::uint32_t>(row[in++]);
      num_bits += 8;
    }
    num_bits -= bits;
    unsigned value = window >> num_bits & mask;
    if (most > 0) value = value * most / mask;
    if (size == 1) {
      out[at] = static_cast<std::byte>(value);
    } else {
      const auto word = static_cast<std::uint16_t>(value);
      std::memcpy(&out[at], &word, 2);
    }
  }
}

}  // namespace ovoid::io
