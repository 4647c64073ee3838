// SPDX-License-Identifier: Apache-2.0
// A block: one rectangle of pixels inside a tile x some consecutive sheets, the unit of work; and
// what the stages that both kinds of field share work on. It all stays in the L2 cache. One worker
// owns one workspace and uses it for tile after tile.
//
//   plane      the samples of one sheet (sheets.h). Sample (0, 0) of a plane is pixel (x0 - margin,
//              y0 - margin): central differences need a margin of 1, else it is 0. Or they are
//              nodes (nodes.h), of which more fit than a tile has pixels.
//   row bits   one bit per sample of a plane's row, bit x for sample x
#pragma once

#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>

#include "data/out_of_memory.h"
#include "render/cpu/frame.h"
#include "render/cpu/shade/sample_batch.h"
#include "render/cpu/sheets.h"

namespace ovoid::cpu {

inline constexpr int kBlockSheets = 16;                           // sheets, before splitting
inline constexpr int kMaxSheets = kBlockSheets + 3 * kMaxMargin;  // two in front

// Where one sheet of a block lies.
struct SheetPlace {
  float depth;
  float inverse_pitch;  // 1 / (distance of neighbouring samples times FramePlan::gradient_unit)
  float near_cut;       // where the slab begins: -1/2, or later behind the near plane, in sheets
};

struct TileRays;
struct TileLimits;

// Where a block lies in the picture. Its sheets have numbers from 0; sheet s is sheet first_sheet +
// s of the frame.
struct BlockPlace {
  int tile_x, tile_y;        // pixel of the tile's corner in the picture
  int x0, y0, x1, y1;        // pixels of the tile
  int margin;                // samples around them
  int rows, columns;         // of a plane: y1 - y0 + 2 margin, x1 - x0 + 2 margin
  std::int64_t first_sheet;  // of sheet 0 of the block, margin sheets included
  int num_sheets;            // margin sheets included
  int front_margin, back_margin;
  const TileRays* rays;  // of the tile; unused in parallel projection
  TileLimits* limits;    // of the tile; null: none
  SheetPlace sheets[kMaxSheets];

  std::int64_t number_of(int s) const noexcept { return first_sheet + s; }
};

// The tile's pixels so far, front to back; index y * kTileSize + x. Premultiplied.
struct alignas(64) TileState {
  // A group at a row's end reads and writes back what follows.
  static constexpr int kPixels = kTileSize * kTileSize + 16;
  float red[kPixels], green[kPixels], blue[kPixels], alpha[kPixels], depth[kPixels];
  float front_depth[kPixels];  // of what is composited; others have it when they are finished
  float best[kPixels];         // maximum, minimum: that value; xray and mean: sum of value * path
  float path[kPixels];         // mean: sum of path
  RowWord seen[kTileSize];     // xray, maximum, minimum, mean: a sample was defined
  RowWord open[kTileSize];     // still takes samples

  void reset(int width, int height) {
    std::memset(this, 0, sizeof *this);
    std::fill(depth, depth + kPixels, std::numeric_limits<float>::infinity());
    std::fill(front_depth, front_depth + kPixels, std::numeric_limits<float>::infinity());
    std::fill(best, best + kPixels, -std::numeric_limits<float>::infinity());
    for (int y = 0; y < height; ++y) open[y] = first_bits(width);
  }
  bool any_open(int x0, int y0, int x1, int y1) const {
    RowWord any = 0;
    for (int y = y0; y < y1; ++y) any |= open[y];
    return (any >> x0 & first_bits(x1 - x0)) != 0;
  }
};

// The rays of a tile's pixels in perspective; index as in TileState.
struct alignas(64) TileRays {
  float length[TileState::kPixels];  // per unit of depth
  float eye[3][TileState::kPixels];  // direction to the eye, unit length
};

// Where a tile's pixels stand among the stops of the frame's depth limits; index as in TileState.
struct alignas(64) TileLimits {
  float enter[TileState::kPixels], leave[TileState::kPixels];  // depths of the span in hand
  // The same where the field itself ends there; beyond all depths at a seam.
  float begins[TileState::kPixels], ends[TileState::kPixels];
  std::uint32_t span[TileState::kPixels];   // the stop at which it begins
  std::uint32_t shown[TileState::kPixels];  // the first stop that has not joined the pixel
  std::uint32_t end[TileState::kPixels];    // behind the pixel's last stop
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
  std::int64_t multiply_adds = 0;  // of values and gradients
  std::int64_t kernels_loaded = 0;
  std::int64_t bytes_loaded = 0;  // of samples as they are stored
  std::int64_t blocks_total = 0, blocks_drawn = 0, skipped_empty = 0, skipped_irrelevant = 0,
               skipped_opaque = 0;
  std::array<std::uint64_t, kNumStages> ticks{};
};

// The classified samples of one sheet; index y * kTilePlane.stride + x.
struct ShadedSheet {
  alignas(64) float alpha[kTilePlane.num_floats()];
  alignas(64) float red[kTilePlane.num_floats()];
  alignas(64) float green[kTilePlane.num_floats()];
  alignas(64) float blue[kTilePlane.num_floats()];
  RowBits visible;
};

// A tile as the stages from classification on see it, whatever its field is.
struct TileInHand {
  const BlockPlace& place;
  SheetRing& ring;
  TileState& pixels;
  ShadedSheet& shaded;
  SampleBatch& batch;  // empty between sheets
  WorkerStats& stats;
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

}  // namespace ovoid::cpu
