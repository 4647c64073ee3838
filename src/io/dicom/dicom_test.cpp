// SPDX-License-Identifier: Apache-2.0
// DICOM files made here, element by element, and what becomes of them. What would make these fail:
// slices in the order of names or numbers, rows and columns exchanged, a step along the normal
// where the gantry was tilted, bits beside the stored ones, a scale that is one slice's own.
#include "io/dicom/dicom.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "io/core/test_folder.h"
#include "io/dicom/test_dicom.h"
#include "io/images/test_volumes.h"
#include "io/read_source.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace dicom_test {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Dataset read_one(const std::string& file) {
  return read_source(*open_memory("a.dcm", std::as_bytes(std::span(file))), {});
}

std::string error_of_one(const TestSlice& slice) {
  const std::string file = dicom_slice(slice);
  return error_of([&] { read_one(file); });
}

// Slice number i of a series, 3 mm above the one before; its samples are 100 i + 1 to 100 i + 6.
TestSlice slice_of_series(int i) {
  TestSlice slice;
  slice.sop = "1.2.3." + std::to_string(i + 1);
  slice.instance = std::to_string(i + 1);
  slice.position = fmt::format("-10\\20\\{}", 3 * i);
  const DicomElements e(syntax_of(slice.uid));
  for (int k = 1; k <= 6; ++k) slice.pixels += e.word(static_cast<std::uint16_t>(100 * i + k));
  return slice;
}

void expect_near(const Vec3& actual, const Vec3& expected) {
  EXPECT_LT((actual - expected).norm(), 1e-12) << actual.transpose();
}

Vec3 axis_of(const Dataset& dataset, int axis) {
  return dataset.lattice.world_from_index.linear().col(axis);
}

const std::vector<std::uint16_t> kSix{1, 2, 3, 4, 5, 6};

TEST(Dicom, EverySyntaxGivesTheSameSlice) {
  for (const char* uid : {kImplicitUid, kExplicitUid, kBigUid, kDeflatedUid}) {
    SCOPED_TRACE(uid);
    TestSlice slice;
    slice.uid = uid;
    const Dataset dataset = read_one(dicom_slice(slice));
    EXPECT_EQ(dataset.format, "DICOM");
    EXPECT_EQ(dataset.space, Space::kLps);
    EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 1));
    const DataArray& array = dataset.arrays.at(0);
    EXPECT_EQ(array.type, ScalarType::kUInt16);
    EXPECT_EQ(values_of<std::uint16_t>(array), kSix);
    EXPECT_EQ(array.value_scale, 2.0);
    EXPECT_EQ(array.value_offset, -1000.0);
    EXPECT_EQ(array.unit, "HU");
    expect_near(axis_of(dataset, 0), {0.5, 0, 0});  // columns are named second
    expect_near(axis_of(dataset, 1), {0, 2, 0});
    expect_near(axis_of(dataset, 2), {0, 0, 3});
    expect_near(dataset.lattice.world_from_index.translation(), {-10, 20, 5});
    EXPECT_THAT(dataset.notes, IsEmpty());
  }
}

TEST(Dicom, FilesWithoutPreambleAreRead) {
  for (const char* uid : {kImplicitUid, kExplicitUid}) {
    TestSlice slice;
    slice.uid = uid;
    EXPECT_EQ(values_of<std::uint16_t>(read_one(data_set_of(slice)).arrays.at(0)), kSix) << uid;
    EXPECT_EQ(values_of<std::uint16_t>(read_one(dicom_slice(slice).substr(132)).arrays.at(0)),
              kSix);
  }
}

// What the first element shows counts more than what the header states.
TEST(Dicom, AWrongTransferSyntaxIsSeenThrough) {
  TestSlice slice;
  slice.uid = kImplicitUid;
  EXPECT_EQ(
      values_of<std::uint16_t>(read_one(dicom_file(kExplicitUid, data_set_of(slice))).arrays.at(0)),
      kSix);
}

