// SPDX-License-Identifier: Apache-2.0
#include "render/passes/surface_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "ovoid/error.h"
#include "support/scenes.h"

namespace ovoid {
namespace surface_frame_test {

using test::parallel_camera;
using test::perspective_camera;
using test::pixel;

constexpr int kSide = 64;

RenderOptions options_of(int width = kSide, int height = kSide) {
  RenderOptions options;
  options.width = width;
  options.height = height;
  return options;
}

// Corners a, b, c, d around a flat square of side 2 * half in the plane z = depth, two triangles;
// values are x.
void add_square(Surface& surface, double half, double depth) {
  const auto first = static_cast<std::uint32_t>(surface.places.size());
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    surface.places.emplace_back(half * x, half * y, depth);
    surface.bounds.extend(surface.places.back());
  }
  for (const auto& [b, c, edges] : {std::tuple{1U, 2U, 3}, {2U, 3U, 6}}) {
    Surface::Triangle triangle;
    triangle.corners = {first, first + b, first + c};
    triangle.normals.fill(Eigen::Vector3f(0, 0, 1));
    for (std::size_t i = 0; i < 3; ++i)
      triangle.values[i] = static_cast<float>(surface.places[triangle.corners[i]].x());
    triangle.edges = static_cast<std::uint8_t>(edges);
    surface.triangles.push_back(triangle);
  }
}

Surface square(double half = 4, double depth = 0) {
  Surface surface;
  add_square(surface, half, depth);
  return surface;
}

// Gray by value, from -10 to 10.
Look gray() { return test::gray_look(-10, 10); }

TEST(RenderSurface, ShowsValuesAndDepthsExactly) {
  const Surface surface = square();
  for (const bool is_parallel : {true, false}) {
    const Camera camera = is_parallel ? parallel_camera({0, 0, 0}, {0, 0, -1}, 8, 20)
                                      : perspective_camera({0, 0, 0}, {0, 0, -1}, 8, 20);
    const Image image = paint_surface(surface, camera, gray(), {}, options_of()).image;
    for (int y = 20; y < 44; ++y) {
      for (int x = 18; x < 46; ++x) {
        // Right is +x or -x, as the camera's up says; the value is that of the place.
        const double across = (x + 0.5 - 32) / 32 * 8;
        const double right = (camera.focal_point - camera.position)
                                 .normalized()
                                 .cross(camera.view_up)
                                 .normalized()
                                 .x();
        EXPECT_NEAR(pixel(image, x, y).r(), (right * across + 10) / 20, 1e-5);
        EXPECT_EQ(pixel(image, x, y).a(), 1);
        EXPECT_NEAR(test::depth(image, x, y), 20, 1e-5);
      }
    }
    EXPECT_EQ(pixel(image, 2, 2).a(), 0);
    EXPECT_EQ(test::depth(image, 2, 2), std::numeric_limits<double>::infinity());
    // All that is seen has a front, also of what an outline leaves a quarter of.
    for (std::size_t i = 0; i < image.front_depth.size(); ++i)
      ASSERT_EQ(image.front_depth[i]<1e9F, image.rgba[4 * i + 3]> 0) << i;
  }
}

// What a pixel is covered by is known to a quarter: the sum is the area's to a per cent.
TEST(RenderSurface, OutlinesAreSmoothAndWithinHalfAPixel) {
  Surface surface = square(3);
  const double turn = 0.3;
  for (Vec3& place : surface.places) {
    place = Vec3(std::cos(turn) * place.x() - std::sin(turn) * place.y(),
                 std::sin(turn) * place.x() + std::cos(turn) * place.y(), 0);
  }
  const Image image = paint_surface(surface, parallel_camera({0, 0, 0}, {0, 0, -1}, 8, 20), gray(),
                                    {}, options_of())
                          .image;
  double covered = 0;
  int num_partly = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
    covered += image.rgba[i];
    if (image.rgba[i] > 0 && image.rgba[i] < 1) ++num_partly;
  }
  const double pixel_area = 0.25 * 0.25;
  EXPECT_NEAR(covered * pixel_area, 36, 0.01 * 36);
  EXPECT_GT(num_partly, 60);
}

