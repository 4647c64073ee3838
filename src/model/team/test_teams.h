// SPDX-License-Identifier: Apache-2.0
// Fields that threads as a team make of shares, and how they are compared with one process'.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "data/kernels/kernel_shape.h"
#include "ovoid/kernel_team.h"
#include "ovoid/model.h"
#include "support/thread_team.h"

namespace ovoid::model {

struct Made {
  KernelField field;
  KernelModelReport report;
  std::shared_ptr<const Surface> surface;
};

using ShareOf = std::function<Dataset(int number, int count)>;

inline std::vector<Made> made_together(const ShareOf& share_of, int count,
                                       const KernelModelOptions& options) {
  ovoid::testing::Room room(count);
  return ovoid::testing::run_as_team(room, [&](const std::shared_ptr<KernelTeam>& team) {
    Dataset share = share_of(team->number(), count);
    agree_on_array(share, *team);
    Made made;
    made.field = make_team_field(share, {options, 1 << 20, &made.surface}, team, &made.report);
    return made;
  });
}

// One after the other, in the order of the bricks.
inline void expect_same(const KernelField& field, const KernelField& expected) {
  const KernelSource& a = field.source();
  const KernelSource& b = expected.source();
  ASSERT_EQ(a.num_kernels(), b.num_kernels());
  ASSERT_EQ(a.num_bricks(), b.num_bricks());
  for (std::int64_t i = 0; i < a.num_bricks(); ++i) {
    const KernelBrick& brick = a.brick(i);
    const KernelBrick& other = b.brick(i);
    ASSERT_EQ(brick.count, other.count) << "brick " << i;
    ASSERT_EQ(brick.origin, other.origin);
    const double sigma = static_cast<double>(other.least_sigma);
    ASSERT_LE((brick.support.min() - other.support.min()).norm(), 1e-4 * sigma);
    ASSERT_LE((brick.cells.max() - other.cells.max()).norm(), 1e-4 * sigma);
    const KernelView view = a.acquire(i, 0), wanted = b.acquire(i, 0);
    ASSERT_EQ(view.count, wanted.count);
    for (std::int32_t k = 0; k < view.count; ++k) {
      ASSERT_EQ(data::offset_of(view, k), data::offset_of(wanted, k));
      const auto shape = data::shape_numbers(view, a.shape(), k);
      const auto other_shape = data::shape_numbers(wanted, b.shape(), k);
      for (std::size_t c = 0; c < 6; ++c)
        ASSERT_NEAR(shape[c], other_shape[c], 1e-5 * std::abs(other_shape[0]));
      ASSERT_NEAR(data::weight_of(view, k) / data::weight_of(wanted, k), 1, 1e-4);
      for (std::size_t v = 0; v < a.attributes().size(); ++v)
        ASSERT_NEAR(view.value[v][k], wanted.value[v][k], 1e-5 * std::abs(wanted.value[v][k]));
    }
  }
  const auto expect_range = [](const ValueRange& range, const ValueRange& other) {
    EXPECT_NEAR(range.lo, other.lo, 1e-4 * std::abs(other.hi));
    EXPECT_NEAR(range.hi, other.hi, 1e-4 * std::abs(other.hi));
  };
  expect_range(field.value_range(), expected.value_range());
  expect_range(field.color_range(), expected.color_range());
  for (std::size_t v = 0; v < a.attributes().size(); ++v)
    expect_range(a.attributes()[v].range, b.attributes()[v].range);
  ASSERT_EQ(field.sums() == nullptr, expected.sums() == nullptr);
  if (expected.sums() != nullptr) {
    ASSERT_EQ(field.sums()->values.size(), expected.sums()->values.size());
    for (std::size_t i = 0; i < expected.sums()->values.size(); ++i) {
      const float sum = expected.sums()->values[i];
      ASSERT_NEAR(field.sums()->values[i], sum, 1e-4 * std::abs(sum));
    }
  }
  EXPECT_NEAR(field.default_sampling_distance() / expected.default_sampling_distance(), 1, 1e-5);
  EXPECT_NEAR(field.refined_sampling_distance() / expected.refined_sampling_distance(), 1, 1e-5);
}

// By 1, 2, 3, 4 and 7 processes, against what one makes of the whole.
inline void expect_same_together(const Dataset& whole, const ShareOf& share_of,
                                 const KernelModelOptions& options = {}) {
  Made alone;
  alone.field = make_kernel_field(whole, options, &alone.report);
  for (const int count : {1, 2, 3, 4, 7}) {
    SCOPED_TRACE(::testing::Message() << count << " processes");
    for (const Made& made : made_together(share_of, count, options)) {
      expect_same(made.field, alone.field);
      EXPECT_EQ(made.report.array, alone.report.array);
      EXPECT_EQ(made.report.num_sites, alone.report.num_sites);
      EXPECT_EQ(made.report.num_missing, alone.report.num_missing);
      EXPECT_EQ(made.report.num_merged, alone.report.num_merged);
      EXPECT_EQ(made.report.num_misplaced, alone.report.num_misplaced);
      EXPECT_EQ(made.report.num_dangling, alone.report.num_dangling);
      EXPECT_EQ(made.report.num_degenerate, alone.report.num_degenerate);
      EXPECT_NEAR(made.report.constant_mean, alone.report.constant_mean, 1e-5);
      EXPECT_NEAR(made.report.constant_deviation, alone.report.constant_deviation, 1e-5);
      EXPECT_EQ(made.report.num_copies, alone.report.num_copies);
      EXPECT_EQ(made.report.notes, alone.report.notes);
    }
  }
}

}  // namespace ovoid::model
