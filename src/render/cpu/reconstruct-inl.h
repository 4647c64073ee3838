// SPDX-License-Identifier: Apache-2.0
// Stage "reconstruct" by gathering: each sample of a sheet sums the kernels that reach it. The hot
// loop.
//
// In:  a block's region as floats, the positions of groups of samples.
// Out: field values (and, where asked, index-space gradients) of the groups, and which of them are
// defined.
//
// Two ways, same numbers:
//  - four taps: kernels of support 2 around every position (the default kernel) away from holes.
//  The normalized weights of
//    one axis are a softmax of (-1, 0, 1, 2) times f / sigma^2, f the position's fraction, so one
//    exponential serves four weights. Three passes over a batch of groups keep the processor from
//    waiting for any of them: weigh (SIMD over samples), sum y and z (SIMD along the taps: the
//    region is stored with z, z + 1 side by side, so one load of eight floats brings 4 x-taps of
//    two slices and feeds one multiply-add), reduce x (SIMD over samples).
//  - general: any support, holes, `sum`, widened kernels, slab means. One sample after the other,
//  SIMD along x.
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

// Normalized weights of the four taps around a position.
struct FourWeights {
  V w[4];
  V variance;  // of the tap's number under the endless lattice's weights, spacings squared
};

// The lattice's end along one axis, as the four taps see it: bounds of the indices that exist,
// relative to the block's origin.
struct AxisEnds {
  float first, last;
};

HWY_INLINE AxisEnds ends_of(const CpuFrame& frame, const Block& block, int axis) {
  const float first = static_cast<float>(-block.origin[axis]);
  return {first, first + static_cast<float>(frame.dims[axis] - 1)};
}

// `whole` and `fraction` are the position's. At a border, taps that do not exist get no weight, and
// `share` is multiplied by the part of the weights that is left.
template <bool kBorder, bool kWithVariance>
HWY_INLINE FourWeights four_weights_at(V whole, V fraction, const CpuFrame& frame, AxisEnds ends,
                                       V& share) {
  // g(f + 1) : g(f) : g(1 - f) : g(2 - f) = n : e : n e^2 : F e^3 with e = exp(f / sigma^2).
  constexpr float kLog2E = 1.44269504F;
  const V e = vector_exp2</*kCoarse=*/true>(
      d, hn::Mul(fraction, hn::Set(d, frame.inverse_variance * kLog2E)));
  const V n = hn::Set(d, frame.near_weight);
  const V ee = hn::Mul(e, e);
  FourWeights t{{n, e, hn::Mul(n, ee), hn::Mul(hn::Set(d, frame.far_weight), hn::Mul(ee, e))}, n};
  const auto sum = [&] { return hn::Add(hn::Add(t.w[0], t.w[1]), hn::Add(t.w[2], t.w[3])); };
  V total = sum();
  if constexpr (kWithVariance) {
    const V inverse = reciprocal_of(total);
    const V mean = hn::Mul(inverse, hn::Add(hn::Sub(t.w[2], t.w[0]), hn::Add(t.w[3], t.w[3])));
    const V square =
        hn::Mul(inverse, hn::MulAdd(hn::Set(d, 4.0F), t.w[3], hn::Add(t.w[0], t.w[2])));
    t.variance = hn::NegMulAdd(mean, mean, square);
  }
  if constexpr (kBorder) {
    for (int k = 0; k < 4; ++k) {
      const V index = hn::Add(whole, hn::Set(d, static_cast<float>(k - 1)));
      const M exists =
          hn::And(hn::Ge(index, hn::Set(d, ends.first)), hn::Le(index, hn::Set(d, ends.last)));
      t.w[k] = hn::IfThenElseZero(exists, t.w[k]);
    }
    const V existing = sum();
    share = hn::Mul(share, hn::Div(existing, total));
    total = hn::Max(existing, hn::Set(d, 1e-30F));
  }
  const V r = reciprocal_of(total);
  for (V& w : t.w) w = hn::Mul(w, r);
  return t;
}

