// SPDX-License-Identifier: Apache-2.0
#include "io/images/tiff.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "io/core/test_folder.h"
#include "io/images/test_tiff.h"
#include "io/images/test_volumes.h"
#include "io/images/tiff_blocks.h"
#include "io/images/tiff_description.h"

namespace ovoid::io {
namespace tiff_test {

using testing::AnyOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Dataset read_bytes(const std::string& content, const ReadOptions& options = {}) {
  return read_tiff(*open_memory("a.tif", std::as_bytes(std::span(content))), options);
}

std::string text_of(const DataArray& array) {
  return {reinterpret_cast<const char*>(array.bytes.view.data()), array.bytes.view.size()};
}

// Two pages of 4 x 3 bytes.
const std::vector<std::string> kPages{"abcdefghijkl", "ABCDEFGHIJKL"};
const std::string kBoth = kPages[0] + kPages[1];

std::string reversed_pairs(std::string bytes) {
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) std::swap(bytes[i], bytes[i + 1]);
  return bytes;
}

TEST(Tiff, PagesAreSlicesInAllContainersAndCompressions) {
  for (const bool is_big_tiff : {false, true}) {
    for (const bool is_big_endian : {false, true}) {
      for (const int compression : {1, 5, 8, 32773, 50000}) {
        TestTiff tiff;
        tiff.is_big_tiff = is_big_tiff;
        tiff.is_big_endian = is_big_endian;
        tiff.compression = compression;
        const Dataset dataset = read_bytes(tiff_file(tiff, kPages));
        SCOPED_TRACE(compression);
        EXPECT_EQ(dataset.format, "TIFF");
        EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
        EXPECT_EQ(text_of(dataset.array()), kBoth);
        EXPECT_THAT(dataset.notes, IsEmpty());
        tiff.bits = 16;
        tiff.width = 2;
        EXPECT_EQ(text_of(read_bytes(tiff_file(tiff, kPages)).array()),
                  is_big_endian ? reversed_pairs(kBoth) : kBoth);
      }
    }
  }
}

// Strings of 4000 bytes, a table that fills up and is cleared, codes of all lengths.
TEST(Tiff, LzwOfManyCodes) {
  std::string data;
  unsigned state = 1;
  for (int i = 0; i < 60'000; ++i) {
    state = state * 1103515245 + 12345;
    data += static_cast<char>(i % 7000 < 3000 ? 'a' : state >> 16U & 15U);
  }
  const std::string packed = lzw_packed(data);
  std::string out(data.size(), '\0');
  EXPECT_EQ(unpack_tiff(kTiffLzw, std::as_bytes(std::span(packed)),
                        std::as_writable_bytes(std::span(out))),
            "");
  EXPECT_TRUE(out == data);
  EXPECT_EQ(unpack_tiff(kTiffLzw, std::as_bytes(std::span(packed)).first(packed.size() / 2),
                        std::as_writable_bytes(std::span(out))),
            "holds less than its part of the page");
}

TEST(Tiff, TilesPlanesAndTransparency) {
  TestTiff tiff;
  tiff.tile = 16;
  tiff.width = 20;
  tiff.height = 17;
  std::string wanted;
  std::vector<std::string> tiles(4, std::string(256, '#'));
  for (std::size_t y = 0; y < 17; ++y) {
    for (std::size_t x = 0; x < 20; ++x) {
      const char value = static_cast<char>(7 * y + x);
      tiles[y / 16 * 2 + x / 16][y % 16 * 16 + x % 16] = value;
      wanted += value;
    }
  }
  for (const int compression : {1, 5}) {
    tiff.compression = compression;
    TiffWriter writer(tiff);
    writer.add_page(tiles);
    EXPECT_EQ(text_of(read_bytes(writer.bytes()).array()), wanted) << compression;
  }
  TestTiff colours;
  colours.num_samples = 3;
  colours.photometric = 2;
  colours.width = 2;
  colours.height = 1;
  colours.is_planar = true;
  TiffWriter writer(colours);
  writer.add_page({"rR", "gG", "bB"});
  Dataset dataset = read_bytes(writer.bytes());
  EXPECT_EQ(dataset.array().num_components, 3);
  EXPECT_EQ(text_of(dataset.array()), "rgbRGB");
  colours.is_planar = false;
  colours.num_samples = 4;
  colours.has_alpha = true;
  dataset = read_bytes(tiff_file(colours, {"rgbaRGBA"}));
  EXPECT_EQ(dataset.array().num_components, 3);
  EXPECT_EQ(text_of(dataset.array()), "rgbRGB");
  EXPECT_THAT(dataset.notes, ElementsAre("a.tif: transparency is left out"));
}

TEST(Tiff, Predictors) {
  TestTiff tiff;
  tiff.compression = 8;
  tiff.predictor = 2;
  std::string differences;
  for (const char* const row : {"abcd", "efgh", "ijkl"}) differences += {row[0], '\1', '\1', '\1'};
  EXPECT_EQ(text_of(read_bytes(tiff_file(tiff, {differences})).array()), kPages[0]);
  // Big endian pairs: 0x0100, then 0x00ff more.
  TestTiff wide;
  wide.compression = 5;
  wide.predictor = 2;
  wide.bits = 16;
  wide.width = 2;
  wide.height = 1;
  wide.is_big_endian = true;
  EXPECT_EQ(
      values_of<std::uint16_t>(read_bytes(tiff_file(wide, {std::string("\1\0\0\xff", 4)})).array()),
      (std::vector<std::uint16_t>{0x0100, 0x01ff}));
  // The bytes of 1.0 (3f 80 00 00) and 2.0 (40 00 00 00), the highest first, as differences.
  TestTiff floats;
  floats.compression = 50000;
  floats.predictor = 3;
  floats.bits = 32;
  floats.format = 3;
  floats.width = 2;
  floats.height = 1;
  EXPECT_EQ(
      values_of<float>(
          read_bytes(tiff_file(floats, {std::string("\x3f\x01\x40\x80\0\0\0\0", 8)})).array()),
      (std::vector<float>{1.0F, 2.0F}));
}

// 1.0 (3c 00), -2.0 (c0 00) and 0.5 (38 00), as they are and as differences of both kinds.
TEST(Tiff, HalvesBecomeFloat32) {
  TestTiff tiff;
  tiff.bits = 16;
  tiff.format = 3;
  tiff.width = 3;
  tiff.height = 1;
  const auto values = [&](const std::string& block) {
    return values_of<float>(read_bytes(tiff_file(tiff, {block})).array());
  };
  const std::vector<float> expected{1, -2, 0.5F};
  EXPECT_EQ(values({"\0\x3c\0\xc0\0\x38", 6}), expected);
  tiff.is_big_endian = true;
  EXPECT_EQ(values({"\x3c\0\xc0\0\x38\0", 6}), expected);
  tiff.compression = 8;
  tiff.predictor = 2;
  EXPECT_EQ(values({"\x3c\0\x84\0\x78\0", 6}), expected);
  tiff.predictor = 3;
  EXPECT_EQ(values({"\x3c\x84\x78\xc8\0\0", 6}), expected);
}

TEST(Tiff, FewBits) {
  TestTiff tiff;
  tiff.bits = 1;
  tiff.width = 3;
  tiff.height = 2;
  Dataset dataset = read_bytes(tiff_file(tiff, {"\xa0\x40"}));
  EXPECT_EQ(values_of<std::uint8_t>(dataset.array()),
            (std::vector<std::uint8_t>{255, 0, 255, 0, 255, 0}));
  tiff.photometric = 3;
  dataset = read_bytes(tiff_file(tiff, {"\xa0\x40"}));
  EXPECT_EQ(values_of<std::uint8_t>(dataset.array()),
            (std::vector<std::uint8_t>{1, 0, 1, 0, 1, 0}));
  EXPECT_THAT(dataset.notes, ElementsAre(HasSubstr("values are its numbers")));
  tiff.photometric = 1;
  tiff.bits = 12;
  tiff.width = 2;
  tiff.height = 1;
  dataset = read_bytes(tiff_file(tiff, {"\x12\x3a\xbc"}));
  EXPECT_EQ(values_of<std::uint16_t>(dataset.array()), (std::vector<std::uint16_t>{0x123, 0xabc}));
}

TEST(Tiff, ImageJSaysWhichPageIsWhich) {
  TestTiff tiff;
  tiff.width = tiff.height = 1;
  tiff.rows_per_strip = 1;
  tiff.resolution = 4;
  tiff.resolution_unit = 1;
  tiff.description =
      "ImageJ=1.53t\nimages=12\nchannels=2\nslices=3\nframes=2\nunit=\\u00B5m\nspacing=0.5\n"
      "finterval=1.5\nloop=false\n";
  std::vector<std::string> pages;
  for (char c = 'a'; c < 'm'; ++c) pages.emplace_back(1, c);
  ReadOptions options;
  options.step = 1;
  Dataset dataset = read_bytes(tiff_file(tiff, pages), options);
  EXPECT_EQ(dataset.lattice.dims, (Index3{1, 1, 3}));
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(0.25, 0.25, 0.5));
  ASSERT_EQ(dataset.arrays.size(), 2U);
  EXPECT_EQ(dataset.arrays[0].name, "channel 1");
  EXPECT_EQ(text_of(dataset.arrays[0]), "gik");
  EXPECT_EQ(text_of(dataset.arrays[1]), "hjl");
  EXPECT_THAT(dataset.times, ElementsAre(0, 1.5));
  EXPECT_EQ(dataset.time_unit, "s");
  EXPECT_THAT(dataset.notes, ElementsAre("a.tif: lengths are in um, as the file has them"));
  options.array = "channel 2";
  options.raw.spacing = Vec3(1, 2, 3);
  dataset = read_bytes(tiff_file(tiff, pages), options);
  ASSERT_EQ(dataset.arrays.size(), 1U);
  EXPECT_EQ(text_of(dataset.arrays[0]), "hjl");
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(1, 2, 3));
  options.array = "DAPI";
  EXPECT_THAT(error_of([&] { read_bytes(tiff_file(tiff, pages), options); }),
              HasSubstr("array 'DAPI': no such channel: expected one of 'channel 1' 'channel 2'"));
  options = {};
  options.step = 2;
  EXPECT_THAT(error_of([&] { read_bytes(tiff_file(tiff, pages), options); }),
              HasSubstr("step 2: expected 0 to 1"));
  // Numbers that contradict the pages: these count.
  tiff.description = "ImageJ=1\nchannels=5\nslices=7\n";
  EXPECT_EQ(read_bytes(tiff_file(tiff, pages)).lattice.dims, (Index3{1, 1, 12}));
}

