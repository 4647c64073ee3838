// SPDX-License-Identifier: Apache-2.0
// The sums of docs/numerics.md. Input: a field's samples and a place (a point or a segment).
// Output: value and gradient. Nothing is approximated and nothing is skipped: the loops run over
// all lattice indices within the support box. The only economy is that the one-axis weights of a
// point are computed once per axis and not once per kernel.
#include "render/reference/field_evaluator.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <new>
#include <numbers>

#include "ovoid/error.h"

namespace ovoid::reference {
namespace {

// The share of the endless lattice's denominator below which a normalized field is undefined. On
// the face of a lattice the share is 1/2; under that, so that rounding does not decide about a
// sheet that lies on the face.
constexpr double kLeastShare = 0.48;

// Spacings squared: a gradient is only corrected where more than one kernel has weight.
constexpr double kLeastVariance = 1e-6;

// The same of several sublattices, where a matrix is inverted: it must not be near to singular.
constexpr double kLeastInnerVariance = 1e-3;

// Index units: so near to the cut-off, where rounding would decide about a kernel, it counts half.
constexpr double kOnCutoff = 1e-9;

// Spacings; nobody waits for the sums of longer ones.
constexpr double kMaxSegment = 1e6;

double stored_number(const BrickView& view, std::int64_t position) {
  const auto read = [&]<typename T>(T number) {
    std::memcpy(&number,
                static_cast<const std::byte*>(view.data) + position * std::int64_t{sizeof(T)},
                sizeof(T));
    return static_cast<double>(number);
  };
  switch (view.type) {
    case ScalarType::kUInt8:
      return read(std::uint8_t{});
    case ScalarType::kInt8:
      return read(std::int8_t{});
    case ScalarType::kUInt16:
      return read(std::uint16_t{});
    case ScalarType::kInt16:
      return read(std::int16_t{});
    case ScalarType::kFloat32:
      return read(float{});
    default:
      break;
  }
  throw Error(ErrorCode::kUnsupported, std::string("brick of type ") + name_of(view.type) +
                                           ": expected uint8, int8, uint16, int16 or float32");
}

// The indices whose support along one axis holds the place u: |u - i| <= reach.
struct IndexRange {
  std::int64_t first;
  std::int64_t last;  // inclusive

  // Those of them that a lattice of `size` samples has.
  IndexRange inside(std::int64_t size) const {
    return {std::max<std::int64_t>(first, 0), std::min(last, size - 1)};
  }
};

IndexRange indices_in_reach(double lowest_u, double highest_u, double reach) {
  return {static_cast<std::int64_t>(std::ceil(lowest_u - reach)),
          static_cast<std::int64_t>(std::floor(highest_u + reach))};
}

// A weight along one axis, and its slope.
struct AxisWeight {
  double g = 0;
  double dg = 0;
};

AxisWeight b_spline_at(double t) {
  const double a = std::abs(t);
  if (a >= 2) return {};
  const double sign = t < 0 ? -1.0 : 1.0;
  if (a >= 1) return {(2 - a) * (2 - a) * (2 - a) / 6, -sign * (2 - a) * (2 - a) / 2};
  return {2.0 / 3.0 - a * a * (2 - a) / 2, sign * (1.5 * a * a - 2 * a)};
}

AxisWeight catmull_rom_at(double t) {
  const double a = std::abs(t);
  if (a >= 2) return {};
  const double sign = t < 0 ? -1.0 : 1.0;
  if (a >= 1) return {(1 - a) * (2 - a) * (2 - a) / 2, sign * (2 - a) * (3 * a - 4) / 2};
  return {(1 - a) * (1 + a - 1.5 * a * a), sign * a * (4.5 * a - 5)};
}

// A kernel along one axis, widened: g and dg/dd at the distance d.
struct AxisKernel {
  LatticeKernelKind kind;
  double sigma;
  double reach;

