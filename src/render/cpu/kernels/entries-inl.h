// SPDX-License-Identifier: Apache-2.0
// Tables whose entries are four floats side by side: a lane's entry is one load, and a group's four
// columns are a transposition. Hardware gathers of separate columns take longer.
#if defined(OVOID_RENDER_CPU_ENTRIES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_ENTRIES_INL_H_
#undef OVOID_RENDER_CPU_ENTRIES_INL_H_
#else
#define OVOID_RENDER_CPU_ENTRIES_INL_H_
#endif

#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Colour and opacity of a group's values.
struct Classified {
  V red, green, blue, opacity;
};

#if HWY_TARGET != HWY_SCALAR
// Blocks of the lanes k, k + 4, k + 8, ...: 128 bits each.
template <class Block>
HWY_INLINE V load_blocks(const Block& block, int k) {
#if HWY_MAX_BYTES >= 64
  const hn::FixedTag<float, 8> eight;
  return hn::Combine(d, hn::Combine(eight, block(k + 12), block(k + 8)),
                     hn::Combine(eight, block(k + 4), block(k)));
#elif HWY_MAX_BYTES >= 32
  return hn::Combine(d, block(k + 4), block(k));
#else
  return block(k);
#endif
}

// The four numbers of every lane's block: a 4 x 4 transposition within blocks.
template <class Block>
HWY_INLINE Classified transpose_blocks(const Block& block) {
  const hn::RepartitionToWide<D> pairs;
  const V n0 = load_blocks(block, 0), n1 = load_blocks(block, 1);
  const V n2 = load_blocks(block, 2), n3 = load_blocks(block, 3);
  const auto rg01 = hn::BitCast(pairs, hn::InterleaveLower(d, n0, n1));
  const auto rg23 = hn::BitCast(pairs, hn::InterleaveLower(d, n2, n3));
  const auto ba01 = hn::BitCast(pairs, hn::InterleaveUpper(d, n0, n1));
  const auto ba23 = hn::BitCast(pairs, hn::InterleaveUpper(d, n2, n3));
  return {hn::BitCast(d, hn::InterleaveLower(pairs, rg01, rg23)),
          hn::BitCast(d, hn::InterleaveUpper(pairs, rg01, rg23)),
          hn::BitCast(d, hn::InterleaveLower(pairs, ba01, ba23)),
          hn::BitCast(d, hn::InterleaveUpper(pairs, ba01, ba23))};
}

// The four channels of every lane's entry.
HWY_INLINE Classified transpose_entries(const float* entries, const std::int32_t* index) {
  const hn::FixedTag<float, 4> four;
  return transpose_blocks([&](int lane) { return hn::Load(four, entries + 4 * index[lane]); });
}

// Of every lane the numbers at its index, one on, `stride` on, and one and `stride` on.
HWY_INLINE Classified transpose_squares(const float* numbers, const std::int32_t* index,
                                        int stride) {
  const hn::FixedTag<float, 2> two;
  const hn::FixedTag<float, 4> four;
  return transpose_blocks([&](int lane) {
    const float* const first = numbers + index[lane];
    return hn::Combine(four, hn::LoadU(two, first + stride), hn::LoadU(two, first));
  });
}
#else
HWY_INLINE Classified transpose_squares(const float* numbers, const std::int32_t* index,
                                        int stride) {
  const float* const n = numbers + index[0];
  return {hn::Load(d, n), hn::Load(d, n + 1), hn::Load(d, n + stride), hn::Load(d, n + stride + 1)};
}
HWY_INLINE Classified transpose_entries(const float* entries, const std::int32_t* index) {
  const float* n = entries + 4 * index[0];
  return {hn::Load(d, n), hn::Load(d, n + 1), hn::Load(d, n + 2), hn::Load(d, n + 3)};
}
#endif

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
