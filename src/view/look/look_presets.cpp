// SPDX-License-Identifier: Apache-2.0
// Looks for kinds of data, designed for this project on real scans (docs/looks.md, "Presets").
// Hounsfield units: air -1000, lung -900 to -600, fat -120 to -60, water 0, soft tissue 20 to 80,
// blood with contrast 150 to 500, spongy bone 150 to 500, dense bone 700 to 2000, metal above 3000.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>

#include "ovoid/error.h"
#include "ovoid/look.h"
#include "view/look/label_look.h"

namespace ovoid {
namespace {

struct PresetPoint {
  double x;  // Hounsfield units, or fraction of the data's range
  double opacity;
  std::uint32_t rgb;  // 0xrrggbb
};

struct Preset {
  std::string_view name;
  std::span<const PresetPoint> points;
  Material material;
  bool is_relative = false;
};

// clang-format off
constexpr PresetPoint kCtBone[] = {
    {-1000, 0, 0x7a3a20}, {160, 0, 0x8c4a2a}, {260, 0.06, 0xb87848}, {380, 0.35, 0xe0bf94},
    {700, 0.8, 0xf2e3c4}, {1500, 0.95, 0xfffaf0}, {3000, 1, 0xffffff}};

constexpr PresetPoint kCtSkin[] = {
    {-1000, 0, 0x9c6448}, {-550, 0, 0xb9785a}, {-350, 0.55, 0xd79a76}, {-100, 0.85, 0xe8b795},
    {150, 0.9, 0xedc4a4}, {400, 0.95, 0xf3dcc4}, {3000, 1, 0xfffaf0}};

// Fat is passed over, so that muscles and organs stand free; bone shows where it breaks through.
constexpr PresetPoint kCtSoftTissue[] = {
    {-1000, 0, 0x6e2f26}, {-20, 0, 0x8f3f33}, {20, 0.10, 0xb3574a}, {60, 0.32, 0xc97a66},
    {130, 0.45, 0xdb9d84}, {250, 0.6, 0xecd2b0}, {800, 0.9, 0xfaf0dc}, {3000, 1, 0xffffff}};

// Airways and the lung's surface; what is denser than lung is left out, but for a hint of vessels.
constexpr PresetPoint kCtLung[] = {
    {-1000, 0, 0x2b4f7a}, {-960, 0, 0x3b6a9c}, {-900, 0.012, 0x6d9cc4}, {-750, 0.03, 0xa9c7dd},
    {-600, 0.06, 0xe6c9c0}, {-450, 0.10, 0xe09a8c}, {-300, 0.02, 0xd87a6c}, {-200, 0, 0xd06a5c},
    {3000, 0, 0xd06a5c}};

// Vessels with contrast red over bone's ivory, as far as their values are apart.
constexpr PresetPoint kCtAngio[] = {
    {-1000, 0, 0x7a0f12}, {110, 0, 0x8f1416}, {170, 0.18, 0xb81f1c}, {280, 0.6, 0xdc4a34},
    {420, 0.75, 0xefa070}, {600, 0.85, 0xf5deb8}, {1500, 0.95, 0xfffaf0}, {3000, 1, 0xffffff}};

constexpr PresetPoint kMrDefault[] = {
    {0, 0, 0x2a1a16}, {0.08, 0, 0x4a2c22}, {0.16, 0.10, 0x7d4f3c}, {0.3, 0.24, 0xb68464},
    {0.5, 0.36, 0xdcb795}, {0.75, 0.5, 0xf2e0c8}, {1, 0.6, 0xffffff}};

constexpr PresetPoint kMrAngio[] = {
    {0, 0, 0x4a0d0d}, {0.28, 0, 0x6a1212}, {0.4, 0.12, 0xa3241c}, {0.55, 0.5, 0xd85a3a},
    {0.75, 0.8, 0xf4b47a}, {1, 0.95, 0xfff4dc}};

constexpr Preset kPresets[] = {
    {"ct-bone", kCtBone, {.ambient = 0.15, .diffuse = 0.75, .specular = 0.25, .specular_power = 25}},
    {"ct-skin", kCtSkin, {.ambient = 0.2, .diffuse = 0.75, .specular = 0.12, .specular_power = 15}},
    {"ct-soft-tissue", kCtSoftTissue, {.ambient = 0.2, .diffuse = 0.75, .specular = 0.2, .specular_power = 20}},
    {"ct-lung", kCtLung, {.ambient = 0.3, .diffuse = 0.75, .specular = 0.1, .specular_power = 10}},
    {"ct-angio", kCtAngio, {.ambient = 0.15, .diffuse = 0.75, .specular = 0.3, .specular_power = 30}},
    {"mr-default", kMrDefault, {.ambient = 0.2, .diffuse = 0.8, .specular = 0.15, .specular_power = 15}, true},
    {"mr-angio", kMrAngio, {.ambient = 0.2, .diffuse = 0.75, .specular = 0.25, .specular_power = 25}, true},
};
// clang-format on

constexpr std::string_view kLabel = "label";
constexpr int kNumLabels = 256;       // colours of the map glasbey
constexpr int kMostLabels = 1 << 24;  // that a float tells apart
constexpr double kLabelOpacity = 0.9;

// Label k has colour k - 1 of the map glasbey, which begins again behind its last; background, 0,
// shows nothing. There are at least kNumLabels, and as many as the data have; of more than
// kMostLabelBands as many numbers share a colour as it takes.
TransferFunction label_function(const ValueRange& range) {
  const double greatest = range.is_empty() ? 0.0 : std::ceil(static_cast<double>(range.hi));
  const int num_labels = static_cast<int>(std::clamp<double>(greatest, kNumLabels, kMostLabels));
  const int width = (num_labels + view::kMostLabelBands - 1) / view::kMostLabelBands;
  const int num_bands = (num_labels + width - 1) / width;
  const TransferFunction glasbey = color_map("glasbey");
  // Half-way from the background to the middle of the first band lies 0.5.
  std::vector<double> values{0.5 * (1 - width)};
  std::vector<Rgb> colors{{0, 0, 0}};
  for (int band = 0; band < num_bands; ++band) {
    values.push_back(1 + width * band + 0.5 * (width - 1));
    colors.push_back(glasbey.color_at((band % kNumLabels + 0.5) / kNumLabels));
  }
  TransferFunction tf = categorical(values, colors);
  const double opacity = num_labels > kNumLabels ? view::kLabelOpacityWithoutGaps : kLabelOpacity;
  const double last = static_cast<double>(num_bands) * width;
  tf.opacities = {{0.0, 0.0}, {0.5, 0.0}, {0.5, opacity}, {last, opacity}};
  return tf;
}

TransferFunction function_of(const Preset& preset, const ValueRange& range) {
  TransferFunction tf;
  for (const PresetPoint& point : preset.points) {
    tf.colors.push_back({point.x,
                         {(point.rgb >> 16 & 0xffU) / 255.0, (point.rgb >> 8 & 0xffU) / 255.0,
                          (point.rgb & 0xffU) / 255.0}});
    tf.opacities.push_back({point.x, point.opacity});
  }
  if (!preset.is_relative || range.is_empty()) return tf;
  // As the default look treats a constant field: it shows half way up.
  const double half = range.lo < range.hi ? 0.0 : std::max(0.5, 0.5 * std::abs(range.lo));
  tf.map_range(range.lo - half, range.hi + half);
  return tf;
}

}  // namespace

Look look_preset(const std::string& name, const ValueRange& range) {
  Look look;
  if (name == kCinematicPreset) {
    look = ramp_look(range);
    add_cinematic_light(look);
  } else if (name == kLabel) {
    look.transfer_function = label_function(range);
    look.material = {.ambient = 0.25, .diffuse = 0.75, .specular = 0.1, .specular_power = 10};
  } else {
    const auto* preset = std::find_if(std::begin(kPresets), std::end(kPresets),
                                      [&](const Preset& p) { return p.name == name; });
    if (preset == std::end(kPresets)) {
      throw Error(ErrorCode::kInvalidArgument, fmt::format("preset = {}: must be one of {}", name,
                                                           fmt::join(look_preset_names(), " ")));
    }
    look.transfer_function = function_of(*preset, range);
    look.material = preset->material;
  }
  look.transfer_function.name = name;
  return look;
}

std::vector<std::string> look_preset_names() {
  std::vector<std::string> names;
  for (const Preset& preset : kPresets) names.emplace_back(preset.name);
  names.emplace_back(kLabel);
  names.emplace_back(kCinematicPreset);
  return names;
}

void add_cinematic_light(Look& look) {
  look.shade = true;
  look.light = Light::kStudio;
  look.material = {.ambient = 0.2, .diffuse = 0.85, .specular = 0.3, .specular_power = 30};
  look.occlusion = 0.7;
  look.shadows = 0.7;
  look.scatter = 0.5;
}

}  // namespace ovoid