  AxisWeight at(double d) const {
    if (kind == LatticeKernelKind::kGaussian) {
      const double part = std::abs(d) >= reach - kOnCutoff ? 0.5 : 1.0;
      const double g = part * std::exp(-0.5 * d * d / (sigma * sigma));
      return {g, -d / (sigma * sigma) * g};
    }
    const double unit = 2 * sigma;
    const AxisWeight piece =
        kind == LatticeKernelKind::kBSpline ? b_spline_at(d / unit) : catmull_rom_at(d / unit);
    return {piece.g, piece.dg / unit};
  }
};

// g and dg/du at u of every kernel in reach along one axis, and their endless sum E.
struct AxisWeights {
  IndexRange indices;
  std::vector<AxisWeight> weights;
  double endless = 0;

  AxisWeights(double u, const AxisKernel& kernel)
      : indices(indices_in_reach(u, u, kernel.reach + kOnCutoff)) {
    for (std::int64_t i = indices.first; i <= indices.last; ++i) {
      weights.push_back(kernel.at(u - static_cast<double>(i)));
      endless += weights.back().g;
    }
  }

  const AxisWeight& of(std::int64_t i) const {
    return weights[static_cast<std::size_t>(i - indices.first)];
  }
};

// erf(b) - erf(a) for a <= b, without cancellation where both lie in one tail.
double difference_of_erf(double a, double b) {
  if (a > 0) return std::erfc(a) - std::erfc(b);
  if (b < 0) return std::erfc(-b) - std::erfc(-a);
  return std::erf(b) - std::erf(a);
}

// A part of a segment, in t; empty unless t_in < t_out.
struct Part {
  double t_in = 0;
  double t_out = 1;

  // What is left of it where |start + t step| <= reach.
  Part within(double start, double step, double reach) const {
    if (step == 0) return std::abs(start) <= reach ? *this : Part{1, 0};
    const double t1 = (-reach - start) / step;
    const double t2 = (reach - start) / step;
    return {std::max(t_in, std::min(t1, t2)), std::min(t_out, std::max(t1, t2))};
  }
  bool is_empty() const { return !(t_in < t_out); }
};

// The indices in reach of some place u = from + t step of a part.
IndexRange indices_in_reach(double from, double step, const Part& part, double reach) {
  const double u_in = from + part.t_in * step;
  const double u_out = from + part.t_out * step;
  return indices_in_reach(std::min(u_in, u_out), std::max(u_in, u_out), reach);
}

// Integrals over a part of a segment, in t, of one kernel and its gradient along d(t) = start + t
// step, where d is the offset from the kernel's centre.
struct LineIntegral {
  double phi = 0;
  Vec3 grad_phi = Vec3::Zero();
};

// Along the line phi is one Gaussian in t: exp(-q0 - k/2 (t - t0)^2).
LineIntegral gaussian_integral(const Part& part, const Vec3& start, const Vec3& step,
                               const Vec3& sigma) {
  LineIntegral integral;
  const Vec3 scaled_start = start.cwiseQuotient(sigma);
  const Vec3 scaled_step = step.cwiseQuotient(sigma);
  const double k = scaled_step.squaredNorm();
  const double t0 = -scaled_start.dot(scaled_step) / k;
  const double peak = std::exp(-0.5 * (scaled_start + t0 * scaled_step).squaredNorm());
  const double a = part.t_in - t0;
  const double b = part.t_out - t0;
  const double root = std::sqrt(0.5 * k);
  integral.phi =
      peak * std::sqrt(std::numbers::pi / (2 * k)) * difference_of_erf(root * a, root * b);
  // First moment about t0: the integral of (t - t0) phi.
  const double moment = peak * (std::exp(-0.5 * k * a * a) - std::exp(-0.5 * k * b * b)) / k;
  const Vec3 nearest = start + t0 * step;
  integral.grad_phi =
      -(nearest * integral.phi + step * moment).cwiseQuotient(sigma.cwiseProduct(sigma));
  return integral;
}

// Kinds of one size: between the places where the line meets a knot of one of the axes, phi is a
// polynomial of degree 9 in t, for which five Gauss-Legendre points are exact.
LineIntegral piecewise_integral(const Part& part, const Vec3& start, const Vec3& step,
                                const std::array<AxisKernel, 3>& kernels) {
  static constexpr double kPoints[5] = {0.0, -0.5384693101056831, 0.5384693101056831,
                                        -0.9061798459386640, 0.9061798459386640};
  static constexpr double kWeights[5] = {0.5688888888888889, 0.4786286704993665, 0.4786286704993665,
                                         0.2369268850561891, 0.2369268850561891};
  std::vector<double> knots{part.t_in, part.t_out};
  for (int a = 0; a < 3; ++a) {
    for (int knot = -1; knot <= 1 && step[a] != 0; ++knot) {
      const double t = (2 * kernels[static_cast<std::size_t>(a)].sigma * knot - start[a]) / step[a];
      if (t > part.t_in && t < part.t_out) knots.push_back(t);
    }
  }
  std::sort(knots.begin(), knots.end());
  LineIntegral integral;
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    const double half = 0.5 * (knots[i + 1] - knots[i]);
    const double middle = 0.5 * (knots[i + 1] + knots[i]);
    for (int n = 0; n < 5; ++n) {
      const Vec3 d = start + (middle + half * kPoints[n]) * step;
      const AxisWeight x = kernels[0].at(d[0]);
      const AxisWeight y = kernels[1].at(d[1]);
      const AxisWeight z = kernels[2].at(d[2]);
      const double weight = half * kWeights[n];
      integral.phi += weight * x.g * y.g * z.g;
      integral.grad_phi += weight * Vec3(x.dg * y.g * z.g, x.g * y.dg * z.g, x.g * y.g * z.dg);
    }
  }
  return integral;
}

}  // namespace

