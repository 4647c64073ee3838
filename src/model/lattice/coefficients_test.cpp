// SPDX-License-Identifier: Apache-2.0
// Coefficients of 16 bits against those of floats.
#include "model/lattice/coefficients.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "data/scalar_visit.h"
#include "ovoid/error.h"

namespace ovoid::model {
namespace coefficients_test {

struct Subject {
  std::string name;
  Index3 dims;
  std::vector<std::uint8_t> stored;
};

template <class Sample>
Subject subject(const std::string& name, const Index3& dims, Sample&& sample) {
  Subject made{name, dims, {}};
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    for (std::int64_t y = 0; y < dims[1]; ++y) {
      for (std::int64_t x = 0; x < dims[0]; ++x)
        made.stored.push_back(static_cast<std::uint8_t>(sample(x, y, z)));
    }
  }
  return made;
}

std::vector<Subject> subjects() {
  std::minstd_rand draw(7);
  return {
      subject("noise, several slabs", {13, 9, 110},
              [&](auto, auto, auto) { return draw() % 200 + 20; }),
      // The greatest coefficients there are: 27 times the range.
      subject("checkerboard", {21, 22, 70},
              [](auto x, auto y, auto z) { return (x + y + z) % 2 * 255; }),
      subject("a slab and a slice", {5, 150, 33}, [&](auto, auto, auto z) { return z; }),
      subject("one slice", {40, 30, 1}, [&](auto x, auto y, auto) { return 3 * x + 2 * y; }),
      subject("one column", {1, 1, 200}, [&](auto, auto, auto) { return draw() % 256; }),
      subject("constant", {6, 5, 4}, [](auto, auto, auto) { return 77; }),
  };
}

ScalarSamples samples_of(const Subject& subject) {
  return {ScalarType::kUInt8,
          {nullptr, std::as_bytes(std::span(subject.stored))},
          nullptr,
          0.25,
          -12.0};
}

PrefilterOptions options_of(const Subject& subject, int threads) {
  const auto [least, greatest] = std::minmax_element(subject.stored.begin(), subject.stored.end());
  PrefilterOptions options{kBSplineKernel};
  options.threads = threads;
  options.may_miss = false;
  options.range = {static_cast<float>(*least * 0.25 - 12),
                   static_cast<float>(*greatest * 0.25 - 12)};
  return options;
}

std::vector<float> exact_coefficients(const Subject& subject, const PrefilterOptions& options) {
  std::vector<float> values;
  for (const std::uint8_t stored : subject.stored)
    values.push_back(static_cast<float>(stored * 0.25 - 12));
  prefilter(values, subject.dims, options);
  return values;
}

// Fails if slabs do not fit together, if the window looks ahead too little, or if coefficients
// beyond the usual range are cut.
TEST(Coefficients, OfSixteenBitsAreThoseOfFloats) {
  for (const Subject& subject : subjects()) {
    const PrefilterOptions options = options_of(subject, 2);
    const std::vector<float> exact = exact_coefficients(subject, options);
    const ScalarSamples rounded = make_coefficients(samples_of(subject), subject.dims, options);
    ASSERT_EQ(rounded.type, ScalarType::kInt16);
    ASSERT_EQ(rounded.bytes.view.size(), 2 * exact.size());
    const auto [lo, hi] = std::minmax_element(exact.begin(), exact.end());
    const double span = options.range.hi - options.range.lo;
    const double bound = std::max({3.1e-5 * span, 8e-6 * (*hi - *lo), 1e-5}) * 1.05;
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const auto stored =
          data::load_scalar<std::int16_t>(rounded.bytes.view.data(), static_cast<std::int64_t>(i));
      ASSERT_NEAR(stored * rounded.value_scale + rounded.value_offset, exact[i], bound)
          << subject.name << ", sample " << i;
    }
  }
}

TEST(Coefficients, DoNotDependOnTheNumberOfThreads) {
  for (const Subject& subject : subjects()) {
    const auto bytes = [&](int threads) {
      const ScalarSamples made =
          make_coefficients(samples_of(subject), subject.dims, options_of(subject, threads));
      return std::vector<std::byte>(made.bytes.view.begin(), made.bytes.view.end());
    };
    EXPECT_EQ(bytes(1), bytes(5)) << subject.name;
  }
}

TEST(Coefficients, FewLevelsAreThoseWithinFourThousand) {
  ScalarSamples samples;
  samples.type = ScalarType::kInt16;
  samples.value_scale = -2;
  EXPECT_TRUE(have_few_levels(samples, {-100, 8000}));
  EXPECT_FALSE(have_few_levels(samples, {-1000, 8000}));
  EXPECT_FALSE(have_few_levels(samples, {}));
  samples.type = ScalarType::kFloat32;
  EXPECT_FALSE(have_few_levels(samples, {0, 1}));
  samples.type = ScalarType::kUInt8;
  samples.value_scale = 1e30;  // filtered, they might overflow
  EXPECT_FALSE(have_few_levels(samples, {0, 2e32F}));
}

TEST(Coefficients, StopWhenAsked) {
  const Subject subject = subjects().front();
  PrefilterOptions options = options_of(subject, 1);
  std::stop_source source;
  source.request_stop();
  options.stop = source.get_token();
  EXPECT_THROW(make_coefficients(samples_of(subject), subject.dims, options), Error);
}

}  // namespace coefficients_test
}  // namespace ovoid::model
