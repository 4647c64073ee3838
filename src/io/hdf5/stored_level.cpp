// SPDX-License-Identifier: Apache-2.0
#include "io/hdf5/stored_level.h"

#include <cstdint>

#include "ovoid/lattice_file.h"

namespace ovoid {
namespace io {

StoredLevel::StoredLevel(const LatticeLevel& level)
    : weights({level.weights.begin(), level.weights.end()}) {
  std::vector<std::int64_t> between;
  std::int64_t before = -1;
  for (const std::int64_t node : level.nodes) {
    between.push_back(node - before - 1);
    before = node;
  }
  gaps = ShortNumbers(between);
}

ShortNumbers stored_holes(const LatticeLevels& levels) {
  return ShortNumbers({levels.holes.begin(), levels.holes.end()});
}

}  // namespace io

std::int64_t lattice_levels_bytes(const LatticeLevels& levels) {
  constexpr std::int64_t kOfFile = 6144;  // of groups and attributes, in blocks of 2 KiB
  std::int64_t sum = kOfFile;
  for (const LatticeLevel& level : levels.levels) {
    if (level.nodes.empty()) continue;
    const io::StoredLevel stored(level);
    sum += io::packed_bytes(stored.gaps) + io::packed_bytes(stored.weights);
  }
  if (!levels.holes.empty()) sum += io::packed_bytes(io::stored_holes(levels));
  return sum;
}

}  // namespace ovoid
