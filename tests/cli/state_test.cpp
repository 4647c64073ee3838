// SPDX-License-Identifier: Apache-2.0
// `ovoid render --state`: the same bytes as by flags, flags that win, and states that are refused.
#include <gtest/gtest.h>

#include "flag_set.h"
#include "ovoid/error.h"
#include "program.h"
#include "state_file.h"

namespace ovoid::cli_tests {
namespace state_test {

using cli::State;
using Json = cli::FlagSet::Json;

constexpr const char* kLook =
    R"({"Name":"a \"b\" \\ c","RGBPoints":[0.1,0,0,1,255,1,0.25,0],"Points":[0,0,0.5,0,255,1,0.5,0]})";
constexpr const char* kCamera =
    R"({"position":[7.5,7.5,60.1],"focal_point":[7.5,7.5,7.5],"view_angle":22.125})";

std::string drawn(Words words, const std::string& path) {
  words.insert(words.begin(), "render");
  words.insert(words.end(), {"-o", path});
  expect_success(words);
  return read_file(path);
}

void write_by_hand(const std::string& path, const std::string& flags,
                   const std::string& input = "ball_16x16x16_uint8.raw") {
  write_file(path, R"({"ovoid_state": 1, "inputs": [")" + input + R"("], "flags": )" + flags + "}");
}

TEST(State, DrawsTheSameBytesAsFlags) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  write_file(folder / "look.json", kLook);
  const std::pair<Words, std::string> cases[] = {
      {{"--size", "40x30"}, R"({"size": "40x30"})"},
      {{"--size", "40x30", "--tf", kLook, "--camera", kCamera},
       R"({"size": "40x30", "tf": )" + std::string(kLook) + R"(, "camera": )" + kCamera + "}"},
      {{"--size", "40x30", "--tf", folder / "look.json", "--no-shade"},
       R"({"size": "40x30", "tf": "look.json", "no-shade": true})"},
      {{"--size", "40x30", "--clip", "1,0,0,-1", "--clip", "0,1,0,2", "--colorbar=A title"},
       R"({"clip": ["1,0,0,-1", "0,1,0,2"], "colorbar": "A title", "size": "40x30"})"},
      {{"--size", "40x30", "--colorbar", "--mode", "isosurface", "--iso", "99", "--view", "-x"},
       R"({"view": "-x", "iso": "99", "mode": "isosurface", "colorbar": true, "size": "40x30"})"},
      {{"--size", "40x30", "--range", "-5,200", "--background", "1,1,1", "--azimuth", "-12.5"},
       R"({"size": "40x30", "range": "-5,200", "background": "1,1,1", "azimuth": "-12.5"})"},
  };
  for (const auto& [flags, json] : cases) {
    SCOPED_TRACE(json);
    Words words = {ball};
    words.insert(words.end(), flags.begin(), flags.end());
    const std::string expected = drawn(words, folder / "a.png");
    write_by_hand(folder / "s.json", json);
    EXPECT_EQ(drawn({"--state", folder / "s.json"}, folder / "b.png"), expected);
    // Read, written and read again.
    cli::write_state(cli::read_state(folder / "s.json"), folder / "t.json");
    EXPECT_EQ(drawn({"--state=" + (folder / "t.json")}, folder / "b.png"), expected);
    EXPECT_FALSE(expected.empty());
  }
}

TEST(State, FlagsBeatIt) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  const std::string state = folder / "s.json";
  write_by_hand(state, R"({"size": "40x30", "camera": )" + std::string(kCamera) +
                           R"(, "mode": "isosurface", "iso": "99", "no-shade": true})");
  EXPECT_EQ(
      drawn({"--state", state, "--view", "+x", "--size", "20x20", "--shade"}, folder / "a.png"),
      drawn({ball, "--view", "+x", "--size", "20x20", "--mode", "isosurface", "--iso", "99"},
            folder / "b.png"));
  EXPECT_EQ(drawn({"--mode", "xray", "--state", state}, folder / "a.npy"),
            drawn({ball, "--mode", "xray", "--size", "40x30", "--camera", kCamera, "--no-shade"},
                  folder / "b.npy"));
}

TEST(State, InputsReplaceItsOwn) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  write_by_hand(folder / "s.json", R"({"size": "40x30"})", "missing.nrrd");
  expect_failure({"render", "--state", folder / "s.json", "-o", folder / "a.png"}, 1,
                 {"missing.nrrd"});
  const std::string expected = drawn({ball, "--size", "40x30"}, folder / "b.png");
  EXPECT_EQ(drawn({ball, "--state", folder / "s.json"}, folder / "a.png"), expected);
  EXPECT_EQ(drawn({"--state", folder / "s.json", ball}, folder / "a.png"), expected);
}