std::string ome(const std::string& pixels, const std::string& inside) {
  return "<?xml version=\"1.0\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\">"
         "<Image ID=\"Image:0\" Name=\"cells\"><Pixels SizeX=\"1\" SizeY=\"1\" " +
         pixels + ">" + inside + "</Pixels></Image></OME>";
}

// ImageJ takes the absolute value of a spacing, centimetres beside micrometres for those of the
// page, and a straight line from samples to values.
TEST(Tiff, ImageJSaysLengthsAndValues) {
  TestTiff tiff;
  tiff.width = tiff.height = 1;
  tiff.rows_per_strip = 1;
  tiff.resolution = 5000;
  tiff.resolution_unit = 3;
  tiff.bits = 16;
  tiff.description =
      "ImageJ=1.53t\nimages=2\nslices=2\nunit=micron\nspacing=-4.0\nfps=4\ncf=0\nc0=-32768.0\n"
      "c1=1.0\nvunit=Gray Value\n";
  const std::vector<std::string> pages{"ab", "cd"};
  Dataset dataset = read_bytes(tiff_file(tiff, pages));
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(2, 2, 4));
  EXPECT_EQ(dataset.array().value_offset, -32768);
  EXPECT_EQ(dataset.array().value_scale, 1);
  // Samples with a sign are kept without one.
  tiff.format = 2;
  EXPECT_EQ(read_bytes(tiff_file(tiff, pages)).array().value_offset, 0);
  tiff.description = with(tiff.description, "cf=0", "cf=4");
  dataset = read_bytes(tiff_file(tiff, pages));
  EXPECT_FALSE(dataset.array().is_scaled());
  EXPECT_THAT(dataset.notes, Contains(HasSubstr("no straight line (function 4)")));
  // Without a resolution pixels are 1 wide.
  tiff.resolution = 0;
  EXPECT_EQ(read_bytes(tiff_file(tiff, pages)).lattice.spacing(), Vec3(1, 1, 4));
}

