// SPDX-License-Identifier: Apache-2.0
// 3D Slicer's volume properties: as JSON by its schema volume-property 1.0.0, and the numbers of
// its older lines (.vp, MRML); docs/looks.md, "Files".
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "io/core/text_file.h"
#include "io/core/text_scanner.h"
#include "io/looks/look_readers.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

[[noreturn]] void refuse_line(const std::string& place, const std::string& what) {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", place, what));
}

// "COUNT n n n ...": the COUNT numbers behind the first, a multiple of `group`.
std::vector<double> counted_numbers(std::string_view line, std::size_t group,
                                    const std::string& place) {
  const std::vector<std::string_view> parts = words(line);
  const auto count = parts.empty() ? std::nullopt : parse_integer(parts.front());
  if (!count || *count < 0 || static_cast<std::size_t>(*count) != parts.size() - 1) {
    refuse_line(place, fmt::format("must begin with the count of the {} numbers that follow",
                                   parts.empty() ? 0 : parts.size() - 1));
  }
  if (static_cast<std::size_t>(*count) % group != 0) {
    refuse_line(place, fmt::format("has {} numbers: must be {} per point", *count, group));
  }
  std::vector<double> numbers;
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const bool is_value = (i - 1) % group == 0;
    numbers.push_back(
        number_in(parts[i], is_value ? -kInfinity : 0.0, is_value ? kInfinity : 1.0, place));
  }
  return numbers;
}

std::vector<OpacityPoint> counted_points(std::string_view line, const std::string& place) {
  const std::vector<double> numbers = counted_numbers(line, 2, place);
  std::vector<OpacityPoint> points;
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    points.push_back({.x = numbers[i], .opacity = numbers[i + 1]});
  }
  return points;
}

// A factor of 1 throughout, which Slicer writes for "no gradient opacity", is none; gradients have
// lengths >= 0, and what lies below 0 says nothing but where the curve starts.
std::vector<OpacityPoint> effective(std::vector<OpacityPoint> gradients) {
  const bool is_one = std::all_of(gradients.begin(), gradients.end(),
                                  [](const OpacityPoint& p) { return p.opacity == 1.0; });
  if (is_one) return {};
  for (OpacityPoint& point : gradients) point.x = std::max(point.x, 0.0);
  return gradients;
}

double in_unit(const JsonValue& value) {
  const double number = value.number();
  if (!(number >= 0.0 && number <= 1.0)) value.refuse("must be in [0, 1]");
  return number;
}

// The shape of the piece behind a point, which either curve may have.
OpacityPoint shape_of(const JsonValue& point) {
  OpacityPoint shape{.x = point.member("x").number()};
  if (point.has("midpoint")) shape.midpoint = in_unit(point.member("midpoint"));
  if (point.has("sharpness")) shape.sharpness = in_unit(point.member("sharpness"));
  return shape;
}

std::vector<OpacityPoint> piecewise(const JsonValue& function) {
  const JsonValue list = function.member("points").array();
  std::vector<OpacityPoint> points;
  for (std::size_t i = 0; i < list.size(); ++i) {
    points.push_back(shape_of(list.element(i)));
    points.back().opacity = in_unit(list.element(i).member("y"));
  }
  return points;
}

// Our colour points have no midpoint and sharpness: a piece that bends becomes kBendSteps straight
// ones, half of them on either side of the midpoint. A midpoint alone is exact so; the steepest
// curves (sharpness 0.9) are followed to 0.0025 of the change; a step becomes two points of one
// value.
constexpr int kBendSteps = 128;
constexpr std::size_t kMaxBends = 256;

void add_bent(std::vector<ColorPoint>& colors, const ColorPoint& right, const OpacityPoint& shape) {
  const ColorPoint left = colors.back();
  TransferFunction bend;
  bend.opacities = {{0.0, 0.0, shape.midpoint, shape.sharpness}, {1.0, 1.0}};
  const auto at = [&](double s, double weight) {
    ColorPoint point{std::lerp(left.x, right.x, s), {}};
    for (std::size_t c = 0; c < 3; ++c) {
      point.rgb[c] = std::clamp(std::lerp(left.rgb[c], right.rgb[c], weight), 0.0, 1.0);
    }
    return point;
  };
  if (shape.sharpness > 0.99) {
    colors.push_back(at(shape.midpoint, 0.0));
    colors.push_back(at(shape.midpoint, 1.0));
    return;
  }
  for (int i = 1; i < kBendSteps; ++i) {
    const double t = 2.0 * i / kBendSteps - 1.0;
    const double s = shape.midpoint + t * (t < 0.0 ? shape.midpoint : 1.0 - shape.midpoint);
    colors.push_back(at(s, bend.opacity_at(s)));
  }
}

