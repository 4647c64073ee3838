// SPDX-License-Identifier: Apache-2.0
// A lattice of runs shows what the dense lattice with background shows.
#include "data/lattice/run_lattice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "ovoid/error.h"

namespace ovoid {
namespace run_lattice_test {

using data::RelevantRuns;
using data::RelevantValues;

template <class T>
Bytes owned_bytes(const std::vector<T>& values) {
  const auto owner = std::make_shared<std::vector<T>>(values);
  return {owner, std::as_bytes(std::span(*owner))};
}

// A ball of values up to 100 in the middle of nothing.
std::vector<float> ball_samples(const Index3& dims) {
  std::vector<float> values;
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    for (std::int64_t y = 0; y < dims[1]; ++y) {
      for (std::int64_t x = 0; x < dims[0]; ++x) {
        const auto d = [&](std::int64_t i, int a) {
          const auto n = static_cast<double>(dims[static_cast<std::size_t>(a)]);
          return (static_cast<double>(i) - 0.4 * n) / (0.3 * n);
        };
        const double r2 = d(x, 0) * d(x, 0) + d(y, 1) * d(y, 1) + d(z, 2) * d(z, 2);
        values.push_back(static_cast<float>(100 * (1 - r2)));
      }
    }
  }
  return values;
}

RelevantRuns runs_of(const Index3& dims, const std::vector<float>& values, double background = -5) {
  return {{ScalarType::kFloat32, dims},
          owned_bytes(values).view,
          RelevantValues::above(10),
          background};
}

std::vector<float> dense_again(std::vector<float> values, float background = -5) {
  for (float& value : values)
    if (value <= 10) value = background;
  return values;
}

TEST(RunLattice, BricksShowWhatTheDenseLatticeHas) {
  for (const LatticeKind kind : {LatticeKind::kCartesian, LatticeKind::kBodyCentred}) {
    const Index3 dims{50, 37, 70};
    const std::vector<float> values = ball_samples(dims);
    const std::vector<float> expected = dense_again(values);
    const RunLattice lattice({dims, Affine3::Identity(), kind}, runs_of(dims, values));
    const int layers = RunLattice::kBrickEdge * (kind == LatticeKind::kBodyCentred ? 2 : 1);
    std::int64_t num_seen = 0;
    for (std::int64_t bz = 0; bz * layers < dims[2]; ++bz) {
      for (std::int64_t by = 0; by * 16 < dims[1]; ++by) {
        for (std::int64_t bx = 0; bx * 16 < dims[0]; ++bx) {
          const BrickView view = lattice.acquire(bx, by, bz, 0);
          EXPECT_EQ(view.lo, (Index3{bx * 16, by * 16, bz * layers}));
          for (std::int64_t z = view.lo[2]; z < view.hi[2]; ++z) {
            for (std::int64_t y = view.lo[1]; y < view.hi[1]; ++y) {
              for (std::int64_t x = view.lo[0]; x < view.hi[0]; ++x, ++num_seen) {
                ASSERT_EQ(static_cast<const float*>(
                              view.data)[(x - view.lo[0]) + (y - view.lo[1]) * view.stride_y +
                                         (z - view.lo[2]) * view.stride_z],
                          expected[static_cast<std::size_t>((z * dims[1] + y) * dims[0] + x)]);
              }
            }
          }
        }
      }
    }
    EXPECT_EQ(num_seen, num_samples(dims));
  }
}

// The ranges of bricks of 16 are those of the dense table of that edge.
TEST(RunLattice, RangesAreThoseOfTheSamplesInReach) {
  const Index3 dims{50, 37, 20};
  std::vector<float> values = ball_samples(dims);
  values[3] = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> dense = dense_again(values);
  ResidentLatticeOptions options;
  options.range_reach = 1.7;
  options.value_scale = -2;
  options.value_offset = 1;
  const RunLattice lattice({dims, Affine3::Identity()}, runs_of(dims, values), options);
  const auto table =
      data::make_brick_table(dense.data(), dims, {.edge = 16, .reach = 1.7, .threads = 1});
  for (std::int64_t i = 0; i < 4 * 3 * 2; ++i) {
    const auto range = lattice.brick_range(i % 4, i / 4 % 3, i / 12);
    const auto& extent = table.extents[static_cast<std::size_t>(i)];
    EXPECT_EQ(range.lo, extent.hi * -2 + 1) << i;
    EXPECT_EQ(range.hi, extent.lo * -2 + 1) << i;
    EXPECT_EQ(lattice.has_missing(i % 4, i / 4 % 3, i / 12),
              table.missing[static_cast<std::size_t>(i)] != 0)
        << i;
  }
}

TEST(RunLattice, MemoryIsThatOfTheRuns) {
  const Index3 dims{96, 96, 96};
  std::vector<float> values = ball_samples(dims);
  for (float& value : values) value -= 80;  // a tenth of the radius cubed is left
  const RunLattice lattice({dims, Affine3::Identity()}, runs_of(dims, values));
  EXPECT_LT(lattice.resident_bytes(), lattice.runs().values().size() + 60'000);
  EXPECT_LT(lattice.resident_bytes(), values.size() * sizeof(float) / 20);
  EXPECT_EQ(lattice.acquire(5, 5, 5, 0).pin, nullptr) << "a brick without runs is shared";
}

TEST(RunLattice, RefusesWhatItCannotShow) {
  const Index3 dims{4, 4, 4};
  const std::vector<float> values(64);
  const auto code = [](const auto& make) {
    try {
      make();
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(code([&] {
                RunLattice({{4, 4, 5}, Affine3::Identity()}, runs_of(dims, values));
              }),
              testing::HasSubstr("runs: of 4 x 4 x 4 samples, must be of 4 x 4 x 5"));
  const std::vector<double> doubles(64);
  EXPECT_THAT(code([&] {
                RunLattice({dims, Affine3::Identity()},
                           RelevantRuns({ScalarType::kFloat64, dims}, owned_bytes(doubles).view,
                                        RelevantValues::above(0), 0));
              }),
              testing::HasSubstr("type = float64"));
  ResidentLatticeOptions options;
  options.range_reach = -1;
  EXPECT_THAT(code([&] {
                RunLattice({dims, Affine3::Identity()}, runs_of(dims, values), options);
              }),
              testing::HasSubstr("range_reach = -1"));
}

}  // namespace run_lattice_test
}  // namespace ovoid
