// SPDX-License-Identifier: Apache-2.0
// Fields that blend the steps of a series while they are drawn, against the volume of that time.
#include <gtest/gtest.h>

#include "model/test_steps.h"
#include "ovoid/error.h"
#include "ovoid/slices.h"
#include "support/agreement.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace slice_fields_test {

Series moving_waves(SeriesKind kind, double hole = -1) {
  const bool is_staggered = kind == SeriesKind::kStaggered;
  const auto times = is_staggered ? staggered_times(9) : std::vector<double>{0, 1, 1.5, 4, 7};
  const auto dims = is_staggered ? Index3{17, 14, 19} : Index3{23, 18, 21};
  return Series(std::make_shared<FormulaSteps>(
      kind, dims, times,
      [times, hole](const Vec3& p, std::int64_t step) {
        if ((p - Vec3(8, 7, 9)).norm() < hole) return kMissing;
        const double t = times[static_cast<std::size_t>(step)];
        return 0.5 + 0.02 * t + 0.25 * std::cos(0.8 * p.x() + t) +
               0.2 * std::sin(p.y() - 0.6 * p.z());
      },
      oblique_axes()));
}

TestScene scene_of(const LatticeField& field, bool is_parallel) {
  TestScene scene{field, askew_camera(field, is_parallel, 1.3), semi_transparent_look(0, 1),
                  picture(48, 40)};
  // So narrow that most bricks are irrelevant: too narrow a range of one leaves holes.
  scene.look.transfer_function.opacities = {{0.7, 0}, {0.75, 0.4}, {0.8, 0}};
  return scene;
}

// Fails if a step or half has the wrong share or place, or the range of a brick is too narrow.
TEST(SliceFields, AreTheVolumesOfTheirTimes) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  for (const SeriesKind kind : {SeriesKind::kSteps, SeriesKind::kStaggered}) {
    for (const double hole : {-1.0, 3.0}) {
      const Series series = moving_waves(kind, hole);
      for (const LatticeKernel& kernel : {LatticeKernel{}, kLabelKernel, {0.8, 4}}) {
        LatticeModelOptions model;
        model.kernel = kernel;
        SliceFields fields(series, model);
        for (const double time : {0.3, 1.0, 2.2, 4.1}) {
          const LatticeField direct = fields.at(time);
          const LatticeField volume = make_lattice_field(slice_at_time(series, time), model);
          EXPECT_EQ(direct.geometry().dims, volume.geometry().dims);
          EXPECT_LE(direct.value_range().lo, volume.value_range().lo + 1e-4F);
          EXPECT_GE(direct.value_range().hi, volume.value_range().hi - 1e-4F);
          const Image found = draw(scene_of(direct, time < 2)).image;
          const Image expected = draw(scene_of(volume, time < 2)).image;
          EXPECT_GE(compare(found, expected).psnr_db, 80)
              << name_of(kind) << " at " << time << ", sigma " << kernel.sigma << ", hole " << hole;
        }
      }
    }
  }
}

TEST(SliceFields, OutliveTheirMaker) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const Series series = moving_waves(SeriesKind::kSteps);
  LatticeField field;
  {
    SliceFields fields(series, {});
    field = fields.at(0.5);
    fields.at(6);  // lets go of the steps
  }
  const LatticeField volume = make_lattice_field(slice_at_time(series, 0.5));
  EXPECT_GE(compare(draw(scene_of(field, true)).image, draw(scene_of(volume, true)).image).psnr_db,
            80);
}

TEST(SliceFields, RefuseWhatIsNoSumOverSteps) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const Series series = moving_waves(SeriesKind::kStaggered);
  TimeSliceOptions options;
  options.filter = TimeFilter::kExact;
  EXPECT_THROW(SliceFields(series, {}, options), Error);
  SliceFields fields(series, {});
  EXPECT_THROW(fields.at(-1), Error);
}

}  // namespace slice_fields_test
}  // namespace ovoid::test