// d w_k / d f = w_k (k - mean of k) / sigma^2, k = -1, 0, 1, 2, whichever of them exist.
HWY_INLINE FourWeights derivative_of(const FourWeights& w, const CpuFrame& frame) {
  const V mean = hn::Add(hn::Sub(w.w[2], w.w[0]), hn::Add(w.w[3], w.w[3]));
  const V scale = hn::Set(d, frame.inverse_variance);
  FourWeights out;
  for (int k = 0; k < 4; ++k) {
    out.w[k] =
        hn::Mul(hn::Mul(w.w[k], scale), hn::Sub(hn::Set(d, static_cast<float>(k - 1)), mean));
  }
  return out;
}

// What makes the gradient of a ramp constant: the weights' derivative answers to slope 1 with
// variance / sigma^2.
HWY_INLINE V correction_for(V variance, const CpuFrame& frame) {
  if (!frame.corrects_gradient) return hn::Set(d, 1.0F);
  const V answer = hn::Mul(variance, hn::Set(d, frame.inverse_variance));
  return hn::IfThenElse(hn::Gt(variance, hn::Set(d, kLeastVariance)),
                        hn::Div(hn::Set(d, 1.0F), answer), hn::Set(d, 1.0F));
}

// Eight floats: four x-taps, each of slice z and slice z + 1. One register where vectors are wide
// enough.
#if HWY_TARGET == HWY_SCALAR
struct Octet {
  float v[8];
};
HWY_INLINE Octet load_octet(const float* p) {
  Octet o;
  std::memcpy(o.v, p, sizeof o.v);
  return o;
}
HWY_INLINE Octet set_octet(float a) { return {{a, a, a, a, a, a, a, a}}; }
HWY_INLINE Octet set_pairs(const float* p) {
  return {{p[0], p[1], p[0], p[1], p[0], p[1], p[0], p[1]}};
}
HWY_INLINE Octet mul(Octet a, Octet b) {
  for (int k = 0; k < 8; ++k) a.v[k] *= b.v[k];
  return a;
}
HWY_INLINE Octet mul_add(Octet a, Octet b, Octet c) {
  for (int k = 0; k < 8; ++k) c.v[k] += a.v[k] * b.v[k];
  return c;
}
HWY_INLINE void store_folded(Octet o, float* to) {
  for (int k = 0; k < 4; ++k) to[k] = o.v[2 * k] + o.v[2 * k + 1];
}
#elif HWY_MAX_BYTES >= 32
using D4 = hn::FixedTag<float, 4>;
using D8 = hn::FixedTag<float, 8>;
inline constexpr D4 d4;
inline constexpr D8 d8;
struct Octet {
  hn::Vec<D8> v;
};
HWY_INLINE Octet load_octet(const float* p) { return {hn::LoadU(d8, p)}; }
HWY_INLINE Octet set_octet(float a) { return {hn::Set(d8, a)}; }
HWY_INLINE Octet set_pairs(const float* p) {
  std::uint64_t both;
  std::memcpy(&both, p, sizeof both);
  return {hn::BitCast(d8, hn::Set(hn::FixedTag<std::uint64_t, 4>(), both))};
}
HWY_INLINE Octet mul(Octet a, Octet b) { return {hn::Mul(a.v, b.v)}; }
HWY_INLINE Octet mul_add(Octet a, Octet b, Octet c) { return {hn::MulAdd(a.v, b.v, c.v)}; }
// Adds each tap's two slices: [4].
HWY_INLINE void store_folded(Octet o, float* to) {
  const auto lo = hn::LowerHalf(d4, o.v);
  const auto hi = hn::UpperHalf(d4, o.v);
  hn::Store(hn::Add(hn::ConcatEven(d4, hi, lo), hn::ConcatOdd(d4, hi, lo)), d4, to);
}
#else
using D4 = hn::FixedTag<float, 4>;
inline constexpr D4 d4;
struct Octet {
  hn::Vec<D4> lo, hi;
};
HWY_INLINE Octet load_octet(const float* p) { return {hn::LoadU(d4, p), hn::LoadU(d4, p + 4)}; }
HWY_INLINE Octet set_octet(float a) { return {hn::Set(d4, a), hn::Set(d4, a)}; }
HWY_INLINE Octet set_pairs(const float* p) {
  std::uint64_t both;
  std::memcpy(&both, p, sizeof both);
  const auto v = hn::BitCast(d4, hn::Set(hn::FixedTag<std::uint64_t, 2>(), both));
  return {v, v};
}
HWY_INLINE Octet mul(Octet a, Octet b) { return {hn::Mul(a.lo, b.lo), hn::Mul(a.hi, b.hi)}; }
HWY_INLINE Octet mul_add(Octet a, Octet b, Octet c) {
  return {hn::MulAdd(a.lo, b.lo, c.lo), hn::MulAdd(a.hi, b.hi, c.hi)};
}
HWY_INLINE void store_folded(Octet o, float* to) {
  hn::Store(hn::Add(hn::ConcatEven(d4, o.hi, o.lo), hn::ConcatOdd(d4, o.hi, o.lo)), d4, to);
}
#endif

