// SPDX-License-Identifier: Apache-2.0
// Runs hold exactly the relevant samples, and give everything back.
#include "data/lattice/relevant_runs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "data/scalar_visit.h"
#include "ovoid/error.h"

namespace ovoid::data {
namespace relevant_runs_test {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::uint64_t kRunSeed = 20240229;

template <class T>
std::span<const std::byte> raw_bytes(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

template <class T>
std::vector<T> decoded(const RelevantRuns& runs, const Index3& lo, const Index3& hi) {
  std::vector<T> values(
      static_cast<std::size_t>(num_samples({hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]})));
  runs.decode(lo, hi, reinterpret_cast<std::byte*>(values.data()));
  return values;
}

// Runs of random lengths, so that rows of many, of one and of none occur.
template <class T>
std::vector<T> random_runs(const Index3& dims, std::mt19937_64& random) {
  std::vector<T> values(static_cast<std::size_t>(num_samples(dims)));
  for (std::size_t i = 0; i < values.size();) {
    const std::size_t length = 1 + random() % (random() % 8 == 0 ? 2000 : 9);
    const bool is_high = random() % 2 == 0;
    for (const std::size_t end = std::min(values.size(), i + length); i < end; ++i)
      values[i] = static_cast<T>(random() % 50 + (is_high ? 50 : 0));
  }
  return values;
}

TEST(RelevantRuns, EveryTypeComesBack) {
  std::mt19937_64 random(kRunSeed);
  const Index3 dims{37, 35, 5};
  for (int t = 0; t <= static_cast<int>(ScalarType::kFloat64); ++t) {
    const auto type = static_cast<ScalarType>(t);
    visit_scalar(type, [&]<class T>(std::type_identity<T>) {
      const std::vector<T> values = random_runs<T>(dims, random);
      const RelevantRuns runs({type, dims}, raw_bytes(values), RelevantValues::above(49), 7);
      std::vector<T> expected = values;
      std::int64_t num_relevant = 0;
      for (T& value : expected) {
        const bool is_relevant = static_cast<double>(value) > 49;
        if (!is_relevant) value = T{7};
        num_relevant += is_relevant ? 1 : 0;
      }
      EXPECT_EQ(decoded<T>(runs, {0, 0, 0}, dims), expected) << name_of(type);
      EXPECT_EQ(runs.num_relevant(), num_relevant);
      EXPECT_EQ(runs.background(), 7);
      EXPECT_EQ(runs.values().size(), static_cast<std::size_t>(num_relevant) * sizeof(T));
      // And through lists.
      const RelevantRuns again({type, dims}, runs.lists(), runs.values(), runs.background_bytes());
      EXPECT_EQ(decoded<T>(again, {0, 0, 0}, dims), expected);
      EXPECT_EQ(again.num_runs(), runs.num_runs());
      EXPECT_EQ(again.num_bytes(), runs.num_bytes());
    });
  }
}

TEST(RelevantRuns, AnyBoxOfThem) {
  std::mt19937_64 random(kRunSeed);
  for (const Index3& dims : {Index3{3000, 17, 2}, Index3{40, 33, 6}, Index3{1, 1, 1}}) {
    const auto values = random_runs<std::int16_t>(dims, random);
    const RelevantRuns runs({ScalarType::kInt16, dims}, raw_bytes(values),
                            RelevantValues::above(49), -1);
    for (int i = 0; i < 200; ++i) {
      Index3 lo, hi;
      for (std::size_t a = 0; a < 3; ++a) {
        lo[a] = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(dims[a]));
        hi[a] = lo[a] + 1 +
                static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(dims[a] - lo[a]));
      }
      std::vector<std::int16_t> expected;
      bool has_relevant = false;
      for (std::int64_t z = lo[2]; z < hi[2]; ++z) {
        for (std::int64_t y = lo[1]; y < hi[1]; ++y) {
          for (std::int64_t x = lo[0]; x < hi[0]; ++x) {
            const auto value = values[static_cast<std::size_t>((z * dims[1] + y) * dims[0] + x)];
            expected.push_back(value > 49 ? value : std::int16_t{-1});
            has_relevant = has_relevant || value > 49;
          }
        }
      }
      ASSERT_EQ(decoded<std::int16_t>(runs, lo, hi), expected)
          << "seed " << kRunSeed << ", box " << i;
      ASSERT_LE(has_relevant, runs.may_hold_runs(lo, hi));
    }
  }
}

