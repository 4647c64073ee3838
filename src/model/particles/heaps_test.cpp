// SPDX-License-Identifier: Apache-2.0
// Particles that lie as no tree likes them: at one place, on few, on a line, far off. Fails if
// lengths or the field are not what brute force finds, or if the search compares many more sites
// than it does where they lie evenly.
#include "model/particles/heaps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>

#include "model/lattice/noise.h"
#include "model/particles/particle_lengths.h"
#include "model/test_datasets.h"
#include "ovoid/model.h"
#include "support/where.h"

namespace ovoid::model {
namespace heaps_test {

using Layout = std::function<std::vector<Vec3>(int count)>;

std::vector<Vec3> evenly(int count, std::uint64_t seed = 1) {
  Random random(seed);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(0, 1), y = random.uniform(0, 1), z = random.uniform(0, 1);
    points.emplace_back(x, y, z);
  }
  return points;
}

// `count` particles at as many places as there are in `places`, by turns.
std::vector<Vec3> heaps_at(const std::vector<Vec3>& places, int count) {
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i)
    points.push_back(places[static_cast<std::size_t>(i * 7919) % places.size()]);
  return points;
}

std::vector<Vec3> mapped(std::vector<Vec3> points, const std::function<Vec3(const Vec3&)>& map) {
  for (Vec3& point : points) point = map(point);
  return points;
}

std::vector<Vec3> partly(int count, double share, const Vec3& place) {
  std::vector<Vec3> points = evenly(count);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (static_cast<double>(i % 100) < 100 * share) points[i] = place;
  }
  return points;
}

std::map<std::string, Layout> layouts() {
  const Vec3 middle(0.5, 0.5, 0.5);
  return {
      {"one place", [=](int n) { return heaps_at({middle}, n); }},
      {"two places", [](int n) { return heaps_at(evenly(2), n); }},
      {"ten places", [](int n) { return heaps_at(evenly(10), n); }},
      {"sixteen at each", [](int n) { return heaps_at(evenly(n / 16), n); }},
      {"forty at each", [](int n) { return heaps_at(evenly(n / 40), n); }},
      {"of duplicates", [](int n) { return heaps_at(heaps_at(evenly(n / 64), n / 8), n); }},
      {"a tenth in the middle", [=](int n) { return partly(n, 0.1, middle); }},
      {"a tenth in the corner", [](int n) { return partly(n, 0.1, Vec3::Zero()); }},
      {"nearly all in the middle", [=](int n) { return partly(n, 0.98, middle); }},
      {"a line",
       [](int n) { return mapped(evenly(n), [](const Vec3& p) { return Vec3(p.x(), 0, 0); }); }},
      {"a plane",
       [](int n) {
         return mapped(evenly(n), [](const Vec3& p) { return Vec3(p.x(), 2, p.z()); });
       }},
      {"a sphere around a heap",
       [=](int n) {
         return mapped(partly(n, 0.5, middle), [=](const Vec3& p) {
           return p == middle ? Vec3(Vec3::Zero()) : Vec3((p - middle).normalized());
         });
       }},
      {"a steep core",
       [=](int n) {
         return mapped(evenly(n), [=](const Vec3& p) {
           return Vec3(middle + (p - middle) * std::pow((p - middle).norm(), 4));
         });
       }},
      {"one far off", [](int n) {
         std::vector<Vec3> points = evenly(n);
         points.back() = Vec3(1e12, -1e12, 1e12);
         return points;
       }}};
}

class Lengths {
 public:
  NearestStatistics of(const std::vector<Vec3>& points, WithCovariances with) {
    std::vector<double> sites;
    for (const Vec3& p : points) sites.insert(sites.end(), {p.x(), p.y(), p.z()});
    return nearest_statistics(run_, sites, std::nullopt, with);
  }

 private:
  Dataset dataset_;
  KernelModelOptions options_;
  KernelModelReport report_;
  ModelRun run_{dataset_, options_, report_, 2, {}};
};

TEST(Heaps, LengthsAreThoseOfBruteForce) {
  constexpr std::size_t kNeighbors = 32;
  for (const auto& [name, layout] : layouts()) {
    const std::vector<Vec3> points = layout(700);
    const NearestStatistics found = Lengths().of(points, WithCovariances::kYes);
    const NearestStatistics alone = Lengths().of(points, WithCovariances::kNo);  // in floats
    for (std::size_t i = 0; i < points.size(); i += 3) {
      std::vector<double> squares;
      for (const Vec3& point : points) squares.push_back((point - points[i]).squaredNorm());
      std::vector<double> sorted = squares;
      std::nth_element(sorted.begin(), sorted.begin() + kNeighbors - 1, sorted.end());
      const double last = sorted[kNeighbors - 1];
      ASSERT_NEAR(found.lengths[i], std::sqrt(last) / 2, 1e-6 * std::sqrt(last))
          << name << " " << i;
      ASSERT_NEAR(alone.lengths[i], std::sqrt(last) / 2, 1e-5 * std::sqrt(last))
          << name << " " << i;
      double trace = 0, count = 0;
      for (const double square : squares) {
        if (square > last) continue;
        trace += square;
        ++count;
      }
      if (last > 0) trace *= 4 / (last * count);
      const float* covariance = found.covariances.data() + 6 * i;
      ASSERT_NEAR(covariance[0] + covariance[2] + covariance[5], trace, 1e-5 * (1 + trace))
          << name << " " << i;
    }
  }
}