// Numbers that contradict the pages: these count, and a note says so.
TEST(Tiff, DescriptionsOfMorePagesThanThereAre) {
  TestTiff tiff;
  tiff.width = tiff.height = 1;
  tiff.rows_per_strip = 1;
  const auto dims = [&](const std::string& description, std::size_t num_pages) {
    tiff.description = description;
    const std::vector<std::string> all{"a", "b", "c", "d"};
    const Dataset dataset =
        read_bytes(tiff_file(tiff, {all.begin(), all.begin() + static_cast<long>(num_pages)}));
    EXPECT_THAT(dataset.notes, Contains(HasSubstr("its description")));
    return Index3{dataset.lattice.dims[2], dataset.num_steps,
                  static_cast<std::int64_t>(dataset.arrays.size())};
  };
  EXPECT_EQ(dims("ImageJ=1.5\nimages=14\nslices=7\nframes=2\n", 4), (Index3{4, 1, 1}));
  EXPECT_EQ(dims("ImageJ=1.5\nimages=7\nslices=7\n", 1), (Index3{1, 1, 1}));
  EXPECT_EQ(dims("{\"shape\": [14, 1, 1], \"axes\": \"ZYX\"}", 4), (Index3{4, 1, 1}));
  EXPECT_EQ(dims("{\"shape\": [2, 1, 1]}", 4), (Index3{4, 1, 1}));
  EXPECT_EQ(dims("{\"shape\": [7, 1, 1]}", 1), (Index3{1, 1, 1}));
  EXPECT_EQ(dims("{\"shape\": [4, 5, 6]}", 4), (Index3{4, 1, 1}));
  EXPECT_EQ(dims(ome("SizeZ=\"3\" SizeC=\"2\" SizeT=\"1\"", ""), 4), (Index3{4, 1, 1}));
  EXPECT_EQ(dims(ome("SizeZ=\"2\" SizeC=\"1\" SizeT=\"5\" DimensionOrder=\"XYZCT\"", ""), 4),
            (Index3{2, 2, 1}));
}

