// SPDX-License-Identifier: Apache-2.0
#include "make_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ovoid/error.h"
#include "ovoid/framing.h"
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

void turn(Camera& camera, const CameraFlags& flags) {
  camera.azimuth(flags.azimuth);
  camera.elevation(flags.elevation);
  camera.roll(flags.roll);
  camera.validate();
}

}  // namespace

Camera camera_of_flag(const std::string& value) {
  return is_json(value) ? camera_from_text(value, "--camera") : read_camera(value);
}

Camera start_camera(const CameraFlags& flags, const CameraSubject& subject) {
  const bool is_from_file = !flags.file.empty();
  Camera camera = is_from_file ? camera_of_flag(flags.file)
                  : flags.view.empty()
                      ? first_camera(subject.scene.volumes.front().field, subject.bounds,
                                     subject.space, subject.aspect)
                      : default_camera(subject.bounds, subject.space, flags.view, subject.aspect);
  if (flags.parallel_projection) camera.parallel_projection = *flags.parallel_projection;
  if (!flags.view_angle) return camera;
  if (is_from_file || flags.fit == Fit::kVisible) {
    camera.view_angle = *flags.view_angle;
  } else {
    set_view_angle_in_sight(camera, *flags.view_angle);
  }
  return camera;
}

Camera make_camera(const CameraFlags& flags, const CameraSubject& subject) {
  Camera camera = start_camera(flags, subject);
  turn(camera, flags);
  if (flags.file.empty() && flags.fit == Fit::kVisible) {
    camera = framed(camera, subject.scene,
                    {.aspect = subject.aspect,
                     .is_for_turning = subject.is_for_turning,
                     .clip_planes = subject.clip_planes});
  }
  camera.zoom(flags.zoom);
  try {
    camera.validate();
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("--zoom {:g}: {}", flags.zoom, error.what()));
  }
  return camera;
}

Camera turned_camera(const CameraFlags& flags, const Camera& start, const Camera& near) {
  Camera from = start;
  turn(from, flags);
  Camera camera = near;
  const double distance = (near.position - near.focal_point).norm();
  camera.position = near.focal_point + distance * (from.position - from.focal_point).normalized();
  camera.view_up = from.view_up;
  return camera;
}

Camera unturned_camera(const CameraFlags& flags, const Camera& start, const Camera& made) {
  Camera camera = made;
  const double distance = (made.position - made.focal_point).norm();
  camera.position = made.focal_point + distance * (start.position - start.focal_point).normalized();
  camera.view_up = start.view_up;
  camera.zoom(1 / flags.zoom);
  return camera;
}

}  // namespace ovoid::cli
