// SPDX-License-Identifier: Apache-2.0
#include "model/particles/kernel_groups.h"

#include <algorithm>

#include "model/particles/site_order.h"

namespace ovoid::model {

KernelGroups::KernelGroups(std::span<const double> centers, std::span<const float> shapes,
                           double cutoff, int threads)
    : most_(static_cast<float>(cutoff * cutoff)),
      at_end_(std::exp(-0.5F * most_)),
      order_(morton_order(centers, threads)) {
  const std::size_t num_groups = (order_.size() + kGroup - 1) / kGroup;
  groups_.resize(num_groups);
  levels_.emplace_back(num_groups);
  center_boxes_.resize(num_groups);
  for (std::size_t g = 0; g < num_groups; ++g) fill(g, centers, shapes, cutoff);
  while (levels_.back().size() > 1) {
    std::vector<Bounds3> above((levels_.back().size() + kFanOut - 1) / kFanOut);
    for (std::size_t i = 0; i < levels_.back().size(); ++i)
      above[i / kFanOut].extend(levels_.back()[i]);
    levels_.push_back(std::move(above));
  }
}

void KernelGroups::fill(std::size_t g, std::span<const double> centers,
                        std::span<const float> shapes, double cutoff) {
  Group& group = groups_[g];
  const std::size_t first = g * kGroup;
  group.count = std::min(kGroup, order_.size() - first);
  const auto center = [&](std::size_t i) {
    const double* const at = centers.data() + std::size_t{3} * order_[first + i];
    return Vec3(at[0], at[1], at[2]);
  };
  for (std::size_t i = 0; i < group.count; ++i) {
    const float* const l = shapes.data() + std::size_t{6} * order_[first + i];
    const Vec3 at = center(i);
    center_boxes_[g].extend(at);
    for (std::size_t a = 0; a < 3; ++a) group.center[a][i] = at[static_cast<int>(a)];
    group.per_diagonal[0][i] = 1 / l[0];
    group.per_diagonal[1][i] = 1 / l[2];
    group.per_diagonal[2][i] = 1 / l[5];
    group.below[0][i] = l[1];
    group.below[1][i] = l[3];
    group.below[2][i] = l[4];
    const Vec3 reach =
        cutoff * Vec3(std::abs(l[0]), std::hypot(l[1], l[2]), std::hypot(l[3], l[4], l[5]));
    levels_[0][g].extend(Bounds3(at - reach, at + reach));
  }
}

void KernelGroups::find_below(std::size_t level, std::size_t node, const Bounds3& box,
                              std::vector<std::uint32_t>& near) const {
  if (!levels_[level][node].intersects(box)) return;
  if (level == 0) {
    near.push_back(static_cast<std::uint32_t>(node));
    return;
  }
  const std::size_t end = std::min((node + 1) * kFanOut, levels_[level - 1].size());
  for (std::size_t child = node * kFanOut; child < end; ++child)
    find_below(level - 1, child, box, near);
}

void KernelGroups::find_squares(std::size_t g, const Vec3& place, Squares& squares) const {
  const Group& group = groups_[g];
  const double x = place[0], y = place[1], z = place[2];
  for (std::size_t i = 0; i < kGroup; ++i) {
    const auto dx = static_cast<float>(x - group.center[0][i]);
    const auto dy = static_cast<float>(y - group.center[1][i]);
    const auto dz = static_cast<float>(z - group.center[2][i]);
    const float a = dx * group.per_diagonal[0][i];
    const float b = (dy - group.below[0][i] * a) * group.per_diagonal[1][i];
    const float c = (dz - group.below[1][i] * a - group.below[2][i] * b) * group.per_diagonal[2][i];
    squares[i] = a * a + b * b + c * c;
  }
}

}  // namespace ovoid::model
