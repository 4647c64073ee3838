// SPDX-License-Identifier: Apache-2.0
// Isosurface mode: finds where a ray crosses the isovalues between two sheets, refines the places
// on the field and shades them. It stands for "shade" and "composite" in this mode. A group's
// crossings are refined together.
#if defined(OVOID_RENDER_CPU_ISOSURFACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_ISOSURFACE_INL_H_
#undef OVOID_RENDER_CPU_ISOSURFACE_INL_H_
#else
#define OVOID_RENDER_CPU_ISOSURFACE_INL_H_
#endif

#include "render/cpu/lattice/gradient-inl.h"
#include "render/cpu/shade/composite-inl.h"
#include "render/cpu/shade/limits-inl.h"
#include "render/cpu/shade/shade-inl.h"

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
                    const SurfaceEnds& ends, V iso) {
  V before = ends.before;
  V after = ends.after;
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

// A surface that the group's lanes cross joins their pixels. Returns the lanes that it closes.
inline std::uint32_t draw_crossing(const LatticeFrame& frame, Workspace& work,
                                   const FrameSurface& surface, SampleGroup group,
                                   const SurfaceEnds& ends) {
  const BlockPlace& place = work.block.place;
  const auto& [s, column, row, crossing] = group;
  const V t = refine(frame, work, group, ends, hn::Set(d, surface.value));
  group.lanes &= kept_by_planes(frame, place, s, column, row, t);
  const V depth =
      hn::MulAdd(hn::Sub(t, hn::Set(d, 1.0F)), hn::Set(d, frame.camera.sampling_distance),
                 hn::Set(d, place.sheets[s].depth));
  group.lanes = within_spans(frame, place, group, depth, *work.tile);
  if (group.lanes == 0) return 0;
  Lighting light{hn::Set(d, 1.0F), hn::Zero(d)};
  if (frame.is_lit) {
    const WorldVector g = exact_gradient(frame, work, group, point_between(ends.from, ends.to, t));
    light = light_between(frame, place, group, t, g);
    work.stats.gradients += std::popcount(group.lanes);
  } else if (frame.light != nullptr) {
    light = light_between(frame, place, group, t, no_gradient());
  }
  work.stats.samples_shaded += std::popcount(group.lanes);
  const auto lit = [&](int c) { return lit_color(hn::Set(d, surface.color[c]), light); };
  return add_surface(frame, {lit(0), lit(1), lit(2)}, surface.opacity, mask_of(group.lanes), depth,
                     *work.tile, tile_index(place, column, row));
}

// Crossings between sheet s - 1 and sheet s of the block.
inline void surface_sheet(const LatticeFrame& frame, Workspace& work, int s) {
  const Block& block = work.block;
  const BlockPlace& place = block.place;
  TileState& tile = *work.tile;
  const Sheet& here = work.ring[place.number_of(s)];
  const Sheet& front = work.ring[place.number_of(s - 1)];
  for (int y = 0; y < place.rows; ++y) {
    RowWord& open = tile.open[tile_row(place, y)];
    const RowWord both = here.defined[y] & front.defined[y] & open >> place.x0;
    for_each_group(both, 0, place.columns, [&](int column, std::uint32_t lanes) {
      const int at = here.at(column, y);
      SurfaceEnds ends;
      ends.before = hn::LoadU(d, front.values + at);
      ends.after = hn::LoadU(d, here.values + at);
      bool has_places = false;
      std::uint32_t closed = 0;
      for_each_surface(
          frame, ends.before, ends.after, lanes,
          [&](const FrameSurface& surface, std::uint32_t crossing) {
            crossing &= ~closed;
            if (crossing == 0) return;
            if (!has_places) {
              ends.from = position_of(block.sheets[s - 1], column, y);
              ends.to = position_of(block.sheets[s], column, y);
              has_places = true;
            }
            closed |= draw_crossing(frame, work, surface, {s, column, y, crossing}, ends);
          });
      open &= ~(RowWord{closed} << tile_column(place, column));
    });
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
