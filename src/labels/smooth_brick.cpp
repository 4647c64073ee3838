// SPDX-License-Identifier: Apache-2.0
#include "labels/smooth_brick.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "labels/smooth_brick.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "labels/smooth_brick-inl.h"

#if HWY_ONCE

namespace ovoid::labels {

HWY_EXPORT(smoothed_on_target);

LabelBrick smoothed_brick(const simd::SimdTarget& target, const std::uint16_t* window) {
  return target.choose(HWY_DISPATCH_TABLE(smoothed_on_target))(window);
}

}  // namespace ovoid::labels
#endif
