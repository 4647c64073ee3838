// SPDX-License-Identifier: Apache-2.0
// Gathering for a batch of samples: the field's value, and where asked its gradient, from the
// four-tap sums of the lattice's sublattices (four_taps-inl.h).
//
// One sublattice: its weighted mean F is the field. Two: the field is q_0 F_0 + q_1 F_1, q_s the
// part of sublattice s in all weights that exist; its gradient adds to those of F_s what the parts
// change: q_0 q_1 (F_1 - F_0) times the difference of the derivatives of the logarithms of their
// sums of weights, which is that of the mean places of the kernels that have weight over sigma^2,
// if they are Gaussians.
#if defined(OVOID_RENDER_CPU_GATHER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_GATHER_INL_H_
#undef OVOID_RENDER_CPU_GATHER_INL_H_
#else
#define OVOID_RENDER_CPU_GATHER_INL_H_
#endif

#include "render/cpu/lattice/differences-inl.h"
#include "render/cpu/lattice/four_taps-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Samples of a sheet, wherever they lie: groups are full even where few samples are active.
template <class Taps>
struct GatherBatch {
  int count = 0;                            // samples; padded to whole groups by repeating the last
  alignas(64) float column[kBatchSamples];  // of the plane
  alignas(64) float row[kBatchSamples];
  alignas(64) std::int32_t at[kBatchSamples];  // in the plane
  alignas(64) float share[kBatchSamples];      // of the weights that exist; only at borders
  alignas(64) float part[device::kMaxSublattices][kBatchSamples];  // if there are several
  Taps taps[device::kMaxSublattices];

  int padded_count() const { return (count + group_size() - 1) / group_size() * group_size(); }
};

using ValueBatch = GatherBatch<FourTapBatch>;

struct GradientBatch : GatherBatch<FourTapGradientBatch> {
  // What makes gradients of ramps constant: a factor for each component; of two sublattices, the
  // variance inside them.
  alignas(64) float correction[3][kBatchSamples];
  // Two sublattices: from one's mean place to the other's, of the kernels that exist (of piecewise
  // kernels, what stands for it) and of the endless lattice, and the product of their parts in
  // that.
  alignas(64) float between[3][kBatchSamples];
  alignas(64) float apart[3][kBatchSamples];
  alignas(64) float parts[kBatchSamples];
};

template <class Batch>
inline constexpr bool kTakesGradient = std::is_same_v<Batch, GradientBatch>;

// What makes the gradient of a ramp constant: the weights' derivative answers to slope 1 with
// variance / sigma^2.
HWY_INLINE V correction_for(V variance, const LatticeFrame& frame) {
  if (!frame.corrects_gradient) return hn::Set(d, 1.0F);
  const V answer = hn::Mul(variance, hn::Set(d, frame.lattice.inverse_variance));
  return hn::IfThenElse(hn::Gt(variance, hn::Set(d, device::kLeastVariance)),
                        hn::Div(hn::Set(d, 1.0F), answer), hn::Set(d, 1.0F));
}

template <bool kBorder, class Batch>
HWY_INLINE void weigh_one(const LatticeFrame& frame, const Region& region, const Position& u, int i,
                          Batch& batch) {
  const GroupWeights group =
      weigh_taps<false, kBorder>(frame.lattice, region, 0, u, i, batch.taps[0]);
  if constexpr (kBorder) hn::Store(group.share, d, batch.share + i);
  if constexpr (kTakesGradient<Batch>) {
    for (int a = 0; a < 3; ++a)
      hn::Store(correction_for(group.axis[a].variance, frame), d, batch.correction[a] + i);
  }
}

// The weights of a sublattice, summed, are this times the product of the axes' totals.
HWY_INLINE V log2_of_scale(const LatticeFrame& frame, const GroupWeights& group) {
  if (frame.is_piecewise) return hn::Zero(d);
  constexpr float kLog2E = 1.44269504F;
  V sum = hn::Zero(d);
  for (const V f : group.fraction)
    sum = hn::Add(sum, hn::MulAdd(hn::Mul(f, f), hn::Set(d, 0.5F), f));
  return hn::Mul(sum, hn::Set(d, -frame.lattice.inverse_variance * kLog2E));
}

HWY_INLINE V product_of_totals(const GroupWeights& group) {
  return hn::Mul(hn::Mul(group.axis[0].total, group.axis[1].total), group.axis[2].total);
}

