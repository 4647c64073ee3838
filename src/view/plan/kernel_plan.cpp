// SPDX-License-Identifier: Apache-2.0
#include "view/plan/kernel_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "ovoid/error.h"
#include "view/look/color_attribute.h"

namespace ovoid::view {
namespace {

// Kernel sets have no index space: it is the world.
LatticeGeometry world_geometry() { return {.dims = {1, 1, 1}}; }

int clamp_block(double block, int count) {
  return static_cast<int>(std::clamp(block, 0.0, static_cast<double>(count)));
}

Bounds3 support_of(const KernelField& field, double cutoff_reach) {
  Bounds3 box;
  for (std::int64_t b = 0; b < field.source().num_bricks(); ++b)
    box.extend(field.source().brick(b).support);
  box.min().array() -= cutoff_reach;
  box.max().array() += cutoff_reach;
  return box;
}

bool takes_the_mean(const Look& look, const RenderOptions& options) {
  return options.slab == Slab::kMean || (options.slab == Slab::kAuto && look.mode == Mode::kXray);
}

}  // namespace

KernelPlan::KernelPlan(const KernelField& field, const Camera& camera, const Look& look,
                       const RenderOptions& options, std::span<const KernelField> beside)
    : FramePlan(field,
                ViewLattice(camera, options.width, options.height,
                            sheet_distance(field, look, options), world_geometry()),
                look, options),
      is_mean(takes_the_mean(look, options)),
      overshoot(is_published(options.post_convolution) ? kOvershootSigmas : 0.0) {
  if (field.has_own_color()) color_table.emplace(color_function_of(look));
  const double cutoff = field.source().cutoff();
  // Along the view axis no kernel is narrower than half a sheet.
  Bounds3 support = support_of(field, 0.5 * cutoff * lattice.sampling_distance());
  for (const KernelField& other : beside)
    support.extend(support_of(other, 0.5 * other.source().cutoff() * lattice.sampling_distance()));
  set_sheets(support);
  // Another of the fields may end with a piece.
  if (!beside.empty() && !is_refined && sheets.first < sheets.last) ++sheets.last;
  const Vec3 right = lattice.world_map(0).per_x.normalized();
  const Vec3 down = lattice.world_map(0).per_y.normalized();
  const double sign = lattice.is_parallel() || lattice.depth(0) > 0 ? 1.0 : -1.0;
  space.focal_depth = (camera.focal_point - camera.position).norm();
  space.origin = camera.focal_point;
  space.rotation.row(0) = sign * right;
  space.rotation.row(1) = sign * down;
  space.rotation.row(2) = lattice.view_axis();
  space.is_parallel = lattice.is_parallel();
  space.sampling_distance = lattice.sampling_distance();
  space.first_depth = lattice.depth(sheets.first);
  space.pitch = std::abs(lattice.pitch(0) / (space.is_parallel ? 1.0 : lattice.depth(0))) *
                (space.is_parallel ? 1.0 : space.focal_depth);
  space.center_x = 0.5 * (options.width - 1);
  space.center_y = 0.5 * (options.height - 1);
  width = options.width;
  height = options.height;
  num_blocks[0] = (options.width + kBlockEdge - 1) / kBlockEdge;
  num_blocks[1] = (options.height + kBlockEdge - 1) / kBlockEdge;
  num_blocks[2] = static_cast<int>(
      std::max<std::int64_t>(0, (sheets.last - sheets.first + kBlockDepth - 1) / kBlockDepth));
  if (total_blocks() > kMaxBlocks) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("sampling_distance = {}: gives {} sheets, too many for a picture of {} x "
                    "{} pixels: expected a larger distance or a smaller picture",
                    lattice.sampling_distance(), sheets.last - sheets.first, options.width,
                    options.height));
  }
  std::vector<BlockRange> ranges;
  ranges.reserve(static_cast<std::size_t>(field.source().num_bricks()));
  for (std::int64_t b = 0; b < field.source().num_bricks(); ++b)
    ranges.push_back(blocks_of_brick(field.source().brick(b), cutoff));
  find_relevant(field, ranges, is_preintegrated || is_refined || look.mode == Mode::kIsosurface);
  if (may_matter) drop_clipped();
  find_needed(ranges);
}

