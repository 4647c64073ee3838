// SPDX-License-Identifier: Apache-2.0
// Lattices of all kinds by the program: made, converted, cut in time and drawn.
#include <gtest/gtest.h>
#ifdef OVOID_IO_HDF5
#include <hdf5.h>
#endif

#include "program.h"

namespace ovoid::cli_tests {
namespace lattice_test {

using nlohmann::json;

// Fails if counts, kinds or spacings are not those of the lattice that was asked for.
TEST(Lattices, AreMadeConvertedAndDrawn) {
  if (!has_hdf5()) GTEST_SKIP() << "no HDF5";
  const Folder folder;
  const std::string cube = folder / "cube.nrrd", body = folder / "body.h5";
  expect_success({"make", "gaussians", "--size", "24", "-o", cube});
  expect_success({"convert", cube, "--lattice", "bcc", "-o", body});
  const json facts = facts_of(body);
  EXPECT_EQ(facts["lattice"], "body-centred");
  EXPECT_EQ(facts["dims"], (json{17, 17, 34}));
  EXPECT_NEAR(facts["spacing"][0].get<double>(), 2.0 / 23, 1e-6);
  expect_success({"make", "gaussians", "--size", "24", "--lattice", "bcc", "-o", body});
  EXPECT_EQ(facts_of(body)["dims"], (json{17, 17, 34}));
  expect_success(
      {"convert", cube, "--lattice", "cc", "--lattice-spacing", "2", "-o", cube + "2.nrrd"});
  EXPECT_EQ(facts_of(cube + "2.nrrd")["dims"], (json{13, 13, 13}));
  expect_success({"render", body, "-o", folder / "a.png", "--size", "40x30"});
  expect_success({"render", body, "-o", folder / "b.png", "--size", "40x30", "--crop", "4:12,,"});
  expect_failure({"convert", body, "-o", folder / "a.nrrd"}, 1, {"body-centred", ".h5"});
  expect_failure({"convert", body, "--lattice", "bcc", "-o", folder / "a.h5"}, 1, {"cartesian"});
  expect_failure({"render", body, "--prefilter", "--kernel", "gaussian:2", "-o", folder / "a.png"},
                 1, {"kernel gaussian, sigma = 2"});
}

// Fails if a file in time has other steps or times than were asked for, or a time between steps is
// not a lattice like any other.
TEST(Lattices, InTimeAreCutAnywhere) {
  if (!has_hdf5()) GTEST_SKIP() << "no HDF5";
  const Folder folder;
  const std::string halves = folder / "d.h5", steps = folder / "c.h5", again = folder / "e.h5";
  const Words common{"make", "tornado", "--size", "12", "--steps", "5"};
  const auto made = [&](const char* kind, const std::string& path) {
    Words words = common;
    words.insert(words.end(), {"--lattice", kind, "-o", path});
    expect_success(words);
  };
  made("d4star", halves);
  made("cc4", steps);
  EXPECT_EQ(facts_of(steps)["steps"], 5);
  EXPECT_EQ(facts_of(halves)["steps"], 6);
  EXPECT_EQ(facts_of(halves)["lattice"], "body-centred");
  EXPECT_EQ(facts_of(halves, {"--step", "1"})["lattice"], "cartesian");
  expect_success({"convert", steps, "--lattice", "d4star", "-o", again});
  EXPECT_EQ(facts_of(again)["steps"], 6);
  for (const std::string& path : {halves, steps, again})
    expect_success({"render", path, "--time", "2.3", "-o", folder / "a.png", "--size", "40x30"});
  for (const char* const filter : {"four-steps", "two-steps", "gaussian", "exact"}) {
    expect_success({"render", halves, "--time", "1.1", "--time-filter", filter, "-o",
                    folder / (std::string(filter) + ".npy"), "--size", "24x20"});
  }
  expect_success({"convert", steps, "--time", "2.3", "-o", again});
  EXPECT_EQ(facts_of(again)["times"], (json{2.3}));
  EXPECT_NE(read_file(folder / "two-steps.npy"), read_file(folder / "exact.npy"));
  expect_success(
      {"animate", halves, "-o", folder / "f_%d.png", "--frames", "3", "--size", "24x20"});
  expect_failure({"render", halves, "--time", "9", "-o", folder / "a.png"}, 1,
                 {"time = 9", "0 to"});
  expect_failure({"render", steps, "--time", "nan", "-o", folder / "a.png"}, 2, {"--time"});
}

// Fails if a lattice in time loses steps or samples when its samples are stored as runs.
TEST(Lattices, InTimeAreStoredAsRuns) {
  if (!has_hdf5()) GTEST_SKIP() << "no HDF5";
  const Folder folder;
  const std::string halves = folder / "d.h5";
  expect_success(
      {"make", "tornado", "--size", "12", "--steps", "5", "--lattice", "d4star", "-o", halves});
  const auto picture = [&](const std::string& path, const Words& when) {
    Words words{"render", path, "--range", "0,1", "-o", folder / "a.npy", "--size", "24x20"};
    words.insert(words.end(), when.begin(), when.end());
    expect_success(words);
    return read_file(folder / "a.npy");
  };
  for (const Words& how : {Words{}, Words{"--lattice", "d4star"}}) {
    const std::string runs = folder / "r.h5";
    Words words{"convert", halves, "--relevant-above", "-1", "-o", runs};
    words.insert(words.end(), how.begin(), how.end());
    expect_success(words);
    EXPECT_EQ(facts_of(runs)["steps"], 6);
    EXPECT_EQ(facts_of(runs)["times"], facts_of(halves)["times"]);
    EXPECT_EQ(facts_of(runs)["lattice"], "body-centred");
    for (const Words& when : {Words{"--time", "2.3"}, Words{"--step", "3"}})
      EXPECT_EQ(picture(runs, when), picture(halves, when)) << when[1];
  }
  const std::string few = folder / "f.h5";
  expect_success({"convert", halves, "--relevant-above", "0.3", "-o", few});
  EXPECT_EQ(facts_of(few)["steps"], 6);
  EXPECT_NE(picture(few, {"--time", "2.3"}), picture(halves, {"--time", "2.3"}));
}

// Fails if a flag that cannot be obeyed is passed over, or something is written all the same.
#ifdef OVOID_IO_HDF5
// Fails if the time of a step is taken from a list that the file does not have.
TEST(Lattices, HalvesInTimeNeedNoTimes) {
  const Folder folder;
  const std::string halves = folder / "halves.h5";
  expect_success(
      {"make", "tornado", "--size", "8", "--steps", "4", "--lattice", "d4star", "-o", halves});
  const hid_t file = H5Fopen(halves.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  ASSERT_GE(H5Ldelete(file, "times", H5P_DEFAULT), 0);
  H5Fclose(file);
  EXPECT_EQ(facts_of(halves)["lattice"], "body-centred");
  expect_success({"render", halves, "-o", folder / "a.png", "--size", "32x24"});
  expect_success({"render", halves, "--time", "1.5", "-o", folder / "a.png", "--size", "32x24"});
}
#endif

TEST(Lattices, WhatCannotBeIsRefused) {
  const Folder folder;
  const std::string cube = folder / "cube.nrrd", out = folder / "out.h5";
  expect_success({"make", "flat", "--size", "6", "-o", cube});
  expect_failure({"convert", cube, "--lattice", "fcc", "-o", out}, 2, {"--lattice", "bcc"});
  expect_failure({"convert", cube, "--lattice-spacing", "2", "-o", out}, 2, {"without --lattice"});
  expect_failure({"convert", cube, "--lattice", "d4star", "-o", cube + ".vti"}, 2, {".h5"});
  expect_failure({"convert", cube, "--lattice", "d4star", "-o", out}, 1, {"one step"});
  expect_failure({"convert", cube, "--lattice", "bcc", "--size", "4", "-o", out}, 2, {"--size"});
  expect_failure({"make", "flat", "--lattice", "d4star", "-o", out}, 2, {"does not move"});
  expect_failure({"make", "tornado", "--steps", "3", "-o", cube + ".nrrd"}, 2, {".h5"});
  expect_failure({"make", "galaxy", "--lattice", "bcc", "-o", folder / "a.csv"}, 2, {"no lattice"});
  EXPECT_FALSE(std::filesystem::exists(out));
}

// Fails if a sample is dropped that the look's picture takes.
TEST(RelevantSamples, OfALookLeaveItsPictureAsItIs) {
  if (!has_hdf5()) GTEST_SKIP() << "no HDF5";
  const Folder folder;
  const std::string look = folder / "look.json", all = folder / "all.nrrd";
  write_file(look,
             R"([{"Name": "t", "ColorSpace": "RGB", "RGBPoints": [0, 0, 0, 1, 255, 1, 1, 0],)"
             R"( "Points": [0, 0, 0.5, 0, 120, 0, 0.5, 0, 200, 0.6, 0.5, 0, 255, 0.2, 0.5, 0]}])");
  for (const char* const lattice : {"cc", "bcc"}) {
    const std::string some = folder / (std::string(lattice) + ".h5");
    const std::string whole = folder / (std::string("whole_") + lattice + ".h5");
    expect_success({"make", "gaussians", "--size", "32", "--type", "uint8", "--lattice", lattice,
                    "-o", whole});
    expect_success({"convert", whole, "--relevant-tf", look, "-o", some});
    for (const char* const kernel : {"gaussian", "catmull-rom"}) {
      const Picture expected = draw(folder, {whole, "--tf", look, "--kernel", kernel});
      EXPECT_EQ(draw(folder, {some, "--tf", look, "--kernel", kernel}).rgba, expected.rgba);
    }
    // The same in memory, of the samples themselves.
    const std::string above = folder / (std::string("above_") + lattice + ".h5");
    expect_success({"convert", whole, "--relevant-above", "120", "-o", above});
    EXPECT_EQ(draw(folder, {whole, "--tf", look, "--relevant-above", "120"}).rgba,
              draw(folder, {above, "--tf", look, "--kernel", "gaussian"}).rgba);
  }
  write_file(look, R"([{"Name": "t", "ColorSpace": "RGB", "RGBPoints": [0, 0, 0, 1, 255, 1, 1, 0],)"
                   R"( "Points": [0, 0.1, 0.5, 0, 255, 0.2, 0.5, 0]}])");
  const std::string whole = folder / "whole_cc.h5", out = folder / "a.h5";
  expect_failure({"convert", whole, "--relevant-tf", look, "-o", out}, 1, {"shows even the least"});
  expect_failure({"convert", whole, "--relevant-tf", look, "--relevant-above", "1", "-o", out}, 2,
                 {"contradicts"});
  expect_failure({"convert", whole, "--relevant-tf", look, "-o", all}, 2, {"only .h5 does"});
  expect_failure({"convert", whole, "--background-value", "1", "-o", out}, 2, {"has no effect"});
  expect_failure({"render", whole, "--relevant-above", "9", "--prefilter", "-o", folder / "a.png"},
                 2, {"contradicts"});
}

}  // namespace lattice_test
}  // namespace ovoid::cli_tests
