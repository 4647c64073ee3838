// SPDX-License-Identifier: Apache-2.0
// What the window remembers: fails if a choice is forgotten, if a damaged file keeps the window
// from opening, or if a script depends on what somebody has chosen.
#include <filesystem>

#include "screen.h"

namespace ovoid::viewer_tests {
namespace {

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

}  // namespace
}  // namespace ovoid::viewer_tests
