// SPDX-License-Identifier: Apache-2.0
// Tables of labels, as other programs write them. Fails if a name, colour or opacity is another's.
#include <gtest/gtest.h>

#include "io/core/test_folder.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace label_table_test {

class LabelTable : public testing::Test {
 protected:
  std::vector<LabelEntry> read(const std::string& text) {
    return read_label_table(folder_.write("table.txt", text));
  }
  void expect_refused(const std::string& text, const std::string& part) {
    try {
      read(text);
      ADD_FAILURE() << "no error, expected " << part;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFileFormat);
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  }

  io::TestFolder folder_;
};

TEST_F(LabelTable, SlicersColourTable) {
  const auto entries = read(
      "# Color table file\r\n0 Background 0 0 0 0\r\n12 left_kidney 255 0 51 255\r\n7 Vein of "
      "Galen 0 102 255 128\r\n");
  ASSERT_EQ(entries.size(), 3U);
  EXPECT_EQ(entries[0].opacity, 0);
  EXPECT_EQ(entries[1].label, 7);
  EXPECT_EQ(entries[1].name, "Vein of Galen");
  EXPECT_EQ(entries[1].color, (Rgb{0, 0.4, 1}));
  EXPECT_DOUBLE_EQ(*entries[1].opacity, 128.0 / 255);
  EXPECT_EQ(entries[2].name, "left_kidney");
  EXPECT_EQ(entries[2].opacity, 1);
}

TEST_F(LabelTable, FreeSurfersOpacitiesMeanNothing) {
  const auto entries =
      read("#No. Label Name: R G B A\n\n0  Unknown 0 0 0 0\n2 Left-WM 245 245 245 0\n");
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_EQ(entries[1].name, "Left-WM");
  EXPECT_FALSE(entries[1].opacity.has_value());
}

TEST_F(LabelTable, ItkSnapsDescriptions) {
  const auto entries = read(
      "################\n    0     0    0    0        0  0  0    \"Clear Label\"\n"
      "    1   255    0    0        1  1  1    \"Tumour core\"\n"
      "    2     0  255    0      0.5  0  1    \"Oedema\"\n");
  ASSERT_EQ(entries.size(), 3U);
  EXPECT_EQ(entries[1].name, "Tumour core");
  EXPECT_EQ(entries[1].color, (Rgb{1, 0, 0}));
  EXPECT_EQ(entries[1].opacity, 1);
  EXPECT_EQ(entries[2].opacity, 0);  // not visible
}

TEST_F(LabelTable, BidsColumnsInAnyOrder) {
  const auto entries = read("name\tcolor\tindex\nGray Matter\t#ff53bb\t1\nWhite Matter\tn/a\t2\n");
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_EQ(entries[0].name, "Gray Matter");
  EXPECT_EQ(entries[0].color, (Rgb{1, 83.0 / 255, 187.0 / 255}));
  EXPECT_FALSE(entries[1].color.has_value());
}

TEST_F(LabelTable, RowsOfANumberAndAName) {
  const auto entries = read("1 Precentral_L 2001\n2 Precentral_R 2002\n-5 minus\n2 Last_Counts\n");
  ASSERT_EQ(entries.size(), 3U);
  EXPECT_EQ(entries[0].label, -5);
  EXPECT_EQ(entries[1].name, "Precentral_L");
  EXPECT_EQ(entries[2].name, "Last_Counts");
}

TEST_F(LabelTable, Json) {
  const std::string text =
      R"( {"12": ["Vein of Galen", "#0066ff", 0.25], "-3": "spleen", "7": ["liver", null], "12": ["vein", "#ff0000"]})";
  const auto entries = read(text);
  ASSERT_EQ(entries.size(), 3U);
  EXPECT_EQ(entries[0].label, -3);
  EXPECT_EQ(entries[0].name, "spleen");
  EXPECT_FALSE(entries[0].color || entries[0].opacity);
  EXPECT_EQ(entries[1].name, "liver");
  EXPECT_FALSE(entries[1].color);
  EXPECT_EQ(entries[2].name, "vein");
  EXPECT_EQ(entries[2].color, (Rgb{1, 0, 0}));
  const auto again = label_table_from_text(R"({"12": ["a", "#0066ff", 0.25]})");
  EXPECT_EQ(again[0].color, (Rgb{0, 0.4, 1}));
  EXPECT_EQ(again[0].opacity, 0.25);
  EXPECT_EQ(label_table_from_text("5 heart 255 0 0 255\n")[0].name, "heart");
}

TEST_F(LabelTable, ASegmentationsHeader) {
  const std::string header =
      "NRRD0004\ntype: unsigned char\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n"
      "Segment0_Color:=1 0.5 0\nSegment0_ID:=Segment_1\nSegment0_LabelValue:=4\n"
      "Segment0_Name:=Left lung\nSegment1_LabelValue:=9\nSegment1_Name:=Heart\n"
      "Segment3_LabelValue:=4\nSegment3_Layer:=1\nSegment3_Name:=Tumour\n"
      "Segment2_Name:=nowhere\nSegmentation_SourceRepresentation:=Binary labelmap\n\n";
  const auto entries = read_label_table(folder_.write("x.seg.nrrd", header + '\0'));
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_EQ(entries[0].label, 4);
  EXPECT_EQ(entries[0].name, "Left lung");
  EXPECT_EQ(entries[0].color, (Rgb{1, 0.5, 0}));
  EXPECT_EQ(entries[1].name, "Heart");
  const auto second = read_label_table(folder_.file("x.seg.nrrd"), 1);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].name, "Tumour");
}

TEST_F(LabelTable, WhatIsWrongIsNamed) {
  expect_refused("", "has no labels");
  expect_refused("# nothing but a comment\n", "has no labels");
  expect_refused("1 one 0 0 0 255\nliver 3\n", "line 2");
  expect_refused("1 one 0 0 300 255\n", "300");
  expect_refused("1 2 3 \"unfinished\n", "line 1");
  expect_refused("1 255 0 0 2 1 1 \"x\"\n", "opacity");
  expect_refused("index\tname\nx\ty\n", "'x'");
  expect_refused("NRRD0004\nSegment0_LabelValue:=one\n\n", "line 2");
  expect_refused("{", "JSON");
  expect_refused("{}", "has no labels");
  expect_refused(R"({"liver": 1})", "its name must be a label");
  expect_refused(R"({"1.5": "liver"})", "its name must be a label");
  expect_refused(R"({"1": 2})", "must be a name");
  expect_refused(R"({"1": []})", "must be a name");
  expect_refused(R"({"1": ["liver", "red"]})", "#rrggbb");
  expect_refused(R"({"1": ["liver", null, 2]})", "an opacity from 0 to 1");
  EXPECT_THROW(read_label_table(folder_.file("none.txt")), Error);
}

}  // namespace label_table_test
}  // namespace ovoid
