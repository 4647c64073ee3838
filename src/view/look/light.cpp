// SPDX-License-Identifier: Apache-2.0
#include "view/look/light.h"

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

// Of the studio's diffuse light; the rest is the soft light's.
constexpr double kKeyShare = 0.65;

LightShares single_light(const Vec3& normal, const Vec3& to_light, const Vec3& to_eye, double power,
                         double arriving) {
  const double n_l = normal.dot(to_light);
  const double n_h = normal.dot(half_way(to_light, to_eye));
  const bool is_same_side = n_l * normal.dot(to_eye) >= 0;
  const double specular = is_same_side ? std::pow(std::abs(n_h), power) : 0.0;
  return {arriving * std::abs(n_l), arriving * specular, 1, arriving};
}

LightShares studio_light(const Vec3& normal, const Vec3& to_key, const Vec3& to_eye, double power,
                         const ArrivingLight& arriving) {
  constexpr double kWrap = 0.25;
  const Vec3 side = normal.dot(to_eye) < 0 ? Vec3(-normal) : normal;
  const double n_l = side.dot(to_key);
  const double key = std::max(0.0, (n_l + kWrap) / (1 + kWrap));
  const double fill = 0.5 * (1 + side.dot(to_eye));
  const double n_h = std::max(0.0, side.dot(half_way(to_key, to_eye)));
  const double from_key = kKeyShare * arriving.key;
  const double from_eye = (1 - kKeyShare) * arriving.around;
  return {from_key * key + from_eye * fill, n_l > 0 ? arriving.key * std::pow(n_h, power) : 0.0, 1,
          from_key + from_eye};
}

// In the mean over all normals a light reaches them by half.
constexpr double kMeanCosine = 0.5;

void add_further_light(const FurtherLight& light, const Vec3& normal, const Vec3& to_eye,
                       double power, double around, LightShares& shares) {
  const LightShares own =
      single_light(normal, light.direction.normalized(), to_eye, power, light.intensity * around);
  shares.diffuse += own.diffuse;
  shares.specular += own.specular;
  shares.flat += kMeanCosine * own.flat;
}

}  // namespace

LightShares light_shares(const Look& look, const Vec3& normal, const Vec3& to_light,
                         const Vec3& to_eye, const ArrivingLight& arriving) {
  const double power = look.material.specular_power;
  // Nothing is in the way of a headlight that is not in the way of the eye.
  const double of_single = look.light_direction ? arriving.key : arriving.around;
  LightShares shares = look.light == Light::kStudio
                           ? studio_light(normal, to_light, to_eye, power, arriving)
                           : single_light(normal, to_light, to_eye, power, of_single);
  shares.ambient = arriving.around;
  for (const FurtherLight& light : look.further_lights)
    add_further_light(light, normal, to_eye, power, arriving.around, shares);
  return shares;
}

Rgb lit_color(const Rgb& color, const Material& material, const LightShares& light,
              double flatness) {
  const double factor = material.ambient * light.ambient +
                        material.diffuse * ((1 - flatness) * light.flat + flatness * light.diffuse);
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

std::optional<Vec3> direction_of_light(const Look& look, const Camera& camera) {
  if (look.light_direction) return look.light_direction->normalized();
  if (look.light == Light::kStudio) return studio_key(camera).normalized();
  return std::nullopt;
}

}  // namespace ovoid::view