FieldEvaluator::FieldEvaluator(const LatticeField& field)
    : FieldEvaluator(field, {0, 0, 0}, field.geometry().dims) {}

FieldEvaluator::FieldEvaluator(const LatticeField& field, const Index3& lo, const Index3& hi)
    : lattice_(field.geometry()),
      world_gradient_from_index_(lattice_.world_from_index.linear().inverse().transpose()),
      index_from_world_(lattice_.world_from_index.inverse()),
      index_gradient_from_world_(lattice_.world_from_index.linear().transpose()),
      kernel_(field.index_kernel()),
      reconstruction_(field.reconstruction()),
      lo_(lo),
      hi_(hi) {
  const BrickSource& source = field.source();
  const auto count =
      static_cast<std::size_t>(num_samples({hi_[0] - lo_[0], hi_[1] - lo_[1], hi_[2] - lo_[2]}));
  try {
    values_.assign(count, 0.0);
    exists_.assign(count, 0);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory, "reference back end: no memory for " +
                                             std::to_string(count) + " samples of 9 bytes");
  }
  const std::int64_t edge = source.brick_edge();
  const std::int64_t layers = edge * lattice_.num_sublattices();
  for (std::int64_t bz = lo_[2] / layers; bz * layers < hi_[2]; ++bz) {
    for (std::int64_t by = lo_[1] / edge; by * edge < hi_[1]; ++by) {
      for (std::int64_t bx = lo_[0] / edge; bx * edge < hi_[0]; ++bx)
        copy_brick(source, {bx, by, bz});
    }
  }
}

void FieldEvaluator::copy_brick(const BrickSource& source, const Index3& brick) {
  const BrickView view = source.acquire(brick[0], brick[1], brick[2], 0.0);
  Index3 begin;
  Index3 end;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t samples = source.brick_edge() * (a == 2 ? lattice_.num_sublattices() : 1);
    begin[a] = std::max(brick[a] * samples, lo_[a]);
    end[a] = std::min((brick[a] + 1) * samples, hi_[a]);
  }
  for (std::int64_t k = begin[2]; k < end[2]; ++k) {
    for (std::int64_t j = begin[1]; j < end[1]; ++j) {
      for (std::int64_t i = begin[0]; i < end[0]; ++i) {
        const double stored =
            stored_number(view, (i - view.lo[0]) + (j - view.lo[1]) * view.stride_y +
                                    (k - view.lo[2]) * view.stride_z);
        const double value = stored * source.value_scale() + source.value_offset();
        if (!std::isfinite(value)) continue;
        const std::size_t place = place_of_sample({i, j, k});
        values_[place] = value;
        exists_[place] = 1;
        ++num_existing_;
      }
    }
  }
}