inline constexpr int kMaxLanes = 16;
inline constexpr int kBatchSamples = 64;  // their weights take 5 KiB and stay in the L1 cache

struct GroupValues {
  V value;
  std::uint32_t defined;  // bits, a subset of the lanes asked for
};

struct ValueAndGradient {
  V value, x, y, z;  // gradient in index space
};

// Samples of a sheet on their way through the passes, wherever they lie: groups are full even where
// few samples are active. `x`, `y`, `dx`, `dy` by tap and sample; `z`, `dz` and `partial` by sample
// and tap.
struct FourTapBatch {
  int count = 0;                            // samples; padded to whole groups by repeating the last
  alignas(64) float column[kBatchSamples];  // of the plane
  alignas(64) float row[kBatchSamples];
  alignas(64) std::int32_t at[kBatchSamples];  // row * kPlaneStride + column
  alignas(64) float x[4][kBatchSamples];
  alignas(64) float y[4][kBatchSamples];
  alignas(64) float z[4 * kBatchSamples];
  alignas(64) std::int32_t offset[kBatchSamples];
  alignas(64) float partial[4 * kBatchSamples];
  alignas(64) float share[kBatchSamples];  // of the weights that exist; only at borders

  int padded_count() const { return (count + group_size() - 1) / group_size() * group_size(); }
};

struct FourTapGradientBatch : FourTapBatch {
  alignas(64) float dx[4][kBatchSamples];
  alignas(64) float dy[4][kBatchSamples];
  alignas(64) float dz[4 * kBatchSamples];
  alignas(64) float correction[3][kBatchSamples];  // factors on the gradient's components
  alignas(64) float partial_y[4 * kBatchSamples];
  alignas(64) float partial_z[4 * kBatchSamples];
};

HWY_INLINE void store_by_tap(const FourWeights& w, float (*to)[kBatchSamples], int i) {
  for (int k = 0; k < 4; ++k) hn::Store(w.w[k], d, to[k] + i);
}

HWY_INLINE void store_by_lane(const FourWeights& w, float* to) {
#if HWY_TARGET == HWY_SCALAR
  for (int k = 0; k < 4; ++k) hn::Store(w.w[k], d, to + k);
#else
  hn::StoreInterleaved4(w.w[0], w.w[1], w.w[2], w.w[3], d, to);
#endif
}

// Pass 1: weights of a group's taps, samples i and following, and where each one's first tap lies
// in the region (in floats).
template <bool kBorder, class Batch>
HWY_INLINE void weigh_taps(const CpuFrame& frame, const Block& block, const Position& u, int i,
                           Batch& batch) {
  const V x = hn::Floor(u.x);
  const V y = hn::Floor(u.y);
  const V z = hn::Floor(u.z);
  const auto index = [&](V p, int a) {
    return hn::Sub(nearest_integer(p), hn::Set(di, block.region_lo[a] + 1));
  };
  const VI rows = hn::Add(hn::Mul(index(z, 2), hn::Set(di, block.region_size[1])), index(y, 1));
  const VI samples = hn::Add(hn::Mul(rows, hn::Set(di, block.row_stride)), index(x, 0));
  hn::Store(hn::ShiftLeft<1>(samples), di, batch.offset + i);
  constexpr bool kGradient = std::is_same_v<Batch, FourTapGradientBatch>;
  V share = hn::Set(d, 1.0F);
  const FourWeights wx = four_weights_at<kBorder, kGradient>(x, hn::Sub(u.x, x), frame,
                                                             ends_of(frame, block, 0), share);
  const FourWeights wy = four_weights_at<kBorder, kGradient>(y, hn::Sub(u.y, y), frame,
                                                             ends_of(frame, block, 1), share);
  const FourWeights wz = four_weights_at<kBorder, kGradient>(z, hn::Sub(u.z, z), frame,
                                                             ends_of(frame, block, 2), share);
  store_by_tap(wx, batch.x, i);
  store_by_tap(wy, batch.y, i);
  store_by_lane(wz, batch.z + 4 * i);
  if constexpr (kGradient) {
    store_by_tap(derivative_of(wx, frame), batch.dx, i);
    store_by_tap(derivative_of(wy, frame), batch.dy, i);
    store_by_lane(derivative_of(wz, frame), batch.dz + 4 * i);
    hn::Store(correction_for(wx.variance, frame), d, batch.correction[0] + i);
    hn::Store(correction_for(wy.variance, frame), d, batch.correction[1] + i);
    hn::Store(correction_for(wz.variance, frame), d, batch.correction[2] + i);
  }
  if constexpr (kBorder) hn::Store(share, d, batch.share + i);
}

