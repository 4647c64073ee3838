// SPDX-License-Identifier: Apache-2.0
#include "look_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "ovoid/error.h"
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
    throw BadValue(fmt::format("expected one of {}, or V,R,G,B,...{}", fmt::join(names, ", "),
                               did_you_mean(text, names)));
  }
  return text;
}

std::string parse_preset(const std::string& text) {
  const std::vector<std::string> names = look_preset_names();
  if (std::find(names.begin(), names.end(), text) == names.end()) {
    throw BadValue(
        fmt::format("expected one of {}{}", fmt::join(names, ", "), did_you_mean(text, names)));
  }
  return text;
}

// "v,r,g,b,v,r,g,b,..." and "v,a,v,a,...": blanks may stand around the numbers, as in files.
std::vector<double> parse_list(const std::string& text) {
  std::vector<double> numbers;
  for (const std::string& part : split(text, ',')) {
    const auto begin = part.find_first_not_of(' ');
    const auto end = part.find_last_not_of(' ');
    numbers.push_back(
        parse_number(begin == std::string::npos ? "" : part.substr(begin, end - begin + 1)));
  }
  return numbers;
}

std::vector<ColorPoint> parse_colors(const std::string& text) {
  try {
    return colors_from_list(parse_list(text));
  } catch (const BadValue&) {
    throw BadValue("expected V,R,G,B,V,R,G,B,...: numbers, separated by commas");
  } catch (const Error& error) {
    throw BadValue(fmt::format("expected V,R,G,B,V,R,G,B,...: {}", error.what()));
  }
}

bool is_list_of_colors(const std::string& text) { return text.find(',') != std::string::npos; }

// "v:a,v:a,..." or "v,a,v,a,..."; `value` is what the first of each is called.
std::vector<OpacityPoint> parse_opacities(const std::string& text, const char* value) {
  std::vector<double> numbers;
  const bool has_pairs = text.find(':') != std::string::npos;
  for (const std::string& pair : has_pairs ? split(text, ',') : std::vector<std::string>{}) {
    const std::vector<std::string> parts = split(pair, ':');
    try {
      if (parts.size() != 2) throw BadValue("");
      numbers.push_back(parse_number(parts[0]));
      numbers.push_back(parse_number(parts[1], {0, 1}));
    } catch (const BadValue&) {
      throw BadValue(
          fmt::format("expected {}:OPACITY pairs with OPACITY in [0, 1], not '{}'", value, pair));
    }
    const std::size_t n = numbers.size();
    if (n > 2 && numbers[n - 4] > numbers[n - 2]) {
      throw BadValue(fmt::format("expected rising values, not {:g} after {:g}", numbers[n - 2],
                                 numbers[n - 4]));
    }
  }
  if (!has_pairs) {
    try {
      numbers = parse_list(text);
    } catch (const BadValue&) {
      throw BadValue(
          fmt::format("expected {}:OPACITY pairs with OPACITY in [0, 1], not '{}'", value, text));
    }
  }
  try {
    return opacities_from_list(numbers);
  } catch (const Error& error) {
    throw BadValue(
        fmt::format("expected {0}:OPACITY,... or {0},OPACITY,...: {1}", value, error.what()));
  }
}

std::vector<OpacityPoint> parse_gradient_opacities(const std::string& text) {
  std::vector<OpacityPoint> points = parse_opacities(text, "GRADIENT");
  if (points.front().x < 0) {
    throw BadValue(fmt::format("expected gradients >= 0, not {:g}", points.front().x));
  }
  return points;
}

// "W,L": the values from L - W/2 to L + W/2.
std::pair<double, double> parse_window(const std::string& text) {
  const std::vector<double> numbers = parse_numbers(text, 2);
  const double lo = numbers[1] - numbers[0] / 2;
  const double hi = numbers[1] + numbers[0] / 2;
  if (!(lo < hi) || !std::isfinite(hi - lo)) throw BadValue("expected W,L with W > 0");
  return {lo, hi};
}

bool is_lit(Mode mode) { return mode == Mode::kComposite || mode == Mode::kIsosurface; }

void add_look_source_flags(Flags& flags, LookFlags* look) {
  flags.value("--tf", "FILE|JSON",
              "a look: ParaView JSON or XML, Slicer .vp.json or .vp, Inviwo .itf, or numbers; "
              "values are absolute; or JSON itself",
              [look](const std::string& text) { look->file = text; });
  flags.value("--tf-name", "NAME", "which look of a file with several (default: the first)",
              [look](const std::string& text) { look->file_name = text; });
  flags.value("--color-tf", "FILE|JSON",
              "colours of --color-array alone, as --tf; other flags about colour leave them be",
              [look](const std::string& text) { look->color_file = text; });
  flags.value(
      "--preset", "NAME",
      fmt::format("a look made for one kind of data: {}", fmt::join(look_preset_names(), ", ")),
      [look](const std::string& text) { look->preset = parse_preset(text); });
}

