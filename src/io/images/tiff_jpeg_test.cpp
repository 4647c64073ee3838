// SPDX-License-Identifier: Apache-2.0
// TIFF whose strips and tiles are JPEG. What would make it fail: tables that do not reach the
// pictures, colours converted that are not YCbCr, a JPEG believed to have the TIFF's size.
#include "io/images/tiff_jpeg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "io/images/test_tiff.h"
#include "io/images/test_volumes.h"
#include "io/images/tiff.h"

namespace ovoid::io {
namespace tiff_jpeg_test {

using testing::HasSubstr;

Dataset read_jpeg_tiff(const std::string& content) {
  return read_tiff(*open_memory("a.tif", std::as_bytes(std::span(content))), {});
}

std::string jpeg_tiff_error(const std::string& content) {
  return error_of([&] { read_jpeg_tiff(content); });
}

// Slow changes, which JPEG keeps; components differ by more than it loses.
std::uint8_t smooth_value(std::size_t x, std::size_t y, std::size_t component, std::size_t page) {
  return static_cast<std::uint8_t>(40 + 2 * x + y + 50 * component + 20 * page);
}

std::string smooth_block(std::size_t x0, std::size_t y0, std::size_t width, std::size_t height,
                         std::size_t num_components, std::size_t page = 0) {
  std::string block;
  for (std::size_t y = y0; y < y0 + height; ++y)
    for (std::size_t x = x0; x < x0 + width; ++x)
      for (std::size_t c = 0; c < num_components; ++c)
        block += static_cast<char>(smooth_value(x, y, c, page));
  return block;
}

// The greatest difference of any component of any sample.
int jpeg_loss(const Dataset& dataset) {
  const Index3 dims = dataset.lattice.dims;
  const auto num_components = static_cast<std::size_t>(dataset.array().num_components);
  const std::vector<std::uint8_t> values = values_of<std::uint8_t>(dataset.array());
  int most = 0;
  std::size_t at = 0;
  for (std::size_t z = 0; z < static_cast<std::size_t>(dims[2]); ++z)
    for (std::size_t y = 0; y < static_cast<std::size_t>(dims[1]); ++y)
      for (std::size_t x = 0; x < static_cast<std::size_t>(dims[0]); ++x)
        for (std::size_t c = 0; c < num_components; ++c)
          most = std::max(most, std::abs(values.at(at++) - smooth_value(x, y, c, z)));
  return most;
}

// Rounding in the transform and its inverse at quality 100.
constexpr int kLossOfGrey = 2;
// Colours of half the resolution beside that, on slopes of 2 a pixel.
constexpr int kLossOfYcbcr = 6;

TestTiff jpeg_tiff(int num_samples, int photometric) {
  TestTiff tiff;
  tiff.width = 20;
  tiff.height = 18;
  tiff.rows_per_strip = 16;
  tiff.compression = 7;
  tiff.num_samples = num_samples;
  tiff.photometric = photometric;
  return tiff;
}

TEST(TiffJpeg, StripsOfAllColours) {
  struct Case {
    int num_samples, photometric, loss;
  };
  for (const Case& one : {Case{1, 1, kLossOfGrey}, Case{3, 2, kLossOfGrey},
                          Case{3, 6, kLossOfYcbcr}, Case{2, 1, kLossOfGrey}}) {
    for (const bool has_jpeg_tables : {true, false}) {
      for (const bool is_progressive : {false, true}) {
        SCOPED_TRACE(testing::Message() << one.num_samples << ' ' << one.photometric << ' '
                                        << has_jpeg_tables << is_progressive);
        TestTiff tiff = jpeg_tiff(one.num_samples, one.photometric);
        // A progressive picture's tables are its own.
        if (is_progressive && has_jpeg_tables) continue;
        tiff.has_jpeg_tables = has_jpeg_tables;
        tiff.jpeg.is_progressive = is_progressive;
        tiff.is_big_endian = has_jpeg_tables;
        const auto num_samples = static_cast<std::size_t>(one.num_samples);
        const Dataset dataset =
            read_jpeg_tiff(tiff_file(tiff, {smooth_block(0, 0, 20, 18, num_samples, 0),
                                            smooth_block(0, 0, 20, 18, num_samples, 1)}));
        EXPECT_EQ(dataset.lattice.dims, (Index3{20, 18, 2}));
        EXPECT_EQ(dataset.array().num_components, one.num_samples);
        EXPECT_LE(jpeg_loss(dataset), one.loss);
      }
    }
  }
}

TEST(TiffJpeg, TilesAndPlanes) {
  for (const bool is_planar : {false, true}) {
    TestTiff tiff = jpeg_tiff(3, 2);
    tiff.tile = 16;
    tiff.is_planar = is_planar;
    std::vector<std::string> tiles;
    for (std::size_t plane = 0; plane < (is_planar ? 3U : 1U); ++plane) {
      for (const std::size_t y : {0U, 16U}) {
        for (const std::size_t x : {0U, 16U}) {
          std::string tile = smooth_block(x, y, 16, 16, is_planar ? 1 : 3);
          if (is_planar)
            for (char& value : tile)
              value = static_cast<char>(value + 50 * static_cast<int>(plane));
          tiles.push_back(tile);
        }
      }
    }
    TiffWriter writer(tiff);
    writer.add_page(tiles);
    EXPECT_LE(jpeg_loss(read_jpeg_tiff(writer.bytes())), kLossOfGrey) << is_planar;
  }
}

// Writers may pack the last strip as long as the others.
TEST(TiffJpeg, LastStripMayBeWholeInItsJpeg) {
  const TestTiff tiff = jpeg_tiff(1, 1);
  TiffWriter writer(tiff);
  writer.add_page({smooth_block(0, 0, 20, 16, 1), smooth_block(0, 16, 20, 16, 1)});
  EXPECT_LE(jpeg_loss(read_jpeg_tiff(writer.bytes())), kLossOfGrey);
}

TEST(TiffJpeg, SizesMustBeTheTiffs) {
  const TestTiff tiff = jpeg_tiff(1, 1);
  const auto error = [&](const std::string& first) {
    TiffWriter writer(tiff);
    writer.add_page({first, smooth_block(0, 16, 20, 2, 1)});
    return jpeg_tiff_error(writer.bytes());
  };
  EXPECT_EQ(error(smooth_block(0, 0, 20, 16, 1)), "");
  EXPECT_THAT(error(smooth_block(0, 0, 20, 8, 1)),
              HasSubstr("page 0: a strip or tile is a JPEG of 20 x 8 pixels of 1 components: "
                        "expected 20 x 16 of 1"));
  EXPECT_THAT(error(smooth_block(0, 0, 20, 17, 1)), HasSubstr("is a JPEG of 20 x 17 pixels"));
  // A picture of colours in a page of grey, and the other way round.
  const std::string grey = smooth_block(0, 0, 8, 8, 1), colours = smooth_block(0, 0, 8, 8, 3);
  std::string out(64, '\0');
  const auto unpacked = [&](const std::string& picture, const TiffJpegBlock& block) {
    return unpack_tiff_jpeg(block, std::as_bytes(std::span(picture)),
                            std::as_writable_bytes(std::span(out)));
  };
  EXPECT_THAT(unpacked(jpeg_picture({.num_components = 3}, colours), {{}, 8, 8, 1}),
              HasSubstr("of 3 components: expected 8 x 8 of 1"));
  out.resize(192);
  EXPECT_THAT(unpacked(jpeg_picture({}, grey), {{}, 8, 8, 3}),
              HasSubstr("of 1 components: expected 8 x 8 of 3"));
  EXPECT_THAT(unpacked(jpeg_picture({}, grey), {{}, 8, 8, 3, true}),
              HasSubstr("of 1 components: expected 8 x 8 of 3"));
}

// The first four bytes of a field's value.
std::string with_field(std::string bytes, int tag, std::uint32_t value) {
  const std::string field{static_cast<char>(tag), static_cast<char>(tag >> 8)};
  const std::size_t directory =
      static_cast<unsigned char>(bytes[4]) + 256U * static_cast<unsigned char>(bytes[5]);
  for (std::size_t at = directory + 2; at + 12 <= bytes.size(); at += 12) {
    if (bytes.compare(at, 2, field) != 0) continue;
    for (std::size_t i = 0; i < 4; ++i) bytes[at + 8 + i] = static_cast<char>(value >> 8 * i);
    return bytes;
  }
  ADD_FAILURE() << "no field " << tag;
  return bytes;
}

TEST(TiffJpeg, WhatIsNotReadIsRefusedInWords) {
  TestTiff tiff = jpeg_tiff(1, 1);
  const std::vector<std::string> page{smooth_block(0, 0, 20, 18, 1)};
  const std::string whole = tiff_file(tiff, page);
  EXPECT_EQ(jpeg_tiff_error(whole), "");
  EXPECT_THAT(
      jpeg_tiff_error(with_field(whole, 259, 6)),
      HasSubstr("page 0: is compressed by JPEG of the old kind, which is not read: expected"));
  EXPECT_THAT(jpeg_tiff_error(with_field(whole, 258, 12)),
              HasSubstr("page 0: has JPEG of uint16 in 12 bits: expected uint8 in 8"));
  EXPECT_THAT(jpeg_tiff_error(with_field(whole, 262, 6)),
              HasSubstr("page 0: has YCbCr colours of 1 samples: expected three, together"));
  EXPECT_THAT(jpeg_tiff_error(with_field(whole, 262, 8)), HasSubstr("has colours of kind 8"));
  // A frame header that says 12 bits.
  std::string deep = whole;
  const std::size_t frame = deep.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  deep[frame + 4] = 12;
  EXPECT_THAT(jpeg_tiff_error(deep), HasSubstr("libjpeg: Unsupported JPEG data precision 12"));
  // Without the tables that its pictures lack.
  std::string bare = whole;
  const std::size_t tables = bare.find("\x5b\x01", 8);
  ASSERT_NE(tables, std::string::npos);
  bare[tables] = 0x5a;
  EXPECT_THAT(jpeg_tiff_error(bare), HasSubstr("libjpeg: Quantization table 0x00 was not defined"));
}

TEST(TiffJpeg, DamageIsTold) {
  TestTiff tiff = jpeg_tiff(3, 6);
  tiff.height = tiff.rows_per_strip = 16;
  const std::string picture = [&] {
    TestJpeg jpeg{.width = 20, .height = 16, .num_components = 3, .is_ycbcr = true};
    jpeg.has_tables = false;
    return jpeg_picture(jpeg, smooth_block(0, 0, 20, 16, 3));
  }();
  const std::string tables = jpeg_tables({.width = 20, .num_components = 3, .is_ycbcr = true});
  std::string out(std::size_t{20} * 16 * 3, '\0');
  const auto unpacked = [&](std::string_view shared, std::string_view bytes) {
    return unpack_tiff_jpeg({std::as_bytes(std::span(shared)), 20, 16, 3, true},
                            std::as_bytes(std::span(bytes)),
                            std::as_writable_bytes(std::span(out)));
  };
  EXPECT_EQ(unpacked(tables, picture), "");
  for (std::size_t size = 0; size < picture.size(); ++size)
    EXPECT_NE(unpacked(tables, std::string_view(picture).substr(0, size)), "") << size;
  for (std::size_t size = 1; size < tables.size(); ++size) {
    EXPECT_THAT(unpacked(std::string_view(tables).substr(0, size), picture),
                HasSubstr("has tables (JPEGTables) that cannot be read: libjpeg: "))
        << size;
  }
  EXPECT_THAT(unpacked(jpeg_picture({}, std::string(64, 'a')), picture),
              HasSubstr("a picture where tables are expected"));
  // Sizes that no file so small holds.
  std::string huge = tiff_file(tiff, {smooth_block(0, 0, 20, 16, 3)});
  for (const int tag : {256, 257, 278}) huge = with_field(huge, tag, 60'000);
  EXPECT_THAT(jpeg_tiff_error(huge), HasSubstr("too few for"));
  // The whole file, cut anywhere.
  const std::string whole = tiff_file(tiff, {smooth_block(0, 0, 20, 16, 3)});
  EXPECT_EQ(jpeg_tiff_error(whole), "");
  for (std::size_t size = 0; size < whole.size(); size += 3)
    EXPECT_NE(jpeg_tiff_error(whole.substr(0, size)), "") << size;
}

}  // namespace tiff_jpeg_test
}  // namespace ovoid::io
