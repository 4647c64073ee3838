// SPDX-License-Identifier: Apache-2.0
#include "view/look/look_colors.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace ovoid::view {
namespace {

// A map's ends are hardly used where materials fill its middle.
constexpr double kFirst = 0.05;
constexpr double kLast = 0.95;

// Where materials lie along a map: each `apart` from the one before, or as far as they have room,
// and otherwise as near to where they were (`shares` of the map's way, rising) as that allows.
std::vector<double> moved_apart(const std::vector<double>& shares, double apart) {
  const double first = std::min(shares.front(), kFirst);
  const double last = std::max(shares.back(), kLast);
  const double gap = std::min(apart, (last - first) / static_cast<double>(shares.size() - 1));
  std::vector<double> moved = shares;
  for (std::size_t i = 1; i < moved.size(); ++i) moved[i] = std::max(moved[i], moved[i - 1] + gap);
  moved.back() = std::min(moved.back(), last);
  for (std::size_t i = moved.size() - 1; i-- > 0;)
    moved[i] = std::min(moved[i], moved[i + 1] - gap);
  return moved;
}

// Colours at other values: those of the map, which spans all of `tf`, with its materials apart.
void set_materials_apart(TransferFunction& tf, std::span<const double> materials, double apart) {
  const double lo = tf.lo();
  const double span = tf.hi() - lo;
  std::vector<double> from;
  for (const double value : materials) {
    const double share = (value - lo) / span;
    if (share > 0 && share < 1) from.push_back(share);
  }
  if (from.size() < 2) return;
  std::vector<double> to = moved_apart(from, apart);
  from.push_back(1);
  to.push_back(1);
  std::vector<ColorPoint> colors;
  auto next = tf.colors.begin();
  double from_before = 0;
  double to_before = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    for (; next != tf.colors.end() && (next->x - lo) / span < to[i]; ++next) {
      const double s = ((next->x - lo) / span - to_before) / (to[i] - to_before);
      colors.push_back({lo + span * std::lerp(from_before, from[i], s), next->rgb});
    }
    colors.push_back({lo + span * from[i], tf.color_at(lo + span * to[i])});
    from_before = from[i];
    to_before = to[i];
  }
  tf.colors = std::move(colors);
}

}  // namespace

void set_body_colors(Look& look, double lo, double hi, std::span<const double> materials) {
  TransferFunction& tf = look.transfer_function;
  tf.name = "clay to ivory";
  tf.color_space = ColorSpace::kLab;
  tf.colors = {{0.0, {0.79, 0.48, 0.35}},
               {0.25, {0.87, 0.63, 0.47}},
               {0.5, {0.93, 0.78, 0.61}},
               {0.75, {0.97, 0.90, 0.79}},
               {1.0, {1.0, 0.98, 0.95}}};
  tf.map_range(lo, hi);
  constexpr double kApart = 0.45;  // of the way: 15.6 at the ivory end, where it is least
  set_materials_apart(tf, materials, kApart);
}

void set_bright_colors(Look& look, double lo, double hi, std::span<const double> materials) {
  TransferFunction& tf = look.transfer_function;
  tf.name = "sky to coral";
  tf.color_space = ColorSpace::kLab;
  tf.colors = {{0.0, {0.45, 0.70, 1.0}},
               {0.3, {0.57, 0.88, 0.94}},
               {0.55, {0.98, 0.93, 0.66}},
               {0.8, {0.99, 0.66, 0.30}},
               {1.0, {0.95, 0.40, 0.30}}};
  tf.map_range(lo, hi);
  constexpr double kApart = 0.225;  // of the way: 15.3 at the coral end, where it is least
  set_materials_apart(tf, materials, kApart);
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
