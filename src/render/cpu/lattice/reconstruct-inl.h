// SPDX-License-Identifier: Apache-2.0
// Stage "reconstruct" by gathering: each sample of a sheet sums the kernels that reach it. The hot
// loop.
//
// In:  a block's region as floats, the positions of groups of samples.
// Out: field values (and, where asked, index-space gradients) of the groups, and which of them are
// defined.
//
// Three ways, same numbers:
//  - rows: the same kernel on lattice sheets, where samples share weights (rows-inl.h).
//  - four taps: the default kernel, away from holes, batch after batch (gather-inl.h).
//  - general: any support, holes, `sum`, widened kernels, slab means. One sample after the other,
//  SIMD along x (general-inl.h).
#if defined(OVOID_RENDER_CPU_RECONSTRUCT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_RECONSTRUCT_INL_H_
#undef OVOID_RENDER_CPU_RECONSTRUCT_INL_H_
#else
#define OVOID_RENDER_CPU_RECONSTRUCT_INL_H_
#endif

#include "render/cpu/lattice/gather-inl.h"
#include "render/cpu/lattice/general-inl.h"
#include "render/cpu/lattice/rows-inl.h"
#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

struct GroupValues {
  V value;
  std::uint32_t defined;  // bits, a subset of the lanes asked for
};

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

// Values of one group at any positions near its sheet. Its samples must be active.
HWY_INLINE GroupValues gather_group(const LatticeFrame& frame, Workspace& work,
                                    const SampleGroup& group, const Position& u) {
  const Region& region = work.block.region;
  if (region.uses_four_taps) {
    ValueBatch batch;
    batch.count = group_size();
    weigh_at(frame, region, fill_lanes(u, group.lanes), 0, batch);
    sum_batch(frame, region, batch);
    const std::uint32_t whole =
        region.is_interior
            ? group_bits()
            : bits_of(hn::Ge(hn::Load(d, batch.share), hn::Set(d, device::kLeastShare)));
    return {value_of(frame, batch, 0), group.lanes & whole};
  }
  alignas(64) float value[kMaxLanes] = {};
  const std::uint32_t defined =
      gather_general<false>(frame, work, group, u, GeneralOut{value, nullptr, nullptr, nullptr});
  return {hn::Load(d, value), defined};
}

HWY_INLINE ValueAndGradient gather_gradient(const LatticeFrame& frame, Workspace& work,
                                            const SampleGroup& group, const Position& u) {
  const Region& region = work.block.region;
  if (region.uses_four_taps) {
    GradientBatch batch;
    batch.count = group_size();
    weigh_at(frame, region, fill_lanes(u, group.lanes), 0, batch);
    sum_batch(frame, region, batch);
    return value_of(frame, batch, 0);
  }
  alignas(64) float out[4][kMaxLanes] = {};
  gather_general<true>(frame, work, group, u, GeneralOut{out[0], out[1], out[2], out[3]});
  return {hn::Load(d, out[0]), hn::Load(d, out[1]), hn::Load(d, out[2]), hn::Load(d, out[3])};
}

// Samples of a plane, to be handed on in batches.
struct SampleSet {
  const RowBits& bits;
  int rows, stride;
};

// Hands samples to `run` in batches, packed. (Packing by vector compression is slower: its
// overlapping stores must drain before the next pass may read.)
template <class Batch, class Run>
HWY_INLINE void for_each_batch(const SampleSet& samples, Batch& batch, const Run& run) {
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
  for (int y = 0; y < samples.rows; ++y) {
    const auto row = static_cast<float>(y);
    for (RowWord left = samples.bits[y]; left != 0; left &= left - 1) {
      const int x = std::countr_zero(left);
      batch.column[count] = static_cast<float>(x);
      batch.row[count] = row;
      batch.at[count] = y * samples.stride + x;
      if (++count == kBatchSamples) finish();
    }
  }
  if (count > 0) finish();
}

// At a border: takes back the samples of a batch where too few kernels exist.
template <class Batch>
inline void drop_undefined(const Batch& batch, RowBits& defined) {
  for (int i = 0; i < batch.count; ++i) {
    if (batch.share[i] >= device::kLeastShare) continue;
    defined[static_cast<std::size_t>(batch.row[i])] &=
        ~(RowWord{1} << static_cast<int>(batch.column[i]));
  }
}

inline void reconstruct_four_taps(const LatticeFrame& frame, Workspace& work, int s,
                                  const RowBits& wanted) {
  const Block& block = work.block;
  Sheet& sheet = work.ring[block.place.number_of(s)];
  float* values = sheet.values;
  work.stats.multiply_adds += kGatheredTaps * count_bits(wanted, block.place.rows);
  for (int y = 0; y < block.place.rows; ++y) sheet.defined[y] |= wanted[y];
  ValueBatch batch;
  for_each_batch({wanted, block.place.rows, sheet.stride}, batch, [&] {
    weigh_sheet(frame, block, s, batch);
    sum_batch(frame, block.region, batch);
    alignas(64) float value[kBatchSamples];
    for (int i = 0; i < batch.count; i += group_size())
      hn::Store(value_of(frame, batch, i), d, value + i);
    for (int i = 0; i < batch.count; ++i) values[batch.at[i]] = value[i];
    if (!block.region.is_interior) drop_undefined(batch, sheet.defined);
  });
}

inline void reconstruct_general(const LatticeFrame& frame, Workspace& work, int s,
                                const RowBits& wanted) {
  const Block& block = work.block;
  Sheet& sheet = work.ring[block.place.number_of(s)];
  for (int y = 0; y < block.place.rows; ++y) {
    for_each_group(wanted[y], 0, block.place.columns, [&](int column, std::uint32_t lanes) {
      const Position u = position_of(block.sheets[s], column, y);
      const GroupValues group = gather_group(frame, work, {s, column, y, lanes}, u);
      // Neighbours may have their values already.
      hn::BlendedStore(group.value, mask_of(lanes), d, sheet.values + sheet.at(column, y));
      sheet.defined[y] |= RowWord{group.defined} << column;
    });
  }
}

// Adds the samples named by `wanted` to sheet s of the block.
inline void reconstruct_sheet(const LatticeFrame& frame, Workspace& work, int s,
                              const RowBits& wanted) {
  if (work.block.region.uses_four_taps) {
    reconstruct_four_taps(frame, work, s, wanted);
  } else {
    reconstruct_general(frame, work, s, wanted);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
