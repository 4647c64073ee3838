// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "fit/level_fitter.h"
#include "io/images/test_volumes.h"
#include "model/lattice/noise.h"
#include "model/test_datasets.h"
#include "ovoid/error.h"
#include "ovoid/fit.h"
#include "support/where.h"

namespace ovoid {
namespace fit_lattice_test {

using fit::LevelFitter;
using io::values_of;

// A ball with a soft edge, a plate with a sharp one, and a slow wave.
double scene(double x, double y, double z) {
  const double ball = 1 / (1 + std::exp(2 * (std::hypot(x - 14, y - 12, z - 10) - 6)));
  const double plate = x > 22 && y > 4 && y < 20 ? 0.7 : 0;
  return 100 * std::max(ball, plate) + 5 * std::sin(0.3 * x + 0.2 * y);
}

Dataset lattice_of(const Index3& dims, const std::function<double(double, double, double)>& value) {
  Dataset dataset;
  dataset.lattice.dims = dims;
  std::vector<float> values;
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    for (std::int64_t y = 0; y < dims[1]; ++y) {
      for (std::int64_t x = 0; x < dims[0]; ++x)
        values.push_back(static_cast<float>(
            value(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z))));
    }
  }
  dataset.arrays = {io::make_array("v", ScalarType::kFloat32, values)};
  return dataset;
}

const Dataset& scan() {
  static const Dataset dataset = lattice_of({30, 25, 20}, scene);
  return dataset;
}

struct Errors {
  double psnr = 0, greatest = 0;
};
Errors errors_of(const Dataset& dataset, const LatticeLevels& levels) {
  const std::vector<float> theirs = values_of<float>(dataset.array()), ours = samples_of(levels);
  const auto [lo, hi] = std::minmax_element(theirs.begin(), theirs.end());
  double square = 0, greatest = 0;
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    const double error = static_cast<double>(theirs[i]) - static_cast<double>(ours[i]);
    square += error * error;
    greatest = std::max(greatest, std::abs(error));
  }
  const double rms = std::sqrt(square / static_cast<double>(theirs.size()));
  return {20 * std::log10((static_cast<double>(*hi) - static_cast<double>(*lo)) / rms), greatest};
}

FitOptions lattice_psnr(double psnr) {
  FitOptions options;
  options.psnr = psnr;
  return options;
}
FitOptions lattice_kernels(std::int64_t count) {
  FitOptions options;
  options.kernels = count;
  return options;
}
FitOptions lattice_tolerance(double tolerance) {
  FitOptions options;
  options.tolerance = tolerance;
  return options;
}

std::vector<float> odd_numbers(std::size_t count) {
  std::vector<float> numbers(count);
  for (std::size_t i = 0; i < count; ++i)
    numbers[i] = static_cast<float>(std::sin(12.9898 * static_cast<double>(i * i % 1009)));
  return numbers;
}

// Fails if a pair of kernels is missed, or found twice.
TEST(LevelPairs, AreTheProductsThroughTheSamples) {
  const data::LevelBasis basis({21, 14, 9}, 4);
  std::vector<std::uint32_t> nodes;
  for (std::uint32_t node = 0; node < basis.num_weights(); node += 1 + node % 5)
    nodes.push_back(node);
  const std::vector<float> some = odd_numbers(nodes.size());
  std::vector<float> weights(basis.num_weights()), samples(basis.num_samples()),
      products(basis.num_weights());
  for (std::size_t i = 0; i < nodes.size(); ++i) weights[nodes[i]] = some[i];
  basis.expand(weights, 0, 4, 1, samples, {2});
  basis.reduce(samples, 0, 4, products, {2});

  fit::LevelPairs pairs(basis);
  ASSERT_TRUE(pairs.assemble(nodes, 1 << 24, {2}));
  const std::vector<double> values(some.begin(), some.end());
  std::vector<double> out(nodes.size()), again(nodes.size());
  pairs.multiply(values, out, {2});
  pairs.multiply(values, again, {1});
  EXPECT_EQ(out, again);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    EXPECT_NEAR(out[i], static_cast<double>(products[nodes[i]]), 2e-4) << nodes[i];
  EXPECT_FALSE(pairs.assemble(nodes, 100, {2}));
}

