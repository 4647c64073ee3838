// SPDX-License-Identifier: Apache-2.0
#include "io/decode.h"

#include <bzlib.h>
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <span>
#include <string_view>

#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kInputChunk = std::int64_t{1} << 18;
constexpr std::int64_t kOutputChunk = std::int64_t{1} << 20;

// Deflate's longest match is 258 bytes, coded in two bits at best: 1032 to 1 (zlib's technical
// notes).
constexpr std::int64_t kMaxDeflateRatio = 1032;

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

// zlib and libbz2 behind one shape. step() consumes input and fills output, as much as it can.
struct Inflater {
  static constexpr const char* kName = "gzip";
  z_stream stream{};
  bool ended = false;  // at the end of a member

  Inflater() {
    // 32: accept a gzip or a zlib header.
    if (inflateInit2(&stream, 15 + 32) != Z_OK)
      throw Error(ErrorCode::kOutOfMemory, "zlib: cannot start");
  }
  ~Inflater() { inflateEnd(&stream); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  bool restart() {
    ended = false;
    return inflateReset(&stream) == Z_OK;
  }
  // Empty if all is well, else what is wrong.
  std::string step() {
    const int status = inflate(&stream, Z_NO_FLUSH);
    ended = status == Z_STREAM_END;
    if (status == Z_OK || status == Z_STREAM_END || status == Z_BUF_ERROR) return {};
    return stream.msg != nullptr   ? stream.msg
           : status == Z_NEED_DICT ? "needs a dictionary"
                                   : "broken";
  }
};

struct Bunzipper {
  static constexpr const char* kName = "bzip2";
  bz_stream stream{};
  bool ended = false;

  Bunzipper() {
    if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK)
      throw Error(ErrorCode::kOutOfMemory, "libbz2: cannot start");
  }
  ~Bunzipper() { BZ2_bzDecompressEnd(&stream); }
  Bunzipper(const Bunzipper&) = delete;
  Bunzipper& operator=(const Bunzipper&) = delete;

  bool restart() {
    char* const next_in = stream.next_in;
    const unsigned avail_in = stream.avail_in;
    BZ2_bzDecompressEnd(&stream);
    stream = {};
    ended = false;
    if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return false;
    stream.next_in = next_in;
    stream.avail_in = avail_in;
    return true;
  }
  std::string step() {
    const int status = BZ2_bzDecompress(&stream);
    ended = status == BZ_STREAM_END;
    if (status == BZ_OK || status == BZ_STREAM_END) return {};
    return status == BZ_MEM_ERROR ? "no memory for it" : "block or checksum broken";
  }
};

// Decompresses one or more members until the wanted bytes and the end of their member (so that the
// checksum is verified) have been met.
template <typename Decompressor>
void append_decompressed(const ByteSource& source, std::int64_t offset, const WantedSamples& wanted,
                         SampleBuffer& out, ReadProgress& progress,
                         std::vector<std::string>& notes) {
  Decompressor decompressor;
  auto& stream = decompressor.stream;
  InputChunks input(source, offset, progress);
  std::int64_t to_skip = wanted.num_skipped;
  std::int64_t to_keep = wanted.num_bytes;
  const std::int64_t final_size = out.size() + to_keep;
  std::vector<std::byte> scratch(static_cast<std::size_t>(kOutputChunk));  // for what is skipped
  const auto num_decoded = [&] {
    return wanted.num_bytes + wanted.num_skipped - to_keep - to_skip;
  };

  while (true) {
    if (stream.avail_in == 0) {
      const auto chunk = input.next();
      stream.next_in = reinterpret_cast<decltype(stream.next_in)>(chunk.data());
      stream.avail_in = static_cast<unsigned>(chunk.size());
      if (chunk.empty() && to_skip + to_keep == 0) {
        throw_broken(source, wanted,
                     fmt::format("the {} data lack their checksum: is the file truncated?",
                                 Decompressor::kName));
      }
      if (chunk.empty())
        throw_short(source, wanted, fmt::format("the {} data end after", Decompressor::kName),
                    num_decoded());
    }
    // Once nothing is wanted, one more byte of room lets the decompressor reach the end, or shows
    // that there is more.
    std::span<std::byte> room = scratch;
    if (to_skip > 0) {
      room = room.first(static_cast<std::size_t>(std::min(to_skip, kOutputChunk)));
    } else if (to_keep > 0) {
      room = out.extend(std::min(to_keep, kOutputChunk), final_size);
    } else {
      room = room.first(1);
    }
    stream.next_out = reinterpret_cast<decltype(stream.next_out)>(room.data());
    stream.avail_out = static_cast<unsigned>(room.size());
    const std::string problem = decompressor.step();
    const std::int64_t unused = stream.avail_out;
    const std::int64_t made = static_cast<std::int64_t>(room.size()) - unused;
    const bool was_keeping = to_skip == 0 && to_keep > 0;
    if (to_skip > 0) {
      to_skip -= made;
    } else if (was_keeping) {
      out.shrink(unused);
      to_keep -= made;
    } else if (made > 0) {
      notes.push_back(fmt::format("{}: more data follow the {} bytes of {} and are ignored",
                                  file_and_header(source, wanted), wanted.num_bytes,
                                  wanted.layout));
      return;
    }
    if (!problem.empty()) {
      throw_broken(source, wanted,
                   fmt::format("the {} data are broken after {} of {} decoded bytes: {}",
                               Decompressor::kName, num_decoded(),
                               wanted.num_bytes + wanted.num_skipped, problem));
    }
    if (!decompressor.ended) continue;
    if (to_skip == 0 && to_keep == 0) return;
    if (!decompressor.restart()) throw Error(ErrorCode::kOutOfMemory, "decompressor: cannot start");
  }
}

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

