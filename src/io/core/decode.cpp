// SPDX-License-Identifier: Apache-2.0
#include "io/core/decode.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <string_view>

#include "io/core/decompressors.h"
#include "io/core/text_scanner.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kInputChunk = std::int64_t{1} << 18;
constexpr std::int64_t kOutputChunk = std::int64_t{1} << 20;

std::string file_and_header(const ByteSource& source, const WantedSamples& wanted) {
  return source.name() == wanted.header ? source.name()
                                        : fmt::format("{}: {}", wanted.header, source.name());
}

[[noreturn]] void throw_broken(const ByteSource& source, const WantedSamples& wanted,
                               const std::string& what) {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", file_and_header(source, wanted), what));
}

[[noreturn]] void throw_short(const ByteSource& source, const WantedSamples& wanted,
                              const std::string& what, std::int64_t available) {
  throw_broken(
      source, wanted,
      fmt::format(
          "{} {} bytes, {} needs {}: is the file truncated or a header field wrong?", what,
          available, wanted.layout,
          wanted.num_skipped > 0 ? wanted.num_bytes + wanted.num_skipped : wanted.num_bytes));
}

[[noreturn]] void throw_not(const char* encoding, const ByteSource& source, std::int64_t offset,
                            const WantedSamples& wanted) {
  const std::int64_t available = source.size() - offset;
  std::string message = fmt::format("{}: encoding says {} but ", wanted.header, encoding);
  message += source.name() == wanted.header ? std::string("the data") : source.name();
  message += available == 0 ? std::string(" is empty")
                            : fmt::format(" is not {} data (starts with {})", encoding,
                                          first_bytes_text(source, offset));
  if (available == wanted.num_bytes) {
    message += fmt::format("; it holds {} bytes, what {} needs raw: did you mean 'encoding: raw'?",
                           available, wanted.layout);
  }
  throw Error(ErrorCode::kFileFormat, message);
}

// Hands out the source piece by piece.
class InputChunks {
 public:
  InputChunks(const ByteSource& source, std::int64_t offset, ReadProgress& progress)
      : source_(source),
        offset_(offset),
        progress_(progress),
        buffer_(static_cast<std::size_t>(kInputChunk)) {}

  // Empty at the end. Valid until the next call.
  std::span<std::byte> next() {
    const auto count = static_cast<std::size_t>(std::min(kInputChunk, source_.size() - offset_));
    const auto chunk = std::span(buffer_).first(count);
    source_.read(offset_, chunk);
    offset_ += static_cast<std::int64_t>(count);
    progress_.advance(static_cast<std::int64_t>(count));
    return chunk;
  }

 private:
  const ByteSource& source_;
  std::int64_t offset_;
  ReadProgress& progress_;
  std::vector<std::byte> buffer_;
};

// One or more members, one behind the other.
template <typename Decompressor>
class DecompressedStream final : public SampleStream {
 public:
  DecompressedStream(const ByteSource& source, std::int64_t offset, const WantedSamples& wanted,
                     ReadProgress& progress)
      : source_(source), wanted_(wanted), input_(source, offset, progress) {}

  void append(std::int64_t count, SampleBuffer& out) override {
    const std::int64_t final_size = out.size() + count;
    while (out.size() < final_size) {
      const auto room = out.extend(std::min(final_size - out.size(), kOutputChunk), final_size);
      const auto made = static_cast<std::int64_t>(decode_wanted(room));
      out.shrink(static_cast<std::int64_t>(room.size()) - made);
    }
  }

  void skip(std::int64_t count) override {
    std::vector<std::byte> scratch(static_cast<std::size_t>(std::min(count, kOutputChunk)));
    while (count > 0) {
      const auto room = std::span(scratch).first(
          static_cast<std::size_t>(std::min<std::int64_t>(count, kOutputChunk)));
      count -= static_cast<std::int64_t>(decode_wanted(room));
    }
  }

