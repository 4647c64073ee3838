// SPDX-License-Identifier: Apache-2.0
#include "io/images/slices.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "io/core/test_folder.h"
#include "io/dicom/test_dicom.h"
#include "io/images/slice_names.h"
#include "io/images/slice_pictures.h"
#include "io/images/test_png.h"
#include "io/images/test_volumes.h"
#include "io/pictures/pictures.h"

namespace ovoid::io {
namespace slices_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string grey_slice(char value) { return png_file({2, 3}, std::string(6, value)); }

// Names of the files of a folder, without it.
std::vector<std::string> short_names(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  for (const std::string& path : paths)
    names.push_back(std::filesystem::path(path).filename().string());
  return names;
}

TEST(SliceNames, NumbersAreComparedAsNumbers) {
  std::vector<std::string> names{"s10", "s2", "s1b", "s1a", "s02", "t1", "s", "s1"};
  std::sort(names.begin(), names.end(), is_before_naturally);
  EXPECT_THAT(names, ElementsAre("s", "s1", "s1a", "s1b", "s2", "s02", "s10", "t1"));
  // Numbers beyond every integer.
  EXPECT_TRUE(is_before_naturally("a99999999999999999999", "a100000000000000000000"));
  EXPECT_FALSE(is_before_naturally("a1", "a1"));
}

TEST(SliceNames, MostNumerousKindOfAFolderIsTaken) {
  const SliceNames names =
      slices_of_folder("F", {"F/s_10.png", "F/s_9.png", "F/S_8.png", "F/preview.png", "F/a1.tif"});
  EXPECT_THAT(names.paths, ElementsAre("F/S_8.png", "F/s_9.png", "F/s_10.png"));
  EXPECT_THAT(names.left_out, ElementsAre("F/a1.tif", "F/preview.png"));
  EXPECT_THAT(names.notes, ElementsAre("F: a1.tif and 1 more left out: not named as its 3 slices"));
  EXPECT_THAT(error_of([] {
                slices_of_folder("F", {"F/a1.png", "F/a2.png", "F/b1", "F/b2"});
              }),
              HasSubstr("F: holds 2 files like a1.png and as many like b1"));
}

TEST(SliceNames, GapsAreTold) {
  EXPECT_THAT(slices_of_folder("F", {"1.png", "2.png", "5.png", "6.png", "9.png"}).notes,
              ElementsAre("F: no slices between 2 and 5, 6 and 9: the others are put at equal "
                          "distances"));
  EXPECT_THAT(slices_of_folder("F", {"s0010.png", "s0020.png", "s0030.png"}).notes, IsEmpty());
  EXPECT_THAT(slices_of_folder("F", {"1", "2", "4", "6", "8", "10", "12"}).notes,
              ElementsAre(HasSubstr("2 and 4, 4 and 6, 6 and 8 and in 2 more places")));
  EXPECT_THAT(slices_of_folder("F", {"t1z1.png", "t1z2.png", "t2z1.png"}).notes,
              ElementsAre(HasSubstr("differ in 2 numbers (t1z1.png, t1z2.png, ...)")));
  // Of a shell's order nobody has chosen one.
  EXPECT_THAT(slices_in_order("F", {"s1.png", "s10.png", "s2.png"}).notes,
              ElementsAre(HasSubstr("between 2 and 10")));
  EXPECT_THAT(slices_in_order("F", {"s2.png", "s1.png"}).notes,
              ElementsAre(HasSubstr("ordered by the numbers in their names")));
}

TEST(Slices, FolderIsAVolume) {
  const TestFolder folder;
  folder.write("s_10.png", grey_slice('c'));
  folder.write("s_9.png", grey_slice('b'));
  folder.write("s_8.png", grey_slice('a'));
  folder.write("readme.txt", "text");
  folder.write(".hidden.png", grey_slice('x'));
  Dataset dataset = read_dataset({folder.file("")});
  EXPECT_EQ(dataset.format, "PNG slices");
  EXPECT_EQ(dataset.lattice.dims, (Index3{2, 3, 3}));
  EXPECT_EQ(dataset.array().type, ScalarType::kUInt8);
  EXPECT_EQ(values_of<char>(dataset.array()),
            (std::vector<char>{'a', 'a', 'a', 'a', 'a', 'a', 'b', 'b', 'b', 'b', 'b', 'b', 'c', 'c',
                               'c', 'c', 'c', 'c'}));
  EXPECT_THAT(dataset.notes, IsEmpty());
  EXPECT_THAT(short_names(files_read_for(folder.file(""))),
              ElementsAre("", "s_10.png", "s_8.png", "s_9.png"));
  ReadOptions options;
  options.raw.spacing = Vec3(1, 2, 3);
  dataset = read_dataset({folder.file("s_8.png"), folder.file("s_10.png")}, options);
  EXPECT_EQ(dataset.lattice.dims, (Index3{2, 3, 2}));
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(1, 2, 3));
  EXPECT_EQ(values_of<char>(dataset.array())[6], 'c');
}

