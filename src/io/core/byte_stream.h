// SPDX-License-Identifier: Apache-2.0
// A file's bytes from the front to the back where nobody says how many there are: text, as it is or
// within gzip or bzip2.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "io/core/byte_source.h"
#include "io/core/line_ends.h"
#include "io/core/samples.h"

namespace ovoid::io {

class ByteStream {
 public:
  ByteStream() = default;
  virtual ~ByteStream() = default;
  ByteStream(const ByteStream&) = delete;
  ByteStream& operator=(const ByteStream&) = delete;

  // Fills the front of `out`, which is not empty, and returns how much; 0 at the end only. Throws
  // Error(kFileFormat) for compressed data that are broken.
  virtual std::size_t read(std::span<std::byte> out) = 0;
};

// From the first byte, decompressed if the first bytes are gzip's or bzip2's; several members in a
// row are one stream. `source` and `progress` must outlive it.
std::unique_ptr<ByteStream> open_stream(const ByteSource& source, ReadProgress& progress);

// The first bytes of the same, up to `count`; fewer if they end or are broken.
std::string stream_start(const ByteSource& source, std::size_t count);

// Walks a stream line by line and holds a piece of it.
class LineReader {
 public:
  // `name`: of the file, for messages.
  LineReader(ByteStream& stream, std::string name) : stream_(stream), name_(std::move(name)) {}

  // Longer lines are an error: what has no line ends is no text, and is not to fill the memory.
  static constexpr std::size_t kLongestLine = std::size_t{1} << 30;

  // The next line without its end (LineEnds); false at the end. Valid until the next call.
  // Throws Error(kFileFormat) for a line that is too long or holds a byte 0.
  bool next(std::string_view& line);

  std::int64_t number() const noexcept { return number_; }  // of the line returned last, from 1
  // "a.csv: line 3"
  std::string where() const;

 private:
  bool refill();

  ByteStream& stream_;
  std::string name_;
  std::string window_;
  LineEnds line_ends_;
  std::size_t begin_ = 0, end_ = 0;  // of what is not handed out yet
  std::int64_t number_ = 0;
};

}  // namespace ovoid::io