  // One byte of room lets the decompressor reach the end, or shows that there is more.
  void finish(std::vector<std::string>& notes) override {
    while (!decompressor_.ended) {
      if (!refill()) {
        throw_broken(source_, wanted_,
                     fmt::format("the {} data lack their checksum: is the file truncated?",
                                 Decompressor::kName));
      }
      std::byte behind{};
      std::string problem;
      if (step(std::span(&behind, 1), problem) > 0) {
        notes.push_back(fmt::format("{}: more data follow the {} bytes of {} and are ignored",
                                    file_and_header(source_, wanted_), wanted_.num_bytes,
                                    wanted_.layout));
        return;
      }
      check(problem);
    }
  }

 private:
  // At least a byte unless a member has ended.
  std::size_t decode_wanted(std::span<std::byte> room) {
    if (decompressor_.ended && !decompressor_.restart())
      throw Error(ErrorCode::kOutOfMemory, "decompressor: cannot start");
    if (!refill()) {
      throw_short(source_, wanted_, fmt::format("the {} data end after", Decompressor::kName),
                  num_decoded_);
    }
    std::string problem;
    const std::size_t made = step(room, problem);
    num_decoded_ += static_cast<std::int64_t>(made);
    check(problem);
    return made;
  }

  // False at the end of the file.
  bool refill() {
    auto& stream = decompressor_.stream;
    if (stream.avail_in > 0) return true;
    const auto chunk = input_.next();
    stream.next_in = reinterpret_cast<decltype(stream.next_in)>(chunk.data());
    stream.avail_in = static_cast<unsigned>(chunk.size());
    return !chunk.empty();
  }

  std::size_t step(std::span<std::byte> room, std::string& problem) {
    auto& stream = decompressor_.stream;
    stream.next_out = reinterpret_cast<decltype(stream.next_out)>(room.data());
    stream.avail_out = static_cast<unsigned>(room.size());
    problem = decompressor_.step();
    return room.size() - stream.avail_out;
  }

  void check(const std::string& problem) const {
    if (problem.empty()) return;
    throw_broken(
        source_, wanted_,
        fmt::format("the {} data are broken after {} of {} decoded bytes: {}", Decompressor::kName,
                    num_decoded_, wanted_.num_bytes + wanted_.num_skipped, problem));
  }

  const ByteSource& source_;
  WantedSamples wanted_;
  InputChunks input_;
  Decompressor decompressor_;
  std::int64_t num_decoded_ = 0;
};

// One number of type T from `word` into `out`; false if it is none or does not fit.
template <typename T>
bool store_number(std::string_view word, std::byte* out) {
  const auto value = parse_number<T>(word);
  if (value) std::memcpy(out, &*value, sizeof(T));
  return value.has_value();
}

using NumberParser = bool (*)(std::string_view, std::byte*);

// In the order of ScalarType.
constexpr std::array<NumberParser, 10> kNumberParsers{
    store_number<std::uint8_t>,  store_number<std::int8_t>,   store_number<std::uint16_t>,
    store_number<std::int16_t>,  store_number<std::uint32_t>, store_number<std::int32_t>,
    store_number<std::uint64_t>, store_number<std::int64_t>,  store_number<float>,
    store_number<double>};
static_assert(kNumberParsers.size() == static_cast<std::size_t>(ScalarType::kFloat64) + 1);

// The characters of a source, one after the other.
class Characters {
 public:
  Characters(const ByteSource& source, std::int64_t offset, ReadProgress& progress)
      : input_(source, offset, progress) {}

  bool next(char& c) {
    if (position_ == chunk_.size()) {
      chunk_ = input_.next();
      position_ = 0;
      if (chunk_.empty()) return false;
    }
    c = static_cast<char>(chunk_[position_++]);
    return true;
  }

 private:
  InputChunks input_;
  std::span<const std::byte> chunk_;
  std::size_t position_ = 0;
};

// Numbers between white space or commas.
class TextStream final : public SampleStream {
 public:
  TextStream(const ByteSource& source, std::int64_t offset, const WantedSamples& wanted,
             ReadProgress& progress)
      : source_(source), wanted_(wanted), characters_(source, offset, progress) {}

