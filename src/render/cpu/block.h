// SPDX-License-Identifier: Apache-2.0
// A block: one rectangle of pixels inside a tile x some consecutive sheets, the unit of work.
// Everything a worker needs lies here and in TileState; both stay in the L2 cache. One worker owns
// one Workspace and uses it for tile after tile.
//
//   plane      the samples of one sheet: kMaxPlaneRows rows of kPlaneStride. Sample (0, 0) of a
//              plane is pixel (x0 - margin, y0 - margin): central differences need a margin of 1,
//              else it is 0. Or they are nodes (nodes.h), of which more fit than a tile has pixels.
//   row bits   one bit per sample of a plane's row, bit x for sample x
//   region     the box of lattice samples that the block's active samples reach, as floats, zero
//              where no kernel exists; one such box of every sublattice
#pragma once

#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>

#include "data/out_of_memory.h"
#include "render/cpu/frame.h"

namespace ovoid::cpu {

inline constexpr int kTileSize = 16;  // pixels: the largest SIMD group is 16 lanes, and a cube of
                                      // 16^3 samples reads few kernels twice
inline constexpr int kBlockSheets = 16;  // sheets, before splitting
inline constexpr int kMaxMargin = 1;
// Floats: a row of bits has that many and more. Not a power of two, for the rows of ten planes to
// share the L1 cache.
inline constexpr int kPlaneStride = 56;
inline constexpr int kMaxPlaneRows = kPlaneStride;
inline constexpr int kPatchTiles = 4;  // tiles along a side of a patch, which share nodes (nodes.h)
inline constexpr int kPatchSize = kPatchTiles * kTileSize;
inline constexpr int kMaxSheets = kBlockSheets + 2 * kMaxMargin;
inline constexpr int kRingSheets = 4;  // planes kept at a time: sheet s lives in plane s & 3
inline constexpr int kTapPadding =
    16;  // floats readable beyond a region's row, so that a vector of taps may overrun
inline constexpr int kRegionBeyond =
    2;  // samples: how far regions go beyond the lattice, for four taps at its faces
inline constexpr std::int64_t kMaxRegionSamples =
    72 * 1024;  // 288 KiB of floats, over half an L2 cache: larger blocks are split

using RowWord = std::uint64_t;  // bit x for sample x
using RowBits = std::array<RowWord, kMaxPlaneRows>;

// What one sheet of a block looks like from the samples: index position relative to the block's
// origin, u = base + x per_x + y per_y for sample (x, y) of the plane, and how kernels are widened
// there.
struct SheetSetup {
  float base[3], per_x[3], per_y[3];
  float step[3], step_per_x[3], step_per_y[3];  // change of u over one sheet along the ray: step +
                                                // x step_per_x + y step_per_y
  float widening[3];
  float depth;
  float inverse_pitch;  // 1 / distance of neighbouring samples, world
  float near_cut;       // where the slab begins: -1/2, or later behind the near plane, in sheets
};

// The tile's pixels so far, front to back; index y * kTileSize + x. Premultiplied.
struct alignas(64) TileState {
  // A group at a row's end reads and writes back what follows.
  static constexpr int kPixels = kTileSize * kTileSize + 16;
  float red[kPixels], green[kPixels], blue[kPixels], alpha[kPixels], depth[kPixels];
  float best[kPixels];            // maximum: greatest value; xray and mean: sum of value * path
  float path[kPixels];            // mean: sum of path
  std::uint32_t seen[kTileSize];  // row bits: xray, maximum, mean: a sample was defined
  std::uint32_t open[kTileSize];  // row bits: still takes samples

