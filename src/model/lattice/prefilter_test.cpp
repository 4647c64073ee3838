// SPDX-License-Identifier: Apache-2.0
#include "model/lattice/prefilter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "model/lattice/holes.h"
#include "model/own_array.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "ovoid/sampler.h"
#include "support/numbers.h"
#include "support/where.h"

namespace ovoid::model {
namespace prefilter_test {

// One axis' kernel by docs/numerics.md, at the distance d.
double one_axis(const LatticeKernel& kernel, double d) {
  const double a = std::abs(d);
  if (kernel.kind == LatticeKernelKind::kBSpline)
    return a < 1 ? 2.0 / 3 - a * a + a * a * a / 2 : a < 2 ? std::pow(2 - a, 3) / 6 : 0;
  if (kernel.kind == LatticeKernelKind::kCatmullRom)
    return a < 1   ? 1 - 2.5 * a * a + 1.5 * a * a * a
           : a < 2 ? 2 - 4 * a + 2.5 * a * a - a * a * a / 2
                   : 0;
  const double reach = kernel.support_radius();
  const double part = a == reach ? 0.5 : a < reach ? 1.0 : 0.0;
  return part * std::exp(-0.5 * d * d / (kernel.sigma * kernel.sigma));
}

double mass_of(const LatticeKernel& kernel) {
  return kernel.kind == LatticeKernelKind::kGaussian
             ? std::sqrt(2 * std::numbers::pi) * kernel.sigma
             : 1.0;
}

// The field at sample (x, y, z) by docs/numerics.md, every existing kernel, no product form, in
// double.
double field_at_sample(const std::vector<float>& coefficients, const Index3& dims, const Index3& at,
                       const PrefilterOptions& options) {
  double numerator = 0;
  double denominator = 0;
  std::size_t index = 0;
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    for (std::int64_t y = 0; y < dims[1]; ++y) {
      for (std::int64_t x = 0; x < dims[0]; ++x, ++index) {
        if (!std::isfinite(coefficients[index])) continue;
        const double phi = one_axis(options.kernel, static_cast<double>(x - at[0])) *
                           one_axis(options.kernel, static_cast<double>(y - at[1])) *
                           one_axis(options.kernel, static_cast<double>(z - at[2]));
        numerator += coefficients[index] * phi;
        denominator += phi;
      }
    }
  }
  if (options.reconstruction == Reconstruction::kNormalized) return numerator / denominator;
  return numerator / std::pow(mass_of(options.kernel), 3);
}

std::vector<float> random_samples(const Index3& dims, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(-1, 1);
  std::vector<float> samples(static_cast<std::size_t>(num_samples(dims)));
  for (float& sample : samples) sample = value(random);
  return samples;
}

// Greatest difference of the filtered field from the samples, over the samples for which `counts`.
template <class Counts>
double greatest_error(const std::vector<float>& samples, const Index3& dims,
                      const PrefilterOptions& options, const Counts& counts) {
  std::vector<float> coefficients = samples;
  prefilter(coefficients, dims, options);
  double greatest = 0;
  std::size_t index = 0;
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    for (std::int64_t y = 0; y < dims[1]; ++y) {
      for (std::int64_t x = 0; x < dims[0]; ++x, ++index) {
        if (!counts(Index3{x, y, z})) continue;
        const double value = field_at_sample(coefficients, dims, {x, y, z}, options);
        greatest = std::max(greatest, std::abs(value - samples[index]));
      }
    }
  }
  return greatest;
}

const auto kEverySample = [](const Index3&) { return true; };

// Flat, long and odd lattices, lines shorter than the band, more lines than one batch of 16.
const std::vector<Index3> kSizes = {{1, 1, 1},  {2, 1, 1}, {3, 2, 1},    {1, 7, 1},
                                    {1, 1, 40}, {9, 7, 5}, {18, 17, 19}, {33, 4, 3}};

// Fails if a face is treated like the inside, an axis is left out, or a line's factors are used for
// another length. Random samples are the hardest: coefficients reach 27 times the samples, of the
// published kernel 5.3 times, and are sums in floats: 2e-6 of samples up to 1 is 1e-6 of the range.
TEST(Prefilter, MakesTheFieldTakeTheSamplesValues) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  for (const LatticeKernel& kernel : {LatticeKernel{}, kBSplineKernel, kCatmullRomKernel}) {
    for (const auto reconstruction : {Reconstruction::kNormalized, Reconstruction::kSum}) {
      for (const Index3& dims : kSizes) {
        const PrefilterOptions options = {kernel, reconstruction, 2, {}};
        EXPECT_LT(greatest_error(random_samples(dims, 5), dims, options, kEverySample), 2e-6)
            << name_of(kernel.kind) << ", " << dims[0] << " x " << dims[1] << " x " << dims[2];
      }
    }
  }
}

