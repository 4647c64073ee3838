// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/merged_range.h"

namespace ovoid::data {

ValueRange merged_range(const BrickSource& source) noexcept {
  const Index3 cells = source.geometry().cells();
  const std::int64_t edge = source.brick_edge();
  ValueRange merged;
  for (std::int64_t bz = 0; bz * edge < cells[2]; ++bz) {
    for (std::int64_t by = 0; by * edge < cells[1]; ++by) {
      for (std::int64_t bx = 0; bx * edge < cells[0]; ++bx) {
        merge(merged, source.brick_range(bx, by, bz));
      }
    }
  }
  return merged;
}

}  // namespace ovoid::data
