// SPDX-License-Identifier: Apache-2.0
// Stage "bin": which splats reach which block, by a counting sort. The bricks are cut into a fixed
// number of parts; every part lists and counts what its splats reach, the counts become places, and
// every part writes to its places. So the order does not depend on who did which part.
#include <algorithm>
#include <cmath>
#include <utility>

#include "render/cpu/kernels/project_brick.h"
#include "render/cpu/kernels/splat_layers.h"

namespace ovoid::cpu {
namespace {

constexpr int kMaxParts = 32;
constexpr std::int64_t kSplatsPerPart = 8192;                  // fewer are not worth a part
constexpr std::int64_t kMostCounters = std::int64_t{1} << 23;  // of all parts together, if they can

struct Part {
  std::size_t first_brick, last_brick;  // of the plan's
  std::uint64_t first_splat;
};

std::vector<Part> parts_of(const KernelField& field, const view::KernelPlan& plan,
                           std::uint64_t& total) {
  total = 0;
  for (const std::int64_t b : plan.bricks)
    total += static_cast<std::uint64_t>(field.source().brick(b).count);
  const std::int64_t most = std::clamp<std::int64_t>(
      kMostCounters / std::max<std::int64_t>(plan.total_blocks(), 1), 1, kMaxParts);
  const auto count = static_cast<std::uint64_t>(
      std::clamp<std::int64_t>(static_cast<std::int64_t>(total) / kSplatsPerPart, 1, most));
  std::vector<Part> parts;
  std::uint64_t done = 0;
  Part part{0, 0, 0};
  for (std::size_t i = 0; i < plan.bricks.size(); ++i) {
    done += static_cast<std::uint64_t>(field.source().brick(plan.bricks[i]).count);
    part.last_brick = i + 1;
    if (done * count >= total * (parts.size() + 1)) {
      parts.push_back(part);
      part = {i + 1, i + 1, done};
    }
  }
  if (part.first_brick < part.last_brick) parts.push_back(part);
  return parts;
}

struct Reached {
  std::uint32_t block, splat;
};

// Blocks [lo, hi) along one axis whose samples, of which the first lies one before its pixels and
// the last one behind them, meet [from, to] pixels.
struct BlockSpan {
  int lo, hi;
};

BlockSpan span_of(float from, float to, int count) {
  constexpr float kSlack = 1e-2F;
  constexpr float kPerPixel = 1.0F / view::kBlockEdge;
  const auto most = static_cast<float>(count);
  const float lo = std::clamp((from - kSlack) * kPerPixel - 1.0F, -1.0F, most);
  const float hi = std::clamp((to + 1.0F + kSlack) * kPerPixel, -1.0F, most);
  // Rounded down by way of positive numbers.
  return {std::max(static_cast<int>(lo + 1.0F), 0), std::min(static_cast<int>(hi + 1.0F), count)};
}

// Blocks of a layer that an extent meets.
struct BlockArea {
  BlockArea(const view::KernelPlan& plan, const SplatExtent& extent)
      : xs(span_of(extent.lo_x, extent.hi_x, plan.num_blocks[0])),
        ys(span_of(extent.lo_y, extent.hi_y, plan.num_blocks[1])) {}

  bool is_empty() const { return xs.lo >= xs.hi || ys.lo >= ys.hi; }
  bool is_one() const { return xs.lo + 1 == xs.hi && ys.lo + 1 == ys.hi; }

  BlockSpan xs, ys;
};

// Runs `body(block)` for the needed blocks that a splat reaches. Most lie within one tile; of the
// others the blocks are found layer by layer, since cuts grow smaller and those of inclined kernels
// slide.
template <class Body>
void for_each_block(const view::KernelPlan& plan, const std::vector<Layer>& layers,
                    const Splat& splat, const Body& body) {
  const float reach = plan.is_mean ? 0.5F : 0.0F;
  const float first_sheet = splat.s - splat.reach_s - reach;
  const float last_sheet = splat.s + splat.reach_s + reach;
  if (!(last_sheet >= 0)) return;
  const std::size_t end = layers.size();
  auto first = static_cast<std::size_t>(std::max(first_sheet, 0.0F) / view::kBlockDepth);
  first -= first > 0 ? 1 : 0;
  while (first < end && layers[first].last < first_sheet) ++first;
  std::size_t past = first;
  while (past < end && layers[past].first <= last_sheet) ++past;
  if (first == past) return;
  const auto visit = [&](const BlockArea& area, std::size_t layer) {
    for (int y = area.ys.lo; y < area.ys.hi; ++y) {
      for (int x = area.xs.lo; x < area.xs.hi; ++x) {
        const auto block =
            static_cast<std::size_t>(plan.block_index(x, y, static_cast<int>(layer)));
        if (plan.is_needed[block] != 0) body(block);
      }
    }
  };
  const Layer all = {layers[first].first, layers[past - 1].last, layers[past - 1].scale_lo,
                     layers[first].scale_hi};
  const BlockArea whole(plan, extent_on(plan, all, splat));
  if (whole.is_empty()) return;
  for (std::size_t n = first; n < past; ++n)
    visit(whole.is_one() ? whole : BlockArea(plan, extent_on(plan, layers[n], splat)), n);
}

}  // namespace

BinnedSplats bin_splats(const KernelField& field, const view::KernelPlan& plan, Merging merging,
                        Runner& runner) {
  BinnedSplats binned;
  std::uint64_t total = 0;
  const std::vector<Part> parts = parts_of(field, plan, total);
  const auto num_blocks = static_cast<std::size_t>(plan.total_blocks());
  const std::vector<Layer> layers = layers_of(plan);
  binned.num_kernels = static_cast<std::int64_t>(total);
  binned.splats = std::make_unique_for_overwrite<Splat[]>(total);
  std::vector<std::vector<std::uint64_t>> places(parts.size());  // counts first, per block
  std::vector<std::vector<Reached>> reached(parts.size());
  runner.run(static_cast<int>(parts.size()), [&](int task, int) {
    const auto p = static_cast<std::size_t>(task);
    const Part& part = parts[p];
    std::uint64_t end = part.first_splat;
    for (std::size_t n = part.first_brick; n < part.last_brick; ++n)
      end += static_cast<std::uint64_t>(
          project_brick(field, plan, plan.bricks[n], merging, binned.splats.get() + end));
    places[p].assign(num_blocks, 0);
    reached[p].reserve(end - part.first_splat);
    for (std::uint64_t i = part.first_splat; i < end; ++i) {
      for_each_block(plan, layers, binned.splats[i], [&](std::size_t block) {
        reached[p].push_back({static_cast<std::uint32_t>(block), static_cast<std::uint32_t>(i)});
        ++places[p][block];
      });
    }
  });
  binned.first.assign(num_blocks + 1, 0);
  std::uint64_t place = 0;
  for (std::size_t block = 0; block < num_blocks; ++block) {
    binned.first[block] = place;
    for (std::vector<std::uint64_t>& of_part : places)
      place += std::exchange(of_part[block], place);
  }
  binned.first[num_blocks] = place;
  binned.indices = std::make_unique_for_overwrite<std::uint32_t[]>(place);
  runner.run(static_cast<int>(parts.size()), [&](int task, int) {
    const auto p = static_cast<std::size_t>(task);
    for (const Reached& one : reached[p]) binned.indices[places[p][one.block]++] = one.splat;
    reached[p] = {};
  });
  return binned;
}

}  // namespace ovoid::cpu
