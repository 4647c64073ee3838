// SPDX-License-Identifier: Apache-2.0
#include "io/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace {

// The partial files of this process. A signal handler may walk the table at any moment, so it is
// plain memory guarded by one lock-free word per slot; no lock, no allocation.
struct PartialFileSlot {
  enum State : int { kFree, kBusy, kPublished };
  std::atomic<int> state{kFree};
  std::array<char, 4096> path{};  // PATH_MAX on Linux; longer paths are not published
};
static_assert(std::atomic<int>::is_always_lock_free);

// A process writes one or two files at a time; a file that finds no slot is still removed by its
// destructor.
std::array<PartialFileSlot, 16> partial_files;

int publish(const std::string& path) noexcept {
  if (path.size() >= partial_files[0].path.size()) return -1;
  for (std::size_t i = 0; i < partial_files.size(); ++i) {
    int expected = PartialFileSlot::kFree;
    PartialFileSlot& slot = partial_files[i];
    if (!slot.state.compare_exchange_strong(expected, PartialFileSlot::kBusy)) continue;
    std::memcpy(slot.path.data(), path.c_str(), path.size() + 1);
    slot.state.store(PartialFileSlot::kPublished);
    return static_cast<int>(i);
  }
  return -1;
}

void withdraw(int slot) noexcept {
  if (slot >= 0) partial_files[static_cast<std::size_t>(slot)].state.store(PartialFileSlot::kFree);
}

std::string reason(int error) { return std::generic_category().message(error); }

[[noreturn]] void throw_cannot_write(const std::string& path, const std::string& why) {
  throw Error(ErrorCode::kFileWrite, fmt::format("{}: cannot be written: {}", path, why));
}

// The file that `path` finally names. A dangling link, too, is followed to where its file would be.
std::string resolve_links(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_symlink(path, ignored)) return path;
  const std::filesystem::path resolved = std::filesystem::weakly_canonical(path, ignored);
  return ignored ? path : resolved.string();
}

bool exists_but_cannot_be_replaced(const std::string& path) {
  struct stat info {};
  return ::stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode);
}

}  // namespace

void remove_partial_files() noexcept {
  const int saved_errno = errno;
  for (PartialFileSlot& slot : partial_files) {
    if (slot.state.load() == PartialFileSlot::kPublished) ::unlink(slot.path.data());
  }
  errno = saved_errno;
}

namespace io {

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
  check_writable(path_);
  target_path_ = resolve_links(path_);
  const bool is_direct = exists_but_cannot_be_replaced(target_path_);
  partial_path_ = is_direct ? target_path_ : fmt::format("{}.part{}", target_path_, ::getpid());
  // A left-over of a killed process that had the same id is not worth keeping: O_TRUNC, not O_EXCL.
  descriptor_ = ::open(partial_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ < 0) throw_cannot_write(path_, reason(errno));
  if (!is_direct) slot_ = publish(partial_path_);
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) close_and_remove();
}

void AtomicFile::write(const void* data, std::size_t size) {
  const char* next = static_cast<const char*>(data);
  while (size > 0) {
    // Linux moves at most 2 GiB in one call.
    const ssize_t written = ::write(descriptor_, next, std::min<std::size_t>(size, 1U << 30U));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw_cannot_write(path_, reason(errno));
    next += written;
    size -= static_cast<std::size_t>(written);
  }
}

void AtomicFile::commit() {
  // Network file systems report a full disk here.
  const int closed = ::close(descriptor_);
  const int close_error = errno;
  descriptor_ = -1;
  const bool is_direct = partial_path_ == target_path_;
  const bool done =
      closed == 0 && (is_direct || std::rename(partial_path_.c_str(), target_path_.c_str()) == 0);
  const int error = closed == 0 ? errno : close_error;
  if (!done && !is_direct) ::unlink(partial_path_.c_str());
  withdraw(slot_);
  slot_ = -1;
  if (!done) throw_cannot_write(path_, reason(error));
}

void AtomicFile::close_and_remove() noexcept {
  ::close(descriptor_);
  if (partial_path_ != target_path_) ::unlink(partial_path_.c_str());
  withdraw(slot_);
}

void write_atomically(const std::string& path, std::string_view bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

void check_writable(const std::string& path) {
  if (path.empty()) throw Error(ErrorCode::kFileWrite, "output path: is empty");
  std::error_code ignored;
  const std::string target = resolve_links(path);
  if (std::filesystem::is_directory(target, ignored)) throw_cannot_write(path, "it is a folder");
  if (exists_but_cannot_be_replaced(target)) {
    if (::access(target.c_str(), W_OK) != 0) throw_cannot_write(path, reason(errno));
    return;
  }
  std::filesystem::path folder = std::filesystem::path(target).parent_path();
  if (folder.empty()) folder = ".";
  if (!std::filesystem::is_directory(folder, ignored)) {
    throw_cannot_write(path, fmt::format("the folder {} does not exist", folder.string()));
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    throw_cannot_write(path, fmt::format("the folder {}: {}", folder.string(), reason(errno)));
  }
}

}  // namespace io
}  // namespace ovoid
