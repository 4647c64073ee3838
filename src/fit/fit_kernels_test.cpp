// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "model/lattice/noise.h"
#include "model/test_datasets.h"
#include "ovoid/error.h"
#include "ovoid/fit.h"
#include "support/where.h"

namespace ovoid {
namespace fit_kernels_test {

using Formula = std::function<double(const Vec3&)>;

double bump(const Vec3& p) { return std::exp(-0.5 * (p - Vec3(4, 5, 6)).squaredNorm() / 4); }
double line(const Vec3& p) { return 3 + 0.5 * p[0] - p[1] + 0.25 * p[2]; }

// A grid of hexahedra whose nodes are moved at random, with the formula's values at the nodes.
Dataset jittered_grid(const Index3& dims, const Formula& value, double most = 0.2) {
  model::Random random(11);
  Dataset dataset = model::grid_dataset(dims, [&](const Vec3& p) {
    return Vec3(p + Vec3(random.uniform(-most, most), random.uniform(-most, most),
                         random.uniform(-most, most)));
  });
  std::vector<float> values;
  const auto* const at = reinterpret_cast<const double*>(dataset.positions.bytes.view.data());
  for (std::int64_t i = 0; i < dataset.num_positions(); ++i)
    values.push_back(static_cast<float>(value(Vec3(at + 3 * i))));
  dataset.arrays = {model::array_of_numbers("v", 1, std::move(values))};
  return dataset;
}

FitOptions with_kernels(std::int64_t count) {
  FitOptions options;
  options.kernels = count;
  return options;
}

// A fifteenth of the kernels is nearer to the mesh than all of them, and as near to the formula as
// the mesh is.
TEST(FitKernels, FewKernelsAreNearlyAsGoodAsAll) {
  OVOID_NOT_UNDER_TSAN();
  const Dataset mesh = jittered_grid({14, 14, 14}, bump);
  FitReport report;
  const KernelField field = fit_kernels(mesh, with_kernels(14 * 14 * 14 / 15), &report);
  EXPECT_EQ(field.num_kernels(), 14 * 14 * 14 / 15);
  EXPECT_EQ(report.kernels, field.num_kernels());
  EXPECT_EQ(report.source_kernels, 14 * 14 * 14);
  EXPECT_GT(report.psnr, report.source_psnr);
  EXPECT_GT(report.psnr, 48);
  EXPECT_LT(report.wrongly_empty, 1e-3);
  const KernelSampler sampler(field);
  model::Random random(2);
  double square = 0;
  constexpr int kPlaces = 4000;
  for (int i = 0; i < kPlaces; ++i) {
    Vec3 place;
    for (int a = 0; a < 3; ++a) place[a] = random.uniform(0.5, 12.5);
    const double error = sampler.at(place).value - bump(place);
    square += error * error;
  }
  const double psnr = 20 * std::log10(report.range / std::sqrt(square / kPlaces));
  EXPECT_GT(psnr, 41);
}

// More kernels, less error: the curve has no bumps worth the name.
TEST(FitKernels, MoreKernelsErrLess) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  const Dataset mesh = jittered_grid({12, 12, 12}, bump);
  double last = 0;
  for (const std::int64_t count : {16, 64, 256, 1024}) {
    FitReport report;
    fit_kernels(mesh, with_kernels(count), &report);
    EXPECT_GT(report.psnr, last + 1) << count;
    last = report.psnr;
  }
}

TEST(FitKernels, PsnrIsReachedWithFewKernels) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  const Dataset mesh = jittered_grid({12, 12, 12}, bump);
  FitOptions options;
  options.psnr = 52;
  FitReport report;
  const KernelField field = fit_kernels(mesh, options, &report);
  EXPECT_GE(report.steps.back().psnr, 50);
  EXPECT_GT(report.psnr, 51);
  EXPECT_LT(report.psnr, 56);
  EXPECT_LT(field.num_kernels(), 12 * 12 * 12 / 4);
}

// The bound holds at places that nobody told it.
TEST(FitKernels, ToleranceHoldsEverywhere) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  const Dataset mesh = jittered_grid({12, 12, 12}, bump);
  FitOptions options;
  options.tolerance = 0.05;
  FitReport report;
  const KernelField field = fit_kernels(mesh, options, &report);
  EXPECT_LE(report.greatest_error, 0.05);
  EXPECT_LT(field.num_kernels(), 12 * 12 * 12 / 2);
  const KernelSampler sampler(field);
  const auto* const at = reinterpret_cast<const double*>(mesh.positions.bytes.view.data());
  for (std::int64_t i = 0; i < mesh.num_positions(); ++i) {
    const Vec3 node(at + 3 * i);
    const KernelSample sample = sampler.at(node);
    if (!sample.is_defined) continue;
    EXPECT_NEAR(sample.value, bump(node), 0.0501);
  }
  FitOptions share;
  share.relative_tolerance = 0.05 / report.range;
  EXPECT_EQ(fit_kernels(mesh, share).num_kernels(), field.num_kernels());
}

