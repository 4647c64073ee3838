// SPDX-License-Identifier: Apache-2.0
// Scripts as files: what is refused, with which words, and what a recorder writes.
#include "script.h"

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <deque>
#include <map>

#include "cli/program.h"
#include "ovoid/error.h"

namespace ovoid::viewer {
namespace script_test {

using cli_tests::Folder;

std::string complaint_of_script(const std::string& path) {
  try {
    const Script script(path);
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

TEST(Scripts, EachBadLineIsNamedWithItsFileAndNumber) {
  const std::string wait = "expected: wait loaded|full|idle, wait N frames|ms";
  const std::map<std::string, std::string> faults = {
      {"jump 3", "'jump' is no command"},
      {"jump\x01", "'jump?' is no command"},
      {"wait", wait},
      {"wait long", wait},
      {"wait 3", wait},
      {"wait 3 frames more", wait},
      {"wait x frames", "expected: wait N frames|ms"},
      {"wait -1 frames", "expected: wait N frames|ms"},
      {"wait 1e300 ms", "expected: wait N frames|ms"},
      {"wait 3 seconds", "expected: wait N frames|ms"},
      {"move", "expected: move TARGET"},
      {"move a b", "expected: move TARGET"},
      {"press", "expected: press left|middle|right"},
      {"press top", "'top' is no button"},
      {"release 1", "'1' is no button"},
      {"click", "expected: click TARGET [left|right|double]"},
      {"click a middle", "'middle' is no kind of click"},
      {"drag left a", "expected: drag BUTTON TARGET DX,DY [FRAMES]"},
      {"drag a left 3,4", "'a' is no button"},
      {"drag left a 34", "'34': expected DX,DY"},
      {"drag left a 3,b", "'3,b': expected DX,DY"},
      {"drag left a 3,4 0", "'0': expected a number of frames"},
      {"wheel", "expected: wheel NOTCHES [TARGET]"},
      {"wheel up", "'up': expected a number"},
      {"wheel nan", "'nan': expected a number"},
      {"key", "expected: key CHORD, key down|up KEY"},
      {"key hyper", "'hyper' is no key"},
      {"key ctrl+hyper", "'hyper' is no key"},
      {"key press a", "'press': expected down or up"},
      {"key down ctrl+a", "'ctrl+a' is no key"},
      {"type", "expected: type TEXT..."},
      {"drop", "expected: drop FILE..."},
      {"resize 100", "expected: resize WIDTHxHEIGHT"},
      {"resize 100x", "expected: resize WIDTHxHEIGHT"},
      {"resize 0x10", "expected: resize WIDTHxHEIGHT"},
      {"resize 1e9x10", "expected: resize WIDTHxHEIGHT"},
      {"screenshot", "expected: screenshot FILE"},
      {"picture a b", "expected: picture FILE"},
      {"state", "expected: state FILE"},
      {"expect a ==", "expected: expect KEY ==|!=|<|<=|>|>=|contains VALUE"},
      {"expect a = 3", "'=' is no comparison"},
      {"print", "expected: print KEY"},
      {"measure", "expected: measure NAME"},
      {"pace", "expected: pace FRAMES_PER_SECOND (0: as fast as possible)"},
      {"pace -1", "expected: pace FRAMES_PER_SECOND (0: as fast as possible)"},
      {"repeat", "expected: repeat N"},
      {"repeat 0", "'0': expected a whole number, from 1"},
      {"repeat 1.5", "'1.5': expected a whole number, from 1"},
      {"repeat 1e300", "'1e300': expected a whole number, from 1"},
      {"end", "'end' without 'repeat'"},
      {"end 3", "expected: end"},
      {"close now", "expected: close"}};
  const Folder folder;
  const std::string path = folder / "script.txt";
  for (const auto& [line, fault] : faults) {
    cli_tests::write_file(path, "# a comment\n\n  pace 0 # and another\n" + line + "\nclose\n");
    EXPECT_EQ(complaint_of_script(path), path + ":4: " + fault) << line;
  }
}

TEST(Scripts, FilesThatAreNoneAndLoopsWithoutEnd) {
  const Folder folder;
  const std::string missing = folder / "missing.txt";
  EXPECT_EQ(complaint_of_script(missing), missing + ": no such file");
  const std::string path = folder / "script.txt";
  cli_tests::write_file(path, "repeat 2\nrepeat 3\nend\n");
  EXPECT_EQ(complaint_of_script(path), path + ": a 'repeat' has no 'end'");
  cli_tests::write_file(path, std::string((16U << 20) + 1, 'x'));
  EXPECT_EQ(complaint_of_script(path), path + ": must have at most 16777216 bytes");
  cli_tests::write_file(path, "");
  EXPECT_EQ(complaint_of_script(path), "");
  EXPECT_EQ(complaint_of_script(folder / "."),
            folder / "." + ": is a folder: expected a regular file");
  const std::string pipe = folder / "pipe";  // without a writer: to open it as a file would wait
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(complaint_of_script(pipe), pipe + ": is a device or a pipe: expected a regular file");
}

TEST(Scripts, KeysByNameAndBack) {
  std::vector<std::string> names = {"ctrl", "shift", "alt",    "left",      "right", "up",
                                    "down", "space", "tab",    "enter",     "?",     "[",
                                    "]",    "home",  "delete", "backspace", "end",   "escape"};
  for (char c = 'a'; c <= 'z'; ++c) names.emplace_back(1, c);
  for (char c = '0'; c <= '9'; ++c) names.emplace_back(1, c);
  for (const std::string& name : names) {
    EXPECT_GE(key_by_name(name), 0) << name;
    EXPECT_EQ(name_of_key(key_by_name(name)), name);
  }
  for (const char* const name : {"", "A", "f99", "ctrl+c", " "})
    EXPECT_EQ(key_by_name(name), -1) << name;
  EXPECT_EQ(name_of_key(-1), "");
}

// A program that knows one place, and keeps what it is asked for.
class Stage final : public ScriptHost {
 public:
  std::optional<Box2> find(const std::string& name) const override {
    if (name == "box" || (name == "far" && is_scrolled)) return Box2{10, 20, 30, 60};
    return std::nullopt;
  }
  bool scroll_to(const std::string& name) override {
    is_scrolled = true;
    return name == "far";
  }
  bool has_come_to(const std::string& state) const override { return state == "loaded"; }
  std::string value_of(const std::string& key) const override {
    if (key == "number") return "1.50";
    if (key == "text") return "one two";
    throw Error(ErrorCode::kInvalidArgument, key + ": unknown");
  }
  void save_screenshot(const std::string& path) override { asked += "screenshot " + path + '\n'; }
  void save_picture(const std::string& path) override { asked += "picture " + path + '\n'; }
  void save_state(const std::string& path) override { asked += "state " + path + '\n'; }
  void resize(int width, int height) override {
    asked += "resize " + std::to_string(width) + 'x' + std::to_string(height) + '\n';
  }
  void begin_measure(const std::string& name) override { asked += "measure " + name + '\n'; }

  std::string asked;
  bool is_scrolled = false;
};

// The events of all its frames, as a recorder tells them; frames that came in the same millisecond.
std::string replayed(const Folder& folder, const std::string& text, Stage& stage) {
  const std::string path = folder / "replayed.txt";
  cli_tests::write_file(path, text);
  Script script(path);
  Recorder recorder(folder / "recorded.txt");
  for (int frame = 0; frame < 1000 && !script.is_over(); ++frame)
    recorder.take(script.next_frame(stage), 1);
  EXPECT_TRUE(script.is_over());
  recorder.write();
  return cli_tests::read_file(folder / "recorded.txt");
}

TEST(Scripts, LinesBecomeEventsInOrder) {
  const Folder folder;
  Stage stage;
  EXPECT_EQ(replayed(folder, "wait loaded\nclick box\n", stage),
            "move 20,40\npress left\nrelease left\n");
  EXPECT_EQ(replayed(folder, "click box@0.25,1 right\n", stage),
            "move 15,60\npress right\nrelease right\n");
  EXPECT_EQ(replayed(folder, "click 7,8 double\n", stage),
            "move 7,8\npress left\nrelease left\npress left\nrelease left\n");
  EXPECT_EQ(replayed(folder, "drag middle box 10,-4 2\n", stage),
            "move 20,40\npress middle\nmove 25,38\nmove 30,36\nrelease middle\n");
  EXPECT_EQ(replayed(folder, "wheel -2 box\n", stage), "move 20,40\nwheel -2\n");
  EXPECT_EQ(replayed(folder, "key ctrl+shift+z\n", stage),
            "key down ctrl\nkey down shift\nkey down z\nkey up z\nkey up shift\nkey up ctrl\n");
  EXPECT_EQ(replayed(folder, "type \"a b\"\n", stage), "type \"a\"\ntype \" \"\ntype \"b\"\n");
  EXPECT_EQ(replayed(folder, "drop \"a b.nrrd\" c.json\nclose\n", stage),
            "drop \"a b.nrrd\" \"c.json\"\nclose\n");
  EXPECT_EQ(replayed(folder, "repeat 2\nrepeat 3\nwheel 1\nend\nwheel 2\nend\n", stage),
            "wheel 1\nwheel 1\nwheel 1\nwheel 2\nwheel 1\nwheel 1\nwheel 1\nwheel 2\n");
  EXPECT_FALSE(stage.is_scrolled);
  EXPECT_EQ(replayed(folder, "move far\n", stage), "move 20,40\n");
  EXPECT_TRUE(stage.is_scrolled);
}

TEST(Scripts, TheProgramIsAsked) {
  const Folder folder;
  Stage stage;
  EXPECT_EQ(replayed(folder,
                     "resize 30x40\nscreenshot a.png\npicture b.png\nstate c.json\nmeasure d\n"
                     "expect number == 1.5\nexpect number != 2\nexpect number < 2\n"
                     "expect number >= 1.5\nexpect number <= 1.5\nexpect number > 1\n"
                     "expect text contains \"e t\"\nexpect text == \"one two\"\n",
                     stage),
            "");
  EXPECT_EQ(stage.asked,
            "resize 30x40\nscreenshot a.png\npicture b.png\nstate c.json\nmeasure d\n");
}

TEST(Scripts, WhatIsNotAsExpectedIsNamed) {
  const std::map<std::string, std::string> faults = {
      {"expect number == 2", "number is '1.50', expected == 2"},
      {"expect number > 1.5", "number is '1.50', expected > 1.5"},
      {"expect text < 2", "text is 'one two', which is no number"},
      {"expect text contains three", "text is 'one two', expected contains three"},
      {"click nowhere", "there is no 'nowhere' in the window"}};
  const Folder folder;
  const std::string path = folder / "script.txt";
  for (const auto& [line, fault] : faults) {
    cli_tests::write_file(path, "pace 0\n" + line + "\n");
    Stage stage;
    Script script(path);
    std::string said;
    for (int frame = 0; frame < 100 && said.empty() && !script.is_over(); ++frame) {
      try {
        script.next_frame(stage);
      } catch (const Error& error) {
        said = error.what();
      }
    }
    EXPECT_EQ(said, path + ":2: " + fault);
  }
}

TEST(Scripts, ARecordingParsesAndSaysTheSameAgain) {
  const Folder folder;
  Recorder recorder(folder / "first.txt");
  recorder.begin(640, 480);
  double now = 1000;
  const std::vector<Event> events = {MouseMoved{12.5, 7},
                                     ButtonChanged{0, true},
                                     ButtonChanged{0, false},
                                     ButtonChanged{7, true},  // a button without a name
                                     Scrolled{0, -1.5},
                                     KeyChanged{key_by_name("ctrl"), true, 2},
                                     KeyChanged{key_by_name("z"), true, 2},
                                     KeyChanged{-1, true, 0},  // nor is there one of this key
                                     Typed{'#'},
                                     Typed{'"'},
                                     Typed{0x1F600},
                                     Dropped{{"/a b/c.nrrd", "d"}},
                                     CloseAsked{}};
  for (const Event& event : events) recorder.take({event}, now += 0.5);
  recorder.take({}, now += 1000);
  recorder.take({MouseMoved{1, 2}}, now);
  recorder.write();
  EXPECT_EQ(cli_tests::read_file(folder / "first.txt"),
            "resize 640x480\nwait loaded\nmove 12.5,7\npress left\nrelease left\nwheel -1.5\n"
            "key down ctrl\nkey down z\ntype \"#\"\ndrop \"/a b/c.nrrd\" \"d\"\nclose\n"
            "wait 1000 ms\nmove 1,2\n");
  EXPECT_EQ(complaint_of_script(folder / "first.txt"), "");
}

}  // namespace script_test
}  // namespace ovoid::viewer
