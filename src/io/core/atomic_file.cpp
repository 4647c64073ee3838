// SPDX-License-Identifier: Apache-2.0
#include "io/core/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/output_files.h"

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
  constexpr int kMostLinks = 40;  // the system's own bound; longer chains it has refused
  std::error_code ignored;
  std::filesystem::path file = path;
  for (int i = 0; i < kMostLinks && std::filesystem::is_symlink(file, ignored); ++i)
    file = file.parent_path() / std::filesystem::read_symlink(file, ignored);
  return file.string();
}

bool exists_but_cannot_be_replaced(const std::string& path) {
  struct stat info {};
  return ::stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode);
}

bool is_regular(const std::string& path, struct stat* info) {
  return ::lstat(path.c_str(), info) == 0 && S_ISREG(info->st_mode);
}

std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

// The access list of `from`, or that it has none (a new file may have got one from its folder).
// False if it could not be kept.
bool keep_access_list(int descriptor, const std::string& from) noexcept {
#ifdef __linux__
  constexpr const char* kName = "system.posix_acl_access";
  std::array<char, 4096> list{};  // 500 entries; file systems hold fewer
  const ssize_t size = ::lgetxattr(from.c_str(), kName, list.data(), list.size());
  if (size > 0)
    return ::fsetxattr(descriptor, kName, list.data(), static_cast<std::size_t>(size), 0) == 0;
  if (size < 0 && errno != ENODATA && errno != ENOTSUP) return false;
  ::fremovexattr(descriptor, kName);
#endif
  return true;
}

// Owner, group, mode and access list of the file that is replaced. Where the group or the list
// cannot be kept, others in the group get what everybody has, not what was meant for someone else.
void keep_rights(int descriptor, const std::string& target) noexcept {
  struct stat old {
  }, own{};
  if (!is_regular(target, &old) || ::fstat(descriptor, &own) != 0) return;
  constexpr mode_t kRights = 0777, kGroup = 070, kEverybody = 07;
  mode_t mode = old.st_mode & kRights;
  const bool has_group =
      old.st_gid == own.st_gid || ::fchown(descriptor, static_cast<uid_t>(-1), old.st_gid) == 0;
  if (!has_group || !keep_access_list(descriptor, target))
    mode = (mode & ~kGroup) | (mode & ((mode & kEverybody) << 3U));
  ::fchmod(descriptor, mode);
  // Only the superuser may give files away.
  if (old.st_uid != own.st_uid && ::fchown(descriptor, old.st_uid, static_cast<gid_t>(-1)) != 0)
    return;
}

// False, with errno set, if the disk did not take it. Some file systems cannot tell.
bool sync(int descriptor) noexcept {
  while (::fsync(descriptor) != 0) {
    if (errno == EINTR) continue;
    return errno == EINVAL || errno == ENOTSUP || errno == ENOSYS || errno == EROFS;
  }
  return true;
}

void remove_quietly(const std::string& path) noexcept { ::unlink(path.c_str()); }

struct CloseFile {
  void operator()(const int* descriptor) const noexcept { ::close(*descriptor); }
};

}  // namespace

// A whole file that has no name yet.
struct NamelessFile {
  std::string path;     // as given, for messages
  std::string target;   // with symbolic links resolved
  std::string partial;  // where it lies
  std::string kept;     // what it replaces, while it may have to come back; empty: nothing
  int slot = -1;
  bool is_new = true;  // nothing was there
};

struct FilesTogether::Impl {
  std::vector<NamelessFile> files;

  // Under its name, with what was there before beside it.
  void place(NamelessFile& file) const {
    struct stat info {};
    file.is_new = ::lstat(file.target.c_str(), &info) != 0;
    std::string kept = fmt::format("{}.kept", file.partial);
    if (!file.is_new && ::link(file.target.c_str(), kept.c_str()) == 0) file.kept = std::move(kept);
    if (::rename(file.partial.c_str(), file.target.c_str()) != 0)
      throw_cannot_write(file.path, reason(errno));
  }
  void take_back(NamelessFile& file) const noexcept {
    if (!file.kept.empty())
      ::rename(file.kept.c_str(), file.target.c_str());
    else if (file.is_new)
      remove_quietly(file.target);
  }
  void forget(NamelessFile& file) const noexcept {
    if (!file.kept.empty()) remove_quietly(file.kept);
    withdraw(file.slot);
  }
};

namespace {

thread_local FilesTogether::Impl* files_together = nullptr;

}  // namespace

FilesTogether::FilesTogether() : impl_(std::make_unique<Impl>()) { files_together = impl_.get(); }

FilesTogether::~FilesTogether() {
  files_together = nullptr;
  for (NamelessFile& file : impl_->files) {
    remove_quietly(file.partial);
    impl_->forget(file);
  }
}

