// SPDX-License-Identifier: Apache-2.0
// Looks by value and gradient, painted in the tab "look".
#include "screen.h"

namespace ovoid::viewer_tests {
namespace regions_window_test {

class WindowRegions : public OnScreen {
 protected:
  static constexpr const char* kBegin = "pace 0\nwait idle\n";
  static constexpr const char* kTwo =
      R"({"Regions": [{"Values": [-800, -200], "Gradients": [500, 6000], "Opacity": 0.3},
          {"Values": [100, 900], "Gradients": [1000, 9000], "Color": [1, 0.5, 0], "Opacity": 0.9}]})";

  // High enough for the canvas and the numbers below it.
  Words words(const Words& more = {}) {
    Words all = {make_head(), "--size", "300x600"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Words with_two() { return words({"--tf2d", kTwo}); }
};

// Fails if the first region shows nothing, lies where nothing was counted, or is not one edit.
TEST_F(WindowRegions, AButtonMakesTheFirstAndAnotherLeaves) {
  const Viewed viewed =
      view(words(), std::string(kBegin) +
                        "expect view.is_2d == false\npicture $/0.png\nclick look.enter-2d\n"
                        "wait idle\nexpect view.is_2d == true\nexpect view.regions == 1\n"
                        "expect selected_region == 0\nexpect has_counted_2d == true\n"
                        "print view.region\npicture $/1.png\nkey ctrl+z\nwait idle\n"
                        "expect view.is_2d == false\nexpect can_undo == false\npicture $/2.png\n"
                        "key ctrl+y\nwait idle\nexpect view.regions == 1\n"
                        "drag left look.regions.top 0,30\nwait idle\nprint view.region\n"
                        "picture $/3.png\nclick look.leave-2d\nwait idle\n"
                        "expect view.is_2d == false\npicture $/4.png\nclick look.enter-2d\n"
                        "wait idle\nprint view.region\npicture $/5.png\n");
  const auto first = viewed.json("view.region")[0];
  EXPECT_LT(first["values"][0], first["values"][1]);
  EXPECT_GT(first["gradients"][0], 0);
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_TRUE(file("0.png") == file("2.png"));
  EXPECT_FALSE(file("1.png") == file("3.png"));
  EXPECT_TRUE(file("4.png") == file("0.png"));
  EXPECT_TRUE(file("5.png") == file("3.png"));  // what was painted comes back
  EXPECT_EQ(viewed.json("view.region", 2), viewed.json("view.region", 1));
}

TEST_F(WindowRegions, HandsSelectMoveAndResize) {
  const Viewed viewed =
      view(with_two(),
           std::string(kBegin) +
               "expect selected_region == -1\nprint view.region\nclick look.regions.1\n"
               "expect selected_region == 1\nexpect can_undo == false\n"
               "drag left look.regions.1 -20,-12\nprint view.region\nexpect can_undo == true\n"
               "drag left look.regions.top-right 15,25\nprint view.region\n"
               "drag left look.regions.right-foot -30,0\nprint view.region\n"
               "drag left look.regions.bottom 0,900\nprint view.region\n"
               "key ctrl+z\nkey ctrl+z\nkey ctrl+z\nkey ctrl+z\nwait idle\nprint view.region\n"
               "expect can_undo == false\n");
  const auto region = [&](std::size_t time) { return viewed.json("view.region", time)[1]; };
  const auto number = [&](std::size_t time, const char* key, int end) {
    return region(time)[key][end].get<double>();
  };
  EXPECT_LT(number(1, "values", 0), number(0, "values", 0));
  EXPECT_GT(number(1, "gradients", 0), number(0, "gradients", 0));  // upwards
  EXPECT_NEAR(number(1, "values", 1) - number(1, "values", 0), 800, 5);
  EXPECT_GT(number(2, "values", 1), number(1, "values", 1));
  EXPECT_LT(number(2, "gradients", 1), number(1, "gradients", 1));
  EXPECT_EQ(number(2, "values", 0), number(1, "values", 0));
  EXPECT_LT(region(3)["foot"], 0.9);
  EXPECT_EQ(region(3)["values"], region(2)["values"]);
  EXPECT_EQ(number(4, "gradients", 0), 0);  // not below the ground
  EXPECT_EQ(region(5), region(0));
  EXPECT_EQ(viewed.json("view.region", 4)[0], viewed.json("view.region", 0)[0]);
}

TEST_F(WindowRegions, RegionsAreAddedRemovedAndReordered) {
  const Viewed viewed =
      view(with_two(),
           std::string(kBegin) +
               "click look.regions@0.9,0.1 double\nwait idle\nexpect view.regions == 3\n"
               "expect selected_region == 2\nprint view.region\nkey delete\nwait 3 frames\n"
               "expect view.regions == 2\nexpect selected_region == -1\n"
               // By a drag, from corner to corner.
               "drag left look.regions@0.85,0.05 30,40\nwait idle\nexpect view.regions == 3\n"
               "print view.region\nclick look.region.lower\nexpect selected_region == 1\n"
               "print view.region\nclick look.region.raise\nprint view.region\n"
               "click look.region.add\nwait 3 frames\nexpect view.regions == 4\n"
               "click look.region.remove\nwait 3 frames\nexpect view.regions == 3\n"
               "click look.regions.2 right\nwait 3 frames\nexpect view.regions == 2\n"
               "click look.regions.1 right\nwait 3 frames\nexpect view.regions == 1\n"
               // Nothing is left of a function without regions.
               "click look.regions.0 right\nwait 3 frames\nexpect view.regions == 1\n"
               "click look.regions.0\nkey delete\nwait idle\nexpect view.regions == 1\n");
  const auto regions = [&](std::size_t time) { return viewed.json("view.region", time); };
  EXPECT_GT(regions(0)[2]["values"][0], 900);  // where the mouse was
  EXPECT_NE(regions(0)[2]["rgb"], regions(0)[1]["rgb"]);
  EXPECT_GT(regions(1)[2]["values"][1], regions(1)[2]["values"][0]);
  EXPECT_EQ(regions(2)[1], regions(1)[2]);
  EXPECT_EQ(regions(2)[2], regions(1)[1]);
  EXPECT_EQ(regions(3), regions(1));
}

TEST_F(WindowRegions, NumbersShapeAndColourAreEdited) {
  const std::string type = "wait 2 frames\nkey ctrl+a\ntype ";
  const Viewed viewed = view(
      with_two(),
      std::string(kBegin) + "click look.regions.1\npicture $/0.png\n" +
          "click look.region.values.hi double\n" + type + "1234.5\nkey enter\nwait 3 frames\n" +
          "expect view.region.1.values.1 == 1234.5\n" +
          // What is no range stays as it was.
          "click look.region.values.lo double\n" + type + "2000\nkey enter\nwait 3 frames\n" +
          "expect view.region.1.values.0 == 100\n" + "click look.region.gradients.lo double\n" +
          type + "-5\nkey enter\nwait 3 frames\n" + "expect view.region.1.gradients.0 == 0\n" +
          "click look.region.opacity@0.25,0.5\nclick look.region.softness@0.999,0.5\n"
          "click look.region.foot@0.001,0.5\nwait idle\nprint view.region\npicture $/1.png\n"
          "click look.region.shape\nclick look.region.shape/gaussian\nwait idle\n"
          "expect view.region.1.shape == gaussian\npicture $/2.png\n"
          "click look.region\nclick \"look.region/1: -800 to -200\"\nwait 3 frames\n"
          "expect selected_region == 0\n"
          "drag left look.region.rgb@0.05,0.5 -60,0\nwait idle\nprint view.region\n"
          "picture $/3.png\n");
  const auto region = viewed.json("view.region")[1];
  EXPECT_NEAR(region["opacity"].get<double>(), 0.25, 0.1);
  EXPECT_GT(region["softness"], 0.9);
  EXPECT_LT(region["foot"], 0.1);
  EXPECT_LT(viewed.json("view.region", 1)[0]["rgb"][0], 0.95);
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(file(std::to_string(i) + ".png") == file(std::to_string(i + 1) + ".png")) << i;
  }
}

