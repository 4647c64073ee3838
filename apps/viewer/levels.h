// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace ovoid::viewer {

// How coarse a picture is: its pixels are `pixels` times as wide as the window's, and it is made of
// coarse_field() applied `field` times, whose sheets are as much farther apart.
struct Level {
  int pixels = 1;  // a power of two
  int field = 0;
  bool operator==(const Level&) const = default;
  bool is_full() const noexcept { return pixels == 1 && field == 0; }
};

// What a picture of a level took: in the part that goes with the number of kernels (plan, project,
// bin), and in the part that goes with the number of samples.
struct FrameCost {
  double kernels_ms = 0;
  double samples_ms = 0;
  double total_ms() const noexcept { return kernels_ms + samples_ms; }
};

// Chooses levels from what pictures took. Measured costs are kept by level; what was never drawn is
// told from the nearest that was: an eighth of the kernels and half the sheets for each coarser
// field, a quarter of the samples for each coarser step of pixels. When a level that was measured
// before turns out dearer or cheaper (another side, another look), all others are taken to have
// changed alike.
class LevelChooser {
 public:
  // `pixel`, `spacing`: world sizes of the window's pixel and of the field's spacing; what is
  // shown is then as fine as both together. `coarsest_field`: how often the field was coarsened.
  void set_scales(double pixel, double spacing, int coarsest_field);
  void forget();  // other data

  void measured(const Level& level, const FrameCost& cost);
  double predicted_ms(const Level& level) const;  // 0 before anything was measured

  // The finest level that is expected within `budget_ms`, or the coarsest. Stays with `current`
  // unless that misses by more than a third, or a finer one keeps it with a third to spare: a
  // level that flips back and forth is worse than a coarse one.
  Level choose(double budget_ms, const Level& current) const;

  // Between a moving picture's level and the full picture: the steps worth showing, each at least
  // thrice as dear as the one before, the full one last.
  std::vector<Level> refinement(const Level& from) const;

  // All levels, the finest first.
  const std::vector<Level>& levels() const noexcept { return levels_; }

 private:
  struct Measured {
    Level level;
    FrameCost cost;
  };
  FrameCost cost_of(const Level& level) const;

  std::vector<Level> levels_{Level{}};
  std::vector<Measured> measured_;
};

}  // namespace ovoid::viewer
