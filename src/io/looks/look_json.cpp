// SPDX-License-Identifier: Apache-2.0
// ParaView's JSON colour presets; the format as read and written here is in docs/looks.md.
#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "io/core/atomic_file.h"
#include "io/core/json_file.h"
#include "io/core/numbers.h"
#include "io/core/text_file.h"
#include "io/looks/look_readers.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace {

using io::Json;
using io::JsonValue;
using OrderedJson = nlohmann::ordered_json;  // writes members in the order of the code

struct NamedSpace {
  std::string_view name;
  ColorSpace space;
};

constexpr NamedSpace kSpaces[] = {
    {"RGB", ColorSpace::kRgb},   {"HSV", ColorSpace::kHsv},
    {"Lab", ColorSpace::kLab},   {"Diverging", ColorSpace::kDiverging},
    {"Step", ColorSpace::kStep}, {io::kCiede2000, ColorSpace::kLab}};

double unit_number(const JsonValue& value) {
  const double number = value.number();
  if (!(number >= 0.0 && number <= 1.0)) value.refuse("must be in [0, 1]");
  return number;
}

Rgb color_from(const JsonValue& list, std::size_t first) {
  return {unit_number(list.element(first)), unit_number(list.element(first + 1)),
          unit_number(list.element(first + 2))};
}

// A flat list of groups of `size`: how many.
std::size_t num_groups(const JsonValue& list, std::size_t size, const char* expected) {
  if (list.array().size() % size != 0) list.refuse(expected);
  return list.size() / size;
}

std::size_t num_quadruples(const JsonValue& list) {
  return num_groups(list, 4, "must have four numbers per point");
}

bool is_on(const JsonValue& preset, const char* key) {
  return preset.has(key) && preset.member(key).boolean();
}

std::optional<Rgb> optional_color(const JsonValue& preset, const char* key, const char* use) {
  if (!is_on(preset, use)) return std::nullopt;
  return color_from(preset.member(key).array_of(3), 0);
}

std::vector<OpacityPoint> opacities_from(const JsonValue& list) {
  std::vector<OpacityPoint> points;
  for (std::size_t i = 0; i < 4 * num_quadruples(list); i += 4) {
    points.push_back({list.element(i).number(), unit_number(list.element(i + 1)),
                      unit_number(list.element(i + 2)), unit_number(list.element(i + 3))});
  }
  return points;
}

// Annotations are pairs of a value and a text; without them the values are 0, 1, 2 ...
std::vector<double> annotated_values(const JsonValue& preset, std::size_t num_colors) {
  std::vector<double> values;
  if (preset.has("Annotations") && preset.member("Annotations").size() > 0) {
    const JsonValue list = preset.member("Annotations");
    const std::size_t num_pairs = num_groups(list, 2, "must have a value and a text per category");
    for (std::size_t i = 0; i < 2 * num_pairs; i += 2) {
      const JsonValue value = list.element(i);
      const auto number =
          value.json().is_number() ? std::optional(value.number()) : io::parse_real(value.string());
      if (!number) value.refuse("must be a number, as the data's categories are");
      values.push_back(*number);
    }
  } else {
    for (std::size_t i = 0; i < num_colors; ++i) values.push_back(static_cast<double>(i));
  }
  return values;
}

void take_categories(TransferFunction& tf, const JsonValue& preset) {
  const JsonValue list = preset.member("IndexedColors");
  std::vector<Rgb> colors;
  const std::size_t num_colors = num_groups(list, 3, "must have three numbers per colour");
  if (num_colors == 0) list.refuse("must have at least one colour");
  for (std::size_t i = 0; i < 3 * num_colors; i += 3) colors.push_back(color_from(list, i));
  const TransferFunction steps = categorical(annotated_values(preset, num_colors), colors);
  tf.colors = steps.colors;
  tf.color_space = steps.color_space;
}

void take_colors(TransferFunction& tf, const JsonValue& preset, const std::string& place) {
  const std::string space = preset.has("ColorSpace") ? preset.member("ColorSpace").string() : "RGB";
  tf.color_space = io::color_space_called(space, place + "ColorSpace");
  if (tf.color_space == ColorSpace::kHsv && is_on(preset, "HSVWrap")) {
    tf.color_space = ColorSpace::kHsvWrap;
  }
  if (!preset.has("RGBPoints")) return;
  const JsonValue list = preset.member("RGBPoints");
  for (std::size_t i = 0; i < 4 * num_quadruples(list); i += 4) {
    tf.colors.push_back({list.element(i).number(), color_from(list, i + 1)});
  }
  tf.sort();
  if (space == io::kCiede2000) io::follow_ciede2000_of(tf, place + "RGBPoints");
}

// Points at or below 0 have no place on a logarithmic scale; the order of reading is the file's.
void require_logarithms(const JsonValue& preset, const char* key) {
  if (!preset.has(key)) return;
  const JsonValue list = preset.member(key);
  for (std::size_t i = 0; i < 4 * num_quadruples(list); i += 4) {
    if (!(list.element(i).number() > 0.0)) list.element(i).refuse("must be > 0 with UseLogScale");
  }
}