TEST(Slices, KindsOfPixels) {
  const TestFolder folder;
  const auto read = [&](const TestPng& png, const std::string& rows) {
    folder.write("1.png", png_file(png, rows));
    return read_dataset({folder.file("")});
  };
  Dataset dataset = read({1, 2, 16}, {"\x12\x34\xab\xcd", 4});
  EXPECT_EQ(values_of<std::uint16_t>(dataset.array()),
            (std::vector<std::uint16_t>{0x1234, 0xabcd}));
  // Four pixels of two bits: stretched, so that white is white.
  dataset = read({4, 1, 2}, "\x1b");
  EXPECT_EQ(values_of<std::uint8_t>(dataset.array()), (std::vector<std::uint8_t>{0, 85, 170, 255}));
  dataset = read({2, 1, 8, PngPixels::kGreyAlpha}, {"a\0b\0", 4});
  EXPECT_EQ(values_of<char>(dataset.array()), (std::vector<char>{'a', 'b'}));
  dataset = read({2, 1, 8, PngPixels::kRgb}, "abcddd");
  EXPECT_EQ(dataset.array().num_components, 3);
  EXPECT_EQ(dataset.array().num_tuples, 2);
  EXPECT_EQ(values_of<char>(dataset.array()), (std::vector<char>{'a', 'b', 'c', 'd', 'd', 'd'}));
  EXPECT_THAT(dataset.notes, ElementsAre(HasSubstr("red, green and blue are three components")));
  dataset = read({2, 1, 8, PngPixels::kRgba}, "aaaxbbby");  // grey all the same
  EXPECT_EQ(dataset.array().num_components, 1);
  EXPECT_EQ(values_of<char>(dataset.array()), (std::vector<char>{'a', 'b'}));
  dataset = read({2, 1, 8, PngPixels::kPalette, "aaabbbabc"}, {"\1\0", 2});
  EXPECT_EQ(values_of<char>(dataset.array()), (std::vector<char>{'b', 'a'}));
  EXPECT_THAT(dataset.notes, IsEmpty());
}

// Programs that make files small store few greys as a palette.
TEST(Slices, GreyAndColourMayBeMixed) {
  const TestFolder folder;
  folder.write("1.png", png_file({2, 1}, "ab"));
  folder.write("2.png", png_file({2, 1, 8, PngPixels::kPalette, "cccddd"}, {"\0\1", 2}));
  Dataset dataset = read_dataset({folder.file("")});
  EXPECT_EQ(dataset.array().num_components, 1);
  EXPECT_EQ(values_of<char>(dataset.array()), (std::vector<char>{'a', 'b', 'c', 'd'}));
  folder.write("3.png", png_file({2, 1, 8, PngPixels::kRgb}, "efgggg"));
  dataset = read_dataset({folder.file("")});
  const std::string values = "aaabbbcccdddefgggg";
  EXPECT_EQ(values_of<char>(dataset.array()), std::vector<char>(values.begin(), values.end()));
}

