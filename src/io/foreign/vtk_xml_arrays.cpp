// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/vtk_xml_arrays.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>

#include "io/core/base64.h"
#include "io/core/numbers.h"
#include "io/core/samples.h"
#include "io/foreign/vtk_header_parts.h"

namespace ovoid::io {
namespace {

bool is_base64_digit(char c) { return value_of_base64_digit(c) >= 0; }

// VTK reads them as missing samples; it does not read infinity.
bool is_nan(std::string_view text) {
  const std::string word = lower(text);
  return word == "nan" || word == "-nan";
}

}  // namespace

std::int64_t XmlArrays::num_stated(const StoredArray& array) const {
  const StoredSize size = is_compressed ? compressed_size(array) : plain_size(array);
  return static_cast<std::int64_t>(size.num_stated);
}

std::optional<std::int64_t> XmlArrays::last_value(const StoredArray& array) const {
  if (array.format == "ascii") {
    TextScanner text(source_, array.position, array.text_end);
    std::string last;
    for (std::int64_t i = 0; i < array.num_values; ++i) last = text.word();
    return parse_integer(last).value_or(-1);
  }
  const auto size = static_cast<std::size_t>(array.value_size);
  std::string bytes;
  if (is_compressed) {
    if (max_ratio != kZlibRatio) return std::nullopt;
    bytes = inflated_end(array, size);
  } else {
    bytes = stored_bytes(array, word_size + array.num_bytes - array.value_size, size);
  }
  if (bytes.size() != size) fail_header(source_, "cells: offsets: the last one cannot be read");
  const std::uint64_t value = unsigned_of(bytes, is_big_endian);
  return value > static_cast<std::uint64_t>(kMaxNumBytes) ? -1 : static_cast<std::int64_t>(value);
}

// `count` bytes of an array without compressor, header included in `offset`.
std::string XmlArrays::stored_bytes(const StoredArray& array, std::int64_t offset,
                                    std::size_t count) const {
  const std::int64_t begin = data_begin(array);
  if (!is_base64(array)) return source_.text(begin + offset, static_cast<std::int64_t>(count));
  return base64_behind(array, 0, offset, count);
}

// The last `count` bytes that the last block of zlib data holds.
std::string XmlArrays::inflated_end(const StoredArray& array, std::size_t count) const {
  const auto num_blocks = static_cast<std::size_t>(stated_words(array, 1)[0]);
  const auto head = stated_words(array, 3 + num_blocks);
  std::int64_t begin = 0;
  for (std::size_t i = 3; i + 1 < head.size(); ++i) begin += static_cast<std::int64_t>(head[i]);
  const auto header = static_cast<std::int64_t>(head.size()) * word_size;
  const auto num_stored = static_cast<std::size_t>(head.back());
  // The header and the blocks are two pieces of base64.
  const std::string stored =
      is_base64(array)
          ? base64_behind(array, (header + 2) / 3 * 4, begin, num_stored)
          : source_.text(data_begin(array) + header + begin, static_cast<std::int64_t>(num_stored));
  const std::uint64_t size = head[2] > 0 ? head[2] : head[1];
  // At most 2 GiB is stated; what the block can hold bounds it.
  if (size / kZlibRatio > stored.size() + 1 || size < count) return {};
  std::string inflated(static_cast<std::size_t>(size), '\0');
  auto num_bytes = static_cast<uLongf>(size);
  const int status = ::uncompress(reinterpret_cast<Bytef*>(inflated.data()), &num_bytes,
                                  reinterpret_cast<const Bytef*>(stored.data()),
                                  static_cast<uLong>(stored.size()));
  if (status != Z_OK || num_bytes != size) return {};
  return inflated.substr(inflated.size() - count);
}

// `count` bytes from `offset` of the base64 that begins `num_digits` behind the array's first.
std::string XmlArrays::base64_behind(const StoredArray& array, std::int64_t num_digits,
                                     std::int64_t offset, std::size_t count) const {
  const auto skipped = static_cast<std::size_t>(offset % 3);
  const std::string text = source_.text(data_begin(array) + num_digits + offset / 3 * 4,
                                        static_cast<std::int64_t>((skipped + count) * 4 / 3 + 4));
  const std::string bytes = decoded_base64(text);
  return bytes.size() < skipped + count ? "" : bytes.substr(skipped, count);
}

void XmlArrays::check_ratio(const std::string& what, std::int64_t num_bytes) const {
  if (num_bytes / max_ratio > source_.size()) {
    fail_header(
        source_,
        fmt::format("{}: need {} bytes, which a file of {} bytes cannot hold: is it truncated?",
                    what, num_bytes, source_.size()));
  }
}

bool XmlArrays::is_base64(const StoredArray& array) const {
  return array.format != "appended" || !is_appended_raw;
}

// Where the array's bytes, or the digits that stand for them, begin and at most end.
std::int64_t XmlArrays::data_begin(const StoredArray& array) const {
  if (array.format == "appended") return appended_begin + std::min(array.position, source_.size());
  TextScanner text(source_, array.position, array.text_end);
  text.skip_blanks();
  return text.position();
}
std::int64_t XmlArrays::data_end(const StoredArray& array) const {
  return array.format == "appended" ? source_.size() : array.text_end;
}

// `count` words of the array's own header; empty if they are not there.
std::vector<std::uint64_t> XmlArrays::read_words(const StoredArray& array,
                                                 std::size_t count) const {
  const std::size_t num_bytes = count * static_cast<std::size_t>(word_size);
  const auto num_stored =
      static_cast<std::int64_t>(is_base64(array) ? num_bytes * 4 / 3 + 4 : num_bytes);
  std::string bytes = source_.text(data_begin(array), num_stored);
  if (is_base64(array)) bytes = decoded_base64(bytes);
  if (bytes.size() < num_bytes) return {};
  std::vector<std::uint64_t> result;
  const auto size = static_cast<std::size_t>(word_size);
  for (std::size_t i = 0; i < count; ++i)
    result.push_back(unsigned_of(std::string_view(bytes).substr(i * size, size), is_big_endian));
  return result;
}

void XmlArrays::check(const StoredArray& array) const {
  const std::string what = fmt::format("array '{}'", array.name);
  if (array.num_bytes == 0) return;
  if (array.format == "ascii") return check_text(array, what);
  check_ratio(what, array.num_bytes);
  if (array.is_text) return;
  if (array.format == "appended" && appended_begin == 0)
    fail_header(source_, what + ": its data are appended, but no AppendedData follow");
  const StoredSize size = is_compressed ? compressed_size(array) : plain_size(array);
  if (size.num_stated != static_cast<std::uint64_t>(array.num_bytes)) {
    fail_header(source_, fmt::format("{}: states {} bytes, {} need {}", what, size.num_stated,
                                     array.layout, array.num_bytes));
  }
  check_stored(array, what, size);
}

// Numbers between the tags.
void XmlArrays::check_text(const StoredArray& array, const std::string& what) const {
  // A digit and a blank for every number but the last.
  if (array.num_values > (array.text_end - array.position + 1) / 2) {
    fail_header(source_, fmt::format("{}: {} bytes of text cannot hold {}", what,
                                     array.text_end - array.position, array.layout));
  }
  if (array.is_text) return;
  TextScanner text(source_, array.position, array.text_end);
  for (std::int64_t i = 0; i < array.num_values; ++i) {
    const std::string_view word = text.word();
    if (is_number(word, array.kind)) continue;
    if (array.kind == NumberKind::kReal && is_nan(word)) continue;
    if (word.empty())
      fail_header(source_,
                  fmt::format("{}: holds {} numbers, {} need more", what, i, array.layout));
    fail_header(source_, fmt::format("{}: '{}' after {} numbers: expected {}", what,
                                     word.substr(0, 40), i, array.layout));
  }
}

XmlArrays::StoredSize XmlArrays::plain_size(const StoredArray& array) const {
  const std::uint64_t num_bytes = stated_words(array, 1)[0];
  return {num_bytes, word_size,
          static_cast<std::int64_t>(std::min<std::uint64_t>(num_bytes, kMaxNumBytes))};
}

std::vector<std::uint64_t> XmlArrays::stated_words(const StoredArray& array,
                                                   std::size_t count) const {
  auto result = read_words(array, count);
  if (result.empty())
    fail_header(source_, fmt::format("array '{}': its data are missing: is the file truncated?",
                                     array.name));
  return result;
}

// Compressed arrays begin with: number of blocks, size of each, size of the last if it is
// shorter, compressed size of every block.
XmlArrays::StoredSize XmlArrays::compressed_size(const StoredArray& array) const {
  const auto head = stated_words(array, 3);
  const auto [num_blocks, block_size, last_size] = std::array{head[0], head[1], head[2]};
  const auto file_size = static_cast<std::uint64_t>(source_.size());
  // VTK's writers make blocks of 32 KiB to 4 MiB.
  constexpr std::uint64_t kLargestBlock = std::uint64_t{1} << 31;
  const bool fits = num_blocks > 0 &&
                    num_blocks <= file_size / static_cast<std::uint64_t>(word_size) &&
                    block_size <= kLargestBlock && last_size <= block_size &&
                    num_blocks <= static_cast<std::uint64_t>(kMaxNumBytes) / kLargestBlock;
  if (!fits) {
    fail_header(
        source_,
        fmt::format(
            "array '{}': states {} blocks of {} bytes, the last of {}: the file has {} bytes",
            array.name, num_blocks, block_size, last_size, file_size));
  }
  const auto all = stated_words(array, 3 + static_cast<std::size_t>(num_blocks));
  StoredSize size;
  for (std::size_t i = 3; i < all.size(); ++i) {
    size.num_data += static_cast<std::int64_t>(std::min(all[i], file_size));
    if (all[i] > file_size || size.num_data > source_.size()) {
      fail_header(source_,
                  fmt::format("array '{}': states that block {} has {} bytes: the file has {}",
                              array.name, i - 3, all[i], file_size));
    }
  }
  size.num_header = static_cast<std::int64_t>(all.size()) * word_size;
  // At most kMaxNumBytes.
  size.num_stated = (last_size > 0 ? num_blocks - 1 : num_blocks) * block_size + last_size;
  return size;
}

// Are all bytes there? VTK leaves those that are not as memory happens to be.
void XmlArrays::check_stored(const StoredArray& array, const std::string& what,
                             const StoredSize& size) const {
  std::int64_t begin = data_begin(array);
  std::int64_t num_wanted = size.num_data;
  if (is_compressed) {
    if (is_base64(array)) {
      begin += (size.num_header + 2) / 3 * 4;
      // VTK looks for the blocks behind the padding of the header.
      if (size.num_header % 3 != 0 && source_.text(begin - 1, 1) != "=")
        fail_header(source_, what + ": its base64 does not end behind its header");
    } else {
      begin += size.num_header;
    }
  } else {
    num_wanted += size.num_header;  // one with the data
  }
  const std::int64_t num_there = is_base64(array)
                                     ? num_base64_digits(begin, data_end(array), num_wanted) * 6 / 8
                                     : data_end(array) - begin;
  if (num_there >= num_wanted) return;
  fail_header(source_,
              fmt::format("{}: holds {} bytes, its header says {}: is the file truncated?", what,
                          std::max<std::int64_t>(num_there - (num_wanted - size.num_data), 0),
                          size.num_data));
}

// Digits in a row from `begin`, counted until they hold `num_bytes`.
std::int64_t XmlArrays::num_base64_digits(std::int64_t begin, std::int64_t end,
                                          std::int64_t num_bytes) const {
  const std::int64_t most = std::min(end - begin, (num_bytes * 8 + 5) / 6);
  std::int64_t count = 0;
  while (count < most) {
    const std::string text = source_.text(begin + count, std::min(kTextWindow, most - count));
    const auto stop = std::find_if_not(text.begin(), text.end(), is_base64_digit);
    count += stop - text.begin();
    if (stop != text.end()) break;
  }
  return count;
}

}  // namespace ovoid::io