void take_scale(TransferFunction& tf, const JsonValue& preset) {
  if (is_on(preset, "UseLogScale")) {
    tf.scale = ValueScale::kLog;
    require_logarithms(preset, "RGBPoints");
    require_logarithms(preset, "Points");
  } else if (preset.has("SymlogLinearWidth")) {
    const JsonValue width = preset.member("SymlogLinearWidth");
    if (!(width.number() > 0.0)) width.refuse("must be > 0");
    tf.scale = ValueScale::kSymlog;
    tf.linear_width = width.number();
  }
}

std::vector<FurtherLight> lights_from(const JsonValue& list) {
  constexpr double kGreatestIntensity = 10;
  if (!list.json().is_array()) list.refuse("must be an array of lights");
  if (list.size() > Look::kMaxFurtherLights)
    list.refuse(fmt::format("must have at most {} lights", Look::kMaxFurtherLights));
  std::vector<FurtherLight> lights(list.size());
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const JsonValue light = list.element(i).object();
    const JsonValue direction = light.member("Direction").array_of(3);
    for (std::size_t a = 0; a < 3; ++a)
      lights[i].direction[static_cast<int>(a)] = direction.element(a).number();
    const double length = lights[i].direction.norm();
    if (!(length > 0.0 && std::isfinite(length)))
      direction.refuse("must be a direction other than 0, 0, 0");
    if (!light.has("Intensity")) continue;
    const JsonValue intensity = light.member("Intensity");
    lights[i].intensity = intensity.number();
    if (!(lights[i].intensity >= 0.0 && lights[i].intensity <= kGreatestIntensity))
      intensity.refuse("must be in [0, 10]");
  }
  return lights;
}

// Our own keys.
void take_light(Look& look, const JsonValue& preset) {
  if (preset.has("Shade")) look.shade = preset.member("Shade").boolean();
  for (const auto& [key, into] :
       {std::pair{"FlatRise", &look.flat_rise}, std::pair{"Occlusion", &look.occlusion},
        std::pair{"Shadows", &look.shadows}, std::pair{"Scatter", &look.scatter}}) {
    if (!preset.has(key)) continue;
    const JsonValue share = preset.member(key);
    if (!(share.number() >= 0.0 && share.number() <= 1.0)) share.refuse("must be in [0, 1]");
    *into = share.number();
  }
  if (preset.has("Lights")) look.further_lights = lights_from(preset.member("Lights"));
  Material& material = look.material;
  for (const auto& [key, into] :
       {std::pair{"Ambient", &material.ambient}, std::pair{"Diffuse", &material.diffuse},
        std::pair{"Specular", &material.specular},
        std::pair{"SpecularPower", &material.specular_power}}) {
    if (!preset.has(key)) continue;
    const JsonValue value = preset.member(key);
    if (!(value.number() >= 0.0)) value.refuse("must be >= 0");
    *into = value.number();
  }
}

std::string place_of(const io::LookFile& file, const JsonValue& root, std::size_t index) {
  return file.path + ": " + (root.json().is_array() ? fmt::format("[{}].", index) : "");
}

Look look_from(const JsonValue& preset, const io::LookFile& file, const std::string& place) {
  Look look;
  TransferFunction& tf = look.transfer_function;
  if (preset.has("Name")) tf.name = preset.member("Name").string();
  if (!preset.has("RGBPoints") && !preset.has("Points") && !preset.has("IndexedColors")) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: {} has neither RGBPoints, IndexedColors nor Points; {}", file.path,
                            tf.name.empty() ? "the preset"
                                            : fmt::format("preset '{}'", io::printable(tf.name)),
                            io::kExpectedLook));
  }
  take_scale(tf, preset);
  const bool is_categorical =
      preset.has("IndexedColors") && (is_on(preset, "IndexedLookup") || !preset.has("RGBPoints"));
  if (is_categorical) {
    take_categories(tf, preset);
  } else {
    take_colors(tf, preset, place);
  }
  if (preset.has("Points")) tf.opacities = opacities_from(preset.member("Points"));
  if (preset.has("GradientOpacityPoints")) {
    tf.gradient_opacities = opacities_from(preset.member("GradientOpacityPoints"));
  }
  if (preset.has("NanColor")) tf.nan_color = color_from(preset.member("NanColor").array_of(3), 0);
  tf.below_color = optional_color(preset, "BelowRangeColor", "UseBelowRangeColor");
  tf.above_color = optional_color(preset, "AboveRangeColor", "UseAboveRangeColor");
  if (preset.has("ScalarOpacityUnitDistance")) {
    const JsonValue value = preset.member("ScalarOpacityUnitDistance");
    if (!(value.number() > 0.0)) value.refuse("must be > 0");
    tf.unit_distance = value.number();
  }
  take_light(look, preset);
  if (preset.has("TransferFunction2D"))
    look.transfer_function_2d = io::function_2d_from(preset.member("TransferFunction2D"));
  return look;
}

