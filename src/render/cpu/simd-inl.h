// SPDX-License-Identifier: Apache-2.0
// Names and small functions that all SIMD stages share. Included once per target (Highway's foreach
// pattern).
#if defined(OVOID_RENDER_CPU_SIMD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_SIMD_INL_H_
#undef OVOID_RENDER_CPU_SIMD_INL_H_
#else
#define OVOID_RENDER_CPU_SIMD_INL_H_
#endif

#include <hwy/highway.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "render/cpu/sheets.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A group: as many neighbouring samples of a plane's row as a vector holds.
using D = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;
using M = hn::Mask<D>;
inline constexpr D d;
inline constexpr DI di;

inline int group_size() { return static_cast<int>(hn::Lanes(d)); }
inline std::uint32_t group_bits() { return group_size() == 32 ? ~0U : (1U << group_size()) - 1U; }

// Bits of the group at `column` of a row of bits.
HWY_INLINE std::uint32_t lanes_at(std::uint64_t row_bits, int column) {
  return static_cast<std::uint32_t>(row_bits >> column) & group_bits();
}

HWY_INLINE M mask_of(std::uint32_t bits) {
  alignas(8) std::uint8_t bytes[8] = {};
  std::memcpy(bytes, &bits, sizeof bits);
  return hn::LoadMaskBits(d, bytes);
}

HWY_INLINE std::uint32_t bits_of(M mask) {
  alignas(8) std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  std::uint32_t bits;
  std::memcpy(&bits, bytes, sizeof bits);
  return bits;
}

// Adding this to a float of magnitude under 2^22 leaves its nearest whole number in the low bits:
// rounding and conversion to an integer in one addition.
inline constexpr float kRoundingMagic = 12582912.0F;  // 1.5 * 2^23
inline constexpr std::int32_t kRoundingMagicBits = 0x4B400000;

// The integer nearest to x, |x| < 2^22.
HWY_INLINE VI nearest_integer(V x) {
  const V shifted = hn::Add(x, hn::Set(d, kRoundingMagic));
  return hn::Sub(hn::BitCast(di, shifted), hn::Set(di, kRoundingMagicBits));
}

// 2^x for |x| <= 126 by Taylor's series on [-1/2, 1/2]; relative error below (ln 2 / 2)^(n + 1) /
// (n + 1)! with n terms: kExp2CoarseError for five, kExp2Error for six (plus rounding).
inline constexpr double kExp2CoarseError = 2.5e-6;
inline constexpr double kExp2Error = 3e-7;

template <bool kCoarse = false, class DF, class VF = hn::Vec<DF>>
HWY_INLINE VF vector_exp2(DF df, VF x) {
  const hn::RebindToSigned<DF> dint;
  const VF shifted = hn::Add(x, hn::Set(df, kRoundingMagic));
  const VF f = hn::Sub(x, hn::Sub(shifted, hn::Set(df, kRoundingMagic)));
  VF p = kCoarse ? hn::Set(df, 1.3333558e-3F)
                 : hn::MulAdd(f, hn::Set(df, 1.5403530e-4F), hn::Set(df, 1.3333558e-3F));
  p = hn::MulAdd(p, f, hn::Set(df, 9.6181291e-3F));
  p = hn::MulAdd(p, f, hn::Set(df, 5.5504109e-2F));
  p = hn::MulAdd(p, f, hn::Set(df, 2.4022651e-1F));
  p = hn::MulAdd(p, f, hn::Set(df, 6.9314718e-1F));
  p = hn::MulAdd(p, f, hn::Set(df, 1.0F));
  // Only the low bits of `shifted` survive the shift: the whole part, in the exponent's place.
  const auto exponent = hn::ShiftLeft<23>(hn::BitCast(dint, shifted));
  return hn::BitCast(df, hn::Add(hn::BitCast(dint, p), exponent));
}

// 1 / x to float precision: one Newton step on the hardware's estimate.
HWY_INLINE V reciprocal_of(V x) {
  const V r = hn::ApproximateReciprocal(x);
  return hn::Mul(r, hn::NegMulAdd(x, r, hn::Set(d, 2.0F)));
}

// 1 / sqrt(x) for x > 0, to float precision: one Newton step.
HWY_INLINE V reciprocal_sqrt(V x) {
  const V r = hn::ApproximateReciprocalSqrt(x);
  const V half = hn::Mul(hn::Set(d, 0.5F), x);
  return hn::Mul(r, hn::NegMulAdd(hn::Mul(half, r), r, hn::Set(d, 1.5F)));
}

// log2 x for normal x > 0: exponent plus the series of 2 artanh(t) / ln 2, t = (m - 1) / (m + 1),
// for a mantissa m within a factor sqrt(2) of 1. The first term left out is 2 t^9 / (9 ln 2) <
// kLog2Error.
inline constexpr double kLog2Error = 5e-8;

HWY_INLINE V vector_log2(V x) {
  constexpr std::int32_t kSqrtHalf = 0x3F3504F3;
  const VI bits = hn::Sub(hn::BitCast(di, x), hn::Set(di, kSqrtHalf));
  const V exponent = hn::ConvertTo(d, hn::ShiftRight<23>(bits));
  const VI mantissa = hn::And(bits, hn::Set(di, 0x007FFFFF));
  const V m = hn::BitCast(d, hn::Add(mantissa, hn::Set(di, kSqrtHalf)));
  const V one = hn::Set(d, 1.0F);
  const V t = hn::Mul(hn::Sub(m, one), reciprocal_of(hn::Add(m, one)));
  const V tt = hn::Mul(t, t);
  V series = hn::Set(d, 0.41219859F);  // 2 / (7 ln 2)
  series = hn::MulAdd(series, tt, hn::Set(d, 0.57707802F));
  series = hn::MulAdd(series, tt, hn::Set(d, 0.96179669F));
  series = hn::MulAdd(series, tt, hn::Set(d, 2.88539008F));
  return hn::MulAdd(series, t, exponent);
}

inline std::int64_t count_bits(const RowBits& bits, int rows) {
  std::int64_t count = 0;
  for (int y = 0; y < rows; ++y) count += std::popcount(bits[y]);
  return count;
}

// Samples of a group: those of its lanes, of which bit i is sample column + i of the row.
struct SampleGroup {
  int s;  // sheet of the block
  int column, row;
  std::uint32_t lanes;
};

// Runs `body(column, bits)` for each group of a row in which `row_bits` has a bit set; bit i of
// `bits` is sample column + i.
template <class Body>
HWY_INLINE void for_each_group(std::uint64_t row_bits, int first_column, int last_column,
                               const Body& body) {
  for (int column = first_column; column < last_column; column += group_size()) {
    const std::uint32_t bits = lanes_at(row_bits, column);
    if (bits != 0) body(column, bits);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