FieldSample FieldEvaluator::at_index(const Vec3& position, const Vec3& widening) const {
  // Also keeps what is no number, or too large for an index, from the loops.
  if (!support_bounds(widening).contains(position)) return {};
  Sums sums;
  for (int s = 0; s < lattice_.num_sublattices(); ++s) add_sublattice(s, position, widening, sums);
  return reconstruct(sums, widening);
}

void FieldEvaluator::add_sublattice(int sublattice, const Vec3& position, const Vec3& widening,
                                    Sums& sums) const {
  const Vec3 u = position - lattice_.offset_of(sublattice);
  const Index3 dims = lattice_.dims_of(sublattice);
  const auto axis = [&](int a) {
    return AxisWeights(
        u[a], {kernel_.kind, kernel_.sigma * widening[a], kernel_.support_radius() * widening[a]});
  };
  const AxisWeights x = axis(0);
  const AxisWeights y = axis(1);
  const AxisWeights z = axis(2);
  sums.endless += x.endless * y.endless * z.endless;
  const IndexRange in_x = x.indices.inside(dims[0]);
  const IndexRange in_y = y.indices.inside(dims[1]);
  const IndexRange in_z = z.indices.inside(dims[2]);
  for (std::int64_t k = in_z.first; k <= in_z.last; ++k) {
    for (std::int64_t j = in_y.first; j <= in_y.last; ++j) {
      for (std::int64_t i = in_x.first; i <= in_x.last; ++i) {
        const std::size_t place = place_of(sublattice, {i, j, k});
        if (exists_[place] == 0) continue;
        const auto [gx, dgx] = x.of(i);
        const auto [gy, dgy] = y.of(j);
        const auto [gz, dgz] = z.of(k);
        const double phi = gx * gy * gz;
        const Vec3 grad_phi(dgx * gy * gz, gx * dgy * gz, gx * gy * dgz);
        sums.numerator += values_[place] * phi;
        sums.denominator += phi;
        sums.reaches = sums.reaches || phi != 0;
        sums.grad_numerator += values_[place] * grad_phi;
        sums.grad_denominator += grad_phi;
      }
    }
  }
}

FieldSample FieldEvaluator::at_world(const Vec3& position, const Vec3& widening) const {
  return at_index(index_from_world_ * position, widening);
}

FieldSample FieldEvaluator::mean_over(const Vec3& from, const Vec3& to,
                                      const Vec3& widening) const {
  if (!from.allFinite() || !to.allFinite()) return {};
  if (!support_bounds(widening).intersects(Bounds3(from.cwiseMin(to), from.cwiseMax(to))))
    return {};
  const Vec3 step = to - from;
  if (!(step.norm() <= kMaxSegment)) {
    throw Error(ErrorCode::kInvalidArgument,
                "mean over a segment of " + std::to_string(step.norm()) +
                    " spacings: expected at most " + std::to_string(kMaxSegment));
  }
  assert(from != to);
  Sums sums;
  for (int s = 0; s < lattice_.num_sublattices(); ++s)
    integrate_sublattice(s, from - lattice_.offset_of(s), step, widening, sums);
  return reconstruct(sums, widening);
}

