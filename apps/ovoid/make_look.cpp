// SPDX-License-Identifier: Apache-2.0
#include "make_look.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "ovoid/error.h"
#include "ovoid/io.h"
#include "setting_forms.h"
#include "values.h"

namespace ovoid::cli {
namespace {

bool is_lit(Mode mode) { return mode == Mode::kComposite || mode == Mode::kIsosurface; }

bool has_own_span(const LookFlags& flags) {
  return !flags.file.empty() || (!flags.preset.empty() && flags.preset != kCinematicPreset);
}

ValueScale scale_of(const LookFlags& flags, const TransferFunction& tf) {
  if (flags.is_log) return ValueScale::kLog;
  return flags.linear_width ? ValueScale::kSymlog : tf.scale;
}

double linear_width_of(const LookFlags& flags, const TransferFunction& tf) {
  return flags.linear_width.value_or(tf.linear_width);
}

// Over a span of values that may be a single one, then around it.
void spread_over(TransferFunction& tf, double lo, double hi, ValueScale scale,
                 double linear_width) {
  if (!(lo < hi) && scale == ValueScale::kLog) {
    std::tie(lo, hi) = std::pair(0.5 * lo, 2 * lo);
  } else if (!(lo < hi)) {
    const double half = std::max(0.5, 0.5 * std::abs(lo));
    std::tie(lo, hi) = std::pair(lo - half, lo + half);
  }
  tf.map_range(lo, hi, scale, linear_width);
}

void take_colors(TransferFunction& tf, const TransferFunction& from) {
  tf.colors = from.colors;
  tf.color_space = from.color_space;
  tf.nan_color = from.nan_color;
}

// What neither the file nor a flag says is the default look's, spread over the file's span.
void complete(TransferFunction& file, TransferFunction defaults, const LookFlags& flags,
              Session& session) {
  spread_over(defaults, file.lo(), file.hi(), file.scale, file.linear_width);
  if (file.opacities.empty() && flags.opacities.empty() && uses_opacity(flags.mode)) {
    session.note(source_of_flag("--tf", flags.file) +
                 ": has no opacities, drawn with a ramp over its span");
    file.opacities = defaults.opacities;
  }
  if (file.colors.empty() && flags.color_map.empty()) {
    session.note(source_of_flag("--tf", flags.file) +
                 ": has no colours, drawn with viridis over its span");
    take_colors(file, defaults);
  }
}

// Values that have little to do with the data's draw nothing, or one colour.
void note_disjoint_span(const TransferFunction& tf, const LookFlags& flags, const ValueRange& range,
                        Session& session) {
  if (range.is_empty() || (tf.hi() >= range.lo && tf.lo() <= range.hi)) return;
  session.note(fmt::format(
      "{} spans the values {:g} to {:g}, but the data's are {:g} to {:g}; --range moves it",
      flags.file.empty() ? "--preset" : "--tf", tf.lo(), tf.hi(), range.lo, range.hi));
}

// In the modes where one sample makes the pixel, its opacity is no longer a matter of thickness.
void make_opaque(TransferFunction& tf) {
  double greatest = 0;
  for (const OpacityPoint& point : tf.opacities) greatest = std::max(greatest, point.opacity);
  if (greatest == 0) return;
  for (OpacityPoint& point : tf.opacities) point.opacity /= greatest;
}

// A look can only see through noise; a wider kernel takes it away.
bool is_noisy(const Look& look, const Field& field) {
  constexpr double kMuch = 0.5;
  constexpr double kCrisp = 0.06;  // default_look() takes more from light for noise alone
  const LatticeField* const lattice = field.lattice();
  if (look.flat_rise <= kCrisp || lattice == nullptr ||
      lattice->kernel().kind == LatticeKernelKind::kGaussian)
    return false;
  return materials_of(field).noisiness > kMuch;
}

// Whether one value of each ray is shown, over a range that nobody named.
bool is_projection(const LookFlags& flags) {
  return (flags.mode == Mode::kMaximum || flags.mode == Mode::kMinimum ||
          flags.mode == Mode::kMean) &&
         !has_own_span(flags) && !flags.range;
}

// The look that the other flags change.
Look base_look(const LookFlags& flags, const Field& field, const std::string& unit,
               Session& session, const UsualLook& usual) {
  const ValueRange range = field.value_range();
  Look look = uses_default_look(flags) ? usual.of(field, unit).look
              : is_projection(flags)   ? projection_look(field, flags.mode)
                                       : ramp_look(range);
  if (uses_default_look(flags) && usual.of(field, unit).is_noisy)
    session.note("the values are noisy: drawn soft (--kernel gaussian:1.5 smooths them)");
  if (flags.mode == Mode::kMaximum || flags.mode == Mode::kMean)
    make_opaque(look.transfer_function);
  // Of a ramp the least values would be the ones that do not show.
  if (flags.mode == Mode::kMinimum) look.transfer_function.opacities.clear();
  if (flags.preset == kCinematicPreset) {
    add_cinematic_light(look);
    look.transfer_function.name = flags.preset;
  } else if (!flags.preset.empty()) {
    look = look_preset(flags.preset, range);
    const std::string note =
        flags.range ? "" : place_hounsfield_units(look.transfer_function, field, unit);
    if (!note.empty())
      session.note(fmt::format("--preset {}: {}; --range or --shift moves it", flags.preset, note));
  }
  if (flags.preset != kCinematicPreset) look.occlusion = kUsualOcclusion;
  if (!flags.file.empty()) {
    Look file = look_of_flag("--tf", flags.file, flags.file_name);
    complete(file.transfer_function, look.transfer_function, flags, session);
    look = std::move(file);
  }
  if (has_own_span(flags) && !flags.range && flags.mode != Mode::kXray) {
    note_disjoint_span(look.transfer_function, flags, range, session);
  }
  return look;
}

// Moves the points onto the range and the scale that flags ask for. A file's or preset's values are
// absolute: without a range only the way between them changes.
void place(TransferFunction& tf, const LookFlags& flags, Session& session) {
  const ValueScale scale = scale_of(flags, tf);
  const double linear_width = linear_width_of(flags, tf);
  if (!flags.range && !flags.is_log && !flags.linear_width) return;
  if (has_own_span(flags) && !flags.range) {
    if (scale == ValueScale::kLog && !(tf.lo() > 0)) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("--log: {} begins at the value {:g}, expected values > 0 (--range "
                              "LO,HI spreads it over others)",
                              flags.file.empty() ? flags.preset : flags.file, tf.lo()));
    }
    tf.scale = scale;
    tf.linear_width = linear_width;
    return;
  }
  auto [lo, hi] = flags.range.value_or(std::pair(tf.lo(), tf.hi()));
  if (scale == ValueScale::kLog) std::tie(lo, hi) = logarithmic_range(lo, hi, session);
  tf.map_range(lo, hi, scale, linear_width);
}

