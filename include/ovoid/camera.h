// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/export.h"
#include "ovoid/math.h"

namespace OVOID_API ovoid {

// A camera in VTK's words; world units and degrees. Valid if position != focal_point, view_up is
// not parallel to the view axis, parallel_scale > 0 and 0 < view_angle < 180.
struct Camera {
  Vec3 position{0, 0, 1};
  Vec3 focal_point{0, 0, 0};
  Vec3 view_up{0, 1, 0};
  bool parallel_projection = false;
  // Half the height of the picture in world units (parallel projection).
  double parallel_scale = 1.0;
  double view_angle = 30.0;  // vertical opening angle (perspective projection)

  // Throws Error(kInvalidArgument) that names the member.
  void validate() const;

  // VTK's own motions, each about the focal point but `roll`; degrees.
  void azimuth(double degrees);  // about view_up through the focal point
  void elevation(
      double degrees);  // about the right axis through the focal point; view_up is made orthogonal
  void roll(double degrees);  // about the view axis
  void zoom(double factor);   // > 1 comes nearer: divides parallel_scale or the view angle
};

// The whole box in sight for any aspect ratio >= `aspect` (width / height; below 1 the distance
// grows): the camera looks along the direction named by `view`: "+x" "-x" "+y" "-y" "+z" "-z" (seen
// from there); "front" "back" "left" "right" "top" "bottom", and "three-quarter" (30 degrees from
// the front to the viewer's right, 20 up) or "three-quarter-side" (60), where data of a patient
// face anterior, and left and right are the patient's; other data face -y with z up. "anterior"
// "posterior" "superior" "inferior" are for patients alone. Empty: from +z with y up, or for LPS
// and RAS data from anterior with superior up. (framing.h chooses, and comes nearer.) Throws
// Error(kInvalidArgument) for an unknown name, a patient direction without a patient space, or an
// empty box.
Camera default_camera(const Bounds3& world_bounds, Space space = Space::kNone,
                      const std::string& view = {}, double aspect = 1.0);
// All names of views.
std::vector<std::string> view_names();

}  // namespace ovoid