TEST(Dicom, SlicesAreOrderedByPosition) {
  const TestFolder folder;
  const char* const names[] = {"d.dcm", "a.dcm", "c", "b.ima"};
  for (int i = 0; i < 4; ++i) {
    TestSlice slice = slice_of_series(i);
    slice.instance = std::to_string(10 - i);  // against the positions
    folder.write(names[i], dicom_slice(slice));
  }
  folder.write("notes.txt", "no slice");
  folder.write(".hidden", "neither");
  const Dataset dataset = read_dataset({folder.file("")});
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 4));
  expect_near(axis_of(dataset, 2), {0, 0, 3});
  expect_near(dataset.lattice.world_from_index.translation(), {-10, 20, 0});
  const auto values = values_of<std::uint16_t>(dataset.arrays.at(0));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(values[6 * i], 100 * i + 1);
  EXPECT_THAT(dataset.notes, ElementsAre(HasSubstr("1 file is left out: no DICOM")));
  EXPECT_TRUE(dataset.blocks.empty());

  // The same files by name, in any order.
  const Dataset named = read_dataset(
      {folder.file("c"), folder.file("b.ima"), folder.file("d.dcm"), folder.file("a.dcm")});
  EXPECT_EQ(values_of<std::uint16_t>(named.arrays.at(0)), values);
  EXPECT_THAT(named.notes, IsEmpty());

  std::vector<std::string> files = files_read_for(folder.file(""));
  EXPECT_EQ(files.size(), 5U);  // the folder and its slices
}

// Against the normal, slices descend: the world stays the same, the lattice begins at the lowest.
TEST(Dicom, ObliqueAndTiltedSlicesKeepTheirPlace) {
  const TestFolder folder;
  const double c = std::cos(0.3), s = std::sin(0.3);
  for (int i = 0; i < 3; ++i) {
    TestSlice slice = slice_of_series(i);
    slice.orientation = fmt::format("{:.17g}\\0\\{:.17g}\\0\\1\\0", c, -s);
    // The table moves along z, the gantry is tilted: steps are not along the normal.
    slice.position = fmt::format("1\\2\\{}", 4 * i);
    folder.write(std::to_string(i), dicom_slice(slice));
  }
  const Dataset dataset = read_dataset({folder.file("")});
  expect_near(axis_of(dataset, 0), Vec3(c, 0, -s) * 0.5);
  expect_near(axis_of(dataset, 1), {0, 2, 0});
  expect_near(axis_of(dataset, 2), {0, 0, 4});
  expect_near(dataset.lattice.world_from_index.translation(), {1, 2, 0});
}

TEST(Dicom, StoredBitsAreKeptAndOthersDropped) {
  TestSlice slice;
  slice.is_signed = 1;
  const DicomElements e;
  // 12 bits: 0x800 is -2048; an overlay's bits lie above.
  slice.pixels = e.word(0x0800) + e.word(0xF7FF) + e.word(0xF000) + e.word(0x0FFF) + e.word(1) +
                 e.word(0xFFFE);
  const Dataset low = read_one(dicom_slice(slice));
  EXPECT_EQ(low.arrays.at(0).type, ScalarType::kInt16);
  EXPECT_THAT(values_of<std::int16_t>(low.arrays.at(0)), ElementsAre(-2048, 2047, 0, -1, 1, -2));
  slice.is_signed = 0;
  EXPECT_THAT(values_of<std::uint16_t>(read_one(dicom_slice(slice)).arrays.at(0)),
              ElementsAre(0x800, 0x7FF, 0, 0xFFF, 1, 0xFFE));
  slice.high_bit = 15;
  EXPECT_THAT(values_of<std::uint16_t>(read_one(dicom_slice(slice)).arrays.at(0)),
              ElementsAre(0x080, 0xF7F, 0xF00, 0x0FF, 0, 0xFFF));
}

TEST(Dicom, BytesAndWordsOf32Bits) {
  TestSlice slice;
  slice.allocated = slice.stored = 8;
  slice.high_bit = 7;
  EXPECT_THAT(values_of<std::uint8_t>(read_one(dicom_slice(slice)).arrays.at(0)),
              ElementsAre(1, 2, 3, 4, 5, 6));
  // Big-endian files keep bytes in words of two.
  slice.uid = kBigUid;
  slice.pixels = {2, 1, 4, 3, 6, 5};
  EXPECT_THAT(values_of<std::uint8_t>(read_one(dicom_slice(slice)).arrays.at(0)),
              ElementsAre(1, 2, 3, 4, 5, 6));
  slice.pixels.clear();
  slice.allocated = slice.stored = 32;
  slice.high_bit = 31;
  const DicomElements e(DicomElements::Syntax::kBig);
  for (std::uint32_t i = 0; i < 6; ++i) slice.pixels += e.long_word(0xFFFFFFFF - i);
  slice.is_signed = 1;
  EXPECT_THAT(values_of<std::int32_t>(read_one(dicom_slice(slice)).arrays.at(0)),
              ElementsAre(-1, -2, -3, -4, -5, -6));
}