template <bool kBorder, class Batch>
HWY_INLINE void weigh_two(const LatticeFrame& frame, const Region& region, const Position& u, int i,
                          Batch& batch) {
  const V offset = hn::Set(d, frame.lattice.sublattices[1].offset);
  const Position shifted{hn::Sub(u.x, offset), hn::Sub(u.y, offset), hn::Sub(u.z, offset)};
  const GroupWeights first =
      weigh_taps<true, kBorder>(frame.lattice, region, 0, u, i, batch.taps[0]);
  const GroupWeights second =
      weigh_taps<true, kBorder>(frame.lattice, region, 1, shifted, i, batch.taps[1]);
  // Of the endless lattice.
  const V scale =
      vector_exp2(d, hn::Sub(log2_of_scale(frame, second), log2_of_scale(frame, first)));
  const V ratio = hn::Mul(scale, hn::Div(product_of_totals(second), product_of_totals(first)));
  const V p0 = hn::Div(hn::Set(d, 1.0F), hn::Add(hn::Set(d, 1.0F), ratio));
  const V p1 = hn::Sub(hn::Set(d, 1.0F), p0);
  V q0 = p0;
  V q1 = p1;
  if constexpr (kBorder) {
    q0 = hn::Mul(p0, first.share);
    q1 = hn::Mul(p1, second.share);
    const V share = hn::Add(q0, q1);
    hn::Store(share, d, batch.share + i);
    const V inverse = hn::Div(hn::Set(d, 1.0F), hn::Max(share, hn::Set(d, 1e-30F)));
    q0 = hn::Mul(q0, inverse);
    q1 = hn::Mul(q1, inverse);
  }
  hn::Store(q0, d, batch.part[0] + i);
  hn::Store(q1, d, batch.part[1] + i);
  if constexpr (kTakesGradient<Batch>) {
    hn::Store(hn::Mul(p0, p1), d, batch.parts + i);
    for (int a = 0; a < 3; ++a) {
      const FourWeights& w0 = first.axis[a];
      const FourWeights& w1 = second.axis[a];
      const V shift = hn::Sub(first.fraction[a], second.fraction[a]);
      const V between = frame.is_piecewise
                            ? hn::Mul(hn::Sub(w1.log_slope, w0.log_slope),
                                      hn::Set(d, 1.0F / frame.lattice.inverse_variance))
                            : hn::Add(hn::Sub(mean_tap(w1), mean_tap(w0)), shift);
      hn::Store(between, d, batch.between[a] + i);
      hn::Store(kBorder ? hn::Add(hn::Sub(w1.mean, w0.mean), shift) : between, d,
                batch.apart[a] + i);
      hn::Store(hn::MulAdd(p0, w0.variance, hn::Mul(p1, w1.variance)), d, batch.correction[a] + i);
    }
  }
}

// Pass 1 for samples i and following, at u.
template <class Batch>
HWY_INLINE void weigh_at(const LatticeFrame& frame, const Region& region, const Position& u, int i,
                         Batch& batch) {
  if (frame.lattice.num_sublattices == 1) {
    region.is_interior ? weigh_one<false>(frame, region, u, i, batch)
                       : weigh_one<true>(frame, region, u, i, batch);
  } else {
    region.is_interior ? weigh_two<false>(frame, region, u, i, batch)
                       : weigh_two<true>(frame, region, u, i, batch);
  }
}

// Pass 1 for all samples of a batch on one sheet.
template <class Batch>
HWY_INLINE void weigh_sheet(const LatticeFrame& frame, const Block& block, int s, Batch& batch) {
  const SheetInLattice& sheet = block.sheets[s];
  for (int i = 0; i < batch.padded_count(); i += group_size()) {
    const V column = hn::Load(d, batch.column + i);
    const V row = hn::Load(d, batch.row + i);
    const auto along = [&](int a) {
      const V start = hn::MulAdd(row, hn::Set(d, sheet.per_y[a]), hn::Set(d, sheet.base[a]));
      return hn::MulAdd(column, hn::Set(d, sheet.per_x[a]), start);
    };
    weigh_at(frame, block.region, {along(0), along(1), along(2)}, i, batch);
  }
}

