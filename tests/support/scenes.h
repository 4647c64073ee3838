// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "ovoid/camera.h"
#include "ovoid/look.h"
#include "ovoid/renderer.h"

namespace ovoid::test {

// A parallel camera `distance` before the focal point, looking along `direction`; the picture is 2
// * half_height high.
Camera parallel_camera(const Vec3& focal_point, const Vec3& direction, double half_height,
                       double distance = 100);

// The perspective camera that shows the same rectangle at its focal point.
Camera perspective_camera(const Vec3& focal_point, const Vec3& direction, double half_height,
                          double distance);

// One colour and one opacity for all values, no light.
Look uniform_look(double opacity, const Rgb& color = {1, 1, 1});

// Gray equal to the value over [lo, hi] -> [0, 1], one opacity, no light.
Look gray_look(double lo, double hi, double opacity = 1);

Look with_mode(Look look, Mode mode);

// On image sheets, whose samples are those of the pixels' own rays.
RenderOptions picture(int width, int height, double sampling_distance = 0, Slab slab = Slab::kMid);

// Draws the field behind a distance from the camera plane alone, and cuts no face open there.
void draw_from(double depth, RenderOptions& options);

// The four components of a pixel.
struct Pixel {
  std::array<float, 4> rgba;
  double r() const { return static_cast<double>(rgba[0]); }
  double g() const { return static_cast<double>(rgba[1]); }
  double b() const { return static_cast<double>(rgba[2]); }
  double a() const { return static_cast<double>(rgba[3]); }
};
Pixel pixel(const Image& image, int x, int y);
Pixel center_pixel(const Image& image);
double depth(const Image& image, int x, int y);
double center_depth(const Image& image);
double center_front_depth(const Image& image);

}  // namespace ovoid::test
