// SPDX-License-Identifier: Apache-2.0
#include "look_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ovoid/io.h"
#include "suggest.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

const Names<Mode> kModes = {{"composite", Mode::kComposite},
                            {"xray", Mode::kXray},
                            {"maximum", Mode::kMaximum},
                            {"mean", Mode::kMean},
                            {"isosurface", Mode::kIsosurface}};

std::string parse_color_map(const std::string& text) {
  const std::vector<std::string> names = color_map_names();
  const bool is_reversed = text.size() > 2 && text.compare(text.size() - 2, 2, "_r") == 0;
  const std::string base = is_reversed ? text.substr(0, text.size() - 2) : text;
  const bool is_known = std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    return name == text || name == base;
  });
  if (!is_known) {
    throw BadValue(
        fmt::format("expected one of {}{}", fmt::join(names, ", "), did_you_mean(text, names)));
  }
  return text;
}

// "v:a,v:a,..."
std::vector<OpacityPoint> parse_opacities(const std::string& text) {
  std::vector<OpacityPoint> points;
  for (const std::string& pair : split(text, ',')) {
    const std::vector<std::string> parts = split(pair, ':');
    try {
      if (parts.size() != 2) throw BadValue("");
      points.push_back({.x = parse_number(parts[0]), .opacity = parse_number(parts[1], {0, 1})});
    } catch (const BadValue&) {
      throw BadValue(
          fmt::format("expected VALUE:OPACITY pairs with OPACITY in [0, 1], not '{}'", pair));
    }
    if (points.size() > 1 && points[points.size() - 2].x > points.back().x) {
      throw BadValue(fmt::format("expected rising values, not {:g} after {:g}", points.back().x,
                                 points[points.size() - 2].x));
    }
  }
  return points;
}

bool is_lit(Mode mode) { return mode == Mode::kComposite || mode == Mode::kIsosurface; }

void add_color_flags(Flags& flags, LookFlags* look) {
  flags.section("colour and opacity");
  flags.value("--tf", "FILE.json", "a ParaView preset; values are absolute",
              [look](const std::string& text) { look->file = text; });
  flags.value(
      "--colormap", "NAME",
      fmt::format("{} (default viridis); NAME_r reverses", fmt::join(color_map_names(), ", ")),
      [look](const std::string& text) { look->color_map = parse_color_map(text); });
  flags.value("--opacity", "V:A,V:A,...", "opacity A at value V, per unit distance",
              [look](const std::string& text) { look->opacities = parse_opacities(text); });
  flags.value("--range", "LO,HI",
              "spread the colours, and a file's opacities, over these values (default: the data's, "
              "or the file's own)",
              [look](const std::string& text) { look->range = parse_range(text); });
  flags.value(
      "--unit-distance", "D",
      "world length over which opacities are meant (default: the file's, or the smallest spacing)",
      [look](const std::string& text) {
        look->unit_distance = parse_number(text, {.lo = 0, .lo_open = true});
      });
  flags.refuse({"--log", "--gradient-opacity"});
}

void add_light_flags(Flags& flags, LookFlags* look) {
  const auto material = [&flags](const char* name, const char* what, double* into,
                                 const Interval& interval) {
    flags.value(
        name, "K", fmt::format("{} (default {:g})", what, *into),
        [into, interval](const std::string& text) { *into = parse_number(text, interval); });
  };
  flags.section("mode and light");
  flags.value("--mode", joined(kModes), fmt::format("(default {})", name_of_mode(look->mode)),
              [look](const std::string& text) { look->mode = parse_name(text, kModes); });
  flags.value("--iso", "V", "the value of the isosurface",
              [look](const std::string& text) { look->isovalue = parse_number(text); });
  flags.toggle("--shade", "light the volume (default)", &look->shade);
  flags.toggle("--no-shade", "colours as they are", &look->shade, false);
  material("--ambient", "light from everywhere", &look->material.ambient, {.lo = 0});
  material("--diffuse", "matt reflection", &look->material.diffuse, {.lo = 0});
  material("--specular", "highlights", &look->material.specular, {.lo = 0});
  material("--specular-power", "their sharpness", &look->material.specular_power,
           {.lo = 0, .lo_open = true});
  flags.value("--light", "X,Y,Z", "direction towards the light, world (default: a headlight)",
              [look](const std::string& text) {
                look->light_direction = parse_vec3(text);
                if (look->light_direction->norm() == 0)
                  throw BadValue("expected a direction other than 0,0,0");
              });
}

// Over a span of values that may be a single one, then around it.
void spread_over(TransferFunction& tf, double lo, double hi) {
  const double half = lo < hi ? 0 : std::max(0.5, 0.5 * std::abs(lo));
  tf.map_range(lo - half, hi + half);
}

void take_colors(TransferFunction& tf, const TransferFunction& from) {
  tf.colors = from.colors;
  tf.color_space = from.color_space;
  tf.nan_color = from.nan_color;
}