TEST(Dicom, EnhancedFramesAreSlices) {
  for (const char* uid : {kExplicitUid, kImplicitUid}) {
    for (const bool is_defined : {true, false}) {
      SCOPED_TRACE(std::string(uid) + (is_defined ? " defined" : " undefined"));
      const Dataset dataset = read_one(dicom_slice(enhanced_slices(is_defined, uid)));
      EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 3));
      EXPECT_THAT(values_of<std::uint16_t>(dataset.arrays.at(0)),
                  ElementsAre(7, 8, 9, 10, 11, 12, 1, 2, 3, 4, 5, 6, 13, 14, 15, 16, 17, 18));
      expect_near(axis_of(dataset, 0), {0.5, 0, 0});
      expect_near(axis_of(dataset, 2), {0, 0, 3});
      EXPECT_EQ(dataset.arrays[0].value_scale, 2.0);
      EXPECT_EQ(dataset.arrays[0].value_offset, -1000.0);
      EXPECT_EQ(dataset.arrays[0].unit, "HU");
      EXPECT_THAT(dataset.notes, IsEmpty());
    }
  }
}

TEST(Dicom, ClassicFramesFollowTheFirst) {
  TestSlice slice = enhanced_slices();
  slice.groups = DicomElements();
  slice.position = "1\\2\\3";
  slice.orientation = "1\\0\\0\\0\\1\\0";
  slice.thickness = "4";
  slice.spacing = "1\\1";
  const Dataset dataset = read_one(dicom_slice(slice));
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 3));
  EXPECT_EQ(values_of<std::uint16_t>(dataset.arrays.at(0)), counting<std::uint16_t>(18));
  expect_near(axis_of(dataset, 2), {0, 0, 4});
  expect_near(dataset.lattice.world_from_index.translation(), {1, 2, 3});
  EXPECT_THAT(dataset.notes, ElementsAre(HasSubstr("only the first frame's position is stated")));
}

TEST(Dicom, FramesAreStackedByTheirOffsets) {
  TestSlice slice = enhanced_slices();
  slice.position = "1\\2\\3";
  slice.orientation = "1\\0\\0\\0\\1\\0";
  slice.spacing = "1\\1";
  slice.groups = DicomElements();
  slice.groups.text(0x3004000C, "DS", "0\\-5\\-10").text(0x3004000E, "DS", "0.25");
  const Dataset dataset = read_one(dicom_slice(slice));
  expect_near(axis_of(dataset, 2), {0, 0, 5});
  expect_near(dataset.lattice.world_from_index.translation(), {1, 2, -7});
  EXPECT_EQ(values_of<std::uint16_t>(dataset.arrays.at(0))[0], 13);
  EXPECT_EQ(dataset.arrays[0].value_scale, 0.25);
}

TEST(Dicom, FramesInTimeAreSteps) {
  TestSlice slice = enhanced_slices();
  slice.position = "1\\2\\3";
  slice.orientation = "1\\0\\0\\0\\1\\0";
  slice.spacing = "1\\1";
  slice.groups = DicomElements();
  std::string file = dicom_slice(slice);
  const DicomElements e;
  // FrameIncrementPointer to FrameTime, behind NumberOfFrames.
  const std::string number = DicomElements().text(0x00280008, "IS", "3").bytes();
  const std::string pointer =
      DicomElements().raw(0x00280009, "AT", e.word(0x0018) + e.word(0x1063)).bytes();
  file = with(file, number, number + pointer);
  const Dataset dataset = read_one(file);
  EXPECT_EQ(dataset.num_steps, 3);
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 1));
  EXPECT_EQ(values_of<std::uint16_t>(dataset.arrays.at(0)), kSix);
}

