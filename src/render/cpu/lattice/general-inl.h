// SPDX-License-Identifier: Apache-2.0
// Gathering for every kernel and every place: any support, borders, holes, `sum`, widened kernels,
// slab means. One sample after the other, SIMD along the taps of a row. See reconstruct-inl.h for
// when it is used.
#if defined(OVOID_RENDER_CPU_GENERAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_GENERAL_INL_H_
#undef OVOID_RENDER_CPU_GENERAL_INL_H_
#else
#define OVOID_RENDER_CPU_GENERAL_INL_H_
#endif

#include "render/cpu/lattice/block-inl.h"
#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// The weights g(u - i) of one axis for the samples that exist, and their sums.
struct AxisTaps {
  float* weight;       // [count], followed by zeros up to a whole vector
  float* derivative;   // likewise
  int first;           // of the region
  int count;           // 0: no kernel reaches
  float existing = 0;  // sum of weights
  float existing_derivative = 0;
  float endless = 0;  // sum if the lattice had no border
};

using DT = hn::CappedTag<float, 8>;  // taps of a row
inline constexpr DT dt;

inline int tap_capacity(const LatticeFrame& frame, const SheetInLattice& sheet) {
  const float widest = std::max({sheet.widening[0], sheet.widening[1], sheet.widening[2]});
  return static_cast<int>(2 * frame.lattice.support * widest) + 2 + 2 * kTapPadding;
}

// The kernel along one axis, widened.
struct AxisKernel {
  const device::LatticeConstants& lattice;
  float support;
  float inverse_variance;
  float inverse_unit;

  AxisKernel(const device::LatticeConstants& constants, float widening)
      : lattice(constants),
        support(lattice.support * widening),
        inverse_variance(lattice.inverse_variance / (widening * widening)),
        inverse_unit(lattice.inverse_unit / widening) {}
};

// The weights of taps at `distance`, the position less theirs, which is at most the support.
template <class Tag, class Vector>
HWY_INLINE Vector axis_weight(Tag tag, const AxisKernel& kernel, Vector distance) {
  if (kernel.lattice.is_piecewise == 0) {
    constexpr float kLog2E = 1.44269504F;
    return vector_exp2(tag, hn::Mul(hn::Mul(distance, distance),
                                    hn::Set(tag, -0.5F * kernel.inverse_variance * kLog2E)));
  }
  const Vector t = hn::Mul(hn::Abs(distance), hn::Set(tag, kernel.inverse_unit));
  const auto piece = [&](const device::vec4& c) {
    return hn::MulAdd(
        hn::MulAdd(hn::MulAdd(hn::Set(tag, c.w), t, hn::Set(tag, c.z)), t, hn::Set(tag, c.y)), t,
        hn::Set(tag, c.x));
  };
  const Vector weight =
      hn::IfThenElse(hn::Lt(t, hn::Set(tag, 1.0F)), piece(kernel.lattice.inner_piece),
                     piece(kernel.lattice.outer_piece));
  return hn::IfThenElseZero(hn::Lt(t, hn::Set(tag, 2.0F)), weight);
}

// Their derivative by the position, `weight` at hand.
template <class Tag, class Vector>
HWY_INLINE Vector axis_slope(Tag tag, const AxisKernel& kernel, Vector distance, Vector weight) {
  if (kernel.lattice.is_piecewise == 0)
    return hn::Mul(weight, hn::Mul(distance, hn::Set(tag, -kernel.inverse_variance)));
  const Vector t = hn::Mul(hn::Abs(distance), hn::Set(tag, kernel.inverse_unit));
  const auto piece = [&](const device::vec4& c) {
    return hn::MulAdd(hn::MulAdd(hn::Set(tag, 3 * c.w), t, hn::Set(tag, 2 * c.z)), t,
                      hn::Set(tag, c.y));
  };
  const Vector slope =
      hn::IfThenElse(hn::Lt(t, hn::Set(tag, 1.0F)), piece(kernel.lattice.inner_piece),
                     piece(kernel.lattice.outer_piece));
  const Vector of_unit = hn::Mul(hn::CopySign(hn::Set(tag, kernel.inverse_unit), distance), slope);
  return hn::IfThenElseZero(hn::Lt(t, hn::Set(tag, 2.0F)), of_unit);
}