// Fails if the weights are not those of least squares: a direct solution of the normal equations is
// the oracle.
TEST(LevelFitter, AgreesWithADirectSolution) {
  const Index3 dims{12, 9, 7};
  const std::vector<float> samples = odd_numbers(static_cast<std::size_t>(num_samples(dims)));
  LevelFitter fitter(dims, samples, {}, {2});
  fitter.start(0.8);
  ASSERT_GT(fitter.num_kernels(), 20);
  ASSERT_LT(fitter.num_kernels(), 600);
  fitter.fit(400);
  std::vector<std::size_t> nodes;
  for (std::size_t node = 0; node < fitter.weights().size(); ++node) {
    if (fitter.is_kernel(node)) nodes.push_back(node);
  }
  ASSERT_EQ(static_cast<std::int64_t>(nodes.size()), fitter.num_kernels());
  const auto count = static_cast<Eigen::Index>(nodes.size());
  Eigen::MatrixXd kernels(static_cast<Eigen::Index>(samples.size()), count);
  for (Eigen::Index c = 0; c < count; ++c) {
    std::vector<float> one(fitter.weights().size()), column(samples.size());
    one[nodes[static_cast<std::size_t>(c)]] = 1;
    fitter.basis().expand(one, 0, fitter.basis().num_levels(), 1, column, {1});
    for (std::size_t i = 0; i < column.size(); ++i)
      kernels(static_cast<Eigen::Index>(i), c) = static_cast<double>(column[i]);
  }
  Eigen::VectorXd wanted(static_cast<Eigen::Index>(samples.size()));
  for (std::size_t i = 0; i < samples.size(); ++i)
    wanted[static_cast<Eigen::Index>(i)] = static_cast<double>(samples[i]);
  const Eigen::VectorXd direct =
      (kernels.transpose() * kernels).ldlt().solve(kernels.transpose() * wanted);
  const double least =
      (wanted - kernels * direct).squaredNorm() / static_cast<double>(samples.size());
  EXPECT_NEAR(fitter.mean_square(), least, 1e-4 * least);
}

// With no memory for the matrix a fit goes through the samples, to the same end.
TEST(LevelFitter, WithoutTheMatrixIsTheSame) {
  const Index3 dims{12, 9, 7};
  const std::vector<float> samples = odd_numbers(static_cast<std::size_t>(num_samples(dims)));
  LevelFitter with(dims, samples, {}, {2}), without(dims, samples, {}, {2}, 10);
  for (LevelFitter* const fitter : {&with, &without}) {
    fitter->start(0.8);
    fitter->fit(40);
  }
  ASSERT_EQ(with.num_kernels(), without.num_kernels());
  EXPECT_NEAR(with.mean_square(), without.mean_square(), 1e-4 * with.mean_square());
}

// Where samples are the least there is, kernels may go below it. Fails if that counts as an error,
// if it does not where a sample is greater, or if a fit makes the sum of squares greater.
TEST(LevelFitter, WhatIsClampedIsNoError) {
  const Index3 dims{32, 12, 12};
  std::vector<float> samples;
  for (std::int64_t i = 0; i < num_samples(dims); ++i)
    samples.push_back(std::max(0.0F, std::sin(0.6F * static_cast<float>(i % dims[0]))));
  LevelFitter free(dims, samples, {}, {2}), clamped(dims, samples, {0, 1}, {2}),
      without_matrix(dims, samples, {0, 1}, {2}, 10);
  for (LevelFitter* const fitter : {&free, &clamped, &without_matrix}) {
    fitter->start(0.2);
    fitter->prune(400);
    double before = fitter->mean_square();
    for (int round = 0; round < 10; ++round) {
      fitter->fit(10);
      EXPECT_LE(fitter->mean_square(), before * (1 + 1e-6));
      before = fitter->mean_square();
    }
  }
  EXPECT_LT(clamped.mean_square(), 0.7 * free.mean_square());
  EXPECT_NEAR(without_matrix.mean_square(), clamped.mean_square(), 0.01 * clamped.mean_square());
  std::vector<float> sums(samples.size());
  clamped.basis().expand(clamped.weights(), 0, clamped.basis().num_levels(), 1, sums, {1});
  EXPECT_LT(*std::min_element(sums.begin(), sums.end()), -0.01F);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const float lowest = samples[i] == 0 ? 0 : -1;
    ASSERT_NEAR(clamped.residual()[i], samples[i] - std::max(lowest, sums[i]), 1e-5);
  }
}

TEST(LevelFitter, GrowsByTheBestAndPrunesTheLeast) {
  const Index3 dims{20, 20, 20};
  std::vector<float> samples(8000);
  samples[20 * 20 * 10 + 20 * 10 + 10] = 9;  // one sample alone
  LevelFitter fitter(dims, samples, {}, {2});
  fitter.grow(1);
  EXPECT_EQ(fitter.num_kernels(), 1);
  EXPECT_TRUE(fitter.is_kernel(20 * 20 * 10 + 20 * 10 + 10));
  fitter.grow(30);
  fitter.fit(30);
  EXPECT_EQ(fitter.num_kernels(), 31);
  fitter.prune(5);
  EXPECT_EQ(fitter.num_kernels(), 5);
  EXPECT_TRUE(fitter.is_kernel(20 * 20 * 10 + 20 * 10 + 10));
}

