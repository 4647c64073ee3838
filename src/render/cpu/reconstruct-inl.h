// SPDX-License-Identifier: Apache-2.0
// Stage "reconstruct" by gathering: each sample of a sheet sums the kernels that reach it. The hot
// loop.
//
// In:  a block's region as floats, the positions of a group of samples.
// Out: field values (and, where asked, index-space gradients) of the group, and which of them are
// defined.
//
// Two ways, same numbers:
//  - four taps: kernels of support 2 around every position, all of them present (the default
//  kernel, away from borders and
//    holes). The normalized weights of one axis are a softmax of (-1, 0, 1, 2) times f / sigma^2, f
//    the position's fraction, so one exponential serves four weights; they are computed for a group
//    at once. The 4 x 4 x 4 taps of a sample are summed with SIMD along the taps: two rows of four
//    fill a vector of eight, and x is reduced for the group together.
//  - general: any support, borders, holes, `sum`, widened kernels, slab means. One sample after the
//  other, SIMD along x.
#if defined(OVOID_RENDER_CPU_RECONSTRUCT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_RECONSTRUCT_INL_H_
#undef OVOID_RENDER_CPU_RECONSTRUCT_INL_H_
#else
#define OVOID_RENDER_CPU_RECONSTRUCT_INL_H_
#endif

#include "render/cpu/general-inl.h"
#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Normalized weights of the four taps around a position, and their derivatives.
struct FourWeights {
  V w[4];
};

HWY_INLINE FourWeights FourWeightsAt(V fraction, const CpuFrame& frame) {
  // g(f + 1) : g(f) : g(1 - f) : g(2 - f) = n : e : n e^2 : F e^3 with e = exp(f / sigma^2).
  constexpr float kLog2E = 1.44269504F;
  const V e =
      Exp2</*kCoarse=*/true>(d, hn::Mul(fraction, hn::Set(d, frame.inverse_variance * kLog2E)));
  const V n = hn::Set(d, frame.near_weight);
  const V ee = hn::Mul(e, e);
  const V t0 = n;
  const V t2 = hn::Mul(n, ee);
  const V t3 = hn::Mul(hn::Set(d, frame.far_weight), hn::Mul(ee, e));
  const V r = Reciprocal(hn::Add(hn::Add(t0, e), hn::Add(t2, t3)));
  return {{hn::Mul(t0, r), hn::Mul(e, r), hn::Mul(t2, r), hn::Mul(t3, r)}};
}

// d w_k / d f = w_k (k - mean of k) / sigma^2, k = -1, 0, 1, 2.
HWY_INLINE FourWeights DerivativeOf(const FourWeights& w, const CpuFrame& frame) {
  const V mean = hn::Add(hn::Sub(w.w[2], w.w[0]), hn::Add(w.w[3], w.w[3]));
  const V scale = hn::Set(d, frame.inverse_variance);
  FourWeights out;
  for (int k = 0; k < 4; ++k) {
    out.w[k] =
        hn::Mul(hn::Mul(w.w[k], scale), hn::Sub(hn::Set(d, static_cast<float>(k - 1)), mean));
  }
  return out;
}

