// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/lattice/nodes.h"

#include <cmath>

namespace ovoid::cpu {

NodeSpan nodes_for(double node_step, int first_pixel, int last_pixel) {
  const auto first = static_cast<std::int64_t>(std::floor(first_pixel / node_step)) - kTapsBefore;
  const auto last = static_cast<std::int64_t>(std::floor(last_pixel / node_step)) - kTapsBefore;
  return {first, static_cast<int>(last - first) + kFilterTaps};
}

NodeBand node_band(PostConvolution how, double node_step, int first_pixel,
                   std::int64_t first_node) {
  NodeBand band;
  band.first_input = static_cast<int>(
      nodes_for(node_step, first_pixel, first_pixel + kTileSize - 1).first - first_node);
  for (int x = 0; x < kTileSize; ++x) {
    const double place = (first_pixel + x) / node_step;
    const double before = std::floor(place);
    band.set_output(x, how, static_cast<int>(static_cast<std::int64_t>(before) - first_node),
                    place - before);
  }
  return band;
}

}  // namespace ovoid::cpu
