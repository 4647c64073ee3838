// SPDX-License-Identifier: Apache-2.0
// Label maps as `ovoid render` draws them: by themselves and beside a scan. Fails if a name means
// another label, if labels that are hidden are drawn, or if what is wrong is not named.
#include <gtest/gtest.h>

#include <fstream>

#include "program.h"

namespace ovoid::cli_tests {
namespace labels_test {

class LabelMaps : public testing::Test {
 protected:
  void SetUp() override {
    expect_success({"make", "head-labels", "--size", "40", "--type", "uint8", "-o", map_});
    std::ofstream(table_) << "1 skin 255 0 0 255\n2 Skull 0 255 0 255\n5 brain 0 0 255 255\n"
                             "7 eyes 200 200 200 255\n";
  }

  Picture picture_of(const std::string& data, const Words& more) {
    Words words = {data, "--size", "80x80"};
    words.insert(words.end(), more.begin(), more.end());
    return draw(folder_, words);
  }
  static double sum(const Picture& image, std::size_t channel) {
    double all = 0;
    for (std::size_t i = channel; i < image.rgba.size(); i += 4) all += image.rgba[i];
    return all;
  }

  Folder folder_;
  std::string map_ = folder_ / "map.nrrd", table_ = folder_ / "names.txt",
              picture_ = folder_ / "p.png";
};

TEST_F(LabelMaps, AMapByItselfIsDrawnByItsSurfaces) {
  const Outcome drawn = run({"render", map_, "--size", "40x40", "-o", picture_});
  EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
  EXPECT_NE(drawn.err.find("look like labels"), std::string::npos) << drawn.err;
  const Picture skin = picture_of(map_, {"--label-table", table_});
  EXPECT_GT(sum(skin, 0), 500);
  EXPECT_LT(sum(skin, 1), 0.2 * sum(skin, 0));
}

TEST_F(LabelMaps, NamesAndNumbersMeanLabels) {
  const Picture by_name =
      picture_of(map_, {"--label-table", table_, "--label-opacity", "others=0,skull=1"});
  EXPECT_EQ(by_name.rgba,
            picture_of(map_, {"--label-table", table_, "--label-opacity", "2=1,others=0"}).rgba);
  EXPECT_GT(sum(by_name, 1), 200);
  EXPECT_LT(sum(by_name, 0), 0.2 * sum(by_name, 1));
}

TEST_F(LabelMaps, NamesAsJson) {
  const std::string json =
      R"({"1": ["skin", "#ff0000"], "2": ["Skull", "#00ff00", 1], "5": ["brain", "#0000ff"], "7": "eyes"})";
  const Words some = {"--label-opacity", "7=0,skin=0.25"};
  const Picture by_rows = picture_of(map_, {"--label-table", table_, some[0], some[1]});
  EXPECT_EQ(by_rows.rgba, picture_of(map_, {"--label-table", json, some[0], some[1]}).rgba);
  const std::string file = folder_ / "names.json";
  std::ofstream(file) << json;
  EXPECT_EQ(by_rows.rgba, picture_of(map_, {"--label-table", file, some[0], some[1]}).rgba);
}

TEST_F(LabelMaps, FlagsGiveColours) {
  const Words table = {"--label-table", table_};
  const Picture by_flag =
      picture_of(map_, {table[0], table[1], "--label-color", "skin=#00ff00,2=white,EYES=#0000ff"});
  EXPECT_GT(sum(by_flag, 1), 500);
  EXPECT_LT(sum(by_flag, 0), 0.2 * sum(by_flag, 1));
  EXPECT_EQ(by_flag.rgba, picture_of(map_, {table[0], table[1], "--label-color",
                                            "1=#00ff00,skull=#ffffff,7=blue"})
                              .rgba);
}

// A scan's slice with the outlines of its parts, and a map's in their colours.
TEST_F(LabelMaps, SlicesShowThem) {
  const std::string scan = folder_ / "scan.nrrd";
  expect_success({"make", "head", "--size", "40", "-o", scan});
  const Words flat = {"--labels",  map_,  "--label-table", table_,   "--slice", "axial",
                      "--opacity", "0:0", "--flat-labels", "--view", "+z"};
  const auto of_scan = [&](const Words& more) {
    Words words = flat;
    words.insert(words.end(), more.begin(), more.end());
    return picture_of(scan, words);
  };
  const Picture none = of_scan({"--slice-labels", "none"});
  EXPECT_NEAR(sum(none, 0), sum(none, 2), 1e-2);  // gray
  const Picture lines = of_scan({});
  EXPECT_EQ(lines.rgba, of_scan({"--slice-labels", "lines"}).rgba);
  EXPECT_GT(sum(lines, 0), sum(lines, 1) + 20);  // skin's, which is the longest
  const Picture areas = of_scan({"--slice-labels", "areas"});
  EXPECT_GT(sum(areas, 2), sum(lines, 2) + 200);  // the brain
  Words of_map = {"--label-table", table_, "--slice", "axial", "--flat-labels",
                  "--view",        "+z",   "--zoom",  "0.5"};
  const Picture map = picture_of(map_, of_map);
  EXPECT_GT(sum(map, 2), 50);
  of_map.emplace_back("--slice-outline=white");
  EXPECT_GT(picture_of(map_, of_map).num_covered(), map.num_covered() + 50);
  const Outcome lone = run({"render", scan, "--labels", map_, "--flat-labels", "-o", picture_});
  EXPECT_NE(lone.err.find("no effect without --slice"), std::string::npos) << lone.err;
}

// Light and camera go by what shows: hidden labels cast no shade, and need no room.
TEST_F(LabelMaps, HiddenLabelsAreNotThere) {
  const std::string alone = folder_ / "alone.nrrd";
  const std::string bytes = read_file(map_);
  std::string kept = bytes;
  const std::size_t begin = kept.find("\n\n") + 2;
  for (std::size_t i = begin; i < kept.size(); ++i)
    if (kept[i] != 7) kept[i] = 0;
  write_file(alone, kept);
  const Words eyes = {"--label-table", table_, "--label-opacity", "others=0,eyes=1"};
  EXPECT_GT(picture_of(map_, eyes).num_covered(), 300U);
  const Words camera = {
      "--camera", R"({"position": [0, -3, 0], "focal_point": [0, 0, 0], "view_up": [0, 0, 1]})"};
  const Picture hidden =
      picture_of(map_, {eyes[0], eyes[1], eyes[2], eyes[3], camera[0], camera[1]});
  const Picture only =
      picture_of(alone, {"--label-surfaces", eyes[0], eyes[1], camera[0], camera[1]});
  EXPECT_GT(sum(only, 3), 20);
  EXPECT_NEAR(sum(hidden, 3), sum(only, 3), 0.02 * sum(only, 3));
  EXPECT_NEAR(sum(hidden, 0) / sum(hidden, 3), sum(only, 0) / sum(only, 3), 0.05);
}

// A segmentation with two layers, in each of which label 1 is another segment.
TEST_F(LabelMaps, ASegmentationIsDrawnByItsOwnTable) {
  std::string bytes;
  for (int k = 0; k < 16; ++k)
    for (int j = 0; j < 16; ++j)
      for (int i = 0; i < 16; ++i)
        bytes += {static_cast<char>(i > 3 && i < 9), static_cast<char>(j > 3 && j < 12)};
  const std::string path = folder_ / "two.seg.nrrd";
  write_file(path,
             "NRRD0004\ntype: unsigned char\ndimension: 4\nsizes: 2 16 16 16\n"
             "kinds: list domain domain domain\nencoding: raw\nSegment0_LabelValue:=1\n"
             "Segment0_Layer:=0\nSegment0_Color:=1 0 0\nSegment0_Name:=first\n"
             "Segment1_LabelValue:=1\nSegment1_Layer:=1\nSegment1_Color:=0 0 1\n\n" +
                 bytes);
  const Picture first = picture_of(path, {"--component", "0"});
  EXPECT_GT(sum(first, 0), 500);
  EXPECT_LT(sum(first, 2), 0.3 * sum(first, 0));
  const Picture second = picture_of(path, {"--component", "1"});
  EXPECT_GT(sum(second, 2), 500);
  EXPECT_LT(sum(second, 0), 0.3 * sum(second, 2));
  // Both: the first keeps its number, and what both have is its own, as it has fewer samples.
  const Picture both = picture_of(path, {});
  EXPECT_GT(sum(both, 0), 300);
  EXPECT_GT(sum(both, 2), 300);
  const Picture red = picture_of(path, {"--label-opacity", "others=0,first=1"});
  EXPECT_GT(sum(red, 0), 500);
  EXPECT_LT(sum(red, 2), 0.3 * sum(red, 0));
  const Picture blue = picture_of(path, {"--label-opacity", "1=0"});
  EXPECT_GT(sum(blue, 2), 300);
  EXPECT_LT(sum(blue, 0), 0.3 * sum(blue, 2));
}

TEST_F(LabelMaps, BesideAScanTheyAreHiddenAndShown) {
  const std::string scan = folder_ / "scan.nrrd";
  expect_success({"make", "head", "--size", "40", "-o", scan});
  const Words shared = {"--labels", map_, "--label-table", table_};
  const auto with = [&](Words more) {
    more.insert(more.begin(), shared.begin(), shared.end());
    return picture_of(scan, more);
  };
  const Picture hidden = with({"--label-opacity", "others=0"});
  EXPECT_EQ(hidden.rgba, picture_of(scan, {}).rgba);
  const Picture brain =
      with({"--label-opacity", "others=0,brain=1", "--opacity", "-300:0,2000:0.05"});
  EXPECT_GT(sum(brain, 2), 100);
  const Picture inside =
      with({"--inside-labels", "brain", "--label-opacity", "others=0", "--range", "0,45"});
  const Picture outside =
      with({"--outside-labels", "brain", "--label-opacity", "others=0", "--range", "0,45"});
  const Picture whole = picture_of(scan, {"--range", "0,45"});
  EXPECT_GT(sum(inside, 3), 100);
  EXPECT_LT(sum(inside, 3), 0.8 * sum(whole, 3));
  EXPECT_NE(outside.rgba, whole.rgba);
}

TEST_F(LabelMaps, WhatIsWrongIsNamed) {
  expect_failure(
      {"render", map_, "--label-table", table_, "--label-opacity", "livr=1", "-o", picture_}, 1,
      {"--label-opacity livr", "1 (skin)"});
  expect_failure({"render", map_, "--label-opacity", "skin", "-o", picture_}, 2, {"LABEL=A"});
  expect_failure({"render", map_, "--label-color", "99=red", "-o", picture_}, 1,
                 {"--label-color 99", "no such label"});
  expect_failure({"render", map_, "--label-color", "1=#12345", "-o", picture_}, 2, {"#12345"});
  expect_failure({"render", map_, "--label-color", "red", "-o", picture_}, 2, {"LABEL=COLOR"});
  expect_failure({"render", map_, "--label-opacity", "1=1.5", "-o", picture_}, 2, {"1.5"});
  expect_failure({"render", map_, "--inside-labels", "1", "-o", picture_}, 2, {"--labels"});
  expect_failure({"render", map_, "--label-table", folder_ / "none.txt", "-o", picture_}, 1,
                 {"none.txt"});
  expect_failure({"render", map_, "--label-table", R"({"skin": 1})", "-o", picture_}, 2,
                 {"--label-table: skin", "must be a label"});
  const std::string scan = folder_ / "scan.nrrd";
  expect_success({"make", "ball", "--size", "16", "-o", scan});
  expect_failure({"render", scan, "--labels", scan, "-o", picture_}, 1,
                 {"--labels", "is no label"});
  expect_failure({"render", scan, "--labels", map_, "--mode", "mip", "-o", picture_}, 2,
                 {"--mode", "--labels"});
}

}  // namespace labels_test
}  // namespace ovoid::cli_tests
