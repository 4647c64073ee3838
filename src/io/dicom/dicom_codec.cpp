// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstring>
#include <optional>
#include <string_view>
#include <vector>

#include "io/core/numbers.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

using Codec = DicomCodec;

struct Syntax {
  std::string_view uid;
  Codec codec;
  const char* name;
};

constexpr std::array kSyntaxes = {
    Syntax{"1.2.840.10008.1.2.5", Codec::kRle, "RLE"},
    Syntax{"1.2.840.10008.1.2.4.50", Codec::kJpeg, "JPEG baseline"},
    Syntax{"1.2.840.10008.1.2.4.51", Codec::kJpeg, "JPEG extended"},
    Syntax{"1.2.840.10008.1.2.4.57", Codec::kJpeg, "JPEG lossless"},
    Syntax{"1.2.840.10008.1.2.4.70", Codec::kJpeg, "JPEG lossless"},
    Syntax{"1.2.840.10008.1.2.4.80", Codec::kJpegLs, "JPEG-LS"},
    Syntax{"1.2.840.10008.1.2.4.81", Codec::kJpegLs, "JPEG-LS"},
    Syntax{"1.2.840.10008.1.2.4.90", Codec::kJpeg2000, "JPEG 2000"},
    Syntax{"1.2.840.10008.1.2.4.91", Codec::kJpeg2000, "JPEG 2000"},
};

// A stream of a few bytes may stand for a large frame of one value. Up to this size that is
// believed; above it a frame may have so many times its stream's bytes.
constexpr std::int64_t kFreeFrameBytes = std::int64_t{16} << 20;
constexpr std::int64_t kMaxCompression = 250;

// OpenJPEG keeps some kilobytes for every tile that a header announces.
constexpr std::int64_t kMaxTiles = 1024;

std::atomic<ForeignDicomDecoder> foreign_decoder{nullptr};

const Syntax* find_syntax(const std::string& uid) noexcept {
  const auto* const found = std::find_if(kSyntaxes.begin(), kSyntaxes.end(),
                                         [&](const Syntax& s) { return s.uid == uid; });
  return found == kSyntaxes.end() ? nullptr : found;
}

