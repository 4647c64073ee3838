// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/kernels/kernel_tile.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/cpu/kernels/kernel_tile.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifdef OVOID_SIMD_UNITS  // of each target its own (ovoid_simd_sources in cmake/OvoidTargets.cmake)
HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu::HWY_NAMESPACE {
void render_kernel_tile_on_target(const KernelFrame& frame, KernelTileWorkspace& work,
                                  const TileRect& rect);
}  // namespace ovoid::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#else
#include "render/cpu/kernels/kernel_tile-inl.h"
#endif

#if HWY_ONCE && !defined(OVOID_SIMD_UNIT)

namespace ovoid::cpu {

HWY_EXPORT(render_kernel_tile_on_target);

void render_kernel_tile(const simd::SimdTarget& target, const KernelFrame& frame,
                        KernelTileWorkspace& work, const TileRect& rect) {
  target.choose(HWY_DISPATCH_TABLE(render_kernel_tile_on_target))(frame, work, rect);
}

}  // namespace ovoid::cpu
#endif
