// SPDX-License-Identifier: Apache-2.0
#include "view/look/label_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "data/lattice/sample_reader.h"

namespace ovoid::view {
namespace {

// From one label to another the field passes all values between, within a tenth of a spacing with
// kLabelKernel. Of each band the part about its labels shows, so that the passage is mostly clear.
constexpr std::size_t kMostWithGaps = 256;
constexpr double kShown = 0.2;  // of the way from a band's labels to its ends
constexpr double kOpacity = 0.99;

// Hues by the golden angle, so that any number of labels get colours that differ.
Rgb golden_color(std::uint64_t i, double saturation, double brightness) {
  const double hue = std::fmod(0.02 + static_cast<double>(i) * (std::numbers::phi - 1.0), 1.0);
  Rgb rgb;
  for (std::size_t c = 0; c < 3; ++c) {
    const double k = std::fmod(hue * 6.0 + std::array{5.0, 3.0, 1.0}[c], 6.0);
    rgb[c] = brightness * (1.0 - saturation * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0));
  }
  return rgb;
}

// Labels that follow each other and share what the first of them shows.
struct Band {
  LabelColor first;
  int last;
};

// One for each label, or where they reach further than kMostLabelBands, of as many numbers each.
std::vector<Band> bands_of(std::span<const LabelColor> labels) {
  const double width =
      static_cast<double>(labels.back().label - labels.front().label) / kMostLabelBands;
  std::vector<Band> bands;
  for (const LabelColor& label : labels) {
    const bool joins = !bands.empty() && label.label - bands.back().first.label < width &&
                       (label.opacity > 0) == (bands.back().first.opacity > 0);
    if (joins) {
      bands.back().last = label.label;
    } else {
      bands.push_back({label, label.label});
    }
  }
  return bands;
}

// 0, or what the faces show most. Among many labels a single one in the middle would be narrower
// than the table's cells: then nothing is background (-1).
int background_of(std::span<const int> labels, const FieldSamples& samples) {
  if (labels.front() == 0) return 0;
  const int on_faces = static_cast<int>(quantile(samples.on_faces, 0.5));
  const bool is_at_end = on_faces == labels.front() || on_faces == labels.back();
  return is_at_end || labels.back() - labels.front() <= kMostLabelBands ? on_faces : -1;
}

}  // namespace

Rgb color_of_rank(std::size_t i) {
  return golden_color(i, i % 2 == 0 ? 0.62 : 0.45, i % 3 == 2 ? 0.75 : 0.95);
}

Rgb color_of_label(int label) {
  const std::uint64_t mixed = data::scrambled(static_cast<std::uint64_t>(label));
  return golden_color(static_cast<std::uint64_t>(label), std::array{0.3, 0.5, 0.7}[mixed % 3],
                      std::array{1.0, 0.82}[mixed / 3 % 2]);
}

TransferFunction label_function(std::span<const LabelColor> labels) {
  constexpr Rgb kTransparent{0.5, 0.5, 0.5};
  const std::vector<Band> bands = bands_of(labels);
  TransferFunction tf;
  tf.name = "labels";
  tf.color_space = ColorSpace::kRgb;
  const bool has_gaps = bands.size() <= kMostWithGaps;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const auto& [shown, last] = bands[i];
    const int first = shown.label;
    const double lo = i == 0 ? first - 0.5 : 0.5 * (bands[i - 1].last + first);
    const double hi = i + 1 == bands.size() ? last + 0.5 : 0.5 * (last + bands[i + 1].first.label);
    if (shown.opacity == 0) {
      tf.colors.insert(tf.colors.end(), {{lo, kTransparent}, {hi, kTransparent}});
      tf.opacities.insert(tf.opacities.end(), {{.x = lo}, {.x = hi}});
      continue;
    }
    const double opacity = shown.opacity * (has_gaps ? kOpacity : kLabelOpacityWithoutGaps);
    tf.colors.insert(tf.colors.end(), {{lo, shown.color}, {hi, shown.color}});
    const double from = has_gaps ? std::lerp(first, lo, kShown) : lo;
    const double to = has_gaps ? std::lerp(last, hi, kShown) : hi;
    if (has_gaps) tf.opacities.insert(tf.opacities.end(), {{.x = lo}, {.x = from}});
    tf.opacities.insert(tf.opacities.end(),
                        {{.x = from, .opacity = opacity}, {.x = to, .opacity = opacity}});
    if (has_gaps) tf.opacities.insert(tf.opacities.end(), {{.x = to}, {.x = hi}});
  }
  return tf;
}

Look label_look(const std::vector<int>& labels, const FieldSamples& samples) {
  const int background = background_of(labels, samples);
  std::vector<LabelColor> colors;
  std::size_t num_shown = 0;
  for (const int label : labels) {
    const bool is_shown = label != background || labels.size() == 1;
    const Rgb color = !is_shown                     ? Rgb{}
                      : labels.size() <= kFewLabels ? color_of_rank(num_shown++)
                                                    : color_of_label(label);
    colors.push_back({label, color, is_shown ? 1.0 : 0.0});
  }
  Look look;
  look.transfer_function = label_function(colors);
  return look;
}

}  // namespace ovoid::view