TEST(Dicom, FloatPixels) {
  TestSlice slice;
  slice.pixels = std::string(12, '\0');
  std::string file = dicom_slice(slice);
  file.resize(file.size() - 24);  // the pixel data with their header
  const std::vector<float> values{0.5F, -1, 2, 3e8F, 4, 5};
  file += DicomElements().raw(0x7FE00008, "OF", bytes_of(values)).bytes();
  const Dataset dataset = read_one(file);
  EXPECT_EQ(dataset.arrays.at(0).type, ScalarType::kFloat32);
  EXPECT_EQ(values_of<float>(dataset.arrays[0]), values);
}

TEST(Dicom, SlicesWithScalesOfTheirOwnBecomeValues) {
  const TestFolder folder;
  for (int i = 0; i < 2; ++i) {
    TestSlice slice = slice_of_series(i);
    slice.slope = i == 0 ? "0.5" : "4";
    folder.write(std::to_string(i), dicom_slice(slice));
  }
  const Dataset dataset = read_dataset({folder.file("")});
  const DataArray& array = dataset.arrays.at(0);
  EXPECT_FALSE(array.is_scaled());
  EXPECT_THAT(values_of<float>(array), ElementsAre(-999.5F, -999, -998.5F, -998, -997.5F, -997,  //
                                                   -596, -592, -588, -584, -580, -576));
  EXPECT_THAT(dataset.notes,
              ElementsAre(HasSubstr("RescaleSlope and RescaleIntercept of their own")));
}

TEST(Dicom, CopiesAreDroppedAndCounted) {
  const TestFolder folder;
  for (int i = 0; i < 3; ++i)
    folder.write("s" + std::to_string(i), dicom_slice(slice_of_series(i)));
  folder.write("copy", dicom_slice(slice_of_series(1)));
  TestSlice renamed = slice_of_series(2);
  renamed.sop = "9.9";
  folder.write("renamed", dicom_slice(renamed));
  const Dataset dataset = read_dataset({folder.file("")});
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 3));
  EXPECT_THAT(dataset.notes,
              ElementsAre("1 slice is left out: another file holds the same SOP instance",
                          "1 slice is left out: another file holds the same pixels at the same "
                          "place"));
}

TEST(Dicom, TwoSeriesAreBlocks) {
  const TestFolder folder;
  for (int i = 0; i < 3; ++i)
    folder.write("a" + std::to_string(i), dicom_slice(slice_of_series(i)));
  for (int i = 0; i < 2; ++i) {
    TestSlice slice = slice_of_series(i + 7);
    slice.series = "1.7";
    slice.series_number = "2";
    folder.write("b" + std::to_string(i), dicom_slice(slice));
  }
  TestSlice scout = slice_of_series(0);
  scout.sop = "5";
  scout.orientation = "0\\1\\0\\0\\0\\-1";
  folder.write("scout", dicom_slice(scout));
  TestSlice photo = slice_of_series(0);
  photo.samples = 3;
  photo.photometric = "RGB";
  folder.write("photo", dicom_slice(photo));
  const Dataset dataset = read_dataset({folder.file("")});
  ASSERT_EQ(dataset.blocks.size(), 3U);
  EXPECT_EQ(dataset.blocks[0].name, "2");
  EXPECT_EQ(dataset.blocks[0].description, "CT 3x2x2 uint16, 'Abdomen', axial");
  EXPECT_EQ(dataset.blocks[1].name, "4");
  EXPECT_EQ(dataset.blocks[2].name, "4.2");
  EXPECT_EQ(dataset.blocks[2].description, "CT 3x2x1 uint16, 'Abdomen', sagittal");
  EXPECT_EQ(dataset.block, "4");
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 3));
  EXPECT_THAT(dataset.notes, Contains(HasSubstr("3 volumes; the largest, '4' (CT 3x2x3")));
  EXPECT_THAT(dataset.notes,
              Contains(HasSubstr("1 file is left out: colour picture (RGB, 3 samples per pixel)")));

  ReadOptions options;
  options.block = "2";
  const Dataset other = read_dataset({folder.file("")}, options);
  EXPECT_EQ(other.block, "2");
  EXPECT_EQ(values_of<std::uint16_t>(other.arrays.at(0))[0], 701);
  options.block = "5";
  EXPECT_THAT(error_of([&] { read_dataset({folder.file("")}, options); }),
              HasSubstr("block '5': expected one of '2', '4', '4.2'"));
}

