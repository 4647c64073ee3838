// SPDX-License-Identifier: Apache-2.0
#include "view/plan/relevance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "render/reference/field_evaluator.h"
#include "support/volumes.h"

namespace ovoid::view {
namespace relevance_test {

RelevanceMap filled(const LatticeField& field, const MayMatter& may_matter, double widening = 1,
                    int grow = 0) {
  RelevanceMap map(field, widening, grow);
  for (int layer = 0; layer < map.num_layers(); ++layer) map.fill_layer(layer, may_matter);
  map.finish();
  return map;
}

bool relevant(const RelevanceMap& map, const Index3& brick) {
  const auto word = static_cast<std::size_t>(
      (brick[2] * map.num_bricks()[1] + brick[1]) * map.words_per_row() + (brick[0] >> 5));
  return ((map.words()[word] >> (brick[0] & 31)) & 1U) != 0;
}

// One bright sample among zeros: only the bricks its kernel reaches, (2 or 3 along each axis).
LatticeField one_bright_sample(const Index3& dims, const Index3& bright, int edge,
                               Reconstruction reconstruction = Reconstruction::kNormalized) {
  test::FieldSetup setup;
  setup.brick_edge = edge;
  setup.reconstruction = reconstruction;
  return test::make_field(
      dims,
      [bright](std::int64_t i, std::int64_t j, std::int64_t k) {
        return Index3{i, j, k} == bright ? 1.0 : 0.0;
      },
      setup);
}

constexpr auto kAboveHalf = [](float, float hi) { return hi > 0.5F; };

// Sample 18 with reach 2 brings its value to the bricks of [16, 24) and, from 16 on, of [8, 16): a
// cell that only its closed face touches counts. Fails if bits are at the wrong brick.
TEST(RelevanceMap, MarksTheBricksThatAreReached) {
  const LatticeField field = one_bright_sample({300, 40, 24}, {290, 20, 4}, 8);
  const RelevanceMap map = filled(field, kAboveHalf);
  EXPECT_EQ(map.num_bricks(), (Index3{38, 5, 3}));
  EXPECT_EQ(map.words_per_row(), 2);
  EXPECT_EQ(map.brick_shift(), 3);
  // 288..292 is in brick 36 alone, but for its face: 35 ends at 288. 18..22 in brick 2; 2..6 in 0.
  EXPECT_TRUE(relevant(map, {36, 2, 0}));
  EXPECT_FALSE(relevant(map, {34, 2, 0}));
  EXPECT_FALSE(relevant(map, {37, 2, 0}));
  EXPECT_FALSE(relevant(map, {36, 1, 0}));
  EXPECT_FALSE(relevant(map, {36, 3, 0}));
  EXPECT_FALSE(relevant(map, {36, 2, 1}));
  EXPECT_LE(map.num_relevant(), 2);
}

// Fails if the box of a question misses a brick it touches, by the coarse bits or the fine ones.
TEST(RelevanceMap, AnyInABox) {
  const LatticeField field = one_bright_sample({300, 40, 24}, {292, 20, 4}, 8);
  const RelevanceMap map = filled(field, kAboveHalf);  // brick (36, 2, 0): from 288, 16, 0 on
  const auto any_in = [&](const Vec3& lo, const Vec3& hi) { return map.any_in(lo, hi); };
  EXPECT_TRUE(any_in({0, 0, 0}, {300, 40, 24}));
  EXPECT_TRUE(any_in({288.5, 17, 1}, {288.6, 17.1, 1.1}));
  EXPECT_TRUE(any_in({280, 10, -50}, {288.5, 16.5, -40}));  // outer bricks have no end
  EXPECT_FALSE(any_in({0, 0, 0}, {279, 40, 24}));
  EXPECT_FALSE(any_in({297, 0, 0}, {1000, 40, 24}));
  EXPECT_FALSE(any_in({288, 24.5, 0}, {300, 40, 24}));
  EXPECT_FALSE(any_in({288, 16, 8.5}, {300, 40, 24}));
}

// Fails if widened kernels, which reach farther than the source's ranges know, or `grow` bricks are
// forgotten.
TEST(RelevanceMap, Dilates) {
  const LatticeField field = one_bright_sample({64, 64, 64}, {36, 36, 36}, 8);
  const RelevanceMap plain = filled(field, kAboveHalf);
  EXPECT_EQ(plain.num_relevant(), 1);
  const RelevanceMap grown = filled(field, kAboveHalf, 1, 1);
  EXPECT_EQ(grown.num_relevant(), 27);
  EXPECT_TRUE(relevant(grown, {3, 5, 4}));
  const RelevanceMap widened = filled(field, kAboveHalf, 6);  // reach 12: 10 more, two bricks
  EXPECT_EQ(widened.num_relevant(), 125);
}

TEST(RelevanceMap, Everything) {
  RelevanceMap map(one_bright_sample({20, 20, 20}, {3, 3, 3}, 8), 1, 0);
  map.fill_everything();
  map.finish();
  EXPECT_TRUE(map.any_in({18, 18, 18}, {19, 19, 19}));
}

// Fails if a value the field takes in a brick is outside the bounds its relevance was judged by,
// for sums (whose weights add up to more than 1) and mixed signs too.
TEST(RelevanceMap, BoundsHoldTheField) {
  for (const Reconstruction reconstruction : {Reconstruction::kNormalized, Reconstruction::kSum}) {
    for (const LatticeKernel kernel :
         {LatticeKernel{0.5, 4}, LatticeKernel{0.3, 5}, LatticeKernel{1, 3}}) {
      test::FieldSetup setup;
      setup.kernel = kernel;
      setup.reconstruction = reconstruction;
      const LatticeField field = test::make_field(
          {17, 10, 9},
          [](std::int64_t i, std::int64_t j, std::int64_t k) {
            return std::sin(static_cast<double>(3 * i + 5 * j + 7 * k)) + 0.3;
          },
          setup);
      const reference::FieldEvaluator evaluator(field);
      for (int bx = 0; bx < 3; ++bx) {
        for (int n = 0; n < 300; ++n) {
          const auto part = [n](double irrational) {
            return 7.99 * std::fmod(n * irrational, 1.0);
          };
          const Vec3 u(8 * bx + part(0.618034), part(0.414214), part(0.732051));
          const reference::FieldSample sample = evaluator.at_index(u);
          if (!sample.is_defined) continue;
          const RelevanceMap map = filled(field, [&](float lo, float hi) {
            return static_cast<double>(lo) <= sample.value &&
                   sample.value <= static_cast<double>(hi);
          });
          ASSERT_TRUE(relevant(map, {bx, 0, 0})) << sample.value;
        }
      }
    }
  }
}

}  // namespace relevance_test
}  // namespace ovoid::view
