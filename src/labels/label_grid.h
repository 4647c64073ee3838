// SPDX-License-Identifier: Apache-2.0
// A label map in memory: ranks of labels, and bricks of smoothed scores, made when they are asked
// for (docs/numerics.md, "Labels").
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <variant>
#include <vector>

#include "labels/label_brick.h"
#include "ovoid/field.h"
#include "simd/simd_target.h"

namespace ovoid::labels {

// A label's place in the rising list of all; kNoLabel: a missing sample.
using Rank = std::uint16_t;
inline constexpr Rank kNoLabel = 0xFFFF;
inline constexpr std::size_t kMostRanks = 65000;

class LabelGrid {
 public:
  // Throws as make_label_map().
  LabelGrid(const LatticeField& field, int threads, const std::stop_token& stop);
  ~LabelGrid();
  LabelGrid(const LabelGrid&) = delete;
  LabelGrid& operator=(const LabelGrid&) = delete;

  const std::vector<int>& labels() const noexcept { return labels_; }
  const LatticeGeometry& geometry() const noexcept { return geometry_; }
  const simd::SimdTarget& target() const noexcept { return target_; }

  // Bricks along each axis. Brick (i, j, k) is the part of index space with kBrickEdge * i - 1 <= x
  // < kBrickEdge * (i + 1) - 1, y and z likewise.
  const Index3& num_bricks() const noexcept { return num_bricks_; }
  std::size_t brick_at(std::int64_t i, std::int64_t j, std::int64_t k) const noexcept {
    return static_cast<std::size_t>((k * num_bricks_[1] + j) * num_bricks_[0] + i);
  }
  // The one label in a brick and in all that reaches it, as far as is known; kMixed: perhaps
  // several. Where making a brick finds one alone, this says so from then on.
  Rank only_label(std::size_t brick) const noexcept {
    return only_label_[brick].load(std::memory_order_relaxed);
  }
  static constexpr Rank kMixed = 0xFFFE;
  // Of a brick that is not kMixed: bricks less than so many steps away, along axes or aslant, have
  // the same label alone.
  int steps_to_others(std::size_t brick) const noexcept { return steps_to_others_[brick]; }
  // Of a brick that is kMixed. Made by the first who asks.
  const LabelBrick& brick(std::int64_t i, std::int64_t j, std::int64_t k) const;

  // Beyond the map the outermost samples go on.
  Rank rank_at(std::int64_t i, std::int64_t j, std::int64_t k) const noexcept;
  // Ranks of the samples [lo, lo + kWindowEdge) along each axis, x fastest.
  void copy_window(const Index3& lo, Rank* window) const;

  std::size_t resident_bytes() const noexcept;

 private:
  void read_labels(const LatticeField& field, int threads, const std::stop_token& stop);
  void find_even_bricks(int threads, const std::stop_token& stop);
  void find_steps_to_others();

  LatticeGeometry geometry_;
  std::vector<int> labels_;
  // By samples, x fastest. Of at most 255 labels a byte, in which 255 stands for kNoLabel.
  std::variant<std::vector<std::uint8_t>, std::vector<std::uint16_t>> ranks_;
  Index3 num_bricks_{};
  mutable std::vector<std::atomic<Rank>> only_label_;
  std::vector<std::uint8_t> steps_to_others_;
  simd::SimdTarget target_;
  mutable std::unique_ptr<std::atomic<const LabelBrick*>[]> bricks_;
  mutable std::atomic<std::size_t> brick_bytes_{0};
};

}  // namespace ovoid::labels