void shift(TransferFunction& tf, double by) {
  if (tf.scale == ValueScale::kLog && !(tf.lo() + by > 0)) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("--shift {:g}: the look begins at {:g}, and on a logarithm it must stay "
                    "above 0",
                    by, tf.lo()));
  }
  tf.map_range(tf.lo() + by, tf.hi() + by);
}

// The colours of flags, by name over the look's span, or as a list: from 0 to 1 it is spread as a
// map is, else its values are absolute, but for --range.
void take_flag_colors(TransferFunction& tf, const LookFlags& flags) {
  const bool is_list = is_list_of_colors(flags.color_map);
  const std::string name = flags.is_window && flags.color_map.empty() ? "gray" : flags.color_map;
  if (name.empty()) return;
  TransferFunction map = is_list ? TransferFunction() : color_map(name);
  if (is_list) map.colors = parse_colors(name);
  const bool is_absolute = is_list && !flags.range && !(map.lo() == 0 && map.hi() == 1);
  if (!is_absolute) spread_over(map, tf.lo(), tf.hi(), tf.scale, tf.linear_width);
  take_colors(tf, map);
}

void take_flag_light(Look& look, const LookFlags& flags, Session& session) {
  if (flags.shade || flags.no_shade) look.shade = flags.shade;
  Material& material = look.material;
  material.ambient = flags.ambient.value_or(material.ambient);
  material.diffuse = flags.diffuse.value_or(material.diffuse);
  material.specular = flags.specular.value_or(material.specular);
  material.specular_power = flags.specular_power.value_or(material.specular_power);
  look.light = flags.light;
  look.light_direction = flags.light_direction;
  if (flags.names_lights) look.further_lights = flags.further_lights;
  look.flat_rise = flags.flat_rise.value_or(look.flat_rise);
  look.occlusion = flags.occlusion.value_or(look.occlusion);
  if (flags.scattering_blending) look.shadows = *flags.scattering_blending / 2;
  look.shadows = flags.shadows.value_or(look.shadows);
  look.scatter = flags.scatter.value_or(look.scatter);
  // What is not lit has the colours as they are, unless somebody asks for less.
  if (!look.shade && (flags.file.empty() || flags.no_shade)) {
    look.occlusion = flags.occlusion.value_or(0);
    if (!flags.shadows && !flags.scattering_blending) look.shadows = 0;
  }
  const bool has_light = flags.ambient || flags.diffuse || flags.specular || flags.specular_power ||
                         flags.light != Light::kStudio || flags.light_direction ||
                         !flags.further_lights.empty() || flags.flat_rise;
  if (has_light && !look.shade && look.shadows == 0 && is_lit(flags.mode)) {
    session.note((flags.file.empty() ? std::string("the default look of clouds")
                                     : source_of_flag("--tf", flags.file)) +
                 ": is not lit, so that light and material show nothing; --shade");
  }
}

