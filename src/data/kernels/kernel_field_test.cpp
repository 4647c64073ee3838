// SPDX-License-Identifier: Apache-2.0
#include "ovoid/kernel_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "data/kernels/kernel_shape.h"
#include "ovoid/error.h"

namespace ovoid {
namespace kernel_field_test {

using testing::HasSubstr;

// Columns that own their numbers.
struct Kernels {
  std::vector<double> centers;
  std::vector<float> shapes, weights, values;
  KernelShape shape = KernelShape::kBalls;

  KernelColumns columns() const {
    KernelColumns result;
    result.shape = shape;
    result.centers = centers;
    result.shapes = shapes;
    result.weights = weights;
    result.values = {values};
    result.attributes = {{.name = "value", .unit = "", .range = {}}};
    return result;
  }
  std::shared_ptr<const KernelSource> source() const { return make_kernel_source(columns()); }
};

Kernels random_balls(std::size_t count, double offset, double least, double greatest) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> place(0, 1);
  Kernels set;
  for (std::size_t i = 0; i < count; ++i) {
    for (int a = 0; a < 3; ++a) set.centers.push_back(offset + place(random));
    set.shapes.push_back(static_cast<float>(least * std::pow(greatest / least, place(random))));
    set.weights.push_back(static_cast<float>(0.5 + place(random)));
    set.values.push_back(static_cast<float>(i));
  }
  return set;
}

// Balls at the samples of a lattice of spacing 1, with the weight that makes their sum about 1.
Kernels lattice_balls(int edge, double (*f)(const Vec3&)) {
  Kernels set;
  set.shapes = {0.5F};
  set.weights = {static_cast<float>(1 / (std::pow(2 * M_PI, 1.5) * 0.125))};
  for (int z = 0; z < edge; ++z) {
    for (int y = 0; y < edge; ++y) {
      for (int x = 0; x < edge; ++x) {
        set.centers.insert(set.centers.end(), {1.0 * x, 1.0 * y, 1.0 * z});
        set.values.push_back(static_cast<float>(f(Vec3(x, y, z))));
      }
    }
  }
  return set;
}

std::string error_of(const KernelColumns& columns) {
  try {
    make_kernel_source(columns);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    return error.what();
  }
  return "none";
}

// Every kernel is in one brick, where its offset gives back its place: fails if bricks mix up
// columns, lose kernels, or are too large for float offsets.
void expect_bricks_hold_all(const Kernels& set) {
  const auto source = set.source();
  std::set<int> seen;
  for (std::int64_t b = 0; b < source->num_bricks(); ++b) {
    const KernelBrick& brick = source->brick(b);
    const KernelView view = source->acquire(b, 0);
    ASSERT_EQ(view.count, brick.count);
    ASSERT_LE(brick.count, KernelBrick::kMaxBrickKernels);
    for (std::int32_t i = 0; i < view.count; ++i) {
      const auto k = static_cast<std::size_t>(view.value[0][i]);
      ASSERT_TRUE(seen.insert(static_cast<int>(k)).second);
      const float sigma = view.shape[0][i];
      ASSERT_EQ(sigma, set.shapes[k]);
      ASSERT_EQ(view.weight[i], set.weights[k]);
      const Vec3 at(set.centers[3 * k], set.centers[3 * k + 1], set.centers[3 * k + 2]);
      const Vec3 stored = brick.origin + data::offset_of(view, i);
      ASSERT_LE((stored - at).norm(), 2 * KernelBrick::kMaxOffsetError * brick.least_sigma);
      ASSERT_TRUE(brick.support.contains(at));
      ASSERT_LE(brick.least_sigma, sigma);
      ASSERT_GE(brick.greatest_sigma, sigma);
    }
  }
  EXPECT_EQ(seen.size(), set.values.size());
}

TEST(KernelSource, BricksHoldEveryKernelOnce) {
  expect_bricks_hold_all(random_balls(5000, 0, 0.01, 0.02));
}
TEST(KernelSource, RadiiOfEightDecadesKeepTheirPlaces) {
  expect_bricks_hold_all(random_balls(5000, 0, 1e-8, 2e-2));
}
TEST(KernelSource, LargeCoordinatesKeepTheirPlaces) {
  expect_bricks_hold_all(random_balls(2000, 5e6, 1e-3, 1e-2));
}
TEST(KernelSource, ManyKernelsMayShareAPlace) {
  Kernels set = random_balls(1000, 0, 0.1, 0.1);
  std::fill(set.centers.begin(), set.centers.end(), 3.0);
  expect_bricks_hold_all(set);
}

TEST(KernelSource, IsAsLeanAsPromised) {
  const Kernels balls = random_balls(100000, 0, 0.01, 0.011);
  EXPECT_LE(static_cast<double>(balls.source()->resident_bytes()), 25.0 * 100000);
  Kernels shared = balls;
  shared.weights.resize(1);
  EXPECT_LE(static_cast<double>(shared.source()->resident_bytes()), 24.0 * 100000);
  Kernels ellipsoids = balls;
  ellipsoids.shape = KernelShape::kEllipsoids;
  ellipsoids.shapes.clear();
  for (int i = 0; i < 100000; ++i)
    ellipsoids.shapes.insert(ellipsoids.shapes.end(), {0.01F, 0.001F, 0.011F, 0.0F, 0.0F, 0.01F});
  EXPECT_LE(static_cast<double>(ellipsoids.source()->resident_bytes()), 48.0 * 100000);
}

TEST(KernelSource, NamesWhatIsWrong) {
  const Kernels good = random_balls(10, 0, 0.1, 0.2);
  Kernels bad = good;
  bad.shapes[3] = -0.2F;
  EXPECT_THAT(error_of(bad.columns()), HasSubstr("shapes[3][0] = -0.2: must be finite and > 0"));
  bad = good;
  bad.centers[7] = std::nan("");
  EXPECT_THAT(error_of(bad.columns()), HasSubstr("centers[2][1] = nan: must be finite"));
  bad = good;
  bad.weights[9] = 0;
  EXPECT_THAT(error_of(bad.columns()), HasSubstr("weights[9] = 0: must be > 0"));
  bad = good;
  bad.values.pop_back();
  EXPECT_THAT(error_of(bad.columns()),
              HasSubstr("values[0]: 9 numbers, expected one for each of 10"));
  EXPECT_THAT(error_of(Kernels().columns()), HasSubstr("centers: empty"));
  KernelColumns cut = good.columns();
  cut.cutoff = 0.5;
  EXPECT_THAT(error_of(cut), HasSubstr("cutoff = 0.5: must be from 1 to 16"));
}

TEST(KernelField, SamplesALatticesSpacingByDefault) {
  const KernelField field(lattice_balls(6, [](const Vec3& p) { return p.x(); }).source(),
                          Reconstruction::kNormalized);
  EXPECT_DOUBLE_EQ(field.default_sampling_distance(), 1.0);
  EXPECT_TRUE(field.world_bounds().isApprox(Bounds3(Vec3::Constant(-0.5), Vec3::Constant(5.5))));
}

// The sum of the lattice's kernels ripples between the two values of METHOD's table, over its mean.
TEST(KernelSampler, SumsALatticesBallsToTheKnownRipple) {
  const Kernels balls = lattice_balls(8, [](const Vec3&) { return 1.0; });
  KernelColumns columns = balls.columns();
  columns.cutoff = 7;  // the table's kernels have no end
  const KernelSampler sampler(KernelField(make_kernel_source(columns), Reconstruction::kSum));
  const double integral = std::pow(2 * M_PI, 1.5) * 0.125;
  EXPECT_NEAR(sampler.at(Vec3(3, 3, 3)).value * integral, 2.0536, 2e-3);
  EXPECT_NEAR(sampler.at(Vec3(3.5, 3.5, 3.5)).value * integral, 1.8831, 2e-3);
}

TEST(KernelSampler, GradientIsTheDerivative) {
  Kernels set = random_balls(400, 0, 0.08, 0.12);
  for (std::size_t i = 0; i < set.values.size(); ++i)
    set.values[i] = static_cast<float>(std::sin(5 * set.centers[3 * i]));
  for (const KernelProfile profile : {KernelProfile::kGaussian, KernelProfile::kCubicSpline,
                                      KernelProfile::kWendlandC2, KernelProfile::kEpanechnikov}) {
    KernelColumns columns = set.columns();
    columns.profile = profile;
    for (const Reconstruction sum : {Reconstruction::kNormalized, Reconstruction::kSum}) {
      const KernelSampler sampler(KernelField(make_kernel_source(columns), sum));
      const Vec3 at(0.45, 0.55, 0.5);
      const KernelSample here = sampler.at(at);
      ASSERT_TRUE(here.is_defined);
      constexpr double kStep = 1e-6;
      for (int a = 0; a < 3; ++a) {
        const Vec3 step = kStep * Vec3::Unit(a);
        const double slope =
            (sampler.at(at + step).value - sampler.at(at - step).value) / (2 * kStep);
        EXPECT_NEAR(here.gradient[a], slope, 1e-5 * (1 + std::abs(slope))) << name_of(profile);
      }
    }
  }
}

TEST(KernelSampler, IsUndefinedWhereFewWeightsReach) {
  const KernelField field(lattice_balls(6, [](const Vec3&) { return 7.0; }).source(),
                          Reconstruction::kNormalized);
  const KernelSampler sampler(field);
  EXPECT_TRUE(sampler.at(Vec3(-0.5, 2.5, 2.5)).is_defined);  // half of the weights
  EXPECT_NEAR(sampler.at(Vec3(-0.5, 2.5, 2.5)).value, 7.0, 1e-12);
  EXPECT_FALSE(sampler.at(Vec3(-1.1, 2.5, 2.5)).is_defined);
}

// The integral of each profile, by a fine sum over shells.
TEST(KernelProfile, IntegralsAreRight) {
  for (const KernelProfile profile : {KernelProfile::kGaussian, KernelProfile::kCubicSpline,
                                      KernelProfile::kWendlandC2, KernelProfile::kEpanechnikov}) {
    for (const double cutoff : {1.0, 2.5, 4.0, 10.0}) {
      constexpr int kShells = 100000;
      double sum = 0;
      for (int i = 0; i < kShells; ++i) {
        const double r = (i + 0.5) * cutoff / kShells;
        sum += 4 * M_PI * r * r * profile_value(profile, r, cutoff) * cutoff / kShells;
      }
      EXPECT_NEAR(profile_integral(profile, cutoff) / sum, 1.0, 1e-6) << name_of(profile);
    }
  }
}

// Levels, light and surfaces see a jump at the end of a kernel as an edge of the data.
TEST(KernelProfile, EndsAreSmooth) {
  for (const KernelProfile profile : {KernelProfile::kGaussian, KernelProfile::kCubicSpline,
                                      KernelProfile::kWendlandC2, KernelProfile::kEpanechnikov}) {
    for (const double cutoff : {1.0, 3.5, 4.0}) {
      EXPECT_NEAR(profile_value(profile, cutoff, cutoff), 0, 1e-15) << name_of(profile);
      const double slope = profile_value(profile, 0.999 * cutoff, cutoff) / (0.001 * cutoff);
      if (profile != KernelProfile::kEpanechnikov) EXPECT_LT(slope, 2e-3) << name_of(profile);
      for (int i = 0; i < 100; ++i) EXPECT_GE(profile_value(profile, 0.01 * i * cutoff, cutoff), 0);
    }
  }
}

TEST(KernelShape, SemiAxesOfStretchedEllipsoids) {
  // A factor of R diag(1000, 30, 1)^2 R^T, by its Cholesky decomposition.
  const Mat3 rotation = (Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized())).toRotationMatrix();
  const Vec3 axes(1000, 30, 1);
  const Mat3 covariance = rotation * axes.cwiseAbs2().asDiagonal() * rotation.transpose();
  const Mat3 factor = covariance.llt().matrixL();
  const float numbers[6] = {static_cast<float>(factor(0, 0)), static_cast<float>(factor(1, 0)),
                            static_cast<float>(factor(1, 1)), static_cast<float>(factor(2, 0)),
                            static_cast<float>(factor(2, 1)), static_cast<float>(factor(2, 2))};
  const Vec3 found = data::semi_axes(KernelShape::kEllipsoids, numbers);
  EXPECT_NEAR(found[2], 1000, 1e-3 * 1000);
  EXPECT_NEAR(found[1], 30, 1e-2 * 30);
  EXPECT_NEAR(found[0], 1, 1e-2);
}

}  // namespace kernel_field_test
}  // namespace ovoid
