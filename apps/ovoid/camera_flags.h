// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "flags.h"
#include "ovoid/camera.h"

namespace ovoid::cli {

// Where the picture is taken from. What is not given is the file's, or else the default camera's.
struct CameraFlags {
  std::string file;  // a name, or JSON itself
  std::string view;
  double azimuth = 0;  // degrees, as are the next two
  double elevation = 0;
  double roll = 0;
  double zoom = 1;
  std::optional<bool> parallel_projection;
  std::optional<double> view_angle;
};

void add_camera_flags(Flags& flags, CameraFlags* camera);
// Throws UsageError for contradictions, and for JSON that is no camera.
void check_camera_flags(const Flags& flags, const CameraFlags& camera);

// The default view of the bounds, or the file's camera, with the flags applied. `aspect` is width /
// height. Throws Error.
Camera make_camera(const CameraFlags& flags, const Bounds3& bounds, Space space, double aspect);

}  // namespace ovoid::cli
