// SPDX-License-Identifier: Apache-2.0
// A frame of a kernel field: which blocks of the view lattice can show, and which bricks they need.
//
// Splat space is where kernels are worked out: x to the right and y down in pixels of the focal
// plane, from the optical axis; s in sheets, from the frame's first one. A sheet at depth z is that
// plane scaled by scale(z) = focal depth / z (parallel: 1), so a kernel's cut with a sheet is an
// ellipse in both projections, without approximation.
#pragma once

#include <cstdint>
#include <vector>

#include "view/frame_plan.h"

namespace ovoid::view {

// A block: kBlockEdge x kBlockEdge pixels x kBlockDepth sheets.
inline constexpr int kBlockEdge = 64;
inline constexpr int kBlockDepth = 4;

// The most blocks a frame may have: what is kept of each takes some 20 bytes.
inline constexpr std::int64_t kMaxBlocks = std::int64_t{1} << 25;

// Across the view axis the unit, in pixels, in which no kernel's sigma is under one half.
inline constexpr double kLeastPixels = 1.3;

// Blocks [lo, hi) along x, y and s.
struct BlockRange {
  int lo[3] = {0, 0, 0};
  int hi[3] = {0, 0, 0};
  bool is_empty() const noexcept { return lo[0] >= hi[0] || lo[1] >= hi[1] || lo[2] >= hi[2]; }
};

// World to splat space, before the perspective scale.
struct SplatSpace {
  Vec3 origin;    // world: on the optical axis, at the focal depth
  Mat3 rotation;  // rows: right, down, view axis
  double pitch;   // of a pixel at the focal depth, world units
  double sampling_distance;
  double focal_depth;
  double first_depth;  // of the frame's first sheet
  bool is_parallel;
  double center_x, center_y;  // pixel coordinates of the optical axis: pixel (0, 0) is at 0, 0

  // Camera coordinates of a world position: right and down in world units, and depth.
  Vec3 camera_from_world(const Vec3& world) const {
    Vec3 at = rotation * (world - origin);
    at[2] += focal_depth;
    return at;
  }
  double sheet_of(double depth) const noexcept { return (depth - first_depth) / sampling_distance; }
  double depth_of(double sheet) const noexcept { return first_depth + sheet * sampling_distance; }
  double scale(double depth) const noexcept { return is_parallel ? 1.0 : focal_depth / depth; }
};

// Published ways of post-convolution sum kernels on samples up to two sigmas wide, at most
// kWidestSample pixels, and their filters reach two of them on every level: fewer than four
// together. What the interpolation of kAuto carries beyond a kernel's cut is nothing to speak of.
inline constexpr double kOvershootSamples = 4;
inline constexpr double kOvershootSigmas = 2 * kOvershootSamples;
inline constexpr double kWidestSample = 64;

struct KernelPlan : FramePlan {
  KernelPlan(const KernelField& field, const Camera& camera, const Look& look,
             const RenderOptions& options);

  SplatSpace space;
  bool is_mean;                           // samples are means over their slabs
  double overshoot = 0;                   // how far filters carry kernels, sigmas of their cuts
  int width, height;                      // of the picture, pixels
  int num_blocks[3];                      // along x, y and s
  std::vector<std::uint8_t> is_needed;    // [s][y][x]: its kernels are wanted
  std::vector<std::uint8_t> is_relevant;  // [s][y][x]: it can show; relevant blocks are needed
  std::vector<std::int64_t> bricks;       // that reach a needed block, rising

  std::int64_t block_index(int x, int y, int s) const noexcept {
    return (static_cast<std::int64_t>(s) * num_blocks[1] + y) * num_blocks[0] + x;
  }
  std::int64_t total_blocks() const noexcept {
    return static_cast<std::int64_t>(num_blocks[0]) * num_blocks[1] * num_blocks[2];
  }

 private:
  // Blocks that a box in splat space may touch with the margin of one sample that differences
  // need: in x and y before the perspective scale.
  BlockRange blocks_touching(const double lateral_lo[2], const double lateral_hi[2],
                             double sheet_lo, double sheet_hi) const noexcept;
  BlockRange blocks_of_brick(const KernelBrick& brick, double cutoff) const noexcept;
  void find_relevant(const KernelField& field, const std::vector<BlockRange>& ranges,
                     bool needs_both_ends);
  // No sample of such a block has a path.
  bool is_clipped_away(int x, int y, int layer) const;
  void drop_clipped();
  void find_needed(const std::vector<BlockRange>& ranges);
};

}  // namespace ovoid::view
