// SPDX-License-Identifier: Apache-2.0
#include "io/core/byte_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "io/core/decompressors.h"
#include "io/core/signatures.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kStreamPiece = std::int64_t{1} << 18;

class PlainStream final : public ByteStream {
 public:
  PlainStream(const ByteSource& source, ReadProgress& progress)
      : source_(source), progress_(progress) {}

  std::size_t read(std::span<std::byte> out) override {
    const auto count = std::min(static_cast<std::int64_t>(out.size()), source_.size() - position_);
    source_.read(position_, out.first(static_cast<std::size_t>(count)));
    position_ += count;
    progress_.advance(count);
    return static_cast<std::size_t>(count);
  }

 private:
  const ByteSource& source_;
  ReadProgress& progress_;
  std::int64_t position_ = 0;
};

template <typename Decompressor>
class UnpackedStream final : public ByteStream {
 public:
  UnpackedStream(const ByteSource& source, ReadProgress& progress)
      : name_(source.name()),
        packed_(source, progress),
        piece_(static_cast<std::size_t>(kStreamPiece)) {}

  std::size_t read(std::span<std::byte> out) override {
    auto& stream = decompressor_.stream;
    const std::size_t room = std::min<std::size_t>(out.size(), std::size_t{1} << 30);
    stream.next_out = reinterpret_cast<decltype(stream.next_out)>(out.data());
    stream.avail_out = static_cast<unsigned>(room);
    while (stream.avail_out == room) {
      if (!refill()) {
        if (decompressor_.ended) return 0;
        fail("the file ends within them");
      }
      if (decompressor_.ended && !decompressor_.restart())
        throw Error(ErrorCode::kOutOfMemory, "decompressor: cannot start");
      stream.next_out = reinterpret_cast<decltype(stream.next_out)>(out.data());
      stream.avail_out = static_cast<unsigned>(room);
      const std::string problem = decompressor_.step();
      if (!problem.empty()) fail(problem);
    }
    num_decoded_ += static_cast<std::int64_t>(room - stream.avail_out);
    return room - stream.avail_out;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: the {} data are broken after {} decoded bytes: {}", name_,
                            Decompressor::kName, num_decoded_, what));
  }

  bool refill() {
    auto& stream = decompressor_.stream;
    if (stream.avail_in > 0) return true;
    const std::size_t count = packed_.read(piece_);
    stream.next_in = reinterpret_cast<decltype(stream.next_in)>(piece_.data());
    stream.avail_in = static_cast<unsigned>(count);
    return count > 0;
  }

  std::string name_;
  PlainStream packed_;
  std::vector<std::byte> piece_;
  Decompressor decompressor_;
  std::int64_t num_decoded_ = 0;
};

}  // namespace

std::unique_ptr<ByteStream> open_stream(const ByteSource& source, ReadProgress& progress) {
  const std::string start = source.text(0, 8);
  if (is_gzip(start)) return std::make_unique<UnpackedStream<Inflater>>(source, progress);
  if (is_bzip2(start)) return std::make_unique<UnpackedStream<Bunzipper>>(source, progress);
  return std::make_unique<PlainStream>(source, progress);
}

std::string stream_start(const ByteSource& source, std::size_t count) {
  const ReadOptions options;
  ReadProgress progress(options, 0);
  std::string start(count, '\0');
  std::size_t filled = 0;
  try {
    const auto stream = open_stream(source, progress);
    while (filled < count) {
      const std::size_t got =
          stream->read(std::as_writable_bytes(std::span(start)).subspan(filled));
      if (got == 0) break;
      filled += got;
    }
  } catch (const Error&) {
    // What is broken is told by the reader of the whole.
  }
  start.resize(filled);
  return start;
}

std::string LineReader::where() const { return fmt::format("{}: line {}", name_, number_); }

// More of the stream behind what is there; false at its end.
bool LineReader::refill() {
  if (begin_ > 0) {
    std::memmove(window_.data(), window_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  if (end_ == window_.size()) {
    if (window_.size() >= kLongestLine) {
      throw Error(ErrorCode::kFileFormat, fmt::format("{}: line {}: is longer than {} bytes", name_,
                                                      number_ + 1, kLongestLine));
    }
    window_.resize(std::max(static_cast<std::size_t>(kStreamPiece), 2 * window_.size()));
  }
  const auto room = std::as_writable_bytes(std::span(window_)).subspan(end_);
  const std::size_t got = stream_.read(room);
  if (std::memchr(room.data(), '\0', got) != nullptr) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: is no text: it holds bytes that are 0", name_));
  }
  end_ += line_ends_.unify(std::span(window_).subspan(end_, got));
  return got > 0;
}

bool LineReader::next(std::string_view& line) {
  std::size_t looked_at = 0;  // of the line, without finding its end
  while (true) {
    const char* const text = window_.data() + begin_;
    const void* const found = end_ - begin_ == looked_at
                                  ? nullptr
                                  : std::memchr(text + looked_at, '\n', end_ - begin_ - looked_at);
    if (found != nullptr) {
      line = {text, static_cast<std::size_t>(static_cast<const char*>(found) - text)};
      begin_ += line.size() + 1;
      break;
    }
    looked_at = end_ - begin_;
    if (refill()) continue;
    if (begin_ == end_) return false;
    line = std::string_view(window_).substr(begin_, end_ - begin_);
    begin_ = end_;
    break;
  }
  ++number_;
  return true;
}

}  // namespace ovoid::io
