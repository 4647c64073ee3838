// SPDX-License-Identifier: Apache-2.0
#include "render/reference/shading.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "view/look/light.h"

namespace ovoid::reference {
namespace {

// An opacity of 1 counts as this much extinction per unit distance.
constexpr double kGreatestExtinction = 64;

double extinction_of(double opacity) {
  return opacity < 1 ? std::min(-std::log1p(-opacity), kGreatestExtinction) : kGreatestExtinction;
}

// The ends, and all places between them where the look may have a corner.
std::vector<double> corners_between(const TransferFunction& tf, double from, double to) {
  std::vector<double> corners{from, to};
  const auto add = [&](double x) {
    if (std::min(from, to) < x && x < std::max(from, to)) corners.push_back(x);
  };
  for (const ColorPoint& point : tf.colors) add(point.x);
  for (const OpacityPoint& point : tf.opacities) add(point.x);
  std::sort(corners.begin(), corners.end());
  return corners;
}

double flatness_at(const LitPlace& place, const ShadingContext& context) {
  return flatness(place.gradient, context) * std::clamp(place.clearance, 0.0, 1.0);
}

}  // namespace

Vec3 normal_of(const Vec3& gradient) {
  const double length = gradient.norm();
  return length > 0 ? Vec3(gradient / length) : Vec3(Vec3::Zero());
}

double flatness(const Vec3& gradient, const ShadingContext& context) {
  const double rise = gradient.norm() * context.least_spacing;
  if (rise >= context.flat_rise) return rise > 0 ? 1 : 0;
  return rise / context.flat_rise;
}

ClassifiedSample classified_piece(const TransferFunction& tf, double from, double to) {
  constexpr int kSamples = 64;
  double extinction = 0;
  Rgb color{0, 0, 0};
  const std::vector<double> corners = corners_between(tf, from, to);
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const double width = (corners[i + 1] - corners[i]) / kSamples;
    for (int k = 0; k < kSamples; ++k) {
      const double value = corners[i] + (k + 0.5) * width;
      const double share = width * extinction_of(tf.opacity_at(value));
      if (share == 0) continue;
      const Rgb here = tf.color_at(value);
      extinction += share;
      for (std::size_t c = 0; c < 3; ++c) color[c] += share * here[c];
    }
  }
  if (extinction == 0) return {{0, 0, 0}, 0};
  for (double& c : color) c /= extinction;
  return {color, 1 - std::exp(-extinction / std::abs(to - from))};
}

double opacity_over(double opacity, double path, double unit_distance) {
  return 1 - std::pow(1 - opacity, path / unit_distance);
}

Rgb shaded(const Rgb& color, const LitPlace& place, const Look& look, const ShadingContext& context,
           const view::ArrivingLight& arriving) {
  const Vec3 to_light = look.light_direction ? normal_of(*look.light_direction) : place.to_eye;
  const view::LightShares light =
      view::light_shares(look, normal_of(place.gradient), to_light, place.to_eye, arriving);
  return view::lit_color(color, look.material, light, flatness_at(place, context));
}

view::ArrivingLight arriving_light(const view::LightVolume& volume, const Vec3& position,
                                   const LitPlace& place, const ShadingContext& context) {
  return volume.arriving_at(position, normal_of(place.gradient), place.to_eye,
                            flatness_at(place, context));
}

}  // namespace ovoid::reference
