// SPDX-License-Identifier: Apache-2.0
// The built-in colour maps by name, from the tables of color_map_tables.h.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string_view>

#include "ovoid/error.h"
#include "ovoid/transfer_function.h"
#include "view/look/color_map_tables.h"

namespace ovoid {
namespace {

struct NamedMap {
  std::string_view name;
  std::span<const view::Knot> knots = {};
  std::span<const view::Knot8> knots8{};        // instead of `knots`
  std::span<const std::uint32_t> categories{};  // instead of both: 0xrrggbb
  ColorSpace space = ColorSpace::kRgb;
};

constexpr NamedMap kMaps[] = {
    {.name = "viridis", .knots = view::kViridis},
    {.name = "inferno", .knots = view::kInferno},
    {.name = "plasma", .knots = view::kPlasma},
    {.name = "magma", .knots = view::kMagma},
    {.name = "cividis", .knots = view::kCividis},
    {.name = "turbo", .knots = view::kTurbo},
    {.name = "gray", .knots = view::kGray},
    {.name = "bone", .knots = view::kBone},
    {.name = "hot", .knots = view::kHot},
    {.name = "cool-to-warm", .knots = view::kCoolToWarm, .space = ColorSpace::kDiverging},
    {.name = "coolwarm", .knots = view::kCoolwarm},
    {.name = "fast", .knots = view::kFast, .space = ColorSpace::kLab},
    {.name = "thermal", .knots8 = view::kThermal},
    {.name = "haline", .knots8 = view::kHaline},
    {.name = "batlow", .knots8 = view::kBatlow},
    {.name = "vik", .knots8 = view::kVik},
    {.name = "tab10", .categories = view::kTab10},
    {.name = "tab20", .categories = view::kTab20},
    {.name = "glasbey", .categories = view::kGlasbey},
};

constexpr std::string_view kReversed = "_r";

Rgb unpacked(std::uint32_t rgb) {
  return {(rgb >> 16 & 0xffU) / 255.0, (rgb >> 8 & 0xffU) / 255.0, (rgb & 0xffU) / 255.0};
}

// n colours side by side over [0, 1], each 1/n wide; the middle of each is its value.
TransferFunction side_by_side(std::span<const std::uint32_t> rgbs) {
  std::vector<double> middles;
  std::vector<Rgb> colors;
  for (std::size_t i = 0; i < rgbs.size(); ++i) {
    middles.push_back((static_cast<double>(i) + 0.5) / static_cast<double>(rgbs.size()));
    colors.push_back(unpacked(rgbs[i]));
  }
  TransferFunction tf = categorical(middles, colors);
  tf.colors.front().x = 0.0;
  tf.colors.back().x = 1.0;
  return tf;
}

void reverse(TransferFunction& tf) {
  std::reverse(tf.colors.begin(), tf.colors.end());
  for (ColorPoint& point : tf.colors) point.x = 1.0 - point.x;
}

}  // namespace

TransferFunction categorical(const std::vector<double>& values, const std::vector<Rgb>& colors) {
  if (values.empty() || colors.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("categories with {} values and {} colours: must have one of each",
                            values.size(), colors.size()));
  }
  std::map<double, Rgb> sorted;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("values[{}] = {}: must be finite", i, values[i]));
    }
    sorted[values[i]] = colors[i % colors.size()];
  }
  // An interval of kStep has the colour of its right point: one ends half way between two values.
  TransferFunction tf;
  tf.color_space = ColorSpace::kStep;
  tf.colors.push_back({sorted.begin()->first, sorted.begin()->second});
  for (auto it = sorted.begin(); it != sorted.end(); ++it) {
    const auto next = std::next(it);
    const double end = next == sorted.end() ? it->first : 0.5 * it->first + 0.5 * next->first;
    tf.colors.push_back({end, it->second});
  }
  return tf;
}

TransferFunction color_map(const std::string& name) {
  std::string_view stem = name;
  const bool is_reversed = stem.ends_with(kReversed);
  if (is_reversed) stem.remove_suffix(kReversed.size());
  const auto* map = std::find_if(std::begin(kMaps), std::end(kMaps),
                                 [&](const NamedMap& m) { return m.name == stem; });
  if (map == std::end(kMaps)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("colour map = {}: must be one of {}, or one of these with {}", name,
                            fmt::join(color_map_names(), " "), kReversed));
  }
  TransferFunction tf;
  if (!map->categories.empty()) {
    std::vector<std::uint32_t> rgbs(map->categories.begin(), map->categories.end());
    if (is_reversed) std::reverse(rgbs.begin(), rgbs.end());
    tf = side_by_side(rgbs);
  } else {
    tf.color_space = map->space;
    for (const view::Knot& knot : map->knots) tf.colors.push_back({knot.at / 255.0, knot.rgb});
    for (const view::Knot8& knot : map->knots8)
      tf.colors.push_back({knot.at / 255.0, unpacked(knot.rgb)});
    if (is_reversed) reverse(tf);
  }
  tf.name = name;
  return tf;
}

std::vector<std::string> color_map_names() {
  std::vector<std::string> names;
  for (const NamedMap& map : kMaps) names.emplace_back(map.name);
  return names;
}

}  // namespace ovoid