TEST_F(WindowRegions, CommandStateAndLookDrawTheSame) {
  const Viewed viewed = view(
      words(), std::string(kBegin) +
                   "click look.enter-2d\nwait idle\ndrag left look.regions.left 12,0\n"
                   "drag left look.regions.left-foot 20,0\nclick look.regions@0.2,0.2 double\n"
                   "wait idle\n" +
                   kSave +
                   "click look.path\nwait 2 frames\nkey ctrl+a\ntype $/look.json\nkey enter\n"
                   "wait 2 frames\nclick look.write\nwait 2 frames\n"
                   "expect message contains look.json\nclick look.leave-2d\nwait idle\n"
                   "picture $/curves.png\nclick look.read\nwait idle\nexpect view.regions == 2\n"
                   "picture $/read.png\n");
  expect_same(viewed, "window.png", "s.json");
  EXPECT_TRUE(file("read.png") == file("window.png"));
  EXPECT_FALSE(file("curves.png") == file("window.png"));
  const Viewed again = view({"--state", folder_ / "s.json", "--size", "300x600"},
                            "pace 0\nwait idle\nprint view.region\npicture $/again.png\n");
  EXPECT_EQ(again.json("view.region").size(), 2U);
  EXPECT_TRUE(file("again.png") == file("window.png"));
}

