// SPDX-License-Identifier: Apache-2.0
// Which part of a refined piece is drawn: what there is of one that lacks an end, and what planes
// and depth limits leave of it.
#if defined(OVOID_RENDER_CPU_PIECE_PARTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_PIECE_PARTS_INL_H_
#undef OVOID_RENDER_CPU_PIECE_PARTS_INL_H_
#else
#define OVOID_RENDER_CPU_PIECE_PARTS_INL_H_
#endif

#include "render/cpu/shade/path-inl.h"
#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// The part of a piece that is drawn, as shares of the way from the sheet before to its own.
struct PiecePart {
  V from, to;
};

// The lanes of a group for which an end of the piece is there.
struct PieceEnds {
  std::uint32_t front, back;
};

// From one depth to another, of a group's pixels, as shares of their pieces.
HWY_INLINE PiecePart part_between(const CpuFrame& frame, const BlockPlace& place,
                                  const SampleGroup& group, const float* from, const float* to) {
  const int pixel = tile_index(place, group.column, group.row);
  const V per_depth = hn::Set(d, 1 / frame.camera.sampling_distance);
  const V front = hn::Set(d, place.sheets[group.s].depth - frame.camera.sampling_distance);
  const auto share_at = [&](const float* depths) {
    return hn::Mul(hn::Sub(hn::LoadU(d, depths + pixel), front), per_depth);
  };
  return {share_at(from), share_at(to)};
}

// What no plane cuts away, the near plane included, within the span in hand of depth limits.
HWY_INLINE PiecePart cut_part(const CpuFrame& frame, const BlockPlace& place,
                              const SampleGroup& group, PiecePart part) {
  const view::FramePlan& plan = *frame.plan;
  const std::int64_t sheet = place.number_of(group.s);
  if (!frame.is_parallel) {
    const double nearest = 1.0 + (plan.lattice.near_depth() - plan.lattice.depth(sheet)) /
                                     plan.lattice.sampling_distance();
    part.from = hn::Max(part.from, hn::Set(d, static_cast<float>(nearest)));
  }
  const V x = pixel_x(place, group.column);
  const float y = pixel_y(place, group.row);
  for (const ClipPlane& plane : plan.clip_planes) {
    const V inside = evaluate2d(plan.clip_distance(plane, sheet), x, y);
    const V slope = hn::Mul(evaluate2d(plan.clip_slope(plane), x, y),
                            hn::Set(d, frame.camera.sampling_distance));
    const SlabCut cut = cut_of(inside, slope);
    const V one = hn::Set(d, 1.0F);
    part.from = hn::Max(part.from, hn::Add(cut.from, one));
    part.to = hn::Min(part.to, hn::Add(cut.to, one));
  }
  if (place.limits == nullptr) return part;
  const PiecePart span =
      part_between(frame, place, group, place.limits->enter, place.limits->leave);
  return {hn::Max(part.from, span.from), hn::Min(part.to, span.to)};
}

// A piece that has one end is half a piece.
struct HalfPieces {
  HWY_INLINE PiecePart operator()(const SampleGroup& /*group*/, const PieceEnds& ends) const {
    const V half = hn::Set(d, 0.5F);
    return {hn::IfThenElse(mask_of(ends.front), hn::Zero(d), half),
            hn::IfThenElse(mask_of(ends.back), hn::Set(d, 1.0F), half)};
  }
};

// The same of a kernel set, but that it reaches as far as a span of depth limits that begins or
// ends on the side where it has no end, unless at a seam.
struct KernelPieces {
  const CpuFrame& frame;
  const BlockPlace& place;

  HWY_INLINE PiecePart operator()(const SampleGroup& group, const PieceEnds& ends) const {
    PiecePart part = HalfPieces()(group, ends);
    if (place.limits == nullptr) return part;
    const PiecePart span =
        part_between(frame, place, group, place.limits->begins, place.limits->ends);
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0F);
    part.from = hn::IfThenElse(hn::Gt(span.from, zero), zero, part.from);
    part.to = hn::IfThenElse(hn::Lt(span.to, one), one, part.to);
    return part;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
