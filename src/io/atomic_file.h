// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace ovoid::io {

// An output file that appears whole or not at all. Bytes go to "<path>.part<pid>" beside the
// target, which commit() renames over it; destroyed without commit(), the partial file is removed
// and an existing target stays as it was. A target that is a symbolic link stays one: the file it
// points to is replaced. Devices and pipes cannot be renamed and are written directly. Not
// thread-safe; several files may be open at once.
class AtomicFile {
 public:
  // Creates the partial file. Throws Error(kFileWrite) naming the path and the system's reason.
  explicit AtomicFile(std::string path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // Appends `size` bytes. Throws Error(kFileWrite).
  void write(const void* data, std::size_t size);
  void write(std::string_view bytes) { write(bytes.data(), bytes.size()); }

  // Where the bytes go until commit(), for libraries that want a name: they may replace the content
  // of this file.
  const std::string& partial_path() const noexcept { return partial_path_; }

  // Closes and renames. Nothing may be written afterwards. Throws Error(kFileWrite); then nothing
  // is left behind.
  void commit();

 private:
  void close_and_remove() noexcept;

  std::string path_;          // as given, for messages
  std::string target_path_;   // with symbolic links resolved
  std::string partial_path_;  // target_path_ itself for devices and pipes
  int descriptor_ = -1;
  int slot_ = -1;  // in the table that remove_partial_files() walks; -1: not in it
};

// Writes `bytes` as the whole content of `path`, as AtomicFile does. Throws Error(kFileWrite).
void write_atomically(const std::string& path, std::string_view bytes);

// Checks that `path` could be written now: its folder exists and can be written, and it is no
// folder itself. Creates nothing. Throws Error(kFileWrite).
void check_writable(const std::string& path);

}  // namespace ovoid::io
