// SPDX-License-Identifier: Apache-2.0
// Stage "gradient", by central differences over the samples of the view lattice: the way of kernel
// sets, and of lattices on request. Knows nothing of kernels.
//
// In:  the planes of a sheet and its two neighbours, with a margin of one sample.
// Out: the world gradient of a group of samples.
#if defined(OVOID_RENDER_CPU_DIFFERENCES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_DIFFERENCES_INL_H_
#undef OVOID_RENDER_CPU_DIFFERENCES_INL_H_
#else
#define OVOID_RENDER_CPU_DIFFERENCES_INL_H_
#endif

#include "render/cpu/path-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

struct WorldVector {
  V x, y, z;
};

// Of the samples named by `lanes` alone: their neighbours may have theirs already.
HWY_INLINE void store_gradient(Block& block, int column, int row, std::uint32_t lanes,
                               const WorldVector& g) {
  const int at = row * kPlaneStride + column;
  const M mask = mask_of(lanes);
  hn::BlendedStore(g.x, mask, d, block.gradient[0] + at);
  hn::BlendedStore(g.y, mask, d, block.gradient[1] + at);
  hn::BlendedStore(g.z, mask, d, block.gradient[2] + at);
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

// `x`, `y`: where the samples lie in the picture.
HWY_INLINE WorldVector central_difference_at(const CpuFrame& frame, const Block& block, int s,
                                             int column, int row, V x, float y) {
  const auto plane = [&](int sheet) {
    return block.values[sheet & (kRingSheets - 1)] + row * kPlaneStride + column;
  };
  const auto defined = [&](int sheet, int of_row, int shift) {
    const RowWord bits = block.defined[sheet & (kRingSheets - 1)][of_row];
    const int from = column + shift;
    return mask_of(from < 0 ? lanes_at(bits << 1, 0) : lanes_at(bits, from));
  };
  const float* here = plane(s);
  const V middle = hn::LoadU(d, here);
  const V dx = difference(hn::LoadU(d, here - 1), middle, hn::LoadU(d, here + 1),
                          defined(s, row, -1), defined(s, row, 1));
  const V dy =
      difference(hn::LoadU(d, here - kPlaneStride), middle, hn::LoadU(d, here + kPlaneStride),
                 defined(s, row - 1, 0), defined(s, row + 1, 0));
  const V ds = difference(hn::LoadU(d, plane(s - 1)), middle, hn::LoadU(d, plane(s + 1)),
                          defined(s - 1, row, 0), defined(s + 1, row, 0));
  // The reciprocal basis of (pixel right, pixel down, next sheet): pixels are square and orthogonal
  // to the view axis, the step to the next sheet leans by the ray's slopes.
  const V inverse_pitch = hn::Set(d, block.sheets[s].inverse_pitch);
  const V along_right = hn::Mul(dx, inverse_pitch);
  const V along_up = hn::Neg(hn::Mul(dy, inverse_pitch));
  V along_axis = hn::Mul(ds, hn::Set(d, 1.0F / frame.camera.sampling_distance));
  if (!frame.is_parallel) {
    along_axis = hn::NegMulAdd(evaluate2d(frame.camera.slope_right, x, y), along_right, along_axis);
    along_axis = hn::NegMulAdd(evaluate2d(frame.camera.slope_up, x, y), along_up, along_axis);
  }
  const auto component = [&](int a) {
    return hn::MulAdd(along_right, hn::Set(d, frame.camera.right[a]),
                      hn::MulAdd(along_up, hn::Set(d, frame.camera.up[a]),
                                 hn::Mul(along_axis, hn::Set(d, frame.camera.axis[a]))));
  };
  return {component(0), component(1), component(2)};
}

HWY_INLINE WorldVector central_difference_gradient(const CpuFrame& frame, const Block& block, int s,
                                                   int column, int row) {
  return central_difference_at(frame, block, s, column, row, pixel_x(block, column),
                               pixel_y(block, row));
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