bool is_bent(const OpacityPoint& shape) { return shape.midpoint != 0.5 || shape.sharpness >= 0.01; }

std::vector<ColorPoint> color_points(const JsonValue& function) {
  const JsonValue list = function.member("points").array();
  std::vector<ColorPoint> colors;
  OpacityPoint shape;
  std::size_t num_bends = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const JsonValue point = list.element(i);
    const JsonValue rgb = point.member("color").array_of(3);
    const ColorPoint color{
        point.member("x").number(),
        {in_unit(rgb.element(0)), in_unit(rgb.element(1)), in_unit(rgb.element(2))}};
    if (i > 0 && is_bent(shape) && colors.back().x < color.x) {
      if (++num_bends > kMaxBends) {
        list.refuse(
            fmt::format("must have at most {} points with a midpoint or sharpness", kMaxBends));
      }
      add_bent(colors, color, shape);
    }
    colors.push_back(color);
    shape = shape_of(point);
  }
  return colors;
}

std::vector<ColorPoint> grays(const JsonValue& function) {
  std::vector<ColorPoint> colors;
  for (const OpacityPoint& p : piecewise(function)) {
    colors.push_back({p.x, {p.opacity, p.opacity, p.opacity}});
  }
  return colors;
}

void take_lighting(Material& material, const JsonValue& lighting) {
  for (const auto& [key, into] :
       {std::pair{"ambient", &material.ambient}, std::pair{"diffuse", &material.diffuse},
        std::pair{"specular", &material.specular},
        std::pair{"specularPower", &material.specular_power}}) {
    if (!lighting.has(key)) continue;
    const JsonValue value = lighting.member(key);
    if (!(value.number() >= 0.0)) value.refuse("must be >= 0");
    *into = value.number();
  }
}

}  // namespace

double number_in(std::string_view text, double lo, double hi, const std::string& place) {
  const std::string shown = printable(text);
  const auto number = parse_real(text);
  if (!number) refuse_line(place, fmt::format("'{}': must be a number", shown));
  if (!(*number >= lo && *number <= hi)) {
    refuse_line(place, hi < kInfinity ? fmt::format("{}: must be in [{}, {}]", shown, lo, hi)
                                      : fmt::format("{}: must be >= {}", shown, lo));
  }
  return *number;
}

void take_slicer_opacities(TransferFunction& tf, std::string_view line, const std::string& place) {
  tf.opacities = counted_points(line, place);
}

void take_slicer_gradients(TransferFunction& tf, std::string_view line, const std::string& place) {
  tf.gradient_opacities = effective(counted_points(line, place));
}

void take_slicer_colors(TransferFunction& tf, std::string_view line, const std::string& place) {
  const std::vector<double> numbers = counted_numbers(line, 4, place);
  for (std::size_t i = 0; i < numbers.size(); i += 4) {
    tf.colors.push_back({numbers[i], {numbers[i + 1], numbers[i + 2], numbers[i + 3]}});
  }
}

Look read_slicer_json(const LookFile& file, const Json& json) {
  if (!file.wanted.empty()) refuse_name(file, {});
  const JsonValue list = JsonValue(json, file.path + ": ").member("volumeProperties").array();
  if (list.size() == 0) list.refuse("must hold at least one volume property");
  const JsonValue components = list.element(0).member("components").array();
  if (components.size() == 0) components.refuse("must hold at least one component");
  const JsonValue component = components.element(0).object();

  Look look;
  TransferFunction& tf = look.transfer_function;
  if (component.has("rgbTransferFunction")) {
    tf.colors = color_points(component.member("rgbTransferFunction"));
  } else if (component.has("grayTransferFunction")) {
    tf.colors = grays(component.member("grayTransferFunction"));
  }
  if (component.has("scalarOpacity")) {
    tf.opacities = piecewise(component.member("scalarOpacity"));
  }
  const bool has_gradients =
      component.has("gradientOpacity") && !(component.has("disableGradientOpacity") &&
                                            component.member("disableGradientOpacity").boolean());
  if (has_gradients) {
    tf.gradient_opacities = effective(piecewise(component.member("gradientOpacity")));
  }
  if (component.has("scalarOpacityUnitDistance")) {
    const double unit = component.member("scalarOpacityUnitDistance").number();
    if (unit > 0.0) tf.unit_distance = unit;  // 0: not set
  }
  if (component.has("shade")) look.shade = component.member("shade").boolean();
  if (component.has("lighting")) take_lighting(look.material, component.member("lighting"));
  return look;
}

}  // namespace ovoid::io
