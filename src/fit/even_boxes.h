// SPDX-License-Identifier: Apache-2.0
// Looks for runs and boxes of samples that rise evenly: docs/numerics.md, "Boxes of a scan".
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "fit/lattice_samples.h"
#include "ovoid/simplify.h"

namespace ovoid::fit {

enum class SampleState : std::uint8_t {
  kOpen,     // wants a box
  kFree,     // the background stands for it, too
  kDropped,  // no box may have it
  kTaken     // is in one
};

struct BoxRules {
  double tolerance = 0;  // of a sample, in its own numbers
  double rms = 0;        // of a box
  Primitives primitives = Primitives::kBoxes;
  RunSearch search = RunSearch::kGreedy;
};

// What was found in some layers: the boxes, and how many samples in none follow the last one's
// first sample.
struct BoxesOfLayers {
  std::vector<LatticeBox> boxes;
  std::int64_t gap_behind = 0;
};

// Layers [begin, end) of the samples, whose states become kTaken where a box has them. `all`: dims,
// least, greatest, step and whole say what a box's numbers are read as; `states` those of all
// samples. Throws Error(kCancelled).
BoxesOfLayers find_even_boxes(const LatticeSamples& samples, const LatticeBoxes& all,
                              const BoxRules& rules, std::int64_t begin, std::int64_t end,
                              std::span<SampleState> states, const std::stop_token& stop);

}  // namespace ovoid::fit
