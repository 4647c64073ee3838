// SPDX-License-Identifier: Apache-2.0
// Gathering by four taps along each axis: the sums of one sublattice's kernels around a batch of
// samples, for kernels that reach no farther, away from holes.
//
// In:  positions; the region as pairs of slices (load-inl.h).
// Out: the kernels' weighted mean, and where asked its derivatives in index space.
//
// The normalized weights of a Gaussian along one axis are a softmax of (-1, 0, 1, 2) times f /
// sigma^2, f the position's fraction, so one exponential serves four weights; those of piecewise
// kernels are four polynomials, which add up to 1. Three passes over a batch of groups
// keep the processor from waiting for any of them: weigh (SIMD over samples), sum y and z (SIMD
// along the taps: the region is stored with z, z + 1 side by side, so one load of eight floats
// brings 4 x-taps of two slices and feeds one multiply-add), reduce x (SIMD over samples).
//
// Kernels narrower than two index units reach three of the four (kNarrow): the others' weights are
// zero, and along y only three rows are read.
#if defined(OVOID_RENDER_CPU_FOUR_TAPS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_FOUR_TAPS_INL_H_
#undef OVOID_RENDER_CPU_FOUR_TAPS_INL_H_
#else
#define OVOID_RENDER_CPU_FOUR_TAPS_INL_H_
#endif

#include "render/cpu/lattice/block-inl.h"
#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Normalized weights of the four taps around a position.
struct FourWeights {
  V w[4];
  V slope[4];  // their derivatives; where asked for
  // Of the tap's number under the endless lattice's weights, index units (squared); of Gaussians.
  V mean;
  V variance;
  V total;      // of the endless lattice's weights; of Gaussians over that of tap 0 times exp(f /
                // sigma^2)
  V log_slope;  // of piecewise kernels: the derivative of the logarithm of what exists
};

// The lattice's end along one axis, as the four taps see it: bounds of the indices that exist,
// relative to the region's origin.
struct AxisEnds {
  float first, last;
};

HWY_INLINE AxisEnds ends_of(const device::Sublattice& sublattice, const Region& region, int axis) {
  const float first = static_cast<float>(-region.origin[axis]);
  return {first, first + static_cast<float>(sublattice.dims[axis] - 1)};
}

// The tap's number under weights that sum to 1, whichever of them exist.
HWY_INLINE V mean_tap(const FourWeights& w) {
  return hn::Add(hn::Sub(w.w[2], w.w[0]), hn::Add(w.w[3], w.w[3]));
}

// d w_k / d f = w_k (k - mean of k) / sigma^2, k = -1, 0, 1, 2, whichever of them exist.
HWY_INLINE void set_gaussian_slopes(const device::LatticeConstants& lattice, FourWeights& w) {
  const V mean = mean_tap(w);
  const V scale = hn::Set(d, lattice.inverse_variance);
  for (int k = 0; k < 4; ++k) {
    w.slope[k] =
        hn::Mul(hn::Mul(w.w[k], scale), hn::Sub(hn::Set(d, static_cast<float>(k - 1)), mean));
  }
}

HWY_INLINE V sum_of(const V (&v)[4]) { return hn::Add(hn::Add(v[0], v[1]), hn::Add(v[2], v[3])); }

HWY_INLINE M all_exist(V whole, AxisEnds ends) {
  return hn::And(hn::Ge(whole, hn::Set(d, ends.first + 1)),
                 hn::Le(whole, hn::Set(d, ends.last - 2)));
}

// Weights of the taps that do not exist become 0.
HWY_INLINE void keep_existing(V whole, AxisEnds ends, V (&weights)[4]) {
  for (int k = 0; k < 4; ++k) {
    const V index = hn::Add(whole, hn::Set(d, static_cast<float>(k - 1)));
    const M exists =
        hn::And(hn::Ge(index, hn::Set(d, ends.first)), hn::Le(index, hn::Set(d, ends.last)));
    weights[k] = hn::IfThenElseZero(exists, weights[k]);
  }
}

