// SPDX-License-Identifier: Apache-2.0
#include "io/header_lines.h"

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
  std::size_t end = text_.find('\n', position_);
  while (end == std::string::npos && static_cast<std::int64_t>(text_.size()) < source_.size()) {
    const auto searched = text_.size();
    if (static_cast<std::int64_t>(searched) >= kMaxHeaderSize) {
      throw Error(ErrorCode::kFileFormat, fmt::format("{}: the header does not end within {} bytes",
                                                      source_.name(), kMaxHeaderSize));
    }
    text_ += source_.text(static_cast<std::int64_t>(searched), kStep);
    end = text_.find('\n', searched);
  }
  if (position_ >= text_.size()) return false;
  end = std::min(end, text_.size());
  line.assign(text_, position_, end - position_);
  if (line.ends_with('\r')) line.pop_back();
  position_ = std::min(end + 1, text_.size());
  ++number_;
  return true;
}

}  // namespace ovoid::io
