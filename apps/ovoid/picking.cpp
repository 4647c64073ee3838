// SPDX-License-Identifier: Apache-2.0
#include "picking.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

// Seven digits, which floats have; nothing is -0.
std::string text_of_number(double number) {
  const std::string text = fmt::format("{:.7g}", number);
  return text == "-0" ? "0" : text;
}
std::string text_of_place(const Vec3& v) {
  return fmt::format("{}, {}, {}", text_of_number(v.x()), text_of_number(v.y()),
                     text_of_number(v.z()));
}

std::string with_unit(const std::string& text, const std::string& unit) {
  return unit.empty() ? text : text + ' ' + unit;
}

// "HU/mm", "1/mm", "HU"
std::string unit_of_slope(const PickWords& words) {
  if (words.length_unit.empty()) return words.unit;
  return fmt::format("{}/{}", words.unit.empty() ? "1" : words.unit, words.length_unit);
}

// "value", or what the array is called.
std::string name_or(const std::string& name, const char* otherwise) {
  return name.empty() ? otherwise : name;
}

}  // namespace

PickedPixel parse_pixel(const std::string& text) {
  const std::vector<std::string> parts = split(text, ',');
  if (parts.size() != 2) throw BadValue("expected X,Y, a pixel, row 0 at the top");
  const auto number = [](const std::string& part) {
    return static_cast<int>(parse_integer(part, 0, RenderOptions::kMaxImageSide - 1));
  };
  return {number(parts[0]), number(parts[1])};
}

void check_pixels(const std::vector<PickedPixel>& pixels, const RenderOptions& options) {
  for (const auto& [x, y] : pixels) {
    if (x < options.width && y < options.height) continue;
    throw UsageError(fmt::format(
        "--pick {},{}: is outside of the picture of {}x{} pixels, expected 0,0 to {},{}", x, y,
        options.width, options.height, options.width - 1, options.height - 1));
  }
}

PickWords pick_words(const Subject& subject, const Shot& shot, const AnnotationFlags& marks) {
  PickWords words;
  words.array = subject.modelled.array;
  words.unit = subject.unit;
  if (subject.modelled.color_array != subject.modelled.array)
    words.color_array = subject.modelled.color_array;
  words.length_unit = marks.length_unit.value_or(shot.described.length_unit);
  words.space = shot.described.space;
  return words;
}

Picker::Picker(const Shot& shot, const RenderOptions& options)
    : field_(shot.scene.volumes.front().field),
      shot_(shot),
      options_(options),
      probe_(field_),
      surfaces_(shot.scene.labels),
      labels_(label_entries(shot.look().transfer_function)) {}

Pick Picker::at(const Image& image, int x, int y) const {
  return pick(image, x, y, {field_, probe_, shot_.camera, shot_.look(), options_});
}

std::optional<Label> Picker::label(const Pick& pick) const {
  if (!pick.place) return std::nullopt;
  constexpr int kSteps = 8;  // over a spacing
  const double step = default_unit_distance(field_) / kSteps;
  for (int i = 0; i <= kSteps; ++i) {
    const Vec3 at = pick.place->position + i * step * pick.place->direction;
    if (auto found = surfaces_.map != nullptr ? label_of_surface(at) : label_of_look(at))
      return found;
  }
  return std::nullopt;
}

std::optional<Label> Picker::label_of_surface(const Vec3& at) const {
  const auto label = surfaces_.map->label_at(at);
  if (!label) return std::nullopt;
  const auto style =
      std::find_if(surfaces_.styles.begin(), surfaces_.styles.end(),
                   [&](const LabelStyle& one) { return one.label == *label && one.opacity > 0; });
  if (style == surfaces_.styles.end()) return std::nullopt;
  return Label{static_cast<double>(*label),
               style->name.empty() ? fmt::format("{}", *label) : style->name};
}

std::optional<Label> Picker::label_of_look(const Vec3& place) const {
  constexpr double kIsWhole = 1e-2;  // a label's inside, whose kernels leave that much of others
  if (labels_.empty()) return std::nullopt;
  const FieldSample at = probe_.at(place);
  if (!at.is_defined || std::abs(at.value - std::round(at.value)) > kIsWhole) return std::nullopt;
  const auto found = std::find_if(labels_.begin(), labels_.end(), [&](const Label& label) {
    return label.value == std::round(at.value);
  });
  return found == labels_.end() ? std::nullopt : std::optional(*found);
}

Json pick_json(const Picker& picker, const Pick& pick, const PickWords& words) {
  Json json;
  json["pixel"] = {pick.x, pick.y};
  json["shows"] = pick.place.has_value();
  json["opacity"] = pick.opacity;
  if (!pick.place) return json;
  const Pick::Place& place = *pick.place;
  json["depth"] = place.depth;
  json["position"] = to_json(place.position);
  if (place.index) json["index"] = to_json(*place.index);
  json["value"] = place.sample.is_defined ? Json(place.sample.value) : Json();
  json["gradient"] = place.sample.is_defined ? to_json(place.sample.gradient) : Json();
  if (!words.color_array.empty())
    json["color_value"] = place.sample.is_defined ? Json(place.sample.color_value) : Json();
  if (const auto label = picker.label(pick))
    json["label"] = {{"value", label->value}, {"name", label->name}};
  if (pick.integral) json["integral"] = *pick.integral;
  return json;
}

std::string pick_text(const Picker& picker, const Pick& pick, const PickWords& words) {
  const std::string pixel = fmt::format("pixel {},{}", pick.x, pick.y);
  if (!pick.place) return pixel + ": shows nothing\n";
  const Pick::Place& place = *pick.place;
  std::string text = pixel + '\n';
  const auto row = [&text](const std::string& name, const std::string& value) {
    text += fmt::format("  {:<11} {}\n", name, value);
  };
  const std::string space =
      words.space == Space::kNone ? "" : fmt::format(" ({})", name_of(words.space));
  row("position", with_unit(text_of_place(place.position), words.length_unit) + space);
  if (place.index) row("index", text_of_place(*place.index));
  if (place.sample.is_defined) {
    row(name_or(words.array, "value"), with_unit(text_of_number(place.sample.value), words.unit));
    if (!words.color_array.empty())
      row(words.color_array, text_of_number(place.sample.color_value));
    row("gradient", with_unit(text_of_place(place.sample.gradient), unit_of_slope(words)));
  } else {
    row(name_or(words.array, "value"), "not defined here");
  }
  if (const auto label = picker.label(pick)) row("label", label->name);
  if (pick.integral) row("integral", text_of_number(*pick.integral));
  row("depth", with_unit(text_of_number(place.depth), words.length_unit));
  row("opacity", text_of_number(pick.opacity));
  return text;
}

std::string picks_json(const Picker& picker, const std::vector<Pick>& picks, const PickWords& words,
                       const std::string& command) {
  Json json;
  json["picks"] = Json::array();
  for (const Pick& pick : picks) json["picks"].push_back(pick_json(picker, pick, words));
  json["array"] = words.array;
  json["unit"] = words.unit;
  if (!words.color_array.empty()) json["color_array"] = words.color_array;
  json["length_unit"] = words.length_unit;
  json["space"] = words.space == Space::kNone ? Json() : Json(name_of(words.space));
  json["command"] = command;
  // A command line and names of arrays may hold any bytes; JSON is UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace ovoid::cli
