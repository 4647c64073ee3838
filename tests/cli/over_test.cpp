// SPDX-License-Identifier: Apache-2.0
// --over: a second volume in the picture. Fails if it lies elsewhere than its files say, has
// another's look, or if what cannot be drawn is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "program.h"

namespace ovoid::cli_tests {
namespace over_test {

class OverFiles : public testing::Test {
 protected:
  void SetUp() override {
    expect_success({"make", "ball", "--size", "20", "-o", ball_});
    expect_success({"make", "gaussians", "--size", "16", "-o", spots_});
  }

  // The file with its first sample elsewhere in the world.
  std::string moved(const std::string& path, const std::string& origin, const std::string& name) {
    std::string bytes = read_file(path);
    const auto at = bytes.find("space origin: (");
    EXPECT_NE(at, std::string::npos);
    const auto end = bytes.find('\n', at);
    bytes.replace(at, end - at, "space origin: (" + origin + ")");
    write_file(folder_ / name, bytes);
    return folder_ / name;
  }
  // The same, said to be of a patient.
  std::string in_lps(const std::string& path, const std::string& name) {
    std::string bytes = read_file(path);
    const auto at = bytes.find("space dimension: 3");
    EXPECT_NE(at, std::string::npos);
    bytes.replace(at, std::string("space dimension: 3").size(), "space: left-posterior-superior");
    write_file(folder_ / name, bytes);
    return folder_ / name;
  }
  std::string text(const std::string& name, const std::string& content) {
    write_file(folder_ / name, content);
    return folder_ / name;
  }

  // The numbers of a picture.
  std::vector<float> picture(Words words) {
    const std::string out = folder_ / "picture.npy";
    words.insert(words.begin(), "render");
    for (const char* const word : {"-o", out.c_str(), "--size", "60x45", "--backend", "cpu"})
      words.emplace_back(word);
    expect_success(words);
    const std::string bytes = read_file(out);
    const std::size_t header = 10 + static_cast<unsigned char>(bytes.at(8)) +
                               256U * static_cast<unsigned char>(bytes.at(9));
    std::vector<float> numbers((bytes.size() - header) / sizeof(float));
    std::memcpy(numbers.data(), bytes.data() + header, numbers.size() * sizeof(float));
    return numbers;
  }
  static double greatest_difference(const std::vector<float>& a, const std::vector<float>& b) {
    EXPECT_EQ(a.size(), b.size());
    double greatest = 0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
      greatest = std::max(greatest, std::abs(1.0 * a[i] - b[i]));
    return greatest;
  }

