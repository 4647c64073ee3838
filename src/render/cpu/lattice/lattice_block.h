// SPDX-License-Identifier: Apache-2.0
// A block of a lattice field: which of its samples can show, and the part of the lattice that they
// read.
//
//   region     the box of lattice samples that the block's active samples reach, as floats, zero
//              where no kernel exists; one such box of every sublattice
#pragma once

#include <algorithm>

#include "render/cpu/lattice/block.h"
#include "render/cpu/lattice/lattice_frame.h"
#include "view/plan/base_plane.h"

namespace ovoid::cpu {

// The most samples that a plane has: of nodes. Not a power of two, for the rows of ten planes to
// share the L1 cache.
inline constexpr int kPlaneStride = kMaxPlaneRows;
inline constexpr PlaneShape kNodePlane{kMaxPlaneRows, kPlaneStride};
inline constexpr int kPatchTiles = 2;  // tiles along a side of a patch, which share nodes (nodes.h)
inline constexpr int kPatchSize = kPatchTiles * kTileSize;
// Floats readable beyond a region's row, so that a vector of taps may overrun.
inline constexpr int kTapPadding = 16;
// Samples: how far regions go beyond the lattice, for four taps at its faces.
inline constexpr int kRegionBeyond = 2;
inline constexpr std::int64_t kMaxRegionSamples =
    72 * 1024;  // 288 KiB of floats, over half an L2 cache: larger blocks are split

// One sheet of a block in the lattice: index position relative to the region's origin,
// u = base + x per_x + y per_y for sample (x, y) of the plane, how u changes over one sheet along
// the ray, step + x step_per_x + y step_per_y, and how kernels are widened there.
struct SheetInLattice {
  float base[3], per_x[3], per_y[3];
  float step[3], step_per_x[3], step_per_y[3];
  float widening[3];
};

// Which samples of a block are to be reconstructed, and which of them are to be classified (all,
// without a margin). Where pieces are refined, relevant are the pieces that end at the samples.
struct SampleBits {
  RowBits active[kMaxSheets];
  RowBits relevant[kMaxSheets];
};

struct Region {
  std::int64_t origin[3];            // index position to which all others of a block are relative
  int lo[3], size[3];                // samples
  int row_stride, slice_stride;      // samples
  std::ptrdiff_t sublattice_stride;  // floats from a sublattice's samples to the next one's
  bool is_interior;                  // every tap of every active sample exists
  bool has_missing;
  bool uses_four_taps;    // every sample reads four taps an axis
  bool is_paired;         // stored as pairs of slices (load-inl.h)
  const float* samples;   // 0 where missing
  const float* presence;  // 1 where a kernel exists, else 0; only if has_missing

  std::int64_t num_samples() const { return std::int64_t{size[0]} * size[1] * size[2]; }
};

struct Block {
  BlockPlace place;
  SheetInLattice sheets[kMaxSheets];
  SampleBits bits;
  Region region;

  // True if kernels are wider than their own on one of the sheets.
  bool widens_kernels() const noexcept {
    return std::any_of(sheets, sheets + place.num_sheets, [](const SheetInLattice& sheet) {
      const float* w = sheet.widening;
      return w[0] != 1.0F || w[1] != 1.0F || w[2] != 1.0F;
    });
  }
};

// Samples of a plane: those from (x0, y0) to before (x1, y1).
struct SampleBounds {
  int x0 = kTileSize, x1 = 0, y0 = kTileSize, y1 = 0;

  bool is_empty() const noexcept { return x0 >= x1; }
};

// The weights that samples share along one axis: [tap][sample].
struct SharedTaps {
  alignas(64) float weight[4][kTileSize];
  alignas(64) float slope[4][kTileSize];
  alignas(64) float share[kTileSize];         // of the weights, what exists
  alignas(64) std::int32_t first[kTileSize];  // where tap 0 lies
};

// So many samples of the lattice lie along a block's row or column on a lattice sheet, taps
// included; in whole groups; and two groups that begin at any tap.
inline constexpr int kMostAcross = static_cast<int>((kTileSize - 1) * view::kMostSpacings) + 6;
inline constexpr int kRowStride = (kMostAcross + 15) / 16 * 16;
inline constexpr int kRowFloats = kRowStride + 32;

// A row of a sheet, one number for each sample along the lattice.
struct RowOfLattice {
  alignas(64) float value[kRowFloats];
  alignas(64) float slope_y[kRowFloats];
  alignas(64) float slope_z[kRowFloats];
};

// A lattice sheet within a block: the taps of its columns, its rows and of itself, and the
// lattice's samples on it, summed over slices, with their derivatives from sheet to sheet
// (rows-inl.h).
struct RowsOfSheet {
  SampleBounds bounds;             // of the samples that can be worked out
  int columns = 0;                 // of the lattice that they read
  std::int64_t multiply_adds = 0;  // that the slices took
  SharedTaps x, y, z;
  // [samples across][row_stride]: rows lie close together, so that a sheet fits the L1 cache.
  int row_stride = kRowStride;
  alignas(64) float value[kMostAcross * kRowStride];
  alignas(64) float slope[kMostAcross * kRowStride];
  RowOfLattice rows[kTileSize];
};

struct Workspace {
  explicit Workspace(const PlaneShape& shape) : ring(shape) {}

  Block block{};
  SheetRing ring;
  TileState* tile = nullptr;  // the one in hand
  ShadedSheet shaded{};
  SampleBatch batch{};
  RowBits was_visible{};  // samples of the sheet that was shaded last: for a guess
  FloatBuffer sample_memory, presence_memory;  // the region's, unless it is shared
  FloatBuffer taps;                            // general gathering: weights of one sample
  std::array<RowsOfSheet, 2> rows{};           // of lattice sheets, by the parity of their number
  FloatBuffer splats;                          // scatter: numerators and denominators of all sheets
  WorkerStats stats;

  TileInHand in_hand() { return {block.place, ring, *tile, shaded, batch, stats}; }
};

}  // namespace ovoid::cpu
