// SPDX-License-Identifier: Apache-2.0
// Slices that are tiles of one picture. What would make these fail: a mosaic as one slice, tiles in
// another order, the corner of the whole picture as the place of the first slice, slices stacked
// against the CSA header, or a damaged header that is read beyond its end.
#include "io/dicom/dicom_tiles.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/core/test_folder.h"
#include "io/dicom/test_dicom_series.h"
#include "io/images/test_volumes.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace dicom_tiles_test {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A tag of a CSA header with texts as its items; `extra`: what the first version adds to lengths.
std::string csa_tag(const std::string& name, const std::vector<std::string>& items, bool is_second,
                    std::uint32_t extra) {
  const DicomElements e;
  std::string bytes = name + std::string(64 - name.size(), '\0');
  bytes += e.long_word(static_cast<std::uint32_t>(items.size())) + std::string("IS\0\0", 4) +
           e.long_word(6) + e.long_word(static_cast<std::uint32_t>(items.size())) + e.long_word(77);
  for (const std::string& item : items) {
    const auto size = static_cast<std::uint32_t>(item.size());
    bytes += is_second ? e.long_word(size) + e.long_word(size) + e.long_word(77) + e.long_word(size)
                       : e.long_word(size + extra) + std::string(12, '\0');
    bytes += item + std::string((4 - size % 4) % 4, '\0');
  }
  return bytes;
}

std::string csa_header(const std::string& num_slices, const std::string& up,
                       bool is_second = true) {
  const DicomElements e;
  const std::vector<std::string> number{num_slices + "       "}, normal{"0.0", "0.0", up};
  return (is_second ? std::string("SV10\4\3\2\1", 8) : std::string()) + e.long_word(3) +
         e.long_word(77) + csa_tag("EchoLinePosition", {"32"}, is_second, 1) +
         csa_tag("NumberOfImagesInMosaic", number, is_second, 1) +
         csa_tag("SliceNormalVector", normal, is_second, 1);
}

// Four tiles of 3 x 2 in two rows, of which three are slices; 4 mm apart; the first slice begins at
// (-10, 20, 5). Slice k has the samples 10 k + 1 to 10 k + 6.
TestSlice mosaic(int num_slices = 3) {
  TestSlice slice;
  slice.rows = 4;
  slice.columns = 6;
  slice.slope = "1";
  slice.intercept = "0";
  // Half of what the whole picture is larger by: 3 samples of 0.5 mm, 2 of 2 mm.
  slice.position = "-10.75\\18\\5";
  slice.groups.text(0x00080008, "CS", "ORIGINAL\\PRIMARY\\M\\ND\\MOSAIC")
      .text(0x00180088, "DS", "4");
  const DicomElements e(syntax_of(slice.uid));
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 6; ++column) {
      const int tile = row / 2 * 2 + column / 3;
      const int value = tile < num_slices ? 10 * tile + row % 2 * 3 + column % 3 + 1 : 0;
      slice.pixels += e.word(static_cast<std::uint16_t>(value));
    }
  }
  return slice;
}

void add_number(TestSlice& slice, std::uint16_t number) {
  slice.groups.text(0x00190010, "LO", "SIEMENS MR HEADER").us(0x0019100A, number);
}
void add_csa(TestSlice& slice, const std::string& header) {
  slice.groups.text(0x00290011, "LO", "SIEMENS CSA HEADER").raw(0x00291110, "OB", header);
}

void expect_near(const Vec3& actual, const Vec3& expected) {
  EXPECT_LT((actual - expected).norm(), 1e-12) << actual.transpose();
}

void expect_volume(const Dataset& dataset, bool is_against = false) {
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 3));
  expect_near(dataset.lattice.world_from_index.linear().col(2), {0, 0, 4});
  expect_near(dataset.lattice.world_from_index.translation(), {-10, 20, is_against ? -3.0 : 5.0});
  const auto values = values_of<std::uint16_t>(dataset.arrays.at(0));
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_EQ(values[6 * k + i], 10 * (is_against ? 2 - k : k) + i + 1) << k << ", " << i;
  }
}

Dataset read_one(const TestSlice& slice) {
  const std::string file = dicom_slice(slice);
  const TestFolder folder;
  return read_dataset({folder.write("a", file)});
}

TEST(DicomTiles, AMosaicIsAVolume) {
  TestSlice slice = mosaic();
  add_number(slice, 3);
  expect_volume(read_one(slice));
  EXPECT_THAT(read_one(slice).notes, IsEmpty());
}

TEST(DicomTiles, TheCsaHeaderSaysWhereSlicesGo) {
  for (const bool is_second : {true, false}) {
    for (const bool is_against : {true, false}) {
      TestSlice slice = mosaic();
      add_csa(slice, csa_header("3", is_against ? "-1.0" : "1.0", is_second));
      expect_volume(read_one(slice), is_against);
    }
  }
}

TEST(DicomTiles, EverySyntaxAndRunLengths) {
  for (const char* uid : {kImplicitUid, kBigUid, kDeflatedUid}) {
    TestSlice slice = mosaic();
    DicomElements groups(syntax_of(uid));
    groups.text(0x00080008, "CS", "ORIGINAL\\PRIMARY\\M\\ND\\MOSAIC").text(0x00180088, "DS", "4");
    groups.text(0x00190010, "LO", "SIEMENS MR HEADER").us(0x0019100A, 3);
    slice.groups = groups;
    if (std::string(uid) == kBigUid) {
      for (std::size_t i = 0; i + 1 < slice.pixels.size(); i += 2)
        std::swap(slice.pixels[i], slice.pixels[i + 1]);
    }
    slice.uid = uid;
    expect_volume(read_one(slice));
  }
  TestSlice packed = mosaic();
  add_number(packed, 3);
  packed.uid = "1.2.840.10008.1.2.5";
  packed.is_encapsulated = true;
  packed.pixels = encapsulated({rle_frame(packed.pixels)});
  expect_volume(read_one(packed));
}