  Folder folder_;
  const std::string ball_ = folder_ / "ball.nrrd";
  const std::string spots_ = folder_ / "spots.nrrd";
};

// Fails if a flag does not reach its volume.
TEST_F(OverFiles, EachFlagChangesThePicture) {
  const Words both{ball_, "--over", spots_, "--fit", "box"};
  const auto with = [&](const Words& more) {
    Words words = both;
    words.insert(words.end(), more.begin(), more.end());
    return picture(words);
  };
  const std::vector<float> plain = picture(both);
  EXPECT_GT(greatest_difference(plain, picture({ball_, "--fit", "box"})), 0.05);
  for (const Words& more :
       {Words{"--over-colormap", "viridis"}, Words{"--over-range", "0.2,0.4"},
        Words{"--over-opacity", "0.2:0,1:0.9"}, Words{"--over-preset", "cinematic"},
        Words{"--over-transform", text("m.txt", "1 0 0 0.3\n0 1 0 0\n0 0 1 0\n0 0 0 1\n")},
        Words{"--over-tf", R"([{"Name": "x", "RGBPoints": [0, 1, 0, 0, 1, 0, 1, 0]}])"}}) {
    EXPECT_GT(greatest_difference(with(more), plain), 0.01) << more[0];
  }
  // What is said of the picture's own volume is not said of the other.
  EXPECT_GT(greatest_difference(with({"--colormap", "hot"}), plain), 0.01);
}

// Fails if a placement is not what the file says, or goes the other way.
TEST_F(OverFiles, TransformMovesAsTheFilesOriginDoes) {
  // From -1 along each axis, by (0.25, -0.5, 0.125).
  const std::string elsewhere = moved(spots_, "-0.75,-1.5,-0.875", "moved.nrrd");
  const std::vector<float> expected = picture({ball_, "--over", elsewhere});
  EXPECT_GT(greatest_difference(expected, picture({ball_, "--over", spots_})), 0.05);
  const std::string matrix = text("m.txt", "1 0 0 0.25\n0 1 0 -0.5\n0 0 1 0.125\n0 0 0 1\n");
  EXPECT_TRUE(picture({ball_, "--over", spots_, "--over-transform", matrix}) == expected);
  // A registration tells where a place of the picture is in the volume.
  const std::string itk = text("m.tfm",
                               "#Insight Transform File V1.0\nTransform: "
                               "TranslationTransform_double_3_3\nParameters: -0.25 0.5 -0.125\n"
                               "FixedParameters:\n");
  EXPECT_TRUE(picture({ball_, "--over", spots_, "--over-transform", itk}) == expected);
}

// Fails if a scan in RAS is drawn over one in LPS as if both were one space.
TEST_F(OverFiles, SpacesOfPatientsAreBroughtTogether) {
  const std::string first = in_lps(ball_, "first.nrrd");
  const std::string second = in_lps(spots_, "second.nrrd");
  const std::string in_ras = folder_ / "second.nii";
  expect_success({"convert", second, "-o", in_ras});
  EXPECT_NE(run({"info", in_ras}).out.find("RAS"), std::string::npos);
  // Whose rows may run the other way, so that sums differ in their last digits.
  EXPECT_LT(
      greatest_difference(picture({first, "--over", in_ras}), picture({first, "--over", second})),
      0.02);
  // Of files that say nothing the world is taken to be the same, which is told.
  const Outcome outcome =
      run({"render", first, "--over", spots_, "-o", folder_ / "a.png", "--size", "20x20"});
  EXPECT_NE(outcome.err.find("taken to be the same world"), std::string::npos) << outcome.err;
}

TEST_F(OverFiles, LiesBeside) {
  const std::string far = moved(spots_, "5,5,5", "far.nrrd");
  const Outcome outcome =
      run({"render", ball_, "--over", far, "-o", folder_ / "a.png", "--size", "20x20"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.err.find("lies beside the others"), std::string::npos) << outcome.err;
}

// Fails if a volume that nothing is seen of is drawn all the same: then the view, the sheets and
// the light span both, and nothing of the picture's own volume is seen either.
TEST_F(OverFiles, OutOfSightIsLeftOut) {
  const std::string alone = folder_ / "alone.npy", both = folder_ / "both.npy";
  const auto drawn = [&](const std::string& file, const Words& more) {
    Words all{"render", ball_, "-o", file, "--size", "20x20", "--backend", "cpu"};
    all.insert(all.end(), more.begin(), more.end());
    const Outcome outcome = run(all);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.err;
  };
  drawn(alone, {});
  const auto matrix = [](const std::string& scale, const std::string& shift) {
    return scale + " 0 0 " + shift + "\n0 " + scale + " 0 0\n0 0 " + scale + " 0\n0 0 0 1\n";
  };
  const auto left_out = [&](const std::string& transform, const std::string& word) {
    write_file(folder_ / "far.txt", transform);
    const std::string said =
        drawn(both, {"--over", spots_, "--over-transform", folder_ / "far.txt"});
    EXPECT_NE(said.find("it is left out"), std::string::npos) << said;
    EXPECT_NE(said.find(word), std::string::npos) << said;
    EXPECT_EQ(read_file(alone), read_file(both)) << transform;
  };
  left_out(matrix("1", "1e30"), "lies outside");
  left_out(matrix("1", "-1e5"), "lies outside");
  left_out(matrix("1", "1e308"), "lies outside");
  left_out(matrix("1e6", "0"), "has the size");
  left_out(matrix("1e30", "0"), "has the size");
  left_out(matrix("1e-6", "0"), "has the size");
  left_out(matrix("1e-30", "0"), "has the size");
}

TEST_F(OverFiles, LabelsOutsideOfTheDataAreTold) {
  const std::string map = folder_ / "map.nrrd";
  expect_success({"make", "head-labels", "--size", "16", "--type", "uint8", "-o", map});
  const auto said = [&](const std::string& path) {
    return run({"render", ball_, "--labels", path, "--size", "20x20", "-o", folder_ / "p.png"}).err;
  };
  EXPECT_EQ(said(map).find("lies outside"), std::string::npos);
  EXPECT_NE(said(moved(map, "5,5,5", "far.nrrd")).find("lies outside of the data"),
            std::string::npos);
}

TEST_F(OverFiles, RefusesWhatCannotBeDrawn) {
  const std::string out = folder_ / "out.png";
  const auto refused = [&](const Words& more, int code, const std::string& words) {
    Words all{"render", ball_, "-o", out};
    all.insert(all.end(), more.begin(), more.end());
    expect_failure(all, code, {words});
  };
  refused({"--over-tf", "a.json"}, 2, "--over-tf: has no effect without --over");
  refused({"--over", spots_, "--over-array", "a", "--over-array", "b"}, 2,
          "--over-array: given 2 times, for 1 of --over");
  refused({"--over", spots_, "--over", spots_, "--over", spots_, "--over", spots_}, 2,
          "--over: given 4 times, expected at most 3");
  refused({"--over", spots_, "--mode", "xray"}, 2, "--over: is for --mode composite");
  refused({"--over", spots_, "--dry-run"}, 2, "--dry-run is for one volume");
  refused({"--over", folder_ / "none.nrrd"}, 1, "none.nrrd");
  refused({"--over", spots_, "--over-transform", text("m.txt", "1 2 3")}, 1,
          "--over-transform: '" + (folder_ / "m.txt") + "': has 3 numbers");
  const std::string points = text("p.csv", "x,y,z,v\n0,0,0,1\n1,0,0,2\n0,1,1,3\n");
  refused({"--over", points}, 1, "--over: is for lattices");
  expect_failure({"render", points, "-o", out, "--over", spots_}, 1, {"--over: is for lattices"});
  expect_failure({"render", ball_, "-o", spots_, "--over", spots_}, 2, {"--output"});
}

TEST_F(OverFiles, Animates) {
  const std::string frames = folder_ / "frame_%02d.png";
  expect_success({"animate", ball_, "--over", spots_, "-o", frames, "--turn", "90", "--frames", "2",
                  "--size", "40x30"});
  const std::string one = read_file(folder_ / "frame_00.png");
  EXPECT_FALSE(one.empty());
  const std::string alone = folder_ / "alone_%02d.png";
  expect_success(
      {"animate", ball_, "-o", alone, "--turn", "90", "--frames", "2", "--size", "40x30"});
  EXPECT_FALSE(read_file(folder_ / "alone_00.png") == one);
}

}  // namespace over_test
}  // namespace ovoid::cli_tests
