// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace ovoid::io {

// Bytes of text that the readers of headers hold at a time.
inline constexpr std::int64_t kTextWindow = std::int64_t{1} << 20;

// Bytes of known size that readers read from: a file, or memory in tests and fuzzing. Readers take
// it by reference and keep nothing of it.
class ByteSource {
 public:
  virtual ~ByteSource() = default;

  // As given by the caller, for messages and for names relative to it.
  const std::string& name() const noexcept { return name_; }
  std::int64_t size() const noexcept { return size_; }

  // Fills `out` from `offset`, 0 <= offset, offset + out.size() <= size(). Throws
  // Error(kFileFormat) if the file has shrunk since it was opened, Error(kFileNotFound) if the
  // system cannot read it.
  virtual void read(std::int64_t offset, std::span<std::byte> out) const = 0;

  // Up to `max_size` bytes from `offset`; fewer at the end, none behind it.
  std::string text(std::int64_t offset, std::int64_t max_size) const;

 protected:
  ByteSource(std::string name, std::int64_t size) : name_(std::move(name)), size_(size) {}

 private:
  std::string name_;
  std::int64_t size_;
};

// Finds the file a header names. Throws Error as open_file does.
using Opener = std::function<std::unique_ptr<ByteSource>(const std::string& path)>;

// Of an open file, which it closes.
std::unique_ptr<ByteSource> source_of(std::string name, std::int64_t size, int descriptor);

// Opens a regular file. Throws Error(kFileNotFound) if it is missing or unreadable,
// Error(kUnsupported) for folders, devices and pipes: readers need to know the size.
std::unique_ptr<ByteSource> open_file(const std::string& path);

// Reads from memory that the caller keeps alive.
std::unique_ptr<ByteSource> open_memory(std::string name, std::span<const std::byte> bytes);

// The path a header means by `name`: relative to the header's own folder unless absolute.
std::string path_beside(const std::string& header_path, const std::string& name);

}  // namespace ovoid::io
