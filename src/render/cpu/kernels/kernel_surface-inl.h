// SPDX-License-Identifier: Apache-2.0
// Isosurface mode of kernel sets: crossings of the isovalues between two sheets, on the straight
// line between their values; gradients and colours are mixed likewise.
#if defined(OVOID_RENDER_CPU_KERNEL_SURFACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_KERNEL_SURFACE_INL_H_
#undef OVOID_RENDER_CPU_KERNEL_SURFACE_INL_H_
#else
#define OVOID_RENDER_CPU_KERNEL_SURFACE_INL_H_
#endif

#include "render/cpu/kernels/kernel_block.h"
#include "render/cpu/lattice/differences-inl.h"
#include "render/cpu/shade/composite-inl.h"
#include "render/cpu/shade/limits-inl.h"
#include "render/cpu/shade/shade-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

HWY_INLINE WorldVector mix_vectors(const WorldVector& a, const WorldVector& b, V t) {
  const auto mix = [&](V p, V q) { return hn::MulAdd(hn::Sub(q, p), t, p); };
  return {mix(a.x, b.x), mix(a.y, b.y), mix(a.z, b.z)};
}

// A surface that the group's lanes cross joins their pixels. Returns the lanes that it closes.
inline std::uint32_t draw_kernel_crossing(const CpuFrame& frame, const TileInHand& tile,
                                          const FrameSurface& surface, SampleGroup group, V before,
                                          V after) {
  const BlockPlace& place = tile.place;
  const auto& [s, column, row, crossing] = group;
  const V rise = hn::Sub(after, before);
  const V t = hn::Div(hn::Sub(hn::Set(d, surface.value), before),
                      hn::IfThenElse(hn::Eq(rise, hn::Zero(d)), hn::Set(d, 1.0F), rise));
  group.lanes &= kept_by_planes(frame, place, s, column, row, t);
  group.lanes &= with_path_by_planes(frame, place, s - 1, column, row) &
                 with_path_by_planes(frame, place, s, column, row);
  const V depth =
      hn::MulAdd(hn::Sub(t, hn::Set(d, 1.0F)), hn::Set(d, frame.camera.sampling_distance),
                 hn::Set(d, place.sheets[s].depth));
  group.lanes = within_spans(frame, place, group, depth, tile.pixels);
  if (group.lanes == 0) return 0;
  Classified color{hn::Set(d, surface.color[0]), hn::Set(d, surface.color[1]),
                   hn::Set(d, surface.color[2]), hn::Zero(d)};
  if (frame.has_own_color && !surface.has_color) {
    const Sheet& here = tile.ring[place.number_of(s)];
    const Sheet& front = tile.ring[place.number_of(s - 1)];
    const int at = here.at(column, row);
    const V from = hn::LoadU(d, front.colors + at);
    const V to = hn::LoadU(d, here.colors + at);
    color = classify(frame.look.color, hn::MulAdd(hn::Sub(to, from), t, from));
  }
  Lighting light{hn::Set(d, 1.0F), hn::Zero(d)};
  if (frame.is_lit) {
    const WorldVector g = mix_vectors(
        central_difference_gradient(frame, place, tile.ring, {s - 1, column, row, group.lanes}),
        central_difference_gradient(frame, place, tile.ring, group), t);
    light = light_between(frame, place, group, t, g);
    tile.stats.gradients += std::popcount(group.lanes);
  } else if (frame.light != nullptr) {
    light = light_between(frame, place, group, t, no_gradient());
  }
  tile.stats.samples_shaded += std::popcount(group.lanes);
  return add_surface(
      frame,
      {lit_color(color.red, light), lit_color(color.green, light), lit_color(color.blue, light)},
      surface.opacity, mask_of(group.lanes), depth, tile.pixels, tile_index(place, column, row));
}

inline void kernel_surface_sheet(const CpuFrame& frame, const TileInHand& tile, int s) {
  const BlockPlace& place = tile.place;
  const Sheet& here = tile.ring[place.number_of(s)];
  const Sheet& front = tile.ring[place.number_of(s - 1)];
  for (int y = place.margin; y < place.rows - place.margin; ++y) {
    RowWord& open = tile.pixels.open[tile_row(place, y)];
    const RowWord both = here.defined[y] & front.defined[y] & open << place.margin;
    for_each_group(
        both, place.margin, place.columns - place.margin, [&](int column, std::uint32_t lanes) {
          const int at = here.at(column, y);
          const V before = hn::LoadU(d, front.values + at);
          const V after = hn::LoadU(d, here.values + at);
          std::uint32_t closed = 0;
          for_each_surface(frame, before, after, lanes,
                           [&](const FrameSurface& surface, std::uint32_t crossing) {
                             crossing &= ~closed;
                             if (crossing == 0) return;
                             closed |= draw_kernel_crossing(
                                 frame, tile, surface, {s, column, y, crossing}, before, after);
                           });
          open &= ~(RowWord{closed} << tile_column(place, column));
        });
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
