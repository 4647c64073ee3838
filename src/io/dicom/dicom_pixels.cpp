// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_pixels.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <type_traits>
#include <vector>

#include "io/core/memory.h"
#include "io/core/samples.h"
#include "io/dicom/dicom_codec.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Where a frame's stored bytes are, piece by piece.
std::vector<DicomFragment> stored_pieces(const DicomFile& file, std::size_t frame) {
  if (!file.is_encapsulated) {
    const std::int64_t size = file.frame_bytes();
    return {{file.pixel_data.offset + static_cast<std::int64_t>(frame) * size, size}};
  }
  const auto begin = file.fragments.begin();
  return {begin + file.fragment_starts[frame], begin + file.fragment_starts[frame + 1]};
}

std::vector<std::byte> stored_bytes(const ByteSource& data, const DicomFile& file,
                                    std::size_t frame) {
  const std::vector<DicomFragment> pieces = stored_pieces(file, frame);
  std::size_t size = 0;
  for (const DicomFragment& piece : pieces) size += static_cast<std::size_t>(piece.length);
  // GDCM counts a stream's bytes in 32 bits.
  if (size > (std::size_t{1} << 31U) - 64U) {
    throw Error(
        ErrorCode::kUnsupported,
        fmt::format("{}: frame {} has {} bytes: at most 2 GiB are read", file.name, frame, size));
  }
  std::vector<std::byte> bytes(size);
  std::size_t at = 0;
  for (const DicomFragment& piece : pieces) {
    const auto count = static_cast<std::size_t>(piece.length);
    data.read(piece.offset, std::span(bytes).subspan(at, count));
    at += count;
  }
  return bytes;
}

// Single bytes that big-endian files keep in words of two: neighbours are swapped, and a frame may
// begin in the middle of a word.
void read_bytes_in_words(const ByteSource& data, const DicomFile& file, std::size_t frame,
                         std::span<std::byte> out) {
  const std::int64_t begin = static_cast<std::int64_t>(frame) * file.frame_bytes();
  const std::int64_t end = begin + static_cast<std::int64_t>(out.size());
  const std::int64_t first = begin & ~std::int64_t{1};
  const std::int64_t last = std::min((end + 1) & ~std::int64_t{1}, file.pixel_data.length);
  std::vector<std::byte> words(static_cast<std::size_t>(last - first));
  data.read(file.pixel_data.offset + first, words);
  for (std::size_t i = 0; i + 1 < words.size(); i += 2) std::swap(words[i], words[i + 1]);
  std::copy_n(words.begin() + (begin - first), out.size(), out.begin());
}

template <typename Word>
void unpack(std::span<std::byte> bytes, const DicomFile& file) {
  constexpr int kBits = static_cast<int>(sizeof(Word)) * 8;
  const int below = file.high_bit + 1 - file.bits_stored;
  const int above = kBits - 1 - file.high_bit;
  for (std::size_t i = 0; i + sizeof(Word) <= bytes.size(); i += sizeof(Word)) {
    Word word;
    std::memcpy(&word, bytes.data() + i, sizeof(Word));
    // To the top and down again: what is beside the stored bits falls off.
    word = static_cast<Word>(word << above);
    if (file.is_signed) {
      word = static_cast<Word>(static_cast<std::make_signed_t<Word>>(word) >> (above + below));
    } else {
      word = static_cast<Word>(word >> (above + below));
    }
    std::memcpy(bytes.data() + i, &word, sizeof(Word));
  }
}

// Keeps the bits that hold the sample; overlays and padding may lie beside them.
void keep_stored_bits(std::span<std::byte> bytes, const DicomFile& file) {
  if (file.pixels != DicomPixels::kInteger || file.bits_stored == file.bits_allocated) return;
  if (file.bits_allocated == 8) unpack<std::uint8_t>(bytes, file);
  if (file.bits_allocated == 16) unpack<std::uint16_t>(bytes, file);
  if (file.bits_allocated == 32) unpack<std::uint32_t>(bytes, file);
}

// `out` has file.frame_bytes().
void read_frame(const ByteSource& data, const DicomFile& file, std::size_t frame,
                std::span<std::byte> out) {
  if (file.is_encapsulated) {
    const std::vector<std::byte> stream = stored_bytes(data, file, frame);
    std::string where = file.name;
    if (file.num_frames > 1) where += fmt::format(": frame {}", frame);
    const DicomFrameShape shape{where, file.columns, file.rows, file.bits_allocated};
    decode_dicom_frame(file.transfer_syntax, stream, shape, out);
  } else if (file.pixel_data.is_big_endian && file.bits_allocated == 8 &&
             file.pixel_data.has_vr("OW")) {
    read_bytes_in_words(data, file, frame, out);
  } else {
    data.read(stored_pieces(file, frame)[0].offset, out);
    const bool is_native_big = std::endian::native == std::endian::big;
    if (file.pixel_data.is_big_endian != is_native_big)
      swap_bytes(out, static_cast<std::size_t>(file.bits_allocated / 8));
  }
  keep_stored_bits(out, file);
}

// The bytes of one tile, row by row.
void copy_tile(std::span<const std::byte> picture, const DicomFile& file, std::int64_t tile,
               std::span<std::byte> out) {
  const std::int64_t sample = file.bits_allocated / 8;
  const std::int64_t row_bytes = file.slice_columns() * sample;
  const std::int64_t first_row = tile / file.tiles.across * file.slice_rows();
  const std::int64_t first_byte = tile % file.tiles.across * row_bytes;
  for (std::int64_t row = 0; row < file.slice_rows(); ++row) {
    const std::int64_t from = (first_row + row) * file.columns * sample + first_byte;
    std::copy_n(picture.begin() + from, row_bytes, out.begin() + row * row_bytes);
  }
}

}  // namespace

void DicomSliceReader::read(const ByteSource& data, const DicomFile& file, std::size_t slice,
                            std::span<std::byte> out) {
  if (!file.is_tiled()) return read_frame(data, file, slice, out);
  const auto num_tiles = static_cast<std::size_t>(file.tiles.count);
  const std::size_t frame = slice / num_tiles;
  if (file_ != &file || frame_ != frame) {
    file_ = nullptr;
    require_memory(file.name + ": its picture", file.frame_bytes());
    picture_.resize(static_cast<std::size_t>(file.frame_bytes()));
    read_frame(data, file, frame, picture_);
    file_ = &file;
    frame_ = frame;
  }
  copy_tile(picture_, file, static_cast<std::int64_t>(slice % num_tiles), out);
}

bool is_same_dicom_slice(const ByteSource& data_a, const DicomFile& a, std::size_t slice_a,
                         const ByteSource& data_b, const DicomFile& b, std::size_t slice_b) {
  const auto tiles_a = static_cast<std::size_t>(a.tiles.count);
  const auto tiles_b = static_cast<std::size_t>(b.tiles.count);
  return a.transfer_syntax == b.transfer_syntax && slice_a % tiles_a == slice_b % tiles_b &&
         stored_bytes(data_a, a, slice_a / tiles_a) == stored_bytes(data_b, b, slice_b / tiles_b);
}

}  // namespace ovoid::io
