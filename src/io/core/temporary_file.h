// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "io/core/byte_source.h"

namespace ovoid::io {

// A file without a name in the system's folder for temporary files (TMPDIR), gone with its last
// user, however that ends.
class TemporaryFile {
 public:
  // `name`: what it is made from, for messages. Throws Error(kOutOfMemory) naming the folder where
  // there is no room for `num_bytes`, Error(kFileWrite) where no file can be made.
  TemporaryFile(std::string name, std::int64_t num_bytes);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  // At any place. Throws Error(kFileWrite).
  void write(std::int64_t offset, std::span<const std::byte> bytes);

  // For reading; nothing is written afterwards.
  std::unique_ptr<ByteSource> finish();

 private:
  std::string name_, folder_;
  std::int64_t num_bytes_;
  int descriptor_ = -1;
};

}  // namespace ovoid::io
