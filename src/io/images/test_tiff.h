// SPDX-License-Identifier: Apache-2.0
// TIFF files made here: for tests of the reader, and where fuzzing starts from.
#pragma once

#include <zstd.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "io/core/test_deflate.h"
#include "io/images/test_jpeg.h"

namespace ovoid::io {

// What all pages of a file are.
struct TestTiff {
  std::uint32_t width = 4, height = 3;
  int bits = 8, num_samples = 1, format = 1;  // 1: unsigned, 2: signed, 3: floats
  int photometric = 1, compression = 1, predictor = 1;
  bool is_big_endian = false, is_big_tiff = false, is_planar = false;
  std::uint32_t rows_per_strip = 2;
  std::uint32_t tile = 0;  // width and height of tiles; 0: strips
  std::string description{};
  double resolution = 0;  // pixels per unit
  int resolution_unit = 2;
  std::vector<std::uint32_t> subfile_types{};  // of pages
  bool has_alpha = false;                      // in the last sample
  TestJpeg jpeg{};                             // of compression 7; its sizes are the blocks'
  bool has_jpeg_tables = true;                 // shared by the blocks, else each has its own
};

// The same codes as TIFF's first encoder made.
inline std::string lzw_packed(const std::string& data) {
  std::string out;
  std::uint32_t window = 0;
  int num_bits = 0, width = 9;
  const auto put = [&](unsigned code) {
    window = window << width | code;
    for (num_bits += width; num_bits >= 8; num_bits -= 8)
      out += static_cast<char>(window >> (num_bits - 8));
  };
  std::map<std::string, unsigned> table;
  const auto clear = [&] {
    put(256);
    table.clear();
    for (unsigned i = 0; i < 256; ++i) table[std::string(1, static_cast<char>(i))] = i;
    width = 9;
  };
  clear();
  std::string text;
  for (const char c : data) {
    if (table.contains(text + c)) {
      text += c;
      continue;
    }
    put(table[text]);
    table.emplace(text + c, static_cast<unsigned>(table.size() + 2));
    const std::size_t next = table.size() + 2;
    if (next == 512 || next == 1024 || next == 2048) ++width;
    if (next == 4094) clear();
    text = c;
  }
  if (!text.empty()) put(table[text]);
  put(257);
  if (num_bits > 0) out += static_cast<char>(window << (8 - num_bits));
  return out;
}

// Runs of up to 128 bytes as they are.
inline std::string bits_packed(const std::string& data) {
  std::string out;
  for (std::size_t at = 0; at < data.size();) {
    std::size_t same = 1;
    while (same < 128 && at + same < data.size() && data[at + same] == data[at]) ++same;
    if (same > 2) {
      out += {static_cast<char>(1 - static_cast<int>(same)), data[at]};
      at += same;
      continue;
    }
    const std::size_t count = std::min<std::size_t>(100, data.size() - at);
    out += static_cast<char>(count - 1) + data.substr(at, count);
    at += count;
  }
  return out;
}

// Puts a file together, page after page.
class TiffWriter {
 public:
  explicit TiffWriter(const TestTiff& tiff) : tiff_(tiff) {
    bytes_ = tiff.is_big_endian ? "MM" : "II";
    bytes_ += number(tiff.is_big_tiff ? 43 : 42, 2);
    if (tiff.is_big_tiff) bytes_ += number(8, 2) + number(0, 2);
    link_ = bytes_.size();
    bytes_ += number(0, offset_size());
  }

