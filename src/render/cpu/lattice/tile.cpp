// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/lattice/tile.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/cpu/lattice/tile.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifdef OVOID_SIMD_UNITS  // of each target its own (ovoid_simd_sources in cmake/OvoidTargets.cmake)
HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu::HWY_NAMESPACE {
void render_patch_on_target(const LatticeFrame& frame, LatticeWorkspace& work, const TileRect& rect,
                            const RowWord* wanted);
}  // namespace ovoid::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#else
#include "render/cpu/lattice/tile-inl.h"
#endif

#if HWY_ONCE && !defined(OVOID_SIMD_UNIT)

namespace ovoid::cpu {

HWY_EXPORT(render_patch_on_target);

void render_patch(const simd::SimdTarget& target, const LatticeFrame& frame, LatticeWorkspace& work,
                  const TileRect& rect, const RowWord* wanted) {
  target.choose(HWY_DISPATCH_TABLE(render_patch_on_target))(frame, work, rect, wanted);
}

}  // namespace ovoid::cpu
#endif