  void reset(int width, int height) {
    std::memset(this, 0, sizeof *this);
    std::fill(depth, depth + kPixels, std::numeric_limits<float>::infinity());
    std::fill(best, best + kPixels, -std::numeric_limits<float>::infinity());
    for (int y = 0; y < height; ++y) open[y] = (1U << width) - 1U;
  }
  bool any_open(int x0, int y0, int x1, int y1) const {
    std::uint32_t any = 0;
    for (int y = y0; y < y1; ++y) any |= open[y];
    return (any >> x0 & ((1U << (x1 - x0)) - 1U)) != 0;
  }
};

// The rays of a tile's pixels in perspective; index as in TileState.
struct alignas(64) TileRays {
  float length[TileState::kPixels];  // per unit of depth
  float eye[3][TileState::kPixels];  // direction to the eye, unit length
};

// Pixels of the picture, half open.
struct TileRect {
  int x0, y0, x1, y1;
};

// Counts and times of one worker.
enum StageIndex { kBin, kLoad, kReconstruct, kGradient, kShade, kComposite, kNumStages };
inline constexpr std::array<const char*, kNumStages> kStageNames = {
    "bin", "load", "reconstruct", "gradient", "shade", "composite"};

struct WorkerStats {
  std::int64_t samples_reconstructed = 0, samples_shaded = 0, gradients = 0;
  std::int64_t kernels_loaded = 0;
  std::int64_t blocks_total = 0, blocks_drawn = 0, skipped_empty = 0, skipped_irrelevant = 0,
               skipped_opaque = 0;
  std::array<std::uint64_t, kNumStages> ticks{};
};

struct Block {
  // Where
  int tile_x, tile_y;        // pixel of the tile's corner in the picture
  int x0, y0, x1, y1;        // pixels of the tile
  int margin;                // samples around them
  int rows, columns;         // of a plane: y1 - y0 + 2 margin, x1 - x0 + 2 margin
  std::int64_t first_sheet;  // of sheet 0 of the block, margin sheets included
  int num_sheets;            // margin sheets included
  int front_margin, back_margin;
  const TileRays* rays;    // of the tile; unused in parallel projection
  std::int64_t origin[3];  // index position to which SheetSetup's are relative
  SheetSetup sheets[kMaxSheets];

  // Which samples: to be reconstructed, and to be classified (a subset; equal without margin)
  RowBits active[kMaxSheets];
  RowBits relevant[kMaxSheets];

  // The region, relative to `origin`
  int region_lo[3], region_size[3];
  int row_stride, slice_stride;      // samples
  std::ptrdiff_t sublattice_stride;  // floats from a sublattice's samples to the next one's
  bool is_interior;                  // every tap of every active sample exists
  bool has_missing;
  bool uses_four_taps;  // the region is stored as pairs of slices (load-inl.h)

  // The ring of planes
  alignas(64) float values[kRingSheets][kMaxPlaneRows * kPlaneStride];
  RowBits defined[kRingSheets];

  // One sheet's classified samples; index y * kPlaneStride + x
  alignas(64) float sample_alpha[kMaxPlaneRows * kPlaneStride];
  alignas(64) float sample_red[kMaxPlaneRows * kPlaneStride];
  alignas(64) float sample_green[kMaxPlaneRows * kPlaneStride];
  alignas(64) float sample_blue[kMaxPlaneRows * kPlaneStride];
  RowBits visible;       // until a sheet is classified: of the sheet before, for a guess
  RowBits has_gradient;  // samples of the sheet in hand whose gradient is known
  alignas(64) float gradient[3][kMaxPlaneRows * kPlaneStride];  // world
};

// Memory that grows to the largest block seen and is reused. Throws Error(kOutOfMemory).
struct FloatBuffer {
  hwy::AlignedFreeUniquePtr<float[]> data;
  std::size_t capacity = 0;
  float* reserve(std::size_t count) {
    if (count > capacity) {
      capacity = 0;
      data.reset();  // before the next is there: the content is not kept
      data = hwy::AllocateAligned<float>(count);
      if (data == nullptr)
        ovoid::data::throw_out_of_memory("a block of samples", count * sizeof(float));
      capacity = count;
    }
    return data.get();
  }
};

struct Workspace {
  Block block;
  TileState* tile = nullptr;        // the one in hand
  const float* samples = nullptr;   // region: values, 0 where missing
  const float* presence = nullptr;  // region: 1 where a kernel exists, else 0; only if has_missing
  FloatBuffer sample_memory, presence_memory;  // where they are, unless they are shared
  FloatBuffer taps;                            // general gathering: weights of one sample
  FloatBuffer splats;                          // scatter: numerators and denominators of all sheets
  WorkerStats stats;
};

}  // namespace ovoid::cpu
