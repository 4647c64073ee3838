// SPDX-License-Identifier: Apache-2.0
// Post-convolution of lattices: where a picture has many pixels per spacing, sheets are sampled at
// nodes some pixels apart, and pixels take their values and gradients from those by a separable
// filter.
//
//   node     node i of a sheet lies at pixel pitch * i of the picture, along both axes
//   patch    kPatchSize^2 pixels, or a quarter of that, whose tiles share nodes; with the filter's
//            reach at most kMaxNodes along each axis, so that nodes are the samples of a Block
//   filter   kNodeTaps nodes along each axis, those at -2 to +3 from the one at or before the pixel
#pragma once

#include <array>

#include "render/cpu/block.h"

namespace ovoid::cpu {

inline constexpr int kNodeTaps = 6;
inline constexpr int kTapsBefore = 2;
inline constexpr int kMaxNodes = kPlaneStride;

// Fewer pixels per node save nothing, for patches have more nodes than they have pixels over the
// pitch.
inline constexpr double kLeastPitch = 1.7;
inline constexpr double kGreatestPitch = 64.0;
// From here on a patch of kPatchSize has few enough nodes.
inline constexpr double kWholePatchPitch = 2.6;

// The filter for the kTileSize pixels of a tile along one axis, as a matrix.
struct NodeWeights {
  static constexpr int kMost = 20;
  int first = 0, count = 0;           // rows of `weight`: nodes of the patch
  std::array<int, kTileSize> taps{};  // of each pixel: its first node in the patch
  // Nodes of the list that have weight for any of eight neighbouring pixels.
  struct Range {
    int first, past;
  };
  std::array<Range, kTileSize / 8> of_eight{};
  alignas(64) float weight[kMost][kTileSize];
};

// `first_pixel` of the picture; `first_node` is the patch's.
NodeWeights node_weights(PostConvolution how, double pitch, int first_pixel,
                         std::int64_t first_node);

// Nodes along one axis that pixels [first, last] need.
struct NodeSpan {
  std::int64_t first = 0;
  int count = 0;
};
NodeSpan nodes_for(double pitch, int first_pixel, int last_pixel);

// What a worker needs beside the tile in hand.
struct LatticeWorkspace {
  Workspace pixels;
  Workspace nodes;
  std::array<TileState, kPatchTiles * kPatchTiles> tiles;  // row by row
  std::array<TileRays, kPatchTiles * kPatchTiles> rays;
  struct TileBits {
    std::array<RowBits, kMaxSheets> relevant;
    RowBits visible;  // on the sheet before
    bool any_relevant;
  };
  std::array<TileBits, kPatchTiles * kPatchTiles> bits;
};

}  // namespace ovoid::cpu
