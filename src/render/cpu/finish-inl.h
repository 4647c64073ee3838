// SPDX-License-Identifier: Apache-2.0
// What every kind of tile does with the values of a sheet: classify, light and composite, or add
// them up.
#if defined(OVOID_RENDER_CPU_FINISH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_FINISH_INL_H_
#undef OVOID_RENDER_CPU_FINISH_INL_H_
#else
#define OVOID_RENDER_CPU_FINISH_INL_H_
#endif

#include "render/cpu/block-inl.h"
#include "render/cpu/composite-inl.h"
#include "render/cpu/shade-inl.h"
#include "render/cpu/ticks.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// The samples of sheet s named by `bits`, whose values are there. `colors`: the plane of the values
// that give colour, where another attribute does. Calls take_gradients() if any are wanted of the
// samples that turn out visible. Returns whether any is.
template <class TakeGradients>
inline bool finish_samples(const CpuFrame& frame, Block& block, TileState& tile, WorkerStats& stats,
                           int s, const RowBits& bits, const float* colors, StageClock& clock,
                           const TakeGradients& take_gradients) {
  if (frame.mode != Mode::kComposite) {
    accumulate_sheet(frame, block, tile, s, bits);
    clock.lap(kComposite);
    return false;
  }
  classify_sheet(frame, block, s, bits);
  const std::int64_t num_visible = count_bits(block, block.visible);
  clock.lap(kShade);
  if (num_visible == 0) return false;
  stats.samples_shaded += num_visible;
  if (frame.has_own_color) color_sheet(frame, block, colors);
  if (frame.takes_gradients) {
    take_gradients();
    clock.lap(kGradient);
  }
  if (frame.corrects_late) correct_sheet(frame, block, s);
  if (frame.is_lit) light_sheet(frame, block);
  clock.lap(kShade);
  composite_sheet(block, tile, s);
  clock.lap(kComposite);
  return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
