// SPDX-License-Identifier: Apache-2.0
#include "ovoid/lattice_levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "data/lattice/level_basis.h"
#include "data/parallel.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

[[noreturn]] void refuse_levels(const std::string& what) {
  throw Error(ErrorCode::kInvalidArgument, what);
}

void check_level(const LatticeLevels& all, int index) {
  const LatticeLevel& level = all.levels[static_cast<std::size_t>(index)];
  if (level.weights.size() != level.nodes.size())
    refuse_levels(fmt::format("levels[{}]: {} weights for {} nodes", index, level.weights.size(),
                              level.nodes.size()));
  const std::int64_t num_nodes = num_samples(all.nodes(index));
  std::int64_t before = -1;
  for (std::size_t i = 0; i < level.nodes.size(); ++i) {
    const std::int64_t node = level.nodes[i];
    if (node <= before || node >= num_nodes)
      refuse_levels(fmt::format("levels[{}]: nodes[{}] = {}: must rise, and be less than {}", index,
                                i, node, num_nodes));
    before = node;
  }
}

void check_holes(const LatticeLevels& all) {
  if (all.holes.empty()) return;
  if (all.whole) refuse_levels("holes: expected none of whole samples, which have no NaN");
  if (all.holes.size() % 2 != 0)
    refuse_levels(fmt::format("holes: {} numbers, expected pairs", all.holes.size()));
  const std::int64_t count = num_samples(all.dims);
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < all.holes.size(); ++i) {
    sum += all.holes[i];
    if ((i > 0 && all.holes[i] == 0) || sum > count)
      refuse_levels(fmt::format("holes[{}] = {}: must be > 0, and within {} samples", i,
                                all.holes[i], count));
  }
}

void check(const LatticeLevels& all) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (all.dims[a] < 1) refuse_levels(fmt::format("dims[{}] = {}: must be >= 1", a, all.dims[a]));
  }
  if (!std::isfinite(all.offset))
    refuse_levels(fmt::format("offset = {}: must be finite", all.offset));
  if (!(all.step > 0 && std::isfinite(all.step)))
    refuse_levels(fmt::format("step = {}: must be > 0", all.step));
  if (!(all.least <= all.greatest && std::isfinite(all.least) && std::isfinite(all.greatest)))
    refuse_levels(fmt::format("least, greatest = {}, {}: must rise", all.least, all.greatest));
  if (all.levels.size() > LatticeLevels::kMostLevels)
    refuse_levels(fmt::format("levels: there are {}: expected at most {}", all.levels.size(),
                              LatticeLevels::kMostLevels));
  for (int level = 0; level < static_cast<int>(all.levels.size()); ++level) check_level(all, level);
  check_holes(all);
}

}  // namespace

Index3 LatticeLevels::nodes(int level) const noexcept {
  const std::int64_t stride = std::int64_t{1} << level;
  return {(dims[0] + stride - 1) / stride, (dims[1] + stride - 1) / stride,
          (dims[2] + stride - 1) / stride};
}

double LatticeLevels::step_of(int level) const noexcept {
  return step * std::exp2(-1.5 * static_cast<double>(level));
}

std::int64_t LatticeLevels::num_kernels() const noexcept {
  std::int64_t count = 0;
  for (const LatticeLevel& level : levels) count += static_cast<std::int64_t>(level.nodes.size());
  return count;
}

std::vector<float> samples_of(const LatticeLevels& levels, int threads, const std::stop_token& stop,
                              const std::function<void(double fraction)>& progress) {
  check(levels);
  const data::LevelBasis basis(levels.dims, static_cast<int>(levels.levels.size()));
  std::vector<float> samples(basis.num_samples(), static_cast<float>(levels.offset));
  const int num_levels = basis.num_levels();
  for (int l = num_levels - 1; l >= 0; --l) {
    if (progress) progress(static_cast<double>(num_levels - l) / (num_levels + 1));
    const LatticeLevel& level = levels.levels[static_cast<std::size_t>(l)];
    if (level.nodes.empty()) continue;
    std::vector<float> weights(static_cast<std::size_t>(num_samples(basis.nodes(l))));
    const double step = levels.step_of(l);
    for (std::size_t i = 0; i < level.nodes.size(); ++i)
      weights[level.nodes[i]] = static_cast<float>(step * static_cast<double>(level.weights[i]));
    basis.expand_level(weights, l, 1, samples, {threads, stop});
  }
  const auto least = static_cast<float>(levels.least);
  const auto greatest = static_cast<float>(levels.greatest);
  data::parallel_ranges(
      {static_cast<std::int64_t>(samples.size()), 1 << 20, threads, stop},
      [&](std::int64_t begin, std::int64_t end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          const float sample = levels.whole ? std::nearbyint(samples[i]) : samples[i];
          samples[i] = std::clamp(sample, least, greatest);
        }
      });
  auto at = samples.begin();
  for (std::size_t i = 0; i < levels.holes.size(); i += 2) {
    at += levels.holes[i];
    at = std::fill_n(at, levels.holes[i + 1], std::numeric_limits<float>::quiet_NaN());
  }
  return samples;
}

}  // namespace ovoid
