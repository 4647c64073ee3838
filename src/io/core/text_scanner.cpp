// SPDX-License-Identifier: Apache-2.0
#include "io/core/text_scanner.h"

#include <algorithm>

namespace ovoid::io {
namespace {

// Passes the digits at the front; tells whether there are any.
bool skip_digits(std::string_view& text) noexcept {
  const std::size_t before = text.size();
  while (!text.empty() && text.front() >= '0' && text.front() <= '9') text.remove_prefix(1);
  return text.size() < before;
}

void skip_sign(std::string_view& text) noexcept {
  if (!text.empty() && (text.front() == '+' || text.front() == '-')) text.remove_prefix(1);
}

}  // namespace

bool is_blank(char c) noexcept { return c == ' ' || (c >= '\t' && c <= '\r'); }

std::string_view TextScanner::ahead(std::size_t count) {
  const auto wanted = std::min(static_cast<std::int64_t>(count), num_left());
  const auto window_size = static_cast<std::int64_t>(window_.size());
  if (position_ < window_begin_ || position_ + wanted > window_begin_ + window_size) {
    window_ = source_.text(position_, std::min(kTextWindow, num_left()));
    window_begin_ = position_;
  }
  return std::string_view(window_).substr(static_cast<std::size_t>(position_ - window_begin_),
                                          static_cast<std::size_t>(wanted));
}

void TextScanner::skip_blanks() {
  while (true) {
    const std::string_view text = ahead(kLongestWord);
    const auto* const begin = std::find_if_not(text.begin(), text.end(), is_blank);
    position_ += begin - text.begin();
    if (text.empty() || begin != text.end()) return;
  }
}

std::string_view TextScanner::word() {
  skip_blanks();
  const std::string_view text = ahead(kLongestWord + 1);
  const auto* const end = std::find_if(text.begin(), text.end(), is_blank);
  const auto size = end - text.begin();
  if (static_cast<std::size_t>(size) <= kLongestWord) position_ += size;
  return text.substr(0, static_cast<std::size_t>(size));
}

std::optional<std::string> TextScanner::line() {
  if (num_left() == 0) return std::nullopt;
  std::string result;
  for (bool has_ended = false; !has_ended && num_left() > 0;) {
    const std::string_view text = ahead(kLongestWord);
    const auto size = std::min(text.find('\n'), text.size());
    if (result.size() < kLongestWord)
      result += text.substr(0, std::min(size, kLongestWord - result.size()));
    has_ended = size < text.size();
    position_ += static_cast<std::int64_t>(size) + (has_ended ? 1 : 0);
  }
  return result;
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

std::vector<std::string_view> words(std::string_view text) {
  std::vector<std::string_view> result;
  while (true) {
    const auto* const begin = std::find_if_not(text.begin(), text.end(), is_blank);
    const auto* const end = std::find_if(begin, text.end(), is_blank);
    if (begin == text.end()) return result;
    result.push_back(text.substr(static_cast<std::size_t>(begin - text.begin()),
                                 static_cast<std::size_t>(end - begin)));
    text.remove_prefix(static_cast<std::size_t>(end - text.begin()));
  }
}

std::string_view trimmed(std::string_view text) noexcept {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

bool is_number(std::string_view text, NumberKind kind) noexcept {
  skip_sign(text);
  bool has_digits = skip_digits(text);
  if (kind == NumberKind::kReal) {
    if (text.starts_with('.')) {
      text.remove_prefix(1);
      has_digits = skip_digits(text) || has_digits;
    }
    if (has_digits && (text.starts_with('e') || text.starts_with('E'))) {
      text.remove_prefix(1);
      skip_sign(text);
      has_digits = skip_digits(text);
    }
  }
  return has_digits && text.empty();
}

}  // namespace ovoid::io
