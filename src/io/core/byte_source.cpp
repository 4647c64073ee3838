// SPDX-License-Identifier: Apache-2.0
#include "io/core/byte_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "ovoid/error.h"

namespace ovoid::io {
namespace {

std::string reason_of(int error) { return std::generic_category().message(error); }

// Plain reads, not a mapping: a mapped file that somebody truncates kills the process, and one that
// somebody overwrites changes a dataset that is said to be immutable.
class FileSource final : public ByteSource {
 public:
  FileSource(std::string name, std::int64_t size, int descriptor)
      : ByteSource(std::move(name), size), descriptor_(descriptor) {}
  ~FileSource() override { ::close(descriptor_); }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  void read(std::int64_t offset, std::span<std::byte> out) const override {
    assert(offset >= 0 && offset + static_cast<std::int64_t>(out.size()) <= size());
    while (!out.empty()) {
      const ssize_t got =
          ::pread(descriptor_, out.data(), std::min<std::size_t>(out.size(), 1U << 30U), offset);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) {
        throw Error(ErrorCode::kFileNotFound,
                    fmt::format("{}: cannot be read: {}", name(), reason_of(errno)));
      }
      if (got == 0) {
        throw Error(
            ErrorCode::kFileFormat,
            fmt::format("{}: ends at byte {}, had {} when it was opened", name(), offset, size()));
      }
      offset += got;
      out = out.subspan(static_cast<std::size_t>(got));
    }
  }

 private:
  int descriptor_;
};

class MemorySource final : public ByteSource {
 public:
  MemorySource(std::string name, std::span<const std::byte> bytes)
      : ByteSource(std::move(name), static_cast<std::int64_t>(bytes.size())), bytes_(bytes) {}

  void read(std::int64_t offset, std::span<std::byte> out) const override {
    assert(offset >= 0 && offset + static_cast<std::int64_t>(out.size()) <= size());
    if (!out.empty()) std::memcpy(out.data(), bytes_.data() + offset, out.size());
  }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace

std::string ByteSource::text(std::int64_t offset, std::int64_t max_size) const {
  std::string result(
      static_cast<std::size_t>(std::clamp<std::int64_t>(size_ - offset, 0, max_size)), '\0');
  read(std::min(offset, size_), std::as_writable_bytes(std::span(result)));
  return result;
}

std::unique_ptr<ByteSource> source_of(std::string name, std::int64_t size, int descriptor) {
  return std::make_unique<FileSource>(std::move(name), size, descriptor);
}

std::unique_ptr<ByteSource> open_file(const std::string& path) {
  // O_NONBLOCK: opening a pipe without a writer would wait forever; it means nothing for regular
  // files.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) {
    throw Error(ErrorCode::kFileNotFound,
                errno == ENOENT ? fmt::format("{}: no such file", path)
                                : fmt::format("{}: cannot be opened: {}", path, reason_of(errno)));
  }
  struct stat info {};
  const bool is_known = ::fstat(descriptor, &info) == 0;
  if (!is_known || !S_ISREG(info.st_mode)) {
    ::close(descriptor);
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: is {}: expected a regular file", path,
                            is_known && S_ISDIR(info.st_mode) ? "a folder" : "a device or a pipe"));
  }
  return std::make_unique<FileSource>(path, info.st_size, descriptor);
}

std::unique_ptr<ByteSource> open_memory(std::string name, std::span<const std::byte> bytes) {
  return std::make_unique<MemorySource>(std::move(name), bytes);
}

std::string path_beside(const std::string& header_path, const std::string& name) {
  return (std::filesystem::path(header_path).parent_path() / name).lexically_normal().string();
}

}  // namespace ovoid::io
