// SPDX-License-Identifier: Apache-2.0
#include "io/images/data_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "io/core/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {

std::string DataFiles::name(std::int64_t index) const {
  if (!names.empty()) return names[static_cast<std::size_t>(index)];
  const std::int64_t number = first + index * step;
  std::string digits = std::to_string(number < 0 ? -number : number);
  const std::string sign = number < 0 ? "-" : "";
  const auto missing =
      static_cast<std::ptrdiff_t>(width) - static_cast<std::ptrdiff_t>(digits.size() + sign.size());
  const std::string fill(static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, missing)), padding);
  return before + (padding == '0' ? sign + fill : fill + sign) + digits + after;
}

bool parse_numbered_name(std::string_view pattern, DataFiles& files) {
  const auto percent = pattern.find('%');
  if (percent == std::string_view::npos) return false;
  auto end = percent + 1;
  files.padding = ' ';
  if (end < pattern.size() && pattern[end] == '0') files.padding = pattern[end++];
  int width = 0;
  while (end < pattern.size() && pattern[end] >= '0' && pattern[end] <= '9' && width < 100) {
    width = 10 * width + (pattern[end++] - '0');
  }
  if (end >= pattern.size() ||
      (pattern[end] != 'd' && pattern[end] != 'i' && pattern[end] != 'u') || width > 20)
    return false;
  files.width = width;
  files.before = pattern.substr(0, percent);
  files.after = pattern.substr(end + 1);
  return files.after.find('%') == std::string::npos;
}

bool number_files(DataFiles& files, std::int32_t first, std::int32_t last, std::int32_t step) {
  if (step == 0 || (last != first && (step > 0) != (last > first))) return false;
  files.first = first;
  files.step = step;
  files.count = (static_cast<std::int64_t>(last) - first) / step + 1;
  return true;
}

DataParts divide_samples(const std::string& where, const DataFiles& files,
                         std::vector<std::int64_t> sizes, ScalarType type, std::int64_t num_bytes) {
  DataParts parts{files.count, num_bytes, {}};
  const auto dimension = static_cast<int>(sizes.size());
  const int subdimension =
      files.subdimension.value_or(parts.count == 1 ? dimension : dimension - 1);
  if (subdimension == dimension) {
    // Slabs of equal thickness along the slowest axis.
    if (sizes.back() % parts.count != 0) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: {} files cannot share the {} slices of sizes {} evenly", where,
                              parts.count, sizes.back(), dims_text(sizes)));
    }
    sizes.back() /= parts.count;
  } else {
    const std::int64_t num_needed =
        *checked_product(std::span(sizes).subspan(static_cast<std::size_t>(subdimension)));
    if (num_needed != parts.count) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: names {} files, sizes {} with {} axes in each need {}", where,
                              parts.count, dims_text(sizes), subdimension, num_needed));
    }
    sizes.resize(static_cast<std::size_t>(subdimension));
  }
  parts.num_bytes_each = num_bytes / parts.count;
  parts.layout_each = layout_text(sizes, type);
  return parts;
}

std::unique_ptr<ByteSource> open_data_file(const ByteSource& header, const std::string& where,
                                           const std::string& name, const Opener& open) {
  const std::string path = path_beside(header.name(), name);
  if (path == std::filesystem::path(header.name()).lexically_normal()) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: '{}': is the header itself", where, name));
  }
  try {
    return open(path);
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("{}: {}", where, error.what()));
  }
}

}  // namespace ovoid::io
