// SPDX-License-Identifier: Apache-2.0
// A tree over the bricks' boxes: bricks lie along a Morton curve, so eight in a row are near each
// other, and so are eight such groups; a node's box is that of its eight children.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "data/kernels/kernel_shape.h"
#include "data/validate.h"
#include "ovoid/kernel_field.h"

namespace ovoid {
namespace {

constexpr std::int64_t kFanOut = 8;

// Sums over the kernels at a place.
struct Sums {
  double numerator = 0, color_numerator = 0, denominator = 0;
  Vec3 grad_numerator = Vec3::Zero(), grad_denominator = Vec3::Zero();
};

// The derivative of the profile with respect to m^2, times 2: gradients are this times S^-1 d.
double profile_slope(KernelProfile profile, double m, double cutoff) noexcept {
  if (!(m <= cutoff)) return 0.0;
  const double t = m / cutoff;
  const double per_t = 1 / (cutoff * cutoff);  // d phi/dm / m = (d phi/dt / t) / cutoff^2
  switch (profile) {
    case KernelProfile::kGaussian:
      return std::exp(-0.5 * cutoff * cutoff) - std::exp(-0.5 * m * m);
    case KernelProfile::kCubicSpline: {
      const double q = 2 * t;
      if (q < 1) return 4 * per_t * (-3 + 2.25 * q);
      return 4 * per_t * -0.75 * (2 - q) * (2 - q) / q;
    }
    case KernelProfile::kWendlandC2:
      return -20 * per_t * std::pow(1 - t, 3);
    case KernelProfile::kEpanechnikov:
      return -2 * per_t;
  }
  return 0.0;
}

// Squared Mahalanobis distances of `offset` (from the brick's origin) to a brick's kernels, in
// single precision, which is enough to tell the few that matter from the many that do not.
using Distances = std::array<float, KernelBrick::kMaxBrickKernels>;

void find_distances(const KernelView& view, KernelShape shape, const Vec3& offset, Distances& out) {
  const auto x = static_cast<float>(offset[0]);
  const auto y = static_cast<float>(offset[1]);
  const auto z = static_cast<float>(offset[2]);
  // In sigmas before they are squared: world units may be centimetres between galaxies.
  if (shape == KernelShape::kBalls) {
    for (std::int32_t i = 0; i < view.count; ++i) {
      const float per_sigma =
          1.0F / (view.shape[0] == nullptr ? view.shared_shape[0] : view.shape[0][i]);
      const float dx = (x - view.center[0][i]) * per_sigma;
      const float dy = (y - view.center[1][i]) * per_sigma;
      const float dz = (z - view.center[2][i]) * per_sigma;
      out[i] = dx * dx + dy * dy + dz * dz;
    }
    return;
  }
  for (std::int32_t i = 0; i < view.count; ++i) {
    const auto number = [&](int c) {
      return view.shape[0] == nullptr ? view.shared_shape[c] : view.shape[c][i];
    };
    const float a = (x - view.center[0][i]) / number(0);
    const float b = (y - view.center[1][i] - number(1) * a) / number(2);
    const float c = (z - view.center[2][i] - number(3) * a - number(4) * b) / number(5);
    out[i] = a * a + b * b + c * c;
  }
}

}  // namespace

struct KernelSampler::Impl {
  KernelField field;
  std::vector<std::vector<Bounds3>> levels;  // [0]: a box per brick

  explicit Impl(KernelField of) : field(std::move(of)) {
    const KernelSource& source = field.source();
    levels.emplace_back();
    for (std::int64_t b = 0; b < source.num_bricks(); ++b)
      levels[0].push_back(source.brick(b).support);
    while (levels.back().size() > 1) {
      std::vector<Bounds3> above((levels.back().size() + kFanOut - 1) / kFanOut);
      for (std::size_t i = 0; i < levels.back().size(); ++i)
        above[i / kFanOut].extend(levels.back()[i]);
      levels.push_back(std::move(above));
    }
  }

  void add_kernel(const KernelView& view, std::int32_t i, const Vec3& offset, Sums& sums) const {
    const KernelSource& source = field.source();
    const auto numbers = data::shape_numbers(view, source.shape(), i);
    const Mat3 factor = data::factor_of(source.shape(), numbers.data());
    const auto lower = factor.triangularView<Eigen::Lower>();
    const Vec3 whitened = lower.solve(offset - data::offset_of(view, i));
    const double m = whitened.norm();
    if (!(m <= source.cutoff())) return;
    const double weight = data::weight_of(view, i);
    const double phi = weight * profile_value(source.profile(), m, source.cutoff());
    const double value = view.value[static_cast<std::size_t>(field.attribute())][i];
    sums.numerator += value * phi;
    sums.denominator += phi;
    // Of a sum, the colour is weighted by what is summed.
    const bool is_sum = field.reconstruction() == Reconstruction::kSum;
    const double color = view.value[static_cast<std::size_t>(field.color_attribute())][i];
    sums.color_numerator += color * (is_sum ? value * phi : phi);
    const Vec3 slope = weight * profile_slope(source.profile(), m, source.cutoff()) *
                       lower.transpose().solve(whitened);
    sums.grad_numerator += value * slope;
    sums.grad_denominator += slope;
  }

  void add_brick(std::int64_t b, const Vec3& world, Sums& sums) const {
    const KernelSource& source = field.source();
    const KernelView view = source.acquire(b, 0.0);
    const Vec3 offset = world - source.brick(b).origin;
    Distances distances;
    find_distances(view, source.shape(), offset, distances);
    // Wider than the cut-off by far more than single precision can err.
    const auto bound = static_cast<float>(source.cutoff() * source.cutoff() * 1.01);
    for (std::int32_t i = 0; i < view.count; ++i) {
      if (distances[static_cast<std::size_t>(i)] <= bound) add_kernel(view, i, offset, sums);
    }
  }

  void add_node(std::size_t level, std::size_t node, const Vec3& world, Sums& sums) const {
    if (!levels[level][node].contains(world)) return;
    if (level == 0) {
      add_brick(static_cast<std::int64_t>(node), world, sums);
      return;
    }
    const std::size_t end = std::min((node + 1) * kFanOut, levels[level - 1].size());
    for (std::size_t child = node * kFanOut; child < end; ++child)
      add_node(level - 1, child, world, sums);
  }
};

KernelSampler::KernelSampler(KernelField field) {
  data::require_field(field);
  impl_ = std::make_unique<const Impl>(std::move(field));
}
KernelSampler::~KernelSampler() = default;
KernelSampler::KernelSampler(KernelSampler&&) noexcept = default;
KernelSampler& KernelSampler::operator=(KernelSampler&&) noexcept = default;

KernelSample KernelSampler::at(const Vec3& world) const {
  Sums sums;
  impl_->add_node(impl_->levels.size() - 1, 0, world, sums);
  KernelSample sample;
  sample.weight = sums.denominator;
  if (impl_->field.reconstruction() == Reconstruction::kSum) {
    sample.value = sums.numerator;
    sample.gradient = sums.grad_numerator;
    sample.is_defined = sums.numerator != 0;
    if (sample.is_defined) {
      sample.color_value =
          impl_->field.has_own_color() ? sums.color_numerator / sums.numerator : sample.value;
    }
    return sample;
  }
  sample.is_defined = sums.denominator >= KernelField::kLeastWeight;
  if (!sample.is_defined) return sample;
  sample.value = sums.numerator / sums.denominator;
  sample.color_value = sums.color_numerator / sums.denominator;
  sample.gradient = (sums.grad_numerator - sample.value * sums.grad_denominator) / sums.denominator;
  return sample;
}

}  // namespace ovoid