using D1 = hn::CappedTag<float, 1>;

inline float axis_weight(const AxisKernel& kernel, float distance) {
  if (kernel.lattice.is_piecewise == 0)
    return std::exp(-0.5F * kernel.inverse_variance * distance * distance);
  return hn::GetLane(axis_weight(D1(), kernel, hn::Set(D1(), distance)));
}

// A sample along one axis of a sublattice, whose offset is taken off, and how kernels are widened.
struct AxisPlace {
  int axis;
  float u;
  float widening;
};

inline void fill_axis(const device::LatticeConstants& lattice, const Region& region,
                      const device::Sublattice& sublattice, const AxisPlace& place,
                      AxisTaps& taps) {
  const int axis = place.axis;
  const float u = place.u;
  const AxisKernel kernel(lattice, place.widening);
  const int reach_first = static_cast<int>(std::ceil(u - kernel.support));
  const int reach_last = static_cast<int>(std::floor(u + kernel.support));
  const int lattice_first = static_cast<int>(-region.origin[axis]);
  const int lattice_last = lattice_first + sublattice.dims[axis] - 1;
  const int first = std::max(reach_first, lattice_first);
  const int last = std::min(reach_last, lattice_last);
  taps.first = first - region.lo[axis];
  taps.count = std::max(0, last - first + 1);
  const int lanes = static_cast<int>(hn::Lanes(dt));
  auto existing = hn::Zero(dt);
  auto slope = hn::Zero(dt);
  for (int k = 0; k < taps.count; k += lanes) {
    const auto index = hn::Iota(dt, static_cast<float>(first + k));
    const auto distance = hn::Sub(hn::Set(dt, u), index);
    const auto exists = hn::Lt(index, hn::Set(dt, static_cast<float>(last) + 0.5F));
    const auto weight = hn::IfThenElseZero(exists, axis_weight(dt, kernel, distance));
    const auto derivative = hn::IfThenElseZero(exists, axis_slope(dt, kernel, distance, weight));
    hn::StoreU(weight, dt, taps.weight + k);
    hn::StoreU(derivative, dt, taps.derivative + k);
    existing = hn::Add(existing, weight);
    slope = hn::Add(slope, derivative);
  }
  taps.existing = hn::GetLane(hn::SumOfLanes(dt, existing));
  taps.existing_derivative = hn::GetLane(hn::SumOfLanes(dt, slope));
  taps.endless = taps.existing;
  const auto add_missing = [&](int from, int to) {
    for (int k = from; k <= to; ++k) taps.endless += axis_weight(kernel, u - static_cast<float>(k));
  };
  if (taps.count == 0) {
    add_missing(reach_first, reach_last);
  } else {
    add_missing(reach_first, first - 1);
    add_missing(last + 1, reach_last);
  }
}

struct TapSums {
  float value = 0, x = 0, y = 0,
        z = 0;  // sum of samples x weights, and its index-space derivatives
};

