// SPDX-License-Identifier: Apache-2.0
// How large a particle's kernel is: from its nearest neighbours, also across the faces of a
// periodic box.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "model/kernel_parts.h"

namespace ovoid::model {

// Sites [n, 3] in Morton order; in a periodic box, inside it.
struct ParticleSites {
  std::vector<double> centers;
  std::vector<std::uint32_t> sources;  // index in the dataset
  std::optional<Bounds3> periodic_box;

  std::size_t count() const noexcept { return sources.size(); }
  Vec3 center(std::size_t i) const noexcept {
    return {centers[3 * i], centers[3 * i + 1], centers[3 * i + 2]};
  }
};

// What the nearest `options.neighbors` particles, itself counted, say of each.
struct NearestStatistics {
  std::vector<float> lengths;      // h: half the distance to the last of them; 0 in a heap
  std::vector<float> covariances;  // [n, 6] of their offsets: xx, yx, yy, zx, zy, zz over h^2
};

enum class WithCovariances { kNo, kYes };

NearestStatistics nearest_statistics(const ModelRun& run, const ParticleSites& sites,
                                     WithCovariances with);

// Heaps of particles at one place have h = 0; it becomes the least h that is not, or 1 if there is
// none. Counts them as degenerate.
void raise_zero_lengths(const ModelRun& run, std::vector<float>& lengths);

}  // namespace ovoid::model