// What the search costs, in sites compared: with the square of a heap's size it would be hundreds
// of times more.
TEST(Heaps, CostWhatEvenLayoutsCost) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  constexpr int kCount = 20000;
  for (const WithCovariances with : {WithCovariances::kNo, WithCovariances::kYes}) {
    const std::int64_t even = Lengths().of(evenly(kCount), with).num_pairs;
    for (const auto& [name, layout] : layouts())
      EXPECT_LE(Lengths().of(layout(kCount), with).num_pairs, 2 * even) << name;
  }
}

// The sums of all particles' kernels at a place, by the definition.
struct Sums {
  double of_weights = 0, of_values = 0, of_colors = 0;
};

Sums sums_at(const Vec3& place, const std::vector<Vec3>& points, const std::vector<float>& lengths,
             const std::vector<float>& masses, const std::vector<float>& colors, bool is_density) {
  constexpr double kCutoff = 4;
  Sums sums;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double sigma = lengths[i] / 2;
    const double m = (points[i] - place).norm() / sigma;
    if (m > kCutoff) continue;
    double phi = profile_value(KernelProfile::kGaussian, m, kCutoff);
    if (is_density)
      phi *=
          masses[i] / (profile_integral(KernelProfile::kGaussian, kCutoff) * sigma * sigma * sigma);
    sums.of_weights += phi;
    sums.of_values += phi * masses[i];
    sums.of_colors += phi * colors[i];
  }
  return sums;
}

TEST(Heaps, AreOneKernelOfTheSameField) {
  const std::vector<Vec3> heaps = heaps_at({{0.5, 0.5, 0.5}, {0.2, 0.3, 0.8}, {0, 0, 0}}, 300);
  std::vector<Vec3> points = evenly(400);
  points.insert(points.end(), heaps.begin(), heaps.end());
  points.insert(points.end(), 3, Vec3(0.9, 0.9, 0.1));  // too few to be a heap
  std::vector<float> masses, colors;
  Random random(2);
  for (std::size_t i = 0; i < points.size(); ++i) {
    masses.push_back(static_cast<float>(random.uniform(1, 3)));
    colors.push_back(static_cast<float>(random.uniform(-5, 5)));
  }
  masses[401] = 9;  // in a heap
  std::vector<float> lengths = Lengths().of(points, WithCovariances::kNo).lengths;
  float least = 1;
  for (const float length : lengths) least = length > 0 ? std::min(least, length) : least;
  for (float& length : lengths) length = length > 0 ? length : least;
  Dataset dataset = points_dataset(DatasetKind::kParticles, points);
  dataset.arrays = {array_of_numbers("mass", 1, masses), array_of_numbers("c", 1, colors)};
  for (const bool is_density : {false, true}) {
    KernelModelReport report;
    const KernelField field = make_kernel_field(dataset,
                                                {.array = is_density ? "" : "mass",
                                                 .color_array = "c",
                                                 .is_density = is_density,
                                                 .mass_array = is_density ? "mass" : ""},
                                                &report);
    EXPECT_EQ(field.num_kernels(), 406);
    EXPECT_EQ(report.num_merged, 297);
    EXPECT_EQ(report.num_degenerate, 3);
    EXPECT_EQ(field.source().attributes()[0].range.hi, 9.0F) << "the values are those of all";
    const KernelSampler sampler(field);
    std::vector<Vec3> places = evenly(200, 7);
    for (const Vec3& heap : {heaps[0], heaps[1], heaps[2]}) {
      places.push_back(heap);
      places.push_back(heap + Vec3::Constant(0.3 * static_cast<double>(least)));
    }
    for (const Vec3& place : places) {
      const Sums sums = sums_at(place, points, lengths, masses, colors, is_density);
      const KernelSample sample = sampler.at(place);
      if (!sample.is_defined) continue;
      const double value = is_density ? sums.of_weights : sums.of_values / sums.of_weights;
      // Kernels' numbers are float32.
      EXPECT_NEAR(sample.value, value, 2e-5 * value);
      EXPECT_NEAR(sample.color_value, sums.of_colors / sums.of_weights, 2e-4);
    }
  }
}

}  // namespace heaps_test
}  // namespace ovoid::model
