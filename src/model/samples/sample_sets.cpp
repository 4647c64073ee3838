// SPDX-License-Identifier: Apache-2.0
#include "model/samples/sample_sets.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "model/lattice/noise.h"
#include "model/own_array.h"
#include "ovoid/math.h"

namespace ovoid::model {

namespace {

// Normally distributed, by the Box-Muller transform.
double normal(Random& random) {
  const double radius = std::sqrt(-2 * std::log(1 - random.uniform(0, 1)));
  return radius * std::cos(random.uniform(0, 2 * std::numbers::pi));
}

Vec3 normal_place(Random& random) {
  const double x = normal(random), y = normal(random), z = normal(random);
  return {x, y, z};
}

struct Star {
  Vec3 place = Vec3::Zero();
  double age = 0;   // Gyr
  double mass = 1;  // relative
};

// Two arms of an exponential disc, scale length 1: matter gathers where the angle follows the
// logarithm of the radius.
Star disc_star(Random& random) {
  const double radius = -std::log((1 - random.uniform(0, 1)) * (1 - random.uniform(0, 1)));
  const double arm = 3.2 * std::log(radius + 0.25);
  double angle = random.uniform(0, 2 * std::numbers::pi);
  const double near = std::cos(2 * (angle - arm));
  angle -= 0.35 * std::sin(2 * (angle - arm));
  Star star;
  star.place = {radius * std::cos(angle), radius * std::sin(angle), 0.06 * normal(random)};
  star.age = 2.5 - 2 * near + random.uniform(0, 1);
  star.mass = 0.6;
  return star;
}

// Plummer's sphere of scale `scale`, cut at ten of them.
Vec3 plummer_place(Random& random, double scale) {
  double radius = 0;
  do {
    radius = 1 / std::sqrt(std::pow(random.uniform(1e-9, 1), -2.0 / 3) - 1);
  } while (radius > 10);
  return normal_place(random).normalized() * (radius * scale);
}

constexpr int kNumClumps = 24;  // of the halo: small and dense

Dataset make_galaxy(std::int64_t count, std::uint64_t seed) {
  Random random(seed);
  std::array<Vec3, kNumClumps> clumps;
  for (Vec3& clump : clumps) clump = plummer_place(random, 3);
  std::vector<float> positions, ages, masses;
  for (std::int64_t i = 0; i < count; ++i) {
    const double kind = random.uniform(0, 1);
    Star star;
    if (kind < 0.5) {
      star = disc_star(random);
    } else if (kind < 0.65) {
      star = {plummer_place(random, 0.2), 10 + random.uniform(-1, 1), 0.9};
    } else if (kind < 0.9) {
      star = {plummer_place(random, 2.5), 12 + random.uniform(-1, 1), 1.5};
    } else {
      const auto clump = static_cast<std::size_t>(random.next() % kNumClumps);
      star = {clumps[clump] + plummer_place(random, 0.01 + 0.002 * static_cast<double>(clump)),
              8 + random.uniform(-1, 1), 1.2};
    }
    for (const double coordinate : star.place) positions.push_back(static_cast<float>(coordinate));
    ages.push_back(static_cast<float>(star.age));
    masses.push_back(static_cast<float>(star.mass / static_cast<double>(count)));
  }
  Dataset dataset;
  dataset.kind = DatasetKind::kParticles;
  dataset.positions = array_of_numbers("positions", 3, std::move(positions));
  dataset.arrays.push_back(array_of_numbers("age", 1, std::move(ages)));
  dataset.arrays.back().unit = "Gyr";
  dataset.arrays.push_back(array_of_numbers("mass", 1, std::move(masses)));
  return dataset;
}

Dataset make_blobs(std::int64_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> positions;
  std::vector<float> scales, rotations, values;
  // As many as there may be, they fill the cube equally.
  const double size = 0.55 / std::cbrt(static_cast<double>(count));
  for (std::int64_t i = 0; i < count; ++i) {
    for (int a = 0; a < 3; ++a) positions.push_back(random.uniform(-1, 1));
    for (int a = 0; a < 3; ++a)
      scales.push_back(static_cast<float>(size * std::exp(0.6 * normal(random))));
    const double w = normal(random), x = normal(random), y = normal(random), z = normal(random);
    const Eigen::Vector4d q = Eigen::Vector4d(w, x, y, z).normalized();
    for (const double number : q) rotations.push_back(static_cast<float>(number));
    values.push_back(static_cast<float>(random.uniform(0.1, 1)));
  }
  Dataset dataset;
  dataset.kind = DatasetKind::kKernels;
  dataset.positions = array_of_numbers("positions", 3, std::move(positions));
  dataset.arrays.push_back(array_of_numbers("scale", 3, std::move(scales)));
  dataset.arrays.push_back(array_of_numbers("rotation", 4, std::move(rotations)));
  dataset.arrays.push_back(array_of_numbers("value", 1, std::move(values)));
  return dataset;
}

constexpr std::array<SampleSet, 3> kSampleSets = {{
    {"fin", "flow around a blunt fin, tetrahedra", 20000, kLeastFinNodes, "nodes", make_fin},
    {"galaxy", "particles of a disc with arms, a halo and clumps", 100000, 1, "particles",
     make_galaxy},
    {"blobs", "ellipsoids of all shapes, stored kernels", 500, 1, "kernels", make_blobs},
}};

}  // namespace

std::span<const SampleSet> sample_sets() noexcept { return kSampleSets; }

}  // namespace ovoid::model
