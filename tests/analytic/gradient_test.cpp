// SPDX-License-Identifier: Apache-2.0
// A linear field has one gradient everywhere. The kernels' own derivative does not know that; the
// corrected one must.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "render/reference/field_evaluator.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace gradient_test {

// World = oblique, anisotropic, left-handed image of index space.
LatticeGeometry leaning_lattice() {
  LatticeGeometry geometry;
  geometry.dims = {14, 13, 12};
  geometry.world_from_index.linear() << 1.0, 0.2, 0.0, 0.0, 1.7, -0.3, 0.1, 0.0, -0.8;
  geometry.world_from_index.translation() << 5, -3, 40;
  return geometry;
}

class GradientOn : public ::testing::TestWithParam<LatticeKind> {};

TEST_P(GradientOn, RampIsConstantOnceCorrected) {
  LatticeGeometry geometry = leaning_lattice();
  geometry.kind = GetParam();
  geometry.dims[2] *= geometry.num_sublattices();
  const Vec3 slope(0.7, -1.3, 2.1);
  FunctionSource::Options options;
  const auto ramp = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return slope.dot(geometry.world_from_index * geometry.index_position({i, j, k}));
  };
  const LatticeField field(std::make_shared<FunctionSource>(geometry, ramp, options), {},
                           Reconstruction::kNormalized);
  const reference::FieldEvaluator evaluator(field);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(3.0, 8.0);  // every tap exists
  double worst_exact = 0;
  for (int n = 0; n < 200; ++n) {
    const Vec3 position(place(random), place(random), place(random));
    const auto sample = evaluator.at_index(position);
    ASSERT_TRUE(sample.is_defined);
    const Vec3 corrected = evaluator.corrected_gradient(sample.gradient, position, Vec3::Ones());
    // Samples are floats: 2^-24 of values up to 100, over spacings of about one.
    EXPECT_LT((corrected - slope).norm(), 1e-4) << position.transpose();
    worst_exact = std::max(worst_exact, (sample.gradient - slope).norm() / slope.norm());
  }
  // 1 - 2 e^-2 (1 + 4 e^-6) / (1 + 2 e^-2 + 2 e^-8) / sigma^2 = 0.15 at the samples: what the
  // correction is for.
  EXPECT_GT(worst_exact, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Lattices, GradientOn,
                         ::testing::Values(LatticeKind::kCartesian, LatticeKind::kBodyCentred),
                         [](const auto& test) {
                           return test.param == LatticeKind::kCartesian ? "Cartesian"
                                                                        : "BodyCentred";
                         });

}  // namespace gradient_test
}  // namespace ovoid::test
