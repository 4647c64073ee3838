// SPDX-License-Identifier: Apache-2.0
// ParaView's JSON colour presets; the format as read and written here is in docs/looks.md.
#include <fmt/format.h>

#include <string_view>

#include "io/atomic_file.h"
#include "io/json_file.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/look.h"

namespace ovoid {
namespace {

using io::Json;
using io::JsonValue;
using OrderedJson = nlohmann::ordered_json;  // writes members in the order of the code

struct NamedSpace {
  std::string_view name;
  ColorSpace space;
};

constexpr NamedSpace kSpaces[] = {{"RGB", ColorSpace::kRgb},
                                  {"HSV", ColorSpace::kHsv},
                                  {"Lab", ColorSpace::kLab},
                                  {"Diverging", ColorSpace::kDiverging},
                                  {"Step", ColorSpace::kStep}};

double unit_number(const JsonValue& value) {
  const double number = value.number();
  if (!(number >= 0.0 && number <= 1.0)) value.refuse("must be in [0, 1]");
  return number;
}

Rgb color_from(const JsonValue& list, std::size_t first) {
  return {unit_number(list.element(first)), unit_number(list.element(first + 1)),
          unit_number(list.element(first + 2))};
}

// A flat list of groups of four: the number of groups.
std::size_t num_quadruples(const JsonValue& list) {
  if (list.array().size() % 4 != 0) list.refuse("must have four numbers per point");
  return list.size() / 4;
}

ColorSpace color_space_of(const JsonValue& preset) {
  if (!preset.has("ColorSpace")) return ColorSpace::kRgb;
  const JsonValue value = preset.member("ColorSpace");
  const std::string name = value.string();
  for (const NamedSpace& named : kSpaces) {
    if (named.name != name) continue;
    const bool wraps = named.space == ColorSpace::kHsv && preset.has("HSVWrap") &&
                       preset.member("HSVWrap").boolean();
    return wraps ? ColorSpace::kHsvWrap : named.space;
  }
  value.refuse("must be RGB, HSV, Lab, Diverging or Step");
}

TransferFunction function_from(const JsonValue& preset, const std::string& path) {
  TransferFunction tf;
  if (preset.has("Name")) tf.name = preset.member("Name").string();
  const std::string named = tf.name.empty() ? "the preset" : fmt::format("preset '{}'", tf.name);
  if (!preset.has("RGBPoints") && !preset.has("Points")) {
    const bool is_categorical = preset.has("IndexedColors");
    throw Error(
        is_categorical ? ErrorCode::kUnsupported : ErrorCode::kFileFormat,
        fmt::format("{}: {} has neither RGBPoints nor Points{}", path, named,
                    is_categorical ? "; categorical presets (IndexedColors) cannot be read" : ""));
  }
  if (preset.has("UseLogScale") && preset.member("UseLogScale").boolean()) {
    throw Error(
        ErrorCode::kUnsupported,
        fmt::format("{}: {} has UseLogScale: logarithmic presets cannot be read", path, named));
  }
  tf.color_space = color_space_of(preset);
  if (preset.has("RGBPoints")) {
    const JsonValue list = preset.member("RGBPoints");
    for (std::size_t i = 0; i < 4 * num_quadruples(list); i += 4) {
      tf.colors.push_back({list.element(i).number(), color_from(list, i + 1)});
    }
  }
  if (preset.has("Points")) {
    const JsonValue list = preset.member("Points");
    for (std::size_t i = 0; i < 4 * num_quadruples(list); i += 4) {
      tf.opacities.push_back({list.element(i).number(), unit_number(list.element(i + 1)),
                              unit_number(list.element(i + 2)), unit_number(list.element(i + 3))});
    }
  }
  if (preset.has("NanColor")) tf.nan_color = color_from(preset.member("NanColor").array_of(3), 0);
  if (preset.has("ScalarOpacityUnitDistance")) {
    const JsonValue value = preset.member("ScalarOpacityUnitDistance");
    if (!(value.number() > 0.0)) value.refuse("must be > 0");
    tf.unit_distance = value.number();
  }
  tf.sort();
  return tf;
}

// The preset called `name`, or the first if `name` is empty.
JsonValue chosen_preset(const JsonValue& root, const std::string& path, const std::string& name) {
  std::vector<JsonValue> presets;
  if (root.json().is_object()) {
    presets.push_back(root);
  } else {
    if (!root.json().is_array()) root.refuse("must be a preset or an array of presets");
    for (std::size_t i = 0; i < root.size(); ++i) presets.push_back(root.element(i).object());
  }
  if (presets.empty()) root.refuse("must hold at least one preset");
  if (name.empty()) return presets.front();

  constexpr std::size_t kShown = 10;
  std::string names;
  std::size_t num_names = 0;
  for (const JsonValue& preset : presets) {
    if (!preset.has("Name")) continue;
    const std::string its_name = preset.member("Name").string();
    if (its_name == name) return preset;
    if (++num_names <= kShown) names += (names.empty() ? "" : ", ") + its_name;
  }
  if (num_names > kShown) names += fmt::format(" and {} more", num_names - kShown);
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("preset = {}: {} has {}", name, path, names));
}

}  // namespace

TransferFunction read_transfer_function(const std::string& path, const std::string& preset) {
  const Json json = io::read_json(path);
  return function_from(chosen_preset(JsonValue(json, path + ": "), path, preset), path);
}

void write_transfer_function(const TransferFunction& tf, const std::string& path) {
  Look look;
  look.transfer_function = tf;
  look.validate();

  OrderedJson preset;
  preset["Name"] = tf.name;
  const bool wraps = tf.color_space == ColorSpace::kHsvWrap;
  for (const NamedSpace& named : kSpaces) {
    if (named.space == (wraps ? ColorSpace::kHsv : tf.color_space))
      preset["ColorSpace"] = named.name;
  }
  if (wraps) preset["HSVWrap"] = 1;
  preset["NanColor"] = tf.nan_color;
  if (tf.unit_distance) preset["ScalarOpacityUnitDistance"] = *tf.unit_distance;
  OrderedJson& colors = preset["RGBPoints"] = OrderedJson::array();
  for (const ColorPoint& p : tf.colors) {
    for (const double v : {p.x, p.rgb[0], p.rgb[1], p.rgb[2]}) colors.push_back(v);
  }
  OrderedJson& opacities = preset["Points"] = OrderedJson::array();
  for (const OpacityPoint& p : tf.opacities) {
    for (const double v : {p.x, p.opacity, p.midpoint, p.sharpness}) opacities.push_back(v);
  }
  std::string text;
  try {
    text = OrderedJson::array({preset}).dump(1) +
           "\n";  // doubles in the fewest digits that read back the same
  } catch (const OrderedJson::type_error&) {
    throw Error(ErrorCode::kInvalidArgument, "transfer function name: must be UTF-8");
  }
  io::write_atomically(path, text);
}

}  // namespace ovoid