template <bool kGradient>
inline TapSums sum_taps(const Region& region, const float* HWY_RESTRICT samples,
                        const AxisTaps* axis) {
  const int lanes = static_cast<int>(hn::Lanes(dt));
  auto sum = hn::Zero(dt), sum_x = hn::Zero(dt), sum_y = hn::Zero(dt), sum_z = hn::Zero(dt);
  for (int i = 0; i < axis[0].count; i += lanes) {
    auto t = hn::Zero(dt), ty = hn::Zero(dt), tz = hn::Zero(dt);
    for (int k = 0; k < axis[2].count; ++k) {
      const float* slice = samples +
                           static_cast<std::ptrdiff_t>(axis[2].first + k) * region.slice_stride +
                           axis[0].first + i;
      auto row_sum = hn::Zero(dt), row_sum_y = hn::Zero(dt);
      for (int j = 0; j < axis[1].count; ++j) {
        const auto row = hn::LoadU(
            dt, slice + static_cast<std::ptrdiff_t>(axis[1].first + j) * region.row_stride);
        row_sum = hn::MulAdd(row, hn::Set(dt, axis[1].weight[j]), row_sum);
        if constexpr (kGradient)
          row_sum_y = hn::MulAdd(row, hn::Set(dt, axis[1].derivative[j]), row_sum_y);
      }
      t = hn::MulAdd(row_sum, hn::Set(dt, axis[2].weight[k]), t);
      if constexpr (kGradient) {
        ty = hn::MulAdd(row_sum_y, hn::Set(dt, axis[2].weight[k]), ty);
        tz = hn::MulAdd(row_sum, hn::Set(dt, axis[2].derivative[k]), tz);
      }
    }
    const auto weight = hn::LoadU(dt, axis[0].weight + i);
    sum = hn::MulAdd(t, weight, sum);
    if constexpr (kGradient) {
      sum_x = hn::MulAdd(t, hn::LoadU(dt, axis[0].derivative + i), sum_x);
      sum_y = hn::MulAdd(ty, weight, sum_y);
      sum_z = hn::MulAdd(tz, weight, sum_z);
    }
  }
  const auto total = [&](auto v) { return hn::GetLane(hn::SumOfLanes(dt, v)); };
  if constexpr (kGradient) return {total(sum), total(sum_x), total(sum_y), total(sum_z)};
  return {total(sum), 0, 0, 0};
}

struct GeneralOut {
  float *value, *x, *y, *z;  // [lanes]; the gradient's may be null
};

// Numerator, denominator and endless denominator of one sample, added up over its slab's points.
struct Quotient {
  TapSums numerator, denominator;
  float endless = 0;
};

// Of `sum` the denominator says no more than whether a kernel reaches: negative weights count, too.
inline void take_magnitudes(AxisTaps* axis) {
  for (int a = 0; a < 3; ++a) {
    for (int k = 0; k < axis[a].count; ++k) axis[a].weight[k] = std::abs(axis[a].weight[k]);
  }
}

// The sheet on which samples are gathered, and memory for the weights of one.
struct GeneralSheet {
  const LatticeFrame& frame;
  const Region& region;
  const SheetInLattice& sheet;
  float* tap_memory;
  int capacity;
};

// A point of a sample's slab.
struct SamplePoint {
  float u[3];
  float weight;
};

// What the kernels of one sublattice add.
template <bool kGradient>
inline void add_point(const GeneralSheet& on, int s, const SamplePoint& point, Quotient& q) {
  const Region& region = on.region;
  const device::Sublattice& sublattice = on.frame.lattice.sublattices[s];
  AxisTaps axis[3];
  for (int a = 0; a < 3; ++a) {
    axis[a].weight = on.tap_memory + 2 * a * on.capacity;
    axis[a].derivative = axis[a].weight + on.capacity;
    fill_axis(on.frame.lattice, region, sublattice,
              {a, point.u[a] - sublattice.offset, on.sheet.widening[a]}, axis[a]);
  }
  q.endless += point.weight * axis[0].endless * axis[1].endless * axis[2].endless;
  if (axis[0].count == 0 || axis[1].count == 0 || axis[2].count == 0) return;
  const std::ptrdiff_t from = s * region.sublattice_stride;
  const TapSums n = sum_taps<kGradient>(region, region.samples + from, axis);
  TapSums e;
  if (region.has_missing && on.frame.is_sum) {
    take_magnitudes(axis);
    e = sum_taps<false>(region, region.presence + from, axis);
  } else if (region.has_missing) {
    e = sum_taps<kGradient>(region, region.presence + from, axis);
  } else {
    e.value = axis[0].existing * axis[1].existing * axis[2].existing;
    e.x = axis[0].existing_derivative * axis[1].existing * axis[2].existing;
    e.y = axis[0].existing * axis[1].existing_derivative * axis[2].existing;
    e.z = axis[0].existing * axis[1].existing * axis[2].existing_derivative;
  }
  const auto add = [&](TapSums& to, const TapSums& sums) {
    to.value += point.weight * sums.value;
    to.x += point.weight * sums.x;
    to.y += point.weight * sums.y;
    to.z += point.weight * sums.z;
  };
  add(q.numerator, n);
  add(q.denominator, e);
}

