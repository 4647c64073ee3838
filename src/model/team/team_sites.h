// SPDX-License-Identifier: Apache-2.0
// Particles of a team of processes: who has which, and how far the neighbours of each are.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "data/kernels/kernel_bricks.h"
#include "model/particles/kernel_parts.h"

namespace ovoid::model {

// Which process has which part of space: stretches of a Morton curve with about as many of the
// sites each. What lies at one place is one process'; what has no finite place is the first's.
class SpaceShares {
 public:
  // The sites [n, 3] of all. All call it.
  SpaceShares(const ModelRun& run, std::span<const double> sites);

  int owner_of(const Vec3& place) const { return owner_of_key(key_of(place)); }
  // By site.
  const std::vector<int>& owners() const noexcept { return owners_; }

 private:
  std::uint64_t key_of(const Vec3& place) const;
  int owner_of_key(std::uint64_t key) const;

  std::optional<data::MortonCube> cube_;
  std::vector<std::uint64_t> begins_;
  std::vector<int> owners_;
};

// Rows of numbers, which go from one process to another.
struct SiteRows {
  std::vector<std::uint64_t> orders;  // numbers among the rows of all; rising
  std::vector<double> centers;        // [n, 3]
  std::vector<double> edges;          // [n, 3], or of no process any
  std::vector<std::vector<float>> columns;

  std::size_t count() const noexcept { return orders.size(); }
};

// Sends each row to the process that has its part of space (SpaceShares). All call it, with as many
// columns.
SiteRows share_by_place(const ModelRun& run, SiteRows rows);

// The lengths of nearest_statistics() of the sites [n, 3] of all. `num_all`: how many these are.
// Those whose neighbours may be another process's are asked for there.
std::vector<float> team_lengths(const ModelRun& run, std::span<const double> sites,
                                std::int64_t num_all, const std::optional<Bounds3>& periodic_box);

}  // namespace ovoid::model
