// SPDX-License-Identifier: Apache-2.0
// Stage "gradient": the gradient of the visible samples of one sheet.
//
// In:  visible bits; exact: the region; central: the planes of the sheet and its two neighbours.
// Out: the gradients of the sheet along the world's axes, in FramePlan::gradient_unit.
// Exact costs three more multiply-adds per tap and runs only where something is visible; central
// needs a margin of samples.
#if defined(OVOID_RENDER_CPU_GRADIENT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_GRADIENT_INL_H_
#undef OVOID_RENDER_CPU_GRADIENT_INL_H_
#else
#define OVOID_RENDER_CPU_GRADIENT_INL_H_
#endif

#include "render/cpu/lattice/differences-inl.h"
#include "render/cpu/lattice/reconstruct-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

HWY_INLINE WorldVector exact_gradient(const LatticeFrame& frame, Workspace& work,
                                      const SampleGroup& group, const Position& u) {
  const ValueAndGradient g = gather_gradient(frame, work, group, u);
  return to_world(frame, g.x, g.y, g.z);
}

HWY_INLINE Position point_between(const Position& a, const Position& b, V t) {
  const auto mix = [&](V p, V q) { return hn::MulAdd(hn::Sub(q, p), t, p); };
  return {mix(a.x, b.x), mix(a.y, b.y), mix(a.z, b.z)};
}

// Values and gradients of the samples named by `bits`, of which all must be active, in one pass.
// Marks them in has_gradient and, where the field is, in the sheet's defined bits.
inline void reconstruct_with_gradients(const LatticeFrame& frame, Workspace& work, int s,
                                       const RowBits& bits) {
  const Block& block = work.block;
  Sheet& sheet = work.ring[block.place.number_of(s)];
  float* const values = sheet.values;
  const std::array<float*, 3> gradient = sheet.gradient;
  for (int y = 0; y < block.place.rows; ++y) {
    sheet.defined[y] |= bits[y];
    sheet.has_gradient[y] |= bits[y];
    work.stats.gradients += std::popcount(bits[y]);
    work.stats.multiply_adds += 4 * kGatheredTaps * std::popcount(bits[y]);
  }
  GradientBatch batch;
  for_each_batch({bits, block.place.rows, sheet.stride}, batch, [&] {
    weigh_sheet(frame, block, s, batch);
    sum_batch(frame, block.region, batch);
    alignas(64) float value[kBatchSamples];
    alignas(64) float g[3][kBatchSamples];
    for (int i = 0; i < batch.count; i += group_size()) {
      const ValueAndGradient v = value_of(frame, batch, i);
      const WorldVector world = to_world(frame, v.x, v.y, v.z);
      hn::Store(v.value, d, value + i);
      hn::Store(world.x, d, g[0] + i);
      hn::Store(world.y, d, g[1] + i);
      hn::Store(world.z, d, g[2] + i);
    }
    for (int i = 0; i < batch.count; ++i) {
      values[batch.at[i]] = value[i];
      for (std::size_t a = 0; a < 3; ++a) gradient[a][batch.at[i]] = g[a][i];
    }
    if (!block.region.is_interior) drop_undefined(batch, sheet.defined);
  });
}

// Samples of the next sheet whose gradient will probably be wanted: those behind samples that were
// visible. Their value comes with the gradient for less than both would cost apart. A wrong guess
// costs time, nothing else.
inline RowBits guess_visible(const LatticeFrame& frame, const Workspace& work,
                             const RowBits& wanted) {
  RowBits guess;
  const bool is_worthwhile = frame.takes_gradients && !frame.is_preintegrated &&
                             !frame.takes_differences && work.block.region.uses_four_taps;
  for (int y = 0; y < work.block.place.rows; ++y)
    guess[y] = is_worthwhile ? wanted[y] & work.was_visible[y] : 0;
  return guess;
}

// A piece's gradient is that of its middle; of a sample that has none before it, the sample's own.
inline void gradient_of_pieces(const LatticeFrame& frame, Workspace& work, int s,
                               const RowBits& bits) {
  const Block& block = work.block;
  const BlockPlace& place = block.place;
  Sheet& sheet = work.ring[place.number_of(s)];
  const RowBits& defined_before = work.ring[place.number_of(s - 1)].defined;
  for (int y = 0; y < place.rows; ++y) {
    work.stats.gradients += std::popcount(bits[y]);
    for_each_group(bits[y], place.margin, place.columns - place.margin,
                   [&](int column, std::uint32_t lanes) {
                     const SampleGroup group{s, column, y, lanes};
                     const Position to = position_of(block.sheets[s], column, y);
                     const Position from = position_of(block.sheets[s - 1], column, y);
                     const M has_before = mask_of(lanes_at(defined_before[y], column));
                     const V share = hn::IfThenElseZero(has_before, hn::Set(d, 0.5F));
                     const Position middle = point_between(to, from, share);
                     store_gradient(sheet, group, exact_gradient(frame, work, group, middle));
                   });
  }
}

// The visible samples that have no gradient yet.
inline void gradients_of(const LatticeFrame& frame, Workspace& work, int s,
                         const RowBits& missing) {
  const Block& block = work.block;
  const BlockPlace& place = block.place;
  if (has_rows(frame, block)) return gradients_by_rows(frame, work, s, missing);
  if (!frame.takes_differences && block.region.uses_four_taps) {
    reconstruct_with_gradients(frame, work, s, missing);
    return;
  }
  Sheet& sheet = work.ring[place.number_of(s)];
  for (int y = 0; y < place.rows; ++y) {
    work.stats.gradients += std::popcount(missing[y]);
    for_each_group(missing[y], place.margin, place.columns - place.margin,
                   [&](int column, std::uint32_t lanes) {
                     const SampleGroup group{s, column, y, lanes};
                     const Position u = position_of(block.sheets[s], column, y);
                     store_gradient(
                         sheet, group,
                         frame.takes_differences
                             ? central_difference_gradient(frame, place, work.ring, group)
                             : exact_gradient(frame, work, group, u));
                   });
  }
}

// Gradients of the sheet's visible samples.
inline void gradient_of_sheet(const LatticeFrame& frame, Workspace& work, int s) {
  const BlockPlace& place = work.block.place;
  const RowBits& has_gradient = work.ring[place.number_of(s)].has_gradient;
  RowBits missing;
  for (int y = 0; y < place.rows; ++y) missing[y] = work.shaded.visible[y] & ~has_gradient[y];
  if (frame.is_preintegrated && !frame.takes_differences) {
    gradient_of_pieces(frame, work, s, missing);
  } else {
    gradients_of(frame, work, s, missing);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