// Large files of ImageJ's have one directory, and all slices behind its samples.
TEST(Tiff, ImageJWithOneDirectory) {
  TestTiff tiff;
  tiff.rows_per_strip = 3;
  tiff.description = "ImageJ=1.53t\nimages=2\nslices=2\n";
  TiffWriter writer(tiff);
  writer.add_page({kBoth});
  const Dataset dataset = read_bytes(writer.bytes());
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
  EXPECT_EQ(text_of(dataset.array()), kBoth);
  tiff.description = "ImageJ=1.53t\nimages=200000\nslices=200000\n";
  TiffWriter liar(tiff);
  liar.add_page({kBoth});
  EXPECT_THAT(error_of([&] { read_bytes(liar.bytes()); }), HasSubstr("file-format: a.tif: holds"));
}

TEST(Tiff, OmeSaysWhichPageIsWhich) {
  TestTiff tiff;
  tiff.width = tiff.height = 1;
  tiff.rows_per_strip = 1;
  tiff.description =
      ome("SizeZ=\"2\" SizeC=\"2\" SizeT=\"1\" DimensionOrder=\"XYZCT\" PhysicalSizeX=\"0.5\" "
          "PhysicalSizeY=\"500\" PhysicalSizeYUnit=\"nm\" PhysicalSizeZ=\"0.002\" "
          "PhysicalSizeZUnit=\"mm\"",
          "<Channel Name=\"A&amp;B\" Color=\"-16776961\"/><Channel Name=\"GFP\" "
          "Color=\"255\"/><TiffData/>");
  const std::vector<std::string> pages{"a", "b", "c", "d"};
  Dataset dataset = read_bytes(tiff_file(tiff, pages));
  ASSERT_EQ(dataset.arrays.size(), 2U);
  EXPECT_EQ(dataset.arrays[0].name, "A&B");
  EXPECT_EQ(text_of(dataset.arrays[0]), "ab");
  EXPECT_EQ(text_of(dataset.arrays[1]), "cd");
  EXPECT_LT((dataset.lattice.world_from_index.linear().diagonal() - Vec3(0.5, 0.5, 2)).norm(),
            1e-12);
  // Colours are red, green, blue and opacity, in a signed number; black is none.
  EXPECT_EQ(dataset.arrays[0].display.color, (std::array{1.0, 0.0, 0.0}));
  EXPECT_FALSE(dataset.arrays[1].display.color);
  // The channel first.
  tiff.description = with(tiff.description, "XYZCT", "XYCZT");
  EXPECT_EQ(text_of(read_bytes(tiff_file(tiff, pages)).arrays[0]), "ac");
  // Each plane by its page.
  tiff.description = with(tiff.description, "<TiffData/>",
                          "<TiffData IFD=\"3\" FirstZ=\"0\" FirstC=\"0\"/>"
                          "<TiffData IFD=\"2\" FirstZ=\"1\" FirstC=\"0\"/>"
                          "<TiffData IFD=\"0\" FirstZ=\"0\" FirstC=\"1\"/>"
                          "<TiffData IFD=\"1\" FirstZ=\"1\" FirstC=\"1\"/>");
  dataset = read_bytes(tiff_file(tiff, pages));
  EXPECT_EQ(text_of(dataset.arrays[0]), "dc");
  EXPECT_EQ(text_of(dataset.arrays[1]), "ab");
  const std::string missing = with(tiff.description, "IFD=\"3\"", "IFD=\"4\"");
  tiff.description = missing;
  EXPECT_THAT(error_of([&] { read_bytes(tiff_file(tiff, pages)); }),
              HasSubstr("its description names page 4, which is not there"));
  tiff.description =
      ome("SizeZ=\"2\" SizeC=\"1\" SizeT=\"2\" DimensionOrder=\"XYZTC\" TimeIncrement=\"2\"", "");
  ReadOptions options;
  options.step = 1;
  dataset = read_bytes(tiff_file(tiff, pages), options);
  EXPECT_EQ(text_of(dataset.arrays[0]), "cd");
  EXPECT_THAT(dataset.times, ElementsAre(0, 2));
  tiff.description = with(tiff.description, "XYZTC", "XYTZC");
  EXPECT_EQ(text_of(read_bytes(tiff_file(tiff, pages), options).arrays[0]), "bd");
}