BlockRange KernelPlan::blocks_touching(const double lateral_lo[2], const double lateral_hi[2],
                                       double sheet_lo, double sheet_hi) const noexcept {
  BlockRange range;
  // Sheets are at whole numbers; a mean one stands for half a sheet on either side. A refined piece
  // ends on the sheet behind.
  const double reach = is_mean ? 0.5 : 0.0;
  const double first = std::ceil(sheet_lo - reach - 1e-3);
  const double last = std::floor(sheet_hi + reach + (is_refined ? 1.0 : 0.0) + 1e-3);
  if (!(first <= last)) return range;
  range.lo[2] = clamp_block(std::floor(first / kBlockDepth), num_blocks[2]);
  range.hi[2] = clamp_block(std::floor(last / kBlockDepth) + 1, num_blocks[2]);
  // Perspective: what is farthest from the axis is so at one end of the depths.
  double scale_lo = 1, scale_hi = 1;
  if (!space.is_parallel) {
    const double nearest = std::max(space.depth_of(first - reach), lattice.near_depth());
    const double farthest = std::max(space.depth_of(last + reach), nearest);
    scale_lo = space.scale(farthest);
    scale_hi = space.scale(nearest);
  }
  for (int a = 0; a < 2; ++a) {
    const double center = a == 0 ? space.center_x : space.center_y;
    const double beyond = overshoot > 0 ? kOvershootSamples * kWidestSample : 0.0;
    const double lo = lateral_lo[a] * (lateral_lo[a] < 0 ? scale_hi : scale_lo) + center - beyond;
    const double hi = lateral_hi[a] * (lateral_hi[a] > 0 ? scale_hi : scale_lo) + center + beyond;
    // A tile's samples begin one before its pixels and end one behind them.
    range.lo[a] = clamp_block(std::ceil((lo - kBlockEdge - 1e-3) / kBlockEdge), num_blocks[a]);
    range.hi[a] = clamp_block(std::floor((hi + 1 + 1e-3) / kBlockEdge) + 1, num_blocks[a]);
  }
  return range;
}

BlockRange KernelPlan::blocks_of_brick(const KernelBrick& brick, double cutoff) const noexcept {
  double lo[3], hi[3];
  for (int a = 0; a < 3; ++a) {
    lo[a] = std::numeric_limits<double>::infinity();
    hi[a] = -lo[a];
  }
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 at =
        space.camera_from_world(brick.support.corner(static_cast<Bounds3::CornerType>(corner)));
    for (int a = 0; a < 3; ++a) {
      lo[a] = std::min(lo[a], at[a]);
      hi[a] = std::max(hi[a], at[a]);
    }
  }
  // Widened kernels reach so many pixels (at their own depth), or half a sheet, farther per sigma.
  const double depth_scale =
      space.is_parallel ? 1.0 : std::max(hi[2], lattice.near_depth()) / space.focal_depth;
  const double widened = 0.5 * kLeastPixels * cutoff * depth_scale;
  double lateral_lo[2], lateral_hi[2];
  for (int a = 0; a < 2; ++a) {
    lateral_lo[a] = lo[a] / space.pitch - widened;
    lateral_hi[a] = hi[a] / space.pitch + widened;
  }
  return blocks_touching(lateral_lo, lateral_hi, space.sheet_of(lo[2]) - 0.5 * cutoff,
                         space.sheet_of(hi[2]) + 0.5 * cutoff);
}

namespace {

template <class Body>
void for_each_block(const KernelPlan& plan, const BlockRange& range, const Body& body) {
  for (int s = range.lo[2]; s < range.hi[2]; ++s) {
    for (int y = range.lo[1]; y < range.hi[1]; ++y) {
      for (int x = range.lo[0]; x < range.hi[0]; ++x)
        body(static_cast<std::size_t>(plan.block_index(x, y, s)));
    }
  }
}

}  // namespace

