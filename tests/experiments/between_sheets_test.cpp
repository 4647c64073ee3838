// SPDX-License-Identifier: Apache-2.0
// Pieces come nearer to many sheets than samples do.
#include "experiments/between_sheets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

namespace ovoid::experiments {
namespace between_sheets_test {

double db_of(const std::vector<BetweenSheets>& rows, std::string_view look,
             Classification classification, double sheets) {
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const BetweenSheets& other) {
    return other.look == look && other.classification == classification &&
           other.sheets_per_spacing == sheets;
  });
  return row->psnr_db;
}

// Fails if pieces do not gain at least 6 dB (half the error): pre-integrated where sheets are as
// far apart as samples, on thin layers; refined, at their own distance, on any look. What was
// measured is in docs/numerics.md.
TEST(BetweenSheets, PiecesGain) {
  const std::vector<BetweenSheets> rows = measure_between_sheets(40, 64);
  for (const char* look : {"layers", "skin and bone"}) {
    const double sampled = db_of(rows, look, Classification::kSampled, 1.0);
    EXPECT_GT(sampled, 10);
    EXPECT_GT(db_of(rows, look, Classification::kRefined, 2.0), sampled + 6) << look;
  }
  EXPECT_GT(db_of(rows, "layers", Classification::kPreintegrated, 1.0),
            db_of(rows, "layers", Classification::kSampled, 1.0) + 6);
}

}  // namespace between_sheets_test
}  // namespace ovoid::experiments
