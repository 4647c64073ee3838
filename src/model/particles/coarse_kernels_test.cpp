// SPDX-License-Identifier: Apache-2.0
// Coarse fields of kernel sets.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "model/test_datasets.h"
#include "ovoid/camera.h"
#include "ovoid/coarse.h"
#include "ovoid/error.h"
#include "ovoid/look.h"
#include "ovoid/renderer.h"
#include "support/where.h"

namespace ovoid::model {
namespace coarse_kernels_test {

// Columns that own their numbers: values are two attributes.
struct OwnKernels {
  KernelShape shape = KernelShape::kBalls;
  KernelProfile profile = KernelProfile::kGaussian;
  double cutoff = 4;
  std::vector<double> centers;
  std::vector<float> shapes, weights, values, colors;

  KernelField field(Reconstruction how, int attribute = 0, int color = 1) const {
    KernelColumns columns;
    columns.shape = shape;
    columns.profile = profile;
    columns.cutoff = cutoff;
    columns.centers = centers;
    columns.shapes = shapes;
    columns.weights = weights;
    columns.values = {values, colors};
    columns.attributes = {{.name = "value", .unit = "m", .range = {}},
                          {.name = "color", .unit = "K", .range = {}}};
    return {make_kernel_source(columns), how, attribute, color};
  }

  void add(const Vec3& center, std::initializer_list<float> numbers, float weight, float value,
           float color) {
    centers.insert(centers.end(), {center[0], center[1], center[2]});
    shapes.insert(shapes.end(), numbers);
    weights.push_back(weight);
    values.push_back(value);
    colors.push_back(color);
  }
};

// Kernels of a jittered lattice, half a spacing wide or so.
OwnKernels jittered(KernelShape shape, int edge) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> any(0, 1);
  OwnKernels set;
  set.shape = shape;
  for (int n = 0; n < edge * edge * edge; ++n) {
    const Vec3 at(n % edge, n / edge % edge, n / edge / edge);
    const Vec3 center = at + 0.3 * Vec3(any(random), any(random), any(random));
    const float sigma = 0.55F + 0.1F * any(random);  // of one class of sizes
    const float weight = 0.5F + any(random), value = any(random), color = 20 + any(random);
    if (shape == KernelShape::kBalls) {
      set.add(center, {sigma}, weight, value, color);
    } else {
      set.add(center, {sigma, 0.1F * any(random), sigma, -0.1F, 0.1F, 0.8F * sigma}, weight, value,
              color);
    }
  }
  return set;
}

// What merging keeps. `by_value`: of what is summed, else of the weights.
struct Moments {
  double mass = 0, colored = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();