// Looks through a stream's markers.
class StreamReader {
 public:
  StreamReader(const Syntax& syntax, std::span<const std::byte> stream,
               const DicomFrameShape& shape)
      : syntax_(syntax), stream_(stream), shape_(shape) {}

  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFileFormat) const {
    throw Error(code, fmt::format("{}: {} stream: {}", shape_.where, syntax_.name, what));
  }

  std::int64_t size() const { return static_cast<std::int64_t>(stream_.size()); }
  std::uint32_t byte(std::int64_t at) const {
    if (at < 0 || at >= size()) fail("is cut short");
    return static_cast<std::uint32_t>(stream_[static_cast<std::size_t>(at)]);
  }
  std::int64_t word(std::int64_t at) const { return byte(at) << 8U | byte(at + 1); }
  std::int64_t long_word(std::int64_t at) const { return word(at) << 16 | word(at + 2); }

  // The length of the marker segment at `at`, its marker not counted; all of it is there.
  std::int64_t segment_length(std::int64_t at) const {
    const std::int64_t length = word(at + 2);
    if (length < 2 || at + 2 + length > size()) fail("a marker segment is cut short");
    return length;
  }

  void expect_size(std::int64_t columns, std::int64_t rows, std::int64_t components,
                   std::int64_t precision) const {
    if (columns != shape_.columns || rows != shape_.rows || components != 1) {
      fail(fmt::format("says {}x{}, {} components: the file says {}x{}, 1", columns, rows,
                       components, shape_.columns, shape_.rows));
    }
    const int most = std::min(shape_.bits_allocated, 16);
    if (precision < 2 || precision > most) {
      fail(fmt::format("has samples of {} bits: expected 2 to {}", precision, most));
    }
  }

  // JPEG and JPEG-LS share their markers. Up to the end of the image, or of the stream.
  DicomStreamHeader check_jpeg() const {
    if (word(0) != 0xFFD8) fail("does not begin with SOI");
    std::optional<DicomStreamHeader> header;
    int num_scans = 0;
    for (std::int64_t at = 2;;) {
      if (byte(at) != 0xFF) fail(fmt::format("byte {}: expected a marker", at));
      const std::uint32_t marker = byte(at + 1);
      if (marker == 0xFF) {  // filling
        ++at;
        continue;
      }
      if (marker == 0xD9) {
        if (num_scans == 0) fail("ends before its first scan");
        return *header;
      }
      const std::int64_t length = segment_length(at);
      if (is_frame_header(marker)) {
        if (header) fail("has two frame headers");
        header = frame_header(marker, at, length);
      } else if (!is_plain_segment(marker)) {
        fail(fmt::format("marker {:02x} at byte {}", marker, at), ErrorCode::kUnsupported);
      }
      at += 2 + length;
      if (marker != 0xDA) continue;
      if (!header) fail("has a scan before its frame header");
      if (++num_scans > 1) fail("has several scans", ErrorCode::kUnsupported);
      at = end_of_scan(at);
      if (at < 0) return *header;
    }
  }

  // Only raw codestreams are meant for DICOM. Up to the first tile's data.
  DicomStreamHeader check_jpeg2000() const {
    if (word(0) != 0xFF4F || word(2) != 0xFF51) fail("does not begin with SOC and SIZ");
    if (segment_length(2) < 41) fail("SIZ is cut short");
    const std::int64_t width = long_word(8), height = long_word(12);
    const std::int64_t tile_width = long_word(24), tile_height = long_word(28);
    const std::int64_t precision = (byte(42) & 0x7FU) + 1;
    expect_size(width, height, word(40), precision);
    const bool is_simple = long_word(16) == 0 && long_word(20) == 0 && long_word(32) == 0 &&
                           long_word(36) == 0 && byte(43) == 1 && byte(44) == 1;
    if (!is_simple) fail("has an offset or is subsampled", ErrorCode::kUnsupported);
    if (tile_width < 1 || tile_height < 1) fail("has tiles of no size");
    const std::int64_t num_tiles =
        ((width + tile_width - 1) / tile_width) * ((height + tile_height - 1) / tile_height);
    if (num_tiles > kMaxTiles) {
      fail(fmt::format("has {} tiles: at most {} are read", num_tiles, kMaxTiles),
           ErrorCode::kUnsupported);
    }
    bool has_coding_style = false;
    for (std::int64_t at = 2;;) {
      const std::int64_t marker = word(at);
      if (marker == 0xFF93) break;  // the data begin
      if (marker < 0xFF50 || marker == 0xFFD9) fail(fmt::format("byte {}: expected a marker", at));
      const std::int64_t length = segment_length(at);
      if (marker == 0xFF52) {
        if (length < 12) fail("COD is cut short");
        has_coding_style = true;
      }
      at += 2 + length;
    }
    if (!has_coding_style) fail("has no COD segment");
    return {static_cast<int>(precision), false};
  }

 private:
  bool is_frame_header(std::uint32_t marker) const {
    if (syntax_.codec == Codec::kJpegLs) return marker == 0xF7;
    return marker == 0xC0 || marker == 0xC1 || marker == 0xC3;
  }

  // Tables, restart intervals, application data, comments, scans; LSE in JPEG-LS.
  bool is_plain_segment(std::uint32_t marker) const {
    return marker == 0xC4 || marker == 0xDB || marker == 0xDD || marker == 0xDA ||
           (marker >= 0xE0 && marker <= 0xEF) || marker == 0xFE ||
           (marker == 0xF8 && syntax_.codec == Codec::kJpegLs);
  }

  DicomStreamHeader frame_header(std::uint32_t marker, std::int64_t at, std::int64_t length) const {
    if (length < 11) fail("its frame header is cut short");
    const int precision = static_cast<int>(byte(at + 4));
    expect_size(word(at + 7), word(at + 5), byte(at + 9), precision);
    if (byte(at + 11) != 0x11) fail("is subsampled", ErrorCode::kUnsupported);
    const bool is_lossy_jpeg = marker == 0xC0 || marker == 0xC1;
    if (is_lossy_jpeg && precision != 8 && (marker == 0xC0 || precision != 12))
      fail(fmt::format("has samples of {} bits: expected 8, or 12 if extended", precision));
    return {precision, is_lossy_jpeg};
  }

  // The marker behind the coded data; -1 if they go on to the end.
  std::int64_t end_of_scan(std::int64_t at) const {
    for (; at + 1 < size(); ++at) {
      if (byte(at) != 0xFF) continue;
      const std::uint32_t next = byte(at + 1);
      // In JPEG-LS a bit of 0 follows FF, else a byte of 0 does.
      const bool is_data = syntax_.codec == Codec::kJpegLs ? next < 0x80 : next == 0;
      if (!is_data && next != 0xFF && (next < 0xD0 || next > 0xD7)) return at;
    }
    return -1;
  }

  const Syntax& syntax_;
  std::span<const std::byte> stream_;
  const DicomFrameShape& shape_;
};

std::int64_t bytes_of_frame(const DicomFrameShape& shape) {
  return shape.columns * shape.rows * (shape.bits_allocated / 8);
}

std::uint32_t little_word_at(std::span<const std::byte> bytes, std::size_t at) {
  return number_at<std::uint32_t>(bytes.data() + at, false);
}

// One plane of bytes, packed as runs and literals, to every `stride`-th byte of `out`.
void unpack_plane(const StreamReader& reader, std::span<const std::byte> packed,
                  std::span<std::byte> out, std::size_t first, std::size_t stride) {
  std::size_t at = 0;
  for (std::size_t to = first; to < out.size();) {
    if (at >= packed.size()) reader.fail("a segment ends before its plane is full");
    const auto control = static_cast<std::int8_t>(packed[at++]);
    if (control == -128) continue;
    const bool is_run = control < 0;
    const std::size_t count = static_cast<std::size_t>(is_run ? 1 - control : 1 + control);
    if (packed.size() - at < (is_run ? 1 : count)) reader.fail("a segment is cut short");
    for (std::size_t i = 0; i < count && to < out.size(); ++i, to += stride)
      out[to] = packed[is_run ? at : at + i];
    at += is_run ? 1 : count;
  }
}

