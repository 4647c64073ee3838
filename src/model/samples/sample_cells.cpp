// SPDX-License-Identifier: Apache-2.0
// A cluster of cells under a fluorescence microscope: one stain in the nuclei, one in the
// membranes.
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "model/lattice/noise.h"
#include "model/samples/sample_formulas.h"

namespace ovoid::model {
namespace {

constexpr int kNumCells = 40;
constexpr double kClusterRadius = 0.66;
constexpr double kCellRadius = 0.26;
constexpr double kBackground = 0.03;

Vec3 in_ball(Random& random, double radius) {
  Vec3 p;
  do {
    for (int a = 0; a < 3; ++a) p[a] = random.uniform(-radius, radius);
  } while (p.norm() > radius);
  return p;
}

// Each the one of several candidates that is farthest from those before: no two overlap much.
std::vector<Vec3> centres_of(std::uint64_t seed) {
  constexpr int kNumCandidates = 40;
  Random random(seed);
  std::vector<Vec3> centres;
  while (centres.size() < kNumCells) {
    Vec3 best = Vec3::Zero();
    double farthest = -1;
    for (int i = 0; i < kNumCandidates; ++i) {
      const Vec3 p = in_ball(random, kClusterRadius);
      double nearest = std::numeric_limits<double>::max();
      for (const Vec3& centre : centres) nearest = std::min(nearest, (p - centre).norm());
      if (nearest > farthest) std::tie(farthest, best) = std::pair(nearest, p);
    }
    centres.push_back(best);
  }
  return centres;
}

// From the two nearest centres.
std::pair<double, double> two_distances(const std::vector<Vec3>& centres, const Vec3& p) {
  double first = std::numeric_limits<double>::max(), second = first;
  for (const Vec3& centre : centres) {
    const double distance = (p - centre).squaredNorm();
    second = std::min(second, std::max(first, distance));
    first = std::min(first, distance);
  }
  return {std::sqrt(first), std::sqrt(second)};
}

double background_at(const Vec3& p, std::uint64_t seed) {
  return kBackground * (1 + smooth_noise(90 * p, seed));
}

}  // namespace

Formula make_nuclei(std::uint64_t seed, double) {
  struct Nucleus {
    Vec3 centre, stretch;
  };
  std::vector<Nucleus> nuclei;
  Random random(seed + 1);
  for (const Vec3& centre : centres_of(seed)) {
    Nucleus nucleus{centre, Vec3::Zero()};
    for (int a = 0; a < 3; ++a) nucleus.stretch[a] = 1 / random.uniform(0.085, 0.13);
    nuclei.push_back(nucleus);
  }
  return [nuclei = std::move(nuclei), seed](const Vec3& p) {
    constexpr double kEdge = 0.2;  // of the radius
    double most = 0;
    for (const Nucleus& nucleus : nuclei) {
      const double radius = (p - nucleus.centre).cwiseProduct(nucleus.stretch).norm();
      const double t = std::clamp((1 - radius) / kEdge, 0.0, 1.0);
      most = std::max(most, t * t * (3 - 2 * t));
    }
    const double chromatin = 0.75 + 0.2 * smooth_noise(28 * p, seed);
    return std::clamp(most * chromatin + background_at(p, seed + 2), 0.0, 1.0);
  };
}

Formula make_membranes(std::uint64_t seed, double) {
  return [centres = centres_of(seed), seed](const Vec3& p) {
    constexpr double kThickness = 0.022;
    const auto [first, second] = two_distances(centres, p);
    // To where the neighbour's side begins, or the outside.
    const double depth = std::min((second - first) / 2, kCellRadius - first) / kThickness;
    const double patches = 0.75 + 0.2 * smooth_noise(12 * p, seed + 3);
    return std::clamp(std::exp(-0.5 * depth * depth) * patches + background_at(p, seed + 4), 0.0,
                      1.0);
  };
}

}  // namespace ovoid::model
