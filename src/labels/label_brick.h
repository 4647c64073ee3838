// SPDX-License-Identifier: Apache-2.0
// The smoothed scores of 8 x 8 x 8 cells of a label map.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace ovoid::labels {

// Cells along an axis of a brick: cell i lies between the samples i - 1 and i of the brick's eight,
// so that half a cell around the whole map is in bricks, too.
inline constexpr int kBrickEdge = 8;
inline constexpr int kNumCells = kBrickEdge * kBrickEdge * kBrickEdge;
// Fine scores have the spacing of samples, coarse ones twice that: two and one beside the cells,
// where the four taps of a cubic B-spline reach.
inline constexpr int kFineEdge = kBrickEdge + 3;
inline constexpr int kCoarseEdge = 8;
inline constexpr int kNumFine = kFineEdge * kFineEdge * kFineEdge;
inline constexpr int kNumCoarse = kCoarseEdge * kCoarseEdge * kCoarseEdge;
// What a score of 1 is stored as.
inline constexpr float kScoreSteps = 200;
// Labels that a brick tells apart: the most frequent ones.
inline constexpr int kMostInBrick = 32;
// Sets of candidates likewise; of more the last is all labels.
inline constexpr std::size_t kMostSets = 256;

struct LabelBrick {
  // Ranks of the labels that have scores in the brick. One: that alone, and nothing else is stored.
  std::vector<std::uint16_t> ranks;
  // Everywhere the scores of all labels add up to 1: none was lost and kept, or left out.
  bool adds_up = false;
  std::vector<std::uint8_t> fine;    // [ranks][kFineEdge^3], and 3 bytes to read beyond the end
  std::vector<std::uint8_t> coarse;  // [ranks][kCoarseEdge^3]
  // Which labels can win in a cell, bit i: ranks[i]. Cells [8][8][8] have the numbers of their
  // sets: few sets are many cells'.
  std::vector<std::uint32_t> candidate_sets;
  std::vector<std::uint8_t> candidates;

  std::size_t bytes() const noexcept {
    return sizeof *this + 2 * ranks.size() + fine.size() + coarse.size() + candidates.size() +
           4 * candidate_sets.size();
  }
};

}  // namespace ovoid::labels