  // `blocks`: what its strips or tiles hold, unpacked.
  void add_page(const std::vector<std::string>& blocks) {
    std::vector<std::uint64_t> offsets, counts;
    for (const std::string& block : blocks) {
      const std::string packed = pack(block);
      offsets.push_back(bytes_.size());
      counts.push_back(packed.size());
      bytes_ += packed;
    }
    fields_.clear();
    if (page_ < tiff_.subfile_types.size()) add(254, 4, {tiff_.subfile_types[page_]});
    add(256, 4, {tiff_.width});
    add(257, 4, {tiff_.height});
    add(258, 3,
        std::vector<std::uint64_t>(static_cast<std::size_t>(tiff_.num_samples),
                                   static_cast<std::uint64_t>(tiff_.bits)));
    add(259, 3, {static_cast<std::uint64_t>(tiff_.compression)});
    add(262, 3, {static_cast<std::uint64_t>(tiff_.photometric)});
    if (page_ == 0 && !tiff_.description.empty()) {
      std::vector<std::uint64_t> text(tiff_.description.begin(), tiff_.description.end());
      text.push_back(0);
      add(270, 2, text);
    }
    if (tiff_.tile == 0) add(273, 4, offsets);
    add(277, 3, {static_cast<std::uint64_t>(tiff_.num_samples)});
    if (tiff_.tile == 0) {
      add(278, 4, {tiff_.rows_per_strip});
      add(279, 4, counts);
    }
    if (tiff_.resolution > 0) {
      const auto upper = static_cast<std::uint64_t>(tiff_.resolution * 1000);
      for (const int tag : {282, 283}) add_at(tag, 5, 1, number(upper, 4) + number(1000, 4));
    }
    if (tiff_.is_planar) add(284, 3, {2});
    if (tiff_.resolution > 0) add(296, 3, {static_cast<std::uint64_t>(tiff_.resolution_unit)});
    if (tiff_.predictor > 1) add(317, 3, {static_cast<std::uint64_t>(tiff_.predictor)});
    if (tiff_.tile > 0) {
      add(322, 4, {tiff_.tile});
      add(323, 4, {tiff_.tile});
      add(324, tiff_.is_big_tiff ? 16 : 4, offsets);
      add(325, 4, counts);
    }
    if (tiff_.has_alpha) add(338, 3, {2});
    if (tiff_.format > 1) add(339, 3, {static_cast<std::uint64_t>(tiff_.format)});
    if (tiff_.compression == 7 && tiff_.has_jpeg_tables) {
      std::vector<std::uint64_t> tables;
      for (const char byte : jpeg_tables(jpeg_of(1)))
        tables.push_back(static_cast<unsigned char>(byte));
      add(347, 7, tables);
    }
    if (bytes_.size() % 2 != 0) bytes_ += '\0';
    const std::size_t at = bytes_.size();
    bytes_.replace(link_, static_cast<std::size_t>(offset_size()), number(at, offset_size()));
    bytes_ += number(num_fields_, tiff_.is_big_tiff ? 8 : 2) + fields_;
    link_ = bytes_.size();
    bytes_ += number(0, offset_size());
    num_fields_ = 0;
    ++page_;
  }

  // Where the last directory says where the next one is.
  std::size_t link() const { return link_; }
  const std::string& bytes() const { return bytes_; }

  std::string number(std::uint64_t value, int size) const {
    std::string out;
    for (int i = 0; i < size; ++i)
      out += static_cast<char>(value >> 8 * (tiff_.is_big_endian ? size - 1 - i : i));
    return out;
  }

 private:
  int offset_size() const { return tiff_.is_big_tiff ? 8 : 4; }

  void add(int tag, int type, const std::vector<std::uint64_t>& values) {
    const int size = type == 2 || type == 7 ? 1 : type == 3 ? 2 : type == 16 ? 8 : 4;
    std::string bytes;
    for (const std::uint64_t value : values) bytes += number(value, size);
    add_at(tag, type, values.size(), bytes);
  }

  // Values that do not fit the field go before the directory.
  void add_at(int tag, int type, std::uint64_t count, std::string values) {
    if (values.size() > static_cast<std::size_t>(offset_size())) {
      const std::size_t at = bytes_.size();
      bytes_ += values;
      values = number(at, offset_size());
    }
    values.resize(static_cast<std::size_t>(offset_size()));
    fields_ += number(static_cast<std::uint64_t>(tag), 2) +
               number(static_cast<std::uint64_t>(type), 2) + number(count, offset_size()) + values;
    ++num_fields_;
  }

  TestJpeg jpeg_of(std::uint32_t height) const {
    TestJpeg jpeg = tiff_.jpeg;
    jpeg.width = tiff_.tile > 0 ? tiff_.tile : tiff_.width;
    jpeg.height = height;
    jpeg.num_components = tiff_.is_planar ? 1 : tiff_.num_samples;
    jpeg.is_ycbcr = tiff_.photometric == 6;
    jpeg.has_tables = !tiff_.has_jpeg_tables;
    return jpeg;
  }

  std::string pack(const std::string& block) const {
    switch (tiff_.compression) {
      case 5:
        return lzw_packed(block);
      case 7: {
        const std::size_t row = jpeg_of(1).row_size();
        return jpeg_picture(jpeg_of(static_cast<std::uint32_t>(block.size() / row)), block);
      }
      case 8:
        return deflated(block, 15);
      case 50000: {
        std::string packed(ZSTD_compressBound(block.size()), '\0');
        packed.resize(ZSTD_compress(packed.data(), packed.size(), block.data(), block.size(), 1));
        return packed;
      }
      case 32773:
        return bits_packed(block);
      default:
        return block;
    }
  }

  const TestTiff& tiff_;
  std::string bytes_, fields_;
  std::uint64_t num_fields_ = 0;
  std::size_t link_ = 0, page_ = 0;
};

// `pages`: the samples of each as they are stored, in strips of the rows that the file is to have.
inline std::string tiff_file(const TestTiff& tiff, const std::vector<std::string>& pages) {
  TiffWriter writer(tiff);
  for (const std::string& page : pages) {
    std::vector<std::string> strips;
    const std::size_t strip = page.size() / tiff.height * tiff.rows_per_strip;
    for (std::size_t at = 0; at < page.size(); at += strip)
      strips.push_back(page.substr(at, strip));
    writer.add_page(strips);
  }
  return writer.bytes();
}

}  // namespace ovoid::io
