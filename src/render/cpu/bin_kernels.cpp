// SPDX-License-Identifier: Apache-2.0
// Stage "bin": which splats reach which block, by a counting sort. The bricks are cut into a fixed
// number of parts; every part counts its splats per block, the counts become places, and every part
// writes to its places. So the order does not depend on who did which part.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "data/kernel_shape.h"
#include "render/cpu/splat.h"

namespace ovoid::cpu {
namespace {

constexpr int kMaxParts = 32;
constexpr std::int64_t kSplatsPerPart = 8192;  // fewer are not worth a part

struct Part {
  std::size_t first_brick, last_brick;  // of the plan's
  std::uint64_t first_splat;
};

std::vector<Part> parts_of(const KernelField& field, const view::KernelPlan& plan,
                           std::uint64_t& total) {
  total = 0;
  for (const std::int64_t b : plan.bricks)
    total += static_cast<std::uint64_t>(field.source().brick(b).count);
  const auto count = static_cast<std::uint64_t>(
      std::clamp<std::int64_t>(static_cast<std::int64_t>(total) / kSplatsPerPart, 1, kMaxParts));
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

void project_part(const KernelField& field, const view::KernelPlan& plan, const Part& part,
                  Splat* splats) {
  const KernelSource& source = field.source();
  const auto attribute = static_cast<std::size_t>(field.attribute());
  const auto color = static_cast<std::size_t>(field.color_attribute());
  Splat* out = splats + part.first_splat;
  for (std::size_t n = part.first_brick; n < part.last_brick; ++n) {
    const KernelBrick& brick = source.brick(plan.bricks[n]);
    const KernelView view = source.acquire(plan.bricks[n], 0.0);
    for (std::int32_t i = 0; i < view.count; ++i, ++out) {
      const auto numbers = data::shape_numbers(view, source.shape(), i);
      *out = project_kernel(plan.space, brick.origin + data::offset_of(view, i), source.shape(),
                            numbers.data(), source.cutoff());
      out->weight *= data::weight_of(view, i);
      out->value = view.value[attribute][i];
      out->color = view.value[color][i];
    }
  }
}

// Runs `body(block)` for the needed blocks that a splat reaches. Layer by layer, since the cut of
// an inclined kernel slides.
template <class Body>
void for_each_block(const view::KernelPlan& plan, const Splat& splat, const Body& body) {
  const double reach = plan.is_mean ? 0.5 : 0.0;
  const double first_sheet = splat.s - splat.reach_s - reach;
  const double last_sheet = splat.s + splat.reach_s + reach;
  if (last_sheet < 0) return;
  const int first = static_cast<int>(std::max(0.0, std::floor(first_sheet / view::kBlockDepth)));
  const int last = static_cast<int>(
      std::min<double>(plan.num_blocks[2] - 1, std::floor(last_sheet / view::kBlockDepth)));
  for (int layer = first; layer <= last; ++layer) {
    const double from = std::max<double>(first_sheet, layer * view::kBlockDepth - reach);
    const double to = std::min<double>(last_sheet, (layer + 1) * view::kBlockDepth - 1 + reach);
    if (from > to) continue;
    const double t0 = from - splat.s;
    const double t1 = to - splat.s;
    // The cut is widest where it is nearest to the centre.
    const double nearest = t0 > 0 ? t0 : (t1 < 0 ? t1 : 0.0);
    const double share = nearest / splat.reach_s;
    const double width = plan.is_mean ? 1.0 : std::sqrt(std::max(0.0, 1.0 - share * share)) + 1e-4;
    double lo[2], hi[2];
    const float centers[2] = {splat.x, splat.y};
    const float slopes[2] = {splat.mx, splat.my};
    const float reaches[2] = {splat.reach_x, splat.reach_y};
    for (int a = 0; a < 2; ++a) {
      const double slide0 = slopes[a] * t0;
      const double slide1 = slopes[a] * t1;
      lo[a] = centers[a] + std::min(slide0, slide1) - reaches[a] * width;
      hi[a] = centers[a] + std::max(slide0, slide1) + reaches[a] * width;
    }
    view::BlockRange range = plan.blocks_touching(lo, hi, from + reach, to - reach);
    for (int y = range.lo[1]; y < range.hi[1]; ++y) {
      for (int x = range.lo[0]; x < range.hi[0]; ++x) {
        const auto block = static_cast<std::size_t>(plan.block_index(x, y, layer));
        if (plan.is_needed[block] != 0) body(block);
      }
    }
  }
}

}  // namespace

BinnedSplats bin_splats(const KernelField& field, const view::KernelPlan& plan, Runner& runner) {
  BinnedSplats binned;
  std::uint64_t total = 0;
  const std::vector<Part> parts = parts_of(field, plan, total);
  const auto num_blocks = static_cast<std::size_t>(plan.total_blocks());
  binned.splats.resize(total);
  std::vector<std::vector<std::uint32_t>> counts(parts.size());
  const auto end_of = [&](std::size_t p) {
    return p + 1 < parts.size() ? parts[p + 1].first_splat : total;
  };
  runner.run(static_cast<int>(parts.size()), [&](int task, int) {
    const auto p = static_cast<std::size_t>(task);
    counts[p].assign(num_blocks, 0);
    project_part(field, plan, parts[p], binned.splats.data());
    for (std::uint64_t i = parts[p].first_splat; i < end_of(p); ++i)
      for_each_block(plan, binned.splats[i], [&](std::size_t block) { ++counts[p][block]; });
  });
  binned.first.assign(num_blocks + 1, 0);
  std::uint64_t place = 0;
  std::vector<std::vector<std::uint64_t>> next(parts.size(),
                                               std::vector<std::uint64_t>(num_blocks));
  for (std::size_t block = 0; block < num_blocks; ++block) {
    binned.first[block] = place;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      next[p][block] = place;
      place += counts[p][block];
    }
  }
  binned.first[num_blocks] = place;
  binned.indices.resize(place);
  runner.run(static_cast<int>(parts.size()), [&](int task, int) {
    const auto p = static_cast<std::size_t>(task);
    for (std::uint64_t i = parts[p].first_splat; i < end_of(p); ++i) {
      for_each_block(plan, binned.splats[i], [&](std::size_t block) {
        binned.indices[next[p][block]++] = static_cast<std::uint32_t>(i);
      });
    }
  });
  return binned;
}

}  // namespace ovoid::cpu
