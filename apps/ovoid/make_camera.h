// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ovoid/camera.h"
#include "ovoid/field.h"
#include "ovoid/further_volumes.h"
#include "ovoid/geometry.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"
#include "ovoid/surface.h"
#include "ovoid/trail.h"
#include "settings.h"

namespace ovoid::cli {

// What a camera is made for.
struct CameraSubject {
  const Field& field;
  const Look& look;
  Bounds3 bounds;  // of what is left of the field
  Space space = Space::kNone;
  double aspect = 1;  // width / height of the picture
  std::vector<ClipPlane> clip_planes;
  bool is_for_turning = false;       // as in Framing
  const Surface* surface = nullptr;  // what is drawn instead of the field; null: nothing
  bool shows_all = false;            // every kernel is seen, whatever the look makes of its value
  std::shared_ptr<const std::vector<FurtherVolume>> further{};  // drawn with the field
  // Of the field, which count where the look shows nothing of it; null: none.
  const std::vector<FieldSlice>* slices = nullptr;
  const Trail* trail = nullptr;  // drawn with the field; null: none
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