TEST(Dicom, RepeatedPlacesAreStepsOrBlocks) {
  for (const bool is_time : {true, false}) {
    const TestFolder folder;
    for (int t = 0; t < 2; ++t) {
      for (int i = 0; i < 3; ++i) {
        TestSlice slice = slice_of_series(i + 10 * t);
        slice.position = fmt::format("0\\0\\{}", 3 * i);
        (is_time ? slice.trigger_time : slice.echo_time) = std::to_string(40 - 30 * t);
        folder.write(fmt::format("{}{}", t, i), dicom_slice(slice));
      }
    }
    const Dataset dataset = read_dataset({folder.file("")});
    EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 3));
    const auto first = values_of<std::uint16_t>(dataset.arrays.at(0))[0];
    ReadOptions options;
    if (is_time) {
      EXPECT_EQ(dataset.num_steps, 2);
      EXPECT_EQ(dataset.step, 0);
      EXPECT_EQ(first, 1001);  // the earlier, though its numbers are the higher
      EXPECT_THAT(dataset.times, ElementsAre(10, 40));
      options.step = 1;
      EXPECT_EQ(values_of<std::uint16_t>(read_dataset({folder.file("")}, options).arrays.at(0))[0],
                1);
    } else {
      EXPECT_EQ(dataset.num_steps, 1);
      ASSERT_EQ(dataset.blocks.size(), 2U);
      EXPECT_EQ(dataset.blocks[1].name, "4.2");
    }
  }
}

TEST(Dicom, WithoutPositionsNumbersOrder) {
  const TestFolder folder;
  for (int i = 0; i < 3; ++i) {
    TestSlice slice = slice_of_series(2 - i);
    slice.position.clear();
    folder.write(std::to_string(i), dicom_slice(slice));
  }
  const Dataset dataset = read_dataset({folder.file("")});
  EXPECT_EQ(values_of<std::uint16_t>(dataset.arrays.at(0))[0], 1);
  expect_near(axis_of(dataset, 2), {0, 0, 3});
  EXPECT_THAT(dataset.notes, ElementsAre(HasSubstr("slices are ordered by their numbers")));
}

TEST(Dicom, FoldersBelowAreReadIfThisOneHasNoPixels) {
  const TestFolder folder;
  std::filesystem::create_directories(folder.file("S1/deep"));
  folder.write("DICOMDIR",
               dicom_file(kExplicitUid, DicomElements().text(0x00041130, "CS", "D").bytes()));
  folder.write("S1/deep/1", dicom_slice(slice_of_series(0)));
  folder.write("S1/deep/2", dicom_slice(slice_of_series(1)));
  const Dataset dataset = read_dataset({folder.file("")});
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 2));
  EXPECT_THAT(dataset.notes, ElementsAre(HasSubstr("1 file is left out: DICOMDIR")));
  folder.write("3", dicom_slice(slice_of_series(2)));
  EXPECT_THAT(read_dataset({folder.file("")}).lattice.dims, ElementsAre(3, 2, 1));
}

TEST(Dicom, AFolderWithoutDicomIsRefused) {
  const TestFolder folder;
  folder.write("a.txt", "text");
  EXPECT_THAT(error_of([&] { read_dataset({folder.file("")}); }),
              HasSubstr("none of its 1 files is DICOM: a folder is read as DICOM slices"));
  for (int i = 0; i < 3; ++i)
    folder.write("slice" + std::to_string(i) + ".bmp", std::string("BM\x08\0\0\0\0\0\0\0", 10));
  EXPECT_THAT(error_of([&] { read_dataset({folder.file("")}); }),
              HasSubstr("none of its 4 files is DICOM: a folder is read as DICOM slices; 3 are BMP "
                        "pictures: stack them into one volume first"));
  EXPECT_THAT(error_of([&] { read_dataset({folder.file("slice1.bmp")}); }),
              HasSubstr("a BMP picture"));
  const std::string volumes = folder.file("volumes");
  std::filesystem::create_directory(volumes);
  folder.write("volumes/a.nrrd", "NRRD0004\n");
  EXPECT_THAT(error_of([&] { read_dataset({volumes}); }),
              HasSubstr("; 1 are of other kinds that are read: name the files themselves"));
  const std::string slice = folder.write("a.dcm", dicom_slice(slice_of_series(0)));
  EXPECT_THAT(error_of([&] {
                read_dataset({slice, folder.file("a.txt")});
              }),
              HasSubstr("a.txt: is no DICOM file: expected more slices of the series"));
  ReadOptions options;
  options.raw.dims = Index3{1, 1, 1};
  EXPECT_THAT(error_of([&] { read_dataset({folder.file("")}, options); }),
              HasSubstr("states its own layout"));
}

