// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <string>
#include <string_view>

namespace ovoid::io {

// An output file that appears whole or not at all. Bytes go to a file of a random name in the
// target's folder, made anew (no file or link of that name is followed or kept), which commit()
// renames over the target; destroyed without commit(), the partial file is removed and an existing
// target stays as it was.
//
// - What is replaced keeps its owner, group, mode and access list, as far as the system lets the
//   caller; where the group cannot be kept, its members get no more than everybody. Until commit()
//   nobody else can read the partial file of a target that exists.
// - A target that is a symbolic link stays one: the file that it points to is replaced, if the
//   system lets the caller follow it.
// - commit() returns when file and name are on the disk, as far as the system tells.
// - Devices and pipes cannot be renamed and are written directly.
//
// Not thread-safe; several files may be open at once.
class AtomicFile {
 public:
  // Creates the partial file. Triggered, `stop` makes write() and commit() throw Error(kCancelled).
  // Throws Error(kFileWrite) naming the path and the system's reason, kCancelled.
  explicit AtomicFile(std::string path, std::stop_token stop = {});
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // Appends `size` bytes. Throws Error(kFileWrite, kCancelled).
  void write(const void* data, std::size_t size);
  void write(std::string_view bytes) { write(bytes.data(), bytes.size()); }

  // Where the bytes go until commit(), for libraries that want a name: they may replace the content
  // of this file.
  const std::string& partial_path() const noexcept { return partial_path_; }

  // Puts the file in its place, at once or with others (FilesTogether). Nothing may be written
  // afterwards. Throws Error(kFileWrite, kCancelled); then nothing is left behind.
  void commit();

  // The same under another name in the target's folder, which must be nobody's yet; the target
  // stays, and its rights are kept all the same.
  void commit_as(const std::string& name);

 private:
  void push_out() noexcept;
  void finish();
  void settle() noexcept;
  void close_and_remove() noexcept;

  std::string path_;          // as given, for messages
  std::string target_path_;   // with symbolic links resolved
  std::string partial_path_;  // target_path_ itself for devices and pipes
  std::stop_token stop_;
  std::int64_t num_written_ = 0;
  std::int64_t num_pushed_ = 0;  // of these the disk was asked to take
  int descriptor_ = -1;
  int slot_ = -1;            // in the table that remove_partial_files() walks; -1: not in it
  bool is_pending_ = false;  // the partial file is there, and is to be renamed or removed
};

// Writes `bytes` as the whole content of `path`, as AtomicFile does. Throws Error(kFileWrite,
// kCancelled).
void write_atomically(const std::string& path, std::string_view bytes, std::stop_token stop = {});

// Throws Error(kCancelled) if the token was triggered.
void check_stop(const std::stop_token& stop);

// Checks that `path` could be written now: its folder exists and can be written, it is no folder
// itself, and the system takes the name. Creates nothing. Throws Error(kFileWrite).
void check_writable(const std::string& path);

// A file that remove_partial_files() removes while this lives: one that stands under its last name
// before all that belongs to it does.
class PublishedFile {
 public:
  explicit PublishedFile(const std::string& path) noexcept;
  ~PublishedFile();
  PublishedFile(const PublishedFile&) = delete;
  PublishedFile& operator=(const PublishedFile&) = delete;

 private:
  int slot_;
};

// 16 digits that nobody can guess. Throws Error(kFileWrite) where the system has no randomness.
std::string random_digits();

// Waits until the names in the folder of `path` are on the disk, as far as the system does that.
void sync_folder_of(const std::string& path) noexcept;

}  // namespace ovoid::io