TEST(RelevantRuns, CountsAndBytesOfAKnownVolume) {
  // 64 rows of 1000, of which every fourth has two runs of 100 samples, after 10 and after 300.
  const Index3 dims{1000, 32, 2};
  std::vector<std::uint8_t> values(64000);
  for (std::size_t row = 0; row < 64; row += 4) {
    for (std::size_t x = 0; x < 100; ++x) {
      values[row * 1000 + 10 + x] = 200;
      values[row * 1000 + 410 + x] = 201;
    }
  }
  const RelevantRuns runs({ScalarType::kUInt8, dims}, raw_bytes(values), RelevantValues::above(100),
                          0);
  EXPECT_EQ(runs.num_runs(), 32);
  EXPECT_EQ(runs.num_relevant(), 3200);
  // 64 numbers of runs; a run of 2 bytes and one of 3 in each of 16 rows; 4 groups and an end.
  EXPECT_EQ(runs.num_bytes(), 3200U + 64 + 16 * 5 + 5 * 16);
  const RelevantRuns none({ScalarType::kUInt8, dims}, raw_bytes(values), RelevantValues::above(250),
                          3);
  EXPECT_EQ(none.num_runs(), 0);
  EXPECT_EQ(none.num_bytes(), 5U * 16);
  EXPECT_FALSE(none.may_hold_runs({0, 0, 0}, dims));
  EXPECT_EQ(decoded<std::uint8_t>(none, {0, 0, 0}, dims), std::vector<std::uint8_t>(64000, 3));
}

TEST(RelevantRuns, IntervalsAndMissing) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const std::vector<float> values{0, 1, 2, 3, nan, 4, 5, -infinity, 6};
  const Index3 dims{9, 1, 1};
  const auto kept = [&](const RelevantValues& relevant) {
    const RelevantRuns runs({ScalarType::kFloat32, dims}, raw_bytes(values), relevant, -9);
    std::string text;
    for (const float value : decoded<float>(runs, {0, 0, 0}, dims))
      text += value == -9 ? '-' : std::isfinite(value) ? static_cast<char>('0' + value) : 'x';
    return text;
  };
  EXPECT_EQ(kept(RelevantValues::above(3)), "----x45x6");
  EXPECT_EQ(kept(RelevantValues::below(3)), "012-x--x-");
  EXPECT_EQ(kept(RelevantValues({{1, 2}, {5, 5}})), "-12-x-5x-");
  EXPECT_EQ(kept(RelevantValues(std::vector<RelevantValues::Interval>{})), "----x--x-");
}

TEST(RelevantRuns, BackgroundFitsTheType) {
  const std::vector<std::uint8_t> values{0};
  const auto background = [&](double number) {
    return RelevantRuns({ScalarType::kUInt8, {1, 1, 1}}, raw_bytes(values),
                        RelevantValues::above(9), number)
        .background();
  };
  EXPECT_EQ(background(-5), 0);
  EXPECT_EQ(background(3.7), 4);
  EXPECT_EQ(background(1e9), 255);
  EXPECT_EQ(background(NAN), 0);
}

TEST(RelevantRuns, ListsThatDoNotFit) {
  const SampleBox box{ScalarType::kUInt8, {10, 2, 1}};
  const std::vector<std::byte> background(1);
  const auto error = [&](const RunLists& lists, std::size_t num_values) {
    try {
      const std::vector<std::byte> values(num_values);
      const RelevantRuns runs(box, lists, values, background);
      return std::string();
    } catch (const Error& problem) {
      EXPECT_EQ(problem.code(), ErrorCode::kFileFormat);
      return std::string(problem.what());
    }
  };
  EXPECT_EQ(error({{1, 2}, {0, 0, 5}, {10, 5, 5}}, 20), "");
  EXPECT_THAT(error({{1}, {0}, {1}}, 1), HasSubstr("runs of 1 rows: expected 2"));
  EXPECT_THAT(error({{1, 0}, {0}, {1, 2}}, 1), HasSubstr("1 starts and 2 lengths"));
  EXPECT_THAT(error({{1, 1}, {0}, {1}}, 1), HasSubstr("row 1 has 1 runs: there are 0 left"));
  EXPECT_THAT(error({{4294967295U, 1}, {0}, {1}}, 1), HasSubstr("row 0 has 4294967295 runs"));
  EXPECT_THAT(error({{1, 0}, {0, 5}, {1, 1}}, 1), HasSubstr("2 runs: the rows have 1"));
  EXPECT_THAT(error({{1, 0}, {5}, {6}}, 6), HasSubstr("run 0 has 6 samples from 5 on"));
  EXPECT_THAT(error({{1, 0}, {5}, {0}}, 0), HasSubstr("run 0 has 0 samples"));
  EXPECT_THAT(error({{1, 0}, {4294967295U}, {4294967295U}}, 0), HasSubstr("run 0 has 4294967295"));
  EXPECT_THAT(error({{2, 0}, {5, 6}, {2, 1}}, 3), HasSubstr("must lie between 7 and 10"));
  EXPECT_THAT(error({{1, 0}, {5}, {2}}, 3), HasSubstr("3 values: the runs have 2"));
}

}  // namespace relevant_runs_test
}  // namespace ovoid::data
