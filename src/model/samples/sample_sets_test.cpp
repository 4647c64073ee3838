// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "model/samples/sample_sets.h"
#include "ovoid/error.h"
#include "ovoid/model.h"

namespace ovoid::model {
namespace sample_sets_test {

std::string sample_refusal(const std::string& name, const MakeOptions& options) {
  try {
    make_sample(name, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(SampleSets, EveryNameMakesItsKind) {
  for (const SampleSet& set : sample_sets()) {
    SCOPED_TRACE(set.name);
    EXPECT_NE(describe_sample(set.name).find(std::to_string(set.default_count)), std::string::npos);
    const Dataset one = make_sample(set.name, {.count = 2000});
    const Dataset again = make_sample(set.name, {.count = 2000});
    const Dataset other = make_sample(set.name, {.seed = 2, .count = 2000});
    EXPECT_NEAR(static_cast<double>(one.num_positions()), 2000, 200);
    const auto& bytes = one.positions.bytes.view;
    EXPECT_EQ(std::memcmp(bytes.data(), again.positions.bytes.view.data(), bytes.size()), 0);
    EXPECT_NE(std::memcmp(bytes.data(), other.positions.bytes.view.data(), bytes.size()), 0);
    KernelModelReport report;
    const Dataset usual = make_sample(set.name);
    KernelModelOptions options;
    options.is_density = draws_density(usual);
    EXPECT_NO_THROW(make_kernel_field(usual, options, &report));
    EXPECT_EQ(report.num_kernels, usual.num_positions());
    EXPECT_EQ(report.notes, std::vector<std::string>());  // no cell inside out, nothing missing
    EXPECT_NO_THROW(make_kernel_field(make_sample(set.name, {.count = set.least_count})));
  }
}

TEST(SampleSets, RefusesWhatDoesNotApply) {
  EXPECT_NE(sample_refusal("fin", {.size = {9, 9, 9}}).find("'fin' is no lattice"),
            std::string::npos);
  EXPECT_NE(sample_refusal("fin", {.count = 3}).find("count = 3: must be 27"), std::string::npos);
  EXPECT_NE(sample_refusal("galaxy", {.type = ScalarType::kUInt8}).find("type = uint8"),
            std::string::npos);
  EXPECT_NE(sample_refusal("box", {.count = 3}).find("'box' is a lattice"), std::string::npos);
  EXPECT_NE(sample_refusal("nothing", {}).find("fin, galaxy, blobs"), std::string::npos);
}

}  // namespace sample_sets_test
}  // namespace ovoid::model