void FilesTogether::commit() {
  files_together = nullptr;
  std::size_t num_placed = 0;
  try {
    for (; num_placed < impl_->files.size(); ++num_placed) impl_->place(impl_->files[num_placed]);
  } catch (...) {
    while (num_placed > 0) impl_->take_back(impl_->files[--num_placed]);
    throw;
  }
  for (NamelessFile& file : impl_->files) {
    impl_->forget(file);
    io::sync_folder_of(file.target);
  }
  impl_->files.clear();
}

std::int64_t size_of_written(const std::string& path) {
  std::string place = path;
  if (files_together != nullptr) {
    for (const NamelessFile& file : files_together->files) {
      if (file.path == path) place = file.partial;
    }
  }
  std::error_code error;
  const auto size = std::filesystem::file_size(place, error);
  if (error) throw Error(ErrorCode::kFileNotFound, fmt::format("'{}': {}", path, error.message()));
  return static_cast<std::int64_t>(size);
}

void remove_partial_files() noexcept {
  const int saved_errno = errno;
  for (PartialFileSlot& slot : partial_files) {
    if (slot.state.load() == PartialFileSlot::kPublished) ::unlink(slot.path.data());
  }
  errno = saved_errno;
}

void check_file_path(const std::string& path) { io::check_writable(path); }

void write_file(const std::string& path, std::string_view bytes) {
  io::write_atomically(path, bytes);
}

