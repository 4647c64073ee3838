// SPDX-License-Identifier: Apache-2.0
// Normals from depths of surfaces whose normals are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "ovoid/error.h"
#include "ovoid/image.h"

namespace ovoid {
namespace depth_normals_test {

constexpr int kWidth = 90, kHeight = 64;
constexpr double kDegree = std::numbers::pi / 180;

// A ray of a pixel's centre; along it the depth grows by 1.
struct PixelRay {
  Vec3 origin, direction;
};

struct Hit {
  double depth;
  Vec3 normal;  // to either side
};
using SurfaceAt = std::function<std::optional<Hit>(const PixelRay&)>;

Camera slanted_camera(bool is_parallel) {
  Camera camera;
  camera.position = {3, -7, 5};
  camera.focal_point = {0.5, 1, -1};
  camera.view_up = {0.2, 0.3, 1};
  camera.parallel_projection = is_parallel;
  camera.parallel_scale = 2;
  camera.view_angle = 25;
  return camera;
}

PixelRay ray_of(const Camera& camera, int x, int y) {
  const Vec3 axis = (camera.focal_point - camera.position).normalized();
  const Vec3 right = axis.cross(camera.view_up).normalized();
  const Vec3 up = right.cross(axis);
  const double aspect = static_cast<double>(kWidth) / kHeight;
  const Vec3 across =
      (2 * (x + 0.5) / kWidth - 1) * aspect * right + (1 - 2 * (y + 0.5) / kHeight) * up;
  if (camera.parallel_projection) return {camera.position + camera.parallel_scale * across, axis};
  return {camera.position, axis + std::tan(camera.view_angle / 2 * kDegree) * across};
}

// Angles in degrees between normals of a surface and those from its depths; < 0: no surface.
std::vector<double> errors_of(const Camera& camera, const SurfaceAt& surface) {
  std::vector<float> depths;
  std::vector<Vec3> expected;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const PixelRay ray = ray_of(camera, x, y);
      const std::optional<Hit> hit = surface(ray);
      depths.push_back(hit ? static_cast<float>(hit->depth)
                           : std::numeric_limits<float>::infinity());
      const Vec3 normal = hit ? hit->normal.normalized() : Vec3(0, 0, 0);
      expected.push_back(normal.dot(ray.direction) > 0 ? Vec3(-normal) : normal);
    }
  }
  const std::vector<float> normals = depth_normals(depths, kWidth, kHeight, camera, 2);
  EXPECT_EQ(normals, depth_normals(depths, kWidth, kHeight, camera, 1));
  std::vector<double> errors;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Vec3 normal(normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]);
    if (std::isinf(depths[i])) {
      EXPECT_EQ(normal, Vec3(0, 0, 0));
      errors.push_back(-1);
      continue;
    }
    EXPECT_NEAR(normal.norm(), 1, 1e-6);
    errors.push_back(2 * std::asin(std::min(0.5 * (normal - expected[i]).norm(), 1.0)) / kDegree);
  }
  return errors;
}

SurfaceAt plane(const Vec3& normal, const Vec3& through) {
  return [=](const PixelRay& ray) -> std::optional<Hit> {
    return Hit{normal.dot(through - ray.origin) / normal.dot(ray.direction), normal};
  };
}

SurfaceAt ball(const Vec3& center, double radius) {
  return [=](const PixelRay& ray) -> std::optional<Hit> {
    const Vec3 from = ray.origin - center;
    const double a = ray.direction.squaredNorm();
    const double b = from.dot(ray.direction);
    const double inside = b * b - a * (from.squaredNorm() - radius * radius);
    if (inside < 0) return std::nullopt;
    const double depth = (-b - std::sqrt(inside)) / a;
    return Hit{depth, ray.origin + depth * ray.direction - center};
  };
}

// What is in front of two surfaces.
SurfaceAt nearer(const SurfaceAt& a, const SurfaceAt& b) {
  return [=](const PixelRay& ray) {
    const std::optional<Hit> of_a = a(ray);
    const std::optional<Hit> of_b = b(ray);
    return !of_b || (of_a && of_a->depth < of_b->depth) ? of_a : of_b;
  };
}

double greatest(const std::vector<double>& errors) {
  return *std::max_element(errors.begin(), errors.end());
}

double share_above(const std::vector<double>& errors, double degrees) {
  const auto count =
      std::count_if(errors.begin(), errors.end(), [&](double e) { return e > degrees; });
  const auto seen = std::count_if(errors.begin(), errors.end(), [](double e) { return e >= 0; });
  return static_cast<double>(count) / static_cast<double>(seen);
}