// Reads the 2-D transfer function of --tf2d, and refuses flags that have no effect beside one.
void take_2d(Look& look, const LookFlags& flags, Session& session) {
  if (!flags.file_2d.empty()) {
    if (is_json(flags.file_2d) && flags.range_2d)
      throw Error(ErrorCode::kInvalidArgument, "--tf2d-range: is for pictures, not for JSON");
    look.transfer_function_2d = is_json(flags.file_2d)
                                    ? transfer_function_2d_from_text(flags.file_2d, "--tf2d")
                                    : read_transfer_function_2d(flags.file_2d, flags.range_2d);
    look.transfer_function.gradient_opacities.clear();
    if (!flags.file.empty() && (look.occlusion > 0 || look.shadows > 0))
      session.note(
          "--tf2d: drawn without the look's occlusion and shadows, which know no gradients");
    // By flags they are asked for, and refused where the picture is drawn.
    if (!flags.occlusion) look.occlusion = 0;
    if (!flags.shadows && !flags.scattering_blending) look.shadows = 0;
  }
  if (!look.transfer_function_2d) return;
  const std::pair<const char*, bool> kOfOneDimension[] = {
      {"--preset", !flags.preset.empty()},
      {"--colormap", !flags.color_map.empty()},
      {"--opacity", !flags.opacities.empty()},
      {"--gradient-opacity", !flags.gradient_opacities.empty()},
      {flags.is_window ? "--window" : "--range", flags.range.has_value()},
      {"--shift", flags.shift != 0},
      {"--log", flags.is_log},
      {"--symlog", flags.linear_width.has_value()},
      {"--below-color", flags.below_color.has_value()},
      {"--above-color", flags.above_color.has_value()}};
  for (const auto& [flag, is_given] : kOfOneDimension) {
    if (!is_given) continue;
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: has no effect beside a 2-D transfer function ({}), which gives "
                            "colour and opacity; leave one of them out",
                            flag, flags.file_2d.empty() ? "of --tf" : "--tf2d"));
  }
}

// The look where one array gives all.
Look look_of_one(const LookFlags& flags, const Field& field, const std::string& unit,
                 Session& session, const UsualLook& usual) {
  Look look = base_look(flags, field, unit, session, usual);
  TransferFunction& tf = look.transfer_function;
  place(tf, flags, session);
  take_flag_colors(tf, flags);
  if (flags.shift != 0) shift(tf, flags.shift);
  if (!flags.opacities.empty()) {
    tf.opacities = flags.opacities;
    // The default look may have found a logarithm fitting, which these values have none of.
    const bool is_asked_for = flags.is_log || has_own_span(flags);
    if (tf.scale == ValueScale::kLog && !is_asked_for && !(flags.opacities.front().x > 0)) {
      tf.scale = ValueScale::kLinear;
      session.note(
          fmt::format("--opacity begins at {:g}: drawn on a linear scale, the default "
                      "look's would be logarithmic",
                      flags.opacities.front().x));
    }
  }
  if (!flags.gradient_opacities.empty()) tf.gradient_opacities = flags.gradient_opacities;
  if (flags.below_color) tf.below_color = flags.below_color;
  if (flags.above_color) tf.above_color = flags.above_color;
  take_flag_light(look, flags, session);
  look.mode = flags.mode;
  // One that is like any other needs no list.
  const std::vector<Isosurface>& surfaces = flags.isosurfaces;
  look.isovalue = surfaces.empty() ? 0 : surfaces.front().value;
  const bool is_plain =
      surfaces.size() < 2 && (surfaces.empty() || (!surfaces[0].color && surfaces[0].opacity == 1));
  look.isosurfaces = is_plain ? std::vector<Isosurface>() : surfaces;
  if (flags.unit_distance) look.unit_distance = *flags.unit_distance;
  take_2d(look, flags, session);
  return look;
}

