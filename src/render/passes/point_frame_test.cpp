// SPDX-License-Identifier: Apache-2.0
#include "render/passes/point_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "ovoid/error.h"
#include "support/scenes.h"

namespace ovoid {
namespace point_frame_test {

using test::parallel_camera;
using test::perspective_camera;
using test::pixel;

constexpr int kSquare = 96;

RenderOptions square_options() {
  RenderOptions options;
  options.width = options.height = kSquare;
  return options;
}

struct Point {
  Vec3 place;
  float sigma = 1;
  float value = 0;
};

KernelField field_of(const std::vector<Point>& points,
                     Reconstruction reconstruction = Reconstruction::kNormalized) {
  std::vector<double> centers;
  std::vector<float> sigmas, values;
  for (const Point& point : points) {
    centers.insert(centers.end(), point.place.begin(), point.place.end());
    sigmas.push_back(point.sigma);
    values.push_back(point.value);
  }
  const std::vector<float> weights{1.0F};
  KernelColumns columns;
  columns.centers = centers;
  columns.shapes = sigmas;
  columns.weights = weights;
  columns.values.emplace_back(values);
  columns.attributes.push_back({"v", "", {}});
  return {make_kernel_source(columns, 1), reconstruction};
}

// Without light: the material's ambient share alone.
Look plain_gray() {
  Look look = test::gray_look(-10, 10);
  look.material = {1, 0, 0, 1};
  return look;
}

Camera from_above() { return parallel_camera({0, 0, 0}, {0, 0, -1}, 6, 20); }

double covered_by(const Image& image) {
  double sum = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) sum += image.rgba[i];
  return sum;
}

TEST(RenderPoints, ABallIsWhereItsKernelIsAndAsLarge) {
  const KernelField field = field_of({{{1, -2, 0.5}, 4, 5}});
  for (const bool is_parallel : {true, false}) {
    const Camera camera =
        is_parallel ? from_above() : perspective_camera({0, 0, 0}, {0, 0, -1}, 6, 20);
    const Image image = paint_points(field, camera, plain_gray(), {}, square_options(), 1).image;
    const Vec3 axis = (camera.focal_point - camera.position).normalized();
    const Vec3 right = axis.cross(camera.view_up).normalized();
    const Vec3 up = right.cross(axis);
    const Vec3 center(1, -2, 0.5);
    const double near = is_parallel ? 1 : 20 / (20 - 0.5);
    const double x = kSquare * (0.5 + near * center.dot(right) / 12);
    const double y = kSquare * (0.5 - near * center.dot(up) / 12);
    const auto at = pixel(image, static_cast<int>(x), static_cast<int>(y));
    EXPECT_EQ(at.a(), 1);
    EXPECT_NEAR(at.r(), 0.75, 1e-5);
    // Radius 2: half of sigma 4; eight pixels per length.
    EXPECT_NEAR(test::depth(image, static_cast<int>(x), static_cast<int>(y)), 20 - 0.5 - 2, 0.02);
    const double area = std::numbers::pi * 16 * 16 * near * near;
    EXPECT_NEAR(covered_by(image), area, (is_parallel ? 0.01 : 0.04) * area);
    EXPECT_EQ(pixel(image, 2, 2).a(), 0);
    EXPECT_EQ(test::depth(image, 2, 2), std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < image.front_depth.size(); ++i) {
      ASSERT_EQ(image.front_depth[i]<1e9F, image.rgba[4 * i + 3]> 0) << i;
      ASSERT_LE(image.front_depth[i], image.depth[i]) << i;
    }
  }
}

TEST(RenderPoints, TheNearerHidesTheFarther) {
  for (const bool is_first_near : {true, false}) {
    const double z = is_first_near ? 3 : -3;
    const KernelField field = field_of({{{0, 0, z}, 2, -5}, {{0.5, 0, -z}, 2, 5}});
    const Image image =
        paint_points(field, from_above(), plain_gray(), {}, square_options(), 1).image;
    EXPECT_NEAR(pixel(image, kSquare / 2, kSquare / 2).r(), is_first_near ? 0.25 : 0.75, 1e-5);
  }
}

// The side that faces the light is bright.
TEST(RenderPoints, AreLitAsBalls) {
  Look look = test::gray_look(-10, 10);
  look.light = Light::kStudio;
  look.light_direction = Vec3(1, 0, 0);
  look.material = {0.1, 0.8, 0, 1};
  const KernelField field = field_of({{{0, 0, 0}, 8, 0}});
  const Camera camera = from_above();
  const Image image = paint_points(field, camera, look, {}, square_options(), 1).image;
  const double right =
      (camera.focal_point - camera.position).cross(camera.view_up).x() > 0 ? 1 : -1;
  const auto at = [&](double x) {
    return pixel(image, static_cast<int>(kSquare * (0.5 + right * x / 12)), kSquare / 2).r();
  };
  // The normal there is (x / 4, 0, 0.66): the key light's share, and the soft light's from the eye.
  const double soft = 0.35 * (1 + std::sqrt(1 - 0.75 * 0.75)) / 2;
  EXPECT_NEAR(at(3), 0.5 * (0.1 + 0.8 * (0.65 * (0.75 + 0.25) / 1.25 + soft)), 0.02);
  EXPECT_NEAR(at(-3), 0.5 * (0.1 + 0.8 * soft), 0.02);
}

// However far, each is there: 1.2 pixels wide at least.
TEST(RenderPoints, NoneIsTooSmallToBeSeen) {
  std::vector<Point> points;
  for (int i = 0; i < 20; ++i) points.push_back({{0.5 * i - 5, 0.237 * i - 2, 0}, 1e-4F, 10});
  const Image image =
      paint_points(field_of(points), from_above(), plain_gray(), {}, square_options(), 1).image;
  const double area = std::numbers::pi * 0.6 * 0.6;
  EXPECT_NEAR(covered_by(image), 20 * area, 0.25 * 20 * area);
}

// Lone kernels of clustered particles are wide, and would hide the rest.
TEST(RenderPoints, NoneIsLargerThanTheMedianOne) {
  std::vector<Point> points(9, {{0, 0, 0}, 1, 0});
  for (std::size_t i = 0; i < points.size(); ++i) points[i].place.x() = static_cast<double>(i) - 4;
  const auto draw = [&] {
    return covered_by(
        paint_points(field_of(points), from_above(), plain_gray(), {}, square_options(), 1).image);
  };
  const double even = draw();
  points.push_back({{0, 4, 0}, 30, 0});
  EXPECT_LT(draw(), 1.3 * even);
}

TEST(RenderPoints, SizeAndClipPlanes) {
  const KernelField field = field_of({{{-3, 0, 0}, 2, 0}, {{3, 0, 0}, 2, 0}});
  const auto draw = [&](const PointStyle& style, const RenderOptions& options) {
    return covered_by(paint_points(field, from_above(), plain_gray(), style, options, 1).image);
  };
  const double one = std::numbers::pi * 64;  // pixels of a ball of radius 1
  EXPECT_NEAR(draw({1}, square_options()), 2 * one, 0.03 * one);
  EXPECT_NEAR(draw({0.5}, square_options()), 0.5 * one, 0.03 * one);
  RenderOptions cut = square_options();
  cut.clip_planes = {{Vec3(1, 0, 0), -1}};
  EXPECT_NEAR(draw({1}, cut), one, 0.03 * one);
}

// Of a sum the colour is the sum's at the ball, as far as the ball alone can tell.
TEST(RenderPoints, OfSumsTheValueIsTheSums) {
  std::vector<Point> points;
  for (int i = 0; i < 1000; ++i)
    points.push_back({Vec3(i % 10, i / 10 % 10, i / 100) - Vec3::Constant(4.5), 0.5, 1});
  const KernelField field = field_of(points, Reconstruction::kSum);
  const double sum = KernelSampler(field).at({0.5, 0.5, 0.5}).value;
  ASSERT_GT(sum, 1.3);
  Look look = test::gray_look(0, 2 * sum);
  look.material = {1, 0, 0, 1};
  const Image image = paint_points(field, from_above(), look, {}, square_options(), 1).image;
  EXPECT_NEAR(pixel(image, kSquare / 2 + 4, kSquare / 2 + 4).r(), 0.5, 0.1);
}

TEST(RenderPoints, TheSameWhateverTheThreads) {
  std::vector<Point> points;
  for (int i = 0; i < 500; ++i)
    points.push_back({{std::sin(i * 1.7) * 4, std::cos(i * 2.3) * 4, std::sin(i * 0.9) * 4},
                      0.3F + 0.001F * static_cast<float>(i),
                      static_cast<float>(i % 20 - 10)});
  const KernelField field = field_of(points);
  const auto draw = [&](int threads) {
    return paint_points(field, perspective_camera({0, 0, 0}, {0.2, 0.3, -1}, 6, 20),
                        test::gray_look(-10, 10), {}, square_options(), threads)
        .image;
  };
  EXPECT_EQ(draw(1), draw(3));
}

TEST(RenderPoints, RefusesAndStops) {
  const KernelField field = field_of({{{0, 0, 0}, 1, 0}});
  for (const double size : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(paint_points(field, from_above(), plain_gray(), {size}, square_options()), Error);
  EXPECT_THROW(paint_points(KernelField(), from_above(), plain_gray()), Error);
  std::stop_source stop;
  stop.request_stop();
  RenderHooks hooks;
  hooks.stop = stop.get_token();
  EXPECT_THROW(paint_points(field, from_above(), plain_gray(), {}, square_options(), 1, hooks),
               Error);
  // The eye among them, and balls behind it: nothing, and no trouble.
  Camera inside = perspective_camera({0, 0, 0}, {0, 0, -1}, 6, 0.1);
  EXPECT_EQ(covered_by(paint_points(field, inside, plain_gray(), {}, square_options(), 1).image),
            0);
}

}  // namespace point_frame_test
}  // namespace ovoid