// A normalized field lies between the least and the greatest value of the kernels that reach a
// block. A sum has no useful bounds: where kernels are, it may be anything.
void KernelPlan::find_relevant(const KernelField& field, const std::vector<BlockRange>& ranges,
                               bool needs_both_ends) {
  const auto count = static_cast<std::size_t>(total_blocks());
  is_relevant.assign(count, 0);
  if (!may_matter || field.reconstruction() == Reconstruction::kSum) {
    for (const BlockRange& range : ranges)
      for_each_block(*this, range, [&](std::size_t block) { is_relevant[block] = 1; });
    return;
  }
  std::vector<ValueRange> bounds(count);
  for (std::size_t b = 0; b < ranges.size(); ++b) {
    const ValueRange& values = field.source()
                                   .brick(static_cast<std::int64_t>(b))
                                   .ranges[static_cast<std::size_t>(field.attribute())];
    for_each_block(*this, ranges[b], [&](std::size_t block) {
      ValueRange& all = bounds[block];
      all = all.is_empty() ? values
                           : ValueRange{std::min(all.lo, values.lo), std::max(all.hi, values.hi)};
    });
  }
  const std::size_t layer = static_cast<std::size_t>(num_blocks[0]) * num_blocks[1];
  // Rounding, and the overshoot of post-convolution, of a field that lies at an end of its bounds.
  constexpr float kSlack = 0.01F;
  for (std::size_t block = 0; block < count; ++block) {
    ValueRange all = bounds[block];
    if (all.is_empty()) continue;
    // A piece begins, and a crossing may, in the block before.
    if (needs_both_ends && block >= layer && !bounds[block - layer].is_empty()) {
      all.lo = std::min(all.lo, bounds[block - layer].lo);
      all.hi = std::max(all.hi, bounds[block - layer].hi);
    }
    const float slack =
        kSlack * (all.hi - all.lo) + 1e-5F * std::max(std::abs(all.lo), std::abs(all.hi));
    is_relevant[block] = may_matter(all.lo - slack, all.hi + slack) ? 1 : 0;
  }
}

// Distances are linear along pixels, sheets and slabs, each by itself: greatest at a corner.
bool KernelPlan::is_clipped_away(int x, int y, int layer) const {
  // Paths are worked out in floats, in sheets.
  constexpr double kSlack = 1e-3;
  const int x0 = x * kBlockEdge;
  const int y0 = y * kBlockEdge;
  const int x1 = std::min(x0 + kBlockEdge, width) - 1;
  const int y1 = std::min(y0 + kBlockEdge, height) - 1;
  const std::int64_t first = sheets.first + static_cast<std::int64_t>(layer) * kBlockDepth;
  const std::int64_t last = std::min(first + kBlockDepth, sheets.last) - 1;
  const double reach = ((is_refined ? 1.0 : 0.5) + kSlack) * lattice.sampling_distance();
  return std::any_of(drawn_within.begin(), drawn_within.end(), [&](const ClipPlane& plane) {
    const ClipMap slope = clip_slope(plane);
    for (const std::int64_t sheet : {first, last}) {
      const ClipMap distance = clip_distance(plane, sheet);
      for (const int px : {x0, x1}) {
        for (const int py : {y0, y1}) {
          const double lean = slope.origin + px * slope.per_x + py * slope.per_y;
          const double inside = distance.origin + px * distance.per_x + py * distance.per_y;
          if (inside + reach * std::abs(lean) + kSlack * lattice.sampling_distance() >= 0)
            return false;
        }
      }
    }
    return true;
  });
}

void KernelPlan::drop_clipped() {
  if (drawn_within.empty()) return;
  for (int s = 0; s < num_blocks[2]; ++s) {
    for (int y = 0; y < num_blocks[1]; ++y) {
      for (int x = 0; x < num_blocks[0]; ++x) {
        std::uint8_t& is_kept = is_relevant[static_cast<std::size_t>(block_index(x, y, s))];
        if (is_kept != 0 && is_clipped_away(x, y, s)) is_kept = 0;
      }
    }
  }
}

// Differences, pieces and crossings need a sheet of the block before and of the one behind.
void KernelPlan::find_needed(const std::vector<BlockRange>& ranges) {
  is_needed = is_relevant;
  const std::size_t layer = static_cast<std::size_t>(num_blocks[0]) * num_blocks[1];
  for (std::size_t block = 0; block < is_relevant.size(); ++block) {
    if (is_relevant[block] == 0) continue;
    if (block >= layer) is_needed[block - layer] = 1;
    if (block + layer < is_needed.size()) is_needed[block + layer] = 1;
  }
  for (std::size_t b = 0; b < ranges.size(); ++b) {
    bool any = false;
    for_each_block(*this, ranges[b], [&](std::size_t block) { any |= is_needed[block] != 0; });
    if (any) bricks.push_back(static_cast<std::int64_t>(b));
  }
}

}  // namespace ovoid::view
