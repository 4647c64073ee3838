// SPDX-License-Identifier: Apache-2.0
#include "data/names_text.h"

#include <fmt/format.h>

#include <algorithm>

namespace ovoid::data {

std::string name_text(std::string_view name) {
  constexpr std::size_t kLongest = 60;
  if (name.size() <= kLongest) return fmt::format("'{}'", name);
  std::size_t end = kLongest;
  // Not within a character of UTF-8.
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0U) == 0x80) --end;
  return fmt::format("'{}...'", name.substr(0, end));
}

std::string names_text(std::span<const std::string> names) {
  constexpr std::size_t kMost = 10;
  if (names.empty()) return "none";
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
    text += (i > 0 ? ", " : "") + name_text(names[i]);
  if (names.size() > kMost) text += fmt::format(" and {} more", names.size() - kMost);
  return text;
}

}  // namespace ovoid::data
