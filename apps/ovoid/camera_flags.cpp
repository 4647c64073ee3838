// SPDX-License-Identifier: Apache-2.0
#include "camera_flags.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "ovoid/error.h"
#include "ovoid/io.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

const Names<bool> kProjections = {{"perspective", false}, {"parallel", true}};
const Names<std::string> kViews = {{"+x", "+x"},
                                   {"-x", "-x"},
                                   {"+y", "+y"},
                                   {"-y", "-y"},
                                   {"+z", "+z"},
                                   {"-z", "-z"},
                                   {"anterior", "anterior"},
                                   {"posterior", "posterior"},
                                   {"left", "left"},
                                   {"right", "right"},
                                   {"superior", "superior"},
                                   {"inferior", "inferior"}};

Flags::Take number_into(double* into, const Interval& interval = {}) {
  return [into, interval](const std::string& text) { *into = parse_number(text, interval); };
}

// Moves the camera so that a ball around the focal point that touched the borders of the picture
// still does.
void set_view_angle_in_sight(Camera& camera, double degrees) {
  const auto sine_of_half = [](double angle) { return std::sin(angle * std::numbers::pi / 360); };
  const double farther = sine_of_half(camera.view_angle) / sine_of_half(degrees);
  camera.position = camera.focal_point + farther * (camera.position - camera.focal_point);
  camera.view_angle = degrees;
}

Camera camera_of(const CameraFlags& flags) {
  return is_json(flags.file) ? camera_from_text(flags.file, "--camera") : read_camera(flags.file);
}

}  // namespace

void add_camera_flags(Flags& flags, CameraFlags* camera) {
  flags.section("camera");
  flags.value("--camera", "FILE|JSON", "a camera in VTK's words, or JSON itself",
              [camera](const std::string& text) { camera->file = text; });
  flags.value("--view", "DIRECTION",
              "from where: +x, -x, +y, -y, +z, -z, or for patient data anterior, posterior, left, "
              "right, superior, inferior",
              [camera](const std::string& text) { camera->view = parse_name(text, kViews); });
  flags.value("--azimuth", "DEG", "turn the camera around the view's up axis",
              number_into(&camera->azimuth));
  flags.value("--elevation", "DEG", "raise the camera", number_into(&camera->elevation));
  flags.value("--roll", "DEG", "turn the camera about its view axis", number_into(&camera->roll));
  flags.value("--zoom", "FACTOR", "above 1 comes nearer",
              number_into(&camera->zoom, {.lo = 0, .lo_open = true}));
  flags.value("--projection", "perspective|parallel", "(default perspective)",
              [camera](const std::string& text) {
                camera->parallel_projection = parse_name(text, kProjections);
              });
  flags.value("--view-angle", "DEG", "vertical opening of the perspective (default 30)",
              [camera](const std::string& text) {
                camera->view_angle = parse_number(text, {0, 180, true, true});
              });
}

void check_camera_flags(const Flags& flags, const CameraFlags& camera) {
  if (flags.is_given("--camera") && flags.is_given("--view")) {
    throw UsageError("--view: contradicts --camera, which already says from where");
  }
  if (!is_json(camera.file)) return;
  try {
    camera_of(camera);
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
}

Camera make_camera(const CameraFlags& flags, const Bounds3& bounds, Space space, double aspect) {
  const bool is_from_file = !flags.file.empty();
  Camera camera =
      is_from_file ? camera_of(flags) : default_camera(bounds, space, flags.view, aspect);
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
