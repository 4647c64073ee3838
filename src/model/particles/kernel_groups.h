// SPDX-License-Identifier: Apache-2.0
// Gaussian ellipsoids in small groups of neighbours: which of them reach a place.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ovoid/math.h"

namespace ovoid::model {

// Kernels lie in groups of kGroup along a Morton curve. A tree over the boxes of the groups'
// supports finds the groups whose kernels may reach a box of places; against each of those a place
// is tested in one loop that the compiler turns into SIMD code. Only the few kernels that do reach
// a place cost an exponential. What a kernel is at a place does not depend on its group, so that
// processes which group other kernels find the same. Immutable; any number of threads may ask at
// once.
class KernelGroups {
 public:
  static constexpr std::size_t kGroup = 32;
  using Squares = std::array<float, kGroup>;

  // `centers` [n, 3]; `shapes` [n, 6], as KernelShape::kEllipsoids says. Borrowed for the call.
  KernelGroups(std::span<const double> centers, std::span<const float> shapes, double cutoff,
               int threads);

  std::size_t count() const noexcept { return groups_.size(); }
  std::size_t size_of(std::size_t group) const noexcept { return groups_[group].count; }
  // The kernel that is the `i`th of a group.
  std::uint32_t kernel(std::size_t group, std::size_t i) const noexcept {
    return order_[group * kGroup + i];
  }
  const Bounds3& centers_of(std::size_t group) const noexcept { return center_boxes_[group]; }
  bool may_reach(std::size_t group, const Vec3& place) const {
    return levels_[0][group].contains(place);
  }

  // Appends the groups of which a kernel may reach a place in the box.
  void find_near(const Bounds3& box, std::vector<std::uint32_t>& near) const {
    find_below(levels_.size() - 1, 0, box, near);
  }

  // The squares of the place's Mahalanobis distances from a group's kernels.
  void find_squares(std::size_t group, const Vec3& place, Squares& squares) const;

  // profile_value() of a kernel whose square of the distance is `square`, at most most_square().
  float most_square() const noexcept { return most_; }
  float profile(float square) const noexcept {
    return std::exp(-0.5F * square) - at_end_ * (1 + 0.5F * (most_ - square));
  }

 private:
  static constexpr std::size_t kFanOut = 8;

  struct Group {
    std::size_t count = 0;
    std::array<std::array<double, kGroup>, 3> center{};
    std::array<Squares, 3> per_diagonal{};  // reciprocals of the factor's diagonal
    std::array<Squares, 3> below{};         // what is below it: yx, zx, zy
  };

  void fill(std::size_t g, std::span<const double> centers, std::span<const float> shapes,
            double cutoff);
  void find_below(std::size_t level, std::size_t node, const Bounds3& box,
                  std::vector<std::uint32_t>& near) const;

  float most_, at_end_;
  std::vector<std::uint32_t> order_;
  std::vector<Group> groups_;
  std::vector<Bounds3> center_boxes_;
  std::vector<std::vector<Bounds3>> levels_;  // [0]: of the groups' supports
};

}  // namespace ovoid::model
