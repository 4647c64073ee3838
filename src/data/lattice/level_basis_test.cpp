// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/level_basis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "ovoid/error.h"
#include "ovoid/kernel_field.h"
#include "ovoid/lattice_levels.h"

namespace ovoid::data {
namespace level_basis_test {

constexpr Index3 kDims{13, 7, 5};
constexpr int kLevels = 3;

// Numbers in [-1, 1] that look random.
std::vector<float> numbers(std::size_t count, double seed = 1) {
  std::vector<float> numbers(count);
  for (std::size_t i = 0; i < count; ++i)
    numbers[i] = static_cast<float>(std::sin(seed + 12.9898 * static_cast<double>(i * i % 1009)));
  return numbers;
}

// The kernel of a node along one axis, as the header defines it.
double kernel_at(std::int64_t sample, std::int64_t node, int level) {
  const double block = std::exp2(level);
  const double middle = (static_cast<double>(node) + 0.5) * block - 0.5;
  const double blocks = std::abs(static_cast<double>(sample) - middle) / block;
  if (blocks >= LatticeLevels::kReach) return 0;
  return profile_value(KernelProfile::kGaussian, blocks / LatticeLevels::kSigma,
                       LatticeLevels::kReach / LatticeLevels::kSigma);
}

// Calls visit(node, its place) for all nodes of a level.
template <class Visit>
void visit_nodes(const LevelBasis& basis, int level, const Visit& visit) {
  const Index3 nodes = basis.nodes(level);
  std::size_t number = basis.offset(level);
  for (std::int64_t k = 0; k < nodes[2]; ++k) {
    for (std::int64_t j = 0; j < nodes[1]; ++j) {
      for (std::int64_t i = 0; i < nodes[0]; ++i) visit(number++, Index3{i, j, k});
    }
  }
}

// Fails if a node lies elsewhere, if a tap is missing at a border, or if levels are mixed up.
TEST(LevelBasis, ExpandsAsTheDefinitionSays) {
  const LevelBasis basis(kDims, kLevels);
  const std::vector<float> weights = numbers(basis.num_weights());
  std::vector<float> samples(basis.num_samples(), 2);
  basis.expand(weights, 0, kLevels, -3, samples, {2});
  std::size_t at = 0;
  for (std::int64_t z = 0; z < kDims[2]; ++z) {
    for (std::int64_t y = 0; y < kDims[1]; ++y) {
      for (std::int64_t x = 0; x < kDims[0]; ++x) {
        double expected = 2;
        for (int level = 0; level < kLevels; ++level) {
          visit_nodes(basis, level, [&](std::size_t number, const Index3& node) {
            expected -= 3 * static_cast<double>(weights[number]) * kernel_at(x, node[0], level) *
                        kernel_at(y, node[1], level) * kernel_at(z, node[2], level);
          });
        }
        EXPECT_NEAR(static_cast<double>(samples[at++]), expected, 1e-5);
      }
    }
  }
}

TEST(LevelBasis, ReduceIsTheTranspose) {
  const LevelBasis basis(kDims, kLevels);
  const std::vector<float> weights = numbers(basis.num_weights()),
                           samples = numbers(basis.num_samples(), 5);
  std::vector<float> expanded(basis.num_samples()), reduced(basis.num_weights());
  basis.expand(weights, 0, kLevels, 1, expanded, {2});
  basis.reduce(samples, 0, kLevels, reduced, {2});
  double left = 0, right = 0;
  for (std::size_t i = 0; i < samples.size(); ++i)
    left += static_cast<double>(expanded[i]) * static_cast<double>(samples[i]);
  for (std::size_t i = 0; i < weights.size(); ++i)
    right += static_cast<double>(reduced[i]) * static_cast<double>(weights[i]);
  EXPECT_NEAR(left, right, 1e-4 * std::abs(left));
}

TEST(LevelAxis, ProductsAndNormsAreSumsOverTheSamples) {
  for (const int level : {0, 1, 3}) {
    const LevelAxis axis(13, level);
    const auto products = axis.products();
    const std::vector<double> norms = axis.squared_norms();
    for (std::int64_t i = 0; i < axis.num_nodes; ++i) {
      for (std::int64_t j = 0; j < LevelAxis::kTaps && j <= i; ++j) {
        double expected = 0;
        for (std::int64_t x = 0; x < 13; ++x)
          expected += kernel_at(x, i, level) * kernel_at(x, i - j, level);
        EXPECT_NEAR(products[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)], expected,
                    1e-6);
        if (j == 0) {
          EXPECT_NEAR(norms[static_cast<std::size_t>(i)], expected, 1e-6);
        }
      }
    }
  }
}

LatticeLevels some_levels() {
  LatticeLevels levels;
  levels.dims = kDims;
  levels.offset = 4;
  levels.least = 3;
  levels.greatest = 6;
  levels.step = 0.5;
  levels.levels = {{{0, 17, 454}, {8, -9, 1}}, {{3}, {12}}, {{1, 7}, {-20, 30}}};
  return levels;
}

TEST(LatticeLevels, AreSamplesWithinTheirBounds) {
  const LatticeLevels levels = some_levels();
  EXPECT_EQ(levels.num_kernels(), 6);
  EXPECT_EQ(levels.nodes(2), (Index3{4, 2, 2}));
  const std::vector<float> samples = samples_of(levels, 2);
  EXPECT_EQ(samples, samples_of(levels, 1));
  std::size_t at = 0, clamped = 0;
  for (std::int64_t z = 0; z < kDims[2]; ++z) {
    for (std::int64_t y = 0; y < kDims[1]; ++y) {
      for (std::int64_t x = 0; x < kDims[0]; ++x) {
        double expected = levels.offset;
        for (int l = 0; l < 3; ++l) {
          const Index3 nodes = levels.nodes(l);
          const LatticeLevel& level = levels.levels[static_cast<std::size_t>(l)];
          for (std::size_t i = 0; i < level.nodes.size(); ++i) {
            const std::int64_t node = level.nodes[i];
            expected += level.weights[i] * 0.5 * std::pow(2, -1.5 * l) *
                        kernel_at(x, node % nodes[0], l) *
                        kernel_at(y, node / nodes[0] % nodes[1], l) *
                        kernel_at(z, node / (nodes[0] * nodes[1]), l);
          }
        }
        clamped += static_cast<std::size_t>(expected < 3 || expected > 6);
        EXPECT_NEAR(static_cast<double>(samples[at++]), std::clamp(expected, 3.0, 6.0), 1e-5);
      }
    }
  }
  EXPECT_GT(clamped, 0U);
}

TEST(LatticeLevels, RefuseWhatCannotBe) {
  const auto expect_refusal = [](const auto& change, const std::string& words) {
    LatticeLevels levels = some_levels();
    change(levels);
    try {
      samples_of(levels);
      ADD_FAILURE() << "expected: " << words;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  expect_refusal([](LatticeLevels& l) { l.dims[1] = 0; }, "dims[1] = 0");
  expect_refusal([](LatticeLevels& l) { l.holes = {1, 2, 3}; }, "holes: 3 numbers");
  expect_refusal([](LatticeLevels& l) { l.holes = {1, 2, 0, 3}; }, "holes[2] = 0: must be > 0");
  expect_refusal([](LatticeLevels& l) { l.holes = {1, 500000}; }, "holes[1] = 500000");
  expect_refusal(
      [](LatticeLevels& l) {
        l.holes = {1, 2};
        l.whole = true;
      },
      "expected none of whole samples");
  expect_refusal([](LatticeLevels& l) { l.step = 0; }, "step = 0");
  expect_refusal([](LatticeLevels& l) { l.offset = std::nan(""); }, "offset = nan");
  expect_refusal([](LatticeLevels& l) { l.least = 7; }, "least, greatest = 7, 6");
  expect_refusal([](LatticeLevels& l) { l.levels[0].nodes[2] = 455; }, "nodes[2] = 455");
  expect_refusal([](LatticeLevels& l) { l.levels[0].nodes[1] = 0; }, "nodes[1] = 0: must rise");
  expect_refusal([](LatticeLevels& l) { l.levels[1].weights.clear(); },
                 "levels[1]: 0 weights for 1 nodes");
  expect_refusal([](LatticeLevels& l) { l.levels.resize(17); }, "levels: there are 17");
}

}  // namespace level_basis_test
}  // namespace ovoid::data
