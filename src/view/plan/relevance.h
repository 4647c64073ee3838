// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "ovoid/field.h"

namespace ovoid::view {

// Answers whether the field may take a value that matters, given bounds of it; must say yes when in
// doubt.
using MayMatter = std::function<bool(float lo, float hi)>;

// Which bricks of a lattice field can show: one bit per brick, and one per group of 4 x 4 x 4
// bricks for a quick no. Bounds are on the FIELD: min and max of the kernels that reach the brick
// if normalized, of their positive and negative parts if summed. Size: 1 bit per brick (32 KiB for
// 256^3 samples at brick edge 4: it stays in the L1 cache).
class RelevanceMap {
 public:
  // `widening` >= 1: the largest factor by which the frame widens kernels (minification). `grow`:
  // bricks by which the relevant set is dilated on top of what widening needs. `beyond`: index
  // units; a brick's bounds hold so far around it, too. Nothing is relevant until fill_layer() has
  // run for every layer and finish() once.
  RelevanceMap(const LatticeField& field, double widening, int grow, double beyond = 0);

  int num_layers() const noexcept { return static_cast<int>(num_bricks_[2]); }
  // Decides the bricks (*, *, bz). Layers may be filled from different threads.
  void fill_layer(int bz, const MayMatter& may_matter);
  void fill_everything();  // every brick is relevant
  void finish();           // dilates, and builds the coarse bits

  // True if a relevant brick touches the box [lo, hi] (index space, positions; the outermost bricks
  // extend outwards without end).
  bool any_in(const Vec3& lo, const Vec3& hi) const noexcept;

  // Bits like words(), set also for the 26 neighbours of relevant bricks: a no for a brick is a no
  // for every position within a brick's edge of any position in it.
  const std::uint32_t* neighbour_words() const noexcept { return neighbour_words_.data(); }

  int brick_shift() const noexcept { return shift_; }  // log2 of the brick edge
  const Index3& num_bricks() const noexcept { return num_bricks_; }
  int words_per_row() const noexcept {
    return words_per_row_;
  }  // 32-bit words for one row of bricks along x
  // Bit (bx & 31) of word [(bz * num_bricks.y + by) * words_per_row + (bx >> 5)].
  const std::uint32_t* words() const noexcept { return words_.data(); }
  std::int64_t num_relevant() const noexcept;

 private:
  bool at(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept {
    return (words_[static_cast<std::size_t>((bz * num_bricks_[1] + by) * words_per_row_ +
                                            (bx >> 5))] >>
            (bx & 31)) &
           1U;
  }
  std::vector<std::uint32_t> grown(const std::vector<std::uint32_t>& words) const;

  const LatticeField* field_;
  int shift_ = 0;
  int words_per_row_ = 0;
  int dilation_ = 0;
  double sum_bound_ = 1.0;  // greatest sum of weights of a `sum` field
  Index3 num_bricks_{};
  Index3 num_groups_{};
  std::vector<std::uint32_t> words_;
  std::vector<std::uint32_t> neighbour_words_;
  std::vector<std::uint8_t> groups_;
};

}  // namespace ovoid::view