template <class Batch>
HWY_INLINE void weigh_at(const CpuFrame& frame, const Block& block, const Position& u, int i,
                         Batch& batch) {
  if (block.is_interior) {
    weigh_taps<false>(frame, block, u, i, batch);
  } else {
    weigh_taps<true>(frame, block, u, i, batch);
  }
}

// Pass 1 for all samples of a batch on one sheet.
template <class Batch>
HWY_INLINE void weigh_sheet(const CpuFrame& frame, const Block& block, int s, Batch& batch) {
  const SheetSetup& sheet = block.sheets[s];
  for (int i = 0; i < batch.padded_count(); i += group_size()) {
    const V column = hn::Load(d, batch.column + i);
    const V row = hn::Load(d, batch.row + i);
    const auto along = [&](int a) {
      const V start = hn::MulAdd(row, hn::Set(d, sheet.per_y[a]), hn::Set(d, sheet.base[a]));
      return hn::MulAdd(column, hn::Set(d, sheet.per_x[a]), start);
    };
    weigh_at(frame, block, {along(0), along(1), along(2)}, i, batch);
  }
}

// Pass 2: sums over y and z, four x-taps kept apart.
HWY_INLINE void sum_yz(const Block& block, const float* HWY_RESTRICT samples, FourTapBatch& batch) {
  const std::ptrdiff_t row = 2 * static_cast<std::ptrdiff_t>(block.row_stride);
  const std::ptrdiff_t three_rows = 3 * row;
  const std::ptrdiff_t two_slices = 4 * static_cast<std::ptrdiff_t>(block.slice_stride);
  for (int i = 0, end = batch.padded_count(); i < end; ++i) {
    const float* HWY_RESTRICT p = samples + batch.offset[i];
    const float* HWY_RESTRICT q = p + two_slices;
    const Octet y0 = set_octet(batch.y[0][i]);
    const Octet y1 = set_octet(batch.y[1][i]);
    const Octet y2 = set_octet(batch.y[2][i]);
    const Octet y3 = set_octet(batch.y[3][i]);
    const auto rows = [&](const float* HWY_RESTRICT r) {
      Octet t = mul(load_octet(r), y0);
      t = mul_add(load_octet(r + row), y1, t);
      t = mul_add(load_octet(r + 2 * row), y2, t);
      return mul_add(load_octet(r + three_rows), y3, t);
    };
    const float* z = batch.z + 4 * i;
    store_folded(mul_add(rows(q), set_pairs(z + 2), mul(rows(p), set_pairs(z))),
                 batch.partial + 4 * i);
  }
}