// Fails if the diagonal is drawn twice, or left out.
TEST(RenderSurface, SharedSidesLeaveNoSeam) {
  for (const double opacity : {1.0, 0.5}) {
    const Image image = paint_surface(square(), parallel_camera({0, 0, 0}, {0, 0, -1}, 4, 20),
                                      gray(), {.opacity = opacity}, options_of())
                            .image;
    for (int y = 1; y < kSide - 1; ++y)
      for (int x = 1; x < kSide - 1; ++x) ASSERT_NEAR(pixel(image, x, y).a(), opacity, 1e-6);
  }
}

TEST(RenderSurface, LayersAreSeenFrontToBack) {
  Surface surface;
  add_square(surface, 4, -3);
  add_square(surface, 4, 5);
  add_square(surface, 4, 0);
  for (auto& triangle : surface.triangles) {
    const auto depth = static_cast<float>(surface.places[triangle.corners[0]].z());
    triangle.values.fill(depth);
  }
  // From +z: 5, 0, -3, which are gray 0.75, 0.5 and 0.35.
  const Camera camera = parallel_camera({0, 0, 0}, {0, 0, -1}, 8, 20);
  const double a = 0.4;
  const Image image = paint_surface(surface, camera, gray(), {.opacity = a}, options_of()).image;
  const test::Pixel at = pixel(image, 32, 32);
  const double rest = 1 - a;
  EXPECT_NEAR(at.r(), a * (0.75 + rest * 0.5 + rest * rest * 0.35), 1e-5);
  EXPECT_NEAR(at.a(), 1 - rest * rest * rest, 1e-6);
  EXPECT_NEAR(test::depth(image, 32, 32), 20, 1e-5);  // where opacity reaches a half
  EXPECT_NEAR(test::center_front_depth(image), 15, 1e-5);
  const Image opaque = paint_surface(surface, camera, gray(), {}, options_of()).image;
  EXPECT_NEAR(pixel(opaque, 32, 32).r(), 0.75, 1e-5);
}

TEST(RenderSurface, IsLitAsVolumesAre) {
  Look look = gray();
  look.shade = true;
  look.light = Light::kStudio;
  look.light_direction = Vec3(1, 2, 2);
  look.material = {0.1, 0.6, 0.3, 4};
  const Camera camera = parallel_camera({0, 0, 0}, {0, 0, -1}, 8, 20);
  const Vec3 l = Vec3(1, 2, 2).normalized();
  const double n_h = (l + Vec3(0, 0, 1)).normalized().z();
  const double diffuse = 0.65 * (l.z() + 0.25) / 1.25 + 0.35;
  // Both windings, and normals that point away: the side that is seen is lit.
  for (const float sign : {1.0F, -1.0F}) {
    Surface surface = square();
    for (auto& triangle : surface.triangles) {
      triangle.normals.fill(Eigen::Vector3f(0, 0, sign));
      triangle.values.fill(0);
      if (sign < 0) std::swap(triangle.corners[1], triangle.corners[2]);
    }
    const test::Pixel at =
        pixel(paint_surface(surface, camera, look, {}, options_of()).image, 32, 32);
    EXPECT_NEAR(at.r(), 0.5 * (0.1 + 0.6 * diffuse) + 0.3 * std::pow(n_h, 4), 1e-4);
  }
}

// To what a surface shows under its own light, further ones add.
TEST(RenderSurface, TakesFurtherLights) {
  Look look = gray();
  look.shade = true;
  look.material = {0.1, 0.3, 0.2, 4};
  const Camera camera = parallel_camera({0, 0, 0}, {0, 0, -1}, 8, 20);
  Surface surface = square();
  for (auto& triangle : surface.triangles) {
    triangle.normals.fill(Eigen::Vector3f(0, 0, 1));
    triangle.values.fill(0);
  }
  const auto shown = [&] {
    return pixel(paint_surface(surface, camera, look, {}, options_of()).image, 32, 32).r();
  };
  double expected = 0.5 * (0.1 + 0.3) + 0.2;
  EXPECT_NEAR(shown(), expected, 1e-4);
  look.further_lights = {{Vec3(2, 4, 4), 0.5}, {Vec3(0, 3, -4), 0.25}};
  const double n_h = (Vec3(1, 2, 2) / 3 + Vec3(0, 0, 1)).normalized().z();
  expected += 0.5 * (0.5 * 0.3 * 2 / 3 + 0.2 * std::pow(n_h, 4));
  expected += 0.25 * (0.5 * 0.3 * 0.8);  // from behind, without a highlight
  EXPECT_NEAR(shown(), expected, 1e-4);
}