  void append(std::int64_t count, SampleBuffer& out) override {
    const std::int64_t final_size = out.size() + count;
    while (out.size() < final_size) next_number(out.extend(sample_size_, final_size).data());
  }
  void skip(std::int64_t count) override {
    std::array<std::byte, 8> ignored{};
    for (; count > 0; count -= sample_size_) next_number(ignored.data());
  }
  void finish(std::vector<std::string>&) override {}

 private:
  void next_number(std::byte* out) {
    // A double in full decimal notation has at most 327 characters.
    constexpr std::size_t kLongestWord = 512;
    word_.clear();
    char c = ' ';
    bool has_more = true;
    while (word_.size() <= kLongestWord && (has_more = characters_.next(c))) {
      if (!is_blank(c) && c != ',')
        word_ += c;
      else if (!word_.empty())
        break;
    }
    if (word_.empty()) {
      throw_broken(source_, wanted_,
                   fmt::format("the text holds {} numbers, {} needs {}", num_parsed_,
                               wanted_.layout, wanted_.num_bytes / sample_size_));
    }
    if (!parse_(word_, out)) {
      throw_broken(source_, wanted_,
                   fmt::format("value {} is '{}': expected {} as text", num_parsed_,
                               word_.substr(0, 32), name_of(wanted_.type)));
    }
    ++num_parsed_;
  }

  const ByteSource& source_;
  WantedSamples wanted_;
  Characters characters_;
  NumberParser parse_ = kNumberParsers[static_cast<std::size_t>(wanted_.type)];
  std::int64_t sample_size_ = static_cast<std::int64_t>(size_of(wanted_.type));
  std::int64_t num_parsed_ = 0;
  std::string word_;
};

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

class HexStream final : public SampleStream {
 public:
  HexStream(const ByteSource& source, std::int64_t offset, const WantedSamples& wanted,
            ReadProgress& progress)
      : source_(source), wanted_(wanted), characters_(source, offset, progress) {}

  void append(std::int64_t count, SampleBuffer& out) override {
    // As much as that is there: checked against the file.
    for (std::byte& byte : out.extend(count, out.size() + count)) byte = next_byte();
  }
  void skip(std::int64_t count) override {
    for (; count > 0; --count) next_byte();
  }
  void finish(std::vector<std::string>&) override {}

 private:
  std::byte next_byte() {
    const int high = next_digit();
    return static_cast<std::byte>(16 * high + next_digit());
  }

  int next_digit() {
    char c = ' ';
    while (characters_.next(c)) {
      if (is_blank(c)) continue;
      const int digit = hex_digit(c);
      if (digit < 0) {
        throw_broken(source_, wanted_,
                     fmt::format("hex digit {} is character {:#04x}", num_digits_,
                                 static_cast<unsigned char>(c)));
      }
      ++num_digits_;
      return digit;
    }
    throw_short(source_, wanted_, "the hex digits hold", num_digits_ / 2);
  }

  const ByteSource& source_;
  WantedSamples wanted_;
  Characters characters_;
  std::int64_t num_digits_ = 0;
};

class RawStream final : public SampleStream {
 public:
  RawStream(const ByteSource& source, std::int64_t offset, const WantedSamples& wanted,
            ReadProgress& progress)
      : source_(source), wanted_(wanted), position_(offset), progress_(progress) {
    if (wanted_.num_skipped < 0) position_ = source.size() - wanted_.num_bytes;
  }

  void append(std::int64_t count, SampleBuffer& out) override {
    append_plain(source_, position_, count, out, progress_);
    position_ += count;
  }
  void skip(std::int64_t count) override {
    progress_.advance(count);
    position_ += count;
  }
  void finish(std::vector<std::string>& notes) override {
    if (position_ == source_.size()) return;
    notes.push_back(fmt::format("{}: {} bytes behind the {} of {} are ignored",
                                file_and_header(source_, wanted_), source_.size() - position_,
                                wanted_.num_bytes, wanted_.layout));
  }

 private:
  const ByteSource& source_;
  WantedSamples wanted_;
  std::int64_t position_;
  ReadProgress& progress_;
};

