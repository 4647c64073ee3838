// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <string>

namespace ovoid::io {

// Turns the line ends of Windows (\r\n) and of old Macs (\r) into \n, in any mixture, in text that
// comes in pieces.
class LineEnds {
 public:
  // Works in place; returns how many characters of the piece are left.
  std::size_t unify(std::span<char> piece) noexcept {
    if (piece.empty()) return 0;
    const bool skips_first = ended_with_return_ && piece.front() == '\n';
    ended_with_return_ = piece.back() == '\r';
    if (!skips_first && std::memchr(piece.data(), '\r', piece.size()) == nullptr)
      return piece.size();
    std::size_t kept = 0;
    for (std::size_t i = skips_first ? 1 : 0; i < piece.size(); ++i) {
      const bool is_return = piece[i] == '\r';
      if (is_return && i + 1 < piece.size() && piece[i + 1] == '\n') continue;
      piece[kept++] = is_return ? '\n' : piece[i];
    }
    return kept;
  }

 private:
  bool ended_with_return_ = false;  // whose \n may be the next piece's first
};

inline void unify_line_ends(std::string& text) { text.resize(LineEnds().unify(text)); }

}  // namespace ovoid::io
