// SPDX-License-Identifier: Apache-2.0
#include "ovoid/look.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "data/validate.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

[[noreturn]] void refuse(const std::string& member, double value, const char* expected) {
  throw Error(ErrorCode::kInvalidArgument, fmt::format("{} = {}: {}", member, value, expected));
}

void require_finite(const std::string& member, double value) {
  if (!std::isfinite(value)) refuse(member, value, "must be finite");
}

void require_unit(const std::string& member, double value) {
  if (!(value >= 0.0 && value <= 1.0)) refuse(member, value, "must be in [0, 1]");
}

void require_color(const std::string& member, const Rgb& rgb) {
  for (int c = 0; c < 3; ++c) require_unit(fmt::format("{}[{}]", member, c), rgb[c]);
}

void require_strength(const char* member, double value) {
  if (!(value >= 0.0) || !std::isfinite(value)) refuse(member, value, "must be finite and >= 0");
}

void require_isosurfaces(const std::vector<Isosurface>& surfaces) {
  if (surfaces.size() > Look::kMaxIsosurfaces) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("isosurfaces: {}, must be at most {}",
                                                         surfaces.size(), Look::kMaxIsosurfaces));
  }
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const std::string member = fmt::format("isosurfaces[{}]", i);
    require_finite(member + ".value", surfaces[i].value);
    require_unit(member + ".opacity", surfaces[i].opacity);
    if (surfaces[i].color) require_color(member + ".color", *surfaces[i].color);
    for (std::size_t j = 0; j < i; ++j) {
      if (surfaces[j].value == surfaces[i].value)
        refuse(member + ".value", surfaces[i].value, "must differ from the others'");
    }
  }
}

template <class Points>
void require_sorted(const char* member, const Points& points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::string x = fmt::format("{}[{}].x", member, i);
    require_finite(x, points[i].x);
    if (i > 0 && points[i].x < points[i - 1].x)
      refuse(x, points[i].x, "must not be less than the x before it");
  }
}

void require_opacities(const char* member, const std::vector<OpacityPoint>& points) {
  require_sorted(member, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const OpacityPoint& point = points[i];
    require_unit(fmt::format("{}[{}].opacity", member, i), point.opacity);
    require_unit(fmt::format("{}[{}].midpoint", member, i), point.midpoint);
    require_unit(fmt::format("{}[{}].sharpness", member, i), point.sharpness);
  }
}

// Points are sorted: the first is the least.
template <class Points>
void require_first_x(const char* member, const Points& points, bool is_valid,
                     const char* expected) {
  if (!is_valid) refuse(fmt::format("{}[0].x", member), points.front().x, expected);
}

template <class Points>
void require_logarithms(const char* member, const Points& points) {
  require_first_x(member, points, points.empty() || points.front().x > 0.0,
                  "must be > 0 on a logarithmic scale");
}

void validate(const TransferFunction& tf) {
  require_sorted("colors", tf.colors);
  for (std::size_t i = 0; i < tf.colors.size(); ++i) {
    require_color(fmt::format("colors[{}].rgb", i), tf.colors[i].rgb);
  }
  require_opacities("opacities", tf.opacities);
  require_color("nan_color", tf.nan_color);
  if (tf.below_color) require_color("below_color", *tf.below_color);
  if (tf.above_color) require_color("above_color", *tf.above_color);
  require_finite("transfer function span", tf.hi() - tf.lo());
  if (tf.scale == ValueScale::kLog) {
    require_logarithms("colors", tf.colors);
    require_logarithms("opacities", tf.opacities);
  }
  if (!(tf.linear_width > 0.0) || !std::isfinite(tf.linear_width)) {
    refuse("linear_width", tf.linear_width, "must be finite and > 0");
  }
  const auto& gradients = tf.gradient_opacities;
  require_opacities("gradient_opacities", gradients);
  require_first_x("gradient_opacities", gradients, gradients.empty() || gradients.front().x >= 0.0,
                  "must be >= 0");
  if (tf.unit_distance && (!(*tf.unit_distance > 0.0) || !std::isfinite(*tf.unit_distance))) {
    refuse("transfer function unit_distance", *tf.unit_distance, "must be finite and > 0");
  }
}

void validate_lights(const std::vector<FurtherLight>& lights) {
  constexpr double kGreatestIntensity = 10;
  if (lights.size() > Look::kMaxFurtherLights) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("further_lights: {} given, at most {} are possible", lights.size(),
                            Look::kMaxFurtherLights));
  }
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const Vec3& towards = lights[i].direction;
    if (!(towards.allFinite() && towards.norm() > 0.0 && std::isfinite(towards.norm()))) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("further_lights[{}].direction = ({}, {}, {}): must be finite and not "
                              "zero",
                              i, towards.x(), towards.y(), towards.z()));
    }
    const double intensity = lights[i].intensity;
    if (!(intensity >= 0.0 && intensity <= kGreatestIntensity)) {
      refuse(fmt::format("further_lights[{}].intensity", i), intensity, "must be in [0, 10]");
    }
  }
}

}  // namespace

void Look::validate() const {
  ovoid::validate(transfer_function);
  if (color_function) ovoid::validate(*color_function);
  if (transfer_function_2d && !transfer_function.gradient_opacities.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                "gradient_opacities: have no effect beside a 2-D transfer function, which gives "
                "opacities by gradient itself; must be empty");
  }
  require_finite("isovalue", isovalue);
  require_isosurfaces(isosurfaces);
  require_strength("ambient", material.ambient);
  require_strength("diffuse", material.diffuse);
  require_strength("specular", material.specular);
  if (!(material.specular_power > 0.0) || !std::isfinite(material.specular_power)) {
    refuse("specular_power", material.specular_power, "must be finite and > 0");
  }
  if (!(flat_rise >= 0.0 && flat_rise <= 1.0)) refuse("flat_rise", flat_rise, "must be in [0, 1]");
  require_unit("occlusion", occlusion);
  require_unit("shadows", shadows);
  require_unit("scatter", scatter);
  if (light_direction && !(light_direction->allFinite() && light_direction->norm() > 0.0 &&
                           std::isfinite(light_direction->norm()))) {
    const Vec3& towards = *light_direction;
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("light_direction = ({}, {}, {}): must be finite and not zero",
                            towards.x(), towards.y(), towards.z()));
  }
  validate_lights(further_lights);
  if (!(unit_distance >= 0.0) || !std::isfinite(unit_distance)) {
    refuse("unit_distance", unit_distance, "must be finite and >= 0");
  }
}

double default_unit_distance(const Field& field) {
  data::require_field(field);
  return field.default_sampling_distance();
}

double unit_distance_of(const Look& look, const Field& field) {
  if (look.unit_distance > 0) return look.unit_distance;
  return look.transfer_function.unit_distance.value_or(default_unit_distance(field));
}

Look ramp_look(const ValueRange& range, const std::string& color_map_name) {
  double lo = range.lo;
  double hi = range.hi;
  if (range.is_empty()) {
    lo = 0.0;
    hi = 1.0;
  } else if (lo == hi) {
    // A constant field shows at half of the full opacity, in the middle of the map.
    const double half = std::max(0.5, 0.5 * std::abs(lo));
    lo -= half;
    hi += half;
  }
  Look look;
  look.transfer_function = color_map(color_map_name);
  look.transfer_function.map_range(lo, hi);
  look.transfer_function.opacities = {{lo, 0.0}, {hi, 0.5}};
  return look;
}

}  // namespace ovoid