// The flags without what is about colour, which includes where on the axis of values it lies.
LookFlags without_colors(LookFlags flags) {
  flags.color_map.clear();
  flags.range.reset();
  flags.is_window = flags.is_log = false;
  flags.linear_width.reset();
  flags.below_color.reset();
  flags.above_color.reset();
  return flags;
}

// The look where colour comes from an array of its own: every flag about colour, and --range and
// the scales with them, is about that array's values, all the rest about the other's.
Look look_of_two(const LookFlags& flags, const Field& field, const std::string& unit,
                 Session& session, const UsualLook& usual) {
  const bool has_file = !flags.color_file.empty();
  Look look = look_of_one(has_file ? flags : without_colors(flags), field, unit, session, usual);
  if (has_file) {
    look.color_function = look_of_flag("--color-tf", flags.color_file, {}).transfer_function;
    return look;
  }
  TransferFunction colors =
      look.color_function.value_or(ramp_look(field.color_range()).transfer_function);
  if (has_own_span(flags) && flags.file.empty())
    colors = look_preset(flags.preset, field.color_range()).transfer_function;
  if (!flags.file.empty()) {
    TransferFunction file = look_of_flag("--tf", flags.file, flags.file_name).transfer_function;
    if (!file.colors.empty()) colors = std::move(file);
  }
  place(colors, flags, session);
  take_flag_colors(colors, flags);
  if (flags.below_color) colors.below_color = flags.below_color;
  if (flags.above_color) colors.above_color = flags.above_color;
  look.color_function = std::move(colors);
  return look;
}

}  // namespace

// Who names a range wants it spread evenly, and along a logarithm layers would lie elsewhere; the
// other modes have no layers to tell apart.
bool uses_default_look(const LookFlags& flags) {
  return !has_own_span(flags) && !flags.range && !flags.is_log && !flags.linear_width &&
         flags.mode == Mode::kComposite;
}

bool may_be_labels(const LookFlags& flags) {
  return uses_default_look(flags) || flags.preset == "label";
}

std::pair<double, double> logarithmic_range(double lo, double hi, Session& session) {
  constexpr double kDecades = 1e-3;
  if (lo > 0) return {lo, hi};
  if (!(hi > 0)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("--log: the values end at {:g}, expected some > 0 (--symlog W takes "
                            "any)",
                            hi));
  }
  session.note(fmt::format("--log: colours span {:g} to {:g}, three decades; --range sets others",
                           hi * kDecades, hi));
  return {hi * kDecades, hi};
}

std::string place_hounsfield_units(TransferFunction& tf, const Field& field,
                                   const std::string& unit) {
  constexpr double kAir = -1000;
  constexpr double kBone = 1200;
  if (!tf.name.starts_with("ct-")) return "";
  const auto water = value_of_water(field, unit);
  if (water == 0.0) return "";
  if (water) {
    tf.map_range(tf.lo() + *water, tf.hi() + *water);
    return fmt::format("the values look like a scanner's own numbers, {:g} above Hounsfield units",
                       *water);
  }
  const auto ends = air_and_bone(field);
  if (!ends) return "";
  const auto [air, bone] = *ends;
  const double scale = (bone - air) / (kBone - kAir);
  tf.map_range(air + (tf.lo() - kAir) * scale, air + (tf.hi() - kAir) * scale);
  return fmt::format(
      "the values do not look like Hounsfield units: its air is put at {:g}, its "
      "dense bone at {:g}",
      air, bone);
}

Look look_of_flag(const char* flag, const std::string& value, const std::string& name) {
  return is_json(value) ? look_from_text(value, flag, name) : read_look(value, name);
}

std::string source_of_flag(const char* flag, const std::string& value) {
  return is_json(value) ? flag : value;
}

bool uses_opacity(Mode mode) { return mode != Mode::kXray && mode != Mode::kIsosurface; }

const UsualLook::Found& UsualLook::of(const Field& field, const std::string& unit) const {
  if (!found_) {
    Look look = default_look(field, unit);
    const bool noisy = is_noisy(look, field);
    found_ = Found{std::move(look), noisy};
  }
  return *found_;
}

Look make_look(const LookFlags& flags, const Field& field, const std::string& unit,
               Session& session, const UsualLook& usual) {
  const KernelField* const set = field.kernels();
  const bool has_own_color = set != nullptr && set->has_own_color();
  if (!has_own_color && !flags.color_file.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                "--color-tf: no array of its own gives colour (--color-array)");
  }
  if (has_own_color) return look_of_two(flags, field, unit, session, usual);
  return look_of_one(flags, field, unit, session, usual);
}

}  // namespace ovoid::cli
