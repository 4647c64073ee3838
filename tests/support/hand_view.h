// SPDX-License-Identifier: Apache-2.0
// Where pixels, sheets and nodes lie and what the published filters are, by docs/numerics.md and
// apart from every back end.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "ovoid/camera.h"
#include "ovoid/render_options.h"

namespace ovoid::test {

// docs/numerics.md, "The view lattice".
class HandView {
 public:
  HandView(const Camera& camera, const RenderOptions& options)
      : camera_(camera), width_(options.width), height_(options.height) {
    forward = (camera.focal_point - camera.position).normalized();
    right = forward.cross(camera.view_up).normalized();
    up = right.cross(forward);
    ds = options.sampling_distance;
  }

  Vec3 forward, right, up;
  double ds;

  double depth(std::int64_t sheet) const {
    return (camera_.focal_point - camera_.position).norm() +
           (static_cast<double>(sheet) + 0.5) * ds;
  }
  Vec3 direction(double x, double y) const {
    if (camera_.parallel_projection) return forward;
    return forward + std::tan(camera_.view_angle * std::numbers::pi / 360) * across(x, y);
  }
  Vec3 place(double x, double y, std::int64_t sheet) const {
    Vec3 origin = camera_.position;
    if (camera_.parallel_projection) origin += camera_.parallel_scale * across(x, y);
    return origin + depth(sheet) * direction(x, y);
  }
  // Pixels from node to node: a spacing on the last of 16 sheets.
  double node_step(const Mat3& index_from_world, std::int64_t sheet) const {
    std::int64_t last = sheet;
    while (((last + 1) % 16 + 16) % 16 != 0) ++last;
    const Vec3 origin = place(0, 0, last);
    const double step = std::max((index_from_world * (place(1, 0, last) - origin)).norm(),
                                 (index_from_world * (place(0, 1, last) - origin)).norm());
    return std::min(1 / step, 64.0);
  }
  double pixel_pitch(std::int64_t sheet) const {
    return (place(1, 0, sheet) - place(0, 0, sheet)).norm();
  }
  // Planes that keep the middle 0.8 of a sheet's slab.
  std::vector<ClipPlane> planes_around(std::int64_t sheet) const {
    const double middle = forward.dot(camera_.position) + depth(sheet);
    return {{forward, middle - 0.4 * ds}, {-forward, -middle - 0.4 * ds}};
  }

 private:
  Vec3 across(double x, double y) const {
    return (2 * (x + 0.5) / width_ - 1) * width_ / height_ * right +
           (1 - 2 * (y + 0.5) / height_) * up;
  }

  Camera camera_;
  int width_, height_;
};

inline double filter_by_hand(PostConvolution how, double distance) {
  const double x = std::abs(distance);
  if (how == PostConvolution::kBilinear) return std::max(1 - x, 0.0);
  if (how == PostConvolution::kGaussian) return x < 2 ? std::exp(-2 * x * x) : 0;
  if (x < 1) return 1.5 * std::pow(x, 3) - 2.5 * x * x + 1;
  return x < 2 ? -0.5 * std::pow(x, 3) + 2.5 * x * x - 4 * x + 2 : 0;
}

// The filtered sum of `of` over the samples of a grid around the place (x, y), in their numbers.
template <class Value>
Value filtered(PostConvolution how, double x, double y, Value zero,
               const std::function<Value(int, int)>& of) {
  Value sum = zero;
  double weights = 0;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  for (int j = y0 - 2; j <= y0 + 3; ++j) {
    for (int i = x0 - 2; i <= x0 + 3; ++i) {
      const double weight = filter_by_hand(how, x - i) * filter_by_hand(how, y - j);
      if (weight == 0) continue;
      sum += weight * of(i, j);
      weights += weight;
    }
  }
  return sum * (1 / weights);
}

}  // namespace ovoid::test
