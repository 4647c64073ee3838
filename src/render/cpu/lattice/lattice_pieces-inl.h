// SPDX-License-Identifier: Apache-2.0
// What refined pieces of a lattice field have of their own: where they end, and their gradients.
#if defined(OVOID_RENDER_CPU_LATTICE_PIECES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_LATTICE_PIECES_INL_H_
#undef OVOID_RENDER_CPU_LATTICE_PIECES_INL_H_
#else
#define OVOID_RENDER_CPU_LATTICE_PIECES_INL_H_
#endif

#include "render/cpu/lattice/block-inl.h"
#include "render/cpu/lattice/gradient-inl.h"
#include "render/cpu/shade/pieces-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// What there is of a piece that has one end: in a normalized lattice it reaches to the face that
// the other end lies beyond.
struct LatticePieces {
  const LatticeFrame& frame;
  const Block& block;

  HWY_INLINE PiecePart operator()(const SampleGroup& group, const PieceEnds& ends) const {
    const PiecePart half = HalfPieces()(group, ends);
    if (frame.is_sum) return half;
    const Position from = position_of(block.sheets[group.s - 1], group.column, group.row);
    const Position to = position_of(block.sheets[group.s], group.column, group.row);
    PiecePart inside{hn::Zero(d), hn::Set(d, 1.0F)};
    M is_beyond = hn::Lt(inside.to, inside.from);
    const Bounds3& faces = frame.lattice_plan->faces;
    const auto cut = [&](V a, V b, int axis) {
      const auto origin = static_cast<double>(block.region.origin[axis]);
      const V lo = hn::Set(d, static_cast<float>(faces.min()[axis] - origin));
      const V hi = hn::Set(d, static_cast<float>(faces.max()[axis] - origin));
      const V end = hn::IfThenElse(mask_of(ends.front), b, a);  // the one that is not there
      is_beyond = hn::Or(is_beyond, hn::Or(hn::Lt(end, lo), hn::Gt(end, hi)));
      const V slope = hn::Sub(b, a);
      const SlabCut above = cut_of(hn::Sub(a, lo), slope);
      const SlabCut below = cut_of(hn::Sub(hi, a), hn::Neg(slope));
      inside.from = hn::Max(inside.from, hn::Max(above.from, below.from));
      inside.to = hn::Min(inside.to, hn::Min(above.to, below.to));
    };
    cut(from.x, to.x, 0);
    cut(from.y, to.y, 1);
    cut(from.z, to.z, 2);
    // Fields may be defined a little beyond the faces.
    const M has_one_end = hn::Not(hn::And(mask_of(ends.front), mask_of(ends.back)));
    const M ends_at_face = hn::And(is_beyond, has_one_end);
    return {hn::IfThenElse(ends_at_face, inside.from, half.from),
            hn::IfThenElse(ends_at_face, inside.to, half.to)};
  }
};

// Gradients of the ends of the visible pieces that end on sheet s.
inline void gradients_of_ends(const LatticeFrame& frame, Workspace& work, int s) {
  const BlockPlace& place = work.block.place;
  for (const int end : {s - 1, s}) {
    const Sheet& sheet = work.ring[place.number_of(end)];
    RowBits missing;
    for (int y = 0; y < place.rows; ++y)
      missing[y] = work.shaded.visible[y] & sheet.defined[y] & ~sheet.has_gradient[y];
    gradients_of(frame, work, end, missing);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