TEST(Tiff, OmeIsRefusedInWords) {
  TestTiff tiff;
  tiff.width = tiff.height = 1;
  tiff.rows_per_strip = 1;
  const auto error = [&](const std::string& description) {
    tiff.description = description;
    return error_of([&] { read_bytes(tiff_file(tiff, {"a", "b"})); });
  };
  const std::string sizes = "SizeZ=\"2\" SizeC=\"1\" SizeT=\"1\"";
  EXPECT_EQ(error(ome(sizes, "")), "");
  EXPECT_THAT(error(ome(with(sizes, "\"2\"", "\"1000000000\""), "")),
              HasSubstr("has 1000000000 x 1 x 1 planes: at most 1000000 are read"));
  EXPECT_THAT(error(ome(with(sizes, "\"2\"", "\"-1\""), "")),
              HasSubstr("its OME description has SizeZ '-1': expected 1 or more"));
  EXPECT_THAT(error(ome(sizes + " DimensionOrder=\"XYZZT\"", "")),
              HasSubstr("has DimensionOrder 'XYZZT': expected XY and then Z, C and T"));
  EXPECT_THAT(error(ome(sizes,
                        "<TiffData><UUID FileName=\"a.ome.tif\"/></TiffData>"
                        "<TiffData><UUID FileName=\"b.ome.tif\"/></TiffData>")),
              HasSubstr("its planes lie in 2 files (a.ome.tif, ...), which are not put together"));
  EXPECT_THAT(error("<OME></OME>"), HasSubstr("its OME description names no image"));
  EXPECT_THAT(error(ome(sizes, "<TiffData IFD=\"0\"/>")), HasSubstr("1 planes are missing"));
  std::string again;
  for (int i = 0; i < 5; ++i) again += "<TiffData IFD=\"0\" PlaneCount=\"2\"/>";
  EXPECT_THAT(error(ome(sizes, again)), HasSubstr("names its planes again and again"));
}

TEST(Tiff, OneOfSeveralImages) {
  TestTiff tiff;
  tiff.width = tiff.height = 1;
  tiff.rows_per_strip = 1;
  const std::string image =
      "<Image Name=\"one\"><Pixels SizeZ=\"1\" SizeC=\"1\" SizeT=\"1\"/></Image>";
  tiff.description =
      "<OME>" + image + with(with(image, "one", "two"), "\"1\"", "\"3\"") + image + "</OME>";
  const std::vector<std::string> pages{"a", "b", "c", "d", "e"};
  Dataset dataset = read_bytes(tiff_file(tiff, pages));
  EXPECT_EQ(text_of(dataset.array()), "bcd");
  EXPECT_EQ(dataset.block, "two");
  ASSERT_EQ(dataset.blocks.size(), 3U);
  EXPECT_EQ(dataset.blocks[2].name, "one 2");
  ReadOptions options;
  options.block = "one 2";
  EXPECT_EQ(text_of(read_bytes(tiff_file(tiff, pages), options).array()), "e");
  options.block = "three";
  EXPECT_THAT(error_of([&] { read_bytes(tiff_file(tiff, pages), options); }),
              HasSubstr("block 'three': no such image: expected one of 'one' 'two' 'one 2'"));
}