// One number of type T from `word` into `out`; false if it is none or does not fit.
template <typename T>
bool parse_number(std::string_view word, std::byte* out) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const char* const end = word.data() + word.size();
  T value{};
  const auto result = std::from_chars(word.data(), end, value);
  if (result.ec != std::errc{} || result.ptr != end) return false;
  std::memcpy(out, &value, sizeof(T));
  return true;
}

using NumberParser = bool (*)(std::string_view, std::byte*);

// In the order of ScalarType.
constexpr std::array<NumberParser, 10> kNumberParsers{
    parse_number<std::uint8_t>,  parse_number<std::int8_t>,   parse_number<std::uint16_t>,
    parse_number<std::int16_t>,  parse_number<std::uint32_t>, parse_number<std::int32_t>,
    parse_number<std::uint64_t>, parse_number<std::int64_t>,  parse_number<float>,
    parse_number<double>};

// Numbers between white space or commas.
void append_text(const ByteSource& source, std::int64_t offset, const WantedSamples& wanted,
                 SampleBuffer& out, ReadProgress& progress) {
  constexpr std::size_t kLongestWord =
      512;  // a double in full decimal notation has at most 327 characters
  const NumberParser parse = kNumberParsers[static_cast<std::size_t>(wanted.type)];
  const auto sample_size = static_cast<std::int64_t>(size_of(wanted.type));
  const std::int64_t num_wanted = wanted.num_bytes / sample_size;
  const std::int64_t final_size = out.size() + wanted.num_bytes;
  std::int64_t num_parsed = 0;
  std::string word;
  const auto finish_word = [&] {
    if (word.empty()) return;
    if (!parse(word, out.extend(sample_size, final_size).data())) {
      throw_broken(source, wanted,
                   fmt::format("value {} is '{}': expected {} as text", num_parsed,
                               word.substr(0, 32), name_of(wanted.type)));
    }
    ++num_parsed;
    word.clear();
  };
  InputChunks input(source, offset, progress);
  for (auto chunk = input.next(); !chunk.empty() && num_parsed < num_wanted; chunk = input.next()) {
    for (const std::byte byte : chunk) {
      const char c = static_cast<char>(byte);
      if (!is_space(c) && c != ',') {
        word += c;
        if (word.size() > kLongestWord) finish_word();
        continue;
      }
      finish_word();
      if (num_parsed == num_wanted) return;
    }
  }
  if (num_parsed < num_wanted) finish_word();
  if (num_parsed < num_wanted) {
    throw_broken(source, wanted,
                 fmt::format("the text holds {} numbers, {} needs {}", num_parsed, wanted.layout,
                             num_wanted));
  }
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

void append_hex(const ByteSource& source, std::int64_t offset, const WantedSamples& wanted,
                SampleBuffer& out, ReadProgress& progress) {
  const auto bytes = out.extend(
      wanted.num_bytes, out.size() + wanted.num_bytes);  // plausible: checked against the file
  std::size_t num_digits = 0;
  InputChunks input(source, offset, progress);
  for (auto chunk = input.next(); !chunk.empty(); chunk = input.next()) {
    for (const std::byte byte : chunk) {
      const char c = static_cast<char>(byte);
      if (is_space(c)) continue;
      const int digit = hex_digit(c);
      if (digit < 0)
        throw_broken(source, wanted,
                     fmt::format("hex digit {} is character {:#04x}", num_digits, byte));
      std::byte& target = bytes[num_digits / 2];
      target = num_digits % 2 == 0 ? static_cast<std::byte>(digit << 4)
                                   : target | static_cast<std::byte>(digit);
      if (++num_digits == 2 * bytes.size()) return;
    }
  }
  throw_short(source, wanted, "the hex digits hold", static_cast<std::int64_t>(num_digits / 2));
}

void append_raw(const ByteSource& source, std::int64_t offset, const WantedSamples& wanted,
                SampleBuffer& out, ReadProgress& progress, std::vector<std::string>& notes) {
  const std::int64_t extra = source.size() - offset - wanted.num_bytes;
  const std::int64_t skipped = wanted.num_skipped < 0 ? extra : wanted.num_skipped;
  append_plain(source, offset + skipped, wanted.num_bytes, out, progress);
  if (extra > skipped) {
    notes.push_back(fmt::format("{}: {} bytes behind the {} of {} are ignored",
                                file_and_header(source, wanted), extra - skipped, wanted.num_bytes,
                                wanted.layout));
  }
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

void append_decoded(const ByteSource& source, std::int64_t offset, Encoding encoding,
                    const WantedSamples& wanted, SampleBuffer& out, ReadProgress& progress,
                    std::vector<std::string>& notes) {
  check_plausible(source, offset, encoding, wanted);
  switch (encoding) {
    case Encoding::kRaw:
      return append_raw(source, offset, wanted, out, progress, notes);
    case Encoding::kGzip:
      return append_decompressed<Inflater>(source, offset, wanted, out, progress, notes);
    case Encoding::kBzip2:
      return append_decompressed<Bunzipper>(source, offset, wanted, out, progress, notes);
    case Encoding::kText:
      return append_text(source, offset, wanted, out, progress);
    case Encoding::kHex:
      return append_hex(source, offset, wanted, out, progress);
  }
}

}  // namespace ovoid::io
