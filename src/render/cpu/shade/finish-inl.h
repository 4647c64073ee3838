// SPDX-License-Identifier: Apache-2.0
// What every kind of tile does with the values of a sheet: classify, light and composite, or add
// them up.
#if defined(OVOID_RENDER_CPU_FINISH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_FINISH_INL_H_
#undef OVOID_RENDER_CPU_FINISH_INL_H_
#else
#define OVOID_RENDER_CPU_FINISH_INL_H_
#endif

#include "render/cpu/shade/composite-inl.h"
#include "render/cpu/shade/limits-inl.h"
#include "render/cpu/shade/pieces-inl.h"
#include "render/cpu/shade/shade-inl.h"
#include "render/cpu/ticks.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Classifies and lights the samples of sheet s named by `bits`, in mode composite. Calls
// take_gradients() if any are wanted of the samples that turn out visible. Returns whether any is.
template <class TakeGradients>
inline bool shade_samples(const CpuFrame& frame, const TileInHand& tile, int s, const RowBits& bits,
                          StageClock& clock, const TakeGradients& take_gradients) {
  const BlockPlace& place = tile.place;
  const Sheet& sheet = tile.ring[place.number_of(s)];
  ShadedSheet& shaded = tile.shaded;
  classify_sheet(frame, place, tile.ring, s, bits, shaded);
  const std::int64_t num_visible = count_bits(shaded.visible, place.rows);
  clock.lap(kShade);
  if (num_visible == 0) return false;
  tile.stats.samples_shaded += num_visible;
  if (frame.has_own_color) color_sheet(frame, place, sheet, shaded);
  if (frame.takes_gradients) {
    take_gradients();
    clock.lap(kGradient);
  }
  if (frame.corrects_late) correct_sheet(frame, place, s, sheet, shaded);
  if (frame.takes_light()) light_sheet(frame, place, s, sheet, shaded);
  clock.lap(kShade);
  return true;
}

// The samples of sheet s named by `samples`, whose values are there; the rest as shade_samples().
template <class TakeGradients>
inline bool finish_samples(const CpuFrame& frame, const TileInHand& tile, int s,
                           const RowBits& samples, StageClock& clock,
                           const TakeGradients& take_gradients) {
  const BlockPlace& place = tile.place;
  const RowBits bits =
      place.limits == nullptr ? samples : with_path_within(frame, place, s, samples, tile.pixels);
  if (frame.mode != Mode::kComposite) {
    accumulate_sheet(frame, place, s, tile.ring[place.number_of(s)].values, bits, tile.pixels);
    clock.lap(kComposite);
    return false;
  }
  if (!shade_samples(frame, tile, s, bits, clock, take_gradients)) return false;
  composite_sheet(frame, place, s, tile.shaded, tile.pixels);
  clock.lap(kComposite);
  return true;
}

// The refined pieces that end on sheet s, of the pixels named by `bits`, within the spans in hand.
// Calls take_gradients() if
// those of the ends of visible pieces are wanted. Returns whether any is visible.
template <class PartOf, class TakeGradients>
inline bool finish_pieces_in_hand(const CpuFrame& frame, const TileInHand& tile, int s,
                                  const RowBits& bits, const PartOf& part_of, StageClock& clock,
                                  const TakeGradients& take_gradients) {
  const RowBits pieces = with_an_end(tile.place, tile.ring, s, bits);
  if (frame.mode != Mode::kComposite) {
    accumulate_pieces(frame, tile, s, pieces, part_of);
    clock.lap(kComposite);
    return false;
  }
  classify_pieces(frame, tile.place, tile.ring, s, pieces, tile.shaded);
  const bool is_visible = count_bits(tile.shaded.visible, tile.place.rows) > 0;
  clock.lap(kShade);
  if (!is_visible) return false;
  if (frame.takes_gradients) {
    take_gradients();
    clock.lap(kGradient);
  }
  draw_pieces(frame, tile, s, part_of);
  clock.lap(kShade);
  return true;
}

// The same, whatever depth limits there are: one span of a piece after the other.
template <class PartOf, class TakeGradients>
inline bool finish_pieces(const CpuFrame& frame, const TileInHand& tile, int s, const RowBits& bits,
                          const PartOf& part_of, StageClock& clock,
                          const TakeGradients& take_gradients) {
  const BlockPlace& place = tile.place;
  if (place.limits == nullptr)
    return finish_pieces_in_hand(frame, tile, s, bits, part_of, clock, take_gradients);
  const float far = place.sheets[s].depth;
  const float near = far - frame.camera.sampling_distance;
  leave_spans(frame, place, bits, near, tile.pixels);
  bool is_visible = false;
  RowBits left = within_spans(frame, place, bits, near, far, tile.pixels);
  while (count_bits(left, place.rows) > 0) {
    if (finish_pieces_in_hand(frame, tile, s, left, part_of, clock, take_gradients))
      is_visible = true;
    left = at_next_spans(frame, place, left, far, tile.pixels);
    left = within_spans(frame, place, left, near, far, tile.pixels);
  }
  return is_visible;
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
