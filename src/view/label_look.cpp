// SPDX-License-Identifier: Apache-2.0
#include "view/label_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace ovoid::view {
namespace {

// Hues by the golden angle, so that any number of labels get colours that differ.
Rgb label_color(std::size_t i) {
  const double hue = std::fmod(0.02 + static_cast<double>(i) * (std::numbers::phi - 1.0), 1.0);
  const double saturation = i % 2 == 0 ? 0.62 : 0.45;
  const double brightness = i % 3 == 2 ? 0.75 : 0.95;
  Rgb rgb;
  for (std::size_t c = 0; c < 3; ++c) {
    const double k = std::fmod(hue * 6.0 + std::array{5.0, 3.0, 1.0}[c], 6.0);
    rgb[c] = brightness * (1.0 - saturation * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0));
  }
  return rgb;
}

}  // namespace

Look label_look(const std::vector<int>& labels, const FieldSamples& samples) {
  const int background =
      labels.front() == 0 ? 0 : static_cast<int>(quantile(samples.on_faces, 0.5));
  Look look;
  TransferFunction& tf = look.transfer_function;
  tf.name = "labels";
  tf.color_space = ColorSpace::kRgb;
  std::size_t num_shown = 0;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const bool is_shown = labels[i] != background || labels.size() == 1;
    const double lo = i == 0 ? labels[i] - 0.5 : 0.5 * (labels[i - 1] + labels[i]);
    const double hi = i + 1 == labels.size() ? labels[i] + 0.5 : 0.5 * (labels[i] + labels[i + 1]);
    const Rgb color = is_shown ? label_color(num_shown++) : Rgb{0.5, 0.5, 0.5};
    tf.colors.insert(tf.colors.end(), {{lo, color}, {hi, color}});
    const double opacity = is_shown ? 1.0 : 0.0;
    tf.opacities.push_back({.x = lo, .opacity = opacity});
    tf.opacities.push_back({.x = hi, .opacity = opacity});
  }
  return look;
}

}  // namespace ovoid::view
