// SPDX-License-Identifier: Apache-2.0
#include "io/core/text_file.h"

#include <fmt/format.h>

#include "io/core/byte_source.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::io {

std::string read_text(const std::string& path, std::size_t max_bytes) {
  const auto source = open_file(path);
  require_size(static_cast<std::size_t>(source->size()), max_bytes, path);
  return source->text(0, source->size());
}

void require_size(std::size_t num_bytes, std::size_t max_bytes, const std::string& path) {
  if (num_bytes <= max_bytes) return;
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: must have at most {} bytes", path, max_bytes));
}

}  // namespace ovoid::io

namespace ovoid {

std::string read_text_file(const std::string& path, std::size_t max_bytes) {
  return io::read_text(path, max_bytes);
}

}  // namespace ovoid
