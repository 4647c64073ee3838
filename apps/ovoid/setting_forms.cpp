// SPDX-License-Identifier: Apache-2.0
#include "setting_forms.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "color_words.h"
#include "ovoid/crop.h"
#include "ovoid/error.h"
#include "session.h"
#include "suggest.h"

namespace ovoid::cli {
namespace {

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

// "v:a,v:a,..." or "v,a,v,a,..."; `value` is what the first of each is called.
std::vector<OpacityPoint> parse_points(const std::string& text, const char* value) {
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

// The three "LO:HI" of "LO:HI,LO:HI,LO:HI" as text; any of the numbers, or a whole part, may be
// missing.
std::array<std::array<std::string, 2>, 3> parse_parts(const std::string& text) {
  const std::vector<std::string> axes = split(text, ',');
  if (axes.size() != 3) throw BadValue("expected three ranges LO:HI, each may be empty");
  std::array<std::array<std::string, 2>, 3> parts;
  for (std::size_t a = 0; a < 3; ++a) {
    if (axes[a].empty()) continue;
    const std::vector<std::string> ends = split(axes[a], ':');
    if (ends.size() != 2) throw BadValue(fmt::format("expected LO:HI, not '{}'", axes[a]));
    parts[a] = {ends[0], ends[1]};
  }
  return parts;
}

Tolerance tolerance_of(const std::string& text, bool may_be_zero) {
  if (!text.ends_with('%')) return {parse_number(text, {.lo = 0, .lo_open = !may_be_zero}), false};
  const Interval percent = {.lo = 0, .hi = 100, .lo_open = !may_be_zero};
  return {parse_number(text.substr(0, text.size() - 1), percent) / 100, true};
}

}  // namespace

std::optional<std::string> is_unlit(const std::string& mode) {
  return if_so(mode != "composite" && mode != "isosurface", mode);
}
std::optional<std::string> is_no_layer(const std::string& mode) {
  return if_so(mode != "composite", mode);
}

Tolerance parse_tolerance(const std::string& text) { return tolerance_of(text, false); }
Tolerance parse_tolerance_or_zero(const std::string& text) { return tolerance_of(text, true); }

LatticeKernel parse_kernel(const std::string& text) {
  using K = LatticeKernel;
  for (const K& kernel : {kBSplineKernel, kCatmullRomKernel})
    if (text == name_of(kernel.kind)) return kernel;
  const std::vector<std::string> parts = split(text, ':');
  if (parts[0] != name_of(LatticeKernelKind::kGaussian) || parts.size() > 2)
    throw BadValue(fmt::format("expected {}, {} or gaussian:SIGMA,CUTOFF",
                               name_of(LatticeKernelKind::kBSpline),
                               name_of(LatticeKernelKind::kCatmullRom)));
  K kernel;
  if (parts.size() == 1) return kernel;
  const std::vector<std::string> numbers = split(parts[1], ',');
  if (numbers.size() > 2) throw BadValue("expected gaussian:SIGMA,CUTOFF");
  const auto named = [](const char* what, const std::string& number, const Interval& interval) {
    try {
      return parse_number(number, interval);
    } catch (const BadValue& bad) {
      throw BadValue(fmt::format("{}: {}", what, bad.what()));
    }
  };
  kernel.sigma = named("SIGMA", numbers[0], {K::kMinSigma, K::kMaxSigma});
  if (numbers.size() == 2) kernel.cutoff = named("CUTOFF", numbers[1], {0, K::kMaxCutoff, true});
  if (kernel.support_radius() < K::kMinSupport) {
    throw BadValue(fmt::format("expected SIGMA x CUTOFF >= {:g} spacings, else kernels leave gaps",
                               K::kMinSupport));
  }
  return kernel;
}

int parse_component(const std::string& text) {
  if (text == "magnitude") return LatticeModelOptions::kMagnitude;
  try {
    return static_cast<int>(parse_integer(text, 0, 1'000'000));
  } catch (const BadValue&) {
    throw BadValue("expected a component's number, from 0, or magnitude");
  }
}

Vec3 parse_spacing(const std::string& text) {
  Vec3 spacing = parse_vec3(text);
  // What any reader takes for a distance of samples.
  if (!(spacing.minCoeff() >= 1e-90 && spacing.maxCoeff() <= 1e90))
    throw BadValue("expected three numbers > 0, from 1e-90 to 1e90");
  return spacing;
}

Vec3 parse_direction(const std::string& text) {
  Vec3 direction = parse_vec3(text);
  if (direction.norm() == 0) throw BadValue("expected a direction other than 0,0,0");
  return direction;
}

std::pair<Light, std::optional<Vec3>> parse_light(const std::string& text) {
  const std::string kStudio = "studio";
  if (text == "headlight") return {Light::kSingle, std::nullopt};
  if (text == kStudio) return {Light::kStudio, std::nullopt};
  if (text.starts_with(kStudio + ":"))
    return {Light::kStudio, parse_direction(text.substr(kStudio.size() + 1))};
  try {
    return {Light::kSingle, parse_direction(text)};
  } catch (const BadValue& bad) {
    throw BadValue(fmt::format("{}, studio or headlight", bad.what()));
  }
}

FurtherLight parse_further_light(const std::string& text) {
  const std::size_t at = text.find('@');
  FurtherLight light;
  try {
    light.direction = parse_direction(text.substr(0, at));
    if (at != std::string::npos)
      light.intensity = parse_number(text.substr(at + 1), {.lo = 0, .hi = 10});
  } catch (const BadValue& bad) {
    throw BadValue(
        fmt::format("{}; lights after the first are X,Y,Z or X,Y,Z@INTENSITY", bad.what()));
  }
  return light;
}

Hyperplane parse_hyperplane(const std::string& text) {
  const auto commas = std::count(text.begin(), text.end(), ',');
  const std::vector<double> numbers = parse_numbers(text, commas == 3 ? 4 : 5);
  Hyperplane plane{{numbers[0], numbers[1], numbers[2], numbers[3]},
                   numbers.size() == 5 ? numbers[4] : std::numeric_limits<double>::quiet_NaN()};
  if (plane.normal == std::array<double, 4>{})
    throw BadValue("expected a, b, c and d that are not all 0");
  return plane;
}

std::vector<Isosurface> parse_isosurfaces(const std::string& text) {
  std::vector<Isosurface> surfaces;
  for (const std::string& part : split(text, ',')) {
    const std::vector<std::string> pieces = split(part, ':');
    if (pieces.size() > 3) throw BadValue("expected V, V:COLOR or V:COLOR:OPACITY, with commas");
    Isosurface surface;
    surface.value = parse_number(pieces[0]);
    if (pieces.size() > 1 && !pieces[1].empty()) surface.color = parse_rgb(pieces[1]);
    if (pieces.size() > 2) surface.opacity = parse_number(pieces[2], {.lo = 0, .hi = 1});
    for (const Isosurface& other : surfaces) {
      if (other.value == surface.value)
        throw BadValue(fmt::format("expected each value once, not {:g} again", surface.value));
    }
    surfaces.push_back(surface);
  }
  if (surfaces.size() > Look::kMaxIsosurfaces)
    throw BadValue(fmt::format("expected at most {} surfaces", Look::kMaxIsosurfaces));
  return surfaces;
}

ClipPlane parse_clip(const std::string& text) {
  const std::vector<double> numbers = parse_numbers(text, 4);
  ClipPlane plane{{numbers[0], numbers[1], numbers[2]}, numbers[3]};
  if (plane.normal.norm() == 0)
    throw BadValue("expected NX,NY,NZ,D with a normal other than 0,0,0");
  return plane;
}

std::array<ClipPlane, 2> parse_thick_slice(const std::string& text) {
  const std::vector<double> numbers = parse_numbers(text, 5);
  const ClipPlane middle{{numbers[0], numbers[1], numbers[2]}, numbers[3]};
  if (middle.normal.norm() == 0)
    throw BadValue("expected NX,NY,NZ,D,T with a normal other than 0,0,0");
  if (!(numbers[4] > 0))
    throw BadValue("expected NX,NY,NZ,D,T with a thickness T > 0 (--value-plane shows a plane)");
  return slice_planes(middle, numbers[4]);
}

ValuePlane parse_value_plane(const std::string& text) {
  constexpr const char* kShown = ",shown";
  const bool is_shown = has_ending(text, kShown);
  const auto [normal, offset] =
      parse_clip(text.substr(0, text.size() - (is_shown ? std::strlen(kShown) : 0)));
  return {normal, offset, is_shown ? PlaneFront::kShown : PlaneFront::kRemoved};
}

SlicePlane parse_slice_plane(const std::string& text) {
  static const Names<int> axes = {{"x", 0},        {"y", 1},       {"z", 2},
                                  {"sagittal", 0}, {"coronal", 1}, {"axial", 2}};
  if (text.find(',') != std::string::npos) {
    const auto [normal, offset] = parse_clip(text);
    return {normal, offset};
  }
  const std::size_t equals = text.find('=');
  SlicePlane plane;
  try {
    plane.normal = Vec3::Unit(parse_name(text.substr(0, equals), axes));
  } catch (const BadValue&) {
    throw BadValue(
        "expected x, y, z, sagittal, coronal or axial, with =PLACE or through the middle, "
        "or NX,NY,NZ,D");
  }
  if (equals != std::string::npos) plane.offset = parse_number(text.substr(equals + 1));
  return plane;
}

std::string parse_preset(const std::string& text) {
  const std::vector<std::string> names = look_preset_names();
  if (std::find(names.begin(), names.end(), text) == names.end()) {
    throw BadValue(
        fmt::format("expected one of {}{}", fmt::join(names, ", "), did_you_mean(text, names)));
  }
  return text;
}

bool is_list_of_colors(const std::string& text) { return text.find(',') != std::string::npos; }

std::vector<ColorPoint> parse_colors(const std::string& text) {
  try {
    return colors_from_list(parse_list(text));
  } catch (const BadValue&) {
    throw BadValue("expected V,R,G,B,V,R,G,B,...: numbers, separated by commas");
  } catch (const Error& error) {
    throw BadValue(fmt::format("expected V,R,G,B,V,R,G,B,...: {}", error.what()));
  }
}

std::string parse_color_map(const std::string& text) {
  if (is_list_of_colors(text)) {
    parse_colors(text);
    return text;
  }
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

std::vector<OpacityPoint> parse_opacities(const std::string& text) {
  return parse_points(text, "VALUE");
}

std::vector<OpacityPoint> parse_gradient_opacities(const std::string& text) {
  std::vector<OpacityPoint> points = parse_points(text, "GRADIENT");
  if (points.front().x < 0) {
    throw BadValue(fmt::format("expected gradients >= 0, not {:g}", points.front().x));
  }
  return points;
}

Ranges2D parse_ranges_2d(const std::string& text) {
  const std::vector<double> n = parse_numbers(text, 4);
  if (!(n[0] < n[1]) || !(n[2] < n[3]) || n[2] < 0)
    throw BadValue("expected values from and to, and gradients >= 0 from and to, each rising");
  return {{n[0], n[1]}, {n[2], n[3]}};
}

std::pair<double, double> parse_window(const std::string& text) {
  const std::vector<double> numbers = parse_numbers(text, 2);
  const double lo = numbers[1] - numbers[0] / 2;
  const double hi = numbers[1] + numbers[0] / 2;
  if (!(lo < hi) || !std::isfinite(hi - lo)) throw BadValue("expected W,L with W > 0");
  return {lo, hi};
}

std::array<CropFlags::Range, 3> parse_samples(const std::string& text) {
  constexpr std::int64_t kGreatest = std::numeric_limits<std::int64_t>::max();
  const auto parts = parse_parts(text);
  std::array<CropFlags::Range, 3> ranges;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto& [first, last] = parts[a];
    if (!first.empty()) ranges[a].first = parse_integer(first, 0, kGreatest);
    if (!last.empty()) ranges[a].last = parse_integer(last, 0, kGreatest);
    if (ranges[a].first && ranges[a].last && *ranges[a].first > *ranges[a].last)
      throw BadValue(fmt::format("expected FIRST:LAST with FIRST <= LAST, not {}:{}", first, last));
  }
  return ranges;
}

Bounds3 parse_world(const std::string& text) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto parts = parse_parts(text);
  Bounds3 world;
  for (int a = 0; a < 3; ++a) {
    const auto& [lo, hi] = parts[static_cast<std::size_t>(a)];
    world.min()[a] = lo.empty() ? -kInfinity : parse_number(lo);
    world.max()[a] = hi.empty() ? kInfinity : parse_number(hi);
    if (!(world.min()[a] < world.max()[a]))
      throw BadValue(fmt::format("expected LO:HI with LO < HI, not {}:{}", lo, hi));
  }
  return world;
}

std::string text_of_component(int component) {
  return component == LatticeModelOptions::kMagnitude ? "magnitude" : fmt::format("{}", component);
}

std::string text_of(const LatticeKernel& kernel) {
  if (kernel.kind != LatticeKernelKind::kGaussian) return name_of(kernel.kind);
  return fmt::format("gaussian:{},{}", kernel.sigma, kernel.cutoff);
}

std::string text_of(const Vec3& v) { return fmt::format("{},{},{}", v.x(), v.y(), v.z()); }
std::string text_of_light(Light light, const std::optional<Vec3>& direction) {
  const std::string towards = direction ? text_of(*direction) : "";
  if (light == Light::kSingle) return direction ? towards : "headlight";
  return direction ? "studio:" + towards : "studio";
}

std::string text_of(const FurtherLight& light) {
  if (light.intensity == 1) return text_of(light.direction);
  return fmt::format("{}@{}", text_of(light.direction), light.intensity);
}

std::string text_of(const Rgb& rgb) { return fmt::format("{}", fmt::join(rgb, ",")); }
std::string text_of(const std::vector<Isosurface>& surfaces) {
  std::string text;
  for (const Isosurface& surface : surfaces) {
    text += fmt::format("{}{}", text.empty() ? "" : ",", surface.value);
    if (surface.color || surface.opacity != 1) text += ':';
    if (surface.color) text += hex_text(*surface.color);
    if (surface.opacity != 1) text += fmt::format(":{}", surface.opacity);
  }
  return text;
}
std::string text_of(const Index3& dims) { return fmt::format("{}", fmt::join(dims, "x")); }
std::string text_of(ScalarType type) { return name_of(type); }

std::string text_of(const Hyperplane& plane) {
  const std::string normal = fmt::format("{}", fmt::join(plane.normal, ","));
  return std::isnan(plane.offset) ? normal : fmt::format("{},{}", normal, plane.offset);
}

std::string text_of(const ClipPlane& plane) {
  return fmt::format("{},{}", text_of(plane.normal), plane.offset);
}

std::string text_of(const SlicePlane& plane) {
  if (plane.offset) return text_of(ClipPlane{plane.normal, *plane.offset});
  return plane.normal.x() > 0 ? "x" : plane.normal.y() > 0 ? "y" : "z";
}

std::string text_of(const ValuePlane& plane) {
  const bool is_shown = plane.front == PlaneFront::kShown;
  return fmt::format("{},{}{}", text_of(plane.normal), plane.offset, is_shown ? ",shown" : "");
}

std::string text_of(const std::vector<OpacityPoint>& points) {
  std::string text;
  for (const OpacityPoint& point : points)
    text += fmt::format("{}{}:{}", text.empty() ? "" : ",", point.x, point.opacity);
  return text;
}

std::string text_of(const std::pair<double, double>& range) {
  return fmt::format("{},{}", range.first, range.second);
}

std::string text_of(const std::array<CropFlags::Range, 3>& samples) {
  const auto end = [](const auto& sample) { return sample ? fmt::format("{}", *sample) : ""; };
  std::array<std::string, 3> axes;
  for (std::size_t a = 0; a < 3; ++a)
    axes[a] = fmt::format("{}:{}", end(samples[a].first), end(samples[a].last));
  return fmt::format("{}", fmt::join(axes, ","));
}

std::string text_of(const Bounds3& world) {
  const auto end = [](double value) { return std::isinf(value) ? "" : fmt::format("{}", value); };
  std::array<std::string, 3> axes;
  for (int a = 0; a < 3; ++a)
    axes[static_cast<std::size_t>(a)] =
        fmt::format("{}:{}", end(world.min()[a]), end(world.max()[a]));
  return fmt::format("{}", fmt::join(axes, ","));
}

}  // namespace ovoid::cli