// `whole` and `fraction` are the position's. At a border, taps that do not exist get no weight, and
// `share` is multiplied by the part of the weights that is left.
template <bool kNarrow, bool kBorder, bool kGradient>
HWY_INLINE FourWeights gaussian_weights_at(V whole, V fraction,
                                           const device::LatticeConstants& lattice, AxisEnds ends,
                                           V& share) {
  // g(f + 1) : g(f) : g(1 - f) : g(2 - f) = n : e : n e^2 : F e^3 with e = exp(f / sigma^2).
  constexpr float kLog2E = 1.44269504F;
  const V e = vector_exp2</*kCoarse=*/true>(
      d, hn::Mul(fraction, hn::Set(d, lattice.inverse_variance * kLog2E)));
  const V n = hn::Set(d, lattice.near_weight);
  const V ee = hn::Mul(e, e);
  FourWeights t{};
  t.w[0] = n;
  t.w[1] = e;
  t.w[2] = hn::Mul(n, ee);
  t.w[3] = hn::Mul(hn::Set(d, lattice.far_weight), hn::Mul(ee, e));
  if constexpr (kNarrow) {
    for (int k = 0; k < 4; ++k) {
      const V distance = hn::Sub(hn::Set(d, static_cast<float>(k - 1)), fraction);
      const M is_reached = hn::Le(hn::Abs(distance), hn::Set(d, lattice.support));
      t.w[k] = hn::IfThenElseZero(is_reached, t.w[k]);
    }
  }
  V total = sum_of(t.w);
  t.total = total;
  if constexpr (kGradient) {
    const V inverse = reciprocal_of(total);
    t.mean = hn::Mul(inverse, mean_tap(t));
    const V square =
        hn::Mul(inverse, hn::MulAdd(hn::Set(d, 4.0F), t.w[3], hn::Add(t.w[0], t.w[2])));
    t.variance = hn::NegMulAdd(t.mean, t.mean, square);
  }
  if constexpr (kBorder) {
    keep_existing(whole, ends, t.w);
    const V existing = sum_of(t.w);
    share = hn::Mul(share, hn::Div(existing, total));
    total = hn::Max(existing, hn::Set(d, 1e-30F));
  }
  const V r = reciprocal_of(total);
  for (V& w : t.w) w = hn::Mul(w, r);
  if constexpr (kGradient) set_gaussian_slopes(lattice, t);
  return t;
}

HWY_INLINE V polynomial(const device::vec4& c, V t) {
  return hn::MulAdd(hn::MulAdd(hn::MulAdd(hn::Set(d, c.w), t, hn::Set(d, c.z)), t, hn::Set(d, c.y)),
                    t, hn::Set(d, c.x));
}
HWY_INLINE V slope_of_polynomial(const device::vec4& c, V t) {
  return hn::MulAdd(hn::MulAdd(hn::Set(d, 3 * c.w), t, hn::Set(d, 2 * c.z)), t, hn::Set(d, c.y));
}

// The weight, or its derivative, at the distance t >= 0 of the kernel's units.
template <bool kSlope>
HWY_INLINE V piece_at(const device::LatticeConstants& lattice, V t) {
  const auto of = [&](const device::vec4& c) {
    return kSlope ? slope_of_polynomial(c, t) : polynomial(c, t);
  };
  const V piece =
      hn::IfThenElse(hn::Lt(t, hn::Set(d, 1.0F)), of(lattice.inner_piece), of(lattice.outer_piece));
  return hn::IfThenElseZero(hn::Lt(t, hn::Set(d, 2.0F)), piece);
}

// Weights of the four taps, which add up to 1 where the kernel's unit is that of the lattice, and
// their derivatives.
template <bool kNarrow, bool kGradient>
HWY_INLINE void set_pieces(V fraction, const device::LatticeConstants& lattice, FourWeights& t) {
  const V unit = hn::Set(d, kNarrow ? lattice.inverse_unit : 1.0F);
  for (int k = 0; k < 4; ++k) {
    const bool is_behind = k <= 1;  // the tap, of the position: the derivative is that of t
    const V number = hn::Set(d, static_cast<float>(k - 1));
    const V distance = is_behind ? hn::Sub(fraction, number) : hn::Sub(number, fraction);
    const V sign = hn::Set(d, is_behind ? 1.0F : -1.0F);
    if constexpr (kNarrow) {
      const V of_unit = hn::Mul(distance, unit);
      t.w[k] = piece_at<false>(lattice, of_unit);
      if constexpr (kGradient)
        t.slope[k] = hn::Mul(hn::Mul(unit, sign), piece_at<true>(lattice, of_unit));
    } else {
      const bool is_inner = k == 1 || k == 2;
      const device::vec4& piece = is_inner ? lattice.inner_piece : lattice.outer_piece;
      t.w[k] = polynomial(piece, distance);
      if constexpr (kGradient) t.slope[k] = hn::Mul(sign, slope_of_polynomial(piece, distance));
    }
  }
}

