// SPDX-License-Identifier: Apache-2.0
// What the window remembers, and the dialog for files: fails if a choice is forgotten, if a damaged
// file keeps the window from opening, if a script depends on what somebody has chosen, or if the
// window waits for the dialog.
#include <filesystem>

#include "screen.h"
#include "support/where.h"

namespace ovoid::viewer_tests {
namespace memory_window_test {

class WindowMemory : public OnScreen {
 protected:
  // What is kept, as JSON.
  nlohmann::json kept(const std::string& name = "state/window.json") const {
    return nlohmann::json::parse(file(name), nullptr, false);
  }
  Words remembering(Words words) const {
    words.insert(words.end(), {"--remember", folder_ / "state/window.json"});
    return words;
  }
};

TEST_F(WindowMemory, TheThemeIsTheOneChosenLast) {
  const Words words = remembering({});
  view(words,
       "expect theme == dark\nclick data.theme\nclick data.theme/light\n"
       "expect theme == light\n");
  EXPECT_EQ(kept()["theme"], "light");
  view(words, "expect theme == light\n");
  // A flag is for one run.
  view(remembering({"--theme", "dark"}), "expect theme == dark\n");
  view(words, "expect theme == light\n");
  // And a script has what it says.
  view({}, "expect theme == dark\n");
}

TEST_F(WindowMemory, ADamagedFileIsAsGoodAsNone) {
  OVOID_NOT_UNDER_TSAN();
  std::filesystem::create_directory(folder_ / "state");
  for (const char* const content :
       {"", "{", "[1, 2]", R"({"theme": 7})", R"({"theme": "green", "other": {"a": 1}})"}) {
    write_file(folder_ / "state/window.json", content);
    view(remembering({}), "expect theme == dark\nclick data.theme\nclick data.theme/light\n");
    EXPECT_EQ(kept()["theme"], "light") << content;
  }
  EXPECT_EQ(kept()["other"]["a"], 1);  // somebody else's, of a newer version perhaps
}

TEST_F(WindowMemory, WhereNothingCanBeWrittenTheWindowSaysSo) {
  write_file(folder_ / "state", "a file, no folder");
  view(remembering({}),
       "click data.theme\nclick data.theme/light\nexpect theme == light\n"
       "expect message contains window.json\n");
}

TEST_F(WindowMemory, WhereNothingWasChosenNothingIsWritten) {
  setenv("XDG_STATE_HOME", (folder_ / "home").c_str(), 1);
  Program viewer({"--size", "340x240"}, OVOID_VIEWER_PROGRAM);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  viewer.send(SIGINT);
  EXPECT_EQ(viewer.finish(kLimitSeconds).exit_code, 130);
  unsetenv("XDG_STATE_HOME");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "home"));  // nothing was chosen
}

// The picture is what `ovoid render` draws, whatever the theme.
TEST_F(WindowMemory, ThemesLeaveThePictureAlone) {
  const std::string head = make_head();
  for (const char* const theme : {"dark", "light"}) {
    view({head, "--theme", theme}, std::string("pace 0\nwait full\npicture $/") + theme +
                                       ".png\nscreenshot $/screen-" + theme + ".png\n");
  }
  EXPECT_TRUE(file("dark.png") == file("light.png"));
  EXPECT_FALSE(file("screen-dark.png") == file("screen-light.png"));
}