TEST(FitLattice, PsnrIsThatOfTheSamplesThatAreRead) {
  OVOID_NOT_UNDER_TSAN();
  FitReport report;
  const LatticeLevels levels = fit_lattice(scan(), lattice_psnr(40), &report);
  const Errors errors = errors_of(scan(), levels);
  EXPECT_GE(errors.psnr, 40);
  EXPECT_LT(errors.psnr, 40.5);
  EXPECT_NEAR(report.psnr, errors.psnr, 1e-3);
  EXPECT_NEAR(report.greatest_error, errors.greatest, 1e-3);
  EXPECT_EQ(report.kernels, levels.num_kernels());
  EXPECT_EQ(report.source_kernels, 15000);
  EXPECT_LT(report.kernels, 15000 / 6);
  EXPECT_EQ(report.array, "v");
}

TEST(FitLattice, AskedKernelsAreMany) {
  OVOID_NOT_UNDER_TSAN();
  double before = 0;
  for (const std::int64_t count : {100, 400, 1600}) {
    FitReport report;
    const LatticeLevels levels = fit_lattice(scan(), lattice_kernels(count), &report);
    EXPECT_LE(levels.num_kernels(), count);
    EXPECT_GT(levels.num_kernels(), count * 9 / 10);
    EXPECT_GT(report.psnr, before + 3);
    before = report.psnr;
  }
}

// Waves of 40 samples and more, over 200.
double waves(double x, double y, double z) {
  return 100 + 60 * std::sin(0.15 * x + 0.05 * y) * std::cos(0.1 * z) + 40 * std::sin(0.12 * y);
}

// With normal noise of that deviation.
Dataset noisy_waves(double deviation) {
  model::Random random(5);
  return lattice_of({40, 36, 32}, [&](double x, double y, double z) {
    const double normal = std::sqrt(-2 * std::log(1 - random.uniform(0, 1))) *
                          std::cos(2 * std::acos(-1.0) * random.uniform(0, 1));
    return waves(x, y, z) + deviation * normal;
  });
}

double rms_to_waves(const std::vector<float>& samples) {
  double square = 0;
  std::size_t i = 0;
  for (int z = 0; z < 32; ++z) {
    for (int y = 0; y < 36; ++y) {
      for (int x = 0; x < 40; ++x)
        square += std::pow(static_cast<double>(samples[i++]) - waves(x, y, z), 2);
    }
  }
  return std::sqrt(square / static_cast<double>(samples.size()));
}

// Fails if the noise is not found to 5 %, if the fit's error is another, or if it does not come
// nearer to what was there before the noise: the more so, the more noise there is.
TEST(FitLattice, SmoothTakesTheNoiseAway) {
  const std::pair<double, double> gains[] = {{1.0, 0.5}, {4.0, 3.0}, {12.0, 6.0}};
  for (const auto& [deviation, least_gain] : gains) {
    const Dataset noisy = noisy_waves(deviation);
    FitOptions options;
    options.smooth = true;
    FitReport report;
    const LatticeLevels levels = fit_lattice(noisy, options, &report);
    EXPECT_NEAR(report.noise, deviation, 0.05 * deviation);
    EXPECT_NEAR(report.psnr, 20 * std::log10(report.range / report.noise), 0.11);
    const double before = rms_to_waves(values_of<float>(noisy.array()));
    const double gain = 20 * std::log10(before / rms_to_waves(samples_of(levels)));
    EXPECT_GT(gain, least_gain) << deviation;
  }
}

// Numbers of a scanner, with a slope of their own, in a background that was set to 0, along unequal
// axes: the error is that of the noise over all samples.
TEST(FitLattice, SmoothKnowsNumbersMasksAndSpacings) {
  Dataset noisy = noisy_waves(12);
  std::vector<float> values = values_of<float>(noisy.array());
  std::vector<std::int16_t> stored;
  for (std::size_t i = 0; i < values.size(); ++i)
    stored.push_back(static_cast<std::int16_t>(i % 40 < 20 ? 0 : std::lround(values[i])));
  noisy.arrays = {io::make_array("v", ScalarType::kInt16, stored)};
  noisy.arrays[0].value_scale = 0.5;
  noisy.lattice.world_from_index = Eigen::Scaling(1.0, 1.0, 3.0);
  FitOptions options;
  options.smooth = true;
  FitReport report;
  const LatticeLevels levels = fit_lattice(noisy, options, &report);
  EXPECT_NEAR(report.noise, 6 * std::sqrt(0.5), 0.05 * 6);
  EXPECT_NEAR(report.psnr, 20 * std::log10(report.range / report.noise), 0.11);
}