// A straight line needs few kernels, whatever the places of the nodes.
TEST(FitKernels, StraightLinesNeedFew) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  const Dataset mesh = jittered_grid({14, 14, 14}, line, 0.3);
  FitReport report;
  fit_kernels(mesh, with_kernels(100), &report);
  EXPECT_GT(report.psnr, 38);
}

TEST(FitKernels, BallsAreBalls) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  const Dataset mesh = jittered_grid({10, 10, 10}, bump);
  FitOptions options = with_kernels(60);
  options.shape = KernelShape::kBalls;
  const KernelField field = fit_kernels(mesh, options);
  for (const model::OneKernel& kernel : model::kernels_of(field)) {
    const double sigma = kernel.factor(0, 0);
    EXPECT_LT((kernel.factor - Mat3(Mat3::Identity() * sigma)).cwiseAbs().maxCoeff(), 1e-6 * sigma);
  }
}

// Particles with an attribute, and a density, whose integral must stay.
TEST(FitKernels, ParticlesAndDensities) {
  OVOID_NOT_UNDER_TSAN();
  model::Random random(4);
  std::vector<Vec3> points;
  std::vector<float> values, masses;
  for (int i = 0; i < 4000; ++i) {
    points.emplace_back(random.uniform(0, 10), random.uniform(0, 10), random.uniform(0, 10));
    values.push_back(static_cast<float>(bump(points.back())));
    masses.push_back(static_cast<float>(0.2 + bump(points.back())));
  }
  Dataset particles = model::points_dataset(DatasetKind::kParticles, points, values);
  FitReport report;
  fit_kernels(particles, with_kernels(400), &report);
  EXPECT_GT(report.psnr, 36);
  particles.arrays.push_back(model::array_of_numbers("mass", 1, masses));
  FitOptions options = with_kernels(400);
  options.model.is_density = true;
  const KernelField density = fit_kernels(particles, options, &report);
  EXPECT_EQ(density.reconstruction(), Reconstruction::kSum);
  EXPECT_GT(report.psnr, 25);
  double mass = 0, whole = 0;
  for (const float one : masses) whole += static_cast<double>(one);
  const double integral = profile_integral(KernelProfile::kGaussian, density.source().cutoff());
  for (const model::OneKernel& kernel : model::kernels_of(density))
    mass += kernel.weight * static_cast<double>(kernel.values[0]) * integral *
            kernel.factor.diagonal().prod();
  EXPECT_NEAR(mass, whole, 0.002 * whole);
}

struct Scattered {
  Dataset particles;
  std::vector<Vec3> places;  // anywhere among them, also in gaps
};

Scattered scattered_bump() {
  model::Random random(6);
  const auto anywhere = [&](double margin) {
    return Vec3(random.uniform(margin, 10 - margin), random.uniform(margin, 10 - margin),
                random.uniform(margin, 10 - margin));
  };
  std::vector<Vec3> points;
  std::vector<float> values;
  for (int i = 0; i < 3000; ++i) {
    points.push_back(anywhere(0));
    values.push_back(static_cast<float>(bump(points.back())));
  }
  Scattered data{model::points_dataset(DatasetKind::kParticles, points, values), {}};
  for (int i = 0; i < 20'000; ++i) data.places.push_back(anywhere(0));
  return data;
}

// Fails if errors in the gaps between scattered places are not told: they are the greatest.
TEST(FitKernels, PsnrIsThatOfTheWholeDomain) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  const Scattered data = scattered_bump();
  FitReport report;
  const KernelField field = fit_kernels(data.particles, with_kernels(200), &report);
  const KernelField all = make_kernel_field(data.particles);
  const KernelSampler fitted(field), source(all);
  double square = 0, count = 0;
  for (const Vec3& place : data.places) {
    if (!source.at(place).is_defined) continue;
    const double error = fitted.at(place).value - source.at(place).value;
    square += error * error;
    count += 1;
  }
  EXPECT_NEAR(report.psnr, 20 * std::log10(report.range / std::sqrt(square / count)), 0.5);
}