void add_spread_flags(Flags& flags, LookFlags* look) {
  flags.value("--range", "LO,HI",
              "spread the colours, and a file's opacities, over these values (default: the data's, "
              "or the file's own)",
              [look](const std::string& text) { look->range = parse_range(text); });
  flags.value("--window", "W,L",
              "as --range L-W/2,L+W/2; colours gray, unless --colormap says others",
              [look](const std::string& text) {
                look->range = parse_window(text);
                look->is_window = true;
              });
  flags.toggle("--log", "colours and opacity run along the logarithm of the value", &look->is_log);
  flags.value("--symlog", "W",
              "along a logarithm on either side of zero, straight for values within W of it",
              [look](const std::string& text) {
                look->linear_width = parse_number(text, {.lo = 0, .lo_open = true});
              });
}

void add_color_flags(Flags& flags, LookFlags* look) {
  flags.section("colour and opacity");
  add_look_source_flags(flags, look);
  flags.value("--colormap", "NAME|V,R,G,B,...",
              fmt::format("{} (default viridis); NAME_r reverses; or colours at values",
                          fmt::join(color_map_names(), ", ")),
              [look](const std::string& text) {
                if (is_list_of_colors(text)) {
                  look->colors = parse_colors(text);
                } else {
                  look->color_map = parse_color_map(text);
                }
              });
  flags.value(
      "--opacity", "V:A,V:A,...", "opacity A at value V, per unit distance",
      [look](const std::string& text) { look->opacities = parse_opacities(text, "VALUE"); });
  flags.value("--gradient-opacity", "G:A,G:A,...",
              "factor A on the opacity where the gradient has length G, value per world length",
              [look](const std::string& text) {
                look->gradient_opacities = parse_gradient_opacities(text);
              });
  add_spread_flags(flags, look);
  flags.value("--below-color", "R,G,B", "of values below the colours' first, each in [0, 1]",
              [look](const std::string& text) { look->below_color = parse_rgb(text); });
  flags.value("--above-color", "R,G,B", "of values above the colours' last",
              [look](const std::string& text) { look->above_color = parse_rgb(text); });
  flags.value(
      "--unit-distance", "D",
      "world length over which opacities are meant (default: the file's, or the default sampling "
      "distance)",
      [look](const std::string& text) {
        look->unit_distance = parse_number(text, {.lo = 0, .lo_open = true});
      });
  flags.refuse({"--nan-color"});
}

void add_light_flags(Flags& flags, LookFlags* look) {
  const auto material = [&flags](const char* name, const char* what, double otherwise,
                                 std::optional<double>* into, const Interval& interval) {
    flags.value(
        name, "K", fmt::format("{} (default {:g}, or the look's)", what, otherwise),
        [into, interval](const std::string& text) { *into = parse_number(text, interval); });
  };
  const Material otherwise;
  flags.section("mode and light");
  flags.value("--mode", joined(kModes), fmt::format("(default {})", name_of_mode(look->mode)),
              [look](const std::string& text) { look->mode = parse_name(text, kModes); });
  flags.value("--iso", "V", "the value of the isosurface",
              [look](const std::string& text) { look->isovalue = parse_number(text); });
  flags.toggle("--shade", "light the volume (default, unless the look says no)", &look->shade);
  flags.toggle("--no-shade", "colours as they are", &look->no_shade);
  material("--ambient", "light from everywhere", otherwise.ambient, &look->ambient, {.lo = 0});
  material("--diffuse", "matt reflection", otherwise.diffuse, &look->diffuse, {.lo = 0});
  material("--specular", "highlights", otherwise.specular, &look->specular, {.lo = 0});
  material("--specular-power", "their sharpness", otherwise.specular_power, &look->specular_power,
           {.lo = 0, .lo_open = true});
  flags.value("--light", "X,Y,Z", "direction towards the light, world (default: a headlight)",
              [look](const std::string& text) {
                look->light_direction = parse_vec3(text);
                if (look->light_direction->norm() == 0)
                  throw BadValue("expected a direction other than 0,0,0");
              });
}

void contradict(const Flags& flags, const char* a, const char* b) {
  if (flags.is_given(a) && flags.is_given(b)) {
    throw UsageError(fmt::format("{}: contradicts {}", a, b));
  }
}

void check_spread_flags(const Flags& flags, const LookFlags& look) {
  contradict(flags, "--preset", "--tf");
  contradict(flags, "--window", "--range");
  contradict(flags, "--window", "--tf");
  contradict(flags, "--window", "--preset");
  contradict(flags, "--symlog", "--log");
  if (flags.is_given("--tf-name") && !flags.is_given("--tf")) {
    throw UsageError("--tf-name: needs --tf FILE");
  }
  if (!look.is_log) return;
  const char* const range = look.is_window ? "--window" : "--range";
  if (look.range && !(look.range->first > 0)) {
    throw UsageError(fmt::format("{}: begins at {:g}, expected values > 0 with --log", range,
                                 look.range->first));
  }
  if (!look.opacities.empty() && !(look.opacities.front().x > 0)) {
    throw UsageError(fmt::format("--opacity: begins at {:g}, expected values > 0 with --log",
                                 look.opacities.front().x));
  }
  const bool is_map =
      !look.colors.empty() && look.colors.front().x == 0 && look.colors.back().x == 1;
  if (!look.colors.empty() && !is_map && !look.range && !(look.colors.front().x > 0)) {
    throw UsageError(fmt::format("--colormap: begins at {:g}, expected values > 0 with --log",
                                 look.colors.front().x));
  }
}

