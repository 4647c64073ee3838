// SPDX-License-Identifier: Apache-2.0
// Post-convolution of lattices: where a picture has many pixels per spacing, sheets are sampled at
// nodes some pixels apart, and pixels take their values and gradients from those.
//
//   node     node i of a sheet lies at pixel node_step * i of the picture, along both axes
//   patch    kPatchSize^2 pixels, whose tiles share nodes. The nodes of a patch, those that the
//            filter reaches and a margin for differences included, are along each axis at most as
//            many as a Block has samples.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "ovoid/scene.h"
#include "render/cpu/kernels/filter_band.h"
#include "render/cpu/lattice/lattice_block.h"

namespace ovoid::cpu {

static_assert(view::kNodeSheets <= kBlockSheets);
static_assert((kPatchSize - 1) / view::kLeastNodeStep + 1 + kFilterTaps + 2 * kMaxMargin <=
              kPlaneStride);

// From a patch's nodes to the pixels of one of its tiles, along one axis.
inline constexpr int kMostNodesOfTile =
    static_cast<int>((kTileSize - 1) / view::kLeastNodeStep) + 1 + kFilterTaps;
using NodeBand = FilterBand<kTileSize, kMostNodesOfTile>;
NodeBand node_band(PostConvolution how, double node_step, int first_pixel, std::int64_t first_node);

// Those of a patch, by the tiles' columns and rows.
struct TileBands {
  const NodeBand& x;
  const NodeBand& y;
};
struct PatchBands {
  NodeBand x[kPatchTiles], y[kPatchTiles];

  TileBands of_tile(int column, int row) const noexcept { return {x[column], y[row]}; }
};

// Nodes along one axis.
struct NodeSpan {
  std::int64_t first = 0;
  int count = 0;
};
// Those that pixels [first, last] take their values from.
NodeSpan nodes_for(double node_step, int first_pixel, int last_pixel);

// The fields of a frame that are mixed.
inline constexpr std::size_t kMostLayers = Scene::kMaxVolumes;

// What several fields show, to be mixed.
struct MixedSamples {
  // Of each layer the number of a run in its batch; -1: none. The runs are of the same pixels and
  // steps.
  using Run = std::array<int, kMostLayers>;

  int num_runs = 0;
  std::array<Run, kMostLayers * SampleBatch::kSamples> runs;
  SampleBatch batch{};   // a run that has been mixed
  ShadedSheet shaded{};  // a sheet that has been
};

// What a worker needs beside the tile in hand.
struct LatticeWorkspace {
  Workspace pixels{kTilePlane};
  Workspace nodes{kNodePlane};
  std::vector<std::unique_ptr<Workspace>> beside;          // of LatticeFrame::beside
  std::unique_ptr<MixedSamples> mixed;                     // if the frame is mixed
  std::array<TileState, kPatchTiles * kPatchTiles> tiles;  // row by row
  std::array<TileRays, kPatchTiles * kPatchTiles> rays;
  std::array<TileLimits, kPatchTiles * kPatchTiles> limits;
  struct TileBits {
    // By the sheets of the nodes' block; what is active is known where pixels are binned.
    std::array<RowBits, kMaxSheets> relevant, active;
    RowBits visible;  // on the sheet before, if any were
    bool any_relevant, any_visible;
  };
  std::array<TileBits, kPatchTiles * kPatchTiles> bits;
  alignas(64) float node_sums[kMaxPlaneRows * kPlaneStride];  // x-ray, mean: over sheets
};

}  // namespace ovoid::cpu