// Fails if a bound is broken anywhere between scattered places.
TEST(FitKernels, ToleranceHoldsInGaps) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  const Scattered data = scattered_bump();
  FitOptions options;
  options.tolerance = 0.08;
  FitReport report;
  const KernelField field = fit_kernels(data.particles, options, &report);
  EXPECT_LE(report.greatest_error, 0.08);
  EXPECT_LT(field.num_kernels(), 2700);
  const KernelField all = make_kernel_field(data.particles);
  const KernelSampler fitted(field), source(all);
  double greatest = 0;
  for (const Vec3& place : data.places) {
    if (!source.at(place).is_defined) continue;
    ASSERT_TRUE(fitted.at(place).is_defined);
    const double error = fitted.at(place).value - source.at(place).value;
    greatest = std::max(greatest, static_cast<double>(std::abs(error)));
  }
  EXPECT_LE(greatest, 0.08);
}

// Balls of long cells leave places between them without a value, unless they are made wider.
TEST(FitKernels, BallsLeaveNoHoles) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  Dataset mesh = jittered_grid({12, 12, 12}, bump);
  std::vector<double> places;
  const auto* const at = reinterpret_cast<const double*>(mesh.positions.bytes.view.data());
  for (std::int64_t i = 0; i < 3 * mesh.num_positions(); ++i)
    places.push_back(i % 3 == 2 ? 12 * at[i] : at[i]);
  mesh.positions = model::array_of_numbers("positions", 3, std::move(places));
  FitOptions options = with_kernels(170);
  options.shape = KernelShape::kBalls;
  FitReport report;
  fit_kernels(mesh, options, &report);
  EXPECT_LT(report.wrongly_empty, 1e-4);
}

TEST(FitKernels, ThreadsLeaveNoTrace) {
  OVOID_NOT_UNDER_ASAN();
  const Dataset mesh = jittered_grid({10, 10, 10}, bump);
  const auto kernels = [&](int threads) {
    FitOptions options = with_kernels(90);
    options.threads = threads;
    return make_kernel_dataset(fit_kernels(mesh, options));
  };
  const Dataset of_one = kernels(1);
  for (const int threads : {2, 3}) {
    const Dataset same = kernels(threads);
    for (std::size_t a = 0; a < of_one.arrays.size(); ++a) {
      EXPECT_TRUE(std::ranges::equal(same.arrays[a].bytes.view, of_one.arrays[a].bytes.view))
          << of_one.arrays[a].name;
    }
  }
}

// Units of any size give the same picture.
TEST(FitKernels, UnitsLeaveNoTrace) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  const auto psnr = [](double unit) {
    Dataset mesh = jittered_grid({8, 8, 8}, bump);
    std::vector<double> places;
    const auto* const at = reinterpret_cast<const double*>(mesh.positions.bytes.view.data());
    for (std::int64_t i = 0; i < 3 * mesh.num_positions(); ++i) places.push_back(unit * at[i]);
    mesh.positions = model::array_of_numbers("positions", 3, std::move(places));
    FitReport report;
    fit_kernels(mesh, with_kernels(64), &report);
    return report.psnr;
  };
  // A place that rounding gives to another kernel changes all random places after it.
  const double in_one = psnr(1);
  EXPECT_NEAR(psnr(0x1p70), in_one, 0.5);
  EXPECT_NEAR(psnr(0x1p-30), in_one, 0.5);
}

