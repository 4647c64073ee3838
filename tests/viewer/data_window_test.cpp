// SPDX-License-Identifier: Apache-2.0
// Which data are shown, and when: arrays, steps in time, what is dropped and what changes on disk;
// comparisons and the back ends.
#include <thread>

#include "screen.h"
#include "support/where.h"

namespace ovoid::viewer_tests {
namespace data_window_test {

class WindowData : public OnScreen {
 protected:
  Words make_steps() {
    const std::string whole = make("tornado", "all.h5", {"--size", "24", "--steps", "4"});
    Words steps;
    for (int i = 0; i < 4; ++i) {
      steps.push_back(folder_ / "step_" + std::to_string(i) + ".nrrd");
      cli_tests::expect_success(
          {"convert", whole, "--step", std::to_string(i), "-o", steps.back()});
    }
    return steps;
  }
};

TEST_F(WindowData, ArraysOfAMesh) {
  view({make("fin", "fin.vtu", {"--count", "2000"})},
       "pace 0\nwait idle\nexpect array == density\nexpect color_array == density\n"
       "picture $/0.png\nclick tab.data\nclick data.color.pressure\nwait idle\n"
       "expect array == density\nexpect color_array == pressure\npicture $/1.png\n"
       "click data.array.pressure\nwait idle\nexpect array == pressure\n"
       "expect color_array == pressure\npicture $/2.png\n"
       "click data.array.density\nwait idle\nexpect color_array == density\npicture $/3.png\n");
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_FALSE(file("1.png") == file("2.png"));
  EXPECT_FALSE(file("0.png") == file("2.png"));
  EXPECT_TRUE(file("0.png") == file("3.png"));
}

TEST_F(WindowData, StepsByKeysButtonsAndSlider) {
  const Viewed viewed =
      view(make_steps(),
           "pace 0\nwait idle\nexpect time.steps == 4\nexpect time.now == 0\n"
           "picture $/0.png\nkey right\nwait idle\nexpect time.now == 1\n"
           "picture $/1.png\nkey left\nwait idle\nexpect time.now == 0\n"
           "picture $/2.png\nkey left\nwait idle\nexpect time.now == 3\n"  // loops
           "click tab.time\nclick time.loop@0.05,0.5\nkey right\nwait idle\n"
           "expect time.now == 3\nclick time.first\nwait idle\nexpect time.now == 0\n"
           "click time.last\nwait idle\nexpect time.now == 3\nclick time.back\n"
           "wait idle\nexpect time.now == 2\nclick transport.time@0.02,0.5\n"
           "wait idle\nexpect time.now == 0\nclick time.interpolate@0.05,0.5\n"
           "click transport.time@0.5,0.5\nwait idle\nprint time.now\n"
           "picture $/3.png\n");
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_TRUE(file("0.png") == file("2.png"));
  EXPECT_FALSE(file("3.png") == file("2.png"));
  // Between steps.
  const double time = viewed.number("time.now");
  EXPECT_GT(time, 1);
  EXPECT_LT(time, 2);
}

TEST_F(WindowData, PlayAndPause) {
  std::string looks;
  for (const int ms : {300, 50, 70, 110, 130, 90, 40}) {
    looks += "wait " + std::to_string(ms) + " ms\nprint time.now\n";
  }
  const Viewed viewed = view(make_steps(),
                             "wait idle\nclick tab.time\nclick time.fastest@0.05,0.5\nkey space\n"
                             "expect time.is_playing == true\n" +
                                 looks +
                                 "key space\nexpect time.is_playing == false\nwait idle\n"
                                 "print time.now\nwait 300 ms\nprint time.now\n"
                                 "click time.loop@0.05,0.5\nclick transport.play\nwait idle\n"
                                 "expect time.is_playing == false\nexpect time.now == 3\n");
  bool has_moved = false;
  for (std::size_t i = 1; i < 7; ++i)
    has_moved |= viewed.number("time.now", i) != viewed.number("time.now", i - 1);
  EXPECT_TRUE(has_moved);
  EXPECT_EQ(viewed.number("time.now", 7), viewed.number("time.now", 8));
}

// By the clock: a unit of time per second, and only whole steps. A slow machine leaves some out.
TEST_F(WindowData, PlaysByTheClock) {
  const Viewed viewed = view(make_steps(),
                             "wait idle\nkey space\nwait 1300 ms\nprint time.now\n"
                             "key space\nwait idle\n");
  const double time = viewed.number("time.now");
  EXPECT_TRUE(time == 1 || time == 2 || time == 3) << time;
}

TEST_F(WindowData, CompareSideBySideAndAsADifference) {
  const Viewed viewed =
      view({make_head()},
           "pace 0\nwait idle\nclick tab.compare\nclick compare.keep\n"
           "click compare.mode\nclick \"compare.mode/A and B side by side\"\nwait idle\n"
           "expect compare.mode == 2\nexpect compare.psnr == 1e9\nscreenshot $/0.png\n"
           "wait 2 frames\nclick tab.look\ndrag left look.opacity.1 0,-40\nwait idle\n"
           "print compare.psnr\nscreenshot $/1.png\nwait 2 frames\nclick tab.compare\n"
           "click compare.mode\nclick compare.mode/difference\nwait idle\n"
           "expect compare.mode == 3\nprint compare.psnr\nprint view.opacities\n"
           "screenshot $/2.png\nwait 2 frames\nclick compare.swap\nwait idle\n"
           "print compare.psnr\nprint view.opacities\nclick compare.mode\n"
           "click \"compare.mode/B alone\"\nwait idle\npicture $/3.png\n");
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GT(viewed.number("compare.psnr", i), 5);
    EXPECT_LT(viewed.number("compare.psnr", i), 80);
  }
  // The distance is the same from both sides.
  EXPECT_NEAR(viewed.number("compare.psnr", 1), viewed.number("compare.psnr", 2), 1e-9);
  EXPECT_NE(viewed.json("view.opacities", 0), viewed.json("view.opacities", 1));
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_FALSE(file("1.png") == file("2.png"));
  EXPECT_GT(file("3.png").size(), 500U);
}

// A and B lie in the same place, so the line uncovers one of them and moves neither; the camera
// stays, and so does what the other places show.
TEST_F(WindowData, TheLineBetweenTwoPicturesIsDragged) {
  const Viewed viewed =
      view({make_head()},
           "pace 0\nwait idle\nclick tab.compare\nclick compare.keep\nwait idle\n"
           "expect compare.mode == 1\nexpect compare.divider == 0.5\nprint camera\n"
           "click tab.look\nclick look.map\nclick look.map/viridis\nwait idle\n"
           "print version\ndrag left compare.divider 60,5\nprint compare.divider\n"
           "print version\nprint camera\n"
           "drag left compare.divider 4000,0\nprint compare.divider\n");
  EXPECT_GT(viewed.number("compare.divider"), 0.6);
  EXPECT_LT(viewed.number("compare.divider", 1), 1);
  EXPECT_EQ(viewed.json("camera", 0), viewed.json("camera", 1));
  EXPECT_EQ(viewed.number("version", 0), viewed.number("version", 1));
}

TEST_F(WindowData, BackEndsAgreeAndTheSamplingDistanceChangesThePicture) {
  const Viewed viewed = view(
      {make("head", "small.nrrd", {"--size", "24"}), "--size", "340x160"},
      "pace 0\nwait idle\nexpect backend == cpu\npicture $/0.png\nclick tab.quality\n"
      "click quality.backend\nclick quality.backend/reference\nwait idle\n"
      "expect backend == reference\nclick quality.backend\nclick quality.backend/cpu\nwait idle\n"
      "expect backend == cpu\npicture $/1.png\ndrag left quality.sampling-distance 60,0\n"
      "wait idle\npicture $/2.png\n");
  EXPECT_TRUE(file("0.png") == file("1.png"));
  EXPECT_FALSE(file("1.png") == file("2.png"));
}

TEST_F(WindowData, QualityIsAWordOrANumber) {
  const Viewed viewed =
      view({make("head", "small.nrrd", {"--size", "24"}), "--size", "340x160"},
           "pace 0\nwait idle\nexpect quality == normal\npicture $/0.png\nclick tab.quality\n"
           "click quality\nclick quality/finest\nwait idle\nexpect quality == finest\n"
           "picture $/1.png\nclick quality\nclick quality/normal\nwait idle\npicture $/2.png\n"
           "click quality\nclick quality/fast\nwait idle\npicture $/3.png\n"
           "wait 500 ms\n"  // a click on that place so soon would be the second of two
           "drag left quality.sampling-distance 60,0\nwait idle\n"
           "expect quality == \"by number\"\nkey ctrl+z\nwait idle\nexpect quality == fast\n"
           "key ctrl+c\nprint clipboard\nprint view.sampling_distance\n");
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_FALSE(file("0.png") == file("3.png"));
  EXPECT_TRUE(file("0.png") == file("2.png"));
  // A command of such a picture begins with that quality, whatever the number looks like.
  EXPECT_NE(
      viewed.text("clipboard").find("--sampling-distance " + viewed.text("view.sampling_distance")),
      std::string::npos)
      << viewed.text("clipboard");
  view({folder_ / "small.nrrd", "--sampling-distance", viewed.text("view.sampling_distance")},
       "wait loaded\nexpect quality == fast\n");
}

// The file is written again while the window watches it.
TEST_F(WindowData, WatchedFilesAreReadAgain) {
  const std::string ball = cli_tests::write_ball(folder_);
  write_file(folder_ / "script.txt",
             "wait idle\ndrag left picture 30,10\nwait idle\nprint camera\nprint view.opacities\n"
             "picture " +
                 (folder_ / "0.png") +
                 "\nprint version\n"
                 "wait 3000 ms\nwait idle\nprint camera\nprint view.opacities\n"
                 "picture " +
                 (folder_ / "1.png") + "\nprint message\nprint version\n");
  Program viewer({ball, "--watch", "--no-panel", "--size", "160x120", "--backend", "cpu",
                  "--script", folder_ / "script.txt"},
                 OVOID_VIEWER_PROGRAM);
  for (int i = 0; i < 3000 && !std::filesystem::exists(folder_ / "0.png"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  std::string bytes = cli_tests::ball_bytes();
  for (std::size_t i = 0; i < bytes.size(); i += 2) bytes[i] = static_cast<char>(bytes[i] / 2);
  write_file(ball, bytes);
  Viewed viewed;
  viewed.take(viewer.finish(kLimitSeconds));
  EXPECT_EQ(viewed.outcome.exit_code, 0);
  EXPECT_EQ(viewed.outcome.err, "");
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_GT(viewed.number("version", 1), viewed.number("version", 0));
  // What was set stays.
  EXPECT_EQ(viewed.text("camera", 0), viewed.text("camera", 1));
  EXPECT_EQ(viewed.text("view.opacities", 0), viewed.text("view.opacities", 1));
}

class WindowDrops : public OnScreen {};

TEST_F(WindowDrops, ALook) {
  const std::string head = make_head();
  write_file(folder_ / "look.json",
             R"([{"Name": "mine", "ColorSpace": "RGB", "RGBPoints": [0, 1, 0, 0, 1000, 0, 0, 1],)"
             R"( "Points": [0, 0, 0.5, 0, 500, 0.25, 0.5, 0, 1000, 0.5, 0.5, 0]}])");
  const Viewed viewed = view({head},
                             "pace 0\nwait idle\npicture $/0.png\ndrop $/look.json\n"
                             "wait full\nprint view.opacities\nexpect view.colors == 2\n"
                             "picture $/1.png\nkey ctrl+z\nwait full\npicture $/2.png\n");
  const auto points = viewed.json("view.opacities");
  ASSERT_EQ(points.size(), 3U);
  EXPECT_EQ(points[1]["x"], 500);
  EXPECT_EQ(points[1]["opacity"], 0.25);
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_TRUE(file("0.png") == file("2.png"));
}

TEST_F(WindowDrops, AState) {
  const Viewed viewed =
      view({make_head(), "--no-panel"},
           "pace 0\nwait idle\ndrag left picture 50,20\nkey p\nwait full\npicture $/0.png\n"
           "print camera\nstate $/s.json\nkey r\nkey p\nwait full\npicture $/1.png\ndrop $/s.json\n"
           "wait 20 frames\nwait idle\nprint camera\npicture $/2.png\n");
  for (const char* const member : {"position", "focal_point"})
    EXPECT_EQ(viewed.json("camera", 0)[member], viewed.json("camera", 1)[member]);
  EXPECT_EQ(viewed.json("camera", 1)["parallel"], true);
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_TRUE(file("0.png") == file("2.png"));
}

TEST_F(WindowDrops, OtherData) {
  const Words steps = {make("tornado", "t.h5", {"--size", "24", "--steps", "3"})};
  make("fin", "fin.vtu", {"--count", "2000"});
  view({make_head()},
       "pace 0\nwait idle\nexpect kernels == 110592\ndrop $/t.h5\n"
       "wait 20 frames\nwait idle\nexpect kernels == 13824\nexpect time.steps == 3\n"
       "drop $/fin.vtu\nwait 20 frames\nwait idle\nexpect array == density\n"
       "expect time.steps <= 1\nexpect can_undo == false\npicture $/0.png\n");
  EXPECT_GT(file("0.png").size(), 500U);
}

// A message, and the old picture stays and can be turned.
TEST_F(WindowDrops, WhatIsNoDataLeavesWhatIsThere) {
  write_file(folder_ / "noise.nrrd", "these are no samples");
  write_file(folder_ / "noise.json", "{\"a\": 3}");
  write_file(folder_ / "damaged.json", "{\"ovoid_state\": 1, \"inputs\": [");
  write_file(folder_ / "newer.json", "{\"ovoid_state\": 99, \"program\": \"9.9.9\"}");
  std::filesystem::create_directory(folder_ / "empty");
  std::string script = "pace 0\nwait idle\npicture $/0.png\n";
  const Words names = {"noise.nrrd",   "noise.json", "damaged.json", "newer.json",
                       "missing.nrrd", "empty",      "odd name.nrrd"};
  for (const std::string& name : names) {
    script += "drop \"$/" + name +
              "\"\nwait 20 frames\nwait idle\nprint message\n"
              "expect kernels == 110592\nexpect is_open == true\n";
  }
  script += "picture $/1.png\ndrag left picture 30,0\nwait full\npicture $/2.png\n";
  const Viewed viewed = view({make_head()}, script);
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_NE(viewed.text("message", i).find(names[i]), std::string::npos)
        << names[i] << ": " << viewed.text("message", i);
    if (i > 0) {
      EXPECT_NE(viewed.text("message", i), viewed.text("message", i - 1));
    }
  }
  EXPECT_NE(viewed.text("message", 3).find("99"), std::string::npos);
  EXPECT_TRUE(file("0.png") == file("1.png"));
  EXPECT_FALSE(file("1.png") == file("2.png"));
}

// A file of the command line that cannot be read: the window stays and says why, and takes another.
TEST_F(WindowDrops, AfterAFileThatFailsAnotherOneIsTaken) {
  make_head();
  const std::string missing = folder_ / "missing.nrrd";
  for (const bool exists : {false, true}) {
    if (exists) write_file(missing, "NRRD0004\ntype: float\n");
    const Viewed viewed =
        view({missing},
             "pace 0\nwait loaded\nwait full\nexpect is_open == false\nprint error\n"
             "key r\nkey ctrl+c\nkey ctrl+s\nkey s\nkey space\nkey ctrl+z\n"
             "drag left 100,100 30,30\nwheel 2 100,100\nscreenshot $/0.png\n"
             "wait 2 frames\ndrop $/head.nrrd\nwait 20 frames\nwait idle\n"
             "expect is_open == true\nexpect error == \"\"\npicture $/1.png\n");
    EXPECT_NE(viewed.text("error").find(missing), std::string::npos) << viewed.text("error");
    EXPECT_GT(file("1.png").size(), 500U);
  }
}

// The same by the panel, whose other tabs have nothing to show.
TEST_F(WindowDrops, AnEmptyWindowOpensAFileByItsPanel) {
  make_head();
  view({},
       "pace 0\nwait 5 frames\nexpect is_open == false\nclick tab.look\nclick tab.space\n"
       "click tab.time\nclick tab.compare\nclick tab.quality\nclick tab.data\n"
       "click data.open.path\nwait 2 frames\ntype $/head.nrrd\nkey enter\nwait 20 frames\n"
       "wait loaded\nwait idle\nexpect kernels == 110592\n");
}

class WindowFiles : public OnScreen {};

TEST_F(WindowFiles, LooksAndStatesAreWrittenAndReadByThePanel) {
  const std::string head = make_head();
  view({head},
       "pace 0\nwait idle\ndrag left look.opacity.1 0,-40\nwait full\npicture $/0.png\n"
       "click look.path\nwait 2 frames\nkey ctrl+a\ntype $/look.json\nkey enter\n"
       "wait 2 frames\nclick look.write\nwait 2 frames\nexpect message contains look.json\n"
       "click look.undo\nwait full\npicture $/1.png\nclick look.read\nwait full\n"
       "picture $/2.png\nclick tab.data\nclick data.state.path\nwait 2 frames\nkey ctrl+a\n"
       "type $/state.json\nkey enter\nwait 2 frames\nclick data.state.save\n"
       "wait 2 frames\nexpect message contains state.json\nkey ctrl+z\nwait full\n"
       "click data.state.restore\nwait 20 frames\nwait idle\npicture $/3.png\n");
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_TRUE(file("0.png") == file("2.png"));
  EXPECT_TRUE(file("0.png") == file("3.png"));
}

TEST_F(WindowFiles, WhatCannotBeWrittenIsSaid) {
  make_head();
  view({folder_ / "head.nrrd"},
       "pace 0\nwait idle\nclick tab.data\nclick data.state.path\nwait 2 frames\nkey ctrl+a\n"
       "type $/nowhere/state.json\nkey enter\nwait 2 frames\nclick data.state.save\n"
       "wait 2 frames\nexpect message contains nowhere\nexpect is_open == true\nwait full\n");
}

// On the command line: one clear line, and no window.
TEST_F(WindowFiles, DamagedAndNewerStatesAreRefusedInOneLine) {
  OVOID_NOT_UNDER_TSAN();
  const std::map<std::string, std::string> states = {
      {"{\"ovoid_state\": 99, \"program\": \"9.9.9\"}", "99"},
      {"{\"ovoid_state\": 1, \"inputs\": [", "not JSON"},
      {"{\"ovoid_state\": 1, \"inputs\": [\"a.nrrd\"], \"flags\": {\"siz\": \"3x4\"}}", "siz"},
      {"{}", "is no state"},
      {"", "not JSON"}};
  for (const auto& [text, fragment] : states) {
    write_file(folder_ / "s.json", text);
    const Outcome outcome = cli_tests::run({"--state", folder_ / "s.json"}, OVOID_VIEWER_PROGRAM);
    EXPECT_NE(outcome.exit_code, 0) << text;
    const Words lines = outcome.error_lines();
    ASSERT_EQ(lines.size(), 1U) << outcome.err;
    EXPECT_EQ(lines[0].rfind("ovoid: error: ", 0), 0U) << lines[0];
    EXPECT_NE(lines[0].find(folder_ / "s.json"), std::string::npos) << lines[0];
    EXPECT_NE(lines[0].find(fragment), std::string::npos) << lines[0];
  }
}

}  // namespace data_window_test
}  // namespace ovoid::viewer_tests