// Fails if a folder with a state and its data cannot be moved, or a state elsewhere cannot be read.
TEST(State, FilesAreMeantFromItsFolder) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  std::filesystem::create_directories(folder / "states/data");
  std::filesystem::copy_file(ball, folder / "states/data/x_16x16x16_uint8.raw");
  State state;
  state.inputs = {ball, folder / "states/data/x_16x16x16_uint8.raw", folder / "states",
                  folder / "states/data/"};
  state.flags.set("tf", folder / "states/{a}.json");
  state.flags.set("camera", folder / "c.json");
  state.flags.set("add", {folder / "states/data/lead.stl", folder / "bone.ply"});
  state.flags.set("within", folder / "states/hull.vtu");
  state.flags.set("data-folder", Json::array({folder / "states/data"}));
  state.flags.set("array", "data");  // no file's name
  const std::string path = folder / "states/../states/s.json";
  cli::write_state(state, path);
  const Json json = Json::parse(read_file(path));
  const std::string canonical = std::filesystem::canonical(folder / ".").string();
  EXPECT_EQ(json["inputs"][0], canonical + "/ball_16x16x16_uint8.raw");
  EXPECT_EQ(json["inputs"][1], "data/x_16x16x16_uint8.raw");
  EXPECT_EQ(json["inputs"][2], ".");
  EXPECT_EQ(json["inputs"][3], "data");
  EXPECT_EQ(json["flags"]["tf"], "./{a}.json");
  EXPECT_EQ(json["flags"]["camera"], canonical + "/c.json");
  EXPECT_EQ(json["flags"]["add"], Json::array({"data/lead.stl", canonical + "/bone.ply"}));
  EXPECT_EQ(json["flags"]["within"], "hull.vtu");
  EXPECT_EQ(json["flags"]["data-folder"], Json::array({"data"}));
  EXPECT_EQ(json["flags"]["array"], "data");
  EXPECT_EQ(json["ovoid_state"], 1);
  EXPECT_EQ(json["window"], Json::object());
  std::filesystem::rename(folder / "states", folder / "moved");
  const State moved = cli::read_state(folder / "moved/s.json");
  EXPECT_TRUE(
      std::filesystem::equivalent(moved.inputs[1], folder / "moved/data/x_16x16x16_uint8.raw"));
  EXPECT_TRUE(std::filesystem::equivalent(moved.inputs[2], folder / "moved"));
  EXPECT_EQ(moved.inputs[0], canonical + "/ball_16x16x16_uint8.raw");
  const Json& added = *moved.flags.find("add");
  EXPECT_EQ(added, Json::array({folder / "moved/data/lead.stl", canonical + "/bone.ply"}));
  EXPECT_EQ(*moved.flags.find("within"), folder / "moved/hull.vtu");
  EXPECT_EQ(*moved.flags.find("data-folder"), Json::array({folder / "moved/data"}));
}

TEST(State, TheWindowComesBack) {
  const Folder folder;
  State state;
  state.window["panel"] = {{"width", 1.0 / 3}, {"open", true}};
  cli::write_state(state, folder / "s.json");
  const State back = cli::read_state(folder / "s.json");
  EXPECT_EQ(back.window, state.window);
  EXPECT_TRUE(back.inputs.empty());
  EXPECT_TRUE(back.flags.empty());
  EXPECT_EQ(folder.num_files(), 1U);
}

TEST(State, NamesThatJsonCannotHoldAreNotWritten) {
  const Folder folder;
  State state;
  state.inputs = {"\xff.nrrd"};
  EXPECT_THROW(cli::write_state(state, folder / "s.json"), Error);
  EXPECT_THROW(cli::write_state({}, folder / "no/s.json"), Error);
  EXPECT_EQ(folder.num_files(), 0U);
}

std::string of_flags(const std::string& flags) {
  return R"({"ovoid_state": 1, "inputs": ["ball_16x16x16_uint8.raw"], "flags": )" + flags + "}";
}

