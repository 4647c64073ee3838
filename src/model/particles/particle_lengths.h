// SPDX-License-Identifier: Apache-2.0
// How large a particle's kernel is: from its nearest neighbours, also across the faces of a
// periodic box.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "model/particles/kernel_parts.h"

namespace ovoid::model {

// What the nearest `options.neighbors` particles, itself counted, say of each.
struct NearestStatistics {
  std::vector<float> lengths;      // h: half the distance to the last of them; 0 in a heap
  std::vector<float> covariances;  // [n, 6] of their offsets: xx, yx, yy, zx, zy, zz over h^2
  std::int64_t num_pairs = 0;      // of sites that were compared: what the search cost
};

enum class WithCovariances { kNo, kYes };

// Sites [n, 3] in any order; in a periodic box, inside it.
NearestStatistics nearest_statistics(const ModelRun& run, std::span<const double> sites,
                                     const std::optional<Bounds3>& periodic_box,
                                     WithCovariances with);

// Heaps of particles at one place have h = 0; it becomes the least h that is not, or 1 if there is
// none. Counts them as degenerate.
void raise_zero_lengths(const ModelRun& run, std::vector<float>& lengths);

}  // namespace ovoid::model
