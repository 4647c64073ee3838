// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "data/kernels/letters.h"
#include "ovoid/field.h"
#include "ovoid/kernel_team.h"

namespace ovoid::data {

// The layers [first, end) of a lattice that this process looks at where all samples, or samples
// from everywhere, are asked for, and the team that looks at the others; null: nobody else does.
struct SharedLayers {
  std::int64_t first = 0, end = 0;
  KernelTeam* team = nullptr;

  // What all have found, in the order of the layers. All call it.
  template <class T>
  std::vector<T> of_all(std::vector<T> own) const {
    return team != nullptr ? joined(*team, std::span<const T>(own)) : own;
  }
};

SharedLayers shared_layers(const BrickSource& source);

}  // namespace ovoid::data