// Checked and decoded in one: 16 words, the number of segments and their offsets, then one segment
// for each byte of a sample, the most significant first.
void decode_rle(const StreamReader& reader, std::span<const std::byte> stream,
                const DicomFrameShape& shape, std::span<std::byte> out) {
  const auto stride = static_cast<std::size_t>(shape.bits_allocated / 8);
  if (stream.size() < 64) reader.fail("is cut short");
  if (little_word_at(stream, 0) != stride) {
    reader.fail(fmt::format("has {} segments: expected {} for samples of {} bits",
                            little_word_at(stream, 0), stride, shape.bits_allocated));
  }
  for (std::size_t i = 0; i < stride; ++i) {
    const std::size_t begin = little_word_at(stream, 4 + 4 * i);
    const std::size_t end = i + 1 < stride ? little_word_at(stream, 8 + 4 * i) : stream.size();
    if (begin < 64 || begin > end || end > stream.size())
      reader.fail(fmt::format("segment {} lies outside of it", i));
    const std::size_t byte = std::endian::native == std::endian::little ? stride - 1 - i : i;
    unpack_plane(reader, stream.subspan(begin, end - begin), out, byte, stride);
  }
}

// Samples of one or two bytes to words of the file's width.
void widen(const char* from, std::size_t sample_bytes, std::size_t word_bytes,
           std::span<std::byte> out) {
  if (sample_bytes == word_bytes) {
    std::memcpy(out.data(), from, out.size());
    return;
  }
  std::fill(out.begin(), out.end(), std::byte{0});
  for (std::size_t i = 0, to = 0; to < out.size(); ++i, to += word_bytes) {
    const std::size_t shift =
        std::endian::native == std::endian::little ? 0 : word_bytes - sample_bytes;
    std::memcpy(out.data() + to + shift, from + i * sample_bytes, sample_bytes);
  }
}

}  // namespace

bool is_compressed_syntax(const std::string& uid) noexcept {
  return uid != "1.2.840.10008.1.2" && uid != "1.2.840.10008.1.2.1" &&
         uid != "1.2.840.10008.1.2.2" && uid != "1.2.840.10008.1.2.1.99";
}

std::string unreadable_syntax_reason(const std::string& uid) {
  const Syntax* const syntax = find_syntax(uid);
  if (syntax == nullptr) return fmt::format("transfer syntax {}, which is not read", uid);
#ifndef OVOID_IO_GDCM
  if (syntax->codec != Codec::kRle)
    return fmt::format("{} compressed, which this build does not read: it has no GDCM",
                       syntax->name);
#endif
  return {};
}

bool needs_foreign_decoder(const std::string& uid) noexcept {
  const Syntax* const syntax = find_syntax(uid);
  return syntax != nullptr && syntax->codec != Codec::kRle && foreign_decoder.load() == nullptr;
}

void set_foreign_dicom_decoder(ForeignDicomDecoder decoder) noexcept { foreign_decoder = decoder; }

DicomStreamHeader check_dicom_stream(const std::string& uid, std::span<const std::byte> stream,
                                     const DicomFrameShape& shape) {
  const Syntax* const syntax = find_syntax(uid);
  if (syntax == nullptr) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: {}", shape.where, unreadable_syntax_reason(uid)));
  }
  const StreamReader reader(*syntax, stream, shape);
  const std::int64_t frame_bytes = bytes_of_frame(shape);
  if (frame_bytes > kFreeFrameBytes && frame_bytes / kMaxCompression > reader.size()) {
    reader.fail(fmt::format("has {} bytes for a frame of {}: expected at least one in {}",
                            reader.size(), frame_bytes, kMaxCompression));
  }
  switch (syntax->codec) {
    case Codec::kRle:
      return {shape.bits_allocated, false};
    case Codec::kJpeg2000:
      return reader.check_jpeg2000();
    default:
      return reader.check_jpeg();
  }
}

void decode_dicom_frame(const std::string& uid, std::span<const std::byte> stream,
                        const DicomFrameShape& shape, std::span<std::byte> out) {
  const DicomStreamHeader header = check_dicom_stream(uid, stream, shape);
  const Syntax& syntax = *find_syntax(uid);
  const StreamReader reader(syntax, stream, shape);
  if (syntax.codec == Codec::kRle) return decode_rle(reader, stream, shape, out);
  const ForeignDicomDecoder decoder = foreign_decoder;
  if (decoder == nullptr) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: {} is decoded in a process of its own", shape.where, syntax.name));
  }
  const std::size_t sample_bytes = header.precision <= 8 ? 1 : 2;
  const auto word_bytes = static_cast<std::size_t>(shape.bits_allocated / 8);
  const std::vector<char> samples = decoder(syntax.codec, stream, shape, header);
  if (samples.size() != out.size() / word_bytes * sample_bytes) reader.fail("is damaged");
  widen(samples.data(), sample_bytes, word_bytes, out);
}

}  // namespace ovoid::io
