// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "ovoid/kernel_field.h"
#include "ovoid/kernel_team.h"

namespace ovoid::data {

// What all processes know of a set whose kernels they share.
struct TeamSet {
  KernelShape shape = KernelShape::kBalls;
  KernelProfile profile = KernelProfile::kGaussian;
  double cutoff = 4;
  // `range`: of values that kernels here stand for, beside their own.
  std::vector<KernelAttribute> attributes;
};

// The bricks of all, those of the first process first. `own`: of this one; null: it has none. All
// call it. Others' bricks are fetched some at a time, and kept up to so many bytes. Throws what the
// team throws; acquire() does, too.
std::shared_ptr<const KernelSource> make_team_source(TeamSet set,
                                                     std::shared_ptr<const KernelSource> own,
                                                     const std::shared_ptr<KernelTeam>& team,
                                                     std::int64_t kept_bytes);

}  // namespace ovoid::data
