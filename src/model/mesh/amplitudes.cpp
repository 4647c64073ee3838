// SPDX-License-Identifier: Apache-2.0
#include "model/mesh/amplitudes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "data/parallel.h"
#include "model/particles/kernel_groups.h"
#include "ovoid/math.h"

namespace ovoid::model {

namespace {

constexpr double kPassExponent = 0.7;
// A pass changes no weight by more than this factor, so that what a bad mesh leaves far off cannot
// swing to and fro.
constexpr double kMostChange = 8;

// sums[i] = F at centre i: what lies around a group of kernels is looked up once for all of them.
void sum_weights(const AmplitudeProblem& problem, const KernelGroups& groups,
                 const std::vector<float>& weights, std::vector<float>& sums) {
  const auto sum_at = [&](const Vec3& place, const std::vector<std::uint32_t>& near) {
    KernelGroups::Squares squares;
    double sum = 0;
    for (const std::uint32_t g : near) {
      if (!groups.may_reach(g, place)) continue;
      groups.find_squares(g, place, squares);
      for (std::size_t i = 0; i < groups.size_of(g); ++i) {
        if (squares[i] <= groups.most_square())
          sum += static_cast<double>(weights[groups.kernel(g, i)] * groups.profile(squares[i]));
      }
    }
    return static_cast<float>(sum);
  };
  data::parallel_ranges(
      {static_cast<std::int64_t>(groups.count()), 16, problem.threads, problem.stop},
      [&](std::int64_t begin, std::int64_t end) {
        std::vector<std::uint32_t> near;
        for (auto g = static_cast<std::size_t>(begin); g < static_cast<std::size_t>(end); ++g) {
          near.clear();
          groups.find_near(groups.centers_of(g), near);
          for (std::size_t i = 0; i < groups.size_of(g); ++i) {
            const std::size_t kernel = groups.kernel(g, i);
            if (kernel >= sums.size()) continue;
            const double* const at = problem.centers.data() + 3 * kernel;
            sums[kernel] = sum_at({at[0], at[1], at[2]}, near);
          }
        }
      });
}

}  // namespace

std::vector<float> fit_amplitudes(const AmplitudeProblem& problem, std::vector<float>& weights) {
  std::vector<float> sums(weights.size() - problem.num_others);
  std::optional<KernelGroups> groups;
  if (!sums.empty())
    groups.emplace(problem.centers, problem.shapes, problem.cutoff, problem.threads);
  for (int pass = 0; pass <= problem.passes; ++pass) {
    if (groups) sum_weights(problem, *groups, weights, sums);
    if (pass == problem.passes) break;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const double ratio = static_cast<double>(sums[i] / problem.targets[i]);
      const double change =
          std::clamp(std::pow(ratio, -kPassExponent), 1 / kMostChange, kMostChange);
      weights[i] = static_cast<float>(static_cast<double>(weights[i]) * change);
    }
    if (problem.renew) problem.renew(weights);
  }
  return sums;
}

}  // namespace ovoid::model
