// SPDX-License-Identifier: Apache-2.0
// The window's life: begun without a display, closed at any moment, made as small as it gets, used
// for long.
#include <chrono>
#include <cstdlib>
#include <thread>

#include "screen.h"
#include "support/where.h"

namespace ovoid::viewer_tests {
namespace life_window_test {

class WindowLife : public OnScreen {};

TEST_F(WindowLife, ClosesAtAnyMoment) {
  const std::string head = make("head", "head.nrrd", {"--size", "160"});
  // Of each, how far the program is: nothing done yet, reading, drawing the first picture,
  // refining, moving, with a drag begun.
  for (const char* const script :
       {"close\n", "wait 1 frames\nclose\n", "wait 5 frames\nclose\n", "wait 30 ms\nclose\n",
        "wait loaded\nclose\n", "wait loaded\nwait 1 frames\nclose\n", "wait full\nclose\n",
        "wait loaded\ndrag left picture 90,0 10\nclose\n",
        "wait loaded\nmove picture\npress left\nmove 50,50\nclose\n", "key ctrl+q\n",
        "wait loaded\nkey ctrl+w\nwait 1000 frames\n"}) {
    const Viewed viewed = view({head}, script);
    EXPECT_EQ(viewed.outcome.out, "");
  }
}

TEST_F(WindowLife, AnInterruptClosesIt) {
  for (const int after_ms : {0, 40, 150, 500}) {
    Program viewer(words_of({make_head()}, "wait 100000 ms\n"), OVOID_VIEWER_PROGRAM);
    // From the first moment on it is the system's, with the same exit code.
    std::this_thread::sleep_for(std::chrono::milliseconds(after_ms));
    viewer.send(SIGINT);
    const Outcome outcome = viewer.finish(kLimitSeconds);  // before the script ends by itself
    EXPECT_EQ(outcome.exit_code, 130) << after_ms;
    EXPECT_EQ(outcome.out, "");
  }
}

TEST_F(WindowLife, WithoutADisplayOneLineSaysSo) {
  const std::string head = make_head();
  unsetenv("DISPLAY");
  const Outcome outcome = cli_tests::run({head}, OVOID_VIEWER_PROGRAM);
  setenv("DISPLAY", Screen::get().display().c_str(), 1);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.out, "");
  const Words lines = outcome.error_lines();
  ASSERT_EQ(lines.size(), 1U) << outcome.err;
  EXPECT_EQ(lines[0].rfind("ovoid: error: ", 0), 0U) << lines[0];
  EXPECT_NE(lines[0].find("display"), std::string::npos) << lines[0];
  EXPECT_NE(lines[0].find("ovoid render"), std::string::npos) << lines[0];
}

TEST_F(WindowLife, TheProgramStartsIt) {
  const std::string script = folder_ / "script.txt";
  write_file(script, "wait full\nprint is_open\n");
  for (const Words& first : {Words{"view"}, Words{}}) {
    Words words = first;
    words.push_back(make_head());
    words.insert(words.end(), {"--size", "160x120", "--script", script});
    const Outcome outcome = cli_tests::run(words);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "is_open = true\n");
  }
}

TEST_F(WindowLife, BecomesAsSmallAsAPixelAndLargeAgain) {
  view({make_head()},
       "pace 0\nwait full\nprint picture\npicture $/0.png\nresize 1x1\nwait 10 frames\n"
       "drag left 0,0 20,20\nkey r\nwait 5 frames\nkey tab\nwait 5 frames\nresize 1x700\n"
       "wait 5 frames\nresize 700x1\nwait 5 frames\nkey tab\nresize 680x240\nwait 20 frames\n"
       "wait full\nexpect picture.width == 340\nexpect picture.height == 240\nkey r\n"
       "wait full\npicture $/1.png\nresize 900x600\nwait 20 frames\nwait full\n"
       "expect picture.height == 600\n");
  EXPECT_TRUE(file("0.png") == file("1.png"));
}