// As gaussian_weights_at().
template <bool kNarrow, bool kBorder, bool kGradient>
HWY_INLINE FourWeights piecewise_weights_at(V whole, V fraction,
                                            const device::LatticeConstants& lattice, AxisEnds ends,
                                            V& share) {
  FourWeights t{};
  t.mean = t.variance = t.log_slope = hn::Zero(d);
  t.total = hn::Set(d, 1.0F);
  set_pieces<kNarrow, kGradient>(fraction, lattice, t);
  if constexpr (!kNarrow && !kBorder) return t;
  t.total = sum_of(t.w);
  if constexpr (kBorder) {
    keep_existing(whole, ends, t.w);
    if constexpr (kGradient) keep_existing(whole, ends, t.slope);
  }
  const V existing = kBorder ? sum_of(t.w) : t.total;
  if constexpr (kBorder) share = hn::Mul(share, hn::Div(existing, t.total));
  // Where next to nothing exists the sample is not defined, but has to be a number. Of one of two
  // sublattices it may be less than nothing where kernels are negative in places.
  const V magnitude = hn::Max(hn::Abs(existing), hn::Set(d, 1e-6F));
  const V inverse = hn::Div(hn::Set(d, 1.0F), hn::CopySign(magnitude, existing));
  // Where all exist that add up to 1 they are what they are in the lattice's interior, to the bit.
  const M are_whole = kNarrow ? hn::Ne(whole, whole) : all_exist(whole, ends);
  for (V& w : t.w) w = hn::IfThenElse(are_whole, w, hn::Mul(w, inverse));
  if constexpr (kGradient) {
    t.log_slope = hn::Mul(sum_of(t.slope), inverse);
    for (int k = 0; k < 4; ++k) {
      const V slope = hn::NegMulAdd(t.w[k], t.log_slope, hn::Mul(t.slope[k], inverse));
      t.slope[k] = hn::IfThenElse(are_whole, t.slope[k], slope);
    }
  }
  return t;
}

