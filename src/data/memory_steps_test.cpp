// SPDX-License-Identifier: Apache-2.0
// Steps in memory. Fails if one is copied, keeps what it says of other steps, has another's time,
// or if steps that are no series are taken for one.
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/error.h"
#include "ovoid/series.h"

namespace ovoid {
namespace memory_steps_test {

using Steps = std::vector<std::shared_ptr<const Dataset>>;

// A row of 10 bytes: all `value`, but for the first.
Dataset row(int value, int first) {
  std::vector<std::byte> bytes(10, std::byte(value));
  bytes[0] = std::byte(first);
  const auto owner = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
  Dataset dataset;
  dataset.source = "row";
  dataset.lattice.dims = {10, 1, 1};
  dataset.arrays.push_back({"values", ScalarType::kUInt8, 1, 10, "", false, {owner, *owner}});
  return dataset;
}

std::shared_ptr<const Dataset> kept(Dataset dataset) {
  return std::make_shared<const Dataset>(std::move(dataset));
}

Steps rows(int count) {
  Steps steps;
  for (int i = 0; i < count; ++i) steps.push_back(kept(row(i, i)));
  return steps;
}

std::string refusal_of(Steps steps, const StepTimes& times = {},
                       ErrorCode code = ErrorCode::kInvalidArgument) {
  try {
    make_steps("rows", std::move(steps), times);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code);
    return error.what();
  }
  return "";
}

TEST(MemorySteps, ShareTheirArrays) {
  const Steps given = rows(3);
  const auto steps = make_steps("rows", given, {{0, 0.5, 2}, "s"});
  EXPECT_EQ(steps->num_steps(), 3);
  EXPECT_EQ(steps->times(), (std::vector<double>{0, 0.5, 2}));
  EXPECT_TRUE(steps->has_times());
  const Dataset second = steps->read(1);
  EXPECT_EQ(second.arrays[0].bytes.view.data(), given[1]->arrays[0].bytes.view.data());
  EXPECT_EQ(second.step, 1);
  EXPECT_EQ(second.num_steps, 3);
  EXPECT_EQ(second.times, steps->times());
  EXPECT_EQ(second.time_unit, "s");
  EXPECT_THROW(steps->read(3), Error);
  EXPECT_THROW(steps->read(-1), Error);
}

TEST(MemorySteps, TimesAreTheNumbersOrTheSteps) {
  const auto numbered = make_steps("rows", rows(3));
  EXPECT_EQ(numbered->times(), (std::vector<double>{0, 1, 2}));
  EXPECT_FALSE(numbered->has_times());
  EXPECT_TRUE(numbered->read(0).times.empty());

  const auto read_at = [](int value, std::int64_t step, std::vector<double> times) {
    Dataset dataset = row(value, value);
    dataset.num_steps = static_cast<std::int64_t>(times.size());
    dataset.step = step;
    dataset.times = std::move(times);
    dataset.time_unit = "ms";
    dataset.series = SeriesKind::kStaggered;
    return kept(dataset);
  };
  const auto own = make_steps("rows", {read_at(1, 2, {3, 4, 7}), read_at(2, 0, {9})});
  EXPECT_EQ(own->times(), (std::vector<double>{7, 9}));
  EXPECT_EQ(own->read(1).time_unit, "ms");
  EXPECT_EQ(own->read(1).series, SeriesKind::kSteps);
  const auto same = make_steps("rows", {read_at(1, 0, {3}), read_at(2, 0, {3})});
  EXPECT_FALSE(same->has_times());
  const auto one = make_steps("rows", {read_at(1, 1, {3, 4})});
  EXPECT_EQ(one->read(0).times, (std::vector<double>{4}));
  EXPECT_EQ(one->read(0).num_steps, 1);
}

TEST(MemorySteps, ShowTheFirstThatVaries) {
  Steps steps = rows(3);
  steps[2] = kept(row(0, 7));
  const Dataset shown = step_to_show(*make_steps("rows", steps));
  EXPECT_EQ(shown.step, 2);
  ASSERT_EQ(shown.notes.size(), 1U);
  EXPECT_EQ(shown.notes[0], "row: step 2 of 3, the first that varies; choose with --step");
  const Dataset none = step_to_show(*make_steps("rows", rows(3)), "values");
  EXPECT_EQ(none.step, 0);
  EXPECT_TRUE(none.notes.empty());
  EXPECT_TRUE(step_to_show(*make_steps("rows", rows(1))).notes.empty());
  EXPECT_THROW(step_to_show(*make_steps("rows", rows(2)), "others"), Error);
}

TEST(MemorySteps, RefuseWhatIsNoSeries) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal_of({}), "rows: has no steps, expected at least one");
  EXPECT_EQ(refusal_of({rows(1)[0], nullptr}), "rows: step 1: is null");
  EXPECT_EQ(refusal_of(rows(3), {{0, 1}, ""}),
            "rows: 2 times of 3 steps: expected one each, and at least one");
  EXPECT_EQ(refusal_of(rows(2), {{0, kNan}, ""}),
            "rows: times[1] = nan: expected finite times that rise");
  EXPECT_EQ(refusal_of(rows(2), {{1, 1}, ""}),
            "rows: times[1] = 1: expected finite times that rise");
  Dataset longer = row(1, 1);
  longer.lattice.dims = {5, 2, 1};
  EXPECT_EQ(refusal_of({rows(1)[0], kept(longer)}),
            "row: step 1: has 5 x 2 x 1 samples, step 0 has 10 x 1 x 1: the steps of a series are "
            "alike");
  Dataset cloud = row(1, 1);
  cloud.kind = DatasetKind::kParticles;
  EXPECT_NE(refusal_of({rows(1)[0], kept(cloud)}).find("holds particles, step 0 lattice"),
            std::string::npos);
  Dataset other = row(1, 1);
  other.arrays.push_back(other.arrays[0]);
  other.arrays[0].name = "others";
  other.arrays[1].name = "more";
  EXPECT_NE(refusal_of({rows(1)[0], kept(other)}).find("has no array 'values'"), std::string::npos);
}

}  // namespace memory_steps_test
}  // namespace ovoid
