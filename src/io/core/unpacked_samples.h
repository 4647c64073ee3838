// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "io/core/samples.h"
#include "io/core/temporary_file.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Samples of one array, which a reader unpacks or puts together of many files: in memory, or in a
// temporary file.
class UnpackedSamples {
 public:
  using Fill = std::function<void(std::span<std::byte>)>;

  // `name`: of what they are, for messages. Throws Error(kOutOfMemory) where there is no room for
  // so many bytes, in memory or in the folder for temporary files, Error(kFileWrite) where no file
  // can be made.
  UnpackedSamples(const std::string& name, std::int64_t num_bytes, bool are_in_file);

  // The next `count` bytes, made by `fill`. Memory grows with what was made, but for reserve(). Of
  // a file there are never more in memory than one call's. Throws what `fill` throws, and
  // Error(kFileWrite).
  void append(std::int64_t count, const Fill& fill);
  // Takes the memory for all of them at once.
  void reserve();

  // The same for bytes from `offset` on, once there is room for all: from several threads, each of
  // which makes others.
  void make_room();
  void put(std::int64_t offset, std::int64_t count, const Fill& fill);

  // What is in memory.
  SampleBuffer& memory() noexcept { return memory_; }

  // Gives them, of native byte order, to an array, which has its type. Nothing comes after this.
  void release(const ReadOptions& options, DataArray* array);

 private:
  SampleBuffer memory_;
  std::optional<TemporaryFile> file_;
  std::int64_t num_bytes_;
  std::int64_t num_appended_ = 0;
};

}  // namespace ovoid::io
