// SPDX-License-Identifier: Apache-2.0
#include "io/text_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "ovoid/error.h"

namespace ovoid::io {

std::string read_text(const std::string& path, std::size_t max_bytes) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw Error(ErrorCode::kFileNotFound, fmt::format("{}: is a folder, must be a file", path));
  }
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    throw Error(ErrorCode::kFileNotFound, fmt::format("{}: cannot be read: {}", path,
                                                      std::strerror(errno != 0 ? errno : EIO)));
  }
  // By pieces, so that a pipe works and an endless one ends.
  std::string text;
  char piece[65536];
  while (text.size() <= max_bytes && stream) {
    stream.read(piece, sizeof(piece));
    text.append(piece, static_cast<std::size_t>(stream.gcount()));
  }
  if (stream.bad()) throw Error(ErrorCode::kFileNotFound, fmt::format("{}: cannot be read", path));
  require_size(text, max_bytes, path);
  return text;
}

void require_size(std::string_view text, std::size_t max_bytes, const std::string& path) {
  if (text.size() <= max_bytes) return;
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: must have at most {} bytes", path, max_bytes));
}

std::optional<double> parse_real(std::string_view text) noexcept {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

}  // namespace ovoid::io