// Pass 2.
template <class Batch>
HWY_INLINE void sum_batch(const LatticeFrame& frame, const Region& region, Batch& batch) {
  if (frame.lattice.num_sublattices == 1) {
    sum_yz<4>(region, region.samples, batch.padded_count(), batch.taps[0]);
    return;
  }
  for (int s = 0; s < frame.lattice.num_sublattices; ++s)
    sum_yz<3>(region, region.samples + s * region.sublattice_stride, batch.padded_count(),
              batch.taps[s]);
}

// Pass 3: samples i and following.
HWY_INLINE V value_of(const LatticeFrame& frame, const ValueBatch& batch, int i) {
  const V first = reduce(batch.taps[0], i);
  if (frame.lattice.num_sublattices == 1) return first;
  return hn::MulAdd(first, hn::Load(d, batch.part[0] + i),
                    hn::Mul(reduce(batch.taps[1], i), hn::Load(d, batch.part[1] + i)));
}

// Two sublattices answer to the slope of a ramp with C slope / sigma^2, C = D + c a a^T the
// covariance of the kernels' places: D inside the sublattices, a from one's mean to the other's. By
// the formula of Sherman and Morrison.
HWY_INLINE void correct_two(const LatticeFrame& frame, const GradientBatch& batch, int i,
                            V* gradient) {
  V within[3], apart[3];
  V along = hn::Zero(d);   // a^T D^-1 g
  V length = hn::Zero(d);  // a^T D^-1 a
  V least = hn::Set(d, 1e30F);
  const V c = hn::Load(d, batch.parts + i);
  for (int a = 0; a < 3; ++a) {
    const V variance = hn::Load(d, batch.correction[a] + i);
    least = hn::Min(least, variance);
    within[a] = hn::Div(hn::Set(d, 1.0F), variance);
    apart[a] = hn::Load(d, batch.apart[a] + i);
    const V scaled = hn::Mul(apart[a], within[a]);
    along = hn::MulAdd(scaled, gradient[a], along);
    length = hn::MulAdd(scaled, apart[a], length);
  }
  const V share = hn::Div(hn::Mul(c, along), hn::MulAdd(c, length, hn::Set(d, 1.0F)));
  const M is_sound = hn::Gt(least, hn::Set(d, device::kLeastInnerVariance));
  const V variance = hn::Set(d, 1.0F / frame.lattice.inverse_variance);
  for (int a = 0; a < 3; ++a) {
    const V own = hn::Mul(hn::NegMulAdd(share, apart[a], gradient[a]), within[a]);
    gradient[a] = hn::IfThenElse(is_sound, hn::Mul(variance, own), gradient[a]);
  }
}

HWY_INLINE ValueAndGradient value_of(const LatticeFrame& frame, const GradientBatch& batch, int i) {
  const ValueAndGradient first = reduce(batch.taps[0], i);
  if (frame.lattice.num_sublattices == 1) {
    const auto correction = [&](int a) { return hn::Load(d, batch.correction[a] + i); };
    return {first.value, hn::Mul(first.x, correction(0)), hn::Mul(first.y, correction(1)),
            hn::Mul(first.z, correction(2))};
  }
  const ValueAndGradient second = reduce(batch.taps[1], i);
  const V q0 = hn::Load(d, batch.part[0] + i);
  const V q1 = hn::Load(d, batch.part[1] + i);
  const auto mix = [&](V a, V b) { return hn::MulAdd(q0, a, hn::Mul(q1, b)); };
  const V change = hn::Mul(hn::Mul(q0, q1), hn::Mul(hn::Sub(second.value, first.value),
                                                    hn::Set(d, frame.lattice.inverse_variance)));
  const auto changed = [&](V g, int a) {
    return hn::MulAdd(change, hn::Load(d, batch.between[a] + i), g);
  };
  V gradient[3] = {changed(mix(first.x, second.x), 0), changed(mix(first.y, second.y), 1),
                   changed(mix(first.z, second.z), 2)};
  if (frame.corrects_gradient) correct_two(frame, batch, i, gradient);
  return {mix(first.value, second.value), gradient[0], gradient[1], gradient[2]};
}

// From index space.
HWY_INLINE WorldVector to_world(const LatticeFrame& frame, V x, V y, V z) {
  const auto row = [&](int r) {
    const device::vec4& m = frame.lattice.gradient_rows[r];
    return hn::MulAdd(hn::Set(d, m.x), x,
                      hn::MulAdd(hn::Set(d, m.y), y, hn::Mul(hn::Set(d, m.z), z)));
  };
  return {row(0), row(1), row(2)};
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
