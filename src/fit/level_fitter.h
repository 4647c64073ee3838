// SPDX-License-Identifier: Apache-2.0
// Which nodes of LatticeLevels are kernels, and their weights: least squares over all samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stop_token>
#include <vector>

#include "data/lattice/level_basis.h"
#include "fit/level_pairs.h"

namespace ovoid::fit {

// The samples, less what lies behind the kernels, and the kernels so far. Every member costs a few
// passes over the samples; results do not depend on the number of threads.
class LevelFitter {
 public:
  // What sums of kernels are clamped to where they are read: beyond the least a sample that is the
  // least has no error, and so for the greatest.
  struct Limits {
    float least = -std::numeric_limits<float>::infinity();
    float greatest = std::numeric_limits<float>::infinity();
  };
  // Of the normal equations' matrix: entries beyond which it is not kept, by default, and bytes of
  // one.
  static constexpr std::size_t kMostPairs = std::size_t{1} << 27, kBytesPerPair = 8;

  // `samples`: NaN where they are missing.
  LevelFitter(const Index3& dims, std::vector<float> samples, const Limits& limits,
              const data::LevelWork& work, std::size_t most_pairs = kMostPairs);

  const data::LevelBasis& basis() const noexcept { return basis_; }
  std::int64_t num_kernels() const noexcept { return num_kernels_; }
  std::span<const float> weights() const noexcept { return weights_; }
  bool is_kernel(std::size_t node) const noexcept { return is_kernel_[node] != 0; }
  // Samples less the kernels' sums; 0 where a sum is beyond the limit that its sample is, and where
  // a sample is missing.
  std::span<const float> residual();
  double mean_square();  // of the residual, of samples that are there

  // From the coarsest level on: what is left of the samples, prefiltered for the level, and of that
  // the kernels that hold more than `threshold` of it (root of the sum of squares over samples).
  void start(double threshold);
  // So many more kernels, where the residual's product with a kernel is greatest, in units of the
  // kernel's norm.
  void grow(std::int64_t count);
  // A kernel of level 0 at a sample, if there is none.
  void add_kernel(std::size_t sample);
  // Takes away those that hold least until there are `count`.
  void prune(std::int64_t count);
  // So many steps of conjugate gradients. What was beyond a limit before them aims at where it was,
  // which never makes the sum of squares greater.
  void fit(int iterations);

 private:
  using Weights = std::vector<float>;
  class ThroughSamples;

  void fit_few(const std::vector<std::uint32_t>& nodes, int iterations);
  void fit_many(int iterations);
  std::vector<std::uint32_t> kernels() const;
  void refresh_residual();
  void refresh_products();
  void prefilter(int level, std::span<float> weights) const;
  void clear_holes();
  void solve_along(int level, int a, std::span<float> weights) const;
  template <class Term>
  double sum(std::size_t count, const Term& term) const;
  template <class Body>
  void for_each(std::size_t count, const Body& body) const;

  data::LevelBasis basis_;
  data::LevelWork work_;
  Limits limits_;
  std::size_t most_pairs_;
  LevelPairs pairs_;
  std::vector<float> samples_, residual_;
  double num_there_ = 0;  // samples that are not missing
  Weights weights_, inverse_norms_;
  Weights products_;  // of the residual with every kernel
  // Whether they are those of the weights.
  bool is_residual_ = false, are_products_ = false;
  std::vector<std::uint8_t> is_kernel_;
  std::int64_t num_kernels_ = 0;
};

}  // namespace ovoid::fit