// Two rows of four taps: side by side where vectors are wide enough, else one after the other. The
// same sums either way.
#if HWY_TARGET == HWY_SCALAR
struct RowPair {
  float a[4], b[4];
};
HWY_INLINE RowPair LoadPair(const float* a, const float* b) {
  return {{a[0], a[1], a[2], a[3]}, {b[0], b[1], b[2], b[3]}};
}
HWY_INLINE RowPair SetPair(float a, float b) { return {{a, a, a, a}, {b, b, b, b}}; }
HWY_INLINE RowPair SetBoth(float a) { return SetPair(a, a); }
HWY_INLINE RowPair Mul(RowPair p, RowPair q) {
  RowPair r;
  for (int k = 0; k < 4; ++k) {
    r.a[k] = p.a[k] * q.a[k];
    r.b[k] = p.b[k] * q.b[k];
  }
  return r;
}
HWY_INLINE RowPair MulAdd(RowPair p, RowPair q, RowPair r) {
  for (int k = 0; k < 4; ++k) {
    r.a[k] += p.a[k] * q.a[k];
    r.b[k] += p.b[k] * q.b[k];
  }
  return r;
}
HWY_INLINE void StoreFolded(RowPair p, float* to) {
  for (int k = 0; k < 4; ++k) to[k] = p.a[k] + p.b[k];
}
#elif HWY_MAX_BYTES >= 32
using D4 = hn::FixedTag<float, 4>;
using D8 = hn::FixedTag<float, 8>;
inline constexpr D4 d4;
inline constexpr D8 d8;
struct RowPair {
  hn::Vec<D8> v;
};
HWY_INLINE RowPair LoadPair(const float* a, const float* b) {
  return {hn::Combine(d8, hn::LoadU(d4, b), hn::LoadU(d4, a))};
}
HWY_INLINE RowPair SetPair(float a, float b) {
  return {hn::Combine(d8, hn::Set(d4, b), hn::Set(d4, a))};
}
HWY_INLINE RowPair SetBoth(float a) { return {hn::Set(d8, a)}; }
HWY_INLINE RowPair Mul(RowPair p, RowPair q) { return {hn::Mul(p.v, q.v)}; }
HWY_INLINE RowPair MulAdd(RowPair p, RowPair q, RowPair r) { return {hn::MulAdd(p.v, q.v, r.v)}; }
HWY_INLINE void StoreFolded(RowPair p, float* to) {
  hn::Store(hn::Add(hn::LowerHalf(d4, p.v), hn::UpperHalf(d4, p.v)), d4, to);
}
#else
using D4 = hn::FixedTag<float, 4>;
inline constexpr D4 d4;
struct RowPair {
  hn::Vec<D4> a, b;
};
HWY_INLINE RowPair LoadPair(const float* a, const float* b) {
  return {hn::LoadU(d4, a), hn::LoadU(d4, b)};
}
HWY_INLINE RowPair SetPair(float a, float b) { return {hn::Set(d4, a), hn::Set(d4, b)}; }
HWY_INLINE RowPair SetBoth(float a) { return SetPair(a, a); }
HWY_INLINE RowPair Mul(RowPair p, RowPair q) { return {hn::Mul(p.a, q.a), hn::Mul(p.b, q.b)}; }
HWY_INLINE RowPair MulAdd(RowPair p, RowPair q, RowPair r) {
  return {hn::MulAdd(p.a, q.a, r.a), hn::MulAdd(p.b, q.b, r.b)};
}
HWY_INLINE void StoreFolded(RowPair p, float* to) { hn::Store(hn::Add(p.a, p.b), d4, to); }
#endif
inline constexpr int kMaxLanes = 16;

// Weights of a group along y and z, by tap and lane, and where each lane's first tap lies in the
// region.
struct FourTaps {
  alignas(64) float y[4][kMaxLanes];
  alignas(64) float z[4][kMaxLanes];
  alignas(64) std::int32_t offset[kMaxLanes];
};

struct FourTapsWithDerivatives : FourTaps {
  alignas(64) float dy[4][kMaxLanes];
  alignas(64) float dz[4][kMaxLanes];
};

struct SplitPosition {
  V fx, fy, fz;  // fractions in [0, 1)
};

HWY_INLINE SplitPosition SplitForFourTaps(const Block& block, const Position& u,
                                          std::int32_t* offset) {
  const V x = hn::Floor(u.x);
  const V y = hn::Floor(u.y);
  const V z = hn::Floor(u.z);
  const auto index = [&](V p, int a) {
    return hn::Sub(hn::ConvertTo(di, p), hn::Set(di, block.region_lo[a] + 1));
  };
  const VI in_slice = hn::Add(hn::Mul(index(y, 1), hn::Set(di, block.row_stride)), index(x, 0));
  hn::Store(hn::Add(hn::Mul(index(z, 2), hn::Set(di, block.slice_stride)), in_slice), di, offset);
  return {hn::Sub(u.x, x), hn::Sub(u.y, y), hn::Sub(u.z, z)};
}

HWY_INLINE void StoreTaps(const FourWeights& w, float (*to)[kMaxLanes]) {
  for (int k = 0; k < 4; ++k) hn::Store(w.w[k], d, to[k]);
}