// Samples of one of the letters, each of which differs, as the file of tifffile's has them.
struct Shaped {
  Dataset dataset;
  std::string text(std::size_t array = 0) const { return text_of(dataset.arrays[array]); }
};

Shaped read_shaped(TestTiff tiff, const std::string& description, std::size_t num_pages,
                   const ReadOptions& options = {}) {
  tiff.description = description;
  const std::size_t page_size =
      std::size_t{tiff.width} * tiff.height * static_cast<std::size_t>(tiff.num_samples);
  tiff.rows_per_strip = tiff.height;
  std::vector<std::string> pages(num_pages);
  char next = 'a';
  for (std::string& page : pages)
    for (std::size_t i = 0; i < page_size; ++i) page += next++;
  return {read_bytes(tiff_file(tiff, pages), options)};
}

TEST(Tiff, TifffileSaysShapeAndAxes) {
  const TestTiff wide{.width = 2, .height = 1};
  Shaped read = read_shaped(wide, R"({"shape": [2, 3, 1, 2], "axes": "CZYX"})", 6);
  EXPECT_EQ(read.dataset.lattice.dims, (Index3{2, 1, 3}));
  ASSERT_EQ(read.dataset.arrays.size(), 2U);
  EXPECT_EQ(read.text(0), "abcdef");
  EXPECT_EQ(read.text(1), "ghijkl");
  ReadOptions options;
  options.step = 1;
  read =
      read_shaped(wide, R"({"shape": [3, 2, 1, 2], "axes": "ZTYX", "finterval": 0.5})", 6, options);
  EXPECT_EQ(read.dataset.num_steps, 2);
  EXPECT_THAT(read.dataset.times, ElementsAre(0, 0.5));
  EXPECT_EQ(read.text(), "cdghkl");
  // No axes, and names that say nothing: as arrays of as many axes are taken.
  for (const char* const description :
       {R"({"shape": [2, 3, 1, 2]})", R"({"axes": "QQYX", "shape": [2, 3, 1, 2]})",
        "shape=(2, 3, 1, 2)"}) {
    read = read_shaped(wide, description, 6, options);
    EXPECT_EQ(read.dataset.num_steps, 2) << description;
    EXPECT_EQ(read.text(), "ghijkl") << description;
    EXPECT_THAT(read.dataset.notes, Contains(HasSubstr("--axis-order says another")));
  }
  read = read_shaped(wide, R"({"shape": [3, 1, 2], "axes": "QYX"})", 3);
  EXPECT_EQ(read.dataset.lattice.dims, (Index3{2, 1, 3}));
  // Pages that are no planes of (y, x): width is z.
  const TestTiff deep{.width = 3, .height = 2};
  read = read_shaped(deep, R"({"shape": [2, 2, 3], "axes": "XYZ"})", 2);
  EXPECT_EQ(read.dataset.lattice.dims, (Index3{2, 2, 3}));
  EXPECT_EQ(read.text(), "agdjbhekcifl");
  // Channels as the last axis are components, and as samples of a pixel, too.
  read = read_shaped({.width = 2, .height = 3}, R"({"shape": [2, 3, 2], "axes": "YXC"})", 2);
  EXPECT_EQ(read.dataset.array().num_components, 2);
  EXPECT_EQ(read.dataset.lattice.dims, (Index3{3, 2, 1}));
  EXPECT_EQ(read.text(), "abcdefghijkl");
  read = read_shaped({.width = 1, .height = 1, .num_samples = 3, .photometric = 2},
                     R"({"shape": [2, 2, 1, 1, 3], "axes": "CZYXS"})", 4);
  ASSERT_EQ(read.dataset.arrays.size(), 2U);
  EXPECT_EQ(read.dataset.arrays[1].num_components, 3);
  EXPECT_EQ(read.text(1), "ghijkl");
}

