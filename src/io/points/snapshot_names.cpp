// SPDX-License-Identifier: Apache-2.0
#include "io/points/snapshot_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "io/core/numbers.h"

namespace ovoid::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostSiblings = 65536;

bool is_part_number(const std::string& text) {
  return !text.empty() && text.size() < 10 &&
         text.find_first_not_of("0123456789") == std::string::npos &&
         (text == "0" || text[0] != '0');
}

}  // namespace

std::string SnapshotPart::path(std::int64_t of_number) const {
  return fmt::format("{}.{}{}", stem, of_number, ending);
}

std::optional<SnapshotPart> snapshot_part(const std::string& path) {
  const std::size_t begin = path.rfind('/') + 1;  // 0 if there is none
  const auto dot_before = [&](std::size_t end) {
    const auto dot = end > begin ? path.rfind('.', end - 1) : std::string::npos;
    return dot != std::string::npos && dot > begin ? dot : std::string::npos;
  };
  std::size_t end = path.size();
  for (int i = 0; i < 2; ++i) {  // the last word, or the one before it
    const std::size_t dot = dot_before(end);
    if (dot == std::string::npos) return std::nullopt;
    const std::string word = path.substr(dot + 1, end - dot - 1);
    if (is_part_number(word))
      return SnapshotPart{path.substr(0, dot), parse_integer(word).value_or(0), path.substr(end)};
    end = dot;
  }
  return std::nullopt;
}

std::vector<std::string> snapshot_siblings(const ByteSource& source) {
  std::vector<std::string> siblings;
  const auto own = snapshot_part(source.name());
  if (!own) return siblings;
  std::error_code error;
  const fs::path folder = fs::path(source.name()).parent_path();
  const fs::path real_folder = fs::canonical(folder.empty() ? "." : folder, error);
  const fs::path linked_folder = fs::canonical(source.name(), error).parent_path();
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end;
       !error && entry != end && siblings.size() < kMostSiblings; entry.increment(error)) {
    const std::string path = (folder / entry->path().filename()).string();
    const auto other = snapshot_part(path);
    if (!other || other->stem != own->stem || other->ending != own->ending ||
        other->number == own->number)
      continue;
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored)) continue;
    const fs::path real = fs::canonical(path, ignored).parent_path();
    if (real == real_folder || real == linked_folder) siblings.push_back(path);
  }
  std::sort(siblings.begin(), siblings.end());
  return siblings;
}

}  // namespace ovoid::io