void replace_file(const std::string& from, const std::string& to) {
  io::check_writable(to);
  const std::string target = resolve_links(to);
  const int descriptor = ::open(from.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (descriptor < 0) throw_cannot_write(to, fmt::format("{}: {}", from, reason(errno)));
  const std::unique_ptr<const int, CloseFile> closing(&descriptor);
  keep_rights(descriptor, target);
  if (!sync(descriptor)) throw_cannot_write(to, reason(errno));
  if (::rename(from.c_str(), target.c_str()) == 0) return io::sync_folder_of(target);
  if (errno != EXDEV) throw_cannot_write(to, reason(errno));
  // The target is a link to another file system.
  io::AtomicFile copy(to);
  std::vector<char> piece(std::size_t{1} << 20);
  ssize_t size = 0;
  while ((size = ::read(descriptor, piece.data(), piece.size())) > 0)
    copy.write(piece.data(), static_cast<std::size_t>(size));
  if (size < 0) throw_cannot_write(to, fmt::format("{}: {}", from, reason(errno)));
  copy.commit();
  ::unlink(from.c_str());
}

namespace io {

std::string random_digits() {
  std::array<unsigned char, 8> bytes{};
  std::size_t size = 0;
  while (size < bytes.size()) {
    const ssize_t got = ::getrandom(bytes.data() + size, bytes.size() - size, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw Error(ErrorCode::kFileWrite, "random number: " + reason(errno));
    size += static_cast<std::size_t>(got);
  }
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

void sync_folder_of(const std::string& path) noexcept try {
  const int descriptor = ::open(folder_of(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;  // one may write into a folder that one may not read
  sync(descriptor);
  ::close(descriptor);
} catch (const std::bad_alloc&) {  // the file is in its place, only not for sure after a crash
}

void check_stop(const std::stop_token& stop) {
  if (stop.stop_requested()) throw Error(ErrorCode::kCancelled, "cancelled");
}

PublishedFile::PublishedFile(const std::string& path) noexcept : slot_(publish(path)) {}
PublishedFile::~PublishedFile() { withdraw(slot_); }

AtomicFile::AtomicFile(std::string path, std::stop_token stop)
    : path_(std::move(path)), stop_(std::move(stop)) {
  check_stop(stop_);
  check_writable(path_);
  target_path_ = resolve_links(path_);
  const bool is_direct = exists_but_cannot_be_replaced(target_path_);
  if (is_direct) {
    partial_path_ = target_path_;
    descriptor_ = ::open(partial_path_.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0) throw_cannot_write(path_, reason(errno));
    return;
  }
  // A name of its own, so that a target's name may be as long as the file system allows.
  partial_path_ = (std::filesystem::path(target_path_).parent_path() /
                   fmt::format("ovoid-{}.part", random_digits()))
                      .string();
  struct stat ignored {};
  const mode_t mode = is_regular(target_path_, &ignored) ? 0600 : 0666;
  slot_ = publish(partial_path_);  // before it is there, so that no signal finds it unknown
  descriptor_ =
      ::open(partial_path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
  if (descriptor_ < 0) {
    const int error = errno;
    withdraw(slot_);
    throw_cannot_write(path_, reason(error));
  }
  is_pending_ = true;
}

AtomicFile::~AtomicFile() { close_and_remove(); }

void AtomicFile::write(const void* data, std::size_t size) {
  // So much is written between two looks at the token: some milliseconds.
  constexpr std::size_t kPiece = std::size_t{4} << 20;
  const char* next = static_cast<const char*>(data);
  while (size > 0) {
    check_stop(stop_);
    const ssize_t written = ::write(descriptor_, next, std::min(size, kPiece));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw_cannot_write(path_, reason(errno));
    next += written;
    size -= static_cast<std::size_t>(written);
    num_written_ += written;
    push_out();
  }
}

// Hands the disk what was written bit by bit: all at once in commit() would take seconds in which
// nothing can stop the program.
void AtomicFile::push_out() noexcept {
#ifdef SYNC_FILE_RANGE_WRITE
  constexpr std::int64_t kWindow = std::int64_t{8} << 20;
  if (!is_pending_ || num_written_ - num_pushed_ < kWindow) return;
  if (num_pushed_ >= kWindow) {
    ::sync_file_range(
        descriptor_, num_pushed_ - kWindow, kWindow,
        SYNC_FILE_RANGE_WAIT_BEFORE | SYNC_FILE_RANGE_WRITE | SYNC_FILE_RANGE_WAIT_AFTER);
  }
  ::sync_file_range(descriptor_, num_pushed_, num_written_ - num_pushed_, SYNC_FILE_RANGE_WRITE);
  num_pushed_ = num_written_;
#endif
}

// What comes before the file gets its name.
void AtomicFile::finish() {
  if (descriptor_ < 0) return;
  check_stop(stop_);
  if (is_pending_) keep_rights(descriptor_, target_path_);
  const bool is_synced = !is_pending_ || sync(descriptor_);
  const int sync_error = errno;
  // Network file systems report a full disk here.
  const bool is_closed = ::close(std::exchange(descriptor_, -1)) == 0;
  const int error = is_synced ? errno : sync_error;
  if (!is_synced || !is_closed) throw_cannot_write(path_, reason(error));
  check_stop(stop_);
}

void AtomicFile::settle() noexcept {
  is_pending_ = false;
  withdraw(std::exchange(slot_, -1));
  sync_folder_of(target_path_);
}

void AtomicFile::commit() try {
  finish();
  if (!is_pending_) return;
  if (files_together != nullptr) {
    files_together->files.push_back({path_, target_path_, partial_path_, "", slot_});
    slot_ = -1;
    is_pending_ = false;
    return;
  }
  if (::rename(partial_path_.c_str(), target_path_.c_str()) != 0)
    throw_cannot_write(path_, reason(errno));
  settle();
} catch (...) {
  close_and_remove();
  throw;
}

void AtomicFile::commit_as(const std::string& name) try {
  finish();
  if (::link(partial_path_.c_str(), name.c_str()) == 0) {
    ::unlink(partial_path_.c_str());
  } else {
    struct stat ignored {};
    const bool is_taken = errno == EEXIST || ::lstat(name.c_str(), &ignored) == 0;
    if (is_taken) throw_cannot_write(name, reason(EEXIST));
    // A file system without links.
    if (::rename(partial_path_.c_str(), name.c_str()) != 0) throw_cannot_write(name, reason(errno));
  }
  settle();
} catch (...) {
  close_and_remove();
  throw;
}

void AtomicFile::close_and_remove() noexcept {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  if (std::exchange(is_pending_, false)) ::unlink(partial_path_.c_str());
  withdraw(std::exchange(slot_, -1));
}

void write_atomically(const std::string& path, std::string_view bytes, std::stop_token stop) {
  AtomicFile file(path, std::move(stop));
  file.write(bytes);
  file.commit();
}

void check_writable(const std::string& path) {
  if (path.empty()) throw Error(ErrorCode::kFileWrite, "output path: is empty");
  std::error_code ignored;
  struct stat info {};
  const int error = ::stat(path.c_str(), &info) == 0 ? 0 : errno;
  // The system may refuse to follow a link that somebody else has laid.
  const bool is_lost_link =
      error != 0 && error != ENOENT && std::filesystem::is_symlink(path, ignored);
  if (error == ELOOP || error == ENAMETOOLONG || is_lost_link)
    throw_cannot_write(path, reason(error));
  const std::string target = resolve_links(path);
  if (std::filesystem::is_directory(target, ignored)) throw_cannot_write(path, "it is a folder");
  if (exists_but_cannot_be_replaced(target)) {
    if (::access(target.c_str(), W_OK) != 0) throw_cannot_write(path, reason(errno));
    return;
  }
  const std::string folder = folder_of(target);
  if (!std::filesystem::is_directory(folder, ignored))
    throw_cannot_write(path, fmt::format("the folder {} does not exist", folder));
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    throw_cannot_write(path, fmt::format("the folder {}: {}", folder, reason(errno)));
}

}  // namespace io
}  // namespace ovoid