TEST_F(WindowMemory, WhatWasOpenedLastOpensAgain) {
  const std::string head = make_head();
  const std::string ball = make("box", "b [1].nrrd", {"--size", "8"});
  view(remembering({head}), "wait loaded\nexpect recent.0.title == head.nrrd\n");
  view(remembering({ball}),
       "wait loaded\nexpect recent.0.title == \"b [1].nrrd\"\n"
       "expect recent.1.title == head.nrrd\n");
  view(remembering({}),
       "click start.recent.1\nwait loaded\nexpect array == head\n"
       "expect recent.0.title == head.nrrd\nclick tab.data\nclick data.recent\n"
       "click data.recent.1\nwait loaded\nwait idle\n"
       "expect recent.0.title == \"b [1].nrrd\"\nexpect kernels == 512\n");
  EXPECT_EQ(kept()["recent"].size(), 2U);
  EXPECT_EQ(kept()["recent"][1]["inputs"][0], std::filesystem::absolute(head).string());
  // What is gone stays in the list, for a disk may come back, and cannot be chosen.
  std::filesystem::rename(ball, folder_ / "elsewhere.nrrd");
  view(remembering({}),
       "wait 500 ms\nexpect recent.0.is_there == false\nclick start.recent.0\nwait 5 frames\n"
       "expect is_open == false\nexpect error == \"\"\n");
  // A drop of what cannot be read is nothing that was opened.
  write_file(folder_ / "no.nrrd", "no data");
  view(remembering({}),
       "drop $/no.nrrd\nwait loaded\nexpect recent.1.title == head.nrrd\n"
       "click start.recent.1\nwait loaded\nclick tab.data\nclick data.recent\n"
       "click data.recent.forget\nexpect recent == []\n");
  EXPECT_EQ(kept()["recent"].size(), 0U);
  EXPECT_EQ(std::filesystem::status(folder_ / "state").permissions(),
            std::filesystem::perms::owner_all);  // nobody else's business
}

// Several files, and the flags without which they could not be read, from another folder.
TEST_F(WindowMemory, FlagsOfTheDataAreRemembered) {
  Words words = {"--dims", "8x8x8", "--type", "uint8", "--step", "1"};
  for (const char* const name : {"a.bin", "b.bin"}) {
    write_file(folder_ / name, std::string(256, 'a') + std::string(256, 'b'));
    words.push_back(folder_ / name);
  }
  view(remembering(words), "wait loaded\nexpect recent.0.title == \"a.bin and 1 more\"\n");
  view(remembering({}),
       "click start.recent.0\nwait loaded\nwait idle\nexpect time.steps == 2\n"
       "expect kernels == 512\nexpect time.now == 0\n");
  EXPECT_EQ(kept()["recent"].size(), 1U);
}

TEST_F(WindowMemory, TheListIsShortAndItsNonsensePassedOver) {
  nlohmann::json all = nlohmann::json::array();
  all.push_back(7);
  all.push_back({{"inputs", {"relative.nrrd"}}});
  all.push_back({{"inputs", nlohmann::json::array()}});
  all.push_back({{"inputs", {"/x.nrrd"}}, {"flags", {{"nonsense", "1"}}}});
  for (int i = 0; i < 30; ++i)
    all.push_back({{"inputs", {"/nowhere/" + std::to_string(i) + ".nrrd"}}});
  std::filesystem::create_directory(folder_ / "state");
  write_file(folder_ / "state/window.json", nlohmann::json{{"recent", all}}.dump());
  view(remembering({make_head()}),
       "wait loaded\nexpect recent.0.title == head.nrrd\n"
       "expect recent.1.title == 0.nrrd\n"
       "expect recent.9.title == 8.nrrd\n");
  EXPECT_EQ(kept()["recent"].size(), 10U);
}

// A program that stands in for zenity: it writes its words into a file, waits, and answers.
class WindowDialog : public OnScreen {
 protected:
  void SetUp() override {
    OnScreen::SetUp();
    before_ = std::getenv("PATH");
    std::filesystem::create_directory(folder_ / "bin");
  }
  void TearDown() override {
    if (!before_.empty()) setenv("PATH", before_.c_str(), 1);
  }
  void answer(const std::string& program, const std::string& script) {
    const std::string path = folder_ / "bin/" + program;
    write_file(path, "#!/bin/sh\nprintf '%s|' \"$@\" > " + (folder_ / "words") + "\n" + script);
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    setenv("PATH", ((folder_ / "bin") + ":/usr/bin:/bin").c_str(), 1);
  }

  std::string before_;
};

