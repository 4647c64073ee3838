// SPDX-License-Identifier: Apache-2.0
#include "support/scenes.h"

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <utility>

namespace ovoid::test {

Camera parallel_camera(const Vec3& focal_point, const Vec3& direction, double half_height,
                       double distance) {
  Camera camera;
  camera.focal_point = focal_point;
  camera.position = focal_point - distance * direction.normalized();
  camera.view_up = direction.normalized().unitOrthogonal();
  camera.parallel_projection = true;
  camera.parallel_scale = half_height;
  return camera;
}

Camera perspective_camera(const Vec3& focal_point, const Vec3& direction, double half_height,
                          double distance) {
  Camera camera = parallel_camera(focal_point, direction, half_height, distance);
  camera.parallel_projection = false;
  camera.view_angle = 2 * std::atan(half_height / distance) * 180 / std::numbers::pi;
  return camera;
}

Look uniform_look(double opacity, const Rgb& color) {
  Look look;
  look.transfer_function.colors = {{0, color}, {1, color}};
  look.transfer_function.opacities = {{0, opacity}, {1, opacity}};
  look.shade = false;
  look.unit_distance = 1;
  return look;
}

Look gray_look(double lo, double hi, double opacity) {
  Look look;
  look.transfer_function.colors = {{lo, {0, 0, 0}}, {hi, {1, 1, 1}}};
  look.transfer_function.opacities = {{lo, opacity}, {hi, opacity}};
  look.shade = false;
  look.unit_distance = 1;
  return look;
}

Look with_mode(Look look, Mode mode) {
  look.mode = mode;
  return look;
}

RenderOptions picture(int width, int height, double sampling_distance, Slab slab) {
  RenderOptions options;
  options.width = width;
  options.height = height;
  options.sampling_distance = sampling_distance;
  options.slab = slab;
  options.sheets = Sheets::kImage;
  return options;
}

void draw_from(double depth, RenderOptions& options) {
  auto limits = std::make_shared<DepthLimits>();
  limits->width = options.width;
  limits->height = options.height;
  const auto count = static_cast<std::uint32_t>(options.width * options.height);
  limits->stops.resize(count, {static_cast<float>(depth), true, {}});
  for (std::uint32_t i = 0; i <= count; ++i) limits->first.push_back(i);
  options.depth_limits = std::move(limits);
}

Pixel pixel(const Image& image, int x, int y) {
  const float* p =
      image.rgba.data() + 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                               static_cast<std::size_t>(x));
  return {{p[0], p[1], p[2], p[3]}};
}

Pixel center_pixel(const Image& image) { return pixel(image, image.width / 2, image.height / 2); }

double depth(const Image& image, int x, int y) {
  return static_cast<double>(
      image.depth[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                  static_cast<std::size_t>(x)]);
}

double center_depth(const Image& image) { return depth(image, image.width / 2, image.height / 2); }

double center_front_depth(const Image& image) {
  return static_cast<double>(
      image
          .front_depth[static_cast<std::size_t>(image.height / 2 * image.width + image.width / 2)]);
}

}  // namespace ovoid::test
