// SPDX-License-Identifier: Apache-2.0
// Prefiltered fields on both sides of the planes of samples, where kernels of a whole number of
// spacings' reach come and go.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "data/scalar_visit.h"
#include "ovoid/model.h"
#include "ovoid/sampler.h"
#include "support/agreement.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace prefilter_test {

constexpr Index3 kPrefilteredDims{13, 12, 11};

// The second is what a hand types for a reach of two spacings.
constexpr LatticeKernel kKernels[] = {{0.5, 4.0}, {0.6, 3.3333333}, {0.65, 2 / 0.65}};

// Noise over 8 bits: the samples that differ most.
Dataset noise() {
  std::mt19937 random(11);
  const auto bytes = std::make_shared<std::vector<std::uint8_t>>(
      static_cast<std::size_t>(num_samples(kPrefilteredDims)));
  for (std::uint8_t& byte : *bytes) byte = static_cast<std::uint8_t>(random() & 255U);
  Dataset data;
  data.lattice = {kPrefilteredDims, Affine3::Identity()};
  DataArray array;
  array.name = "noise";
  array.type = ScalarType::kUInt8;
  array.num_tuples = num_samples(kPrefilteredDims);
  array.bytes = {bytes, std::as_bytes(std::span<const std::uint8_t>(*bytes))};
  data.arrays.push_back(array);
  return data;
}

LatticeField prefiltered(const Dataset& data, const LatticeKernel& kernel) {
  LatticeModelOptions options;
  options.kernel = kernel;
  options.prefilter = true;
  return make_lattice_field(data, options);
}

double sample_of(const Dataset& data, const Index3& at) {
  const auto index =
      static_cast<std::size_t>(at[0] + kPrefilteredDims[0] * (at[1] + kPrefilteredDims[1] * at[2]));
  return static_cast<double>(data.arrays[0].bytes.view[index]);
}

// Difference of the greatest and the least coefficient.
double spread_of(const LatticeField& field) {
  const std::int64_t edge = field.source().brick_edge();
  double least = 1e30, greatest = -1e30;
  for (std::int64_t k = 0; k < kPrefilteredDims[2]; ++k) {
    for (std::int64_t j = 0; j < kPrefilteredDims[1]; ++j) {
      for (std::int64_t i = 0; i < kPrefilteredDims[0]; ++i) {
        const BrickView view = field.source().acquire(i / edge, j / edge, k / edge, 0);
        const std::int64_t at =
            (i - view.lo[0]) + (j - view.lo[1]) * view.stride_y + (k - view.lo[2]) * view.stride_z;
        const double number = data::visit_scalar(view.type, [&]<class T>(std::type_identity<T>) {
          return static_cast<double>(static_cast<const T*>(view.data)[at]) *
                     field.source().value_scale() +
                 field.source().value_offset();
        });
        least = std::min(least, number);
        greatest = std::max(greatest, number);
      }
    }
  }
  return greatest - least;
}

// What the kernel at the cut-off has of all weights of an axis.
double share_at_cutoff(double sigma) {
  const auto g = [&](double t) { return std::exp(-0.5 * t * t / (sigma * sigma)); };
  return g(2) / (1 + 2 * g(1) + g(2));
}

TEST(PrefilteredPlanes, ReachesAreWholeNumbersWhereTheyAreMeantTo) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const LatticeKernel& kernel : kKernels) EXPECT_EQ(kernel.support_radius(), 2.0);
  EXPECT_EQ((LatticeKernel{0.6, 3.333}).support_radius(), 0.6 * 3.333);
}

// Fails if the field on a sample has other taps than beside it: its limits on both sides then lie
// on one side of the sample's value. The jump between them is the definition's own, and no more.
TEST(PrefilteredPlanes, LimitsOnBothSidesHaveTheSampleBetweenThem) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Dataset data = noise();
  for (const LatticeKernel& kernel : kKernels) {
    SCOPED_TRACE(kernel.sigma);
    const LatticeField field = prefiltered(data, kernel);
    const FieldSampler sampler(field);
    const double most = share_at_cutoff(kernel.sigma) * spread_of(field);
    // Of what is linear in the offset, which is under 1000 per spacing, nothing is left of a mean,
    // and 2e-6 of a difference; coefficients are rounded to 65534 steps of their own range,
    // here up to six times the samples' 255 levels, and a sum may be off by half of one.
    constexpr double kOffset = 1e-9 * 2, kRounding = 0.015;
    double greatest = 0;
    for (std::int64_t k = 3; k + 3 < kPrefilteredDims[2]; ++k) {
      for (std::int64_t j = 3; j + 3 < kPrefilteredDims[1]; ++j) {
        for (std::int64_t i = 3; i + 3 < kPrefilteredDims[0]; ++i) {
          const Vec3 at = data.lattice.world_from_index * data.lattice.index_position({i, j, k});
          const double sample = sample_of(data, {i, j, k});
          EXPECT_NEAR(sampler.at(at).value, sample, kRounding);
          for (int axis = 0; axis < 3; ++axis) {
            const Vec3 step = data.lattice.world_from_index.linear().col(axis) * kOffset;
            const double before = sampler.at(at - step).value;
            const double behind = sampler.at(at + step).value;
            ASSERT_NEAR(0.5 * (before + behind), sample, kRounding) << i << " " << j << " " << k;
            greatest = std::max(greatest, std::abs(behind - before));
          }
        }
      }
    }
    EXPECT_LE(greatest, most + kRounding);
    EXPECT_GT(greatest, 0.1 * most);  // it is there
  }
}

// Fails if a back end drops or adds a tap beside a plane: x-rays of one sheet, whose pixels lie a
// little before or behind samples along x and y.
TEST(PrefilteredPlanes, BackEndsHaveTheReferencesLimits) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Dataset data = noise();
  for (const LatticeKernel& kernel : kKernels) {
    const LatticeField field = prefiltered(data, kernel);
    const Bounds3 bounds = field.world_bounds();
    TestScene scene;
    scene.field = field;
    scene.look.mode = Mode::kXray;
    scene.options = picture(static_cast<int>(kPrefilteredDims[0]) - 6,
                            static_cast<int>(kPrefilteredDims[1]) - 6);
    const double spacing = field.default_sampling_distance();
    scene.options.clip_planes = {{Vec3(0, 0, 1), bounds.center().z() - 0.4 * spacing},
                                 {Vec3(0, 0, -1), -bounds.center().z() - 0.4 * spacing}};
    for (const double offset : {-1e-3, 1e-3}) {
      // The picture's middle lies on a sample, or between two, as there are odd or even of them.
      const Vec3 middle = bounds.center() + Vec3(offset, offset, 0.3) * spacing;
      scene.camera = parallel_camera(middle, Vec3(0, 0, -1), 0.5 * scene.options.height * spacing);
      const Image reference = draw(scene, Backend::kReference).image;
      ImageTolerance tolerance;
      tolerance.peak = greatest_color(reference);
      tolerance.min_psnr_db = 90;  // a tap more or less is a hundredth of that: 50 dB
      EXPECT_TRUE(agrees_with(reference, scene, "prefiltered, beside planes", 0.9, tolerance));
    }
  }
}

}  // namespace prefilter_test
}  // namespace ovoid::test
