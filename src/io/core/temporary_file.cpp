// SPDX-License-Identifier: Apache-2.0
#include "io/core/temporary_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::io {

TemporaryFile::TemporaryFile(std::string name, std::int64_t num_bytes)
    : name_(std::move(name)), num_bytes_(num_bytes) {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  if (error) {
    const char* const told = std::getenv("TMPDIR");
    throw Error(ErrorCode::kFileWrite,
                fmt::format("{}: no temporary file in '{}', where TMPDIR says: it is no folder",
                            name_, told != nullptr ? told : "/tmp"));
  }
  folder_ = folder.string();
  const auto space = std::filesystem::space(folder, error);
  if (!error && static_cast<double>(space.available) < static_cast<double>(num_bytes)) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("{}: unpacked it takes {} bytes of '{}', which has {}: set TMPDIR to a "
                            "folder with more",
                            name_, num_bytes, folder_, space.available));
  }
  std::string path = (folder / "ovoid-XXXXXX").string();
  descriptor_ = ::mkostemp(path.data(), O_CLOEXEC);
  if (descriptor_ < 0) {
    throw Error(ErrorCode::kFileWrite,
                fmt::format("{}: no temporary file in '{}': {}", name_, folder_,
                            std::generic_category().message(errno)));
  }
  ::unlink(path.c_str());
}

TemporaryFile::~TemporaryFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void TemporaryFile::write(std::int64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::pwrite(descriptor_, bytes.data(), bytes.size(), offset);
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) {
      throw Error(ErrorCode::kFileWrite, fmt::format("{}: unpacking to '{}': {}", name_, folder_,
                                                     std::generic_category().message(errno)));
    }
    offset += put;
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
}

std::unique_ptr<ByteSource> TemporaryFile::finish() {
  return source_of(name_, num_bytes_, std::exchange(descriptor_, -1));
}

}  // namespace ovoid::io