TEST(Dicom, WhatIsWrongIsNamed) {
  TestSlice slice;
  slice.orientation = "1\\0\\0\\0.1\\1\\0";
  EXPECT_THAT(error_of_one(slice),
              HasSubstr("expected two directions of length 1 at a right angle"));
  slice = {};
  slice.orientation = "0\\1\\0";
  EXPECT_THAT(error_of_one(slice), HasSubstr("(0020,0037): 3 numbers: expected 6"));
  slice = {};
  slice.position = "1\\2\\three";
  EXPECT_THAT(error_of_one(slice), HasSubstr("(0020,0032): 'three' is not a number"));
  slice = {};
  slice.pixels = "1234";
  EXPECT_THAT(error_of_one(slice),
              HasSubstr("pixel data have 4 bytes: expected 12 for 3x2, 1 frames of 16 bits"));
  slice = {};
  slice.num_frames = "1000000";
  EXPECT_THAT(error_of_one(slice), HasSubstr("1000000 frames: expected 1 to 100000"));
  slice = {};
  slice.stored = 17;
  EXPECT_THAT(error_of_one(slice), HasSubstr("BitsAllocated 16, BitsStored 17, HighBit 11"));
  slice = {};
  slice.slope = "0";
  EXPECT_THAT(error_of_one(slice), HasSubstr("RescaleSlope 0"));
  slice = {};
  slice.spacing = "0\\1";
  EXPECT_THAT(error_of_one(slice), HasSubstr("PixelSpacing 0, 1: expected two numbers > 0"));
  slice = {};
  slice.photometric = "PALETTE COLOR";
  EXPECT_THAT(error_of_one(slice), HasSubstr("unsupported: a.dcm: colour picture (PALETTE COLOR)"));
  slice = {};
  slice.uid = "1.2.840.10008.1.2.4.100";
  slice.is_encapsulated = true;
  slice.pixels = encapsulated({"1234"});
  EXPECT_THAT(error_of_one(slice), HasSubstr("transfer syntax 1.2.840.10008.1.2.4.100"));
}

TEST(Dicom, FilesCutShortAreErrors) {
  const std::string file = dicom_slice(TestSlice{});
  for (std::size_t size = 140; size < file.size(); ++size) {
    const std::string cut = file.substr(0, size);
    const std::string error = error_of([&] { read_one(cut); });
    EXPECT_NE(error, "") << size;
  }
  TestSlice slice;
  slice.uid = kDeflatedUid;
  std::string deflated = dicom_slice(slice);
  deflated.resize(deflated.size() - 20);
  EXPECT_THAT(error_of([&] { read_one(deflated); }), HasSubstr("deflated data set is damaged"));
}

TEST(Dicom, SequencesAreFollowedOnlySoDeep) {
  DicomElements inner;
  for (int i = 0; i < 100; ++i) inner = DicomElements().sequence(0x00091010, {inner}, false);
  TestSlice slice;
  slice.groups = inner;
  EXPECT_THAT(error_of_one(slice), HasSubstr("(0009,1010): sequences lie more than 16 deep"));
  slice.groups = DicomElements().sequence(0x00091010, {TestSlice{}.groups}, false);
  EXPECT_EQ(error_of_one(slice), "");
}

TEST(Dicom, MissingGeometryIsNoted) {
  TestSlice slice;
  slice.spacing.clear();
  slice.orientation.clear();
  slice.photometric = "MONOCHROME1";
  const Dataset dataset = read_one(dicom_slice(slice));
  EXPECT_EQ(dataset.space, Space::kNone);
  EXPECT_THAT(dataset.notes, Contains(HasSubstr("no PixelSpacing: samples are taken to be 1 mm")));
  EXPECT_THAT(dataset.notes, Contains(HasSubstr("no ImageOrientationPatient")));
  EXPECT_THAT(dataset.notes, Contains(HasSubstr("MONOCHROME1")));
}

}  // namespace dicom_test
}  // namespace ovoid::io