  // `variance`: of a kernel of unit covariance, along an axis.
  Moments(const KernelField& field, bool by_value, double variance = 1) {
    for (const OneKernel& kernel : kernels_of(field)) {
      const double own = kernel.weight * kernel.factor.determinant();
      const double part = by_value ? own * static_cast<double>(kernel.values[0]) : own;
      mass += part;
      colored += part * static_cast<double>(kernel.values[1]);
      first += part * kernel.center;
      second += part * (variance * kernel.covariance() + kernel.center * kernel.center.transpose());
    }
  }
};

// Kernels are stored as floats, in a box of 12 spacings: 1e-6 is ten times the rounding of one.
constexpr double kRounding = 1e-6;

void expect_same_moments(const Moments& a, const Moments& b, bool is_ball) {
  EXPECT_NEAR(a.mass / b.mass, 1, kRounding);
  EXPECT_NEAR(a.colored / b.colored, 1, kRounding);
  EXPECT_LT((a.first - b.first).norm(), kRounding * b.first.norm());
  const double scale = b.second.norm();
  if (is_ball) {  // of a ball a third of the trace, each
    EXPECT_NEAR(a.second.trace() / scale, b.second.trace() / scale, kRounding);
  } else {
    EXPECT_LT((a.second - b.second).norm(), kRounding * scale);
  }
}

// Fails if mass, places or extents are lost on the way, or if the colour of a sum is not weighted
// by what is summed.
TEST(CoarseKernels, MomentsAreKept) {
  for (const KernelShape shape : {KernelShape::kBalls, KernelShape::kEllipsoids}) {
    const OwnKernels set = jittered(shape, 12);
    for (const auto how : {Reconstruction::kNormalized, Reconstruction::kSum}) {
      const bool is_sum = how == Reconstruction::kSum;
      const KernelField field = set.field(how);
      const Field coarse = coarse_field(field);
      const Field coarser = coarse_field(coarse);
      const Moments own(field, is_sum);
      expect_same_moments(Moments(*coarse.kernels(), is_sum), own, shape == KernelShape::kBalls);
      expect_same_moments(Moments(*coarser.kernels(), is_sum), own, shape == KernelShape::kBalls);
      EXPECT_EQ(coarse.kernels()->reconstruction(), how);
      EXPECT_EQ(coarse.kernels()->attribute(), 0);
      EXPECT_EQ(coarse.kernels()->color_attribute(), 1);
      EXPECT_EQ(coarse.kernels()->source().shape(), shape);
      EXPECT_EQ(coarse.kernels()->source().attributes()[1].name, "color");
      // 24 bytes per ball and 48 per ellipsoid with one attribute, 4 for the other; bricks.
      const auto limit = shape == KernelShape::kBalls ? 28 : 52;
      EXPECT_LT(coarse.resident_bytes(),
                static_cast<std::size_t>(coarse.num_kernels()) * limit + 8000);
    }
  }
}

// Fails if other profiles are taken for Gaussians. The variance along an axis of what ends at 1 is
// 3/40 of M4, 1/15 of Wendland's and 1/7 of Epanechnikov's: a third of the integral of t^4 phi over
// that of t^2 phi. At a cutoff of 3 it is nine times that.
TEST(CoarseKernels, ProfilesHaveTheirOwnExtent) {
  const std::vector<std::pair<KernelProfile, double>> profiles{
      {KernelProfile::kGaussian, 1.0},
      {KernelProfile::kCubicSpline, 9.0 * 3 / 40},
      {KernelProfile::kWendlandC2, 9.0 / 15},
      {KernelProfile::kEpanechnikov, 9.0 / 7},
  };
  for (const auto& [profile, variance] : profiles) {
    OwnKernels set = jittered(KernelShape::kEllipsoids, 8);
    set.profile = profile;
    set.cutoff = 3;
    const KernelField field = set.field(Reconstruction::kNormalized);
    const Field coarse = coarse_field(field);
    EXPECT_LT(coarse.num_kernels(), field.num_kernels() / 5);
    EXPECT_EQ(coarse.kernels()->source().profile(), profile);
    EXPECT_EQ(coarse.kernels()->source().cutoff(), 3);
    expect_same_moments(Moments(*coarse.kernels(), false, variance),
                        Moments(field, false, variance), false);
  }
}

// Fails if groups are much smaller or larger than eight, or if a constant is not kept.
TEST(CoarseKernels, AboutAnEighthAndConstantsStay) {
  OwnKernels set = jittered(KernelShape::kBalls, 20);
  set.values.assign(set.values.size(), 0.3F);
  const Field field = set.field(Reconstruction::kNormalized, 0, -1);
  const Field coarse = coarse_field(field);
  EXPECT_GT(coarse.num_kernels(), 8000 / 11);
  EXPECT_LT(coarse.num_kernels(), 8000 / 6);
  for (const OneKernel& kernel : kernels_of(*coarse.kernels()))
    EXPECT_NEAR(kernel.values[0], 0.3, 1e-7);
  EXPECT_GT(coarse.default_sampling_distance(), 1.2 * field.default_sampling_distance());
}

// Eight kernels at the corners of two far squares.
OwnKernels two_squares(double distance) {
  OwnKernels set;
  for (int n = 0; n < 8; ++n)
    set.add({distance * (n / 4), 0.5 * (n % 2), 0.5 * (n / 2 % 2)}, {1.0F}, 1, 2, 3);
  return set;
}

// Fails if a hole is bridged, if clusters are left apart, or if `length` does not have its way. Two
// kernels leave a hole where 2 exp(-D^2 / 8) < 0.2: from D = 4.29 on.
TEST(CoarseKernels, HolesStayOpenUnlessAPixelIsLarger) {
  const auto count = [](double distance, double length) {
    return coarse_field(two_squares(distance).field(Reconstruction::kNormalized),
                        {.length = length})
        .num_kernels();
  };
  EXPECT_EQ(count(0, 0), 1);
  EXPECT_EQ(count(4.2, 0), 1);
  EXPECT_EQ(count(4.4, 0), 2);
  EXPECT_EQ(count(100, 0), 2);
  EXPECT_EQ(count(100, 99), 2);
  EXPECT_EQ(count(100, 101), 1);
  // However many they are.
  const OwnKernels many = jittered(KernelShape::kBalls, 5);
  EXPECT_EQ(coarse_field(many.field(Reconstruction::kSum), {.length = 7}).num_kernels(), 1);
}

// Fails if cells a thousand times as long as they are thick are merged along their long axes alone,
// or if flat ones lose their thickness.
TEST(CoarseKernels, FlatKernelsStayFlat) {
  OwnKernels set;
  set.shape = KernelShape::kEllipsoids;
  constexpr float kThick = 1e-3F;
  for (int n = 0; n < 64; ++n)
    set.add({1.0 * (n % 4), 1.0 * (n / 4 % 4), 2e-3 * (n / 16)}, {0.5F, 0, 0.5F, 0, 0, kThick}, 1,
            1, 1);
  const Field coarse = coarse_field(set.field(Reconstruction::kNormalized));
  EXPECT_EQ(coarse.num_kernels(), 8);
  for (const OneKernel& kernel : kernels_of(*coarse.kernels())) {
    // Two layers 2e-3 apart, two neighbours 1 apart: twice the covariance.
    EXPECT_NEAR(kernel.factor(2, 2), std::sqrt(2) * 1e-3, 1e-8);
    EXPECT_NEAR(kernel.factor(0, 0), std::sqrt(0.5), 1e-6);
  }
}

// A sum of which nothing is summed has places all the same.
TEST(CoarseKernels, ASumOfNothingIsMerged) {
  OwnKernels set = two_squares(1);
  set.values.assign(8, 0.0F);
  const Field coarse = coarse_field(set.field(Reconstruction::kSum));
  ASSERT_EQ(coarse.num_kernels(), 1);
  const OneKernel one = kernels_of(*coarse.kernels())[0];
  EXPECT_NEAR(one.center[0], 0.5, 1e-6);
  EXPECT_EQ(one.values[0], 0);
}

// Fails if tasks share anything, or if the order of kernels is that of threads.
TEST(CoarseKernels, ThreadsDoNotMatter) {
  const KernelField field = jittered(KernelShape::kBalls, 30).field(Reconstruction::kSum);
  const auto a = kernels_of(*coarse_field(field, {.threads = 1}).kernels());
  const auto b = kernels_of(*coarse_field(field, {.threads = 5}).kernels());
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].center, b[i].center);
    EXPECT_EQ(a[i].factor, b[i].factor);
    EXPECT_EQ(a[i].weight, b[i].weight);
    EXPECT_EQ(a[i].values, b[i].values);
  }
}

