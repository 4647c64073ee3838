// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/lattice/noise.h"
#include "model/particles/particle_lengths.h"
#include "model/test_datasets.h"
#include "ovoid/model.h"
#include "support/numbers.h"
#include "support/where.h"

namespace ovoid::model {
namespace particles_test {

std::vector<Vec3> random_cloud(int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(0, 1), y = random.uniform(0, 1), z = random.uniform(0, 1);
    // Crowded on one side; off the faces, where rounding decides.
    points.emplace_back(0.001 + 0.998 * x * x * x, 0.001 + 0.998 * y, 0.001 + 0.998 * z);
  }
  return points;
}

Dataset cloud_dataset(const std::vector<Vec3>& points) {
  return points_dataset(DatasetKind::kParticles, points);
}

void add_array(Dataset& dataset, const char* name, std::vector<float> values) {
  dataset.arrays.push_back(array_of_numbers(name, 1, std::move(values)));
}

// 2 h is the distance to the K-th nearest, the particle itself counted: against brute force, and
// with a periodic box against brute force over all 27 images.
TEST(ParticleKernels, LengthsAgainstBruteForce) {
  OVOID_NOT_UNDER_TSAN();
  const std::vector<Vec3> points = random_cloud(700, 3);
  const std::vector<Vec3> here = {Vec3::Zero()};
  std::vector<Vec3> images;
  for (int image = 0; image < 27; ++image)
    images.emplace_back(image % 3 - 1, image / 3 % 3 - 1, image / 9 - 1);
  for (const bool is_periodic : {false, true}) {
    Dataset dataset = cloud_dataset(points);
    if (is_periodic) dataset.periodic_box = Bounds3(Vec3::Zero(), Vec3::Ones());
    KernelModelReport report;
    const auto kernels = kernels_of(make_kernel_field(dataset, {.neighbors = 20}, &report));
    EXPECT_EQ(report.num_copies > 0, is_periodic);
    int inside = 0;
    for (const OneKernel& kernel : kernels) {
      if ((kernel.center.array() < 0).any() || (kernel.center.array() > 1).any()) continue;
      ++inside;
      std::vector<double> distances;
      for (const Vec3& point : points) {
        for (const Vec3& shift : is_periodic ? images : here)
          distances.push_back((point + shift - kernel.center).norm());
      }
      std::nth_element(distances.begin(), distances.begin() + 19, distances.end());
      ASSERT_NEAR(kernel.factor(0, 0), distances[19] / 4, 1e-6 * distances[19]);
    }
    EXPECT_EQ(inside, 700);
  }
}

// The field of a periodic box is the same on both sides of its faces, and particles outside are
// wrapped into it.
TEST(ParticleKernels, PeriodicBoxWraps) {
  OVOID_NOT_UNDER_TSAN();
  std::vector<Vec3> points = random_cloud(400, 4);
  Dataset dataset = cloud_dataset(points);
  dataset.periodic_box = Bounds3(Vec3::Zero(), Vec3::Ones());
  for (std::size_t i = 0; i < points.size(); i += 3)
    points[i] += Vec3(static_cast<double>(i % 2), -3, 1);
  Dataset outside = cloud_dataset(points);
  outside.arrays[0] = dataset.arrays[0];
  outside.periodic_box = dataset.periodic_box;
  const KernelSampler sampler(make_kernel_field(dataset, {.is_density = true}));
  const KernelSampler other(make_kernel_field(outside, {.is_density = true}));
  for (const Vec3& p : random_cloud(30, 5)) {
    const double here = sampler.at({0, p.y(), p.z()}).value;
    EXPECT_NEAR(sampler.at({1, p.y(), p.z()}).value, here, 1e-4 * here);
    EXPECT_NEAR(other.at(p).value, sampler.at(p).value, 1e-4 * sampler.at(p).value);
  }
}

// What is drawn of particles whose owner names no array.
TEST(ParticleKernels, DensityIsTheDefaultOfWhatHasAMass) {
  OVOID_NOT_UNDER_TSAN();
  const auto cloud = [](const std::vector<const char*>& names) {
    Dataset dataset = cloud_dataset({{0, 0, 0}, {0.3, 0.1, 0}, {0.1, 0.2, 0.4}});
    dataset.arrays.clear();
    for (const char* const name : names) add_array(dataset, name, {1, 2, 4});
    return dataset;
  };
  EXPECT_TRUE(draws_density(cloud({})));
  EXPECT_TRUE(draws_density(cloud({"age", "mass"})));
  EXPECT_TRUE(draws_density(cloud({"PartType0/age", "PartType0/Masses"})));
  EXPECT_TRUE(draws_density(cloud({"vx", "vy", "vz", "id"})));
  EXPECT_TRUE(draws_density(cloud({"age"}), {.is_density = true}));
  EXPECT_TRUE(draws_density(cloud({"age"}), {.mass = 2.0}));
  EXPECT_FALSE(draws_density(cloud({"age"})));
  EXPECT_FALSE(draws_density(cloud({"vx", "vy", "vz", "T"})));
  EXPECT_FALSE(draws_density(cloud({"vx", "vz"})));
  EXPECT_FALSE(draws_density(cloud({"mass", "rho"})));  // has one of its own
  EXPECT_FALSE(draws_density(cloud({"age", "mass"}), {.array = "age"}));
  EXPECT_FALSE(draws_density(cloud({"age", "mass"}), {.color_array = "age"}));
  EXPECT_FALSE(draws_density(cloud({"age", "mass"}), {.is_density = false}));
  Dataset mesh = cloud({"age", "mass"});
  mesh.kind = DatasetKind::kMesh;
  EXPECT_FALSE(draws_density(mesh));
  KernelModelReport report;
  const KernelField field = make_kernel_field(cloud({"age", "mass"}), {}, &report);
  EXPECT_EQ(report.array, "density");
  EXPECT_EQ(field.reconstruction(), Reconstruction::kSum);
  ASSERT_EQ(report.notes.size(), 1U);
  EXPECT_NE(report.notes[0].find("mass per volume"), std::string::npos) << report.notes[0];
  make_kernel_field(cloud({"vx", "vy", "vz", "T"}), {}, &report);
  EXPECT_EQ(report.array, "T");
}

// Mass is kept: the density integrates to the sum of masses, with every profile. On a grid of step
// s a smooth kernel's sum errs far less than the bound.
TEST(ParticleKernels, DensityIntegratesToTheMass) {
  OVOID_NOT_UNDER_TSAN();
  for (const KernelProfile profile : {KernelProfile::kGaussian, KernelProfile::kCubicSpline,
                                      KernelProfile::kWendlandC2, KernelProfile::kEpanechnikov}) {
    Dataset dataset = cloud_dataset({{0, 0, 0}, {0.3, 0.1, 0}, {0.1, 0.2, 0.4}});
    add_array(dataset, "mass", {1, 2, 4});
    add_array(dataset, "h", {0.2F, 0.3F, 0.25F});
    const KernelField field = make_kernel_field(dataset, {.is_density = true, .profile = profile});
    EXPECT_EQ(field.reconstruction(), Reconstruction::kSum);
    EXPECT_EQ(field.source().shape(), KernelShape::kBalls);
    const KernelSampler sampler(field);
    constexpr double kStep = 0.04;
    double sum = 0;
    for (double z = -0.8; z < 1.3; z += kStep) {
      for (double y = -0.8; y < 1.3; y += kStep) {
        for (double x = -0.8; x < 1.3; x += kStep) sum += sampler.at({x, y, z}).value;
      }
    }
    // The Gaussian is cut where 0.11 % of its mass lie outside; Epanechnikov's edge is a kink.
    const double bound =
        profile == KernelProfile::kGaussian || profile == KernelProfile::kEpanechnikov ? 2e-3
                                                                                       : 1e-3;
    EXPECT_NEAR(sum * kStep * kStep * kStep, 7, 7 * bound) << name_of(profile);
  }
}

// Support is 2 h whatever the cut-off, but a Gaussian's sigma is h / 2.
TEST(ParticleKernels, SmoothingLengths) {
  OVOID_NOT_UNDER_TSAN();
  Dataset dataset = cloud_dataset({{0, 0, 0}, {9, 0, 0}});
  add_array(dataset, "SmoothingLength", {1, 2});
  const auto sigma = [&](KernelProfile profile, double cutoff) {
    return kernels_of(make_kernel_field(dataset, {.cutoff = cutoff, .profile = profile}))[0].factor(
        0, 0);
  };
  EXPECT_FLOAT_EQ(static_cast<float>(sigma(KernelProfile::kGaussian, 4)), 0.5F);
  EXPECT_FLOAT_EQ(static_cast<float>(sigma(KernelProfile::kGaussian, 3)), 0.5F);
  EXPECT_FLOAT_EQ(static_cast<float>(sigma(KernelProfile::kCubicSpline, 4)), 0.5F);
  EXPECT_FLOAT_EQ(static_cast<float>(sigma(KernelProfile::kCubicSpline, 2)), 1.0F);
}

// A lone particle's density is the kernel of its code, as published: for Gadget's ends at one
// smoothing length, SWIFT's at 1.8257, Ovoid's own and Phantom's at two. Fails if a length is taken
// for another code's: at twice the length the density is an eighth.
TEST(ParticleKernels, DensityOfALoneParticle) {
  OVOID_NOT_UNDER_TSAN();
  using std::numbers::pi;
  constexpr double kLength = 0.5, kMass = 3;
  for (const auto& [format, reach] : std::vector<std::pair<const char*, double>>{
           {"HDF5 (Gadget)", 1.0}, {"HDF5 (SWIFT, cubic spline)", 1.825742}, {"HDF5", 2.0}}) {
    Dataset dataset = cloud_dataset({{0, 0, 0}});
    add_array(dataset, "Masses", {static_cast<float>(kMass)});
    add_array(dataset, "SmoothingLengths", {static_cast<float>(kLength)});
    dataset.format = format;
    const double radius = reach * kLength;
    for (const KernelProfile profile : {KernelProfile::kGaussian, KernelProfile::kCubicSpline,
                                        KernelProfile::kWendlandC2, KernelProfile::kEpanechnikov}) {
      const KernelSampler sampler(
          make_kernel_field(dataset, {.is_density = true, .profile = profile}));
      // It asks for another reach than the file's.
      const KernelSampler wide(make_kernel_field(
          dataset, {.is_density = true, .smoothing_reach = 4, .profile = profile}));
      const auto expected = [&](double t) {  // t: parts of the radius
        const double per_volume = kMass / std::pow(radius, 3);
        switch (profile) {
          case KernelProfile::kCubicSpline:
            return per_volume * 8 / pi *
                   (t < 0.5 ? 1 - 6 * t * t + 6 * t * t * t : 2 * std::pow(1 - t, 3));
          case KernelProfile::kWendlandC2:
            return per_volume * 21 / (2 * pi) * std::pow(1 - t, 4) * (1 + 4 * t);
          case KernelProfile::kEpanechnikov:
            return per_volume * 15 / (8 * pi) * (1 - t * t);
          case KernelProfile::kGaussian:
            break;
        }
        return per_volume * 64 / std::pow(2 * pi, 1.5) * std::exp(-8 * t * t);
      };
      // The Gaussian is brought to 0 at its end, and made as much higher.
      const double bound = profile == KernelProfile::kGaussian ? 0.025 : 1e-5;
      for (const double t : {0.0, 0.25, 0.6, 0.9}) {
        const Vec3 at(t * radius, 0, 0);
        EXPECT_NEAR(sampler.at(at).value, expected(t), bound * expected(0))
            << name_of(profile) << " at " << t << " of " << reach;
        const Vec3 there = at * 4 / reach;
        EXPECT_NEAR(wide.at(there).value, expected(t) * std::pow(reach / 4, 3),
                    bound * expected(0));
      }
      EXPECT_EQ(std::isnan(sampler.at({1.001 * radius, 0, 0}).value)
                    ? 0.0F
                    : sampler.at({1.001 * radius, 0, 0}).value,
                0.0F);
    }
  }
}

// Where mass and density are known, w = m / rho / integral: on a lattice of particles the sum of
// weights is 1. Where only h is, one weight for all
// makes it nearly so.
TEST(ParticleKernels, WeightsOfAttributes) {
  OVOID_NOT_UNDER_TSAN();
  std::vector<Vec3> points;
  for (int i = 0; i < 729; ++i) points.emplace_back(i % 9, i / 9 % 9, i / 81);
  Dataset dataset = cloud_dataset(points);
  add_array(dataset, "h", std::vector<float>(729, 1.2F));
  KernelSampler sampler(make_kernel_field(dataset, {.array = "v"}));
  EXPECT_NEAR(sampler.at({4, 4, 4}).weight, 1, 0.3);  // half of so few are at the surface
  EXPECT_NEAR(sampler.at({4, 4, 4}).value, 4, 1e-3);
  EXPECT_EQ(make_kernel_field(dataset, {.array = "v"}).source().acquire(0, 0).weight, nullptr);
  add_array(dataset, "m", std::vector<float>(729, 3));
  add_array(dataset, "rho", std::vector<float>(729, 3));
  sampler = KernelSampler(make_kernel_field(dataset, {.array = "v"}));
  EXPECT_NEAR(sampler.at({4, 4, 4}).weight, 1, 0.02);
  dataset.arrays.resize(1);
  sampler = KernelSampler(make_kernel_field(dataset, {.array = "v"}));  // h from neighbours
  EXPECT_NEAR(sampler.at({4, 4, 4}).weight, 1, 0.15);
}

// One particle, two, and heaps at one place.
TEST(ParticleKernels, FewAndHeaped) {
  OVOID_NOT_UNDER_TSAN();
  KernelModelReport report;
  auto kernels = kernels_of(make_kernel_field(cloud_dataset({{1, 2, 3}}), {}, &report));
  ASSERT_EQ(kernels.size(), 1U);
  EXPECT_EQ(kernels[0].factor(0, 0), 0.5);  // h = 1
  EXPECT_EQ(report.num_degenerate, 1);
  kernels = kernels_of(make_kernel_field(cloud_dataset({{0, 0, 0}, {0, 0, 4}}), {}));
  EXPECT_EQ(kernels[1].factor(0, 0), 1);
  std::vector<Vec3> heap(50, Vec3(1, 1, 1));
  heap.emplace_back(2, 1, 1);
  kernels = kernels_of(make_kernel_field(cloud_dataset(heap), {}, &report));
  EXPECT_EQ(kernels.size(), 2U) << "a heap is one kernel";
  EXPECT_EQ(report.num_merged, 49);
  EXPECT_EQ(report.num_degenerate, 1);
  for (const OneKernel& kernel : kernels) EXPECT_EQ(kernel.factor(0, 0), 0.25);
  for (const bool anisotropic : {false, true}) {
    const std::vector<Vec3> line = {{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {3, 3, 0}, {4, 4, 0}};
    for (const OneKernel& kernel : kernels_of(
             make_kernel_field(cloud_dataset(line), {.neighbors = 4, .anisotropic = anisotropic})))
      EXPECT_GT(kernel.factor.diagonal().minCoeff(), 0);
  }
}

// Ellipsoids have the ball's volume and at most the documented ratio.
TEST(ParticleKernels, Anisotropic) {
  OVOID_NOT_UNDER_TSAN();
  std::vector<Vec3> points;
  Random random(8);
  for (int i = 0; i < 2000; ++i) {
    const double x = random.uniform(0, 10), y = random.uniform(0, 10);
    points.emplace_back(x, y, 1e-3 * random.uniform(0, 1));
  }
  const auto balls = kernels_of(make_kernel_field(cloud_dataset(points), {}));
  KernelModelReport report;
  const auto discs =
      kernels_of(make_kernel_field(cloud_dataset(points), {.anisotropic = true}, &report));
  ASSERT_EQ(discs.size(), balls.size());
  for (std::size_t i = 0; i < discs.size(); ++i) {
    const double volume = std::pow(balls[i].factor(0, 0), 3);
    EXPECT_NEAR(discs[i].factor.determinant(), volume, 1e-4 * volume);
  }
  EXPECT_NEAR(report.axis_ratios[4], 8, 1e-3);
}

TEST(ParticleKernels, WithoutArraysNumberDensity) {
  OVOID_NOT_UNDER_TSAN();
  Dataset dataset = cloud_dataset(random_cloud(100, 6));
  dataset.arrays.clear();
  KernelModelReport report;
  const KernelField field = make_kernel_field(dataset, {}, &report);
  EXPECT_EQ(field.reconstruction(), Reconstruction::kSum);
  EXPECT_EQ(report.array, "density");
  EXPECT_FALSE(report.notes.empty());
  EXPECT_FALSE(report.is_normalized);
}

// Lengths of 1e21 have volumes beyond float32; their densities need not be.
TEST(ParticleKernels, CentimetresOfAGalaxy) {
  OVOID_NOT_UNDER_TSAN();
  Dataset dataset = cloud_dataset({{0, 0, 0}, {3e21, 0, 0}});
  add_array(dataset, "m", {2e33F, 2e33F});
  add_array(dataset, "h", {1e21F, 1e21F});
  const KernelSampler sampler(make_kernel_field(dataset, {.is_density = true}));
  const double expected = 2e33 * profile_value(KernelProfile::kGaussian, 0, 4) /
                          (profile_integral(KernelProfile::kGaussian, 4) * std::pow(0.5e21, 3));
  EXPECT_NEAR(sampler.at({0, 0, 0}).value, expected, 1e-4 * expected);
}

TEST(ParticleKernels, RefusesAndCounts) {
  OVOID_NOT_UNDER_TSAN();
  const auto refused = [](const std::function<void(Dataset&)>& spoil, const std::string& words,
                          const KernelModelOptions& options = {}) {
    Dataset bad = cloud_dataset({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    spoil(bad);
    EXPECT_NE(model_refusal(bad, options).find(words), std::string::npos)
        << model_refusal(bad, options);
  };
  refused([](Dataset& d) { add_array(d, "h", {1, 0, 1}); }, "h[1] = 0: must be > 0");
  refused([](Dataset& d) { add_array(d, "radii", {1, 1, -2}); }, "radii[2] = -2: must be > 0");
  refused([](Dataset& d) { add_array(d, "h", {1, kNanF, 1}); }, "h[1] = nan: must be > 0");
  refused([](Dataset& d) { add_array(d, "h", {1, 1}); }, "2 tuples, must be 3");
  refused([](Dataset& d) { d.positions = {}; }, "no positions");
  const auto as_large_as = [](double extent) {
    return [extent](Dataset& d) {
      d.positions =
          cloud_dataset({{0, 0, 0}, {extent, 0, 0}, {0, extent, 0}, {0, 0, extent}}).positions;
      add_array(d, "size", {1, 2, 3, 4});
      d.arrays.erase(d.arrays.begin());
    };
  };
  refused(as_large_as(1e38), "extend over 1e+38, expected 1e-30 to 1e+37; give lengths in another");
  refused(as_large_as(1e-31), "extend over 1e-31, expected 1e-30 to 1e+37");
  refused(as_large_as(1e-25), "density is up to about", {.is_density = true});
  refused(as_large_as(1e25), "give lengths or masses in another unit", {.is_density = true});
  refused(as_large_as(1e25), "accepted", {.array = "size"});
  refused([](Dataset&) {}, "'size'", {.radius_array = "size"});
  refused([](Dataset&) {}, "mass = 0", {.mass = 0});
  refused([](Dataset& d) { d.periodic_box = Bounds3(Vec3::Zero(), Vec3(1, 0, 1)); }, "no volume");
  refused(
      [](Dataset& d) {
        d.arrays[0] = array_of_numbers<float>("v", 1, {kNanF, kNanF, kNanF});
      },
      "3 have no finite value of 'v'");
  refused(
      [](Dataset& d) {
        add_array(d, "mass", {1, 1, 1});
        add_array(d, "rho", {1, 1, 0});
      },
      "rho[2] = 0: must be > 0", {.array = "v"});

  Dataset phantom = cloud_dataset({{0, 0, 0}, {1, 0, 0}, {kNan, 1, 0}, {4, 0, 0}});
  add_array(phantom, "h", {1, -1, 1, 1});
  phantom.format = "Phantom HDF5";
  KernelModelReport report;
  EXPECT_EQ(make_kernel_field(phantom, {}, &report).num_kernels(), 2);
  EXPECT_EQ(report.num_misplaced, 1);
  EXPECT_EQ(report.notes.size(), 2U);
}

TEST(ParticleKernels, ThreadsChangeNothingInParticles) {
  OVOID_NOT_UNDER_TSAN();
  const Dataset galaxy = make_sample("galaxy", {.count = 9000});
  const auto one = kernels_of(make_kernel_field(galaxy, {.threads = 1}));
  const auto many = kernels_of(make_kernel_field(galaxy, {.threads = 5}));
  ASSERT_EQ(one.size(), many.size());
  for (std::size_t i = 0; i < one.size(); ++i) ASSERT_EQ(one[i].factor, many[i].factor);
}

// 24 bytes a ball, beside the bricks.
TEST(ParticleKernels, AreSmall) {
  OVOID_NOT_UNDER_TSAN();
  const KernelField field = make_kernel_field(make_sample("galaxy", {.count = 50000}));
  EXPECT_LE(static_cast<double>(field.source().resident_bytes()) / 50000, 25.5);
}

}  // namespace particles_test
}  // namespace ovoid::model
