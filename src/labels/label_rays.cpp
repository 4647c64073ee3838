// SPDX-License-Identifier: Apache-2.0
#include "labels/label_rays.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "labels/label_rays.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "labels/label_rays-inl.h"

#if HWY_ONCE

namespace ovoid::labels {

HWY_EXPORT(trace_on_target);
HWY_EXPORT(winner_on_target);

Bodies::Id trace(const LabelGrid& grid, const Bodies& bodies, const LabelRay& ray, Rank* rank,
                 std::vector<LabelCrossing>& crossings) {
  return grid.target().choose(HWY_DISPATCH_TABLE(trace_on_target))(grid, bodies, ray, rank,
                                                                   crossings);
}

Rank winner_at(const LabelGrid& grid, const Vec3& place) {
  return grid.target().choose(HWY_DISPATCH_TABLE(winner_on_target))(grid, place);
}

}  // namespace ovoid::labels
#endif