std::unique_ptr<SampleStream> make_stream(const ByteSource& source, std::int64_t offset,
                                          Encoding encoding, const WantedSamples& wanted,
                                          ReadProgress& progress) {
  switch (encoding) {
    case Encoding::kRaw:
      break;
    case Encoding::kGzip:
      return std::make_unique<DecompressedStream<Inflater>>(source, offset, wanted, progress);
    case Encoding::kBzip2:
      return std::make_unique<DecompressedStream<Bunzipper>>(source, offset, wanted, progress);
    case Encoding::kText:
      return std::make_unique<TextStream>(source, offset, wanted, progress);
    case Encoding::kHex:
      return std::make_unique<HexStream>(source, offset, wanted, progress);
  }
  return std::make_unique<RawStream>(source, offset, wanted, progress);
}

}  // namespace

const char* name_of(Encoding encoding) noexcept {
  switch (encoding) {
    case Encoding::kRaw:
      return "raw";
    case Encoding::kGzip:
      return "gzip";
    case Encoding::kBzip2:
      return "bzip2";
    case Encoding::kText:
      return "ascii";
    case Encoding::kHex:
      return "hex";
  }
  return "";
}

void check_plausible(const ByteSource& source, std::int64_t offset, Encoding encoding,
                     const WantedSamples& wanted) {
  const std::int64_t available = std::max<std::int64_t>(0, source.size() - offset);
  const std::int64_t needed = wanted.num_bytes + std::max<std::int64_t>(0, wanted.num_skipped);
  switch (encoding) {
    case Encoding::kRaw:
      if (available < needed) throw_short(source, wanted, "holds", available);
      return;
    case Encoding::kHex:
      if (available / 2 < needed)
        throw_short(source, wanted, "its hex digits hold at most", available / 2);
      return;
    case Encoding::kText: {
      // Every number but the last takes a digit and a separator.
      const std::int64_t num_needed = needed / static_cast<std::int64_t>(size_of(wanted.type));
      if ((available + 1) / 2 < num_needed) {
        throw_broken(source, wanted,
                     fmt::format("{} characters of text cannot hold the {} numbers of {}",
                                 available, num_needed, wanted.layout));
      }
      return;
    }
    case Encoding::kGzip: {
      const std::string start = source.text(offset, 2);
      const bool is_gzip = start == "\x1f\x8b";
      // A zlib header: method 8, and the two bytes are a multiple of 31.
      const bool is_zlib =
          start.size() == 2 && (start[0] & 0x0f) == 8 &&
          (static_cast<unsigned char>(start[0]) * 256 + static_cast<unsigned char>(start[1])) %
                  31 ==
              0;
      if (!is_gzip && !is_zlib) throw_not("gzip", source, offset, wanted);
      if (available < needed / kMaxDeflateRatio) {
        throw_broken(source, wanted,
                     fmt::format("{} bytes of gzip data hold at most {} bytes, {} needs {}",
                                 available, available * kMaxDeflateRatio, wanted.layout, needed));
      }
      return;
    }
    case Encoding::kBzip2:
      if (source.text(offset, 3) != "BZh") throw_not("bzip2", source, offset, wanted);
      return;
  }
}

std::unique_ptr<SampleStream> open_samples(const ByteSource& source, std::int64_t offset,
                                           Encoding encoding, const WantedSamples& wanted,
                                           ReadProgress& progress) {
  check_plausible(source, offset, encoding, wanted);
  auto stream = make_stream(source, offset, encoding, wanted, progress);
  stream->skip(std::max<std::int64_t>(0, wanted.num_skipped));
  return stream;
}

std::string gzip_start(const ByteSource& source, std::size_t count) {
  std::string packed = source.text(0, kInputChunk);
  std::string result(count, '\0');
  Inflater inflater;
  inflater.stream.next_in = reinterpret_cast<Bytef*>(packed.data());
  inflater.stream.avail_in = static_cast<uInt>(packed.size());
  inflater.stream.next_out = reinterpret_cast<Bytef*>(result.data());
  inflater.stream.avail_out = static_cast<uInt>(count);
  inflater.step();
  result.resize(count - inflater.stream.avail_out);
  return result;
}

}  // namespace ovoid::io