// Axis by axis, the segment is narrowed to what lies in reach of the index: the kernels of the
// innermost loop are those whose boxes the segment meets, and the part that is left is the one
// inside the box.
void FieldEvaluator::integrate_sublattice(int sublattice, const Vec3& from, const Vec3& step,
                                          const Vec3& widening, Sums& sums) const {
  const Vec3 sigma = kernel_.sigma * widening;
  const Vec3 reach = kernel_.support_radius() * widening;
  const Part whole;
  const IndexRange z = indices_in_reach(from[2], step[2], whole, reach[2]);
  for (std::int64_t k = z.first; k <= z.last; ++k) {
    const double dz = from[2] - static_cast<double>(k);
    const Part near_k = whole.within(dz, step[2], reach[2]);
    if (near_k.is_empty()) continue;
    const IndexRange y = indices_in_reach(from[1], step[1], near_k, reach[1]);
    for (std::int64_t j = y.first; j <= y.last; ++j) {
      const double dy = from[1] - static_cast<double>(j);
      const Part near_j = near_k.within(dy, step[1], reach[1]);
      if (near_j.is_empty()) continue;
      const IndexRange x = indices_in_reach(from[0], step[0], near_j, reach[0]);
      for (std::int64_t i = x.first; i <= x.last; ++i) {
        const double dx = from[0] - static_cast<double>(i);
        const Part in_box = near_j.within(dx, step[0], reach[0]);
        if (in_box.is_empty()) continue;
        const Vec3 start(dx, dy, dz);
        const LineIntegral integral =
            kernel_.kind == LatticeKernelKind::kGaussian
                ? gaussian_integral(in_box, start, step, sigma)
                : piecewise_integral(in_box, start, step,
                                     {{{kernel_.kind, sigma[0], reach[0]},
                                       {kernel_.kind, sigma[1], reach[1]},
                                       {kernel_.kind, sigma[2], reach[2]}}});
        sums.endless += integral.phi;
        if (!is_inside(sublattice, {i, j, k})) continue;
        const std::size_t place = place_of(sublattice, {i, j, k});
        if (exists_[place] == 0) continue;
        sums.numerator += values_[place] * integral.phi;
        sums.denominator += integral.phi;
        sums.reaches = true;
        sums.grad_numerator += values_[place] * integral.grad_phi;
        sums.grad_denominator += integral.grad_phi;
      }
    }
  }
}

