// SPDX-License-Identifier: Apache-2.0
// Pre-integrated pieces come nearer to many sheets than samples do.
#include "experiments/between_sheets.h"

#include <gtest/gtest.h>

namespace ovoid::experiments {
namespace {

// Fails if pieces do not gain at least 6 dB (half the error) where sheets are as far apart as
// samples, on thin layers; what was measured is in docs/numerics.md.
TEST(BetweenSheets, PiecesGainOnThinLayers) {
  double sampled = 0;
  double pieces = 0;
  for (const BetweenSheets& row : measure_between_sheets(40, 64)) {
    if (row.look != "layers" || row.sheets_per_spacing != 1.0) continue;
    (row.classification == Classification::kSampled ? sampled : pieces) = row.psnr_db;
  }
  EXPECT_GT(sampled, 10);
  EXPECT_GT(pieces, sampled + 6);
}

}  // namespace
}  // namespace ovoid::experiments