TEST(Slices, Jpeg) {
  const TestFolder folder;
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 16 * 16; ++i)
    for (const int c : {i, i, i, 255}) rgba.push_back(static_cast<std::uint8_t>(c));
  write_jpeg(rgba, 16, 16, folder.file("a1.jpg"));
  const Dataset dataset = read_dataset({folder.file("")});
  EXPECT_EQ(dataset.format, "JPEG slices");
  EXPECT_EQ(dataset.lattice.dims, (Index3{16, 16, 1}));
  ASSERT_EQ(dataset.array().num_components, 1);
  const auto values = values_of<std::uint8_t>(dataset.array());
  for (int i = 0; i < 256; ++i) EXPECT_NEAR(values[static_cast<std::size_t>(i)], i, 8) << i;
  const std::string whole = folder.read("a1.jpg");
  // Comments of 40,000 bytes stand before the size, as cameras' pictures in miniature do.
  const std::string comment = "\xFF\xFE\x9C\x42" + std::string(40'000, 'c');
  folder.write("a1.jpg", whole.substr(0, 2) + comment + comment + whole.substr(2));
  EXPECT_EQ(values_of<std::uint8_t>(read_dataset({folder.file("")}).array()), values);
  folder.write("a1.jpg", whole.substr(0, whole.size() - 60));
  EXPECT_THAT(error_of([&] { read_dataset({folder.file("")}); }),
              HasSubstr("a1.jpg: cannot be read: libjpeg: Premature end"));
}

TEST(Slices, WhatDoesNotFitIsNamed) {
  const TestFolder folder;
  for (const char* name : {"s1.png", "s2.png", "s3.png"}) folder.write(name, grey_slice('a'));
  folder.write("s1.png", png_file({3, 2}, "abcdef"));
  const auto error = [&] { return error_of([&] { read_dataset({folder.file("")}); }); };
  EXPECT_THAT(error(), HasSubstr("s1.png: has 3 x 2 pixels of uint8, other slices, like s2.png, "
                                 "have 2 x 3 pixels of uint8"));
  folder.write("s1.png", grey_slice('a'));
  folder.write("s3.png", png_file({2, 3, 16}, "abcdefghijkl"));
  EXPECT_THAT(error(), HasSubstr("s3.png: has 2 x 3 pixels of uint16"));
  const std::string whole = grey_slice('a');
  folder.write("s3.png", whole.substr(0, whole.size() - 20));
  EXPECT_THAT(error(), HasSubstr("s3.png: cannot be read: libpng: the file ends too soon"));
  folder.write("s3.png", whole.substr(0, 20));
  EXPECT_THAT(error(), HasSubstr("s3.png: cannot be read: libpng: the file ends too soon"));
  // A size that no file so small can hold is not believed.
  const std::string head =
      png_number(900'000) + png_number(900'000) + std::string("\x8\0\0\0\0", 5);
  folder.write("s3.png", "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", head) + png_chunk("IDAT", "x"));
  EXPECT_THAT(error(), HasSubstr("too few for a picture of 900000 x 900000 pixels"));
  folder.write("s3.png", grey_slice('a'));
  folder.write("note.txt", "text");
  EXPECT_THAT(error_of([&] {
                read_dataset({folder.file("s1.png"), folder.file("note.txt")});
              }),
              HasSubstr("note.txt: is no picture: expected another slice"));
  ReadOptions second;
  second.step = 1;
  EXPECT_THAT(error_of([&] {
                read_dataset({folder.file("s1.png"), folder.file("s2.png")}, second);
              }),
              HasSubstr("step 1: expected 0 to 0"));
  EXPECT_THAT(error_of([&] { read_dataset({folder.file("s1.png")}); }),
              HasSubstr("is a PNG picture: expected the folder of all slices of a volume"));
  EXPECT_THAT(error_of([&] {
                read_dataset({folder.file(""), folder.file("")});
              }),
              HasSubstr("is a folder of slices, of which one is read"));
  ReadOptions options;
  options.raw.dims = Index3{1, 1, 1};
  EXPECT_THAT(error_of([&] { read_dataset({folder.file("")}, options); }),
              HasSubstr("the format folder of slices states its own layout: dimensions"));
}

TEST(Slices, DicomGoesBeforePictures) {
  const TestFolder folder;
  folder.write("1.png", grey_slice('a'));
  folder.write("2.dcm", dicom_slice(TestSlice()));
  EXPECT_EQ(read_dataset({folder.file("")}).format, "DICOM");
}

}  // namespace slices_test
}  // namespace ovoid::io
