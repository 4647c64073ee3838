// SPDX-License-Identifier: Apache-2.0
// Sites in small groups of neighbours, for searches that ask for every site's neighbours: what lies
// around a group is looked up once for all of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "ovoid/math.h"

namespace ovoid::model {

// The square of a place's distance from a box, 0 inside it. Eigen's own goes by branches, which are
// mispredicted half of the time.
inline double square_from(const Bounds3& box, const Vec3& at) {
  return (box.min() - at).cwiseMax(at - box.max()).cwiseMax(0.0).squaredNorm();
}
inline double square_between(const Bounds3& a, const Bounds3& b) {
  return (a.min() - b.max()).cwiseMax(b.min() - a.max()).cwiseMax(0.0).squaredNorm();
}

// A balanced k-d tree whose leaves are the groups. Immutable; any number of threads may ask at
// once. Memory: 32 bytes per site. Cost: n log n.
class SiteGroups {
 public:
  struct Site {
    Vec3 at;
    std::uint32_t index;  // in the list given
  };

  // A box and the sites in it.
  struct Group {
    Bounds3 box;
    std::span<const Site> sites;
    std::size_t number = 0;  // of a group: from 0 to count() - 1
  };

  static constexpr std::size_t kMostInGroup = 32;  // of 8 to 64, the fastest for 32 neighbours

  // At least one site [n, 3]. Throws Error(kCancelled).
  SiteGroups(std::span<const double> sites, int threads, const std::stop_token& stop);

  std::size_t num_sites() const noexcept { return sites_.size(); }
  std::size_t count() const noexcept { return num_groups_; }
  Group group(std::size_t index) const { return node(num_groups_ + index); }

  // Calls visit(const Group&) for the groups for which is_wanted(square), asked when their turn
  // comes, is true of the square of their box's distance from `box`; the nearer half of each part
  // first. Whoever wants a square must want every smaller one.
  template <class IsWanted, class Visit>
  void visit_near(const Bounds3& box, const IsWanted& is_wanted, const Visit& visit) const {
    if (is_wanted(square_to(1, box))) visit_below(1, box, is_wanted, visit);
  }

 private:
  // Node 1 is the whole, 2 i and 2 i + 1 are the halves of i, the groups are the last.
  Group node(std::size_t index) const;

  double square_to(std::size_t index, const Bounds3& box) const {
    return square_between(boxes_[index], box);
  }

  template <class IsWanted, class Visit>
  void visit_below(std::size_t index, const Bounds3& box, const IsWanted& is_wanted,
                   const Visit& visit) const {
    if (index >= num_groups_) return visit(node(index));
    std::size_t near = 2 * index, far = near + 1;
    double near_square = square_to(near, box), far_square = square_to(far, box);
    if (far_square < near_square) {
      std::swap(near, far);
      std::swap(near_square, far_square);
    }
    if (is_wanted(near_square)) visit_below(near, box, is_wanted, visit);
    if (is_wanted(far_square)) visit_below(far, box, is_wanted, visit);
  }

  std::size_t num_groups_ = 1;  // a power of two
  std::vector<Site> sites_;
  std::vector<Bounds3> boxes_;  // by node
};

}  // namespace ovoid::model
