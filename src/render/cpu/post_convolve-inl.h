// SPDX-License-Identifier: Apache-2.0
// Stage "post-convolve": brings the coarse levels of a block to the finer ones, coarsest first.
//
// In:  the levels' planes. Out: level 0 has everything.
// Separable, six taps an axis (render/shared/sections.h): down the columns first, so that whole
// rows are read and written, then along the rows, where the even and the odd samples of the finer
// level are a vector each. About 18 multiply-adds per sample of the finer level and channel,
// whatever was summed on the coarser one.
#if defined(OVOID_RENDER_CPU_POST_CONVOLVE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_POST_CONVOLVE_INL_H_
#undef OVOID_RENDER_CPU_POST_CONVOLVE_INL_H_
#else
#define OVOID_RENDER_CPU_POST_CONVOLVE_INL_H_
#endif

#include "render/cpu/kernel_block.h"
#include "render/cpu/simd-inl.h"
#include "render/shared/sections.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Row `fine_row` of the finer level with the columns of the coarser one.
HWY_INLINE void blend_rows(const float* coarse, const LevelExtent& from, int fine_row, float* out) {
  const bool is_behind = fine_row % 2 != 0;  // a quarter behind its coarse sample
  const int first = half_of(fine_row) - (is_behind ? 2 : 3) - from.lo;
  V weight[6];
  for (int k = 0; k < 6; ++k) weight[k] = hn::Set(d, kQuarterWeights[is_behind ? k : 5 - k]);
  const float* row = coarse + static_cast<std::size_t>(first) * from.stride;
  for (int x = 0; x < from.size; x += group_size()) {
    V sum = hn::Mul(weight[0], hn::LoadU(d, row + x));
    for (int k = 1; k < 6; ++k)
      sum = hn::MulAdd(weight[k], hn::LoadU(d, row + k * from.stride + x), sum);
    hn::StoreU(sum, d, out + x);
  }
}

// Adds one plane of level `level` to the plane of the next finer level.
inline void post_convolve_plane(const float* coarse, int level, float* fine, float* blended) {
  const LevelExtent& from = kLevelExtents[static_cast<std::size_t>(level)];
  const LevelExtent& to = kLevelExtents[static_cast<std::size_t>(level) - 1];
  V weight[6];
  for (int k = 0; k < 6; ++k) weight[k] = hn::Set(d, kQuarterWeights[k]);
  // Coarse column j gives the fine columns 2 j and 2 j + 1; the first pair may begin before the
  // plane.
  const int j_first = half_of(to.lo);
  const int j_last = half_of(to.lo + to.size - 1);
  alignas(64) float pairs[2 * (kValueStride + kPlanePadding)];
  for (int row = 0; row < to.size; ++row) {
    blend_rows(coarse, from, to.lo + row, blended);
    for (int j = j_first; j <= j_last; j += group_size()) {
      const float* at = blended + (j - 3 - from.lo);
      V taps[7];
      for (int k = 0; k < 7; ++k) taps[k] = hn::LoadU(d, at + k);
      V before = hn::Mul(weight[5], taps[0]);
      V behind = hn::Mul(weight[0], taps[1]);
      for (int k = 1; k < 6; ++k) {
        before = hn::MulAdd(weight[5 - k], taps[k], before);
        behind = hn::MulAdd(weight[k], taps[k + 1], behind);
      }
      hn::StoreInterleaved2(before, behind, d, pairs + 2 * (j - j_first));
    }
    const float* from_pair = pairs + (to.lo - 2 * j_first);
    float* out = fine + static_cast<std::size_t>(row) * to.stride;
    // What lies behind the row's end belongs to nobody, or to the next row, which is yet to be
    // added to: it must not be touched.
    int x = 0;
    for (; x + group_size() <= to.size; x += group_size())
      hn::StoreU(hn::Add(hn::LoadU(d, out + x), hn::LoadU(d, from_pair + x)), d, out + x);
    for (; x < to.size; ++x) out[x] += from_pair[x];
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
