// SPDX-License-Identifier: Apache-2.0
// The cpu back end against the reference: volumes by looks by projections.
#include <gtest/gtest.h>

#include "support/agreement.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace table_test {

// One sample alone passes for a field only within 0.09 spacings of its place: elsewhere less than
// 0.48 of the weights are there.
bool is_one_sample(const LatticeField& field) { return field.num_kernels() == 1; }

Camera table_camera(const LatticeField& field, bool is_parallel) {
  return askew_camera(field, is_parallel, is_one_sample(field) ? 8 : 1.4);
}

RenderOptions table_options(const LatticeField& field) {
  return picture(52, 48, is_one_sample(field) ? 0.06 : 0);
}

// Where a field ends, a sample at the end itself exists or not by its rounding: one sample's small
// ball is all end.
ImageTolerance tolerance_of(const LatticeField& field) {
  ImageTolerance tolerance;
  if (is_one_sample(field)) {
    tolerance.min_psnr_db = kAllEndPsnrDb;
    tolerance.max_8bit = kAllEnd8BitDifference;
  }
  return tolerance;
}

class AgreementTable : public ::testing::TestWithParam<int> {};

// Fails if the cpu back end misreads a stored type, its scale, the axes or the missing samples of a
// volume, or misses a feature of the look that is narrower than its tables resolve.
TEST_P(AgreementTable, EveryLookBothProjections) {
  if (GetParam() > 0) {
    OVOID_NIGHTLY_ON_DEVICE();
  }
  OVOID_NOT_UNDER_TSAN();
  const TestVolume volume = test_volumes()[static_cast<std::size_t>(GetParam())];
  int number = GetParam();
  for (const TestLook& look : test_looks(volume.lo, volume.hi)) {
    ++number;
    for (const bool is_parallel : {true, false}) {
      if (is_left_out(number, is_parallel ? 1 : 0)) continue;
      const TestScene scene{volume.field, table_camera(volume.field, is_parallel), look.look,
                            table_options(volume.field)};
      const std::string name =
          volume.name + ", " + look.name + ", " + (is_parallel ? "parallel" : "perspective");
      // A slice has few samples at values within a peak.
      EXPECT_TRUE(backends_agree(scene, name, 0.01, tolerance_of(volume.field))) << name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Volumes, AgreementTable, ::testing::Range(0, 5));

}  // namespace table_test
}  // namespace ovoid::test
