// SPDX-License-Identifier: Apache-2.0
// Fails if a sampler answers anything but what its field's own definition says, or if a resampled
// lattice lies beside the field's bounds.
#include "ovoid/sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "ovoid/error.h"
#include "ovoid/model.h"
#include "support/volumes.h"

namespace ovoid {
namespace sampler_test {

float value_at(const DataArray& array, std::int64_t index) {
  float value = 0;
  std::memcpy(&value, array.bytes.view.data() + index * 4, 4);
  return value;
}

TEST(FieldSampler, AConstantLatticeIsConstantWithWeightOne) {
  LatticeModelOptions model;
  model.kernel = LatticeKernel{};
  const FieldSampler sampler(
      make_lattice_field(make_sample("constant", {.size = {8, 8, 8}}), model));
  const FieldSample at = sampler.at({0.1, 0.2, -0.3});
  EXPECT_TRUE(at.is_defined);
  EXPECT_NEAR(at.value, 1, 1e-12);
  EXPECT_NEAR(at.color_value, 1, 1e-12);
  EXPECT_NEAR(at.weight, 1, 1e-12);
  EXPECT_LT(at.gradient.norm(), 1e-9);
  EXPECT_FALSE(sampler.at({5, 0, 0}).is_defined);
  // Beyond the outermost samples the kernels' share falls, until the field ends.
  const FieldSample beyond = sampler.at({1.1, 0, 0});
  EXPECT_LT(beyond.weight, 1);
  EXPECT_GT(beyond.weight, 0.5);
}

TEST(FieldSampler, AKernelFieldIsItsKernelSampler) {
  const KernelField field = make_kernel_field(make_sample("blobs", {.count = 30}));
  const FieldSampler sampler(field);
  const KernelSampler own(field);
  for (const Vec3& place : {Vec3(0, 0, 0), Vec3(0.5, -0.2, 0.1), Vec3(9, 9, 9)}) {
    const FieldSample a = sampler.at(place);
    const KernelSample b = own.at(place);
    EXPECT_EQ(a.value, b.value);
    EXPECT_EQ(a.gradient, b.gradient);
    EXPECT_EQ(a.weight, b.weight);
    EXPECT_EQ(a.is_defined, b.is_defined);
  }
}

// Fails if the probe's box of samples lacks one that the sampler counts, at borders and holes too,
// or puts one elsewhere. Sums run over the same kernels in the same order: not a digit differs.
void expect_probe_is_sampler(const Field& field, const char* what) {
  SCOPED_TRACE(what);
  const FieldSampler sampler(field);
  const FieldProbe probe(field);
  // A box that may lie obliquely, and its surroundings.
  const LatticeField* const lattice = field.lattice();
  const Affine3 world_from_box =
      lattice != nullptr ? lattice->geometry().world_from_index : Affine3::Identity();
  const Bounds3 box =
      lattice != nullptr ? lattice->geometry().index_bounds() : field.world_bounds();
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> any(-0.2, 1.2);
  int num_defined = 0;
  for (int n = 0; n < 600; ++n) {
    const Vec3 share(any(random), any(random), any(random));
    Vec3 in_box = box.min() + box.sizes().cwiseProduct(share);
    const int axis = n / 4 % 3;
    if (n % 4 == 0) in_box[axis] = n % 8 == 0 ? box.min()[axis] : box.max()[axis];
    const Vec3 at = world_from_box * in_box;
    const FieldSample a = sampler.at(at), b = probe.at(at);
    EXPECT_EQ(a.value, b.value);
    EXPECT_EQ(a.color_value, b.color_value);
    EXPECT_EQ(a.gradient, b.gradient);
    EXPECT_EQ(a.weight, b.weight);
    EXPECT_EQ(a.is_defined, b.is_defined);
    num_defined += a.is_defined ? 1 : 0;
  }
  EXPECT_GT(num_defined, 50);
  for (const double far : {1e300, -1e300, std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()})
    EXPECT_FALSE(probe.at({far, 0, 0}).is_defined);
}

TEST(FieldProbe, IsTheSampler) {
  const auto waves = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return i % 5 == 2 && j % 4 == 1 && k % 3 != 0
               ? test::kMissing
               : std::sin(static_cast<double>(3 * i + 5 * j + 7 * k));
  };
  for (const LatticeKind kind : {LatticeKind::kCartesian, LatticeKind::kBodyCentred}) {
    for (const auto how : {Reconstruction::kNormalized, Reconstruction::kSum}) {
      test::FieldSetup setup;
      setup.lattice = kind;
      setup.reconstruction = how;
      setup.world_from_index = test::oblique_axes();
      setup.value_scale = 3;
      setup.value_offset = -1;
      expect_probe_is_sampler(test::make_field({19, 14, 23}, waves, setup), name_of(kind));
      for (const LatticeKernel& kernel : {kBSplineKernel, kCatmullRomKernel}) {
        setup.kernel = kernel;
        expect_probe_is_sampler(test::make_field({19, 14, 23}, waves, setup), name_of(kernel.kind));
      }
      setup.kernel = {.sigma = 0.9, .cutoff = 5};
      setup.brick_edge = 4;
      expect_probe_is_sampler(test::make_field({19, 2, 23}, waves, setup), "wide, flat");
    }
  }
  LatticeModelOptions model;
  model.kernel = LatticeKernel{.sigma = 0.6};
  model.prefilter = true;
  expect_probe_is_sampler(make_lattice_field(make_sample("head", {.size = {20, 20, 20}}), model),
                          "prefiltered");
  expect_probe_is_sampler(make_kernel_field(make_sample("blobs", {.count = 300})), "kernels");
}

TEST(Resample, ALatticeOverBoundsFillsThem) {
  const Bounds3 bounds(Vec3(-1, 2, 5), Vec3(3, 4, 6));
  const LatticeGeometry lattice = lattice_over(bounds, {7, 3, 2});
  EXPECT_EQ(lattice.dims, (Index3{7, 3, 2}));
  EXPECT_TRUE(lattice.world_bounds().isApprox(bounds, 1e-12));
}

TEST(Resample, CubesReachAcrossTheLongestSideAndCoverTheOthers) {
  const Bounds3 bounds(Vec3(0, 0, 0), Vec3(4, 2, 1.1));
  const LatticeGeometry lattice = lattice_of_cubes(bounds, 8);
  EXPECT_EQ(lattice.dims, (Index3{8, 4, 3}));
  EXPECT_TRUE(lattice.spacing().isApprox(Vec3::Constant(0.5), 1e-12));
  const Bounds3 covered = lattice.world_bounds();
  EXPECT_NEAR(covered.min().z(), -0.2, 1e-12);  // 1.5 - 1.1, half at each end
  EXPECT_NEAR(covered.max().z(), 1.3, 1e-12);
}

TEST(Resample, ValuesAreTheSamplers) {
  const Field field = make_kernel_field(make_sample("blobs", {.count = 30}));
  const LatticeGeometry lattice = lattice_of_cubes(field.world_bounds(), 9);
  double last = 0;
  const Dataset grid =
      resample(field, lattice, {.name = "v", .color_name = "c", .progress = [&](double fraction) {
                                  EXPECT_GT(fraction, last);
                                  last = fraction;
                                }});
  EXPECT_EQ(last, 1);
  ASSERT_EQ(grid.arrays.size(), 2U);
  EXPECT_EQ(grid.arrays[0].name, "v");
  const FieldSampler sampler(field);
  std::int64_t index = 0;
  for (std::int64_t k = 0; k < lattice.dims[2]; ++k) {
    for (std::int64_t j = 0; j < lattice.dims[1]; ++j) {
      for (std::int64_t i = 0; i < lattice.dims[0]; ++i, ++index) {
        const FieldSample at = sampler.at(lattice.world_from_index * Vec3(static_cast<double>(i),
                                                                          static_cast<double>(j),
                                                                          static_cast<double>(k)));
        const float value = value_at(grid.arrays[0], index);
        if (!at.is_defined) {
          EXPECT_TRUE(std::isnan(value));
          continue;
        }
        EXPECT_EQ(value, static_cast<float>(at.value));
        EXPECT_EQ(value_at(grid.arrays[1], index), static_cast<float>(at.color_value));
      }
    }
  }
}

TEST(Resample, RefusesWhatIsNoLattice) {
  const Bounds3 unit(Vec3::Zero(), Vec3::Ones());
  EXPECT_THROW(lattice_over(unit, {4, 0, 4}), Error);
  EXPECT_THROW(lattice_of_cubes(unit, kMaxLatticeSide + 1), Error);
  EXPECT_THROW(lattice_of_cubes(Bounds3(), 4), Error);
  EXPECT_THROW(lattice_over(Bounds3(Vec3::Zero(), Vec3(1, 0, 1)), {4, 4, 4}), Error);
  std::stop_source stopped;
  stopped.request_stop();
  try {
    const Field field = make_kernel_field(make_sample("blobs", {.count = 30}));
    resample(field, lattice_of_cubes(unit, 8), {.stop = stopped.get_token()});
    FAIL() << "not stopped";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCancelled);
  }
}

}  // namespace sampler_test
}  // namespace ovoid
