// SPDX-License-Identifier: Apache-2.0
#include "render/reference/shading.h"

#include <algorithm>
#include <cmath>

namespace ovoid::reference {
namespace {

// Zero stays zero.
Vec3 direction_of(const Vec3& v) {
  const double length = v.norm();
  return length > 0 ? Vec3(v / length) : Vec3(Vec3::Zero());
}

// q: 0 where the field is flat, 1 where its gradient tells a direction.
double flatness(const Vec3& gradient, const ShadingContext& context) {
  const double rise = gradient.norm() * context.least_spacing;
  const double threshold = 1e-4 * context.span;
  if (rise >= threshold) return rise > 0 ? 1 : 0;
  return rise / threshold;
}

}  // namespace

double opacity_over(double opacity, double path, double unit_distance) {
  return 1 - std::pow(1 - opacity, path / unit_distance);
}

Rgb shaded(const Rgb& color, const Vec3& gradient, const Vec3& to_eye, const Look& look,
           const ShadingContext& context) {
  const Vec3 to_light = look.light_direction ? direction_of(*look.light_direction) : to_eye;
  const Vec3 normal = direction_of(gradient);
  const Vec3 half_way = direction_of(to_light + to_eye);
  const double n_l = normal.dot(to_light);
  const double n_e = normal.dot(to_eye);

  const Material& material = look.material;
  const double diffuse = std::abs(n_l);
  const double specular =
      n_l * n_e < 0 ? 0 : std::pow(std::abs(normal.dot(half_way)), material.specular_power);
  const double q = flatness(gradient, context);

  Rgb result;
  for (std::size_t c = 0; c < 3; ++c) {
    const double lit = color[c] * (material.ambient + material.diffuse * (1 - q + q * diffuse)) +
                       q * material.specular * specular;
    result[c] = std::clamp(lit, 0.0, 1.0);
  }
  return result;
}

}  // namespace ovoid::reference
