// SPDX-License-Identifier: Apache-2.0
#include "io/core/header_lines.h"

#include <fmt/format.h>

#include <algorithm>

#include "ovoid/error.h"

namespace ovoid::io {

void HeaderField::fail(const std::string& what, ErrorCode code) const {
  throw Error(code, fmt::format("{}: line {}: {}: {}", source->name(), line, name, what));
}

std::string HeaderField::quoted() const { return fmt::format("'{}'", value.substr(0, 80)); }

bool HeaderLines::next(std::string& line) {
  constexpr std::int64_t kMaxHeaderSize = std::int64_t{16} << 20;
  constexpr std::int64_t kStep = std::int64_t{1} << 16;
  std::size_t end = find_end(position_);
  // One character more than the end, to see whether it is half of Windows'.
  while ((end == std::string::npos || end + 1 == text_.size()) &&
         static_cast<std::int64_t>(text_.size()) < source_.size()) {
    const auto searched = text_.size();
    if (static_cast<std::int64_t>(searched) >= kMaxHeaderSize) {
      throw Error(ErrorCode::kFileFormat, fmt::format("{}: the header does not end within {} bytes",
                                                      source_.name(), kMaxHeaderSize));
    }
    text_ += source_.text(static_cast<std::int64_t>(searched), kStep);
    if (end == std::string::npos) end = find_end(searched);
  }
  if (position_ >= text_.size()) return false;
  end = std::min(end, text_.size());
  line.assign(text_, position_, end - position_);
  const bool is_return = end < text_.size() && text_[end] == '\r';
  const bool is_windows =
      is_return && text_.compare(end, 2, "\r\n") == 0 && (number_ == 0 || !are_returns_);
  are_returns_ = (number_ == 0 || are_returns_) && is_return && !is_windows;
  position_ = std::min(end + (is_windows ? 2 : 1), text_.size());
  ++number_;
  return true;
}

}  // namespace ovoid::io