TEST(RenderSurface, ClipPlanesCutIt) {
  RenderOptions options = options_of();
  options.clip_planes = {{Vec3(1, 0, 0), 1}};
  const Camera camera = parallel_camera({0, 0, 0}, {0, 0, -1}, 8, 20);
  const Image image = paint_surface(square(), camera, gray(), {}, options).image;
  double covered = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) covered += image.rgba[i];
  EXPECT_NEAR(covered * 0.25 * 0.25, 3 * 8, 0.05 * 24);
}

// A ground that passes under the eye: what is behind is left out, what is before goes on.
TEST(RenderSurface, TrianglesMayReachBehindTheEye) {
  const Surface surface = square(100, -1);
  Camera camera;
  camera.position = {0, 0, 0};
  camera.focal_point = {1, 0, 0};
  camera.view_up = {0, 0, 1};
  const Image image = paint_surface(surface, camera, gray(), {}, options_of()).image;
  EXPECT_EQ(pixel(image, 32, 10).a(), 0);
  for (int x = 0; x < kSide; ++x) EXPECT_EQ(pixel(image, x, 60).a(), 1) << x;
  // Down 28.5 of 32 pixels of tangent tan(15 degrees): depth 1 / that.
  const double slope = 28.5 / 32 * std::tan(15 * std::acos(-1.0) / 180);
  EXPECT_NEAR(test::depth(image, 32, 60), 1 / slope, 0.02 / slope);
}

TEST(RenderSurface, MissingValuesAreHoles) {
  Surface surface = square();
  surface.triangles[0].values[1] = std::numeric_limits<float>::quiet_NaN();
  const Image image = paint_surface(surface, parallel_camera({0, 0, 0}, {0, 0, -1}, 4, 20), gray(),
                                    {}, options_of())
                          .image;
  double covered = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) covered += image.rgba[i];
  EXPECT_NEAR(covered, kSide * kSide / 2, 0.02 * kSide * kSide);
}

TEST(RenderSurface, EdgesAreDarkLinesOfFaces) {
  const Camera camera = parallel_camera({0, 0, 0}, {0, 0, -1}, 5, 20);
  const auto draw = [&](bool shows_edges) {
    return paint_surface(square(3.75), camera, gray(), {.shows_edges = shows_edges}, options_of())
        .image;
  };
  const Image plain = draw(false);
  const Image edged = draw(true);
  int num_dark = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      EXPECT_EQ(pixel(edged, x, y).a(), pixel(plain, x, y).a());
      if (pixel(edged, x, y).r() < 0.9 * pixel(plain, x, y).r()) ++num_dark;
    }
  }
  EXPECT_EQ(num_dark, 4 * 47);  // the square's outermost pixels, and not its diagonal
}

TEST(RenderSurface, TheSameWhateverTheThreads) {
  Surface surface;
  for (int i = 0; i < 20; ++i) add_square(surface, 4 - 0.1 * i, 0.3 * i);
  const Camera camera = perspective_camera({0, 0, 0}, Vec3(0.3, 0.2, -1), 8, 20);
  const auto draw = [&](int threads) {
    return paint_surface(surface, camera, gray(), {.opacity = 0.3}, options_of(200, 90), threads)
        .image;
  };
  EXPECT_EQ(draw(1), draw(3));
}

TEST(RenderSurface, RefusesAndStops) {
  const Camera camera = parallel_camera({0, 0, 0}, {0, 0, -1}, 8, 20);
  for (const double opacity : {0.0, -1.0, 1.5, std::nan("")}) {
    EXPECT_THROW(paint_surface(square(), camera, gray(), {.opacity = opacity}, options_of()),
                 Error);
  }
  std::stop_source stop;
  stop.request_stop();
  RenderHooks hooks;
  hooks.stop = stop.get_token();
  EXPECT_THROW(paint_surface(square(), camera, gray(), {}, options_of(), 1, hooks), Error);
  // Nothing at all is an empty picture.
  const Image image = paint_surface(Surface(), camera, gray(), {}, options_of()).image;
  EXPECT_EQ(pixel(image, 32, 32).a(), 0);
}

}  // namespace surface_frame_test
}  // namespace ovoid