HWY_INLINE void sum_yz_gradient(const Block& block, const float* HWY_RESTRICT samples,
                                FourTapGradientBatch& batch) {
  const std::ptrdiff_t row = 2 * static_cast<std::ptrdiff_t>(block.row_stride);
  const std::ptrdiff_t two_slices = 4 * static_cast<std::ptrdiff_t>(block.slice_stride);
  for (int i = 0, end = batch.padded_count(); i < end; ++i) {
    const float* HWY_RESTRICT p = samples + batch.offset[i];
    const float* HWY_RESTRICT q = p + two_slices;
    const Octet p0 = load_octet(p);
    const Octet q0 = load_octet(q);
    const Octet y0 = set_octet(batch.y[0][i]);
    const Octet dy0 = set_octet(batch.dy[0][i]);
    Octet tp = mul(p0, y0), tq = mul(q0, y0);
    Octet sp = mul(p0, dy0), sq = mul(q0, dy0);
    for (int j = 1; j < 4; ++j) {
      const Octet pj = load_octet(p + j * row);
      const Octet qj = load_octet(q + j * row);
      const Octet y = set_octet(batch.y[j][i]);
      const Octet dy = set_octet(batch.dy[j][i]);
      tp = mul_add(pj, y, tp);
      tq = mul_add(qj, y, tq);
      sp = mul_add(pj, dy, sp);
      sq = mul_add(qj, dy, sq);
    }
    const float* z = batch.z + 4 * i;
    const float* dz = batch.dz + 4 * i;
    const Octet zp = set_pairs(z), zq = set_pairs(z + 2);
    store_folded(mul_add(tq, zq, mul(tp, zp)), batch.partial + 4 * i);
    store_folded(mul_add(sq, zq, mul(sp, zp)), batch.partial_y + 4 * i);
    store_folded(mul_add(tq, set_pairs(dz + 2), mul(tp, set_pairs(dz))), batch.partial_z + 4 * i);
  }
}

// Pass 3: the sum over the four x-taps of a group, samples i and following; partial[sample][4]
// times weights[4][sample].
HWY_INLINE V reduce_x(const float* partial, const float (*weights)[kBatchSamples], int i) {
  partial += 4 * i;
#if HWY_TARGET == HWY_SCALAR
  const V p0 = hn::Load(d, partial), p1 = hn::Load(d, partial + 1), p2 = hn::Load(d, partial + 2),
          p3 = hn::Load(d, partial + 3);
#else
  V p0, p1, p2, p3;
  hn::LoadInterleaved4(d, partial, p0, p1, p2, p3);
#endif
  const auto w = [&](int k) { return hn::Load(d, weights[k] + i); };
  return hn::MulAdd(p0, w(0), hn::MulAdd(p1, w(1), hn::MulAdd(p2, w(2), hn::Mul(p3, w(3)))));
}

HWY_INLINE V reduce_value(const FourTapBatch& batch, int i) {
  return reduce_x(batch.partial, batch.x, i);
}

HWY_INLINE ValueAndGradient reduce_gradient(const FourTapGradientBatch& batch, int i) {
  const auto correction = [&](int a) { return hn::Load(d, batch.correction[a] + i); };
  return {reduce_x(batch.partial, batch.x, i),
          hn::Mul(reduce_x(batch.partial, batch.dx, i), correction(0)),
          hn::Mul(reduce_x(batch.partial_y, batch.x, i), correction(1)),
          hn::Mul(reduce_x(batch.partial_z, batch.x, i), correction(2))};
}

// Lanes that nobody asked for take the position of one that somebody did: their taps must lie in
// the region, too.
HWY_INLINE Position fill_lanes(const Position& u, std::uint32_t lanes) {
  const M mask = mask_of(lanes);
  const int first = std::countr_zero(lanes);
  alignas(64) float p[3][kMaxLanes];
  hn::Store(u.x, d, p[0]);
  hn::Store(u.y, d, p[1]);
  hn::Store(u.z, d, p[2]);
  return {hn::IfThenElse(mask, u.x, hn::Set(d, p[0][first])),
          hn::IfThenElse(mask, u.y, hn::Set(d, p[1][first])),
          hn::IfThenElse(mask, u.z, hn::Set(d, p[2][first]))};
}

// Values of one group at any positions near sheet s. `lanes` must be active samples.
HWY_INLINE GroupValues gather_group(const CpuFrame& frame, Workspace& work, int s, int column,
                                    int row, const Position& u, std::uint32_t lanes) {
  if (work.block.uses_four_taps) {
    FourTapBatch batch;
    batch.count = group_size();
    weigh_at(frame, work.block, fill_lanes(u, lanes), 0, batch);
    sum_yz(work.block, work.samples, batch);
    const std::uint32_t whole =
        work.block.is_interior
            ? group_bits()
            : bits_of(hn::Ge(hn::Load(d, batch.share), hn::Set(d, kLeastWeight)));
    return {reduce_value(batch, 0), lanes & whole};
  }
  alignas(64) float value[kMaxLanes] = {};
  const std::uint32_t defined = gather_general<false>(frame, work, s, column, row, u, lanes,
                                                      GeneralOut{value, nullptr, nullptr, nullptr});
  return {hn::Load(d, value), defined};
}

