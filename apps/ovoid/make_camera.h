// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "ovoid/camera.h"
#include "settings.h"

namespace ovoid::cli {

// The default view of the bounds, or the file's camera, with the flags applied. `aspect` is width /
// height. Throws Error.
Camera make_camera(const CameraFlags& flags, const Bounds3& bounds, Space space, double aspect);

// The camera that the value of --camera is: JSON itself, or a file's. Throws Error.
Camera camera_of_flag(const std::string& value);

}  // namespace ovoid::cli
