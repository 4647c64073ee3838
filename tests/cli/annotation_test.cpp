// SPDX-License-Identifier: Apache-2.0
// Marks and crops of `ovoid render`.
#include <gtest/gtest.h>

#include "program.h"

namespace ovoid::cli_tests {
namespace annotation_test {

class Annotation : public ::testing::Test {
 protected:
  std::string png(Words words) {
    const std::string path = folder_ / "drawn.png";
    words.insert(words.begin(), {"render", ball_});
    words.insert(words.end(), {"-o", path, "--size", "160x120"});
    expect_success(words);
    return read_file(path);
  }
  Picture npy(Words words) {
    words.insert(words.begin(), ball_);
    return draw(folder_, words);
  }

  Folder folder_;
  std::string ball_ = write_ball(folder_);
};

TEST_F(Annotation, EveryMarkChangesThePictureAndIsTheSameTwice) {
  const std::string plain = png({});
  for (const char* const mark :
       {"--colorbar", "--colorbar=Ball", "--axes", "--bounding-box", "--scale-bar"}) {
    const std::string once = png({mark});
    EXPECT_NE(once, plain) << mark;
    EXPECT_EQ(png({mark, "--threads", "1"}), once) << mark;
  }
  EXPECT_NE(png({"--colorbar"}), png({"--colorbar=Ball"}));
  EXPECT_NE(png({"--scale-bar"}), png({"--scale-bar", "--length-unit", "\xC2\xB5m"}));
}

TEST_F(Annotation, MarksGoWithEveryMode) {
  for (const Words& mode : {Words{"--mode", "xray"},
                            {"--mode", "maximum"},
                            {"--mode", "mean"},
                            {"--mode", "isosurface", "--iso", "100"},
                            {"--no-shade"}}) {
    Words marked = mode;
    marked.insert(marked.end(), {"--colorbar", "--axes", "--bounding-box", "--scale-bar"});
    EXPECT_NE(png(marked), png(mode));
  }
}

TEST_F(Annotation, FloatPicturesAndUselessUnitsAreRefused) {
  for (const char* const mark : {"--colorbar", "--axes", "--bounding-box", "--scale-bar"}) {
    expect_failure({"render", ball_, "-o", folder_ / "x.npy", mark}, 2, {mark, "x.npy", ".png"});
    expect_failure({"render", ball_, "-o", folder_ / "x.exr", mark}, 2, {mark, "x.exr", ".png"});
  }
  expect_failure({"render", ball_, "-o", folder_ / "x.png", "--length-unit", "m"}, 2,
                 {"--length-unit", "--scale-bar"});
}

// ---- crop

TEST_F(Annotation, ACropCutsAndIsFramed) {
  const std::size_t whole = npy({"--no-shade"}).num_covered();
  // The same camera: half of the ball is half of the pixels.
  const std::string camera = folder_ / "camera.json";
  write_file(camera, R"({"position":[7.5,7.5,60],"focal_point":[7.5,7.5,7.5],"view_angle":20})");
  const std::size_t seen = npy({"--camera", camera, "--sheets", "image"}).num_covered();
  for (const char* const half : {"--crop=8:,,", "--crop=:7,,", "--crop=8:15,0:15,:"}) {
    const double part =
        static_cast<double>(npy({"--camera", camera, half, "--sheets", "image"}).num_covered());
    EXPECT_NEAR(part / static_cast<double>(seen), 0.5, 0.05) << half;
  }
  EXPECT_EQ(npy({"--crop", "8:,,"}).rgba, npy({"--crop-world", "7.5:15.5,,"}).rgba);
  // Framed: a small part fills more of the picture than its share.
  EXPECT_GT(npy({"--crop", "6:9,6:9,6:9", "--no-shade"}).num_covered(), whole / 2);
}

TEST_F(Annotation, ACropOfEverythingChangesNothing) {
  const Picture whole = npy({});
  EXPECT_EQ(npy({"--crop", ",,"}).rgba, whole.rgba);
  EXPECT_EQ(npy({"--crop", "0:15,0:15,0:15"}).rgba, whole.rgba);
  EXPECT_EQ(npy({"--crop-world", ",,"}).rgba, whole.rgba);
}

// The range of the default look is that of the whole.
TEST_F(Annotation, ACropKeepsTheLook) {
  const std::string camera = folder_ / "camera.json";
  write_file(camera, R"({"position":[7.5,7.5,60],"focal_point":[7.5,7.5,7.5],)"
                     R"("parallel_projection":true,"parallel_scale":8})");
  const Picture whole = npy({"--camera", camera, "--mode", "maximum", "--sheets", "image"});
  const Picture part =
      npy({"--camera", camera, "--mode", "maximum", "--crop", "0:4,,", "--sheets", "image"});
  std::size_t covered = 0;
  for (int x = 0; x < 20; ++x) {
    if (part.at(x, 15)[3] <= 0) continue;
    ++covered;
    EXPECT_NEAR(part.at(x, 15)[3], whole.at(x, 15)[3], 1e-6) << x;  // samples are rounded elsewhere
  }
  EXPECT_GT(covered, 0U);
}

TEST_F(Annotation, CropsThatCannotBeAreRefused) {
  const auto refused = [&](const Words& flags, int exit_code, const Words& fragments) {
    Words words = {"render", ball_, "-o", folder_ / "x.png"};
    words.insert(words.end(), flags.begin(), flags.end());
    expect_failure(words, exit_code, fragments);
  };
  refused({"--crop", "1:2"}, 2, {"--crop '1:2'", "three ranges"});
  refused({"--crop", "1,2,3"}, 2, {"--crop '1,2,3'", "LO:HI"});
  refused({"--crop", "5:4,,"}, 2, {"--crop '5:4,,'", "FIRST <= LAST"});
  refused({"--crop", "-1:4,,"}, 2, {"--crop"});
  refused({"--crop", "1.5:4,,"}, 2, {"--crop"});
  refused({"--crop-world", "1:1,,"}, 2, {"--crop-world '1:1,,'", "LO < HI"});
  refused({"--crop-world", "a:1,,"}, 2, {"--crop-world 'a:1,,'"});
  refused({"--crop", ",,", "--crop-world", ",,"}, 2, {"--crop-world: contradicts --crop"});
  refused({"--crop", ",0:16,"}, 1, {"--crop j = 0:16", "samples 0 to 15"});
  refused({"--crop", ",,99:"}, 1, {"--crop k = 99:", "samples 0 to 15"});
  refused({"--crop-world", ",,20:30"}, 1, {"--crop-world z = 20:30", "-0.5 to 15.5"});
  Words planes = {"--crop", "1:2,1:2,1:2"};
  for (int i = 0; i < 11; ++i) planes.insert(planes.end(), {"--clip", "1,0,0,-9"});
  refused(planes, 1, {"--crop", "6 clip planes", "11"});
}

}  // namespace annotation_test
}  // namespace ovoid::cli_tests
