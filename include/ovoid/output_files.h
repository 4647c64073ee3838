// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "ovoid/export.h"

namespace OVOID_API ovoid {

// Several files of one run that appear together or not at all: a picture and the look that it has.
// While one of these lives, every file that this thread writes is whole on the disk, but without
// its name, until commit(); destroyed without it, what is new is removed and what was there stays.
// Devices and pipes, which have no such state, are written at once. One at a time in a thread.
class FilesTogether {
 public:
  FilesTogether();
  ~FilesTogether();
  FilesTogether(const FilesTogether&) = delete;
  FilesTogether& operator=(const FilesTogether&) = delete;

  // Gives all files their names. Throws Error(kFileWrite) if the system refuses one; then those
  // before it are as they were, where the file system has links.
  void commit();

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

// Of a file that was written, with or without its name. Throws Error(kFileNotFound).
std::int64_t size_of_written(const std::string& path);

}  // namespace ovoid
