// SPDX-License-Identifier: Apache-2.0
// --tf, --camera and --trail-tf with JSON itself.
#include <gtest/gtest.h>

#include "program.h"

namespace ovoid::cli_tests {
namespace json_flags_test {

constexpr const char* kLookInFlag =
    R"({"Name":"a \"b\" \\ c","RGBPoints":[0.1,0,0,1,255,1,0.25,0],"Points":[0,0,0.5,0,255,1,0.5,0]})";
constexpr const char* kCameraInFlag =
    R"({"position":[7.5,7.5,60.1],"focal_point":[7.5,7.5,7.5],"view_angle":22.125})";

std::string bytes_drawn(Words words, const std::string& path) {
  words.insert(words.begin(), "render");
  words.insert(words.end(), {"-o", path});
  expect_success(words);
  return read_file(path);
}

// A value that begins like JSON is no file, for reading or for anything else.
TEST(JsonInFlags, StandsForAFile) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  write_file(folder / "look.json", kLookInFlag);
  write_file(folder / "camera.json", kCameraInFlag);
  const std::string expected = bytes_drawn(
      {ball, "--size", "40x30", "--tf", folder / "look.json", "--camera", folder / "camera.json"},
      folder / "a.png");
  EXPECT_EQ(bytes_drawn({ball, "--size", "40x30", "--tf", " [" + std::string(kLookInFlag) + "]",
                         "--camera=" + std::string(kCameraInFlag)},
                        folder / "b.png"),
            expected);
  const std::string out = folder / "c.png";
  expect_failure({"render", ball, "-o", out, "--tf", "{"}, 2, {"--tf: not JSON at byte 2"});
  expect_failure({"render", ball, "-o", out, "--tf", "[]"}, 2,
                 {"--tf: []: must hold at least one preset"});
  expect_failure({"render", ball, "-o", out, "--tf", kLookInFlag, "--tf-name", "x"}, 2,
                 {"preset = x: --tf has a \"b\""});
  expect_failure({"render", ball, "-o", out, "--camera", R"({"view_angle": 0})"}, 2,
                 {"--camera: camera view_angle = 0"});
  expect_failure({"render", ball, "-o", out, "--motion-blur", "1", "--trail-tf", "[1]"}, 2,
                 {"--trail-tf: "});
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace json_flags_test
}  // namespace ovoid::cli_tests
