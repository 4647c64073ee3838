// SPDX-License-Identifier: Apache-2.0
// A block of a kernel field: view::kBlockEdge^2 pixels x view::kBlockDepth sheets, in which splats
// are summed, and its subtiles, which keep the sheets of field values. It all lies in the L2 cache
// of one core.
//
//   channel   what is summed over splats: of normalized fields w v phi, w phi and, with a colour
//             of its own, w c phi; of sums v w phi and c v w phi
//   level     level l has a sample for every 2^l x 2^l pixels, at their middle. Sample i of a plane
//             of level l lies at the pixel 2^l (lo + i) + (2^l - 1) / 2 of the tile. Coarse planes
//             reach as far beyond the finer one as the filter that brings them there.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "render/cpu/kernels/filter_band.h"
#include "render/cpu/kernels/splat.h"
#include "render/cpu/lattice/block.h"
#include "render/shared/kernel_values.h"

namespace ovoid::cpu {

inline constexpr int kMaxChannels = 3;
inline constexpr int kMaxLevel = 6;  // 64 pixels per sample: a tile is one sample
static_assert(kMaxLevel + 1 == device::kNumLevels);
inline constexpr int kSubtiles = view::kBlockEdge / kTileSize;  // along one axis
inline constexpr int kPlanePadding = 64;  // floats: a group at a plane's end reads and writes on

// Floor of a / 2 and the half's number, for negative numbers too.
constexpr int half_of(int a) { return a >= 0 ? a / 2 : -((1 - a) / 2); }

// Samples [lo, lo + size) of a level, in its own numbers from the tile's corner.
struct LevelExtent {
  int lo = 0, size = 0, stride = 0;
};

// The filter reaches two samples against and three along the side on which the finer one lies.
constexpr std::array<LevelExtent, kMaxLevel + 1> level_extents() {
  std::array<LevelExtent, kMaxLevel + 1> extents{};
  int lo = -1;
  int hi = view::kBlockEdge;
  for (int level = 0; level <= kMaxLevel; ++level) {
    const int size = hi - lo + 1;
    extents[static_cast<std::size_t>(level)] = {lo, size, (size + 15) / 16 * 16};
    const int coarse_lo = half_of(lo) - (lo % 2 == 0 ? 3 : 2);
    const int coarse_hi = half_of(hi) + (hi % 2 == 0 ? 2 : 3);
    lo = coarse_lo;
    hi = coarse_hi;
  }
  return extents;
}
inline constexpr std::array<LevelExtent, kMaxLevel + 1> kLevelExtents = level_extents();

inline constexpr int kValueStride = kLevelExtents[0].stride;
inline constexpr int kValueRows = kLevelExtents[0].size;

// From level l + 1 to level l, along either axis.
using LevelBand = FilterBand<(kLevelExtents[0].size + 15) / 16 * 16, kLevelExtents[1].size>;
using LevelBands = std::array<LevelBand, kMaxLevel>;

// `how` is not kOff.
std::unique_ptr<LevelBands> level_bands(PostConvolution how);

inline constexpr std::uint32_t kAllSubtiles = (1U << (kSubtiles * kSubtiles)) - 1U;

// kTileSize^2 pixels of a block.
struct Subtile {
  TileState pixels;
  TileRays rays;
  TileLimits limits;
  SheetRing ring{kTilePlane};
};

// Which sheets of a block are wanted: [first, last).
struct SheetRun {
  int first = 0, last = 0;
};

struct KernelWorkspace {
  std::array<Subtile, kSubtiles * kSubtiles> subtiles;  // row by row
  BlockPlace place;                                     // of the subtile in hand
  ShadedSheet shaded;
  SampleBatch batch{};
  WorkerStats stats;

  // Subtiles of which some pixel takes samples of the block in hand, a bit each. Level 0 has no
  // sums elsewhere.
  std::uint32_t open_subtiles = kAllSubtiles;

  // [sheet of the block][channel][row][column], one buffer per level
  std::array<FloatBuffer, kMaxLevel + 1> levels;
  std::array<bool, kMaxLevel + 1> is_touched{};

  // Of frames with finds_cover: not 0 where a splat of a coarse level reaches the pixel. [sheet of
  // the block][row][column] as on level 0; there where a coarse level is touched.
  FloatBuffer cover;
  bool has_cover = false;
  std::array<bool, view::kBlockDepth> is_all_covered{};

  TileInHand in_hand(Subtile& subtile) {
    return {place, subtile.ring, subtile.pixels, shaded, batch, stats};
  }
};

// A subtile of a trail on the sheets of one layer of blocks.
struct TrailSheets {
  static constexpr int kNone = -1;

  int layer = kNone;  // kNone: nothing is there
  SheetRing ring{kTilePlane};
  // The share of the moments at which a sample has a value. [sheet of the layer][sample]
  alignas(64) float presence[view::kBlockDepth][kTilePlane.num_floats()];

  float* presence_on(int sheet) noexcept { return presence[sheet]; }
};

struct TrailWorkspace {
  KernelWorkspace sums;          // of one moment after the other
  SheetRing moment{kTilePlane};  // a sheet of it
  // By subtile: an even layer and an odd one, for a layer's last sheet is composited in the next.
  std::array<std::array<TrailSheets, 2>, kSubtiles * kSubtiles> sheets;
  // By subtile: the first sheet of the frame that has not joined the pixels.
  std::array<int, kSubtiles * kSubtiles> next;
};

// Of one tile. `trail`: null where the frame has none.
struct KernelTileWorkspace : KernelWorkspace {
  std::unique_ptr<TrailWorkspace> trail;
};

// One field of those whose mean is a trail.
struct MomentFrame {
  const struct KernelFrame* frame;
  float share;
};

// A frame of a kernel field.
struct KernelFrame : CpuFrame, KernelTraits {
  const view::KernelPlan* kernel_plan = nullptr;  // `plan`, as what it is
  const BinnedSplats* binned = nullptr;
  const std::uint8_t* is_visible = nullptr;       // per block: whether it can show
  std::unique_ptr<const LevelBands> level_bands;  // if there are levels
  // Behind the field, with the blocks of its plan; empty: none.
  std::vector<MomentFrame> trail;
};

}  // namespace ovoid::cpu
