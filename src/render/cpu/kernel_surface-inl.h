// SPDX-License-Identifier: Apache-2.0
// Isosurface mode of kernel sets: the first crossing of the isovalue between two sheets, on the
// straight line between their values; its gradient and colour are mixed likewise.
#if defined(OVOID_RENDER_CPU_KERNEL_SURFACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_KERNEL_SURFACE_INL_H_
#undef OVOID_RENDER_CPU_KERNEL_SURFACE_INL_H_
#else
#define OVOID_RENDER_CPU_KERNEL_SURFACE_INL_H_
#endif

#include "render/cpu/composite-inl.h"
#include "render/cpu/differences-inl.h"
#include "render/cpu/kernel_block.h"
#include "render/cpu/limits-inl.h"
#include "render/cpu/shade-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

HWY_INLINE WorldVector mix_vectors(const WorldVector& a, const WorldVector& b, V t) {
  const auto mix = [&](V p, V q) { return hn::MulAdd(hn::Sub(q, p), t, p); };
  return {mix(a.x, b.x), mix(a.y, b.y), mix(a.z, b.z)};
}

inline void kernel_surface_sheet(const CpuFrame& frame, const TileInHand& tile, int s) {
  const BlockPlace& place = tile.place;
  TileState& pixels = tile.pixels;
  const Sheet& here = tile.ring[place.number_of(s)];
  const Sheet& front = tile.ring[place.number_of(s - 1)];
  const V iso = hn::Set(d, frame.look.constants.isovalue);
  for (int y = place.margin; y < place.rows - place.margin; ++y) {
    RowWord& open = pixels.open[tile_row(place, y)];
    const RowWord both = here.defined[y] & front.defined[y] & open << place.margin;
    for_each_group(
        both, place.margin, place.columns - place.margin, [&](int column, std::uint32_t lanes) {
          const int at = here.at(column, y);
          const V before = hn::LoadU(d, front.values + at);
          const V after = hn::LoadU(d, here.values + at);
          std::uint32_t crossing =
              bits_of(hn::Xor(hn::Lt(before, iso), hn::Lt(after, iso))) & lanes;
          if (crossing == 0) return;
          const V rise = hn::Sub(after, before);
          const V t = hn::Div(hn::Sub(iso, before),
                              hn::IfThenElse(hn::Eq(rise, hn::Zero(d)), hn::Set(d, 1.0F), rise));
          crossing &= kept_by_planes(frame, place, s, column, y, t);
          crossing &= with_path_by_planes(frame, place, s - 1, column, y) &
                      with_path_by_planes(frame, place, s, column, y);
          const V depth =
              hn::MulAdd(hn::Sub(t, hn::Set(d, 1.0F)), hn::Set(d, frame.camera.sampling_distance),
                         hn::Set(d, place.sheets[s].depth));
          crossing = within_spans(frame, place, {s, column, y, crossing}, depth, pixels);
          if (crossing == 0) return;
          Classified color{hn::Set(d, frame.look.constants.isosurface_color.x),
                           hn::Set(d, frame.look.constants.isosurface_color.y),
                           hn::Set(d, frame.look.constants.isosurface_color.z), hn::Zero(d)};
          if (frame.has_own_color) {
            const V from = hn::LoadU(d, front.colors + at);
            const V to = hn::LoadU(d, here.colors + at);
            color = classify(frame.look.color, hn::MulAdd(hn::Sub(to, from), t, from));
          }
          Lighting light{hn::Set(d, 1.0F), hn::Zero(d)};
          if (frame.is_lit) {
            const WorldVector g = mix_vectors(
                central_difference_gradient(frame, place, tile.ring, {s - 1, column, y, crossing}),
                central_difference_gradient(frame, place, tile.ring, {s, column, y, crossing}), t);
            light = light_between(frame, place, {s, column, y, crossing}, t, g);
            tile.stats.gradients += std::popcount(crossing);
          } else if (frame.light != nullptr) {
            light = light_between(frame, place, {s, column, y, crossing}, t, no_gradient());
          }
          const int pixel = tile_index(place, column, y);
          const M mask = mask_of(crossing);
          add_surface({lit_color(color.red, light), lit_color(color.green, light),
                       lit_color(color.blue, light)},
                      mask, depth, pixels, pixel);
          open &= ~(RowWord{crossing} << tile_column(place, column));
          tile.stats.samples_shaded += std::popcount(crossing);
        });
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
