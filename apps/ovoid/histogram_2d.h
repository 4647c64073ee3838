// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "ovoid/field.h"

namespace ovoid::cli {

// How often values and lengths of the gradient go together in the field that is drawn.
struct Histogram2D {
  static constexpr int kColumns = 256, kRows = 256;
  double value_lo = 0, value_hi = 1;
  double gradient_hi = 1;             // value per world length, from 0; what is steeper is left out
  std::vector<std::uint32_t> counts;  // [kRows, kColumns], the row of gradient 0 first
};

inline constexpr std::int64_t kMostCopied2D = std::int64_t{1} << 26;  // 576 MiB

// Of some hundred thousand places, evenly spread over the field's box; 999 of 1000 gradients are
// in. Throws what the field's source throws, Error(kInvalidArgument) where nothing is defined, and
// kCancelled. Cost: a sample of the field at each place, and a copy of a lattice's samples, 9 bytes
// each; of one with more than `most_copied` fewer places, and no copy.
Histogram2D histogram_2d_of(const Field& field, const std::stop_token& stop = {},
                            std::int64_t most_copied = kMostCopied2D);

// How bright each count is drawn, in [0, 1], by its logarithm; 1 from those that 2 of 100 reach.
std::vector<float> brightness_of(const Histogram2D& histogram);

// As a picture (.png) of kColumns x kRows pixels, gradients upwards, or as JSON. Throws
// Error(kFileWrite, kUnsupported).
void write_histogram_2d(const Histogram2D& histogram, const std::string& path);

}  // namespace ovoid::cli