template <bool kNarrow, bool kBorder, bool kGradient>
HWY_INLINE FourWeights four_weights_at(V whole, V fraction, const device::LatticeConstants& lattice,
                                       AxisEnds ends, V& share) {
  return lattice.is_piecewise != 0 ? piecewise_weights_at<kNarrow, kBorder, kGradient>(
                                         whole, fraction, lattice, ends, share)
                                   : gaussian_weights_at<kNarrow, kBorder, kGradient>(
                                         whole, fraction, lattice, ends, share);
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
inline constexpr std::int64_t kGatheredTaps =
    64;  // multiply-adds of a value; a gradient has three more of each
inline constexpr int kBatchSamples = 64;  // their weights take 5 KiB and stay in the L1 cache

struct ValueAndGradient {
  V value, x, y, z;  // gradient in index space
};

// Taps of some samples on their way through the passes. `x`, `y`, `dx`, `dy` by tap and sample;
// `z`, `dz` and `partial` by sample and tap.
struct FourTapBatch {
  alignas(64) float x[4][kBatchSamples];
  alignas(64) float y[4][kBatchSamples];
  alignas(64) float z[4 * kBatchSamples];
  alignas(64) std::int32_t offset[kBatchSamples];
  alignas(64) float partial[4 * kBatchSamples];
};

struct FourTapGradientBatch : FourTapBatch {
  alignas(64) float dx[4][kBatchSamples];
  alignas(64) float dy[4][kBatchSamples];
  alignas(64) float dz[4 * kBatchSamples];
  alignas(64) float partial_y[4 * kBatchSamples];
  alignas(64) float partial_z[4 * kBatchSamples];
};

HWY_INLINE void store_by_tap(const V (&w)[4], float (*to)[kBatchSamples], int i) {
  for (int k = 0; k < 4; ++k) hn::Store(w[k], d, to[k] + i);
}

HWY_INLINE void store_by_lane(const V (&w)[4], float* to) {
#if HWY_TARGET == HWY_SCALAR
  for (int k = 0; k < 4; ++k) hn::Store(w[k], d, to + k);
#else
  hn::StoreInterleaved4(w[0], w[1], w[2], w[3], d, to);
#endif
}

// The weights of a group's taps along the three axes.
struct GroupWeights {
  FourWeights axis[3];
  V fraction[3];
  V share;  // of the endless lattice's weights, what exists
};

// Which rows of the four a narrow kernel reaches: those from tap 0 on where `fraction` is over 1/2.
HWY_INLINE void store_three_rows(const V (&w)[4], M from_second, float (*to)[kBatchSamples],
                                 int i) {
  for (int k = 0; k < 3; ++k) hn::Store(hn::IfThenElse(from_second, w[k + 1], w[k]), d, to[k] + i);
}

// Pass 1: weights of a group's taps, samples i and following, and where each one's first tap lies
// in the region (in floats). `u`: of the sublattice, its offset taken off.
template <bool kNarrow, bool kBorder, class Batch>
HWY_INLINE GroupWeights weigh_taps(const device::LatticeConstants& lattice, const Region& region,
                                   int sublattice, const Position& u, int i, Batch& batch) {
  constexpr bool kGradient = std::is_same_v<Batch, FourTapGradientBatch>;
  const V position[3] = {u.x, u.y, u.z};
  GroupWeights group;
  group.share = hn::Set(d, 1.0F);
  VI index[3];
  for (int a = 0; a < 3; ++a) {
    const V whole = hn::Floor(position[a]);
    group.fraction[a] = hn::Sub(position[a], whole);
    index[a] = hn::Sub(nearest_integer(whole), hn::Set(di, region.lo[a] + 1));
    group.axis[a] = four_weights_at<kNarrow, kBorder, kGradient>(
        whole, group.fraction[a], lattice, ends_of(lattice.sublattices[sublattice], region, a),
        group.share);
  }
  const FourWeights& y = group.axis[1];
  store_by_tap(group.axis[0].w, batch.x, i);
  store_by_lane(group.axis[2].w, batch.z + 4 * i);
  if constexpr (kGradient) {
    store_by_tap(group.axis[0].slope, batch.dx, i);
    store_by_lane(group.axis[2].slope, batch.dz + 4 * i);
  }
  if constexpr (kNarrow) {
    const M from_second = hn::Gt(group.fraction[1], hn::Set(d, 0.5F));
    index[1] =
        hn::Add(index[1], hn::IfThenElseZero(hn::RebindMask(di, from_second), hn::Set(di, 1)));
    store_three_rows(y.w, from_second, batch.y, i);
    if constexpr (kGradient) store_three_rows(y.slope, from_second, batch.dy, i);
  } else {
    store_by_tap(y.w, batch.y, i);
    if constexpr (kGradient) store_by_tap(y.slope, batch.dy, i);
  }
  const VI rows = hn::Add(hn::Mul(index[2], hn::Set(di, region.size[1])), index[1]);
  const VI samples = hn::Add(hn::Mul(rows, hn::Set(di, region.row_stride)), index[0]);
  hn::Store(hn::ShiftLeft<1>(samples), di, batch.offset + i);
  return group;
}

// Pass 2: sums over y and z, four x-taps kept apart; `samples`: of the sublattice.
template <int kRows>
HWY_INLINE void sum_yz(const Region& region, const float* HWY_RESTRICT samples, int count,
                       FourTapBatch& batch) {
  const std::ptrdiff_t row = 2 * static_cast<std::ptrdiff_t>(region.row_stride);
  const std::ptrdiff_t three_rows = 3 * row;
  const std::ptrdiff_t two_slices = 4 * static_cast<std::ptrdiff_t>(region.slice_stride);
  for (int i = 0; i < count; ++i) {
    const float* HWY_RESTRICT p = samples + batch.offset[i];
    const float* HWY_RESTRICT q = p + two_slices;
    const Octet y0 = set_octet(batch.y[0][i]);
    const Octet y1 = set_octet(batch.y[1][i]);
    const Octet y2 = set_octet(batch.y[2][i]);
    const Octet y3 = set_octet(batch.y[kRows - 1][i]);
    const auto rows = [&](const float* HWY_RESTRICT r) {
      Octet t = mul(load_octet(r), y0);
      t = mul_add(load_octet(r + row), y1, t);
      t = mul_add(load_octet(r + 2 * row), y2, t);
      return kRows == 3 ? t : mul_add(load_octet(r + three_rows), y3, t);
    };
    const float* z = batch.z + 4 * i;
    store_folded(mul_add(rows(q), set_pairs(z + 2), mul(rows(p), set_pairs(z))),
                 batch.partial + 4 * i);
  }
}

template <int kRows>
HWY_INLINE void sum_yz(const Region& region, const float* HWY_RESTRICT samples, int count,
                       FourTapGradientBatch& batch) {
  const std::ptrdiff_t row = 2 * static_cast<std::ptrdiff_t>(region.row_stride);
  const std::ptrdiff_t two_slices = 4 * static_cast<std::ptrdiff_t>(region.slice_stride);
  for (int i = 0; i < count; ++i) {
    const float* HWY_RESTRICT p = samples + batch.offset[i];
    const float* HWY_RESTRICT q = p + two_slices;
    const Octet p0 = load_octet(p);
    const Octet q0 = load_octet(q);
    const Octet y0 = set_octet(batch.y[0][i]);
    const Octet dy0 = set_octet(batch.dy[0][i]);
    Octet tp = mul(p0, y0), tq = mul(q0, y0);
    Octet sp = mul(p0, dy0), sq = mul(q0, dy0);
    for (int j = 1; j < kRows; ++j) {
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

HWY_INLINE V reduce(const FourTapBatch& batch, int i) {
  return reduce_x(batch.partial, batch.x, i);
}

HWY_INLINE ValueAndGradient reduce(const FourTapGradientBatch& batch, int i) {
  return {reduce_x(batch.partial, batch.x, i), reduce_x(batch.partial, batch.dx, i),
          reduce_x(batch.partial_y, batch.x, i), reduce_x(batch.partial_z, batch.x, i)};
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