TEST_F(WindowLife, ScriptsThatFailEndItInOneLine) {
  const std::string head = make_head();
  const std::map<std::string, std::string> faults = {
      {"bad\n", ":1: 'bad' is no command\n"},
      {"wait full\nexpect view.points == 99\n", ":2: view.points is '6', expected == 99\n"},
      {"expect no.such.fact == 1\n", ":1: 'no.such.fact': nothing is known by that name\n"},
      {"wait full\nclick no.such.widget\n", ":2: there is no 'no.such.widget' in the window\n"},
      {"wait 1 frames\npicture $/a.png\n",
       ":2: picture: the full one is not there yet (wait full)\n"}};
  for (const auto& [script, said] : faults) {
    const Viewed viewed = replay({head}, script);
    EXPECT_EQ(viewed.outcome.exit_code, 1);
    EXPECT_EQ(viewed.outcome.err, "ovoid: error: " + (folder_ / "script.txt") + said);
  }
}

// What a person did is a script that does it again.
TEST_F(WindowLife, ARecordingDoesTheSameAgain) {
  const std::string head = make_head();
  view({head, "--record", folder_ / "recorded.txt"},
       "pace 0\nwait full\ndrag left picture 40,10 3\nwait full\nprint camera\n");
  const std::string text = file("recorded.txt");
  EXPECT_EQ(text.rfind("resize ", 0), 0U) << text;
  const Viewed viewed = view({head}, text + "wait full\n");
  EXPECT_EQ(viewed.outcome.out, "");
}

TEST_F(WindowLife, AReportOfTimesIsWritten) {
  view({make_head(), "--report", folder_ / "report.json"},
       "wait idle\nmeasure turning\ndrag left picture 60,10 30\nwait idle\n");
  const auto report = nlohmann::json::parse(file("report.json"), nullptr, false);
  ASSERT_TRUE(report.is_object()) << file("report.json");
  EXPECT_GT(report["first_full_picture_ms"], 0);
  ASSERT_EQ(report["sections"].size(), 2U);
  EXPECT_EQ(report["sections"][1]["name"], "turning");
  EXPECT_GT(report["sections"][1]["pictures"], 0);
}

// Frames at the rate of the machine, and a picture for some of them; the allocator's and the
// driver's own pools are warm after the first few hundred. What is measured stays below 1 MiB; 3
// MiB are 4 KiB for each of eight hundred frames, or each of at least forty pictures of 160 x 120;
// the night has a KiB and one in ten.
void expect_flat_memory(const Viewed& viewed) {
  const double grown = viewed.number("memory_mib", 1) - viewed.number("memory_mib", 0);
  EXPECT_LT(grown, 3) << "MiB, from " << viewed.number("memory_mib", 0);
}

std::string orbit_script(int times) {
  return "pace 0\nwait idle\nrepeat 10\ndrag left picture 60,20 50\nend\nwait idle\n"
         "print memory_mib\nrepeat " +
         std::to_string(times) +
         "\ndrag left picture 60,20 100\nend\nwait idle\nprint memory_mib\n";
}

TEST_F(WindowLife, MemoryStaysFlatOverManyFrames) {
  expect_flat_memory(view({make_head(), "--size", "160x120", "--no-panel"}, orbit_script(8)));
}

// Ten thousand, with the panel: OVOID_TEST_NIGHTLY=1 viewer_tests --gtest_filter=*TenThousand*.
TEST_F(WindowLife, MemoryStaysFlatOverTenThousandFrames) {
  if (!test::is_nightly()) GTEST_SKIP() << "in make nightly alone (OVOID_TEST_NIGHTLY=1)";
  constexpr double kTenMinutes = 600;
  expect_flat_memory(view({make_head(), "--size", "320x240"}, orbit_script(100), kTenMinutes));
}

}  // namespace life_window_test
}  // namespace ovoid::viewer_tests