// Every sample is looked at: of plates and balls, and of noise, where nothing is smooth.
TEST(FitLattice, ToleranceHoldsAtEverySample) {
  OVOID_NOT_UNDER_TSAN();
  const Dataset noise = lattice_of({20, 17, 13}, [](double x, double y, double z) {
    return std::sin(12.9898 * x * x + 78.233 * y * z + 3.7 * z * z);
  });
  for (const double tolerance : {2.0, 5.0, 20.0}) {
    const LatticeLevels levels = fit_lattice(scan(), lattice_tolerance(tolerance));
    EXPECT_LE(errors_of(scan(), levels).greatest, tolerance);
    EXPECT_LT(levels.num_kernels(), 15000 / 2);
  }
  const LatticeLevels levels = fit_lattice(noise, lattice_tolerance(0.9));
  EXPECT_LE(errors_of(noise, levels).greatest, 0.9);
}

TEST(FitLattice, ThreadsLeaveNoTrace) {
  FitOptions options = lattice_psnr(38);
  options.threads = 1;
  const LatticeLevels one = fit_lattice(scan(), options);
  options.threads = 3;
  const LatticeLevels three = fit_lattice(scan(), options);
  ASSERT_EQ(one.levels.size(), three.levels.size());
  for (std::size_t l = 0; l < one.levels.size(); ++l) {
    EXPECT_EQ(one.levels[l].nodes, three.levels[l].nodes);
    EXPECT_EQ(one.levels[l].weights, three.levels[l].weights);
  }
  EXPECT_EQ(one.step, three.step);
}

TEST(FitLattice, OddLatticesAreFitted) {
  OVOID_NOT_UNDER_TSAN();
  // One value: no kernels, and no error.
  FitReport report;
  const LatticeLevels constant = fit_lattice(
      lattice_of({6, 5, 4}, [](double, double, double) { return 7.5; }), lattice_psnr(60), &report);
  EXPECT_EQ(constant.num_kernels(), 0);
  EXPECT_EQ(samples_of(constant), std::vector<float>(120, 7.5F));
  EXPECT_EQ(report.psnr, std::numeric_limits<double>::infinity());
  // A single sample, a line, a plate.
  EXPECT_EQ(samples_of(fit_lattice(lattice_of({1, 1, 1}, scene), lattice_kernels(3))).size(), 1U);
  for (const Index3 dims : {Index3{200, 1, 1}, Index3{1, 1, 90}, Index3{40, 1, 30}}) {
    const Dataset thin = lattice_of(dims, [](double x, double, double z) {
      return std::sin(0.2 * x + 0.5) * std::cos(0.3 * z);
    });
    EXPECT_GE(errors_of(thin, fit_lattice(thin, lattice_psnr(30))).psnr, 30);
  }
  // A scanner's numbers are fitted as they are stored, and stay whole.
  std::vector<std::int16_t> stored;
  for (const float value : values_of<float>(scan().array()))
    stored.push_back(static_cast<std::int16_t>(std::lround(value)));
  Dataset scaled = scan();
  scaled.arrays = {io::make_array("hu", ScalarType::kInt16, stored)};
  scaled.arrays[0].value_scale = 10;
  scaled.arrays[0].value_offset = -1000;
  FitReport of_scaled;
  const LatticeLevels levels = fit_lattice(scaled, lattice_psnr(35), &of_scaled);
  EXPECT_TRUE(levels.whole);
  EXPECT_EQ(levels.least, *std::min_element(stored.begin(), stored.end()));
  EXPECT_NEAR(of_scaled.range, 10 * (levels.greatest - levels.least), 1e-9);
  double greatest = 0;
  const std::vector<float> back = samples_of(levels);
  for (std::size_t i = 0; i < back.size(); ++i) {
    EXPECT_EQ(back[i], std::round(back[i]));
    greatest = std::max(greatest, 10 * std::abs(static_cast<double>(back[i]) - stored[i]));
  }
  EXPECT_NEAR(of_scaled.greatest_error, greatest, 1e-9);
  // A bound is one of values.
  const std::vector<float> within = samples_of(fit_lattice(scaled, lattice_tolerance(60)));
  for (std::size_t i = 0; i < within.size(); ++i)
    EXPECT_LE(std::abs(static_cast<double>(within[i]) - stored[i]), 6);
}

