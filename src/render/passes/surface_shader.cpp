// SPDX-License-Identifier: Apache-2.0
#include "render/passes/surface_shader.h"

#include <algorithm>
#include <cmath>

#include "view/look/color_attribute.h"
#include "view/look/light.h"

namespace ovoid {
namespace {

constexpr double kEdgeWidth = 0.8;   // pixels, from the middle of a line to where it has faded
constexpr double kEdgeShade = 0.35;  // of the colour, in the middle of a line

void darken_edges(const SurfaceFragment& fragment, const Surface::Triangle& triangle, Rgb& color) {
  double factor = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    if ((triangle.edges >> i & 1U) == 0 || fragment.edge_distance[i] >= kEdgeWidth) continue;
    factor = std::min(factor, std::lerp(kEdgeShade, 1.0, fragment.edge_distance[i] / kEdgeWidth));
  }
  for (double& c : color) c *= factor;
}

}  // namespace

SurfaceShader::SurfaceShader(const Surface& surface, const SurfaceRaster& raster,
                             const Camera& camera, const Look& look, bool shows_edges,
                             const view::LightVolume* light)
    : surface_(surface),
      raster_(raster),
      look_(look),
      shows_edges_(shows_edges),
      light_(light),
      colors_(view::colors_alone(view::color_function_of(look))),
      key_(view::direction_of_light(look, camera)) {}

Rgb SurfaceShader::color_of(const SurfaceFragment& fragment) const {
  const Surface::Triangle& triangle = surface_.triangles[fragment.triangle];
  float value = 0;
  Vec3 normal = Vec3::Zero();
  for (std::size_t c = 0; c < 3; ++c) {
    value += fragment.shares[c] * triangle.values[c];
    normal += (fragment.shares[c] * triangle.normals[c]).cast<double>();
  }
  const view::LookTable::Sample own = colors_.at(value);
  Rgb color{own.r, own.g, own.b};
  if (shows_edges_) darken_edges(fragment, triangle, color);
  if (!look_.shade && light_ == nullptr) return color;
  normal.normalize();
  const Vec3 place = raster_.place_of(fragment);
  const Vec3 to_eye = raster_.towards_eye(place);
  const view::ArrivingLight arriving =
      light_ != nullptr ? light_->arriving_at(place, normal, to_eye, 1, view::kEdgesAway)
                        : view::ArrivingLight{};
  if (!look_.shade) {
    for (double& c : color) c *= view::unlit_share(arriving);
    return color;
  }
  const view::LightShares light =
      view::light_shares(look_, normal, key_.value_or(to_eye), to_eye, arriving);
  return view::lit_color(color, look_.material, light, 1);
}

}  // namespace ovoid
