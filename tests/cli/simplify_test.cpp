// SPDX-License-Identifier: Apache-2.0
// `ovoid simplify` on the command line. Fails if a flag does not reach the library, if what is
// written is not read as the scan is, or if what cannot be leaves a file.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "program.h"

namespace ovoid::cli_tests {
namespace simplify_test {

using nlohmann::json;

class Simplify : public testing::Test {
 protected:
  void SetUp() override {
    expect_success({"make", "head", "--size", "40", "--type", "uint8", "-o", head_});
    if (run({"simplify", head_, "-o", boxes_}).err.find("HDF5") != std::string::npos)
      GTEST_SKIP() << "this build has no HDF5";
  }

  json report(Words words) {
    const std::string file = folder_ / "report.json";
    words.insert(words.begin(), {"simplify", head_, "-o", boxes_, "--report", file});
    expect_success(words);
    return json::parse(read_file(file));
  }

  Folder folder_;
  std::string head_ = folder_ / "head.nii", boxes_ = folder_ / "boxes.h5";
};

TEST_F(Simplify, ScansBecomeBoxes) {
  const Outcome told = run({"simplify", head_, "-o", boxes_, "--tolerance", "2%"});
  ASSERT_EQ(told.exit_code, 0) << told.err;
  for (const char* const word :
       {"primitives ", " relevant samples of 64000: 1 / ", "bytes ", "PSNR ", "greatest error "})
    EXPECT_NE(told.out.find(word), std::string::npos) << told.out;
  const Outcome info = run({"info", boxes_});
  EXPECT_NE(info.out.find("HDF5 lattice, boxes"), std::string::npos) << info.out << info.err;
  EXPECT_NE(info.err.find("is stored as boxes: "), std::string::npos) << info.err;
  EXPECT_GT(draw(folder_, {boxes_}).num_covered(), 100U);
}

// Without loss the picture is the scan's, byte for byte.
TEST_F(Simplify, NothingIsLostWithoutATolerance) {
  EXPECT_EQ(report({"--tolerance", "0"})["greatest_error"], 0);
  EXPECT_EQ(draw(folder_, {boxes_}).rgba, draw(folder_, {head_}).rgba);
}

TEST_F(Simplify, FlagsReachTheSearch) {
  const auto primitives = [&](const Words& words) {
    return report(words)["primitives"].get<int>();
  };
  const int boxes = primitives({"--tolerance", "1%"});
  const int ramps = primitives({"--tolerance", "1%", "--primitive", "ramp"});
  const int fewest = primitives({"--tolerance", "1%", "--primitive", "ramp", "--search", "fewest"});
  const int constants = primitives({"--tolerance", "1%", "--primitive", "constant"});
  EXPECT_LT(boxes, ramps);
  EXPECT_LE(fewest, ramps);
  EXPECT_LT(ramps, constants);
  EXPECT_LT(primitives({"--tolerance", "4"}), boxes);
  EXPECT_GT(primitives({"--tolerance", "1%", "--rms", "0.2"}), boxes);
  const json some = report({"--relevant-above", "120"});
  EXPECT_LT(some["relevant"].get<int>(), report({})["relevant"].get<int>());
  EXPECT_LE(some["greatest_error"].get<double>(), some["tolerance"].get<double>());
}

TEST_F(Simplify, RefusesWhatCannotBe) {
  const std::string other = folder_ / "other.h5", points = folder_ / "points.csv";
  expect_failure({"simplify", head_}, 2, {"--output: none given"});
  expect_failure({"simplify", head_, "-o", folder_ / "b.nrrd"}, 2, {".h5"});
  expect_failure({"simplify", head_, "-o", other, "--tolerance", "-1"}, 2, {"--tolerance"});
  expect_failure({"simplify", head_, "-o", other, "--tolerance", "101%"}, 2, {"--tolerance"});
  expect_failure({"simplify", head_, "-o", other, "--rms", "0"}, 2, {"--rms"});
  expect_failure({"simplify", head_, "-o", other, "--search", "fewest"}, 2,
                 {"is for --primitive constant or ramp"});
  expect_success({"make", "galaxy", "--count", "100", "-o", points});
  expect_failure({"simplify", points, "-o", other}, 1, {"is for lattices", "ovoid fit"});
  EXPECT_FALSE(std::filesystem::exists(other));
  expect_failure({"simplify", head_, "-o", "/dev/full"}, 2, {".h5"});
}

}  // namespace simplify_test
}  // namespace ovoid::cli_tests
