// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/encode_relevant.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "data/lattice/resident_lattice.h"
#include "ovoid/error.h"

namespace ovoid::data {
namespace encode_relevant_test {

constexpr Index3 kDims{23, 17, 20};

template <class T>
Bytes bytes_of(const std::vector<T>& numbers) {
  const auto memory = std::make_shared<std::vector<T>>(numbers);
  return {memory, std::as_bytes(std::span<const T>(*memory))};
}

// Two balls of high numbers in a slope of low ones.
std::vector<std::uint8_t> balls() {
  std::vector<std::uint8_t> numbers;
  for (std::int64_t k = 0; k < kDims[2]; ++k) {
    for (std::int64_t j = 0; j < kDims[1]; ++j) {
      for (std::int64_t i = 0; i < kDims[0]; ++i) {
        const double a = std::hypot(i - 6.0, j - 5.0, k - 7.0);
        const double b = std::hypot(i - 21.0, j - 15.0, k - 18.0);
        const double ball = std::max(0.0, 200 - 70 * std::min(a, b));
        numbers.push_back(
            static_cast<std::uint8_t>(std::max<double>(ball, static_cast<double>(10 + i + j % 3))));
      }
    }
  }
  return numbers;
}

std::vector<std::uint8_t> decoded(const RelevantRuns& runs) {
  std::vector<std::uint8_t> numbers(static_cast<std::size_t>(num_samples(kDims)));
  runs.decode({0, 0, 0}, kDims, reinterpret_cast<std::byte*>(numbers.data()));
  return numbers;
}

// Fails if a sample that a relevant place takes is lost, far ones are kept, or what is lost is not
// the background.
TEST(EncodeRelevant, KeepsWhatRelevantPlacesTake) {
  for (const LatticeKind kind : {LatticeKind::kCartesian, LatticeKind::kBodyCentred}) {
    LatticeGeometry geometry;
    geometry.dims = kDims;
    geometry.kind = kind;
    const std::vector<std::uint8_t> numbers = balls();
    const Bytes bytes = bytes_of(numbers);
    const RelevantRuns runs =
        encode_relevant(geometry, {ScalarType::kUInt8}, bytes, {100, std::nullopt, true}, {});
    EXPECT_LT(runs.num_relevant(), num_samples(kDims) * 2 / 3);
    EXPECT_EQ(runs.background(), 10);
    const std::vector<std::uint8_t> kept = decoded(runs);
    // A sample by a relevant one shares places with it: two spacings from each.
    const double near = 2 * geometry.unit_spacing();
    const auto at = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
      return static_cast<std::size_t>(i + kDims[0] * (j + kDims[1] * k));
    };
    int num_far = 0;
    for (std::int64_t k = 0; k < kDims[2]; ++k) {
      for (std::int64_t j = 0; j < kDims[1]; ++j) {
        for (std::int64_t i = 0; i < kDims[0]; ++i) {
          double nearest = std::numeric_limits<double>::infinity();
          for (std::int64_t c = 0; c < kDims[2]; ++c) {
            for (std::int64_t b = 0; b < kDims[1]; ++b) {
              for (std::int64_t a = 0; a < kDims[0]; ++a) {
                if (numbers[at(a, b, c)] <= 100) continue;
                const Vec3 d =
                    geometry.index_position({a, b, c}) - geometry.index_position({i, j, k});
                nearest = std::min(nearest, d.cwiseAbs().maxCoeff());
              }
            }
          }
          const std::size_t n = at(i, j, k);
          if (nearest <= 2 * near - 1e-9)
            EXPECT_EQ(kept[n], numbers[n]) << i << " " << j << " " << k;
          if (nearest > 2 * near + 8) {
            ++num_far;
            EXPECT_EQ(kept[n], 10) << i << " " << j << " " << k;
          }
        }
      }
    }
    EXPECT_GT(num_far, 50);
  }
}

// Fails if a scale below zero turns the order round, or the background's value is taken for the
// number that stands for it.
TEST(EncodeRelevant, CountsInValues) {
  LatticeGeometry geometry;
  geometry.dims = kDims;
  std::vector<std::uint8_t> numbers = balls();
  for (std::uint8_t& number : numbers) number = static_cast<std::uint8_t>(255 - number);
  for (const bool with_reach : {false, true}) {
    // value = 255 - number
    const RelevantRuns runs = encode_relevant(geometry, {ScalarType::kUInt8, -1, 255},
                                              bytes_of(numbers), {100, 5, with_reach}, {});
    EXPECT_EQ(runs.background(), 250);
    const std::vector<std::uint8_t> kept = decoded(runs);
    for (std::size_t n = 0; n < kept.size(); ++n) {
      if (numbers[n] < 155) {
        EXPECT_EQ(kept[n], numbers[n]);
      }
    }
    EXPECT_EQ(kept[22], 250);  // far from both
  }
}

TEST(EncodeRelevant, RefusesReachOfTypesThatAreNotDrawn) {
  LatticeGeometry geometry;
  geometry.dims = {4, 4, 4};
  const Bytes numbers = bytes_of(std::vector<double>(64, 1.0));
  EXPECT_THROW(
      encode_relevant(geometry, {ScalarType::kFloat64}, numbers, {0, std::nullopt, true}, {}),
      Error);
  EXPECT_EQ(encode_relevant(geometry, {ScalarType::kFloat64}, numbers, {0, std::nullopt}, {})
                .num_relevant(),
            64);
}

}  // namespace encode_relevant_test
}  // namespace ovoid::data
