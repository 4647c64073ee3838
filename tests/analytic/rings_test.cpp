// SPDX-License-Identifier: Apache-2.0
// Sheets show as rings on smooth lit surfaces, and samples as terraces: fine patterns that neither
// the data nor the light has. How much there is of them is the energy of what is left when each
// pixel's surroundings are taken off.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "ovoid/model.h"
#include "support/agreement.h"
#include "support/scenes.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace rings_test {

using Shape = std::function<double(const Vec3& at)>;  // in [-1, 1]^3

// As programs get it: a dataset, drawn by the default kernel.
LatticeField default_field(const Shape& shape) {
  constexpr int kEdge = 40;
  auto values = std::make_shared<std::vector<float>>();
  for (int k = 0; k < kEdge; ++k) {
    for (int j = 0; j < kEdge; ++j) {
      for (int i = 0; i < kEdge; ++i)
        values->push_back(
            static_cast<float>(shape(2.0 / (kEdge - 1) * Vec3(i, j, k) - Vec3::Ones())));
    }
  }
  Dataset dataset;
  dataset.lattice.dims = {kEdge, kEdge, kEdge};
  DataArray array;
  array.name = "shape";
  array.num_tuples = static_cast<std::int64_t>(values->size());
  array.bytes = {values, std::as_bytes(std::span(*values))};
  dataset.arrays.push_back(array);
  return make_lattice_field(dataset);
}

// Of red, over pixels that are opaque with all around them: the mean square of the difference from
// the eight neighbours' mean.
double fine_energy(const Image& image) {
  double sum = 0;
  int count = 0;
  const auto at = [&](int x, int y) { return pixel(image, x, y); };
  for (int y = 1; y + 1 < image.height; ++y) {
    for (int x = 1; x + 1 < image.width; ++x) {
      double around = 0, least = 1;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          least = std::min(least, at(x + dx, y + dy).a());
          if (dx != 0 || dy != 0) around += at(x + dx, y + dy).r() / 8;
        }
      }
      if (least < 0.99) continue;
      sum += std::pow(at(x, y).r() - around, 2);
      ++count;
    }
  }
  EXPECT_GT(count, 500);
  return sum / count;
}

TEST(Rings, LitSurfacesHaveNoFinerPatternThanConvergedOnes) {
  constexpr double kInvisible = 0.25 / 255;  // a quarter of an 8-bit step
  double most_sampled = 0;
  // Surfaces across the line of sight, in the middle of the lattice.
  const Vec3 ahead = Vec3(0.48, -0.31, 0.82).normalized();
  const std::vector<std::pair<std::string, Shape>> shapes = {
      {"sphere", [](const Vec3& p) { return 1 - p.norm(); }},
      {"cone",
       [&](const Vec3& p) {
         const double depth = p.dot(ahead);
         return 0.5 + 0.3 * depth - 0.2 * (p - depth * ahead).norm();
       }},
      {"ramp", [&](const Vec3& p) { return 0.5 + 0.3 * p.dot(ahead) + 0.1 * p.x(); }}};
  for (const auto& [name, shape] : shapes) {
    const LatticeField field = default_field(shape);
    for (const double width : {0.01, 0.05}) {  // opaque within so much of the range
      for (const bool is_parallel : {true, false}) {
        Look look = uniform_look(1, {0.9, 0.5, 0.3});
        look.shade = true;
        look.transfer_function.opacities = {{0.4, 0}, {0.4 + width, 0.95}};
        TestScene scene{field, askew_camera(field, is_parallel, 2.5), look, picture(120, 120)};
        const double found = fine_energy(draw(scene).image);
        scene.options.classification = Classification::kSampled;
        const double sampled = fine_energy(draw(scene).image);
        scene.options.classification = Classification::kRefined;
        scene.options.post_convolution = PostConvolution::kOff;
        scene.options.sampling_distance = field.default_sampling_distance() / 32;
        const double converged = fine_energy(draw(scene).image);
        const double bound = 1.1 * converged + kInvisible * kInvisible;
        EXPECT_LT(found, bound) << name << ", " << width << ": converged " << converged;
        EXPECT_GT(found, 0.9 * converged - kInvisible * kInvisible) << name << ", " << width;
        most_sampled = std::max(most_sampled, sampled / bound);
      }
    }
  }
  EXPECT_GT(most_sampled, 3) << "samples alone show no rings here";
}

}  // namespace rings_test
}  // namespace ovoid::test