// What neither the file nor a flag says is the default look's, spread over the file's span.
void complete(TransferFunction& file, TransferFunction defaults, const LookFlags& flags,
              Session& session) {
  spread_over(defaults, file.lo(), file.hi());
  if (file.opacities.empty() && flags.opacities.empty() && uses_opacity(flags.mode)) {
    session.note(flags.file + ": has no opacities, drawn with a ramp over its span");
    file.opacities = defaults.opacities;
  }
  if (file.colors.empty() && flags.color_map.empty()) {
    session.note(flags.file + ": has no colours, drawn with viridis over its span");
    take_colors(file, defaults);
  }
}

// A file's values that have little to do with the data's draw nothing, or one colour.
void note_disjoint_span(const TransferFunction& tf, const ValueRange& range, Session& session) {
  if (range.is_empty() || (tf.hi() >= range.lo && tf.lo() <= range.hi)) return;
  session.note(fmt::format(
      "--tf spans the values {:g} to {:g}, but the data's are {:g} to {:g}; --range moves it",
      tf.lo(), tf.hi(), range.lo, range.hi));
}

}  // namespace

// Who names a range wants it spread evenly; the other modes have no layers to tell apart.
bool uses_default_look(const LookFlags& flags) {
  return flags.file.empty() && !flags.range && flags.mode == Mode::kComposite;
}

bool uses_opacity(Mode mode) { return mode != Mode::kXray && mode != Mode::kIsosurface; }

const char* name_of_mode(Mode mode) { return name_in(kModes, mode); }

void add_look_flags(Flags& flags, LookFlags* look) {
  add_color_flags(flags, look);
  add_light_flags(flags, look);
}

void check_look_flags(const Flags& flags, const LookFlags& look) {
  const bool is_surface = look.mode == Mode::kIsosurface;
  if (is_surface && !flags.is_given("--iso")) throw UsageError("--mode isosurface: needs --iso V");
  if (!is_surface && flags.is_given("--iso")) throw UsageError("--iso: needs --mode isosurface");
  if (flags.is_given("--shade") && flags.is_given("--no-shade")) {
    throw UsageError("--no-shade: contradicts --shade");
  }
  const std::string mode = fmt::format("--mode {}", name_of_mode(look.mode));
  const char* const light =
      flags.first_given({"--ambient", "--diffuse", "--specular", "--specular-power", "--light"});
  const char* const lighting = light != nullptr ? light : flags.first_given({"--shade"});
  if (lighting != nullptr && !is_lit(look.mode)) {
    throw UsageError(fmt::format("{}: has no effect with {}, which is not lit", lighting, mode));
  }
  if (light != nullptr && !look.shade) {
    throw UsageError(fmt::format("{}: has no effect with --no-shade", light));
  }
  if (flags.is_given("--opacity") && !uses_opacity(look.mode)) {
    throw UsageError(fmt::format("--opacity: has no effect with {}", mode));
  }
  if (flags.is_given("--classification") && look.mode != Mode::kComposite) {
    throw UsageError(fmt::format("--classification: has no effect with {}", mode));
  }
  if (flags.is_given("--unit-distance") && look.mode != Mode::kComposite) {
    throw UsageError(fmt::format("--unit-distance: has no effect with {}", mode));
  }
}

Look make_look(const LookFlags& flags, const Field& field, const std::string& unit,
               Session& session) {
  const ValueRange range = field.value_range();
  Look look = uses_default_look(flags) ? default_look(field, unit) : ramp_look(range);
  TransferFunction& tf = look.transfer_function;
  if (flags.mode == Mode::kMaximum || flags.mode == Mode::kMean) {
    // One sample makes the pixel, so its opacity is no longer a matter of thickness.
    double greatest = 0;
    for (const OpacityPoint& point : tf.opacities) greatest = std::max(greatest, point.opacity);
    for (OpacityPoint& point : tf.opacities) point.opacity /= greatest;
  }
  if (!flags.file.empty()) {
    TransferFunction file = read_transfer_function(flags.file);
    complete(file, std::move(tf), flags, session);
    tf = std::move(file);
    if (!flags.range && flags.mode != Mode::kXray) note_disjoint_span(tf, range, session);
  }
  if (!flags.color_map.empty()) {
    TransferFunction map = color_map(flags.color_map);
    spread_over(map, tf.lo(), tf.hi());
    take_colors(tf, map);
  }
  if (flags.range) tf.map_range(flags.range->first, flags.range->second);
  if (!flags.opacities.empty()) tf.opacities = flags.opacities;
  look.mode = flags.mode;
  look.isovalue = flags.isovalue;
  look.shade = flags.shade;
  look.material = flags.material;
  look.light_direction = flags.light_direction;
  if (flags.unit_distance) look.unit_distance = *flags.unit_distance;
  return look;
}

}  // namespace ovoid::cli