TEST(FitKernels, OddDataAreFitted) {
  OVOID_NOT_UNDER_TSAN();
  // Constant values: nothing to err about.
  FitReport report;
  fit_kernels(jittered_grid({5, 5, 5}, [](const Vec3&) { return 7.0; }), with_kernels(10), &report);
  EXPECT_EQ(report.kernels, 10);
  EXPECT_LT(report.greatest_error, 1e-5);
  // One kernel; two particles at one place; more kernels than there are.
  Dataset one = model::points_dataset(DatasetKind::kParticles, {Vec3(1, 2, 3)});
  EXPECT_EQ(fit_kernels(one, with_kernels(5)).num_kernels(), 1);
  Dataset twice = model::points_dataset(DatasetKind::kParticles, {Vec3(1, 2, 3), Vec3(1, 2, 3)});
  EXPECT_LE(fit_kernels(twice, with_kernels(5)).num_kernels(), 2);
  // On a line, and in a plane.
  std::vector<Vec3> row, plane;
  for (int i = 0; i < 40; ++i) row.emplace_back(i, 0, 0);
  for (int i = 0; i < 100; ++i) plane.emplace_back(i % 10, i / 10, 0);
  EXPECT_EQ(fit_kernels(model::points_dataset(DatasetKind::kParticles, row), with_kernels(7))
                .num_kernels(),
            7);
  EXPECT_EQ(fit_kernels(model::points_dataset(DatasetKind::kParticles, plane), with_kernels(9))
                .num_kernels(),
            9);
  // A value that is missing makes no kernel.
  std::vector<float> values(40, 1.0F);
  values[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_LE(fit_kernels(model::points_dataset(DatasetKind::kParticles, row, values),
                        with_kernels(39), &report)
                .num_kernels(),
            39);
  EXPECT_EQ(report.source_kernels, 39);
}

void expect_refusal(const Dataset& dataset, const FitOptions& options, const std::string& words) {
  try {
    fit_kernels(dataset, options);
    FAIL() << "expected: " << words;
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

TEST(FitKernels, RefusesGoalsThatCannotBe) {
  OVOID_NOT_UNDER_TSAN();
  const Dataset mesh = jittered_grid({6, 6, 6}, bump);
  expect_refusal(mesh, {}, "0 given, expected one");
  FitOptions options = with_kernels(10);
  options.psnr = 30;
  expect_refusal(mesh, options, "2 given, expected one");
  expect_refusal(mesh, with_kernels(0), "kernels = 0");
  options = {};
  options.smooth = true;
  expect_refusal(mesh, options, "smooth: only a lattice tells its noise");
  options = {};
  options.psnr = 200;
  expect_refusal(mesh, options, "all 216 kernels reach");
  options.psnr = std::nan("");
  expect_refusal(mesh, options, "psnr = nan");
  options = {};
  options.tolerance = 1e-9;
  expect_refusal(mesh, options, "leave a greatest error of");
  options.tolerance = 0;
  expect_refusal(mesh, options, "tolerance = 0: must be > 0");
  options = {};
  options.bytes = 100;
  expect_refusal(mesh, options, "bytes = 100: a file with one kernel has");
  options = with_kernels(10);
  options.memory_limit = 1000;
  expect_refusal(mesh, options, "more than the limit");
}

// Fails if the last steps bring nothing, or come uncalled.
TEST(FitKernels, RefinementIsWorthIt) {
  const Dataset mesh = jittered_grid({12, 12, 12}, bump);
  FitOptions options = with_kernels(40);
  FitReport without, with;
  options.refinements = 0;
  fit_kernels(mesh, options, &without);
  options.refinements = 4;
  fit_kernels(mesh, options, &with);
  EXPECT_GT(with.psnr, without.psnr + 6);
  EXPECT_LE(with.wrongly_empty, without.wrongly_empty + 1e-3);
}

// Fails if a colour that is the same everywhere, in units of its range, drowns the values' errors.
TEST(FitKernels, ConstantColoursLeaveNoTrace) {
  OVOID_NOT_UNDER_ASAN();
  Dataset mesh = jittered_grid({8, 8, 8}, bump);
  FitOptions options = with_kernels(40);
  options.model.array = "v";
  FitReport without, with;
  fit_kernels(mesh, options, &without);
  mesh.arrays.push_back(model::array_of_numbers("c", 1, std::vector<float>(8 * 8 * 8, 5.F)));
  options.model.color_array = "c";
  const KernelField field = fit_kernels(mesh, options, &with);
  EXPECT_NEAR(with.psnr, without.psnr, 1);
  EXPECT_NEAR(KernelSampler(field).at(Vec3(4, 4, 4)).color_value, 5, 1e-3);
}

// Of many cells some are looked at, here every twentieth, which are not those of one plane.
TEST(FitKernels, PlacesOfLargeGridsAreEverywhere) {
  const Dataset mesh = jittered_grid({21, 21, 21}, bump);
  FitOptions options = with_kernels(8);
  FitReport with, without;
  fit_kernels(mesh, options, &with);
  options.refinements = 0;
  fit_kernels(mesh, options, &without);
  EXPECT_GT(with.psnr, without.psnr + 3);
}

// Surfaces have no cell to interpolate in: places near their kernels judge.
TEST(FitKernels, MeshesWithoutSolidCellsAreJudged) {
  Dataset mesh = jittered_grid({16, 16, 1}, bump);
  FitOptions options;
  options.psnr = 40;
  FitReport report;
  fit_kernels(mesh, options, &report);
  EXPECT_GT(report.test_places, 1000);
  EXPECT_TRUE(std::isfinite(report.psnr));
  EXPECT_GT(report.psnr, 39);
}

TEST(FitKernels, StopsWhenItIsTold) {
  const Dataset mesh = jittered_grid({10, 10, 10}, bump);
  std::stop_source stop;
  FitOptions options = with_kernels(90);
  options.stop = stop.get_token();
  double last = 0;
  options.progress = [&](double fraction) {
    EXPECT_GE(fraction, last);
    last = fraction;
    if (fraction > 0.2) stop.request_stop();
  };
  try {
    fit_kernels(mesh, options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCancelled);
  }
}

}  // namespace fit_kernels_test
}  // namespace ovoid