// sum over the four x-taps, for all lanes: partial[lane][4] times weights.
HWY_INLINE V ReduceX(const float* partial, const FourWeights& w) {
#if HWY_TARGET == HWY_SCALAR
  const V p0 = hn::Load(d, partial), p1 = hn::Load(d, partial + 1), p2 = hn::Load(d, partial + 2),
          p3 = hn::Load(d, partial + 3);
#else
  V p0, p1, p2, p3;
  hn::LoadInterleaved4(d, partial, p0, p1, p2, p3);
#endif
  return hn::MulAdd(p0, w.w[0],
                    hn::MulAdd(p1, w.w[1], hn::MulAdd(p2, w.w[2], hn::Mul(p3, w.w[3]))));
}

HWY_INLINE V GatherFour(const CpuFrame& frame, const Block& block,
                        const float* HWY_RESTRICT samples, const Position& u, std::uint32_t lanes) {
  FourTaps taps;
  alignas(64) float partial[4 * kMaxLanes] = {};
  const SplitPosition split = SplitForFourTaps(block, u, taps.offset);
  StoreTaps(FourWeightsAt(split.fy, frame), taps.y);
  StoreTaps(FourWeightsAt(split.fz, frame), taps.z);
  const FourWeights x = FourWeightsAt(split.fx, frame);
  const std::ptrdiff_t row = block.row_stride;
  const std::ptrdiff_t slice = block.slice_stride;
  for (; lanes != 0; lanes &= lanes - 1) {
    const int l = std::countr_zero(lanes);
    const float* HWY_RESTRICT p = samples + taps.offset[l];
    const float* HWY_RESTRICT q = p + 2 * slice;
    const RowPair y0 = SetBoth(taps.y[0][l]);
    const RowPair y1 = SetBoth(taps.y[1][l]);
    const RowPair y2 = SetBoth(taps.y[2][l]);
    const RowPair y3 = SetBoth(taps.y[3][l]);
    const auto slices = [&](std::ptrdiff_t at) {
      RowPair t = Mul(LoadPair(p + at, q + at), y0);
      t = MulAdd(LoadPair(p + at + row, q + at + row), y1, t);
      t = MulAdd(LoadPair(p + at + 2 * row, q + at + 2 * row), y2, t);
      return MulAdd(LoadPair(p + at + 3 * row, q + at + 3 * row), y3, t);
    };
    RowPair sum = Mul(slices(0), SetPair(taps.z[0][l], taps.z[2][l]));
    sum = MulAdd(slices(slice), SetPair(taps.z[1][l], taps.z[3][l]), sum);
    StoreFolded(sum, partial + 4 * l);
  }
  return ReduceX(partial, x);
}

struct ValueAndGradient {
  V value, x, y, z;  // gradient in index space
};

