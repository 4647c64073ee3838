// SPDX-License-Identifier: Apache-2.0
#include "view/light.h"

#include <algorithm>
#include <cmath>

namespace ovoid::view {
namespace {

// Zero stays zero.
Vec3 half_way(const Vec3& to_light, const Vec3& to_eye) {
  const Vec3 sum = to_light + to_eye;
  const double length = sum.norm();
  return length > 0 ? Vec3(sum / length) : Vec3(Vec3::Zero());
}

LightShares single_light(const Vec3& normal, const Vec3& to_light, const Vec3& to_eye,
                         double power) {
  const double n_l = normal.dot(to_light);
  const double n_h = normal.dot(half_way(to_light, to_eye));
  const bool is_same_side = n_l * normal.dot(to_eye) >= 0;
  return {std::abs(n_l), is_same_side ? std::pow(std::abs(n_h), power) : 0.0};
}

LightShares studio_light(const Vec3& normal, const Vec3& to_key, const Vec3& to_eye, double power) {
  constexpr double kKeyShare = 0.65;
  constexpr double kWrap = 0.25;
  const Vec3 side = normal.dot(to_eye) < 0 ? Vec3(-normal) : normal;
  const double n_l = side.dot(to_key);
  const double key = std::max(0.0, (n_l + kWrap) / (1 + kWrap));
  const double fill = 0.5 * (1 + side.dot(to_eye));
  const double n_h = std::max(0.0, side.dot(half_way(to_key, to_eye)));
  return {kKeyShare * key + (1 - kKeyShare) * fill, n_l > 0 ? std::pow(n_h, power) : 0.0};
}

}  // namespace

LightShares light_shares(const Look& look, const Vec3& normal, const Vec3& to_light,
                         const Vec3& to_eye) {
  const auto light = look.light == Light::kStudio ? studio_light : single_light;
  return light(normal, to_light, to_eye, look.material.specular_power);
}

Rgb lit_color(const Rgb& color, const Material& material, const LightShares& light,
              double flatness) {
  const double factor =
      material.ambient + material.diffuse * (1 - flatness + flatness * light.diffuse);
  Rgb lit;
  for (std::size_t c = 0; c < 3; ++c) {
    lit[c] =
        std::clamp(color[c] * factor + flatness * material.specular * light.specular, 0.0, 1.0);
  }
  return lit;
}

Vec3 studio_key(const Camera& camera) {
  const Vec3 to_eye = (camera.position - camera.focal_point).normalized();
  const Vec3 right = camera.view_up.cross(to_eye).normalized();
  return -0.5 * right + 0.6 * to_eye.cross(right) + 0.8 * to_eye;
}

}  // namespace ovoid::view
