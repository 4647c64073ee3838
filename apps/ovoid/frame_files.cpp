// SPDX-License-Identifier: Apache-2.0
#include "frame_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>

#include "ovoid/error.h"
#include "ovoid/io.h"
#include "session.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kRecordStart = "# ovoid animate";
constexpr const char* kFirstLine =
    "# ovoid animate: what made each frame, and what its file then held; the same command keeps "
    "them";

std::size_t begin_of_name(const std::string& path) {
  const auto slash = path.rfind('/');
  return slash == std::string::npos ? 0 : slash + 1;
}

[[noreturn]] void refuse_pattern(const std::string& pattern) {
  throw UsageError(fmt::format(
      "--output '{}': expected exactly one number in the name, %d or %0Nd, as in frames_%04d.png",
      pattern));
}

// None if it is not there.
std::optional<std::string> content_of(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;  // a pipe would block
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  return file.bad() ? std::nullopt : std::optional(std::move(bytes));
}

[[noreturn]] void refuse_to_write(const std::string& path) {
  throw Error(ErrorCode::kFileWrite,
              fmt::format("{}: cannot be written: {}", path, std::strerror(errno)));
}

// What the record holds; nothing if there is none. A file of somebody else is not replaced.
std::string record_text(const std::string& path) {
  std::error_code ignored;
  const fs::file_status status = fs::symlink_status(path, ignored);
  if (!fs::exists(status)) return "";
  const auto text = fs::is_regular_file(status) ? content_of(path) : std::nullopt;
  if (text && (text->empty() || text->starts_with(kRecordStart))) return *text;
  throw Error(ErrorCode::kFileWrite,
              fmt::format("{}: is not ovoid's, and animate notes there which frames are whole: "
                          "move it, or choose another name for the frames",
                          path));
}

bool write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

bool FrameNames::is_pattern(const std::string& path) {
  return path.find('%', begin_of_name(path)) != std::string::npos;
}

FrameNames::FrameNames(const std::string& pattern) {
  constexpr int kWidest = 9;
  const auto percent = pattern.find('%', begin_of_name(pattern));
  if (percent == std::string::npos) refuse_pattern(pattern);
  auto end = percent + 1;
  if (end + 1 < pattern.size() && pattern[end] == '0') {
    width_ = pattern[end + 1] - '0';
    if (width_ < 1 || width_ > kWidest) refuse_pattern(pattern);
    end += 2;
  }
  if (end >= pattern.size() || pattern[end] != 'd') refuse_pattern(pattern);
  before_ = pattern.substr(0, percent);
  after_ = pattern.substr(end + 1);
  if (after_.find('%') != std::string::npos) refuse_pattern(pattern);
}

std::string FrameNames::path(std::int64_t number) const {
  return fmt::format("{}{:0{}}{}", before_, number, width_, after_);
}

std::string FrameNames::record_path() const {
  std::string stem = before_;
  const auto begin = begin_of_name(stem);
  while (stem.size() > begin && std::strchr("_-. ", stem.back()) != nullptr) stem.pop_back();
  return (stem.size() == begin ? stem + "frames" : stem) + ".ovoid";
}

std::uint64_t hash_of(std::string_view bytes, std::uint64_t seed) {
  std::uint64_t hash = seed;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return hash;
}

std::uint64_t settings_key(const std::string& command_line, const std::vector<std::string>& files) {
  std::string text = fmt::format("{}\n{}\n", OVOID_VERSION, command_line);
  for (const std::string& file : files) {
    std::error_code ignored;
    const auto size = fs::file_size(file, ignored);
    const auto changed = fs::last_write_time(file, ignored).time_since_epoch().count();
    text += fmt::format("{} {} {}\n", fs::absolute(file, ignored).string(), size, changed);
  }
  return hash_of(text);
}

FrameRecord::FrameRecord(FrameNames names) : names_(std::move(names)) {
  const std::string path = names_.record_path();
  std::istringstream lines(record_text(path));
  std::string line;
  while (std::getline(lines, line)) {
    std::istringstream fields(line);
    Entry entry;
    std::string name;
    fields >> std::hex >> entry.key >> entry.content;
    if (fields && std::getline(fields >> std::ws, name)) entries_[name] = entry;
  }
}

// Anew, so that it does not grow from run to run.
void FrameRecord::write() const {
  std::string text = std::string(kFirstLine) + '\n';
  for (const auto& [name, entry] : entries_)
    text += fmt::format("{:016x} {:016x} {}\n", entry.key, entry.content, name);
  write_file(names_.record_path(), text);
}

bool FrameRecord::is_whole(std::int64_t number, std::uint64_t key) const {
  const std::string path = names_.path(number);
  const auto entry = entries_.find(path.substr(begin_of_name(path)));
  if (entry == entries_.end() || entry->second.key != key) return false;
  const auto bytes = content_of(path);
  return bytes && hash_of(*bytes) == entry->second.content;
}

void FrameRecord::add(std::int64_t number, std::uint64_t key) {
  const std::string path = names_.path(number);
  const std::string name = path.substr(begin_of_name(path));
  const auto bytes = content_of(path);
  if (!bytes) refuse_to_write(path);
  const Entry entry{key, hash_of(*bytes)};
  entries_[name] = entry;
  if (!std::exchange(is_written_, true)) return write();
  const std::string record = names_.record_path();
  // Later lines are added to the file of the first: a whole one for each frame would be quadratic,
  // and of a line that is cut short no frame is believed.
  const int file = ::open(record.c_str(), O_WRONLY | O_APPEND | O_NOFOLLOW | O_CLOEXEC);
  if (file < 0) refuse_to_write(record);
  const bool is_written =
      write_all(file, fmt::format("{:016x} {:016x} {}\n", entry.key, entry.content, name));
  if (::close(file) != 0 || !is_written) refuse_to_write(record);
}

}  // namespace ovoid::cli