TEST(Tiff, TifffileSaysLengths) {
  TestTiff tiff{.width = 2, .height = 1, .resolution = 0.5, .resolution_unit = 1};
  const auto spacing = [&](const std::string& words) {
    return read_shaped(tiff, R"({"shape": [3, 1, 2], "axes": "ZYX")" + words + "}", 3)
        .dataset.lattice.spacing();
  };
  EXPECT_EQ(spacing(R"(, "spacing": 4.0, "unit": "um")"), Vec3(2, 2, 4));
  EXPECT_EQ(spacing(R"(, "spacing": -4.0, "unit": "\u00b5m")"), Vec3(2, 2, 4));
  EXPECT_EQ(spacing(""), Vec3(1, 1, 1));
  EXPECT_EQ(spacing(R"(, "PhysicalSizeX": 3, "PhysicalSizeY": 4, "PhysicalSizeZ": 5)"),
            Vec3(3, 4, 5));
  tiff.resolution_unit = 3;
  tiff.resolution = 5000;
  EXPECT_EQ(spacing(R"(, "spacing": 4.0, "unit": "um")"), Vec3(2, 2, 4));
  tiff.resolution_unit = 2;
  tiff.resolution = 0.5;
  EXPECT_EQ(spacing(R"(, "spacing": 4.0, "unit": "um")"), Vec3(2, 2, 4));
}

// One directory for all planes, and one description for each of several arrays.
TEST(Tiff, TifffileOfOneDirectoryAndOfSeveralSeries) {
  TestTiff tiff{.width = 2, .height = 1, .rows_per_strip = 1};
  tiff.description = R"({"shape": [2, 3, 1, 2], "axes": "CZYX", "truncated": true})";
  TiffWriter writer(tiff);
  writer.add_page({"abcdefghijkl"});
  Dataset dataset = read_bytes(writer.bytes());
  ASSERT_EQ(dataset.arrays.size(), 2U);
  EXPECT_EQ(text_of(dataset.arrays[1]), "ghijkl");
  ReadOptions options;
  options.raw.axis_order = "tzyx";
  options.step = 1;
  dataset = read_bytes(writer.bytes(), options);
  EXPECT_EQ(dataset.num_steps, 2);
  EXPECT_EQ(text_of(dataset.array()), "ghijkl");
  options.raw.axis_order = "zyx";
  EXPECT_THAT(error_of([&] { read_bytes(writer.bytes(), options); }),
              HasSubstr("axis order 'zyx': has 3 letters, the array has 4 axes: (2, 3, 1, 2)"));
}

// What one page says of several slices in it was read as one.
TEST(Tiff, OtherProgramsAreNamed) {
  TestTiff tiff;
  tiff.description = "frameNumbers = 1\nscanimage.SI.version = 5";
  EXPECT_THAT(read_bytes(tiff_file(tiff, kPages)).notes,
              Contains(HasSubstr("was written by ScanImage, whose own description is not read")));
}

TEST(Tiff, MiniaturesAreLeftOut) {
  TestTiff tiff;
  tiff.subfile_types = {0, 1, 0};
  const Dataset dataset = read_bytes(tiff_file(tiff, {kPages[0], kPages[0], kPages[1]}));
  EXPECT_EQ(text_of(dataset.array()), kBoth);
  EXPECT_THAT(dataset.notes, ElementsAre(HasSubstr("1 pages in miniature or of lower resolution")));
}

TEST(Tiff, CentimetresAreLengthsAndInchesAreNot) {
  TestTiff tiff;
  tiff.resolution = 20;
  tiff.resolution_unit = 3;
  Dataset dataset = read_bytes(tiff_file(tiff, kPages));
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(0.5, 0.5, 0.5));
  EXPECT_THAT(dataset.notes, ElementsAre(HasSubstr("the distance of slices is not said")));
  tiff.resolution_unit = 2;
  dataset = read_bytes(tiff_file(tiff, kPages));
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(1, 1, 1));
}

