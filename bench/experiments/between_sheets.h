// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "ovoid/renderer.h"

namespace ovoid::experiments {

// One picture drawn with sheets farther apart than the look's features, and how far it is from one
// with sixteen sheets per spacing.
struct BetweenSheets {
  std::string look;
  Classification classification;
  double sheets_per_spacing;
  double psnr_db;
  double cpu_ms;  // of all threads, the best of a few frames
  Image image;
};

// Looks on smooth data: layers 4 % of the range wide, and skin and bone.
std::vector<BetweenSheets> measure_between_sheets(std::int64_t size, int pixels);

}  // namespace ovoid::experiments
