// SPDX-License-Identifier: Apache-2.0
#include "experiments/grid_pattern.h"

#include <cmath>

namespace ovoid::experiments {

namespace {

constexpr std::int64_t kGridSize = 32;
constexpr double kGridMiddle = (kGridSize - 1) / 2.0;
constexpr double kGridMargin = 4;  // spacings
constexpr double kSurface =
    16;  // the value on the surface, from which it falls by 1 per spacing outwards
constexpr double kRadius = 11;  // of the ball, spacings
const Vec3 kSlope = Vec3(3, 2, 4).normalized();
const Vec3 kLight = Vec3(-0.35, 0.5, 0.9).normalized();
constexpr double kAmbient = 0.1;
constexpr double kDiffuse = 0.9;

// Signed distance to the surface, spacings: exactly linear, or without a kink outside the centre.
double distance_to(SmoothSurface surface, const Vec3& p) {
  return surface == SmoothSurface::kPlane ? p.dot(kSlope) : p.norm() - kRadius;
}

Dataset dataset_with(SmoothSurface surface) {
  Dataset dataset = dataset_of({kGridSize, kGridSize, kGridSize}, [&](auto i, auto j, auto k) {
    const Vec3 p(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
    return kSurface - distance_to(surface, p - Vec3::Constant(kGridMiddle));
  });
  dataset.lattice.world_from_index = Eigen::Translation3d(Vec3::Constant(-kGridMiddle));
  return dataset;
}

Look matte() {
  Look look;
  look.mode = Mode::kIsosurface;
  look.isovalue = kSurface;
  look.transfer_function.colors = {{0, {1, 1, 1}}, {2 * kSurface, {1, 1, 1}}};
  look.material = {kAmbient, kDiffuse, 0, 1};
  look.light_direction = kLight;
  return look;
}

// The brightness where the ray along -z through (x, y) meets the surface, from the surface alone;
// negative where there is none, near the ball's outline, and near the lattice's faces, where a
// field has fewer samples to go by.
double brightness(SmoothSurface surface, double x, double y) {
  const double plane_z = -(x * kSlope.x() + y * kSlope.y()) / kSlope.z();
  if (surface == SmoothSurface::kPlane && std::abs(plane_z) > kGridMiddle - kGridMargin) return -1;
  if (surface == SmoothSurface::kPlane) return kAmbient + kDiffuse * std::abs(kSlope.dot(kLight));
  const double z2 = kRadius * kRadius - x * x - y * y;
  if (z2 < 0.2 * kRadius * kRadius) return -1;
  const Vec3 normal = Vec3(x, y, std::sqrt(z2)) / kRadius;
  return kAmbient + kDiffuse * std::abs(normal.dot(kLight));
}

}  // namespace

GridPattern measure_grid_pattern(const KernelChoice& choice, const GridPatternOptions& options) {
  const LatticeField field = field_of(dataset_with(options.surface), choice);
  Camera camera;
  camera.position = {0, 0, 100};
  camera.focal_point = Vec3::Zero();
  camera.view_up = {0, 1, 0};
  camera.parallel_projection = true;
  camera.parallel_scale = options.pixels / options.pixels_per_sample / 2;
  RenderOptions render;
  render.sheets = ovoid::Sheets::kImage;
  render.width = options.pixels;
  render.height = options.pixels;
  render.classification = Classification::kSampled;
  render.gradient = options.gradient;

  GridPattern result;
  result.image = Renderer(Backend::kCpu).render({field, matte()}, camera, render).image;
  double sum = 0;
  double squares = 0;
  double count = 0;
  for (int row = 0; row < options.pixels; ++row) {
    for (int column = 0; column < options.pixels; ++column) {
      const double x = (column + 0.5 - options.pixels / 2.0) / options.pixels_per_sample;
      const double y = (options.pixels / 2.0 - row - 0.5) / options.pixels_per_sample;
      const double expected = brightness(options.surface, x, y);
      const float* pixel = result.image.rgba.data() + 4 * (row * options.pixels + column);
      if (expected < 0 || pixel[3] < 1) continue;
      const double error = static_cast<double>(pixel[0]) - expected;
      sum += error;
      squares += error * error;
      ++count;
    }
  }
  const double mean = sum / count;
  result.residual = 255 * std::sqrt(squares / count - mean * mean);
  return result;
}

}  // namespace ovoid::experiments
