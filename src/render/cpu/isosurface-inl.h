// SPDX-License-Identifier: Apache-2.0
// Isosurface mode: finds where a ray first crosses the isovalue between two sheets, refines the
// place on the field and shades it. It stands for "shade" and "composite" in this mode. A group's
// crossings are refined together.
#if defined(OVOID_RENDER_CPU_ISOSURFACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_ISOSURFACE_INL_H_
#undef OVOID_RENDER_CPU_ISOSURFACE_INL_H_
#else
#define OVOID_RENDER_CPU_ISOSURFACE_INL_H_
#endif

#include "render/cpu/composite-inl.h"
#include "render/cpu/gradient-inl.h"
#include "render/cpu/limits-inl.h"
#include "render/cpu/shade-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// A group's samples on sheet s - 1 of the block and on sheet s, between which the field takes the
// isovalue.
struct SurfaceEnds {
  Position from, to;
  V before, after;  // the values there
};

// Where between the ends (0 to 1) the field takes the isovalue.
HWY_INLINE V refine(const LatticeFrame& frame, Workspace& work, const SampleGroup& group,
                    const SurfaceEnds& ends) {
  V before = ends.before;
  V after = ends.after;
  const V iso = hn::Set(d, frame.look.constants.isovalue);
  const M rises = hn::Lt(before, iso);
  V near = hn::Zero(d);
  V far = hn::Set(d, 1.0F);
  M far_is_defined = mask_of(group.lanes);
  for (int i = 0; i < device::kSurfaceSteps; ++i) {
    const V middle = hn::Mul(hn::Set(d, 0.5F), hn::Add(near, far));
    const GroupValues f =
        gather_group(frame, work, group, point_between(ends.from, ends.to, middle));
    const M is_low = hn::Lt(f.value, iso);
    // Same side as the near end: the crossing is behind the middle. Where the field is undefined,
    // stay in front of it.
    const M same =
        hn::And(mask_of(f.defined), hn::Or(hn::And(is_low, rises), hn::Not(hn::Or(is_low, rises))));
    near = hn::IfThenElse(same, middle, near);
    before = hn::IfThenElse(same, f.value, before);
    const M other = hn::And(hn::Not(same), mask_of(group.lanes));
    far = hn::IfThenElse(other, middle, far);
    after = hn::IfThenElse(other, f.value, after);
    far_is_defined = hn::Or(hn::And(other, mask_of(f.defined)), hn::AndNot(other, far_is_defined));
  }
  const V rise = hn::Sub(after, before);
  const V share = hn::Div(hn::Sub(iso, before),
                          hn::IfThenElse(hn::Eq(rise, hn::Zero(d)), hn::Set(d, 1.0F), rise));
  const V clamped = hn::Min(hn::Max(share, hn::Zero(d)), hn::Set(d, 1.0F));
  return hn::MulAdd(hn::Sub(far, near), hn::IfThenElseZero(far_is_defined, clamped), near);
}

// Crossings between sheet s - 1 and sheet s of the block.
inline void surface_sheet(const LatticeFrame& frame, Workspace& work, int s) {
  const Block& block = work.block;
  const BlockPlace& place = block.place;
  TileState& tile = *work.tile;
  const Sheet& here = work.ring[place.number_of(s)];
  const Sheet& front = work.ring[place.number_of(s - 1)];
  const V iso = hn::Set(d, frame.look.constants.isovalue);
  for (int y = 0; y < place.rows; ++y) {
    RowWord& open = tile.open[tile_row(place, y)];
    const RowWord both = here.defined[y] & front.defined[y] & open >> place.x0;
    for_each_group(both, 0, place.columns, [&](int column, std::uint32_t lanes) {
      const int at = here.at(column, y);
      SurfaceEnds ends;
      ends.before = hn::LoadU(d, front.values + at);
      ends.after = hn::LoadU(d, here.values + at);
      std::uint32_t crossing =
          bits_of(hn::Xor(hn::Lt(ends.before, iso), hn::Lt(ends.after, iso))) & lanes;
      if (crossing == 0) return;
      ends.from = position_of(block.sheets[s - 1], column, y);
      ends.to = position_of(block.sheets[s], column, y);
      const V t = refine(frame, work, {s, column, y, crossing}, ends);
      crossing &= kept_by_planes(frame, place, s, column, y, t);
      const V depth =
          hn::MulAdd(hn::Sub(t, hn::Set(d, 1.0F)), hn::Set(d, frame.camera.sampling_distance),
                     hn::Set(d, place.sheets[s].depth));
      crossing = within_spans(frame, place, {s, column, y, crossing}, depth, tile);
      if (crossing == 0) return;
      const V color[3] = {hn::Set(d, frame.look.constants.isosurface_color.x),
                          hn::Set(d, frame.look.constants.isosurface_color.y),
                          hn::Set(d, frame.look.constants.isosurface_color.z)};
      Lighting light{hn::Set(d, 1.0F), hn::Zero(d)};
      if (frame.is_lit) {
        const WorldVector g = exact_gradient(frame, work, {s, column, y, crossing},
                                             point_between(ends.from, ends.to, t));
        light = light_between(frame, place, {s, column, y, crossing}, t, g);
        work.stats.gradients += std::popcount(crossing);
      } else if (frame.light != nullptr) {
        light = light_between(frame, place, {s, column, y, crossing}, t, no_gradient());
      }
      const int pixel = tile_index(place, column, y);
      const M mask = mask_of(crossing);
      add_surface(
          {lit_color(color[0], light), lit_color(color[1], light), lit_color(color[2], light)},
          mask, depth, tile, pixel);
      open &= ~(RowWord{crossing} << tile_column(place, column));
      work.stats.samples_shaded += std::popcount(crossing);
    });
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
