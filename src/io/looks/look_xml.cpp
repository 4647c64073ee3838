// SPDX-License-Identifier: Apache-2.0
// Looks in XML, told apart by their tags: ParaView's old colour maps (<ColorMap>), Inviwo's
// transfer functions (<Points> of <Point> with <pos> and <rgba>), 3D Slicer's presets
// (<VolumeProperty>).
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <span>

#include "io/core/xml_tags.h"
#include "io/looks/look_readers.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr double kLargest = std::numeric_limits<double>::infinity();

// The five entities that XML itself has.
std::string unescaped(std::string text) {
  constexpr std::pair<const char*, char> kEntities[] = {
      {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&amp;", '&'}};
  for (const auto& [entity, c] : kEntities) {
    const std::size_t size = std::string_view(entity).size();
    for (auto at = text.find(entity); at != std::string::npos; at = text.find(entity, at + 1)) {
      text.replace(at, size, 1, c);
    }
  }
  return text;
}

// A file, tag by tag, and where it is for messages.
class Tags {
 public:
  explicit Tags(const LookFile& file)
      : path_(file.path),
        source_(open_memory(file.path, std::as_bytes(std::span(file.text)))),
        reader_(*source_) {}

  // Goes to the next tag; false at the end.
  bool next() {
    tag_ = reader_.next();
    return tag_.has_value();
  }
  const XmlTag& tag() const { return *tag_; }
  bool is(const char* name) const { return tag_->name == name; }
  bool has(const char* key) const { return tag_->attributes.count(key) > 0; }

  std::string place(const char* key) const {
    return fmt::format("{}: {} of <{}> at byte {}", path_, key, shown(tag_->name), tag_->begin);
  }
  double number(const char* key, double lo = -kLargest, double hi = kLargest) const {
    if (!has(key)) {
      throw Error(ErrorCode::kFileFormat, place(key) + ": is missing, must be a number");
    }
    return number_in(tag_->attribute(key), lo, hi, place(key));
  }
  double unit(const char* key) const { return number(key, 0.0, 1.0); }
  Rgb rgb(const char* r, const char* g, const char* b) const { return {unit(r), unit(g), unit(b)}; }

 private:
  static std::string shown(const std::string& name) { return printable(name); }

  std::string path_;
  std::unique_ptr<ByteSource> source_;
  XmlTagReader reader_;
  std::optional<XmlTag> tag_;
};

// The points behind a <ColorMap> tag, up to its end.
Look read_color_map(Tags& tags) {
  Look look;
  TransferFunction& tf = look.transfer_function;
  tf.name = unescaped(tags.tag().attribute("name"));
  const std::string space = tags.tag().attribute("space", "RGB");
  const std::string color_map_place = tags.place("space");
  tf.color_space = color_space_called(space, color_map_place);
  const bool is_categorical = tags.has("indexedLookup") && tags.number("indexedLookup") != 0.0;
  const bool is_empty = tags.tag().is_empty_element;
  while (!is_empty && tags.next() && !tags.is("/ColorMap")) {
    if (tags.is("Point")) {
      const double x = tags.number("x");
      tf.colors.push_back({x, tags.rgb("r", "g", "b")});
      if (tags.has("o")) tf.opacities.push_back({.x = x, .opacity = tags.unit("o")});
    } else if (tags.is("NaN")) {
      tf.nan_color = tags.rgb("r", "g", "b");
    }
  }
  // Maps of colours alone carry o = 1.
  const bool is_opaque = std::all_of(tf.opacities.begin(), tf.opacities.end(),
                                     [](const OpacityPoint& p) { return p.opacity == 1.0; });
  if (is_opaque) tf.opacities.clear();
  tf.sort();
  if (is_categorical && !tf.colors.empty()) {
    std::vector<double> values;
    std::vector<Rgb> colors;
    for (const ColorPoint& p : tf.colors) {
      values.push_back(p.x);
      colors.push_back(p.rgb);
    }
    const TransferFunction steps = categorical(values, colors);
    tf.colors = steps.colors;
    tf.color_space = steps.color_space;
  } else if (space == kCiede2000) {
    follow_ciede2000_of(tf, color_map_place);
  }
  return look;
}

// The attributes of a <VolumeProperty> tag.
Look read_volume_property(const Tags& tags) {
  Look look;
  TransferFunction& tf = look.transfer_function;
  const auto line = [&](const char* key) { return tags.tag().attribute(key); };
  tf.name = unescaped(line("name"));
  if (tags.has("scalarOpacity")) {
    take_slicer_opacities(tf, line("scalarOpacity"), tags.place("scalarOpacity"));
  }
  if (tags.has("gradientOpacity")) {
    take_slicer_gradients(tf, line("gradientOpacity"), tags.place("gradientOpacity"));
  }
  if (tags.has("colorTransfer")) {
    take_slicer_colors(tf, line("colorTransfer"), tags.place("colorTransfer"));
  }
  if (tags.has("shade")) look.shade = tags.number("shade") != 0.0;
  if (tags.has("ambient")) look.material.ambient = tags.number("ambient", 0.0);
  if (tags.has("diffuse")) look.material.diffuse = tags.number("diffuse", 0.0);
  if (tags.has("specular")) look.material.specular = tags.number("specular", 0.0);
  if (tags.has("specularPower")) look.material.specular_power = tags.number("specularPower", 0.0);
  return look;
}

// The points behind a <Points> tag: positions in [0, 1] of the data's range, color and opacity.
Look read_inviwo_points(Tags& tags) {
  Look look;
  TransferFunction& tf = look.transfer_function;
  double position = 0.0;
  bool has_position = false;
  while (tags.next() && !tags.is("/Points")) {
    if (tags.is("Point")) has_position = false;
    if (tags.is("pos")) {
      position = tags.number(tags.has("content") ? "content" : "x");
      has_position = true;
    }
    if (!tags.is("rgba")) continue;
    if (!has_position) {
      throw Error(ErrorCode::kFileFormat, tags.place("color") + ": stands before its <pos>");
    }
    tf.colors.push_back({position, tags.rgb("x", "y", "z")});
    tf.opacities.push_back({.x = position, .opacity = tags.unit("w")});
  }
  return look;
}

}  // namespace

Look read_xml_look(const LookFile& file) {
  Tags tags(file);
  std::vector<std::string> names;
  std::string root;
  while (tags.next()) {
    if (root.empty()) root = printable(tags.tag().name);
    Look look;
    if (tags.is("ColorMap")) {
      look = read_color_map(tags);
    } else if (tags.is("VolumeProperty")) {
      look = read_volume_property(tags);
    } else if (tags.is("Points") && root == "InviwoWorkspace") {
      look = read_inviwo_points(tags);
    } else {
      continue;
    }
    const std::string& name = look.transfer_function.name;
    if (file.wanted.empty() || name == file.wanted) return look;
    if (!name.empty()) names.push_back(name);
  }
  if (!names.empty() || !file.wanted.empty()) refuse_name(file, names);
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: looks like XML with the root <{}>, {}",
                                                  file.path, root, kExpectedLook));
}

}  // namespace ovoid::io
