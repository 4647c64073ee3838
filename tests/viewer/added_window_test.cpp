// SPDX-License-Identifier: Apache-2.0
// What is added to the scene takes the colours of an array, a range and a radius. Fails if the
// command or the state draws another picture, or if undo leaves what was made otherwise.
#include "screen.h"

namespace ovoid::viewer_tests {
namespace added_window_test {

class WindowAdded : public OnScreen {
 protected:
  // Balls before the head.
  std::string points(const std::string& name, double heat = 1) const {
    std::ofstream out(folder_ / name);
    out << "x,y,z,heat,cold\n";
    for (int i = 0; i < 6; ++i)
      out << -0.5 + 0.2 * i << ",-1," << 0.1 * i << ',' << heat * i << ',' << 5 - i << '\n';
    return folder_ / name;
  }
  std::string triangle(const std::string& name) const {
    std::ofstream(folder_ / name) << "v -0.6 -1 -0.8\nv 0.6 -1 -0.8\nv 0 -1 -0.3\nf 1 2 3\n";
    return folder_ / name;
  }
  static std::string add(const std::string& path) {
    return "click scene.path\nkey ctrl+a\ntype " + path + "\nclick scene.add\nwait idle\n";
  }
  static std::string type(const std::string& name, const std::string& text) {
    return "click " + name + " double\nwait 2 frames\nkey ctrl+a\ntype " + text +
           "\nkey enter\nwait idle\n";
  }
  Words words(const Words& more = {}) {
    Words all = {make_head(), "--view", "front", "--size", "300x500"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  static constexpr const char* kBegin = "pace 0\nwait idle\nclick tab.scene\n";
};

TEST_F(WindowAdded, AnArrayGivesColoursAndUndoTakesThem) {
  points("p.csv");
  const Viewed viewed =
      view(words(),
           kBegin + add("$/p.csv") +
               "expect scene.surface.0.array == \"\"\npicture $/0.png\n"
               "click scene.surface.0.array\nclick scene.surface.0.array/heat\nwait idle\n"
               "expect scene.surface.0.array == heat\nexpect scene.surface.0.range.1 == 5\n"
               "picture $/1.png\nclick scene.surface.0.map\nclick scene.surface.0.map/plasma\n"
               "wait idle\npicture $/2.png\nclick scene.surface.0.range.usual@0.05,0.5\n"
               "wait idle\npicture $/same.png\n" +
               type("scene.surface.0.range.hi", "20") +
               "expect scene.surface.0.range.1 == 20\npicture $/3.png\n" + kSave +
               "move picture@0.1,0.9\nkey ctrl+z\nkey ctrl+z\nkey ctrl+z\nkey ctrl+z\nwait idle\n"
               "expect scene.surface.0.array == \"\"\npicture $/undone.png\nkey ctrl+y\nwait idle\n"
               "expect scene.surface.0.array == heat\npicture $/redone.png\n");
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(file(std::to_string(i) + ".png") == file(std::to_string(i + 1) + ".png")) << i;
  }
  EXPECT_TRUE(file("same.png") == file("2.png"));
  EXPECT_TRUE(file("undone.png") == file("0.png"));
  EXPECT_TRUE(file("redone.png") == file("1.png"));
  EXPECT_NE(viewed.text("clipboard").find("--add-range"), std::string::npos);
  expect_same(viewed, "window.png", "s.json");
}

TEST_F(WindowAdded, BallsHaveARadius) {
  points("p.csv");
  triangle("t.obj");
  const Viewed viewed = view(words(), kBegin + add("$/t.obj") + add("$/p.csv") +
                                          "expect scene.surface.1.radius == 0\npicture $/0.png\n"
                                          "click scene.surface.1.radius.usual@0.05,0.5\nwait idle\n"
                                          "expect scene.surface.1.radius > 0\n" +
                                          type("scene.surface.1.radius", "0.05") +
                                          "expect scene.surface.1.radius == 0.05\npicture $/1.png\n"
                                          "drag left scene.surface.1.radius 40,0\nwait idle\n"
                                          "expect scene.surface.1.radius > 0.05\n" +
                                          kSave +
                                          "click scene.surface.1.radius.usual@0.05,0.5\nwait idle\n"
                                          "picture $/back.png\n");
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_FALSE(file("1.png") == file("window.png"));
  EXPECT_TRUE(file("back.png") == file("0.png"));
  expect_same(viewed, "window.png", "s.json");
}

// Of several each has its own, and the last one's is not that of those behind it.
TEST_F(WindowAdded, SeveralAreAsFlagsHaveThem) {
  points("p.csv");
  points("q.csv", -2);
  triangle("t.obj");
  const Viewed viewed =
      view(words({"--add",          folder_ / "p.csv",
                  "--add",          folder_ / "t.obj",
                  "--add",          folder_ / "q.csv",
                  "--add-array",    "heat",
                  "--add-array",    "",
                  "--add-array",    "cold",
                  "--add-colormap", "plasma",
                  "--add-range",    "1,3",
                  "--add-radius",   "0.08",
                  "--add-radius",   "0"}),
           std::string(kBegin) +
               "expect scene.surface.0.array == heat\nexpect scene.surface.0.radius == 0.08\n"
               "expect scene.surface.1.array == \"\"\nexpect scene.surface.2.array == cold\n"
               "expect scene.surface.2.map == plasma\nexpect scene.surface.2.range.1 == 3\n"
               "expect scene.surface.2.radius == 0\npicture $/opened.png\n"
               "click scene.surface.0.range.usual@0.05,0.5\nclick scene.surface.1.show@0.02,0.5\n"
               "wait idle\nexpect scene.surface.0.has_range == false\n" +
               kSave);
  EXPECT_FALSE(file("opened.png") == file("window.png"));
  expect_same(viewed, "window.png", "s.json");
  view({"--state", folder_ / "s.json", "--size", "300x500"},
       std::string(kBegin) +
           "expect scene.surfaces == 3\n"
           "expect scene.surface.1.is_hidden == true\n"
           "expect scene.surface.2.array == cold\npicture $/again.png\n");
  EXPECT_TRUE(file("again.png") == file("window.png"));
}

// What the file does not have any more is said, and what is shown stays.
TEST_F(WindowAdded, AnArrayThatIsGoneIsGivenUp) {
  const std::string path = points("p.csv");
  write_file(folder_ / "less.csv", "x,y,z,heat\n0,-1,0,1\n0.3,-1,0,2\n");
  const std::string copy = "cp '" + (folder_ / "less.csv") + "' '" + path + "'";
  Words all = words_of(words({"--add", path}),
                       "pace 0\nwait idle\nclick tab.scene\npicture " + (folder_ / "0.png") +
                           "\nwait 2500 ms\nclick scene.surface.0.array\n"
                           "click scene.surface.0.array/cold\nwait idle\n"
                           "expect scene.error contains cold\n"
                           "expect scene.surface.0.array == \"\"\nexpect scene.surfaces == 1\n");
  Program viewer(all, OVOID_VIEWER_PROGRAM);
  for (int i = 0; i < 6000 && !std::filesystem::exists(folder_ / "0.png"); ++i) usleep(5000);
  EXPECT_EQ(std::system(copy.c_str()), 0);
  const Outcome outcome = viewer.finish(kLimitSeconds);
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
}

TEST_F(WindowAdded, ArraysThatAreNotThereAreSaid) {
  const Viewed viewed = view(words({"--add", points("p.csv"), "--add-array", "speed"}),
                             "pace 0\nwait loaded\nprint error\n");
  EXPECT_NE(viewed.text("error").find("speed"), std::string::npos);
}

}  // namespace added_window_test
}  // namespace ovoid::viewer_tests
