// SPDX-License-Identifier: Apache-2.0
// Particles of a team of processes: who has which, and how far the neighbours of each are.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "model/kernel_parts.h"

namespace ovoid::model {

// Rows of numbers, which go from one process to another.
struct SiteRows {
  std::vector<std::uint64_t> orders;  // numbers among the rows of all; rising
  std::vector<double> centers;        // [n, 3]
  std::vector<std::vector<float>> columns;

  std::size_t count() const noexcept { return orders.size(); }
};

// Sends each row to the process that has this part of space: stretches of a Morton curve with about
// as many rows each. All call it, with as many columns. What lies at one place comes to one
// process.
SiteRows share_by_place(const ModelRun& run, SiteRows rows);

// The lengths of nearest_statistics() of the sites [n, 3] of all. `num_all`: how many these are.
// Those whose neighbours may be another process's are asked for there.
std::vector<float> team_lengths(const ModelRun& run, std::span<const double> sites,
                                std::int64_t num_all, const std::optional<Bounds3>& periodic_box);

}  // namespace ovoid::model
