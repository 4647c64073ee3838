// SPDX-License-Identifier: Apache-2.0
// Stage "gradient", by central differences over the samples of the view lattice: the way of kernel
// sets, and of lattices on request. Knows nothing of kernels.
//
// In:  the planes of a sheet and its two neighbours, with a margin of one sample.
// Out: the gradient of a group of samples along the world's axes, in FramePlan::gradient_unit.
#if defined(OVOID_RENDER_CPU_DIFFERENCES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_DIFFERENCES_INL_H_
#undef OVOID_RENDER_CPU_DIFFERENCES_INL_H_
#else
#define OVOID_RENDER_CPU_DIFFERENCES_INL_H_
#endif

#include "render/cpu/shade/path-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

struct WorldVector {
  V x, y, z;
};

// Of the samples of the group alone: their neighbours may have theirs already.
HWY_INLINE void store_gradient(Sheet& sheet, const SampleGroup& group, const WorldVector& g) {
  const int at = sheet.at(group.column, group.row);
  const M mask = mask_of(group.lanes);
  hn::BlendedStore(g.x, mask, d, sheet.gradient[0] + at);
  hn::BlendedStore(g.y, mask, d, sheet.gradient[1] + at);
  hn::BlendedStore(g.z, mask, d, sheet.gradient[2] + at);
  sheet.has_gradient[group.row] |= RowWord{group.lanes} << group.column;
}

// Difference of the samples on both sides of the middle one; one-sided, or zero, where they are
// undefined.
HWY_INLINE V difference(V before, V middle, V after, M has_before, M has_after) {
  const V forward = hn::Sub(after, middle);
  const V backward = hn::Sub(middle, before);
  const V both = hn::Mul(hn::Set(d, 0.5F), hn::Add(forward, backward));
  return hn::IfThenElse(
      hn::And(has_before, has_after), both,
      hn::IfThenElse(has_after, forward, hn::IfThenElseZero(has_before, backward)));
}

// Where a group's samples lie in the picture.
struct PicturePlace {
  V x;
  float y;
};

HWY_INLINE WorldVector central_difference_at(const CpuFrame& frame, const BlockPlace& place,
                                             const SheetRing& ring, const SampleGroup& group,
                                             const PicturePlace& at) {
  const Sheet& before = ring[place.number_of(group.s - 1)];
  const Sheet& here = ring[place.number_of(group.s)];
  const Sheet& after = ring[place.number_of(group.s + 1)];
  const auto value = [&](const Sheet& sheet, int column, int row) {
    return hn::LoadU(d, sheet.values + sheet.at(group.column + column, group.row + row));
  };
  const auto is_defined = [&](const Sheet& sheet, int column, int row) {
    const RowWord bits = sheet.defined[group.row + row];
    const int from = group.column + column;
    return mask_of(from < 0 ? lanes_at(bits << 1, 0) : lanes_at(bits, from));
  };
  const V middle = value(here, 0, 0);
  const V dx = difference(value(here, -1, 0), middle, value(here, 1, 0), is_defined(here, -1, 0),
                          is_defined(here, 1, 0));
  const V dy = difference(value(here, 0, -1), middle, value(here, 0, 1), is_defined(here, 0, -1),
                          is_defined(here, 0, 1));
  const V ds = difference(value(before, 0, 0), middle, value(after, 0, 0), is_defined(before, 0, 0),
                          is_defined(after, 0, 0));
  // The reciprocal basis of (pixel right, pixel down, next sheet): pixels are square and orthogonal
  // to the view axis, the step to the next sheet leans by the ray's slopes.
  const V inverse_pitch = hn::Set(d, place.sheets[group.s].inverse_pitch);
  const V along_right = hn::Mul(dx, inverse_pitch);
  const V along_up = hn::Neg(hn::Mul(dy, inverse_pitch));
  V along_axis = hn::Mul(ds, hn::Set(d, frame.camera.inverse_step));
  if (!frame.is_parallel) {
    along_axis =
        hn::NegMulAdd(evaluate2d(frame.camera.slope_right, at.x, at.y), along_right, along_axis);
    along_axis = hn::NegMulAdd(evaluate2d(frame.camera.slope_up, at.x, at.y), along_up, along_axis);
  }
  const auto component = [&](int a) {
    return hn::MulAdd(along_right, hn::Set(d, frame.camera.right[a]),
                      hn::MulAdd(along_up, hn::Set(d, frame.camera.up[a]),
                                 hn::Mul(along_axis, hn::Set(d, frame.camera.axis[a]))));
  };
  return {component(0), component(1), component(2)};
}

HWY_INLINE WorldVector central_difference_gradient(const CpuFrame& frame, const BlockPlace& place,
                                                   const SheetRing& ring,
                                                   const SampleGroup& group) {
  return central_difference_at(frame, place, ring, group,
                               {pixel_x(place, group.column), pixel_y(place, group.row)});
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
