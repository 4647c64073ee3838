// SPDX-License-Identifier: Apache-2.0
// Hyperslices and trails by the program.
#include <gtest/gtest.h>

#include <filesystem>

#include "program.h"

namespace ovoid::cli_tests {
namespace slices_test {

using nlohmann::json;

// 12 x 12 x 12 samples on [-1, 1] at the times 0 to 7, in one file.
std::string tornado(const Folder& folder) {
  const std::string path = folder / "tornado.h5";
  expect_success(
      {"make", "tornado", "--size", "12", "--steps", "8", "--lattice", "cc4", "-o", path});
  return path;
}

Words render_words(const std::string& data, const std::string& picture, const Words& how) {
  Words words{"render", data, "-o", picture, "--size", "40x30"};
  words.insert(words.end(), how.begin(), how.end());
  return words;
}

std::string rendered(const std::string& data, const std::string& picture, const Words& how) {
  expect_success(render_words(data, picture, how));
  return read_file(picture);
}

// Fails if a plane is not the one that was asked for, or its slice goes on as nothing else does.
TEST(Hyperslices, AreDrawnToldAndWritten) {
  if (!has_hdf5()) GTEST_SKIP() << "no HDF5";
  const Folder folder;
  const std::string data = tornado(folder);
  const auto render = [&](const Words& how, const std::string& name) {
    return rendered(data, folder / name, how);
  };
  EXPECT_EQ(render({"--hyperslice", "0,0,0,1,2.5"}, "a.png"), render({"--time", "2.5"}, "b.png"));
  EXPECT_EQ(facts_of(data, {"--hyperslice", "1,0,0,0,0.1"})["dims"], (json{8, 12, 12}));
  const json bcc = facts_of(
      data, {"--hyperslice", "1,0.2,0,0.3,1", "--slice-lattice", "bcc", "--slice-spacing", "0.5"});
  EXPECT_EQ(bcc["lattice"], "body-centred");
  expect_success({"convert", data, "--hyperslice", "1,1,0,0,0", "-o", folder / "cut.nrrd"});
  expect_success({"render", folder / "cut.nrrd", "-o", folder / "cut.png", "--size", "40x30"});
  const json near = facts_of(data, {"--hyperslice", "0,0,0,1,2.5", "--slice-method", "extracted"});
  EXPECT_EQ(near["kind"], "kernels");
  expect_success({"convert", data, "--hyperslice", "0,0,0,1,2.5", "--slice-method", "extracted",
                  "-o", folder / "near.ply"});
  EXPECT_EQ(facts_of(folder / "near.ply", {})["field"]["reconstruction"], "normalized");
}

// Across time a trail of slices is one of times; along x it is the mean of slices, not one of them.
TEST(Hyperslices, HaveTrails) {
  if (!has_hdf5()) GTEST_SKIP() << "no HDF5";
  const Folder folder;
  const std::string data = tornado(folder);
  const auto render = [&](const Words& how, const std::string& name) {
    return rendered(data, folder / name, how);
  };
  EXPECT_EQ(render({"--hyperslice", "0,0,0,1,5", "--motion-blur", "3,1"}, "a.png"),
            render({"--time", "5", "--motion-blur", "3,1"}, "b.png"));
  EXPECT_NE(render({"--hyperslice", "1,0,0,0,0.5", "--motion-blur", "0.8"}, "c.png"),
            render({"--hyperslice", "1,0,0,0,0.5"}, "d.png"));
}

// Fails if frames are not the slices one after the other, or a plane with an offset moves.
TEST(Hyperslices, AreAnimatedAlongTheirNormal) {
  if (!has_hdf5()) GTEST_SKIP() << "no HDF5";
  const Folder folder;
  const std::string data = tornado(folder);
  const Words look = {"--colormap",      "gray", "--opacity", "0:0,1:0.3", "--range", "0,1",
                      "--unit-distance", "0.1",  "--fit",     "box"};
  const auto animate = [&](Words how, const std::string& pattern) {
    Words words{"animate", data, "-o", folder / pattern, "--size", "40x30"};
    words.insert(words.end(), how.begin(), how.end());
    words.insert(words.end(), look.begin(), look.end());
    expect_success(words);
  };
  animate({"--hyperslice", "1,0,0,0"}, "x_%02d.png");
  EXPECT_TRUE(std::filesystem::exists(folder / "x_11.png"));  // where there are samples
  EXPECT_FALSE(std::filesystem::exists(folder / "x_12.png"));
  animate({"--hyperslice", "1,0,0,0", "--times", "-0.5:0.5:0.5"}, "y_%02d.png");
  Words alone = look;
  alone.insert(alone.end(), {"--hyperslice", "1,0,0,0,0.5"});
  expect_success(render_words(data, folder / "alone.png", alone));
  EXPECT_EQ(read_file(folder / "y_02.png"), read_file(folder / "alone.png"));
  EXPECT_NE(read_file(folder / "y_01.png"), read_file(folder / "y_02.png"));
  animate({"--hyperslice", "1,0,0,0,0.5", "--turn", "90", "--frames", "2"}, "z_%02d.png");
  EXPECT_EQ(read_file(folder / "z_00.png"), read_file(folder / "alone.png"));
}

TEST(Hyperslices, ThatMissOrContradictAreErrors) {
  if (!has_hdf5()) GTEST_SKIP() << "no HDF5";
  const Folder folder;
  const std::string data = tornado(folder);
  const auto refused = [&](const Words& how, int code, const Words& said) {
    expect_failure(render_words(data, folder / "a.png", how), code, said);
  };
  refused({"--hyperslice", "0,0,0,1,9"}, 1, {"misses the data", "0 to 7", "e = 9"});
  refused({"--hyperslice", "1,0,0,0,4"}, 1, {"misses the data"});
  refused({"--hyperslice", "0,0,0,0,4"}, 2, {"--hyperslice '0,0,0,0,4'", "not all 0"});
  refused({"--hyperslice", "0,0,0,1"}, 2, {"A,B,C,D,E", "animate"});
  refused({"--hyperslice", "0,0,1"}, 2, {"--hyperslice '0,0,1'", "5"});
  refused({"--hyperslice", "0,0,nan,1,2"}, 2, {"--hyperslice"});
  refused({"--hyperslice", "0,0,0,1,2", "--time", "2"}, 2, {"--time: contradicts --hyperslice"});
  refused({"--slice-spacing", "2"}, 2, {"--slice-spacing: has no effect without --hyperslice"});
  refused({"--hyperslice", "0,0,0,1,2", "--slice-method", "extracted", "--slice-lattice", "cc"}, 2,
          {"--slice-lattice: has no effect"});
  refused({"--hyperslice", "1,0,0,-0.2,0.1", "--motion-blur", "2"}, 1, {"across one axis"});
  refused({"--hyperslice", "0,0,0,1,2", "--slice-method", "extracted", "--motion-blur", "2"}, 1,
          {"extracted"});
  const std::string galaxy = folder / "galaxy.csv";
  expect_success({"make", "galaxy", "--count", "100", "-o", galaxy});
  expect_failure({"render", galaxy, "--hyperslice", "0,0,0,1,0", "-o", folder / "a.png"}, 1,
                 {"cartesian"});
}

// Fails if the trail is not drawn, is drawn of another time, or by another look than its own.
TEST(MotionBlur, LeavesATrail) {
  if (!has_hdf5()) GTEST_SKIP() << "no HDF5";
  const Folder folder;
  const std::string data = tornado(folder);
  const std::string look = folder / "trail.json";
  write_file(look, R"([{"Name": "t", "ColorSpace": "RGB", "RGBPoints": [0, 1, 0, 0, 1, 1, 0, 0],)"
                   R"( "Points": [0, 0, 0.5, 0, 1, 0.3, 0.5, 0]}])");
  const auto render = [&](Words how, const std::string& name) {
    how.insert(how.end(), {"--time", "4.5"});
    expect_success(render_words(data, folder / name, how));
    return read_file(folder / name);
  };
  const std::string alone = render({}, "a.png");
  const std::string blurred = render({"--motion-blur", "2"}, "b.png");
  EXPECT_NE(blurred, alone);
  EXPECT_NE(render({"--motion-blur", "2,4"}, "c.png"), blurred);
  const std::string red = render({"--motion-blur", "2", "--trail-tf", look}, "d.png");
  EXPECT_NE(red, blurred);
  // An animation's frame of that time is that picture, given the same look.
  const Words fixed{"--size", "40x30", "--range", "0,1", "--motion-blur", "2", "--fit", "box"};
  Words film{"animate", data, "-o", folder / "f_%02d.png", "--times", "4:4.5:0.5"};
  film.insert(film.end(), fixed.begin(), fixed.end());
  expect_success(film);
  Words one{"render", data, "-o", folder / "one.png", "--time", "4.5"};
  one.insert(one.end(), fixed.begin(), fixed.end());
  expect_success(one);
  EXPECT_EQ(read_file(folder / "f_01.png"), read_file(folder / "one.png"));
}

TEST(MotionBlur, ContradictionsAreErrors) {
  if (!has_hdf5()) GTEST_SKIP() << "no HDF5";
  const Folder folder;
  const std::string data = tornado(folder);
  const auto refused = [&](const Words& how, int code, const Words& said) {
    expect_failure(render_words(data, folder / "a.png", how), code, said);
  };
  refused({"--motion-blur", "0"}, 2, {"--motion-blur '0'"});
  refused({"--motion-blur", "1,2,3"}, 2, {"--motion-blur '1,2,3'", "L,DECAY"});
  refused({"--motion-blur", "1,-1"}, 2, {"--motion-blur '1,-1'"});
  refused({"--trail-tf", "x.json"}, 2, {"--trail-tf: has no effect without --motion-blur"});
  refused({"--motion-blur", "1", "--mode", "xray"}, 2, {"--motion-blur: is for --mode"});
  refused({"--motion-blur", "1", "--post-convolution", "cubic"}, 2, {"--post-convolution"});
  refused({"--motion-blur", "1", "--trail-tf", folder / "none.json"}, 1, {"none.json"});
  const std::string still = folder / "still.nrrd";
  expect_success({"make", "flat", "--size", "6", "-o", still});
  expect_failure({"render", still, "--motion-blur", "1", "-o", folder / "a.png"}, 1,
                 {"--motion-blur", "one step"});
}

// Fails if the limit is not read, or steps are not let go.
TEST(MemoryLimit, IsHeeded) {
  const Folder folder;
  expect_success({"make", "flat", "--size", "6", "-o", folder / "a.nrrd"});
  const auto render = [&](const char* limit) {
    return Words{"render", folder / "a.nrrd", folder / "a.nrrd", "-o",  folder / "a.png",
                 "--size", "10x10",           "--time",          "0.5", "--memory-limit",
                 limit};
  };
  for (const char* const good : {"1", "64K", "4G"}) expect_success(render(good));
  for (const char* const bad : {"0", "-1", "4T", "G", "1.5G", "99999999999G"})
    expect_failure(render(bad), 2, {"--memory-limit", "4G or 512M"});
}

}  // namespace slices_test
}  // namespace ovoid::cli_tests
