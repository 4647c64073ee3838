// SPDX-License-Identifier: Apache-2.0
#include "make_camera.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "ovoid/error.h"
#include "ovoid/io.h"
#include "values.h"

namespace ovoid::cli {
namespace {

// Moves the camera so that a ball around the focal point that touched the borders of the picture
// still does.
void set_view_angle_in_sight(Camera& camera, double degrees) {
  const auto sine_of_half = [](double angle) { return std::sin(angle * std::numbers::pi / 360); };
  const double farther = sine_of_half(camera.view_angle) / sine_of_half(degrees);
  camera.position = camera.focal_point + farther * (camera.position - camera.focal_point);
  camera.view_angle = degrees;
}

}  // namespace

Camera camera_of_flag(const std::string& value) {
  return is_json(value) ? camera_from_text(value, "--camera") : read_camera(value);
}

Camera make_camera(const CameraFlags& flags, const Bounds3& bounds, Space space, double aspect) {
  const bool is_from_file = !flags.file.empty();
  Camera camera =
      is_from_file ? camera_of_flag(flags.file) : default_camera(bounds, space, flags.view, aspect);
  if (flags.parallel_projection) camera.parallel_projection = *flags.parallel_projection;
  if (flags.view_angle && is_from_file) camera.view_angle = *flags.view_angle;
  if (flags.view_angle && !is_from_file) set_view_angle_in_sight(camera, *flags.view_angle);
  camera.azimuth(flags.azimuth);
  camera.elevation(flags.elevation);
  camera.roll(flags.roll);
  camera.validate();
  camera.zoom(flags.zoom);
  try {
    camera.validate();
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("--zoom {:g}: {}", flags.zoom, error.what()));
  }
  return camera;
}

}  // namespace ovoid::cli