// A float has 5e-7 of these depths, a pixel is 0.06 wide, and slopes at the picture's rim are of
// three pixels, with weights up to 2: 0.005 degrees. Fails if an axis, a sign, the middle of the
// picture or the perspective is off.
TEST(DepthNormals, OfPlanesAreExact) {
  for (const bool is_parallel : {true, false}) {
    const Camera camera = slanted_camera(is_parallel);
    const Vec3 axis = (camera.focal_point - camera.position).normalized();
    for (const Vec3& tilt : {Vec3(0, 0, 0), Vec3(0.6, 0.1, 0), Vec3(-0.2, 0.8, 0.3)}) {
      const auto errors = errors_of(camera, plane(axis + tilt, camera.focal_point));
      EXPECT_LT(greatest(errors), 0.02) << is_parallel << " " << tilt.transpose();
    }
  }
}

// A radius of 24 pixels. The parabola errs by the third derivative of the depth, some 4 (pixel /
// radius)^2 over powers of the cosine: half a degree half-way out. Outlines bend more than pixels
// can tell.
TEST(DepthNormals, OfBallsAreSmooth) {
  for (const bool is_parallel : {true, false}) {
    const Camera camera = slanted_camera(is_parallel);
    const auto errors = errors_of(camera, ball(camera.focal_point, 1.5));
    EXPECT_LT(share_above(errors, 0.5), 0.5) << is_parallel;
    EXPECT_LT(share_above(errors, 1.6), 0.1) << is_parallel;
    EXPECT_LT(share_above(errors, 5), 0.03) << is_parallel;
    const auto middle = errors[static_cast<std::size_t>(kHeight / 2 * kWidth + kWidth / 2)];
    EXPECT_LT(middle, 0.1) << is_parallel;
  }
}

// Fails if what lies on the far side of a step, or farther than two pixels beyond a crease, is
// mixed in.
TEST(DepthNormals, StopAtStepsAndCreases) {
  for (const bool is_parallel : {true, false}) {
    const Camera camera = slanted_camera(is_parallel);
    const Vec3 axis = (camera.focal_point - camera.position).normalized();
    const Vec3 right = axis.cross(camera.view_up).normalized();
    const SurfaceAt wall = plane(axis + 0.4 * right, camera.focal_point + 3 * axis);
    const SurfaceAt near = plane(axis - 0.2 * right, camera.focal_point);
    const auto step = errors_of(camera, [&](const PixelRay& ray) {
      const Vec3 at = ray.origin + near(ray)->depth * ray.direction;
      return (at - camera.focal_point).dot(right) < 0.3 ? near(ray) : wall(ray);
    });
    EXPECT_LT(greatest(step), 0.05) << is_parallel;
    // Two walls of a valley.
    const auto crease = errors_of(camera, nearer(plane(axis + right, camera.focal_point + axis),
                                                 plane(axis - right, camera.focal_point + axis)));
    EXPECT_LT(share_above(crease, 0.1), 4.5 / kWidth) << is_parallel;
  }
}

// Depths in steps of samples, as pictures have them, here half a pixel's width apart. Fails if
// normals are those of single differences, of which half are wrong by more than 6 degrees.
TEST(DepthNormals, OfSampledDepthsAreMeans) {
  const Camera camera = slanted_camera(true);
  const double step = 0.5 * 2 * camera.parallel_scale / kHeight;
  const SurfaceAt exact = ball(camera.focal_point, 1.5);
  const auto errors = errors_of(camera, [&](const PixelRay& ray) {
    std::optional<Hit> hit = exact(ray);
    if (hit) hit->depth = step * std::round(hit->depth / step);
    return hit;
  });
  EXPECT_LT(share_above(errors, 6), 0.1);
}

TEST(DepthNormals, OfFewPixels) {
  const Camera camera = slanted_camera(true);
  const float nowhere = std::numeric_limits<float>::infinity();
  const Vec3 back = -(camera.focal_point - camera.position).normalized();
  const auto expect_back = [&](const std::vector<float>& normals, std::size_t pixel) {
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_FLOAT_EQ(normals[3 * pixel + a], static_cast<float>(back[static_cast<int>(a)]));
  };
  expect_back(depth_normals(std::vector<float>{3}, 1, 1, camera), 0);
  const std::vector<float> two = depth_normals(std::vector<float>{3, 3, nowhere}, 3, 1, camera);
  expect_back(two, 0);
  expect_back(two, 1);
  EXPECT_EQ(two[6], 0);
  EXPECT_THROW(depth_normals(std::vector<float>(5), 2, 3, camera), Error);
  EXPECT_THROW(depth_normals(std::vector<float>(), 0, 0, camera), Error);
}

}  // namespace depth_normals_test
}  // namespace ovoid
