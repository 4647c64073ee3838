// SPDX-License-Identifier: Apache-2.0
// Kernels lie in groups of kGroup along a Morton curve. A tree over the boxes of the groups'
// supports finds, for all centres of a group together, the groups whose kernels may reach them;
// against each of those every centre is tested in one loop over plain floats, offsets from the
// group's own origin, that the compiler turns into SIMD code. Only the few kernels that do reach a
// centre cost an exponential.
#include "model/amplitudes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "data/parallel.h"
#include "model/site_order.h"
#include "ovoid/math.h"

namespace ovoid::model {

namespace {

constexpr std::size_t kGroup = 32;
constexpr std::size_t kTreeFanOut = 8;
constexpr double kPassExponent = 0.7;
// A pass changes no weight by more than this factor, so that what a bad mesh leaves far off cannot
// swing to and fro.
constexpr double kMostChange = 8;

struct KernelGroup {
  Vec3 origin = Vec3::Zero();
  std::size_t count = 0;
  std::array<std::array<float, kGroup>, 3> center{};
  // Reciprocals of the factor's diagonal, and what is below it.
  std::array<std::array<float, kGroup>, 3> per_diagonal{};
  std::array<std::array<float, kGroup>, 3> below{};  // yx, zx, zy
  std::array<float, kGroup> weight{};
};

class SumOfWeights {
 public:
  SumOfWeights(const AmplitudeProblem& problem, const std::vector<float>& weights)
      : problem_(problem), order_(morton_order(problem.centers, problem.threads)) {
    const std::size_t num_groups = (order_.size() + kGroup - 1) / kGroup;
    groups_.resize(num_groups);
    levels_.emplace_back(num_groups);
    center_boxes_.resize(num_groups);
    for (std::size_t g = 0; g < num_groups; ++g) fill_group(g);
    set_weights(weights);
    while (levels_.back().size() > 1) {
      std::vector<Bounds3> above((levels_.back().size() + kTreeFanOut - 1) / kTreeFanOut);
      for (std::size_t i = 0; i < levels_.back().size(); ++i)
        above[i / kTreeFanOut].extend(levels_.back()[i]);
      levels_.push_back(std::move(above));
    }
  }

  void set_weights(const std::vector<float>& weights) {
    for (std::size_t i = 0; i < order_.size(); ++i)
      groups_[i / kGroup].weight[i % kGroup] = weights[order_[i]];
  }

  // sums[i] = F at centre i.
  void evaluate(std::vector<float>& sums) const {
    data::parallel_ranges(
        {static_cast<std::int64_t>(groups_.size()), 16, problem_.threads, problem_.stop},
        [&](std::int64_t begin, std::int64_t end) {
          std::vector<std::uint32_t> near;
          for (auto g = static_cast<std::size_t>(begin); g < static_cast<std::size_t>(end); ++g) {
            near.clear();
            find_near(levels_.size() - 1, 0, center_boxes_[g], near);
            const std::size_t first = g * kGroup;
            for (std::size_t i = 0; i < groups_[g].count; ++i)
              sums[order_[first + i]] = sum_at(center(order_[first + i]), near);
          }
        });
  }

 private:
  Vec3 center(std::size_t i) const {
    return {problem_.centers[3 * i], problem_.centers[3 * i + 1], problem_.centers[3 * i + 2]};
  }

  void fill_group(std::size_t g) {
    KernelGroup& group = groups_[g];
    const std::size_t first = g * kGroup;
    group.count = std::min(kGroup, order_.size() - first);
    for (std::size_t i = 0; i < group.count; ++i)
      center_boxes_[g].extend(center(order_[first + i]));
    group.origin = center_boxes_[g].center();
    for (std::size_t i = 0; i < group.count; ++i) {
      const std::size_t kernel = order_[first + i];
      const float* l = problem_.shapes.data() + 6 * kernel;
      const Vec3 at = center(kernel);
      for (std::size_t a = 0; a < 3; ++a)
        group.center[a][i] =
            static_cast<float>(at[static_cast<int>(a)] - group.origin[static_cast<int>(a)]);
      group.per_diagonal[0][i] = 1 / l[0];
      group.per_diagonal[1][i] = 1 / l[2];
      group.per_diagonal[2][i] = 1 / l[5];
      group.below[0][i] = l[1];
      group.below[1][i] = l[3];
      group.below[2][i] = l[4];
      const Vec3 reach = problem_.cutoff *
                         Vec3(std::abs(l[0]), std::hypot(l[1], l[2]), std::hypot(l[3], l[4], l[5]));
      levels_[0][g].extend(Bounds3(at - reach, at + reach));
    }
  }

  void find_near(std::size_t level, std::size_t node, const Bounds3& box,
                 std::vector<std::uint32_t>& near) const {
    if (!levels_[level][node].intersects(box)) return;
    if (level == 0) {
      near.push_back(static_cast<std::uint32_t>(node));
      return;
    }
    const std::size_t end = std::min((node + 1) * kTreeFanOut, levels_[level - 1].size());
    for (std::size_t child = node * kTreeFanOut; child < end; ++child)
      find_near(level - 1, child, box, near);
  }

  float sum_at(const Vec3& place, const std::vector<std::uint32_t>& near) const {
    const auto most = static_cast<float>(problem_.cutoff * problem_.cutoff);
    const float at_end = std::exp(-0.5F * most);
    std::array<float, kGroup> distance;
    double sum = 0;
    for (const std::uint32_t g : near) {
      if (!levels_[0][g].contains(place)) continue;
      const KernelGroup& group = groups_[g];
      const Eigen::Vector3f at = (place - group.origin).cast<float>();
      for (std::size_t i = 0; i < kGroup; ++i) {
        const float a = (at[0] - group.center[0][i]) * group.per_diagonal[0][i];
        const float b =
            (at[1] - group.center[1][i] - group.below[0][i] * a) * group.per_diagonal[1][i];
        const float c =
            (at[2] - group.center[2][i] - group.below[1][i] * a - group.below[2][i] * b) *
            group.per_diagonal[2][i];
        distance[i] = a * a + b * b + c * c;
      }
      for (std::size_t i = 0; i < group.count; ++i) {
        if (!(distance[i] <= most)) continue;
        const float tangent = at_end * (1 + 0.5F * (most - distance[i]));  // profile_value()
        sum += static_cast<double>(group.weight[i] * (std::exp(-0.5F * distance[i]) - tangent));
      }
    }
    return static_cast<float>(sum);
  }

  const AmplitudeProblem& problem_;
  std::vector<std::uint32_t> order_;
  std::vector<KernelGroup> groups_;
  std::vector<Bounds3> center_boxes_;
  std::vector<std::vector<Bounds3>> levels_;  // [0]: of the groups' supports
};

}  // namespace

std::vector<float> fit_amplitudes(const AmplitudeProblem& problem, std::vector<float>& weights) {
  std::vector<float> sums(weights.size());
  SumOfWeights field(problem, weights);
  for (int pass = 0; pass <= problem.passes; ++pass) {
    field.evaluate(sums);
    if (pass == problem.passes) break;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const double ratio = static_cast<double>(sums[i] / problem.targets[i]);
      const double change =
          std::clamp(std::pow(ratio, -kPassExponent), 1 / kMostChange, kMostChange);
      weights[i] = static_cast<float>(static_cast<double>(weights[i]) * change);
    }
    field.set_weights(weights);
  }
  return sums;
}

}  // namespace ovoid::model