TEST(CoarseKernels, ProgressAndStop) {
  const KernelField field = jittered(KernelShape::kBalls, 20).field(Reconstruction::kSum);
  double last = 0;
  coarse_field(field, {.progress = [&](double fraction) {
                 EXPECT_GT(fraction, last);
                 last = fraction;
               }});
  EXPECT_EQ(last, 1);
  std::stop_source stopped;
  stopped.request_stop();
  try {
    coarse_field(field, {.stop = stopped.get_token()});
    FAIL() << "not stopped";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCancelled);
  }
}

// The galaxy's density where a pixel is eight times the default sampling distance, against the
// whole set's: kernels a pixel or so wide, merged, are sqrt(2) times as wide. What lies 0.3 pixels
// beside differs more. (The brighter the look, the more both do.)
TEST(CoarseKernels, FromFarTheyLookTheSame) {
  OVOID_NOT_UNDER_TSAN();
  KernelModelOptions model;
  model.is_density = true;
  const Field field = make_kernel_field(make_sample("galaxy", {.count = 20000}), model);
  Look look = default_look(field);
  look.unit_distance = default_unit_distance(field);
  Camera camera = default_camera(field.world_bounds());
  RenderOptions options;
  options.width = options.height = 64;
  Renderer renderer(Backend::kCpu);
  const Image full = renderer.render({field, look}, camera, options).image;
  const Field coarse = coarse_field(field);
  constexpr double kBound = 31.5;
  const double found = psnr(full, renderer.render({coarse, look}, camera, options).image);
  EXPECT_GT(found, kBound) << found;
  const Vec3 aside(0.3 * 8 * field.default_sampling_distance(), 0, 0);
  camera.position += aside;
  camera.focal_point += aside;
  EXPECT_LT(psnr(full, renderer.render({coarse, look}, camera, options).image), kBound);
}

}  // namespace coarse_kernels_test
}  // namespace ovoid::model
