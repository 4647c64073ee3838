// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/numbers.h"

namespace ovoid::io {

// Walks a part of a file by words, lines and bytes, and holds a piece of it at a time: files whose
// text and bytes take turns, and text of any length.
class TextScanner {
 public:
  // Longer words and lines are seen up to here.
  static constexpr std::size_t kLongestWord = 255;

  // From `begin` up to `end`, which is at most source.size().
  TextScanner(const ByteSource& source, std::int64_t begin, std::int64_t end)
      : source_(source), position_(begin), end_(end) {}

  std::int64_t position() const noexcept { return position_; }
  std::int64_t num_left() const noexcept { return end_ - position_; }

  // Up to `count` bytes from the position, fewer at the end; valid until the next call. `count` is
  // at most kLongestWord + 1.
  std::string_view ahead(std::size_t count);

  void skip_blanks();

  // The next word between blanks, behind which the position then is; empty at the end. A word with
  // more than kLongestWord characters is returned with one more than that, and not passed.
  std::string_view word();

  // The first kLongestWord characters of the line that begins here, which is passed; without its
  // end. Empty at the end of the part.
  std::optional<std::string> line();

  // Passes `count` bytes, at most num_left().
  void skip(std::int64_t count) noexcept { position_ += count; }

 private:
  const ByteSource& source_;
  std::int64_t position_;
  std::int64_t end_;
  std::string window_;  // a piece of the part
  std::int64_t window_begin_ = 0;
};

// What the locale "C" calls blank: space, \t, \n, \v, \f, \r.
bool is_blank(char c) noexcept;

std::string lower(std::string_view text);                    // ASCII letters only
std::vector<std::string_view> words(std::string_view text);  // between blanks
std::string_view trimmed(std::string_view text) noexcept;    // without blanks around it

// Does the whole text look like a number, as C++ streams read it? Its range is not looked at.
enum class NumberKind { kInteger, kReal };
bool is_number(std::string_view text, NumberKind kind) noexcept;

}  // namespace ovoid::io