TEST(DicomTiles, MosaicsAreSteps) {
  const TestFolder folder;
  for (int time = 0; time < 3; ++time) {
    TestSlice slice = mosaic();
    add_number(slice, 3);
    slice.sop = std::to_string(time);
    slice.instance = std::to_string(3 - time);
    // The patient moved a little, and the scanner followed.
    if (time == 1) slice.position = "-10.75\\18.3\\5.1";
    slice.groups.text(0x00080032, "TM", fmt::format("10000{}", 2 * time));
    slice.pixels[0] = static_cast<char>(50 + time);
    folder.write(std::to_string(time), dicom_slice(slice));
  }
  const Dataset dataset = read_dataset({folder.file("")});
  EXPECT_EQ(dataset.num_steps, 3);
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 3));
  EXPECT_THAT(dataset.times, ElementsAre(0, 2, 4));
  EXPECT_EQ(values_of<std::uint16_t>(dataset.arrays.at(0))[0], 50);
  EXPECT_THAT(dataset.notes, ElementsAre(HasSubstr("lie up to 0.3162 mm from the first")));
}

TEST(DicomTiles, AMosaicOfUnknownPlaceIsStillAVolume) {
  TestSlice slice = mosaic();
  add_number(slice, 3);
  slice.position.clear();
  const Dataset dataset = read_one(slice);
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 3));
  expect_near(dataset.lattice.world_from_index.linear().col(2), {0, 0, 4});
}

TEST(DicomTiles, WhatIsWrongIsNamed) {
  const auto error = [](const TestSlice& slice) { return error_of([&] { read_one(slice); }); };
  EXPECT_THAT(error(mosaic()), HasSubstr("a mosaic of Siemens (ImageType MOSAIC) that does not say "
                                         "of how many slices"));
  TestSlice slice = mosaic();
  add_number(slice, 5);  // 3 x 3 tiles do not divide 4 rows
  EXPECT_THAT(error(slice), HasSubstr("of 5 slices, 3 x 3 tiles, which do not divide its 6 x 4"));
  slice = mosaic();
  slice.groups.text(0x00190010, "LO", "ANOTHER OWNER").us(0x0019100A, 3);
  EXPECT_THAT(error(slice), HasSubstr("does not say of how many slices"));
  slice = mosaic();
  add_number(slice, 4);
  add_csa(slice, csa_header("3", "1.0"));
  EXPECT_THAT(read_one(slice).notes,
              Contains(HasSubstr("of 3 slices by its CSA header, of 4 by (0019,xx0a)")));
}

TEST(DicomTiles, ADamagedCsaHeaderIsReadAsFarAsItGoes) {
  for (const bool is_second : {true, false}) {
    const std::string whole = csa_header("3", "-1.0", is_second);
    ASSERT_EQ(read_csa_header(whole).num_slices, 3.0);
    ASSERT_TRUE(read_csa_header(whole).normal);
    for (std::size_t size = 0; size < whole.size(); ++size)
      EXPECT_FALSE(read_csa_header(whole.substr(0, size)).normal && size < whole.size() - 3)
          << size;
    for (std::size_t at = 0; at < whole.size(); ++at) {
      for (const char byte : {'\xff', '\x7f', '\0'}) {
        std::string damaged = whole;
        damaged[at] = byte;
        read_csa_header(damaged);  // under a sanitizer
      }
    }
  }
}

// A grid has as many rows of tiles as it needs, and a place for each.
TEST(DicomTiles, AGridOfUnitedImagingIsAVolume) {
  TestSlice slice = mosaic();
  slice.position.clear();
  slice.groups = DicomElements();
  slice.groups.text(0x00080008, "CS", "ORIGINAL\\PRIMARY\\M\\VFRAME");
  std::vector<DicomElements> items;
  for (const char* position : {"-10\\20\\5", "-10\\20\\9", "-10\\20\\13"})
    items.push_back(DicomElements().text(0x00200032, "DS", position));
  slice.groups.text(0x00650010, "LO", "Image Private Header").text(0x00651050, "DS", "3");
  TestSlice without = slice;
  slice.groups.sequence(0x00651051, items);
  expect_volume(read_one(slice));
  EXPECT_THAT(
      error_of([&] { read_one(without); }),
      HasSubstr("a grid of United Imaging (ImageType VFRAME) of 3 slices that states not all "
                "of their positions"));
}

TEST(DicomTiles, AGridMayHaveFewerRowsThanColumns) {
  StatedTiles stated;
  stated.is_grid = true;
  stated.positions.assign(5, Vec3(0, 0, 0));
  const DicomTiles tiles = divide_tiles(stated, 20, 30, 1);
  EXPECT_EQ(tiles.fault, "");
  EXPECT_EQ(tiles.across, 3);
  EXPECT_EQ(tiles.down, 2);
}

}  // namespace dicom_tiles_test
}  // namespace ovoid::io
