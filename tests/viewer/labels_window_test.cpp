// SPDX-License-Identifier: Apache-2.0
// The list of labels in the tab "scene". Fails if the command or the state draws another picture
// than the window, if hiding a label costs its colour or opacity, if labels that the filter leaves
// out are changed, or if a dropped label map takes the place of the scan.
#include "screen.h"

namespace ovoid::viewer_tests {
namespace labels_window_test {

class WindowLabels : public OnScreen {
 protected:
  std::string make_map(const std::string& name = "map.nrrd") {
    write_file(folder_ / "names.txt",
               "1 skin 255 0 0 255\n2 Skull 0 255 0 255\n5 brain 0 0 255 255\n"
               "7 eyes 200 200 200 255\n");
    return make("head-labels", name, {"--size", "32", "--type", "uint8"});
  }
  std::string make_scan() { return make("head", "scan.nrrd", {"--size", "32"}); }
  // Bars of labels 1 to 120 beside each other, in air.
  std::string make_many() const {
    constexpr int kSide = 24;
    std::string bytes;
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
          const bool is_bar = z > 3 && z < 20 && y > 1 && y < 22 && x < 24;
          bytes += static_cast<char>(is_bar ? 1 + (x / 2 + 12 * ((y - 2) / 2)) % 120 : 0);
        }
    write_file(folder_ / "many.nrrd",
               "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 24 24 24\nencoding: raw\n\n" + bytes);
    return folder_ / "many.nrrd";
  }
  static std::string add(const std::string& path) {
    return "click scene.path\nkey ctrl+a\ntype " + path + "\nclick scene.add\nwait idle\n";
  }
  static constexpr const char* kBegin = "pace 0\nwait idle\nclick tab.scene\n";
};

TEST_F(WindowLabels, SlicesShowThemAsTheCommandAndTheStateSay) {
  const Viewed viewed =
      view({make_scan(), "--labels", make_map(), "--slice", "coronal", "--opacity", "0:0"},
           std::string(kBegin) +
               "picture $/lines.png\nclick scene.flat_labels@0.05,0.5\nwait idle\n"
               "expect scene.labels.are_flat == true\npicture $/flat.png\n"
               "click scene.slice_labels\nclick scene.slice_labels/both\nwait idle\n" +
               kSave);
  EXPECT_FALSE(file("lines.png") == file("flat.png"));
  EXPECT_FALSE(file("flat.png") == file("window.png"));
  expect_same(viewed, "window.png", "s.json");
  const std::string command = viewed.text("clipboard");
  EXPECT_NE(command.find("--slice-labels both"), std::string::npos) << command;
  EXPECT_NE(command.find("--flat-labels"), std::string::npos) << command;
}

TEST_F(WindowLabels, EditsAreThoseOfTheCommandAndTheState) {
  const Words words = {make_map(),  "--label-table", folder_ / "names.txt", "--label-opacity",
                       "brain=0.5", "--label-color", "eyes=#ffff00"};
  const Viewed viewed =
      view(words, std::string(kBegin) +
                      "expect scene.labels.count == 9\nexpect scene.labels.5.opacity == 0.5\n"
                      "expect scene.labels.7.color.2 == 0\npicture $/0.png\n"
                      "click scene.label.1.show@0.1,0.5\nwait idle\npicture $/1.png\n"
                      "expect scene.labels.1.opacity == 0\n"
                      "click scene.label.2.opacity@0.3,0.5\nclick scene.label.3.color\n"
                      "click scene.label.3.color/picker@0.3,0.1\nkey escape\nwait idle\n" +
                      kSave);
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_FALSE(file("1.png") == file("window.png"));
  expect_same(viewed, "window.png", "s.json");
  const std::string command = viewed.text("clipboard");
  EXPECT_NE(command.find("1=0,2=0.2"), std::string::npos) << command;
  EXPECT_NE(command.find("7=#ffff00"), std::string::npos) << command;
  // What flags alone would draw is what the window began with.
  Words plain = {"render"};
  plain.insert(plain.end(), words.begin(), words.end());
  plain.insert(plain.end(), {"-o", folder_ / "plain.png", "--size", "340x240", "--backend", "cpu",
                             "--axes", "--colorbar"});
  cli_tests::expect_success(plain);
  EXPECT_TRUE(file("0.png") == file("plain.png"));
}

// Fails, too, if the bar beside the picture tells labels that are hidden.
TEST_F(WindowLabels, HiddenLabelsComeBackAsTheyWere) {
  const Viewed viewed = view(
      {make_map(), "--label-table", folder_ / "names.txt"},
      std::string(kBegin) + "click scene.label.2.opacity@0.5,0.5\nwait idle\npicture $/0.png\n" +
          "click scene.label.2.show@0.1,0.5\nwait idle\nexpect scene.labels.2.opacity == 0\n" +
          kSave + "click scene.label.2.show@0.1,0.5\nwait idle\npicture $/back.png\n");
  EXPECT_TRUE(file("0.png") == file("back.png"));
  EXPECT_FALSE(file("0.png") == file("window.png"));
  expect_same(viewed, "window.png", "s.json");
  view({"--state", folder_ / "s.json"},
       std::string(kBegin) +
           "picture $/window2.png\nclick scene.label.2.show@0.1,0.5\nwait idle\n"
           "picture $/again.png\n");
  EXPECT_TRUE(file("window2.png") == file("window.png"));
  EXPECT_TRUE(file("again.png") == file("0.png"));
}

TEST_F(WindowLabels, AllAndNoneAreOfThoseThatAreListed) {
  const Viewed viewed =
      view({make_many(), "--label-surfaces"},
           std::string(kBegin) +
               "expect scene.labels.count == 121\nclick scene.label.117.show@0.1,0.5\n"
               "expect scene.labels.117.opacity == 0\nscreenshot $/list.png\n"
               "click scene.labels.none\nwait idle\nexpect scene.labels.1.opacity == 0\n"
               "click scene.labels.filter\ntype \"LABEL 11\"\nclick scene.labels.all\nwait idle\n"
               "expect scene.labels.11.opacity == 1\nexpect scene.labels.119.opacity == 1\n"
               "expect scene.labels.110.opacity == 1\nexpect scene.labels.1.opacity == 0\n"
               "expect scene.labels.120.opacity == 0\nexpect scene.labels.0.opacity == 0\n" +
               kSave);
  expect_same(viewed, "window.png", "s.json");
  // What is told is short.
  EXPECT_NE(viewed.text("clipboard").find("others=0,11=1,110=1,"), std::string::npos);
}

TEST_F(WindowLabels, AMapIsAddedToAScanTakenBackAndRemoved) {
  make_map();
  const Viewed viewed =
      view({make_scan()},
           std::string(kBegin) + "picture $/0.png\n" + add("$/map.nrrd") +
               "expect scene.labels.count == 9\nexpect scene.labels.file contains map.nrrd\n"
               "picture $/1.png\nclick scene.label.1.show@0.1,0.5\nwait idle\n" +
               kSave +
               "move picture@0.1,0.9\nkey ctrl+z\nwait idle\npicture $/shown.png\nkey ctrl+z\n"
               "wait idle\nexpect scene.labels.count == 0\npicture $/undone.png\nkey ctrl+y\n"
               "wait idle\nclick scene.labels.remove\nwait idle\nexpect scene.labels.count == 0\n"
               "picture $/removed.png\n");
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_FALSE(file("1.png") == file("window.png"));
  EXPECT_TRUE(file("shown.png") == file("1.png"));
  EXPECT_TRUE(file("undone.png") == file("0.png"));
  EXPECT_TRUE(file("removed.png") == file("0.png"));
  expect_same(viewed, "window.png", "s.json");
  // The state and what it names can be moved together.
  EXPECT_EQ(nlohmann::json::parse(file("s.json"))["flags"]["labels"], "map.nrrd");
}

// Flags that cut the scan by labels are of their file, and go with it.
TEST_F(WindowLabels, InsideOfLabelsIsThatOfTheirFile) {
  make_map();
  const Viewed viewed =
      view({make_scan(), "--labels", folder_ / "map.nrrd", "--label-table", folder_ / "names.txt",
            "--inside-labels", "skin", "--label-opacity", "others=0"},
           std::string(kBegin) +
               "expect scene.labels.1.opacity == 0\nexpect scene.labels.5.opacity == 0\n"
               "picture $/0.png\nclick scene.label.5.show@0.1,0.5\nwait idle\n" +
               kSave + "click scene.labels.remove\nwait idle\nkey ctrl+c\nprint clipboard\n");
  EXPECT_FALSE(file("0.png") == file("window.png"));
  EXPECT_NE(viewed.text("clipboard").find("--inside-labels skin"), std::string::npos);
  EXPECT_EQ(viewed.text("clipboard", 1).find("label"), std::string::npos);
  expect_same(viewed, "window.png", "s.json");
}

TEST_F(WindowLabels, ADroppedMapIsAddedWhereItIsMeantTo) {
  std::string segmentation = read_file(make_map());
  segmentation.insert(segmentation.find("\n\n") + 1,
                      "Segment0_Name:=skin\nSegment0_LabelValue:=1\n");
  write_file(folder_ / "map.seg.nrrd", segmentation);
  const std::string scan = make_scan();
  // With another tab open data are opened, but what says by its name that it is a segmentation.
  view({scan},
       "pace 0\nwait idle\ndrop $/map.seg.nrrd\nwait idle\nexpect scene.labels.count == 9\n"
       "expect array == head\ndrop $/map.nrrd\nwait 20 frames\nwait idle\n"
       "expect array == head-labels\n");
  view({scan}, std::string(kBegin) +
                   "drop $/map.nrrd\nwait idle\nexpect array == head\n"
                   "expect scene.labels.file contains map.nrrd\n"
                   // Labels beside labels are none that can be seen.
                   "click tab.data\ndrop $/map.nrrd\nwait 20 frames\nwait idle\n"
                   "click tab.scene\ndrop $/map.seg.nrrd\nwait 20 frames\n"
                   "wait idle\nexpect scene.labels.file == \"\"\n");
}

TEST_F(WindowLabels, WhatIsNoMapIsSaidAndNothingIsLost) {
  const std::string scan = make_scan();
  make_map();
  write_file(folder_ / "broken.nrrd", "NRRD0004\ntype: uint8\n");
  view({scan}, std::string(kBegin) + add("$/map.nrrd") + add("$/broken.nrrd") +
                   "expect scene.error contains broken.nrrd\nexpect scene.labels.count == 9\n");
  // A label that nobody knows.
  const Viewed viewed =
      replay({folder_ / "map.nrrd", "--label-color", "liver=red"}, "wait idle\nprint error\n");
  EXPECT_NE(viewed.text("error").find("liver"), std::string::npos);
}

// Another array has other labels, and a step in time keeps them.
TEST_F(WindowLabels, ModesWithoutDepthShowNone) {
  make_map();
  const Viewed viewed =
      view({make_scan(), "--labels", folder_ / "map.nrrd"},
           "pace 0\nwait idle\nclick look.mode\nclick look.mode/maximum\nwait idle\n"
           "expect scene.labels.are_shown == false\n" +
               std::string(kSave) +
               "click look.mode\nclick look.mode/composite\nwait idle\n"
               "expect scene.labels.are_shown == true\n");
  expect_same(viewed, "window.png", "s.json");
}

}  // namespace labels_window_test
}  // namespace ovoid::viewer_tests