HWY_INLINE ValueAndGradient gather_gradient(const CpuFrame& frame, Workspace& work, int s,
                                            int column, int row, const Position& u,
                                            std::uint32_t lanes) {
  if (work.block.uses_four_taps) {
    FourTapGradientBatch batch;
    batch.count = group_size();
    weigh_at(frame, work.block, fill_lanes(u, lanes), 0, batch);
    sum_yz_gradient(work.block, work.samples, batch);
    return reduce_gradient(batch, 0);
  }
  alignas(64) float out[4][kMaxLanes] = {};
  gather_general<true>(frame, work, s, column, row, u, lanes,
                       GeneralOut{out[0], out[1], out[2], out[3]});
  return {hn::Load(d, out[0]), hn::Load(d, out[1]), hn::Load(d, out[2]), hn::Load(d, out[3])};
}

// Hands the samples named by `bits` to `run` in batches, packed. (Packing by vector compression is
// slower: its overlapping stores must drain before the next pass may read.)
template <class Batch, class Run>
HWY_INLINE void for_each_batch(const Block& block, const RowBits& bits, Batch& batch,
                               const Run& run) {
  int count = 0;  // not in `batch`: the loop would wait for its own stores
  const auto finish = [&] {
    batch.count = count;
    for (int i = count; i < batch.padded_count(); ++i) {
      batch.column[i] = batch.column[count - 1];
      batch.row[i] = batch.row[count - 1];
    }
    run();
    count = 0;
  };
  for (int y = 0; y < block.rows; ++y) {
    const auto row = static_cast<float>(y);
    for (RowWord left = bits[y]; left != 0; left &= left - 1) {
      const int x = std::countr_zero(left);
      batch.column[count] = static_cast<float>(x);
      batch.row[count] = row;
      batch.at[count] = y * kPlaneStride + x;
      if (++count == kBatchSamples) finish();
    }
  }
  if (count > 0) finish();
}

// At a border: takes back the samples of a batch where too few kernels exist.
HWY_INLINE void drop_undefined(const FourTapBatch& batch, RowBits& defined) {
  for (int i = 0; i < batch.count; ++i) {
    if (batch.share[i] >= kLeastWeight) continue;
    defined[batch.at[i] / kPlaneStride] &= ~(RowWord{1} << batch.at[i] % kPlaneStride);
  }
}

inline void reconstruct_four_taps(const CpuFrame& frame, Workspace& work, int s,
                                  const RowBits& wanted) {
  Block& block = work.block;
  float* values = block.values[s & (kRingSheets - 1)];
  RowBits& defined = block.defined[s & (kRingSheets - 1)];
  for (int y = 0; y < block.rows; ++y) defined[y] |= wanted[y];
  FourTapBatch batch;
  for_each_batch(block, wanted, batch, [&] {
    weigh_sheet(frame, block, s, batch);
    sum_yz(block, work.samples, batch);
    alignas(64) float value[kBatchSamples];
    for (int i = 0; i < batch.count; i += group_size())
      hn::Store(reduce_value(batch, i), d, value + i);
    for (int i = 0; i < batch.count; ++i) values[batch.at[i]] = value[i];
    if (!block.is_interior) drop_undefined(batch, defined);
  });
}

inline void reconstruct_general(const CpuFrame& frame, Workspace& work, int s,
                                const RowBits& wanted) {
  Block& block = work.block;
  float* values = block.values[s & (kRingSheets - 1)];
  RowBits& defined = block.defined[s & (kRingSheets - 1)];
  for (int y = 0; y < block.rows; ++y) {
    for_each_group(wanted[y], 0, block.columns, [&](int column, std::uint32_t lanes) {
      const Position u = position_of(block.sheets[s], column, y);
      const GroupValues group = gather_group(frame, work, s, column, y, u, lanes);
      // Neighbours may have their values already.
      hn::BlendedStore(group.value, mask_of(lanes), d, values + y * kPlaneStride + column);
      defined[y] |= RowWord{group.defined} << column;
    });
  }
}

// Adds the samples named by `wanted` to sheet s of the block.
inline void reconstruct_sheet(const CpuFrame& frame, Workspace& work, int s,
                              const RowBits& wanted) {
  if (work.block.uses_four_taps) {
    reconstruct_four_taps(frame, work, s, wanted);
  } else {
    reconstruct_general(frame, work, s, wanted);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
