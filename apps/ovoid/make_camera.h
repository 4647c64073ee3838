// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "ovoid/camera.h"
#include "ovoid/scene.h"
#include "settings.h"

namespace ovoid::cli {

// What a camera is made for.
struct CameraSubject {
  const Scene& scene;
  Bounds3 bounds;  // of what is left of the volumes
  Space space = Space::kNone;
  double aspect = 1;  // width / height of the picture
  std::vector<ClipPlane> clip_planes;
  bool is_for_turning = false;  // as in Framing
};

// The default view of the subject, or the file's camera, with the flags applied. Throws Error.
Camera make_camera(const CameraFlags& flags, const CameraSubject& subject);

// The camera before it is turned, fitted or zoomed.
Camera start_camera(const CameraFlags& flags, const CameraSubject& subject);

// As near to its focal point as `near` is, but turned from `start` as the flags say.
Camera turned_camera(const CameraFlags& flags, const Camera& start, const Camera& near);

// The camera that was made of `start`, before the flags turned and zoomed it: it looks at the same
// place from as far. Turning keeps no axis that could be turned about again.
Camera unturned_camera(const CameraFlags& flags, const Camera& start, const Camera& made);

// The camera that the value of --camera is: JSON itself, or a file's. Throws Error.
Camera camera_of_flag(const std::string& value);

}  // namespace ovoid::cli
