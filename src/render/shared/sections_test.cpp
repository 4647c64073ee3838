// SPDX-License-Identifier: Apache-2.0
#include "render/shared/sections.h"

#include <gtest/gtest.h>

namespace ovoid {
namespace sections_test {

// Fails if the moments that shaders sum by points, and those that the cpu back end has in closed
// form, are of different slabs or Gaussians. Slabs are as wide as a sheet, kernels' sigmas half a
// sheet and more.
TEST(SlabMoments, AreTheSameByPointsAndInClosedForm) {
  for (const float width : {0.05F, 0.5F, 1.0F, 2.0F}) {
    for (float a = -4.0F; a <= 4.0F - width; a += 0.125F) {
      const SlabMoments closed = slab_moments(a, a + width);
      const SlabMoments by_points = device::slab_moments_by_points(a, a + width);
      EXPECT_NEAR(by_points.weight, closed.weight, 1e-6F) << a << " " << width;
      EXPECT_NEAR(by_points.mean, closed.mean, 1e-6F) << a << " " << width;
      EXPECT_NEAR(by_points.variance, closed.variance, 1e-6F) << a << " " << width;
    }
  }
}

}  // namespace sections_test
}  // namespace ovoid
