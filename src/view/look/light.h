// SPDX-License-Identifier: Apache-2.0
// docs/numerics.md, "Light", for one normal at a time, in double precision. The fast back ends have
// the same in vectors and in GLSL.
#pragma once

#include <optional>

#include "ovoid/camera.h"
#include "ovoid/look.h"
#include "ovoid/math.h"
#include "view/plan/light_volume.h"

namespace ovoid::view {

// Shares of a material's ambient, diffuse and specular light, and of its diffuse light where the
// field is flat.
struct LightShares {
  double diffuse, specular;
  double ambient = 1, flat = 1;
};

// `normal`, `to_light` and `to_eye` have unit length; to_light is where the look's own light, or
// the studio's key light, stands. `arriving`: how much of the light gets as far as the place.
LightShares light_shares(const Look& look, const Vec3& normal, const Vec3& to_light,
                         const Vec3& to_eye, const ArrivingLight& arriving = {});

// The colour under that light where normals tell a share `flatness` of what light does, in [0, 1].
Rgb lit_color(const Rgb& color, const Material& material, const LightShares& light,
              double flatness);

// Where the look's light stands, unit length; none: at the eye.
std::optional<Vec3> direction_of_light(const Look& look, const Camera& camera);

// The studio's key light where nobody placed it: above left of the camera. World, not of unit
// length.
Vec3 studio_key(const Camera& camera);

}  // namespace ovoid::view