// Of the samples' places along one axis, relative to u, under the weights of an endless lattice.
struct AxisMoments {
  float total = 0, mean = 0, variance = 0;
};

inline AxisMoments moments_of(float u, float support, float inverse_variance) {
  AxisMoments m;
  float square = 0;
  for (float i = std::ceil(u - support); i <= u + support; i += 1.0F) {
    const float distance = i - u;
    const float weight = std::exp(-0.5F * inverse_variance * distance * distance);
    m.total += weight;
    m.mean += weight * distance;
    square += weight * distance * distance;
  }
  m.mean /= m.total;
  m.variance = square / m.total - m.mean * m.mean;
  return m;
}

// Two sublattices answer to the slope of a ramp with C slope / sigma^2, C the covariance of their
// places: D + c d d^T, D what varies inside them, d from one's mean to the other's. The inverse is
// Sherman's and Morrison's.
inline void correct_for_two(const float* within, const float* apart, float c, float* gradient) {
  float along = 0;   // d^T D^-1 g
  float length = 0;  // d^T D^-1 d
  for (int a = 0; a < 3; ++a) {
    along += apart[a] * gradient[a] / within[a];
    length += apart[a] * apart[a] / within[a];
  }
  const float share = c * along / (1 + c * length);
  for (int a = 0; a < 3; ++a) gradient[a] = (gradient[a] - share * apart[a]) / within[a];
}

// Makes the gradient of ramps constant (docs/numerics.md, "Gradients").
inline void correct_gradient(const LatticeFrame& frame, const SheetInLattice& sheet, const float* u,
                             float* gradient) {
  AxisMoments moments[device::kMaxSublattices][3];
  float weight[device::kMaxSublattices];
  float sigma_squared[3];
  float total = 0;
  for (int s = 0; s < frame.lattice.num_sublattices; ++s) {
    weight[s] = 1;
    for (int a = 0; a < 3; ++a) {
      const float widening = sheet.widening[a];
      const float inverse_variance = frame.lattice.inverse_variance / (widening * widening);
      sigma_squared[a] = 1 / inverse_variance;
      moments[s][a] = moments_of(u[a] - frame.lattice.sublattices[s].offset,
                                 frame.lattice.support * widening, inverse_variance);
      weight[s] *= moments[s][a].total;
    }
    if (!(weight[s] > 0)) {
      weight[s] = 0;  // no kernel of it reaches, and its moments are none
      for (AxisMoments& m : moments[s]) m = {};
    }
    total += weight[s];
  }
  if (frame.lattice.num_sublattices == 1) {
    for (int a = 0; a < 3; ++a) {
      const float variance = moments[0][a].variance;
      if (variance > device::kLeastVariance) gradient[a] *= sigma_squared[a] / variance;
    }
    return;
  }
  float within[3];
  float apart[3];
  for (int a = 0; a < 3; ++a) {
    const AxisMoments& first = moments[0][a];
    const AxisMoments& second = moments[1][a];
    within[a] = (weight[0] * first.variance + weight[1] * second.variance) / total;
    apart[a] = second.mean - first.mean;
  }
  if (std::min({within[0], within[1], within[2]}) > device::kLeastInnerVariance) {
    for (int a = 0; a < 3; ++a) gradient[a] *= sigma_squared[a];
    correct_for_two(within, apart, weight[0] * weight[1] / (total * total), gradient);
  }
}

// Does any kernel of a sublattice reach the sample at u, or its slab, `step` long? Where no sample
// is missing the supports fill one box. Points would miss a slab that has but an end in it.
inline bool meets_support_of(const device::Sublattice& sublattice, const LatticeFrame& frame,
                             const Region& region, const SheetInLattice& sheet, const float* u,
                             const float* step) {
  const bool is_point = frame.lattice.num_slab_points == 1;
  float from = -0.5F;
  float to = 0.5F;
  for (int a = 0; a < 3; ++a) {
    const float support = frame.lattice.support * sheet.widening[a];
    const float first = static_cast<float>(-region.origin[a]) + sublattice.offset;
    const float below = first - support - u[a];
    const float above = first + static_cast<float>(sublattice.dims[a] - 1) + support - u[a];
    if (is_point || step[a] == 0.0F) {
      if (below > 0.0F || above < 0.0F) return false;
      continue;
    }
    const float at_below = below / step[a];
    const float at_above = above / step[a];
    from = std::max(from, std::min(at_below, at_above));
    to = std::min(to, std::max(at_below, at_above));
    if (from > to) return false;
  }
  return true;
}

