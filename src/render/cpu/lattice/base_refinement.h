// SPDX-License-Identifier: Apache-2.0
// A magnified base plane from few samples (docs/numerics.md, "Lattice sheets"): first every n-th
// sample of every n-th row is drawn, then those halfway between, and so on; but where the picture
// that there is so far is smooth, they are interpolated.
#pragma once

#include <cstddef>
#include <vector>

#include "ovoid/image.h"
#include "render/cpu/lattice/block.h"
#include "render/cpu/runner.h"
#include "view/plan/base_plane.h"

namespace ovoid::cpu {

// Samples of a picture that are to be drawn.
class SampleMask {
 public:
  SampleMask(int width, int height);

  // Of the tile at a sample: its rows of samples, one after the other.
  const RowWord* of_tile(int x, int y) const noexcept { return &rows_[first_row(x, y)]; }
  bool is_empty(int x, int y) const noexcept;
  // Threads may add samples of different tiles.
  void add(int x, int y) noexcept {
    rows_[first_row(x, y) + static_cast<std::size_t>(y % kTileSize)] |= RowWord{1}
                                                                        << (x % kTileSize);
  }

 private:
  std::size_t first_row(int x, int y) const noexcept {
    return (static_cast<std::size_t>(y / kTileSize) * tiles_across_ +
            static_cast<std::size_t>(x / kTileSize)) *
           kTileSize;
  }

  std::size_t tiles_across_;
  std::vector<RowWord> rows_;  // [tiles][kTileSize]
};

// The base plane of every n-th sample.
view::BasePlane every_nth_sample(const view::BasePlane& base, int n);

// Fills in `picture`, of which `few` has every other sample of every other row, where that is
// smooth, and returns which samples are left. `sheet_distance`: depths that are many sheets apart
// are of different things, and have nothing between them.
SampleMask interpolate_smooth(const Image& few, double sheet_distance, Image& picture,
                              Runner& runner);

}  // namespace ovoid::cpu
