// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/kernels/project_brick.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "data/kernels/kernel_shape.h"

namespace ovoid::cpu {
namespace {

constexpr double kMergedEdge = 0.7;  // of a splat's least sigma

// A brick's kernels, where the frame sees them.
struct BrickInFrame {
  const KernelField& field;
  const view::KernelPlan& plan;
  const KernelBrick& brick;
  KernelView view;

  const float* values() const { return view.value[static_cast<std::size_t>(field.attribute())]; }
  const float* colors() const {
    return view.value[static_cast<std::size_t>(field.color_attribute())];
  }
  Vec3 center(std::int32_t i) const { return brick.origin + data::offset_of(view, i); }
};

Splat splat_of(const BrickInFrame& brick, std::int32_t i) {
  const KernelShape shape = brick.field.source().shape();
  const auto numbers = data::shape_numbers(brick.view, shape, i);
  Splat splat = project_kernel(brick.plan.space, brick.center(i), shape, numbers.data(),
                               brick.field.source().cutoff());
  splat.weight *= data::weight_of(brick.view, i);
  splat.value = brick.values()[i];
  splat.color = brick.colors()[i];
  return splat;
}

// The sigma up to which all balls of a brick become splats of the same size, world units: the
// smaller of what pixels and sheets allow, where the brick is nearest.
double least_sigma(const BrickInFrame& brick) {
  const view::SplatSpace& space = brick.plan.space;
  double depth_scale = 1;
  if (!space.is_parallel) {
    double nearest = std::numeric_limits<double>::infinity();
    for (int corner = 0; corner < 8; ++corner) {
      const auto type = static_cast<Bounds3::CornerType>(corner);
      nearest = std::min(nearest, space.camera_from_world(brick.brick.support.corner(type))[2]);
    }
    depth_scale = std::max(nearest, 0.5 * space.sampling_distance) / space.focal_depth;
  }
  return 0.5 * std::min(view::kLeastPixels * space.pitch * depth_scale, space.sampling_distance);
}

// Balls beside each other, on the way to become one.
class Cluster {
 public:
  Cluster(const BrickInFrame& brick, double edge)
      : brick_(brick), edge_(static_cast<float>(edge)) {}

  int count() const noexcept { return count_; }
  std::int32_t first() const noexcept { return first_; }

  bool has_room_for(std::int32_t i) const {
    if (count_ == 0) return true;
    for (std::size_t a = 0; a < 3; ++a) {
      const float at = brick_.view.center[a][i];
      if (std::max(hi_[a], at) - std::min(lo_[a], at) > edge_) return false;
    }
    return true;
  }

  void add(std::int32_t i, double sigma) {
    if (count_++ == 0) {
      first_ = i;
      sigma_ = sigma;
    }
    const double ratio = sigma / sigma_;
    const double mass = data::weight_of(brick_.view, i) * ratio * ratio * ratio;
    const float value = brick_.values()[i];
    const double share = mass * std::abs(value);
    const Vec3 at = data::offset_of(brick_.view, i);
    for (std::size_t a = 0; a < 3; ++a) {
      lo_[a] = std::min(lo_[a], brick_.view.center[a][i]);
      hi_[a] = std::max(hi_[a], brick_.view.center[a][i]);
    }
    mass_ += mass;
    of_value_ += mass * value;
    of_color_ += share * brick_.colors()[i];
    share_ += share;
    place_ += share * at;
    squares_ += share * at * at.transpose();
  }

  Splat splat() const {
    // Where no value has a share, any place will do.
    Vec3 mean = data::offset_of(brick_.view, first_);
    Mat3 spread = Mat3::Zero();
    if (share_ > 0) {
      mean = place_ / share_;
      spread = squares_ / share_ - mean * mean.transpose();
    }
    Splat splat = project_small_balls(brick_.plan.space, brick_.brick.origin + mean, sigma_, spread,
                                      brick_.field.source().cutoff());
    splat.weight *= static_cast<float>(mass_);
    splat.value = static_cast<float>(of_value_ / mass_);
    splat.color = share_ > 0 ? static_cast<float>(of_color_ / share_) : brick_.colors()[first_];
    return splat;
  }

  void clear() {
    count_ = 0;
    mass_ = of_value_ = of_color_ = share_ = 0;
    place_ = Vec3::Zero();
    squares_ = Mat3::Zero();
    lo_ = {kFar, kFar, kFar};
    hi_ = {-kFar, -kFar, -kFar};
  }

 private:
  static constexpr float kFar = std::numeric_limits<float>::max();

  const BrickInFrame& brick_;
  float edge_;
  int count_ = 0;
  std::int32_t first_ = 0;
  double sigma_ = 0;
  double mass_ = 0, of_value_ = 0, of_color_ = 0, share_ = 0;
  Vec3 place_ = Vec3::Zero();
  Mat3 squares_ = Mat3::Zero();
  std::array<float, 3> lo_ = {kFar, kFar, kFar}, hi_ = {-kFar, -kFar, -kFar};
};

}  // namespace

std::int64_t project_brick(const KernelField& field, const view::KernelPlan& plan,
                           std::int64_t index, Merging merging, Splat* out) {
  const KernelSource& source = field.source();
  const BrickInFrame brick{field, plan, source.brick(index), source.acquire(index, 0.0)};
  const Splat* const first = out;
  const double least = least_sigma(brick);
  if (merging == Merging::kNone || source.shape() != KernelShape::kBalls ||
      brick.brick.least_sigma > least) {
    for (std::int32_t i = 0; i < brick.view.count; ++i) *out++ = splat_of(brick, i);
    return out - first;
  }
  Cluster cluster(brick, kMergedEdge * least);
  const auto finish = [&] {
    if (cluster.count() == 1) *out++ = splat_of(brick, cluster.first());
    if (cluster.count() > 1) *out++ = cluster.splat();
    cluster.clear();
  };
  for (std::int32_t i = 0; i < brick.view.count; ++i) {
    const double sigma = data::shape_numbers(brick.view, source.shape(), i)[0];
    const bool is_small = sigma <= least && data::weight_of(brick.view, i) > 0;
    if (!is_small || !cluster.has_room_for(i)) finish();
    if (is_small) {
      cluster.add(i, sigma);
    } else {
      *out++ = splat_of(brick, i);
    }
  }
  finish();
  return out - first;
}

}  // namespace ovoid::cpu
