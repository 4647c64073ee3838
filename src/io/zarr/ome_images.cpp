// SPDX-License-Identifier: Apache-2.0
#include "io/zarr/ome_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>

#include "io/core/axis_order.h"
#include "io/core/length_units.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::size_t kMostLevels = 1000;
constexpr std::string_view kAxesWithoutNames = "tczyx";  // of versions 0.1 and 0.2

// A path below the group: what a file names must not lead out of its folder.
std::string path_below(const JsonValue& value) {
  std::string path = value.string();
  std::size_t begin = 0;
  while (begin <= path.size()) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const std::string part = path.substr(begin, end - begin);
    const bool is_name =
        !part.empty() && part != "." && part != ".." && part.find('\0') == std::string::npos;
    if (!is_name) value.refuse("expected a path below its folder");
    begin = end + 1;
  }
  return path;
}

// Axes: objects with name, type and unit, or the names alone (0.3).
void read_axes(const JsonValue& multiscale, OmeImage& image) {
  if (!multiscale.has("axes")) {
    image.axes = kAxesWithoutNames;
    image.units.resize(image.axes.size());
    return;
  }
  const JsonValue axes = multiscale.member("axes");
  if (axes.array().size() < 2 || axes.size() > 5) axes.refuse("expected 2 to 5 axes");
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const JsonValue axis = axes.element(i);
    const bool is_name = axis.json().is_string();
    const std::string name = is_name ? axis.string() : axis.member("name").string();
    const auto has_text = [&](const char* key) {
      return !is_name && axis.has(key) && axis.json()[key].is_string();
    };
    const std::string type = has_text("type") ? axis.member("type").string() : "";
    const std::optional<char> letter = type == "time"      ? std::optional('t')
                                       : type == "channel" ? std::optional('c')
                                                           : axis_called(name);
    if (!letter || axis_place(image.axes, *letter))
      axis.refuse("expected time, channels, z, y and x, each once");
    image.axes += *letter;
    image.units.push_back(has_text("unit") ? axis.member("unit").string() : "");
  }
  if (!axis_place(image.axes, 'y') || !axis_place(image.axes, 'x'))
    axes.refuse("expected y and x among the axes");
}

std::vector<double> numbers_of(const JsonValue& list, std::size_t count) {
  list.array_of(count);
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.push_back(list.element(i).number());
  return numbers;
}

// Scales and translations, in their order.
void apply_transformations(const JsonValue& holder, OmeLevel& level) {
  if (!holder.has("coordinateTransformations")) return;
  const JsonValue list = holder.member("coordinateTransformations");
  list.array();
  const std::size_t rank = level.scale.size();
  for (std::size_t i = 0; i < list.size(); ++i) {
    const JsonValue transformation = list.element(i);
    const std::string type = transformation.member("type").string();
    if (type == "identity") continue;
    if (type != "scale" && type != "translation")
      transformation.refuse("expected scale or translation");
    const std::vector<double> numbers = numbers_of(transformation.member(type), rank);
    for (std::size_t a = 0; a < rank; ++a) {
      if (type == "scale") level.scale[a] *= numbers[a];
      level.translation[a] =
          type == "scale" ? level.translation[a] * numbers[a] : level.translation[a] + numbers[a];
    }
  }
}

OmeImage read_image(const JsonValue& multiscale) {
  OmeImage image;
  read_axes(multiscale, image);
  const JsonValue levels = multiscale.member("datasets");
  if (levels.array().size() < 1 || levels.size() > kMostLevels)
    levels.refuse("expected at least one array");
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const JsonValue described = levels.element(i);
    OmeLevel level{path_below(described.member("path")),
                   std::vector<double>(image.axes.size(), 1.0),
                   std::vector<double>(image.axes.size(), 0.0)};
    apply_transformations(described, level);
    apply_transformations(multiscale, level);
    image.levels.push_back(std::move(level));
  }
  return image;
}

// A member of an object; null if there is none.
Json member_of(const Json& object, const char* key) {
  if (!object.is_object()) return {};
  const auto found = object.find(key);
  return found == object.end() ? Json() : *found;
}

// Six hexadecimal digits, perhaps behind "#".
std::optional<std::array<double, 3>> color_in(const Json& value) {
  if (!value.is_string()) return std::nullopt;
  std::string_view digits = value.get_ref<const std::string&>();
  if (digits.starts_with('#')) digits.remove_prefix(1);
  std::uint32_t bits = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), bits, 16);
  if (digits.size() != 6 || error != std::errc() || end != digits.data() + digits.size())
    return std::nullopt;
  return channel_color({static_cast<std::uint8_t>(bits >> 16), static_cast<std::uint8_t>(bits >> 8),
                        static_cast<std::uint8_t>(bits)});
}

std::optional<std::array<double, 2>> range_in(const Json& window) {
  const Json first = member_of(window, "start"), last = member_of(window, "end");
  if (!first.is_number() || !last.is_number()) return std::nullopt;
  const std::array range{first.get<double>(), last.get<double>()};
  if (!std::isfinite(range[0]) || !std::isfinite(range[1]) || !(range[0] < range[1]))
    return std::nullopt;
  return range;
}

// What `omero` says, as viewers show it; what is odd there is passed over.
std::vector<Channel> channels_in(const Json& attributes) {
  std::vector<Channel> channels;
  const Json described = member_of(member_of(attributes, "omero"), "channels");
  if (!described.is_array()) return channels;
  for (const Json& one : described) {
    const Json label = member_of(one, "label");
    channels.push_back({label.is_string() ? label.get<std::string>() : "",
                        {color_in(member_of(one, "color")), range_in(member_of(one, "window"))}});
  }
  return channels;
}

}  // namespace

std::vector<OmeImage> ome_images(const ZarrNode& group) {
  // Version 0.5 has all of it in a member of its own.
  const bool is_inner = group.attributes.contains("ome") && group.attributes["ome"].is_object();
  const Json& attributes = is_inner ? group.attributes["ome"] : group.attributes;
  if (!attributes.contains("multiscales")) return {};
  const JsonValue root(attributes, group.attributes_where);
  const JsonValue multiscales = root.member("multiscales");
  std::vector<OmeImage> images;
  for (std::size_t i = 0; i < multiscales.array().size() && i < kMostLevels; ++i) {
    images.push_back(read_image(multiscales.element(i)));
    images.back().channels = channels_in(attributes);
  }
  return images;
}

}  // namespace ovoid::io
