// SPDX-License-Identifier: Apache-2.0
// `ovoid render --pick`: what it tells of a pixel, as text and as JSON.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "program.h"

namespace ovoid::cli_tests {
namespace pick_test {

using Json = nlohmann::ordered_json;

class Pick : public ::testing::Test {
 protected:
  Json report(Words words) {
    const std::string path = folder_ / "picks.json";
    words.insert(words.begin(), "render");
    words.insert(words.end(), {"--pick-report", path, "--size", "40x30"});
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    return Json::parse(read_file(path));
  }

  Folder folder_;
  std::string ball_ = write_ball(folder_);
};

TEST_F(Pick, TellsInWordsAndNeedsNoPicture) {
  const Outcome told = run({"render", ball_, "--pick", "20,15", "--pick=0,0", "--size", "40x30",
                            "--length-unit", "um", "--scale-bar"});
  EXPECT_EQ(folder_.num_files(), 1U);  // the ball
  for (const char* const word : {"pixel 20,15\n", "\n  position ", " um\n", "\n  index ",
                                 "\n  gradient ", "\n  depth ", "\n  opacity "})
    EXPECT_NE(told.out.find(word), std::string::npos) << word << " in\n" << told.out;
  EXPECT_NE(told.out.find("pixel 0,0: shows nothing\n"), std::string::npos) << told.out;
}

// The picture beside it stays what it is, and both agree.
TEST_F(Pick, WritesAReportBesideThePicture) {
  const Words look = {"--mode", "isosurface", "--iso", "50"};
  const std::string path = folder_ / "x.npy";
  Words words = {ball_, "--pick", "20,15", "--pick", "39,29", "-o", path};
  words.insert(words.end(), look.begin(), look.end());
  const Json told = report(words);
  ASSERT_EQ(told["picks"].size(), 2U);
  const Json& hit = told["picks"][0];
  EXPECT_EQ(hit["pixel"], Json({20, 15}));
  EXPECT_EQ(hit["shows"], true);
  EXPECT_EQ(hit["opacity"], 1.0);
  EXPECT_NEAR(hit["value"].get<double>(), 50, 1);  // its kernels are widened where pixels are wide
  EXPECT_EQ(hit["position"].size(), 3U);
  EXPECT_EQ(hit["index"].size(), 3U);
  EXPECT_EQ(hit["gradient"].size(), 3U);
  EXPECT_FALSE(hit.contains("label"));
  EXPECT_FALSE(hit.contains("integral"));
  const Json& missed = told["picks"][1];
  EXPECT_EQ(missed["shows"], false);
  EXPECT_FALSE(missed.contains("position"));
  for (const char* const member : {"array", "unit", "length_unit", "space", "command"})
    EXPECT_TRUE(told.contains(member)) << member;
  const std::string with_picks = read_file(path);
  Words without = {"render", ball_, "-o", path, "--size", "40x30"};
  without.insert(without.end(), look.begin(), look.end());
  expect_success(without);
  EXPECT_EQ(read_file(path), with_picks);
}

// A box of label 2 within one of label 7: no label between them is ever told.
TEST_F(Pick, TellsLabels) {
  constexpr int kEdge = 24;
  std::string bytes = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 24 24 24\nencoding: raw\n\n";
  for (int k = 0; k < kEdge; ++k) {
    for (int j = 0; j < kEdge; ++j) {
      for (int i = 0; i < kEdge; ++i) {
        const int in = std::min({i, j, k, kEdge - 1 - i, kEdge - 1 - j, kEdge - 1 - k});
        bytes += static_cast<char>(in < 3 ? 0 : k < 12 ? 2 : 7);
      }
    }
  }
  const std::string path = folder_ / "labels.nrrd";
  write_file(path, bytes);
  Words words = {path, "--view", "+x", "--projection", "parallel"};
  for (int y = 6; y < 24; ++y) words.insert(words.end(), {"--pick", "20," + std::to_string(y)});
  int upper = 0, lower = 0;
  const Json told = report(words);
  for (const Json& pick : told["picks"]) {
    if (pick["shows"] == false) continue;
    ASSERT_TRUE(pick.contains("label")) << pick;
    const int label = pick["label"]["value"].get<int>();
    EXPECT_EQ(pick["label"]["name"], std::to_string(label));
    const double k = pick["index"][2].get<double>();
    if (std::abs(k - 11.5) > 0.5) {
      EXPECT_EQ(label, k < 12 ? 2 : 7) << pick;
    }
    (label == 2 ? lower : upper) += 1;
    EXPECT_TRUE(label == 2 || label == 7) << pick;
  }
  EXPECT_GT(upper, 3);
  EXPECT_GT(lower, 3);
}

TEST_F(Pick, TellsIntegralsOfXrays) {
  const Json told = report({ball_, "--mode", "xray", "--pick", "20,15", "-o", folder_ / "x.png"});
  EXPECT_GT(told["picks"][0]["integral"].get<double>(), 0);
}

TEST_F(Pick, RefusesInWords) {
  const auto refused = [&](Words words, const std::string& expected) {
    words.insert(words.begin(), {"render", ball_, "--size", "40x30"});
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    EXPECT_NE(outcome.err.find(expected), std::string::npos) << outcome.err;
  };
  refused({"--pick", "40,0"},
          "--pick 40,0: is outside of the picture of 40x30 pixels, expected "
          "0,0 to 39,29");
  refused({"--pick", "12"}, "--pick '12': expected X,Y");
  refused({"--pick", "1,-1"}, "--pick '1,-1': expected a whole number from 0");
  refused({"--pick", "1.5,2"}, "expected a whole number");
  refused({"--pick-report", "x.json", "-o", folder_ / "x.png"}, "without --pick");
  refused({"--pick", "1,1", "--dry-run"}, "--pick: needs a whole picture");
  refused({}, "--output: none given");
}

}  // namespace pick_test
}  // namespace ovoid::cli_tests