FieldSample FieldEvaluator::mean_under(const Bounds3& box,
                                       const std::function<double(const Vec3&)>& weight) const {
  // Also keeps what is no number, or too large for an index, from the loops.
  if (!support_bounds(Vec3::Ones()).intersects(box)) return {};
  double sum = 0;
  double sum_of_weights = 0;
  for (int s = 0; s < lattice_.num_sublattices(); ++s) {
    const Vec3 offset = lattice_.offset_of(s);
    const IndexRange in_x = indices_in_reach(box.min()[0] - offset[0], box.max()[0] - offset[0], 0);
    const IndexRange in_y = indices_in_reach(box.min()[1] - offset[1], box.max()[1] - offset[1], 0);
    const IndexRange in_z = indices_in_reach(box.min()[2] - offset[2], box.max()[2] - offset[2], 0);
    for (std::int64_t k = in_z.first; k <= in_z.last; ++k) {
      for (std::int64_t j = in_y.first; j <= in_y.last; ++j) {
        for (std::int64_t i = in_x.first; i <= in_x.last; ++i) {
          const Vec3 index(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
          const double w = weight(index + offset);
          if (w == 0) continue;
          if (!is_inside(s, {i, j, k}) || exists_[place_of(s, {i, j, k})] == 0) return {};
          sum += w * values_[place_of(s, {i, j, k})];
          sum_of_weights += w;
        }
      }
    }
  }
  if (!(sum_of_weights > 0)) return {};
  FieldSample sample;
  sample.value = sum / sum_of_weights;
  sample.is_defined = true;
  return sample;
}

Vec3 FieldEvaluator::corrected_gradient(const Vec3& gradient, const Vec3& position,
                                        const Vec3& widening) const {
  if (reconstruction_ == Reconstruction::kSum || kernel_.kind != LatticeKernelKind::kGaussian)
    return gradient;
  // Moments of the samples' places, relative to the position, under the endless lattice's weights:
  // of each sublattice, which are products, and of all.
  const Vec3 sigma = kernel_.sigma * widening;
  double total = 0;
  Vec3 mean = Vec3::Zero();
  Mat3 square = Mat3::Zero();
  Vec3 within = Vec3::Zero();  // variances inside the sublattices
  for (int s = 0; s < lattice_.num_sublattices(); ++s) {
    const Vec3 u = position - lattice_.offset_of(s);
    double weight = 1;
    Vec3 own_mean;
    Vec3 variance;
    for (int a = 0; a < 3; ++a) {
      const AxisWeights axis(u[a],
                             {kernel_.kind, sigma[a], kernel_.support_radius() * widening[a]});
      double first = 0;
      double second = 0;
      for (std::int64_t i = axis.indices.first; i <= axis.indices.last; ++i) {
        const double d = static_cast<double>(i) - u[a];
        first += d * axis.of(i).g / axis.endless;
        second += d * d * axis.of(i).g / axis.endless;
      }
      weight *= axis.endless;
      own_mean[a] = first;
      variance[a] = second - first * first;
    }
    if (!(weight > 0)) continue;  // no kernel of it reaches
    total += weight;
    mean += weight * own_mean;
    square += weight * (own_mean * own_mean.transpose());
    within += weight * variance;
  }
  mean /= total;
  within /= total;
  const Mat3 between = square / total - mean * mean.transpose();
  Vec3 grad_index = index_gradient_from_world_ * gradient;
  const Vec3 answered = sigma.cwiseProduct(sigma).cwiseProduct(grad_index);
  if (lattice_.num_sublattices() == 1) {
    // Where a single kernel reaches, no ramp has a slope.
    for (int a = 0; a < 3; ++a)
      if (within[a] > kLeastVariance) grad_index[a] = answered[a] / within[a];
  } else if (within.minCoeff() > kLeastInnerVariance) {
    const Mat3 covariance = between + Mat3(within.asDiagonal());
    grad_index = covariance.inverse() * answered;
  }
  return world_gradient_from_index_ * grad_index;
}

Bounds3 FieldEvaluator::support_bounds(const Vec3& widening) const {
  const Vec3 reach = kernel_.support_radius() * widening;
  Bounds3 bounds;
  for (int s = 0; s < lattice_.num_sublattices(); ++s) {
    const Index3 dims = lattice_.dims_of(s);
    const Vec3 last(static_cast<double>(dims[0] - 1), static_cast<double>(dims[1] - 1),
                    static_cast<double>(dims[2] - 1));
    bounds.extend(Bounds3(lattice_.offset_of(s) - reach, lattice_.offset_of(s) + last + reach));
  }
  return bounds;
}

FieldSample FieldEvaluator::reconstruct(const Sums& sums, const Vec3& widening) const {
  const bool is_normalized = reconstruction_ == Reconstruction::kNormalized;
  // The cutoff is at most 16 sigmas, so no phi within reach underflows.
  if (!(is_normalized ? sums.denominator > 0 : sums.reaches)) return {};
  FieldSample sample;
  sample.weight = sums.denominator / sums.endless;
  if (is_normalized && sums.denominator < kLeastShare * sums.endless) return sample;
  sample.is_defined = true;
  Vec3 grad_index;
  if (reconstruction_ == Reconstruction::kSum) {
    const double mass = kernel_.kind == LatticeKernelKind::kGaussian
                            ? std::sqrt(2 * std::numbers::pi) * kernel_.sigma
                            : 2 * kernel_.sigma;
    const double weight =
        1 / (mass * mass * mass) / (lattice_.density() * widening[0] * widening[1] * widening[2]);
    sample.value = weight * sums.numerator;
    grad_index = weight * sums.grad_numerator;
  } else {
    sample.value = sums.numerator / sums.denominator;
    grad_index = (sums.grad_numerator - sample.value * sums.grad_denominator) / sums.denominator;
  }
  sample.gradient = world_gradient_from_index_ * grad_index;
  return sample;
}

bool FieldEvaluator::is_inside(int sublattice, const Index3& index) const noexcept {
  const Index3 dims = lattice_.dims_of(sublattice);
  for (int a = 0; a < 3; ++a) {
    if (index[a] < 0 || index[a] >= dims[a]) return false;
  }
  return true;
}

std::size_t FieldEvaluator::place_of(int sublattice, const Index3& index) const noexcept {
  const std::int64_t layer = index[2] * lattice_.num_sublattices() + sublattice;
  return place_of_sample({index[0], index[1], layer});
}

std::size_t FieldEvaluator::place_of_sample(const Index3& sample) const noexcept {
  return static_cast<std::size_t>(
      (sample[0] - lo_[0]) +
      (hi_[0] - lo_[0]) * ((sample[1] - lo_[1]) + (hi_[1] - lo_[1]) * (sample[2] - lo_[2])));
}

}  // namespace ovoid::reference
