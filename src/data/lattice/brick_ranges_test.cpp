// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/brick_ranges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "ovoid/error.h"

namespace ovoid::data {
namespace brick_ranges_test {

constexpr int kEdge = 4;

// Straight from the header: every sample within reach of the closed cells of brick b.
bool reaches(double position, std::int64_t brick, double reach) {
  return position >= static_cast<double>(brick * kEdge) - reach &&
         position <= static_cast<double>((brick + 1) * kEdge) + reach;
}

template <class T>
bool exists(T value) {
  return std::isfinite(static_cast<double>(value));
}

// Compares every brick with a search through all samples.
template <class T>
void expect_brute_force(const std::vector<T>& samples, const LatticeGeometry& lattice, double reach,
                        int threads) {
  const Index3& dims = lattice.dims;
  const Index3 cells = lattice.cells();
  const BrickTable<T> table =
      make_brick_table(samples.data(), dims, {kEdge, reach, lattice.kind, threads, {}});
  std::int64_t num_missing = 0;
  for (const T value : samples) num_missing += exists(value) ? 0 : 1;
  ASSERT_EQ(table.num_missing, num_missing);
  ASSERT_EQ(table.missing.empty(), num_missing == 0);
  std::size_t brick = 0;
  for (std::int64_t bz = 0; bz * kEdge < cells[2]; ++bz) {
    for (std::int64_t by = 0; by * kEdge < cells[1]; ++by) {
      for (std::int64_t bx = 0; bx * kEdge < cells[0]; ++bx, ++brick) {
        bool is_empty = true;
        bool has_missing = false;
        T lo{};
        T hi{};
        std::size_t at = 0;
        for (std::int64_t z = 0; z < dims[2]; ++z) {
          for (std::int64_t y = 0; y < dims[1]; ++y) {
            for (std::int64_t x = 0; x < dims[0]; ++x, ++at) {
              const Vec3 u = lattice.index_position({x, y, z});
              if (!reaches(u[0], bx, reach) || !reaches(u[1], by, reach) ||
                  !reaches(u[2], bz, reach)) {
                continue;
              }
              if (!exists(samples[at])) {
                has_missing = true;
                continue;
              }
              lo = is_empty ? samples[at] : std::min(lo, samples[at]);
              hi = is_empty ? samples[at] : std::max(hi, samples[at]);
              is_empty = false;
            }
          }
        }
        SCOPED_TRACE("brick " + std::to_string(bx) + " " + std::to_string(by) + " " +
                     std::to_string(bz) + " reach " + std::to_string(reach));
        if (is_empty) {
          ASSERT_GT(table.extents[brick].lo, table.extents[brick].hi);
        } else {
          ASSERT_EQ(table.extents[brick].lo, lo);
          ASSERT_EQ(table.extents[brick].hi, hi);
        }
        if (num_missing > 0) {
          ASSERT_EQ(table.missing[brick] != 0, has_missing);
        }
      }
    }
  }
  ASSERT_EQ(table.extents.size(), brick);
}

template <class T>
std::vector<T> random_samples(const Index3& dims, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<T> samples(static_cast<std::size_t>(num_samples(dims)));
  for (T& sample : samples) {
    const auto bits = random();
    sample = static_cast<T>(static_cast<std::int32_t>(bits));
    if constexpr (std::is_same_v<T, float>) sample *= 1e-3F;
  }
  return samples;
}

// Odd and tiny sizes, more than one tile of brick rows (32 bricks = 128 samples), reaches that are
// whole, broken, zero and larger than the lattice.
const std::vector<Index3> kSizes = {{1, 1, 1},  {4, 4, 4},    {5, 3, 9},   {17, 1, 6},
                                    {1, 23, 1}, {13, 14, 11}, {5, 262, 6}, {21, 5, 1}};
const std::vector<double> kReaches = {0.0, 0.5, 2.0, 2.7, 3.0, 40.0};

template <class T>
class BrickTableOf : public testing::Test {};
using SampleTypes = testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, float>;
TYPED_TEST_SUITE(BrickTableOf, SampleTypes);

// Fails if a window is a sample too short or too long on any side, or an axis is mistaken for
// another.
TYPED_TEST(BrickTableOf, EqualsSearchThroughAllSamples) {
  std::uint32_t seed = 1;
  for (const Index3& dims : kSizes) {
    const auto samples = random_samples<TypeParam>(dims, seed++);
    for (const LatticeKind kind : {LatticeKind::kCartesian, LatticeKind::kBodyCentred}) {
      for (const double reach : kReaches)
        expect_brute_force(samples, {.dims = dims, .kind = kind}, reach, 2);
    }
  }
}

// Fails if one bound starts from something else than the samples (0, say): all samples at one end
// of the type.
TYPED_TEST(BrickTableOf, HoldsTheEndsOfTheType) {
  for (const TypeParam value : {std::numeric_limits<TypeParam>::lowest(),
                                std::numeric_limits<TypeParam>::max(), TypeParam{1}}) {
    expect_brute_force(std::vector<TypeParam>(6 * 5 * 4, value), {.dims = {6, 5, 4}}, 2.0, 1);
  }
}

// Fails if a missing sample counts as a value, hides an existing one, or is flagged where it does
// not reach.
TEST(BrickTable, LeavesOutMissingSamples) {
  const float kMissing[] = {std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity()};
  for (const double share : {0.002, 0.05, 0.95, 1.0}) {
    const Index3 dims = {19, 22, 17};
    auto samples = random_samples<float>(dims, 7);
    std::mt19937 random(11);
    std::bernoulli_distribution is_missing(share);
    for (float& sample : samples) {
      if (is_missing(random)) sample = kMissing[random() % 3];
    }
    for (const LatticeKind kind : {LatticeKind::kCartesian, LatticeKind::kBodyCentred}) {
      for (const double reach : {0.0, 0.5, 2.0, 2.7})
        expect_brute_force(samples, {.dims = dims, .kind = kind}, reach, 2);
    }
  }
}

// Fails if tasks share a buffer or write each other's bricks.
TEST(BrickTable, DoesNotDependOnTheNumberOfThreads) {
  const Index3 dims = {40, 300, 50};
  auto samples = random_samples<float>(dims, 3);
  samples[1234] = std::numeric_limits<float>::quiet_NaN();
  const auto one = make_brick_table(samples.data(), dims, {.edge = kEdge, .threads = 1});
  const auto many = make_brick_table(samples.data(), dims, {.edge = kEdge, .threads = 7});
  EXPECT_EQ(one.missing, many.missing);
  ASSERT_EQ(one.extents.size(), many.extents.size());
  for (std::size_t i = 0; i < one.extents.size(); ++i) {
    ASSERT_EQ(one.extents[i].lo, many.extents[i].lo);
    ASSERT_EQ(one.extents[i].hi, many.extents[i].hi);
  }
}

TEST(BrickTable, StopsWhenAsked) {
  std::stop_source source;
  source.request_stop();
  const std::vector<float> samples(64);
  try {
    make_brick_table(samples.data(), {4, 4, 4},
                     {.edge = kEdge, .threads = 1, .stop = source.get_token()});
    FAIL() << "not cancelled";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCancelled);
  }
}

}  // namespace brick_ranges_test
}  // namespace ovoid::data