// Other modes know no gradients.
TEST_F(WindowRegions, OtherModesDrawTheCurvesAndGiveItBack) {
  const Viewed viewed =
      view(with_two(),
           std::string(kBegin) +
               "picture $/0.png\nclick look.mode\nclick look.mode/maximum\nwait idle\n"
               "expect view.is_2d == false\npicture $/max.png\nkey ctrl+c\nprint clipboard\n"
               "click look.mode\nclick look.mode/composite\nwait idle\nexpect view.regions == 2\n"
               "picture $/1.png\nclick look.mode\nclick look.mode/maximum\nwait 3 frames\n"
               "key ctrl+z\nwait idle\nexpect view.regions == 2\nexpect view.mode == composite\n"
               "picture $/2.png\n");
  EXPECT_FALSE(file("max.png").empty());
  EXPECT_TRUE(file("0.png") == file("1.png"));
  EXPECT_TRUE(file("0.png") == file("2.png"));
}

TEST_F(WindowRegions, TablesAreShownAndLeft) {
  const std::string table =
      R"({"Values": [-1000, 1000], "Gradients": [0, 20000], "Size": [2, 2],
          "RGBA": [1,0,0,0, 1,1,1,0.8, 1,0.5,0,0, 0,1,0,0.9]})";
  const Viewed viewed =
      view(words({"--tf2d", table}), std::string(kBegin) +
                                         "expect view.is_2d == true\nexpect view.regions == 0\n"
                                         "screenshot $/table.png\nwait 2 frames\nprint version\n"
                                         "click look.regions double\ndrag left look.regions 20,20\n"
                                         "key delete\nwait 3 frames\nprint version\n"
                                         "expect can_undo == false\n" +
                                         kSave +
                                         "click look.leave-2d\nwait idle\n"
                                         "expect view.is_2d == false\n");
  EXPECT_FALSE(file("table.png").empty());
  EXPECT_EQ(viewed.text("version", 0), viewed.text("version", 1));
  expect_same(viewed, "window.png", "s.json");
}

// Fails, too, if what is painted changes what it is compared with.
TEST_F(WindowRegions, AreComparedWithCurves) {
  view(words(), std::string(kBegin) +
                    "picture $/0.png\nclick tab.compare\nclick compare.keep\nclick tab.look\n"
                    "click look.enter-2d\nwait idle\nexpect compare.psnr < 80\n"
                    "drag left look.regions.bottom 0,20\nwait idle\nexpect compare.psnr < 80\n"
                    "click tab.compare\nclick compare.swap\nwait idle\n"
                    "expect view.is_2d == false\nclick compare.drop\nwait idle\n"
                    "picture $/1.png\n");
  EXPECT_TRUE(file("0.png") == file("1.png"));
}

// Fails if a picture that cannot be is waited for, as a trail of such a look.
TEST_F(WindowRegions, BesideATrailTheyAreNotDrawnAndSayWhy) {
  const std::string path = make("tornado", "tornado.h5", {"--size", "16", "--steps", "3"});
  view({path, "--size", "300x600", "--tf2d", kTwo},
       std::string(kBegin) +
           "picture $/0.png\nclick tab.time\nclick time.blur@0.05,0.5\nwait idle\n"
           "expect message contains \"2-D transfer function\"\nclick time.blur@0.05,0.5\n"
           "wait idle\npicture $/1.png\nclick tab.look\nclick look.leave-2d\nwait idle\n"
           "expect view.is_2d == false\n");
  EXPECT_TRUE(file("0.png") == file("1.png"));
}

// Where the colour comes from another array there is no such look, and the button says why.
TEST_F(WindowRegions, AreNotForTwoArrays) {
  const std::string path = make("fin", "fin.vtu");
  view({path, "--size", "300x600", "--array", "density", "--color-array", "pressure"},
       std::string(kBegin) +
           "click look.enter-2d\nwait idle\nexpect view.is_2d == false\n"
           "expect can_undo == false\nclick tab.data\nclick data.color.density\nwait idle\n"
           "click tab.look\nclick look.enter-2d\nwait idle\nexpect view.regions == 1\n");
}

}  // namespace regions_window_test
}  // namespace ovoid::viewer_tests