TEST(Tiff, DamageIsTold) {
  TestTiff tiff;
  const std::string whole = tiff_file(tiff, kPages);
  const auto error = [](const std::string& bytes) { return error_of([&] { read_bytes(bytes); }); };
  EXPECT_THAT(error(whole.substr(0, whole.size() - 30)),
              HasSubstr("its directory of a page would end behind the file"));
  TiffWriter writer(tiff);
  writer.add_page({kPages[0].substr(0, 8), kPages[0].substr(8)});
  std::string loop = writer.bytes();
  loop.replace(writer.link(), 4, loop.substr(4, 4));  // the first page once more
  EXPECT_THAT(error(loop), HasSubstr("its pages lead back to each other"));
  loop.replace(writer.link(), 4, writer.number(1'000'000, 4));
  EXPECT_THAT(error(loop), HasSubstr("its next page is behind its end"));
  // Sizes that no file so small holds.
  for (const int compression : {1, 5, 8, 32773, 50000}) {
    TestTiff huge;
    huge.width = huge.height = 1'000'000'000;
    huge.compression = compression;
    huge.rows_per_strip = 1'000'000'000;
    TiffWriter liar(huge);
    liar.add_page({"abc"});
    EXPECT_THAT(error(liar.bytes()), AnyOf(HasSubstr("too few for"), HasSubstr("holds 118 bytes")))
        << compression;
    huge.bits = 64;
    TiffWriter worse(huge);
    worse.add_page({"abc"});
    EXPECT_NE(error(worse.bytes()), "");
  }
  TestTiff packed;
  packed.compression = 8;
  std::string damaged = tiff_file(packed, kPages);
  damaged[12] = static_cast<char>(damaged[12] ^ 0x40);
  EXPECT_THAT(error(damaged), HasSubstr("page 0: a strip or tile"));
  packed.compression = 50000;
  damaged = tiff_file(packed, kPages);
  damaged[9] = static_cast<char>(damaged[9] ^ 0x40);
  EXPECT_THAT(error(damaged), HasSubstr("page 0: a strip or tile Zstandard: "));
  TestTiff strange;
  strange.compression = 34661;
  EXPECT_THAT(error(tiff_file(strange, kPages)),
              HasSubstr("page 0: is compressed by JBIG, which is not read: expected none, LZW"));
  strange = {};
  strange.bits = 24;
  strange.format = 3;
  strange.width = 2;
  EXPECT_THAT(error(tiff_file(strange, kPages)), HasSubstr("page 0: has floats of 24 bits"));
  TestTiff odd;
  TiffWriter two(odd);
  two.add_page({"abcdefgh", "ijkl"});
  odd.width = 3;
  two.add_page({"abcdef", "ghi"});
  EXPECT_THAT(error(two.bytes()), HasSubstr("page 1: has 3 x 3 pixels of uint8, page 0 has 4 x 3"));
}

TEST(Tiff, FilesAreStepsAndSlices) {
  const TestFolder folder;
  const TestTiff tiff;
  folder.write("t1.tif", tiff_file(tiff, kPages));
  folder.write("t2.tif", tiff_file(tiff, {kPages[1], kPages[0]}));
  ReadOptions options;
  options.step = 1;
  Dataset dataset = read_dataset({folder.file("t1.tif"), folder.file("t2.tif")}, options);
  EXPECT_EQ(dataset.num_steps, 2);
  EXPECT_EQ(text_of(dataset.array()), kPages[1] + kPages[0]);
  EXPECT_THAT(error_of([&] { read_dataset({folder.file("")}); }),
              HasSubstr("t1.tif: has 2 pages, a slice is one: name the files themselves, which are "
                        "then time steps"));
  folder.write("t1.tif", tiff_file(tiff, {kPages[0]}));
  folder.write("t2.tif", tiff_file(tiff, {kPages[1]}));
  for (const auto& paths :
       {std::vector{folder.file("")}, std::vector{folder.file("t1.tif"), folder.file("t2.tif")}}) {
    dataset = read_dataset(paths);
    EXPECT_EQ(dataset.format, "TIFF slices");
    EXPECT_EQ(text_of(dataset.array()), kBoth);
  }
}

TEST(Tiff, LargeStacksStayInTheirFile) {
  const TestFolder folder;
  const TestTiff tiff{.width = 64, .height = 64, .rows_per_strip = 64};
  TiffWriter writer(tiff);  // directories between pages keep them from being raw data
  writer.add_page({std::string(64 * 64, 'a')});
  folder.write("a.tif", writer.bytes());
  ReadOptions options;
  options.may_stay_in_file = true;
  options.memory_limit = 1000;
  EXPECT_NE(read_dataset({folder.file("a.tif")}, options).array().stored, nullptr);
}

}  // namespace tiff_test
}  // namespace ovoid::io
