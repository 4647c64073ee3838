// SPDX-License-Identifier: Apache-2.0
// How coarse a picture is drawn while something moves.
#include "levels.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace ovoid::viewer {
namespace levels_test {

// All costs here are small whole numbers or their halves, so that sums are exact.
LevelChooser chooser_of(int coarsest_field) {
  LevelChooser chooser;
  chooser.set_scales(1, 2, coarsest_field);
  return chooser;
}

TEST(Levels, TheFinestComesFirstAndNoneIsMissing) {
  const LevelChooser chooser = chooser_of(2);
  EXPECT_EQ(chooser.levels().size(), 9U);  // pixels 1, 2, 4 x fields 0, 1, 2
  EXPECT_TRUE(chooser.levels().front().is_full());
  EXPECT_EQ(chooser.levels().back(), (Level{4, 2}));
  // A picture's blur is that of its pixels and that of its kernels, as lengths add that are
  // independent: hypot(2, 2) < hypot(1, 4).
  const auto place_of = [&](const Level& level) {
    return std::find(chooser.levels().begin(), chooser.levels().end(), level);
  };
  EXPECT_LT(place_of({2, 0}), place_of({1, 1}));
  EXPECT_LT(place_of({1, 1}), place_of({4, 1}));
  EXPECT_LT(place_of({1, 2}), place_of({4, 2}));
}

TEST(Levels, WhatWasNeverDrawnIsToldFromWhatWas) {
  LevelChooser chooser = chooser_of(2);
  EXPECT_EQ(chooser.predicted_ms({1, 0}), 0);
  chooser.measured({1, 0}, {64, 512});
  EXPECT_EQ(chooser.predicted_ms({1, 0}), 64 + 512);
  EXPECT_EQ(chooser.predicted_ms({2, 0}), 64 + 512 / 4);
  EXPECT_EQ(chooser.predicted_ms({4, 0}), 64 + 512 / 16);
  EXPECT_EQ(chooser.predicted_ms({1, 1}), 64 / 8 + 512 / 2);
  EXPECT_EQ(chooser.predicted_ms({2, 2}), 64 / 64 + 512 / 4 / 4);
  // Upwards, too, and from the nearest.
  LevelChooser upwards = chooser_of(2);
  upwards.measured({4, 1}, {1, 8});
  EXPECT_EQ(upwards.predicted_ms({1, 0}), 8 + 8 * 2 * 16);
  upwards.measured({2, 0}, {5, 10});
  EXPECT_EQ(upwards.predicted_ms({1, 0}), 5 + 40);
}

TEST(Levels, WhatTurnsOutDearerMakesAllOthersDearer) {
  LevelChooser chooser = chooser_of(0);
  chooser.measured({1, 0}, {8, 64});
  chooser.measured({4, 0}, {8, 4});
  EXPECT_EQ(chooser.predicted_ms({1, 0}),
            72);  // the first measure of a level says nothing of others
  chooser.measured({4, 0}, {16, 8});
  EXPECT_EQ(chooser.predicted_ms({4, 0}), 24);
  EXPECT_EQ(chooser.predicted_ms({1, 0}), 144);
  chooser.forget();
  EXPECT_EQ(chooser.predicted_ms({1, 0}), 0);
}

TEST(Levels, TheFinestWithinTheBudgetIsChosen) {
  LevelChooser chooser = chooser_of(2);
  chooser.measured({1, 0}, {16, 256});
  for (const double budget : {5.0, 10.0, 20.0, 28.0, 60.0, 100.0, 300.0}) {
    const Level chosen = chooser.choose(budget, Level{16, 0});  // nothing to stay with
    EXPECT_LE(chooser.predicted_ms(chosen), budget);
    for (const Level& finer : chooser.levels()) {
      if (finer == chosen) break;
      EXPECT_GT(chooser.predicted_ms(finer), budget) << finer.pixels << ' ' << finer.field;
    }
  }
  // If none is quick enough, the quickest.
  EXPECT_EQ(chooser.choose(0.001, Level{1, 0}), (Level{4, 2}));
}

// A third too dear, or a third to spare, before anything changes.
TEST(Levels, ALevelIsKeptWhileItIsNearTheBudget) {
  LevelChooser chooser = chooser_of(0);
  chooser.measured({2, 0}, {0, 10});  // so the full one takes 40
  EXPECT_EQ(chooser.choose(40 / 1.2, Level{1, 0}), (Level{1, 0}));
  EXPECT_EQ(chooser.choose(40 / 1.4, Level{1, 0}), (Level{2, 0}));
  EXPECT_EQ(chooser.choose(40 / 0.9, Level{2, 0}), (Level{2, 0}));
  EXPECT_EQ(chooser.choose(40 / 0.7, Level{2, 0}), (Level{1, 0}));
}

// Costs that go up and down by a seventh, as measured ones do, around any budget.
TEST(Levels, ALevelDoesNotFlip) {
  for (double budget = 5; budget < 200; budget *= 1.05) {
    LevelChooser chooser = chooser_of(1);
    Level level{4, 1};
    chooser.measured(level, {0, 4});
    int changes = 0;
    for (int i = 0; i < 40; ++i) {
      const Level next = chooser.choose(budget, level);
      changes += next == level ? 0 : 1;
      level = next;
      const double wave = i % 2 == 0 ? 1.0 : 1.0 / 1.15;
      const double cost = 128.0 / (level.pixels * level.pixels) / (1 << level.field);
      chooser.measured(level, {0, cost * wave});
    }
    EXPECT_LE(changes, 2) << "budget " << budget;
  }
}

TEST(Levels, RefinementEndsInTheFullLevelByStepsWorthShowing) {
  LevelChooser chooser = chooser_of(2);
  chooser.measured({1, 0}, {100, 3000});
  for (const Level& from : chooser.levels()) {
    const std::vector<Level> steps = chooser.refinement(from);
    ASSERT_FALSE(steps.empty());
    EXPECT_TRUE(steps.back().is_full());
    double last = chooser.predicted_ms(from);
    for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
      EXPECT_GE(chooser.predicted_ms(steps[i]), 3 * last);
      EXPECT_LE(3 * chooser.predicted_ms(steps[i]), chooser.predicted_ms({1, 0}));
      last = chooser.predicted_ms(steps[i]);
    }
  }
  EXPECT_EQ(chooser.refinement({1, 0}).size(), 1U);
  EXPECT_GE(chooser.refinement({4, 2}).size(), 2U);
}

}  // namespace levels_test
}  // namespace ovoid::viewer