// Content, and what the line says after the file's name.
const std::vector<std::pair<std::string, std::string>>& bad_states() {
  static const std::vector<std::pair<std::string, std::string>> all = {
      {"", ": not JSON at byte 1"},
      {"{\"ovoid_state\": 1,", ": not JSON at byte 19"},
      {"{\"ovoid_state\": 1, \"program\": \"\xff\"}", ": not JSON at byte 32"},
      {R"({"ovoid_state": 1e999})", ": holds a number that double cannot"},
      {std::string(70, '['), ": nested deeper than 64 levels"},
      {"[]",
       ": is no state, expected an object with the members ovoid_state, program, inputs, "
       "flags and window"},
      {R"({"position": [0, 0, 1]})",
       ": is no state, expected an object with the members "
       "ovoid_state, program, inputs, flags and window"},
      {R"({"ovoid_state": "1"})", ": ovoid_state = \"1\": must be a whole number, from 1"},
      {R"({"ovoid_state": 0})", ": ovoid_state = 0: must be a whole number, from 1"},
      {R"({"ovoid_state": 1.5})", ": ovoid_state = 1.5: must be a whole number, from 1"},
      {R"({"ovoid_state": 2, "program": "0.9.0", "new": 1})",
       ": a state of version 2, this program reads version 1; ovoid 0.9.0 or newer reads it"},
      {R"({"ovoid_state": 2})",
       ": a state of version 2, this program reads version 1; the ovoid "
       "that wrote it or newer reads it"},
      {R"({"ovoid_state": 1, "flag": {}})",
       ": flag: unknown; a state has ovoid_state, program, inputs, flags, window; did you mean "
       "flags?"},
      {R"({"ovoid_state": 1, "flags": {"size": "1x1", "size": "2x2"}})",
       ": 'size' stands twice in one object"},
      {R"({"ovoid_state": 1, "program": 3})", ": program: must be a string"},
      {R"({"ovoid_state": 1, "window": []})", ": window: must be an object"},
      {R"({"ovoid_state": 1, "inputs": "a"})", ": inputs: must be an array of strings"},
      {R"({"ovoid_state": 1, "inputs": ["a", 2]})", ": inputs[1]: must be a string"},
      {R"({"ovoid_state": 1, "inputs": [""]})", ": inputs[0]: must be the name of a file"},
      {R"({"ovoid_state": 1, "inputs": ["a\u0000"]})", ": inputs[0]: must be the name of a file"},
      {of_flags("[]"), ": flags: must be an object of flags and their values"},
      {of_flags(R"({"sze": "1x1"})"), ": flags.sze: unknown flag; did you mean size?"},
      {of_flags(R"({"size": 640})"), ": flags.size = 640: must be a string"},
      {of_flags(R"({"output": "x.png"})"),
       ": flags.output: is for the command line alone, a set of flags writes no files"},
      {of_flags(R"({"size": "640"})"),
       ": flags: --size '640': expected WIDTHxHEIGHT, each 1 to 32768"},
      {of_flags(R"({"shade": true, "no-shade": true})"),
       ": flags: --no-shade: contradicts --shade"},
      {of_flags(R"({"step": "1", "time": "1"})"),
       ": flags: --time: contradicts --step; give one of them"},
      {of_flags(R"({"iso": "1"})"), ": flags: --iso: needs --mode isosurface"},
      {of_flags(R"({"camera": {"x": 1}})"),
       ": flags: --camera: x = 1: unknown; a camera has position focal_point view_up "
       "parallel_projection parallel_scale view_angle"},
      {of_flags(R"({"tf": {"Points": [0, 1]}})"),
       ": flags: --tf: Points = [0,1]: must have four numbers per point"},
  };
  return all;
}

TEST(State, BadOnesAreRefusedInOneLineThatNamesFileAndKey) {
  const Folder folder;
  write_ball(folder);
  const std::string path = folder / "s.json";
  for (const auto& [content, said] : bad_states()) {
    write_file(path, content);
    const Outcome result = run({"render", "--state", path, "-o", folder / "a.png"});
    EXPECT_EQ(result.exit_code, 1) << content;
    EXPECT_EQ(result.err, "ovoid: error: " + path + said + "\n") << content;
    EXPECT_EQ(result.out, "");
  }
  EXPECT_EQ(folder.num_files(), 2U) << "a refused state left a file";
}

TEST(State, LargeAndMissingFilesEnd) {
  const Folder folder;
  const std::string path = folder / "s.json";
  expect_failure({"render", "--state", path, "-o", folder / "a.png"}, 1, {path + ": no such file"});
  expect_failure({"render", "--state", folder / ".", "-o", folder / "a.png"}, 1, {"is a folder"});
  expect_failure({"render", "--state", "/dev/zero", "-o", folder / "a.png"}, 1,
                 {"/dev/zero: is a device or a pipe: expected a regular file"});
  std::string many = R"({"ovoid_state": 1, "window": {"k": 1)";
  for (int i = 0; i < 1000; ++i) many += ", \"" + std::to_string(i) + "\": 1";
  write_file(path, many + "}}");
  expect_failure({"render", "--state", path, "-o", folder / "a.png"}, 1,
                 {path + ": an object has more than 1000 members"});
  EXPECT_EQ(folder.num_files(), 1U);
}

TEST(State, IsNotOverwritten) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  const std::string path = folder / "s.json";
  write_by_hand(path, "{}");
  expect_failure({"render", "--state", path, "-o", folder / "a.png", "--profile=" + path}, 2,
                 {"--profile '" + path + "': is the state of --state"});
  EXPECT_EQ(folder.num_files(), 2U);
}

}  // namespace state_test
}  // namespace ovoid::cli_tests
