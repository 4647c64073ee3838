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
#include "render/cpu/shade-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Where between two samples (0 to 1) the field takes the isovalue; `before` and `after` lie on
// different sides.
HWY_INLINE V refine(const LatticeFrame& frame, Workspace& work, int s, int column, int row,
                    const Position& from, const Position& to, V before, V after,
                    std::uint32_t lanes) {
  const V iso = hn::Set(d, frame.look.constants.isovalue);
  const M rises = hn::Lt(before, iso);
  V near = hn::Zero(d);
  V far = hn::Set(d, 1.0F);
  M far_is_defined = mask_of(lanes);
  for (int i = 0; i < device::kSurfaceSteps; ++i) {
    const V middle = hn::Mul(hn::Set(d, 0.5F), hn::Add(near, far));
    const GroupValues f =
        gather_group(frame, work, s, column, row, point_between(from, to, middle), lanes);
    const M is_low = hn::Lt(f.value, iso);
    // Same side as the near end: the crossing is behind the middle. Where the field is undefined,
    // stay in front of it.
    const M same =
        hn::And(mask_of(f.defined), hn::Or(hn::And(is_low, rises), hn::Not(hn::Or(is_low, rises))));
    near = hn::IfThenElse(same, middle, near);
    before = hn::IfThenElse(same, f.value, before);
    const M other = hn::And(hn::Not(same), mask_of(lanes));
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
  Block& block = work.block;
  TileState& tile = *work.tile;
  const int here = s & (kRingSheets - 1);
  const int front = (s - 1) & (kRingSheets - 1);
  const V iso = hn::Set(d, frame.look.constants.isovalue);
  for (int y = 0; y < block.rows; ++y) {
    std::uint32_t& open = tile.open[tile_row(block, y)];
    const RowWord both = block.defined[here][y] & block.defined[front][y] & open >> block.x0;
    for_each_group(both, 0, block.columns, [&](int column, std::uint32_t lanes) {
      const int at = y * kPlaneStride + column;
      const V before = hn::LoadU(d, block.values[front] + at);
      const V after = hn::LoadU(d, block.values[here] + at);
      std::uint32_t crossing = bits_of(hn::Xor(hn::Lt(before, iso), hn::Lt(after, iso))) & lanes;
      if (crossing == 0) return;
      const Position from = position_of(block.sheets[s - 1], column, y);
      const Position to = position_of(block.sheets[s], column, y);
      const V t = refine(frame, work, s, column, y, from, to, before, after, crossing);
      crossing &= kept_by_planes(frame, block, s, column, y, t);
      if (crossing == 0) return;
      const V color[3] = {hn::Set(d, frame.look.constants.isosurface_color.x),
                          hn::Set(d, frame.look.constants.isosurface_color.y),
                          hn::Set(d, frame.look.constants.isosurface_color.z)};
      Lighting light{hn::Set(d, 1.0F), hn::Zero(d)};
      if (frame.is_lit) {
        const WorldVector g =
            exact_gradient(frame, work, s, column, y, point_between(from, to, t), crossing);
        light = light_sample(frame.look.constants, g, direction_to_eye(frame, block, column, y));
        work.stats.gradients += std::popcount(crossing);
      }
      const int pixel = tile_index(block, column, y);
      const M mask = mask_of(crossing);
      // What is in front is not all that shows.
      const V in_front = hn::LoadU(d, tile.alpha + pixel);
      const V share = hn::Sub(hn::Set(d, 1.0F), in_front);
      const auto add = [&](float* sum, V lit) {
        store_masked(mask, hn::MulAdd(share, lit, hn::LoadU(d, sum + pixel)), sum + pixel);
      };
      add(tile.red, lit_color(color[0], light));
      add(tile.green, lit_color(color[1], light));
      add(tile.blue, lit_color(color[2], light));
      store_masked(mask, hn::Set(d, 1.0F), tile.alpha + pixel);
      const V depth =
          hn::MulAdd(hn::Sub(t, hn::Set(d, 1.0F)), hn::Set(d, frame.camera.sampling_distance),
                     hn::Set(d, block.sheets[s].depth));
      store_masked(hn::And(mask, hn::Lt(in_front, hn::Set(d, 0.5F))), depth, tile.depth + pixel);
      open &= ~(crossing << tile_column(block, column));
      work.stats.samples_shaded += std::popcount(crossing);
    });
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
