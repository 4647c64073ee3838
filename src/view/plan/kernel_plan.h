// SPDX-License-Identifier: Apache-2.0
// The plan of a kernel field's frame. The plan names the blocks of the view lattice that can show
// something, and the bricks whose kernels these blocks need.
//
// Kernels are projected into splat space. Its axes x and y run right and down from the optical
// axis, in pixels of the focal plane. Its axis s counts sheets from the frame's first one. The
// sheet at depth z is the focal plane scaled by scale(z) = focal depth / z; in parallel projection
// scale(z) is 1. So a kernel's cut with a sheet is an ellipse in both projections, exactly.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "view/plan/frame_plan.h"

namespace ovoid::view {

// A block has kBlockEdge x kBlockEdge pixels on kBlockDepth sheets, which are a layer.
inline constexpr int kBlockEdge = 64;
inline constexpr int kBlockDepth = 4;

// The most blocks that a frame may have. A block takes some 20 bytes of memory.
inline constexpr std::int64_t kMaxBlocks = std::int64_t{1} << 25;

// Across the view axis kernels are widened until their sigma is half of this many pixels.
inline constexpr double kLeastPixels = 1.3;

// Blocks [lo, hi) along x, y and s.
struct BlockRange {
  int lo[3] = {0, 0, 0};
  int hi[3] = {0, 0, 0};
  bool is_empty() const noexcept { return lo[0] >= hi[0] || lo[1] >= hi[1] || lo[2] >= hi[2]; }
};

// The map from world coordinates to splat space, without the perspective scale.
struct SplatSpace {
  Vec3 origin;    // world coordinates of the optical axis at the focal depth
  Mat3 rotation;  // rows: right, down, view axis
  double pitch;   // width of a pixel at the focal depth, world units
  double sampling_distance;
  double focal_depth;
  double first_depth;  // of the frame's first sheet
  bool is_parallel;
  double center_x, center_y;  // the optical axis, in pixels from the middle of pixel (0, 0)

  // The result has the distances to the right and down from the optical axis, and the depth, all
  // in world units.
  Vec3 camera_from_world(const Vec3& world) const {
    Vec3 at = rotation * (world - origin);
    at[2] += focal_depth;
    return at;
  }
  double sheet_of(double depth) const noexcept { return (depth - first_depth) / sampling_distance; }
  double depth_of(double sheet) const noexcept { return first_depth + sheet * sampling_distance; }
  double scale(double depth) const noexcept { return is_parallel ? 1.0 : focal_depth / depth; }
};

// Post-convolution carries a kernel beyond its cut. The published ways sum kernels on samples that
// are up to two sigmas and at most kWidestSample pixels wide. Their filters reach two samples on
// every level, which makes fewer than four samples over all levels. The interpolation of kAuto
// carries so little beyond the cut that the plan leaves it out.
inline constexpr double kOvershootSamples = 4;
inline constexpr double kOvershootSigmas = 2 * kOvershootSamples;
inline constexpr double kWidestSample = 64;

struct KernelPlan : FramePlan {
  // `beside`: fields that are drawn on the same sheets, whose plans then have the same blocks.
  KernelPlan(const KernelField& field, const Camera& camera, const Look& look,
             const RenderOptions& options, std::span<const KernelField> beside = {});

  SplatSpace space;
  bool is_mean;                         // a sample is the mean over its slab
  double overshoot = 0;                 // how far filters carry kernels, sigmas of their cuts
  int width, height;                    // of the picture, pixels
  int num_blocks[3];                    // along x, y and s
  std::vector<std::uint8_t> is_needed;  // [s][y][x]: the block's kernels are needed
  // [s][y][x]: the block can show something. A relevant block is also needed.
  std::vector<std::uint8_t> is_relevant;
  std::vector<std::int64_t> bricks;  // numbers of the bricks that reach a needed block, rising

  std::int64_t block_index(int x, int y, int s) const noexcept {
    return (static_cast<std::int64_t>(s) * num_blocks[1] + y) * num_blocks[0] + x;
  }
  std::int64_t total_blocks() const noexcept {
    return static_cast<std::int64_t>(num_blocks[0]) * num_blocks[1] * num_blocks[2];
  }

 private:
  // The blocks that a box in splat space may touch. The box is given in x and y without the
  // perspective scale, and grows by the one sample that differences need.
  BlockRange blocks_touching(const double lateral_lo[2], const double lateral_hi[2],
                             double sheet_lo, double sheet_hi) const noexcept;
  BlockRange blocks_of_brick(const KernelBrick& brick, double cutoff) const noexcept;
  void find_relevant(const KernelField& field, const std::vector<BlockRange>& ranges,
                     bool needs_both_ends);
  // True if no sample of the block has a path.
  bool is_clipped_away(int x, int y, int layer) const;
  void drop_clipped();
  void find_needed(const std::vector<BlockRange>& ranges);
};

}  // namespace ovoid::view