TEST_F(WindowDialog, WhatIsChosenOpensAndTheWindowGoesOnMeanwhile) {
  const std::string head = make_head();
  const std::string box = make("box", "b x.nrrd", {"--size", "8"});
  answer("zenity",
         "while [ ! -e " + (folder_ / "go.png") + " ]; do sleep 0.05; done\necho '" + box + "'\n");
  // The picture turns, and is written, while the dialog waits for just that.
  view({head},
       "pace 0\nwait full\nkey ctrl+o\nexpect is_browsing == true\nkey ctrl+o\n"
       "drag left picture 40,10\nwait full\nexpect array == head\npicture $/go.png\n"
       "wait 1000 ms\nwait idle\nexpect is_browsing == false\nexpect kernels == 512\n");
  EXPECT_NE(file("words").find("--file-selection|--multiple|"), std::string::npos);
  EXPECT_NE(file("words").find("--filename=" + (folder_ / "|")), std::string::npos)
      << file("words");
}

TEST_F(WindowDialog, SeveralFilesAreOneInputAndNoneIsNone) {
  const std::string a = make("box", "a.nrrd", {"--size", "8"});
  const std::string b = make("box", "b.nrrd", {"--size", "8"});
  answer("zenity", "printf '%s\\n%s\\n' '" + a + "' '" + b + "'\n");
  view({}, "click start.browse\nwait loaded\nwait idle\nexpect time.steps == 2\n");
  answer("zenity", "exit 1\n");  // the person's own wish
  view({}, "click data.browse\nwait 500 ms\nexpect is_open == false\nexpect message == \"\"\n");
  answer("zenity", "exit 3\n");
  view({}, "click data.browse\nwait 500 ms\nexpect message contains \"zenity, the dialog\"\n");
}

// Each button has its own question: a look is put on what is open, whatever its name, a state is
// restored, and both of them are one file.
TEST_F(WindowDialog, LooksAndStatesAreChosenToo) {
  const std::string head = make_head();
  const std::string rows = folder_ / "some.rows";
  write_file(rows, "100 0 #ff0000\n200 0.5 #00ff00\n400 1 #0000ff\n");
  answer("zenity", "echo '" + rows + "'\n");
  view({head},
       "wait full\nclick tab.look\nclick look.browse\nwait 500 ms\nwait full\n"
       "expect view.points == 3\nexpect array == head\n");
  EXPECT_NE(file("words").find("--title|Open a look - Ovoid|"), std::string::npos) << file("words");
  EXPECT_EQ(file("words").find("--multiple"), std::string::npos) << file("words");
  const std::string state = folder_ / "a-state.json";
  view({head}, "wait full\nkey p\nwait full\nstate $/a-state.json\n");
  answer("zenity", "echo '" + state + "'\n");
  view({head},
       "wait full\nexpect camera.parallel == false\nclick tab.data\nclick data.state.browse\n"
       "wait 500 ms\nwait full\nexpect camera.parallel == true\n");
  EXPECT_NE(file("words").find("Restore a state"), std::string::npos) << file("words");
}

TEST_F(WindowDialog, KdesOwnWhereKdeRuns) {
  answer("zenity", "exit 1\n");
  answer("kdialog", "exit 1\n");
  setenv("XDG_CURRENT_DESKTOP", "KDE", 1);
  view({}, "click data.browse\nwait 500 ms\n");
  unsetenv("XDG_CURRENT_DESKTOP");
  EXPECT_NE(file("words").find("--getopenfilename|"), std::string::npos) << file("words");
}

TEST_F(WindowDialog, WithoutOneTheWindowSaysWhatToDo) {
  setenv("PATH", (folder_ / "bin").c_str(), 1);
  view({},
       "click data.browse\nexpect is_browsing == false\nexpect message contains zenity\n"
       "expect message contains \"drop a file\"\n");
}

// It does not outlive the window.
TEST_F(WindowDialog, ClosesWithTheWindow) {
  answer("zenity", "echo $$ > " + (folder_ / "number") + "\nexec sleep 1000\n");
  view({}, "click data.browse\nwait 500 ms\nclose\n");
  const int number = std::atoi(file("number").c_str());
  ASSERT_GT(number, 1);
  EXPECT_NE(kill(number, 0), 0);
}

}  // namespace memory_window_test
}  // namespace ovoid::viewer_tests