// Of a body-centred lattice: every sample of both sublattices, by the reference's evaluator.
// Fails if a sublattice, a shift of half an axis vector or a face is not in the operator.
TEST(Prefilter, MakesBodyCentredFieldsTakeTheSamplesValues) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  for (const LatticeKernel& kernel : {LatticeKernel{}, LatticeKernel{0.6}, kBSplineKernel}) {
    for (const auto reconstruction : {Reconstruction::kNormalized, Reconstruction::kSum}) {
      for (const Index3& dims : {Index3{2, 2, 4}, Index3{5, 4, 9}, Index3{13, 12, 16}}) {
        std::vector<float> samples = random_samples(dims, 7);
        Dataset dataset;
        dataset.kind = DatasetKind::kLattice;
        dataset.lattice = {dims, Affine3::Identity(), LatticeKind::kBodyCentred};
        dataset.arrays = {array_of_numbers("v", 1, samples)};
        LatticeModelOptions options;
        options.kernel = kernel;
        options.prefilter = true;
        options.reconstruction = reconstruction;
        const LatticeField field = make_lattice_field(dataset, options);
        const FieldSampler sampler(field);
        std::size_t index = 0;
        for (std::int64_t k = 0; k < dims[2]; ++k)
          for (std::int64_t j = 0; j < dims[1]; ++j)
            for (std::int64_t i = 0; i < dims[0]; ++i, ++index)
              EXPECT_NEAR(sampler.at(dataset.lattice.index_position({i, j, k})).value,
                          samples[index], 4e-5)
                  << name_of(kernel.kind) << kernel.sigma << " " << i << " " << j << " " << k;
      }
    }
  }
}

// Fails if the band is not floor(support radius) wide. The bound is 1e-5 of the range, 2: the
// widest kernel amplifies 27 times per axis before the field averages that away again.
TEST(Prefilter, HoldsForOtherKernels) {
  const Index3 dims = {12, 11, 10};
  for (const LatticeKernel kernel : {LatticeKernel{0.3, 2.0}, LatticeKernel{0.5, 3.0},
                                     LatticeKernel{0.7, 4.0}, LatticeKernel{0.9, 4.5}}) {
    const PrefilterOptions options = {kernel, Reconstruction::kNormalized, 1, {}};
    EXPECT_LT(greatest_error(random_samples(dims, 6), dims, options, kEverySample), 2e-5)
        << "sigma " << kernel.sigma;
  }
}

// The rows of the normalized system sum to one, so a constant is its own solution; float rounding,
// three times.
TEST(Prefilter, LeavesAConstantAlone) {
  std::vector<float> samples(17 * 9 * 8, -1000.0F);
  prefilter(samples, {17, 9, 8}, {});
  for (const float value : samples) ASSERT_NEAR(value, -1000.0F, 3 * 1000 * 0x1p-23);
}

// Closed forms: (2/3 - 2/6) / 1; what interpolates responds alike to all.
TEST(Prefilter, LeastResponseOfPiecewiseKernels) {
  EXPECT_NEAR(least_response(kBSplineKernel), 1.0 / 3, 1e-12);
  EXPECT_NEAR(least_response(kCatmullRomKernel), 1.0, 1e-12);
}

// [METHOD 7.3.2]: 0.574 on one axis, 0.189 in the worst point of three. Closed form with g1 = e^-2,
// g2 = e^-8, which lies on the cut-off and counts half.
TEST(Prefilter, LeastResponseOfTheDefaultKernel) {
  const double g1 = std::exp(-2.0);
  const double g2 = std::exp(-8.0);
  const double response = least_response(LatticeKernel{});
  EXPECT_NEAR(response, (1 - 2 * g1 + g2) / (1 + 2 * g1 + g2), 1e-12);
  EXPECT_NEAR(response, 0.574, 0.0005);
  EXPECT_NEAR(response * response * response, 0.189, 0.0005);
}

// With g1 alone (support 1.5) the response to one sample decays by the root of z^2 + z / g1 + 1
// that is within the unit circle: -0.1379 [METHOD 7.3.2]. Float keeps four digits after five steps.
TEST(Prefilter, ImpulseDecaysByThePole) {
  std::vector<float> line(41, 0.0F);
  line[20] = 1.0F;
  prefilter(line, {41, 1, 1}, {LatticeKernel{0.5, 3.0}, Reconstruction::kNormalized, 1, {}});
  const double g1 = std::exp(-2.0);
  const double pole = (std::sqrt(1 / (g1 * g1) - 4) - 1 / g1) / 2;
  EXPECT_NEAR(pole, -0.1379, 0.0001);
  for (int i = 20; i < 25; ++i) EXPECT_NEAR(line[i + 1] / line[i], pole, 1e-4);
  for (int i = 20; i > 15; --i) EXPECT_NEAR(line[i - 1] / line[i], pole, 1e-4);
}

