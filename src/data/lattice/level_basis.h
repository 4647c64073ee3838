// SPDX-License-Identifier: Apache-2.0
// The kernels of LatticeLevels as a linear map from weights at the nodes to samples, and its
// transpose; separable, level by level. docs/numerics.md, "Levels of a scan".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "ovoid/lattice.h"

namespace ovoid::data {

// A level's kernels along one axis. Sample x = i * stride + phase is reached by the nodes from i +
// first[phase] on; taps of nodes that are not there are left out.
struct LevelAxis {
  static constexpr int kTaps = 4;

  LevelAxis(std::int64_t num_samples, int level);

  std::int64_t num_samples = 0, num_nodes = 0, stride = 1;
  std::vector<int> first;                      // [stride]
  std::vector<std::array<float, kTaps>> taps;  // [stride]

  // The square of the norm of each node's kernel over the samples.
  std::vector<double> squared_norms() const;
  // Products of the kernels of nodes i and i - j, [num_nodes][kTaps] by i and j.
  std::vector<std::array<double, kTaps>> products() const;
};

// Who works, and until when.
struct LevelWork {
  int threads = 0;
  std::stop_token stop{};
};

// The levels of a lattice of samples. Weights lie level behind level, the finest first, each
// [m_z][m_y][m_x].
class LevelBasis {
 public:
  LevelBasis(const Index3& dims, int num_levels);

  int num_levels() const noexcept { return static_cast<int>(axes_.size()); }
  Index3 nodes(int level) const noexcept;
  std::size_t offset(int level) const noexcept { return offsets_[static_cast<std::size_t>(level)]; }
  std::size_t num_weights() const noexcept { return offsets_.back(); }
  std::size_t num_samples() const noexcept;
  const LevelAxis& axis(int level, int a) const noexcept {
    return axes_[static_cast<std::size_t>(level)][static_cast<std::size_t>(a)];
  }

  // samples += factor * the kernels of levels first to last - 1.
  void expand(std::span<const float> weights, int first, int last, float factor,
              std::span<float> samples, const LevelWork& work) const;
  // The same of one level, whose weights alone are given.
  void expand_level(std::span<const float> weights, int level, float factor,
                    std::span<float> samples, const LevelWork& work) const;
  // weights of those levels = the kernels' products with the samples.
  void reduce(std::span<const float> samples, int first, int last, std::span<float> weights,
              const LevelWork& work) const;

 private:
  void expand_planes(std::span<const float> of_level, int level, std::int64_t begin,
                     std::int64_t end, float factor, std::span<float> samples) const;
  void reduce_plane(std::span<const float> samples, int level, std::int64_t node,
                    std::span<float> weights) const;

  Index3 dims_;
  std::vector<std::array<LevelAxis, 3>> axes_;
  std::vector<std::size_t> offsets_;  // [num_levels + 1]
};

}  // namespace ovoid::data
