// SPDX-License-Identifier: Apache-2.0
// What OpenEXR writes to and reads from.
#pragma once

#include <ImfIO.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>

#include "io/core/byte_source.h"

namespace ovoid::io {

// Collects the file in memory: OpenEXR goes back to fill in its line table, and a whole picture is
// small.
class ExrStream final : public Imf::OStream {
 public:
  explicit ExrStream(const std::string& path) : Imf::OStream(path.c_str()) {}

  void write(const char data[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (position_ + size > bytes_.size()) bytes_.resize(position_ + size);
    bytes_.replace(position_, size, data, size);
    position_ += size;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t position_ = 0;
};

// A file that must not be read behind its end. Throws as open_file() does.
class ExrSource final : public Imf::IStream {
 public:
  explicit ExrSource(const std::string& path)
      : Imf::IStream(path.c_str()), source_(open_file(path)) {}

  bool read(char data[], int count) override {
    if (count < 0 || static_cast<std::uint64_t>(count) > size() - std::min(size(), position_))
      throw std::runtime_error("the file ends early");
    source_->read(static_cast<std::int64_t>(position_),
                  std::as_writable_bytes(std::span(data, static_cast<std::size_t>(count))));
    position_ += static_cast<std::uint64_t>(count);
    return position_ < size();
  }
  std::uint64_t tellg() override { return position_; }
  void seekg(std::uint64_t position) override { position_ = position; }

  std::uint64_t size() const { return static_cast<std::uint64_t>(source_->size()); }

 private:
  std::unique_ptr<ByteSource> source_;
  std::uint64_t position_ = 0;
};

}  // namespace ovoid::io
