// SPDX-License-Identifier: Apache-2.0
#include "io/zarr/zarr_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "io/core/zip_file.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostFolders = 10'000;  // that are listed right below one

class ZarrFolder final : public ZarrStore {
 public:
  ZarrFolder(std::string folder, Opener open)
      : folder_(std::move(folder)), open_(std::move(open)) {}

  std::string name_of(const std::string& key) const override {
    return (fs::path(folder_) / key).string();
  }

  std::unique_ptr<ByteSource> find(const std::string& key) const override {
    const std::string path = name_of(key);
    std::error_code error;
    // What is there and cannot be looked at is told by opening it.
    if (!fs::exists(path, error) && !error) return nullptr;
    return open_(path);
  }

  std::vector<std::string> folders_in(const std::string& key) const override {
    std::vector<std::string> names;
    std::error_code error;
    for (fs::directory_iterator entry(name_of(key), error), end; !error && entry != end;
         entry.increment(error)) {
      std::error_code ignored;
      if (entry->is_directory(ignored)) names.push_back(entry->path().filename().string());
      if (names.size() == kMostFolders) break;
    }
    std::sort(names.begin(), names.end());
    return names;
  }

 private:
  std::string folder_;
  Opener open_;
};

// An entry's bytes with what holds them.
class ZipValue final : public ByteSource {
 public:
  ZipValue(std::string name, ZipMember member)
      : ByteSource(std::move(name), member.source->size()), member_(std::move(member)) {}
  void read(std::int64_t offset, std::span<std::byte> out) const override {
    member_.source->read(offset, out);
  }

 private:
  ZipMember member_;
};

// The folder, with its slash, of the outermost description; none without one.
std::optional<std::string> zarr_root(const std::vector<ZipEntry>& entries) {
  std::optional<std::string> root;
  for (const ZipEntry& entry : entries) {
    const std::size_t end = entry.name.rfind('/') + 1;  // 0 without a slash
    if (!is_zarr_description(entry.name.substr(end))) continue;
    if (!root || end < root->size()) root = entry.name.substr(0, end);
  }
  return root;
}

class ZarrZip final : public ZarrStore {
 public:
  explicit ZarrZip(std::unique_ptr<ByteSource> source) : source_(std::move(source)) {
    const std::vector<ZipEntry> entries = read_zip_entries(*source_);
    const std::optional<std::string> root = zarr_root(entries);
    if (!root)
      throw Error(ErrorCode::kFileFormat, fmt::format("{}: holds no Zarr array", source_->name()));
    for (const ZipEntry& entry : entries)
      if (entry.name.starts_with(*root)) entries_.emplace(entry.name.substr(root->size()), entry);
  }

  std::string name_of(const std::string& key) const override {
    return key.empty() ? source_->name() : fmt::format("{}: {}", source_->name(), key);
  }

  std::unique_ptr<ByteSource> find(const std::string& key) const override {
    const auto found = entries_.find(key);
    if (found == entries_.end()) return nullptr;
    return std::make_unique<ZipValue>(name_of(key), open_zip_entry(*source_, found->second));
  }

  std::vector<std::string> folders_in(const std::string& key) const override {
    const std::string before = key.empty() ? "" : key + "/";
    std::set<std::string> names;
    for (auto entry = entries_.lower_bound(before);
         entry != entries_.end() && entry->first.starts_with(before); ++entry) {
      const std::size_t end = entry->first.find('/', before.size());
      if (end != std::string::npos)
        names.insert(entry->first.substr(before.size(), end - before.size()));
      if (names.size() == kMostFolders) break;
    }
    return {names.begin(), names.end()};
  }

 private:
  std::unique_ptr<ByteSource> source_;
  std::map<std::string, ZipEntry> entries_;
};

}  // namespace

std::shared_ptr<const ZarrStore> open_zarr_folder(const std::string& folder, const Opener& open) {
  return std::make_shared<ZarrFolder>(folder, open);
}

std::shared_ptr<const ZarrStore> open_zarr_zip(const ByteSource& source, const Opener& open) {
  return std::make_shared<ZarrZip>(open(source.name()));
}

bool is_zarr_zip(const ByteSource& source) {
  try {
    return zarr_root(read_zip_entries(source)).has_value();
  } catch (const Error&) {
    return false;
  }
}

std::string zarr_key(const std::string& group, const std::string& name) {
  return group.empty() ? name : group + "/" + name;
}

bool is_zarr_description(const std::string& file_name) {
  return file_name == ".zarray" || file_name == ".zgroup" || file_name == "zarr.json";
}

}  // namespace ovoid::io
