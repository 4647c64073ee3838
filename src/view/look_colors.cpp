// SPDX-License-Identifier: Apache-2.0
#include "view/look_colors.h"

#include <algorithm>
#include <cmath>

namespace ovoid::view {

void set_body_colors(Look& look, double lo, double hi) {
  TransferFunction& tf = look.transfer_function;
  tf.name = "clay to ivory";
  tf.color_space = ColorSpace::kLab;
  tf.colors = {{0.0, {0.79, 0.48, 0.35}},
               {0.25, {0.87, 0.63, 0.47}},
               {0.5, {0.93, 0.78, 0.61}},
               {0.75, {0.97, 0.90, 0.79}},
               {1.0, {1.0, 0.98, 0.95}}};
  tf.map_range(lo, hi);
}

void set_bright_colors(Look& look, double lo, double hi) {
  TransferFunction& tf = look.transfer_function;
  tf.name = "sky to coral";
  tf.color_space = ColorSpace::kLab;
  tf.colors = {{0.0, {0.45, 0.70, 1.0}},
               {0.3, {0.57, 0.88, 0.94}},
               {0.55, {0.98, 0.93, 0.66}},
               {0.8, {0.99, 0.66, 0.30}},
               {1.0, {0.95, 0.40, 0.30}}};
  tf.map_range(lo, hi);
}

void set_glowing_colors(Look& look, double lo, double hi) {
  TransferFunction& tf = look.transfer_function;
  tf.name = "dusk to white";
  tf.color_space = ColorSpace::kLab;
  tf.colors = {{0.0, {0.47, 0.56, 0.97}},
               {0.3, {0.80, 0.56, 0.96}},
               {0.55, {1.0, 0.62, 0.64}},
               {0.8, {1.0, 0.84, 0.54}},
               {1.0, {1.0, 0.98, 0.85}}};
  tf.map_range(lo, hi);
  look.shade = false;
}

void set_vessel_colors(Look& look, double tissue, double wall, double bright) {
  TransferFunction& tf = look.transfer_function;
  tf.name = "vessels";
  tf.color_space = ColorSpace::kLab;
  tf.colors = {
      {tissue, {0.84, 0.66, 0.56}}, {wall, {0.95, 0.42, 0.34}}, {bright, {1.0, 0.87, 0.70}}};
}

void set_two_sided_colors(Look& look, double lo, double hi) {
  look.transfer_function = color_map("cool-to-warm");
  look.transfer_function.map_range(lo, hi);
}

void set_light(Look& look, double noise, double softness) {
  constexpr double kLeastRise = 0.01;
  const double most_rise = std::lerp(0.06, 1.0, softness);
  look.light = Light::kStudio;
  look.material = {.ambient = 0.15, .diffuse = 0.85, .specular = 0.2, .specular_power = 25};
  const double span = look.transfer_function.hi() - look.transfer_function.lo();
  look.flat_rise = span > 0 ? std::clamp(noise / span, kLeastRise, most_rise) : kLeastRise;
}

}  // namespace ovoid::view