TEST(Prefilter, RefusesKernelsThatCannotInterpolate) {
  EXPECT_NO_THROW(require_interpolating({0.96, 4.0}));
  // A short, flat kernel has its least response between the frequencies 0 and 1/2, and it is
  // negative: a check of 1/2 alone (0.83 here) would let it pass.
  EXPECT_LT(least_response({4.0, 0.5}), 0);
  for (const LatticeKernel kernel : {LatticeKernel{0.97, 4.0}, LatticeKernel{4.0, 0.5}}) {
    try {
      std::vector<float> samples(8);
      prefilter(samples, {2, 2, 2}, {kernel, Reconstruction::kNormalized, 1, {}});
      FAIL() << "accepted sigma " << kernel.sigma;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      EXPECT_NE(std::string(error.what()).find("sigma"), std::string::npos) << error.what();
    }
  }
}

// Holes stay holes, everything else stays a number, and away from them (reach 2, and 0.1379^6 <
// 1e-5 of influence through the filled samples' neighbours is none at all: the system holds row by
// row) the field is exact.
TEST(Prefilter, KeepsHolesAndIsExactAwayFromThem) {
  const Index3 dims = {14, 13, 12};
  std::vector<float> samples = random_samples(dims, 9);
  const auto index = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    return static_cast<std::size_t>(x + dims[0] * (y + dims[1] * z));
  };
  samples[index(4, 5, 6)] = kNanF;
  samples[index(5, 5, 6)] = std::numeric_limits<float>::infinity();
  samples[index(4, 5, 7)] = -std::numeric_limits<float>::infinity();
  const auto is_away = [](const Index3& at) {
    return at[0] < 2 || at[0] > 7 || at[1] < 3 || at[1] > 7 || at[2] < 4 || at[2] > 9;
  };
  EXPECT_LT(greatest_error(samples, dims, {}, is_away), 2e-6);
  std::vector<float> coefficients = samples;
  prefilter(coefficients, dims, {});
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(std::isnan(coefficients[i]), !std::isfinite(samples[i])) << i;
  }
}

// Fails if an overflowing coefficient becomes infinite, which would make a sample missing.
TEST(Prefilter, CoefficientsStayFinite) {
  std::vector<float> line = {0, 0, 3e38F, -3e38F, 3e38F, 0, 0};
  prefilter(line, {7, 1, 1}, {});
  for (const float value : line) EXPECT_TRUE(std::isfinite(value));
}

TEST(Prefilter, DoesNotDependOnTheNumberOfThreads) {
  const Index3 dims = {70, 41, 50};
  std::vector<float> one = random_samples(dims, 2);
  std::vector<float> many = one;
  prefilter(one, dims, {{}, Reconstruction::kNormalized, 1, {}});
  prefilter(many, dims, {{}, Reconstruction::kNormalized, 7, {}});
  EXPECT_EQ(one, many);
}

TEST(Prefilter, StopsWhenAsked) {
  std::stop_source source;
  source.request_stop();
  for (const float first : {0.0F, kNanF}) {  // with holes: while they are filled
    std::vector<float> samples(64, 1.0F);
    samples[0] = first;
    try {
      prefilter(samples, {4, 4, 4}, {{}, Reconstruction::kSum, 1, source.get_token()});
      FAIL() << "not cancelled";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCancelled);
    }
  }
}

// One existing sample next to a hole three deep: 1 1 1 from the left; further right the mean of
// both sides.
TEST(Holes, AreFilledFromTheRimInwards) {
  std::vector<float> line = {1, kNanF, kNanF, kNanF, 5};
  const std::vector<bool> missing = fill_missing(line, {5, 1, 1}, {});
  EXPECT_EQ(line, (std::vector<float>{1, 1, 3, 5, 5}));
  EXPECT_EQ(missing, (std::vector<bool>{false, true, true, true, false}));
  restore_missing(line, missing);
  EXPECT_TRUE(std::isnan(line[1]) && std::isnan(line[2]) && std::isnan(line[3]));
  EXPECT_EQ(line[4], 5);
}

// Fails if neighbours are taken across the end of a row or slice.
TEST(Holes, NeighboursShareAFace) {
  std::vector<float> slice = {1, 2, kNanF,  //
                              9, 5, 6};
  fill_missing(slice, {3, 2, 1}, {});
  EXPECT_EQ(slice[2], 4);  // (2 + 6) / 2, without the 9 that follows in memory
  std::vector<float> volume(27, kNanF);
  volume[13] = 7;
  fill_missing(volume, {3, 3, 3}, {});
  EXPECT_EQ(volume, std::vector<float>(27, 7.0F));
  std::vector<float> whole = {1, 2};
  EXPECT_TRUE(fill_missing(whole, {2, 1, 1}, {}).empty());
}

}  // namespace prefilter_test
}  // namespace ovoid::model