inline bool meets_support(const LatticeFrame& frame, const Region& region,
                          const SheetInLattice& sheet, const float* u, const float* step) {
  return std::any_of(frame.lattice.sublattices,
                     frame.lattice.sublattices + frame.lattice.num_sublattices,
                     [&](const device::Sublattice& sublattice) {
                       return meets_support_of(sublattice, frame, region, sheet, u, step);
                     });
}

// The samples of a group, at u. Returns the bits of the lanes whose field is defined.
template <bool kGradient>
inline std::uint32_t gather_general(const LatticeFrame& frame, Workspace& work,
                                    const SampleGroup& group, const Position& u,
                                    const GeneralOut& out) {
  const Region& region = work.block.region;
  const SheetInLattice& sheet = work.block.sheets[group.s];
  alignas(64) float position[3][16];
  hn::Store(u.x, d, position[0]);
  hn::Store(u.y, d, position[1]);
  hn::Store(u.z, d, position[2]);
  const int capacity = tap_capacity(frame, sheet);
  const GeneralSheet on{frame, region, sheet,
                        work.taps.reserve(static_cast<std::size_t>(6) * capacity), capacity};
  const float mass = sheet.widening[0] * sheet.widening[1] * sheet.widening[2];
  std::uint32_t defined = 0;
  for (std::uint32_t lanes = group.lanes; lanes != 0; lanes &= lanes - 1) {
    const int l = std::countr_zero(lanes);
    float step[3];
    float center[3];
    for (int a = 0; a < 3; ++a) {
      step[a] = sheet.step[a] + static_cast<float>(group.column + l) * sheet.step_per_x[a] +
                static_cast<float>(group.row) * sheet.step_per_y[a];
      center[a] = position[a][l];
    }
    Quotient q;
    for (int i = 0; i < frame.lattice.num_slab_points; ++i) {
      const device::SlabPoint slab = frame.lattice.slab[i];
      SamplePoint point{{}, slab.weight};
      for (int a = 0; a < 3; ++a) point.u[a] = center[a] + slab.offset * step[a];
      for (int sub = 0; sub < frame.lattice.num_sublattices; ++sub)
        add_point<kGradient>(on, sub, point, q);
    }
    const TapSums& n = q.numerator;
    const TapSums& e = q.denominator;
    if (frame.is_sum) {
      const bool is_defined =
          region.has_missing ? e.value > 0 : meets_support(frame, region, sheet, center, step);
      if (!is_defined) continue;
      const float w = frame.lattice.sum_weight / mass;
      out.value[l] = w * n.value;
      if constexpr (kGradient) {
        out.x[l] = w * n.x;
        out.y[l] = w * n.y;
        out.z[l] = w * n.z;
      }
    } else {
      if (!(e.value >= device::kLeastShare * q.endless) || !(e.value > 0)) continue;
      const float inverse = 1.0F / e.value;
      const float f = n.value * inverse;
      out.value[l] = f;
      if constexpr (kGradient) {
        out.x[l] = (n.x - f * e.x) * inverse;
        out.y[l] = (n.y - f * e.y) * inverse;
        out.z[l] = (n.z - f * e.z) * inverse;
        if (frame.corrects_gradient) {
          float gradient[3] = {out.x[l], out.y[l], out.z[l]};
          correct_gradient(frame, sheet, center, gradient);
          out.x[l] = gradient[0];
          out.y[l] = gradient[1];
          out.z[l] = gradient[2];
        }
      }
    }
    defined |= 1U << l;
  }
  return defined;
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