bool has_own_span(const LookFlags& flags) { return !flags.file.empty() || !flags.preset.empty(); }

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
  if (file.colors.empty() && flags.color_map.empty() && flags.colors.empty()) {
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

// The look that the other flags change.
Look base_look(const LookFlags& flags, const Field& field, const std::string& unit,
               Session& session) {
  const ValueRange range = field.value_range();
  Look look = uses_default_look(flags) ? default_look(field, unit) : ramp_look(range);
  if (flags.mode == Mode::kMaximum || flags.mode == Mode::kMean)
    make_opaque(look.transfer_function);
  if (!flags.preset.empty()) look = look_preset(flags.preset, range);
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

// The colours of flags, by name over the look's span, or as a list: from 0 to 1 it is spread as a
// map is, else its values are absolute, but for --range.
void take_flag_colors(TransferFunction& tf, const LookFlags& flags) {
  const bool is_list = !flags.colors.empty();
  const std::string name = flags.is_window && flags.color_map.empty() ? "gray" : flags.color_map;
  if (!is_list && name.empty()) return;
  TransferFunction map = is_list ? TransferFunction() : color_map(name);
  if (is_list) map.colors = flags.colors;
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
  look.light_direction = flags.light_direction;
  const bool has_light = flags.ambient || flags.diffuse || flags.specular || flags.specular_power ||
                         flags.light_direction;
  if (has_light && !look.shade && is_lit(flags.mode)) {
    session.note(source_of_flag("--tf", flags.file) +
                 ": is not lit, so that light and material show nothing; --shade");
  }
}

// The look where one array gives all.
Look look_of_one(const LookFlags& flags, const Field& field, const std::string& unit,
                 Session& session) {
  Look look = base_look(flags, field, unit, session);
  TransferFunction& tf = look.transfer_function;
  place(tf, flags, session);
  take_flag_colors(tf, flags);
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
  look.isovalue = flags.isovalue;
  if (flags.unit_distance) look.unit_distance = *flags.unit_distance;
  return look;
}

// The flags without what is about colour, which includes where on the axis of values it lies.
LookFlags without_colors(LookFlags flags) {
  flags.color_map.clear();
  flags.colors.clear();
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
                 Session& session) {
  const bool has_file = !flags.color_file.empty();
  Look look = look_of_one(has_file ? flags : without_colors(flags), field, unit, session);
  if (has_file) {
    look.color_function = look_of_flag("--color-tf", flags.color_file, {}).transfer_function;
    return look;
  }
  TransferFunction colors = ramp_look(field.color_range()).transfer_function;
  if (!flags.preset.empty())
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

Look look_of_flag(const char* flag, const std::string& value, const std::string& name) {
  return is_json(value) ? look_from_text(value, flag, name) : read_look(value, name);
}

void check_look_of_flag(const char* flag, const std::string& value, const std::string& name) {
  if (!is_json(value)) return;
  try {
    look_of_flag(flag, value, name);
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
}

std::string source_of_flag(const char* flag, const std::string& value) {
  return is_json(value) ? flag : value;
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
  check_spread_flags(flags, look);
  check_look_of_flag("--tf", look.file, look.file_name);
  check_look_of_flag("--color-tf", look.color_file, {});
  contradict(flags, "--no-shade", "--shade");
  const std::string mode = fmt::format("--mode {}", name_of_mode(look.mode));
  const char* const light =
      flags.first_given({"--ambient", "--diffuse", "--specular", "--specular-power", "--light"});
  const char* const lighting = light != nullptr ? light : flags.first_given({"--shade"});
  if (lighting != nullptr && !is_lit(look.mode)) {
    throw UsageError(fmt::format("{}: has no effect with {}, which is not lit", lighting, mode));
  }
  if (light != nullptr && look.no_shade) {
    throw UsageError(fmt::format("{}: has no effect with --no-shade", light));
  }
  if (flags.is_given("--opacity") && !uses_opacity(look.mode)) {
    throw UsageError(fmt::format("--opacity: has no effect with {}", mode));
  }
  for (const char* const flag : {"--classification", "--unit-distance", "--gradient-opacity"}) {
    if (flags.is_given(flag) && look.mode != Mode::kComposite) {
      throw UsageError(fmt::format("{}: has no effect with {}", flag, mode));
    }
  }
}

Look make_look(const LookFlags& flags, const Field& field, const std::string& unit,
               Session& session) {
  const KernelField* const set = field.kernels();
  const bool has_own_color = set != nullptr && set->has_own_color();
  if (!has_own_color && !flags.color_file.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                "--color-tf: no array of its own gives colour (--color-array)");
  }
  if (has_own_color) return look_of_two(flags, field, unit, session);
  return look_of_one(flags, field, unit, session);
}

}  // namespace ovoid::cli