HWY_INLINE ValueAndGradient GatherFourGradient(const CpuFrame& frame, const Block& block,
                                               const float* HWY_RESTRICT samples, const Position& u,
                                               std::uint32_t lanes) {
  FourTapsWithDerivatives taps;
  alignas(64) float partial[3][4 * kMaxLanes] = {};
  const SplitPosition split = SplitForFourTaps(block, u, taps.offset);
  const FourWeights y = FourWeightsAt(split.fy, frame);
  const FourWeights z = FourWeightsAt(split.fz, frame);
  StoreTaps(y, taps.y);
  StoreTaps(z, taps.z);
  StoreTaps(DerivativeOf(y, frame), taps.dy);
  StoreTaps(DerivativeOf(z, frame), taps.dz);
  const FourWeights x = FourWeightsAt(split.fx, frame);
  const FourWeights dx = DerivativeOf(x, frame);
  const std::ptrdiff_t row = block.row_stride;
  const std::ptrdiff_t slice = block.slice_stride;
  for (; lanes != 0; lanes &= lanes - 1) {
    const int l = std::countr_zero(lanes);
    const float* HWY_RESTRICT p = samples + taps.offset[l];
    const float* HWY_RESTRICT q = p + 2 * slice;
    RowPair sum, sum_y, sum_z;
    for (int k = 0; k < 2; ++k) {
      const std::ptrdiff_t at = k * slice;
      const RowPair r0 = LoadPair(p + at, q + at);
      RowPair t = Mul(r0, SetBoth(taps.y[0][l]));
      RowPair ty = Mul(r0, SetBoth(taps.dy[0][l]));
      for (int j = 1; j < 4; ++j) {
        const RowPair r = LoadPair(p + at + j * row, q + at + j * row);
        t = MulAdd(r, SetBoth(taps.y[j][l]), t);
        ty = MulAdd(r, SetBoth(taps.dy[j][l]), ty);
      }
      const RowPair wz = SetPair(taps.z[k][l], taps.z[k + 2][l]);
      const RowPair dz = SetPair(taps.dz[k][l], taps.dz[k + 2][l]);
      sum = k == 0 ? Mul(t, wz) : MulAdd(t, wz, sum);
      sum_y = k == 0 ? Mul(ty, wz) : MulAdd(ty, wz, sum_y);
      sum_z = k == 0 ? Mul(t, dz) : MulAdd(t, dz, sum_z);
    }
    StoreFolded(sum, partial[0] + 4 * l);
    StoreFolded(sum_y, partial[1] + 4 * l);
    StoreFolded(sum_z, partial[2] + 4 * l);
  }
  return {ReduceX(partial[0], x), ReduceX(partial[0], dx), ReduceX(partial[1], x),
          ReduceX(partial[2], x)};
}

struct GroupValues {
  V value;
  std::uint32_t defined;  // bits, a subset of the lanes asked for
};

// Values of a group at positions of sheet s (or between sheets: then the caller passes them).
// `lanes` must be active samples.
HWY_INLINE GroupValues Gather(const CpuFrame& frame, Workspace& work, int s, int column, int row,
                              const Position& u, std::uint32_t lanes) {
  if (work.block.uses_four_taps[s]) {
    return {GatherFour(frame, work.block, work.samples.data.get(), u, lanes), lanes};
  }
  alignas(64) float value[kMaxLanes] = {};
  const std::uint32_t defined = GatherGeneral<false>(frame, work, s, column, row, u, lanes,
                                                     GeneralOut{value, nullptr, nullptr, nullptr});
  return {hn::Load(d, value), defined};
}

HWY_INLINE ValueAndGradient GatherGradient(const CpuFrame& frame, Workspace& work, int s,
                                           int column, int row, const Position& u,
                                           std::uint32_t lanes) {
  if (work.block.uses_four_taps[s]) {
    return GatherFourGradient(frame, work.block, work.samples.data.get(), u, lanes);
  }
  alignas(64) float out[4][kMaxLanes] = {};
  GatherGeneral<true>(frame, work, s, column, row, u, lanes,
                      GeneralOut{out[0], out[1], out[2], out[3]});
  return {hn::Load(d, out[0]), hn::Load(d, out[1]), hn::Load(d, out[2]), hn::Load(d, out[3])};
}

// May this sheet of the block take the four-tap way?
inline bool UsesFourTaps(const CpuFrame& frame, const Block& block, int s) {
  const float* m = block.sheets[s].widening;
  return frame.has_four_taps && block.is_interior && !block.has_missing && m[0] == 1.0F &&
         m[1] == 1.0F && m[2] == 1.0F;
}

// One sheet of the block: the samples named by `wanted`.
inline void ReconstructSheet(const CpuFrame& frame, Workspace& work, int s, const RowBits& wanted) {
  Block& block = work.block;
  float* values = block.values[s & (kRingSheets - 1)];
  RowBits& defined = block.defined[s & (kRingSheets - 1)];
  for (int y = 0; y < block.rows; ++y) {
    defined[y] = 0;
    ForEachGroup(wanted[y], 0, block.columns, [&](int column, std::uint32_t lanes) {
      const Position u = PositionOf(block.sheets[s], column, y);
      const GroupValues group = Gather(frame, work, s, column, y, u, lanes);
      hn::StoreU(group.value, d, values + y * kPlaneStride + column);
      defined[y] |= group.defined << column;
    });
    work.stats.samples_reconstructed += std::popcount(wanted[y]);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