OrderedJson flat(const std::vector<OpacityPoint>& points) {
  OrderedJson list = OrderedJson::array();
  for (const OpacityPoint& p : points) {
    for (const double v : {p.x, p.opacity, p.midpoint, p.sharpness}) list.push_back(v);
  }
  return list;
}

void put_bound(OrderedJson& preset, const std::string& side, const std::optional<Rgb>& color) {
  if (!color) return;
  preset["Use" + side + "RangeColor"] = 1;
  preset[side + "RangeColor"] = *color;
}

OrderedJson preset_of(const TransferFunction& tf) {
  OrderedJson preset;
  preset["Name"] = tf.name;
  const bool wraps = tf.color_space == ColorSpace::kHsvWrap;
  for (const NamedSpace& named : kSpaces) {
    if (named.name == io::kCiede2000) continue;
    if (named.space == (wraps ? ColorSpace::kHsv : tf.color_space))
      preset["ColorSpace"] = named.name;
  }
  if (wraps) preset["HSVWrap"] = 1;
  if (tf.scale == ValueScale::kLog) preset["UseLogScale"] = 1;
  if (tf.scale == ValueScale::kSymlog) preset["SymlogLinearWidth"] = tf.linear_width;
  preset["NanColor"] = tf.nan_color;
  put_bound(preset, "Below", tf.below_color);
  put_bound(preset, "Above", tf.above_color);
  if (tf.unit_distance) preset["ScalarOpacityUnitDistance"] = *tf.unit_distance;
  OrderedJson& colors = preset["RGBPoints"] = OrderedJson::array();
  for (const ColorPoint& p : tf.colors) {
    for (const double v : {p.x, p.rgb[0], p.rgb[1], p.rgb[2]}) colors.push_back(v);
  }
  preset["Points"] = flat(tf.opacities);
  if (!tf.gradient_opacities.empty()) {
    preset["GradientOpacityPoints"] = flat(tf.gradient_opacities);
  }
  return preset;
}

std::string text_of(const OrderedJson& preset) {
  try {
    return OrderedJson::array({preset}).dump(1) +
           "\n";  // doubles in the fewest digits that read back the same
  } catch (const OrderedJson::type_error&) {
    throw Error(ErrorCode::kInvalidArgument, "transfer function name: must be UTF-8");
  }
}

}  // namespace

namespace io {

ColorSpace color_space_called(const std::string& name, const std::string& place) {
  for (const NamedSpace& named : kSpaces) {
    if (named.name == name) return named.space;
  }
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{} = \"{}\": must be RGB, HSV, Lab, Diverging, Step or {}", place,
                          printable(name), kCiede2000));
}

void follow_ciede2000_of(TransferFunction& tf, const std::string& place) {
  try {
    follow_ciede2000(tf);
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("{}: {}", place, error.what()));
  }
}

Look read_paraview_json(const LookFile& file, const Json& json) {
  const JsonValue root(json, file.path + ": ");
  std::vector<JsonValue> presets;
  if (json.is_object()) {
    presets.push_back(root);
  } else {
    if (!json.is_array()) root.refuse("must be a preset or an array of presets");
    for (std::size_t i = 0; i < root.size(); ++i) presets.push_back(root.element(i).object());
  }
  if (presets.empty()) root.refuse("must hold at least one preset");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < presets.size(); ++i) {
    if (file.wanted.empty()) return look_from(presets[i], file, place_of(file, root, i));
    if (!presets[i].has("Name")) continue;
    names.push_back(presets[i].member("Name").string());
    if (names.back() == file.wanted) return look_from(presets[i], file, place_of(file, root, i));
  }
  refuse_name(file, names);
}

}  // namespace io

void write_transfer_function(const TransferFunction& tf, const std::string& path) {
  Look look;
  look.transfer_function = tf;
  look.validate();
  io::write_atomically(path, text_of(preset_of(tf)));
}

std::string to_text(const Look& look) {
  look.validate();
  TransferFunction tf = look.transfer_function;
  if (look.unit_distance > 0.0) tf.unit_distance = look.unit_distance;
  OrderedJson preset = preset_of(tf);
  preset["Shade"] = look.shade;
  preset["Ambient"] = look.material.ambient;
  preset["Diffuse"] = look.material.diffuse;
  preset["Specular"] = look.material.specular;
  preset["SpecularPower"] = look.material.specular_power;
  preset["FlatRise"] = look.flat_rise;
  preset["Occlusion"] = look.occlusion;
  preset["Shadows"] = look.shadows;
  preset["Scatter"] = look.scatter;
  for (const FurtherLight& light : look.further_lights) {
    const Vec3& towards = light.direction;
    OrderedJson entry;
    entry["Direction"] = {towards.x(), towards.y(), towards.z()};
    entry["Intensity"] = light.intensity;
    preset["Lights"].push_back(std::move(entry));
  }
  if (look.transfer_function_2d)
    preset["TransferFunction2D"] = io::json_of(*look.transfer_function_2d);
  return text_of(preset);
}

void write_look(const Look& look, const std::string& path) {
  io::write_atomically(path, to_text(look));
}

}  // namespace ovoid