TEST(FitLattice, RefusesWhatCannotBe) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  const auto expect_refusal = [](const Dataset& dataset, const FitOptions& options,
                                 const std::string& words) {
    try {
      fit_lattice(dataset, options);
      ADD_FAILURE() << "expected: " << words;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  expect_refusal(scan(), {}, "0 given, expected one");
  expect_refusal(scan(), lattice_psnr(400), "half as many kernels as samples reach");
  expect_refusal(scan(), lattice_tolerance(1e-6),
                 "takes more than half as many kernels as samples");
  FitOptions options;
  options.smooth = true;
  expect_refusal(noisy_waves(0), options, "'v' has no noise that can be told");
  options.psnr = 30;
  expect_refusal(scan(), options, "2 given, expected one");
  options = {};
  options.bytes = 100;
  expect_refusal(scan(), options, "bytes = 100: a file without kernels has");
  options = lattice_kernels(10);
  options.memory_limit = 1000;
  expect_refusal(scan(), options, "more than the limit");
  Dataset other = scan();
  other.lattice.kind = LatticeKind::kBodyCentred;
  expect_refusal(other, lattice_kernels(3), "body-centred: expected the Cartesian lattice");
  expect_refusal(model::grid_dataset({3, 3, 3}, [](const Vec3& p) { return p; }),
                 lattice_kernels(3), "is no lattice");
}

// Missing samples stay missing, the first and the last, too; those that are there are held to the
// goal, and holes cost hardly a kernel.
TEST(FitLattice, HolesStayHoles) {
  const auto is_hole = [](double x, double y, double z) {
    return std::hypot(x - 8, y - 8, z - 8) < 5 || x + y + z == 0 || x + y + z == 72;
  };
  const Dataset holes = lattice_of({30, 25, 20}, [&](double x, double y, double z) {
    return is_hole(x, y, z) ? std::nan("") : scene(x, y, z);
  });
  const std::vector<float> samples = values_of<float>(holes.array());
  FitReport whole, report;
  fit_lattice(scan(), lattice_psnr(40), &whole);
  const LatticeLevels levels = fit_lattice(holes, lattice_psnr(40), &report);
  EXPECT_LT(report.kernels, whole.kernels * 105 / 100);
  FitOptions bound;
  bound.relative_tolerance = 0.02;
  FitReport report_of_bound;
  const LatticeLevels bounded = fit_lattice(holes, bound, &report_of_bound);
  for (const LatticeLevels* const fitted : {&levels, &bounded}) {
    const std::vector<float> read = samples_of(*fitted);
    double square = 0, count = 0, greatest = 0;
    for (std::size_t i = 0; i < read.size(); ++i) {
      ASSERT_EQ(std::isnan(read[i]), std::isnan(samples[i])) << i;
      if (std::isnan(read[i])) continue;
      const double error = static_cast<double>(read[i] - samples[i]);
      square += error * error;
      greatest = std::max(greatest, std::abs(error));
      ++count;
    }
    if (fitted == &levels) {
      const double psnr = 20 * std::log10(report.range / std::sqrt(square / count));
      EXPECT_GE(psnr, 40);
      EXPECT_NEAR(report.psnr, psnr, 1e-3);
    } else {
      EXPECT_LE(greatest, 0.02 * report.range * (1 + 1e-6));
    }
  }
}

// Never more than asked for, by what the file will have at most; and not much less.
TEST(FitLattice, BytesAreFilledAndNotExceeded) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  for (const std::int64_t bytes : {15000}) {
    FitOptions options;
    options.bytes = bytes;
    FitReport report;
    const LatticeLevels levels = fit_lattice(scan(), options, &report);
    EXPECT_LE(report.bytes, bytes);
    EXPECT_GT(report.bytes, bytes * 9 / 10);
    EXPECT_EQ(report.kernels, levels.num_kernels());
  }
}

TEST(FitLattice, StopsWhenItIsTold) {
  std::stop_source stop;
  FitOptions options = lattice_psnr(40);
  options.stop = stop.get_token();
  double last = 0;
  options.progress = [&](double fraction) {
    EXPECT_GE(fraction, last);
    last = fraction;
    if (fraction > 0.2) stop.request_stop();
  };
  try {
    fit_lattice(scan(), options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCancelled);
  }
}

}  // namespace fit_lattice_test
}  // namespace ovoid
