// SPDX-License-Identifier: Apache-2.0
// A look from nothing but the field. docs/looks.md, "The default look", says what is looked for and
// in which order; the numbers of this page are chosen by eye on scans, simulations and formulas,
// and moderate on purpose: a threshold a little off costs a little haze.
//
// Everything goes by quantiles of samples, so that a few odd samples change nothing and a small
// change of the data is a small change of the look.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "data/lattice/rise_samples.h"
#include "data/validate.h"
#include "ovoid/look.h"
#include "view/look/field_samples.h"
#include "view/look/joint_histogram.h"
#include "view/look/label_look.h"
#include "view/look/look_colors.h"
#include "view/look/vessels.h"

namespace ovoid {
namespace {

using view::FieldSamples;
using view::quantile;
using view::set_body_colors;
using view::set_bright_colors;
using view::set_glowing_colors;
using view::set_light;
using view::set_two_sided_colors;

// Least quotient of the greatest and the median value that asks for a logarithmic scale.
constexpr double kLogQuotient = 1000;

// Opacity per sample at which `depth` samples in a row let half of the light through.
double opacity_for_half_depth(double depth) { return 1.0 - std::pow(0.5, 1.0 / depth); }

// Depths at which a layer shows well, in spacings of a field with this many of them: what surrounds
// is seen through, what is dense is a surface.
struct Depths {
  double thin, solid;
};

// What slopes tell of the samples; nothing where curves run along a logarithm.
struct Slopes {
  Materials materials;
  bool is_ramp = false;
};

Slopes slopes_of(const LatticeField& field) {
  constexpr double kAllOneWay = 0.9;
  const std::vector<data::RiseSample> rises = data::take_rises(field.samples());
  return {view::find_materials(rises), view::one_sidedness(rises) > kAllOneWay};
}

// Noise is seen through: over a longer way more of it is averaged.
Depths depths_of(const LatticeField& field, double softness) {
  const LatticeGeometry& lattice = field.geometry();
  const double per_spacing = lattice.density() * std::pow(lattice.unit_spacing(), 3);
  const double edge = std::cbrt(static_cast<double>(num_samples(lattice.dims)) / per_spacing);
  return {std::max(1.5, std::lerp(0.02, 0.06, softness) * edge),
          std::max(0.5, std::lerp(0.004, 0.03, softness) * edge)};
}

// Scanners count; what they see looks like a thing, whether its background is in sight or cropped.
void set_map(Look& look, const FieldSamples& samples, double lo, double hi,
             std::span<const double> materials) {
  (samples.is_counted ? set_body_colors : set_bright_colors)(look, lo, hi, materials);
}

// --- CT in Hounsfield units

constexpr double kRawWater = 1024;  // in scanners' own numbers

// Air makes a peak at -1000, or padding lies far below it; nothing else in use has that. `water`:
// where 0 Hounsfield units would be.
bool has_peaks_of_ct(const FieldSamples& samples, double water) {
  const auto share_between = [&](double lo, double hi) {
    const auto& v = samples.values;
    const auto count = std::upper_bound(v.begin(), v.end(), static_cast<float>(hi + water)) -
                       std::lower_bound(v.begin(), v.end(), static_cast<float>(lo + water));
    return static_cast<double>(count) / static_cast<double>(v.size());
  };
  const double highest = quantile(samples.values, 0.9999) - water;
  return samples.values.front() - water >= -4096 && highest > 100 && highest < 5000 &&
         share_between(-1050, -900) > 0.1 && share_between(-200, 300) > 0.05 &&
         share_between(-890, -210) < share_between(-1050, -900);
}

std::optional<double> water_of(const FieldSamples& samples, std::string_view unit) {
  if (unit == "HU" || unit == "hu" || unit == "Hounsfield") return 0.0;
  if (!unit.empty()) return std::nullopt;
  if (has_peaks_of_ct(samples, 0)) return 0.0;
  const bool may_be_raw = samples.is_counted && samples.values.front() >= 0;
  if (may_be_raw && has_peaks_of_ct(samples, kRawWater)) return kRawWater;
  return std::nullopt;
}

// Opacities are meant over 1/300 of the field's edge, a millimetre or two of a body.
Look hounsfield_look(const LatticeField& field, double water) {
  Look look;
  TransferFunction& tf = look.transfer_function;
  tf.name = "CT in Hounsfield units";
  tf.color_space = ColorSpace::kRgb;
  tf.colors = {{-200, {0.85, 0.65, 0.50}}, {-50, {0.88, 0.62, 0.46}}, {60, {0.78, 0.36, 0.28}},
               {200, {0.93, 0.55, 0.40}},  {350, {0.96, 0.88, 0.76}}, {1500, {1.0, 0.98, 0.94}}};
  tf.opacities = {{-300, 0.0}, {-150, 0.004}, {100, 0.006}, {180, 0.05}, {300, 0.4}, {800, 0.8}};
  const Vec3 axes = field.geometry().world_from_index.linear().colwise().norm().transpose();
  const Vec3 sides = axes.cwiseProduct(field.geometry().index_bounds().sizes());
  tf.unit_distance = sides.maxCoeff() / 300.0;
  tf.map_range(tf.lo() + water, tf.hi() + water);
  set_light(look, 40);  // more than the noise of a usual dose
  return look;
}

// --- what has a background

struct Background {
  double value;
  double spread;  // of its noise: about one standard deviation
};

// The value that most of the outer faces share, if they share one.
std::optional<Background> background_of(const FieldSamples& samples) {
  const auto& faces = samples.on_faces;
  if (faces.size() < 16) return std::nullopt;
  const double range = quantile(samples.values, 0.9995) - quantile(samples.values, 0.0005);
  // The shortest interval that holds half of them.
  const std::size_t half = faces.size() / 2;
  std::size_t best = 0;
  for (std::size_t i = 0; i + half < faces.size(); ++i) {
    if (faces[i + half] - faces[i] < faces[best + half] - faces[best]) best = i;
  }
  const double width = static_cast<double>(faces[best + half]) - faces[best];
  if (width > 0.1 * range) return std::nullopt;
  return Background{quantile(std::span(faces).subspan(best, half + 1), 0.5), width / 1.35};
}

// Otsu's threshold: where two classes differ most between, least within [Otsu 1979].
double best_split(std::span<const float> rising, double lo, double hi) {
  constexpr int kBins = 256;
  std::array<double, kBins> counts{};
  for (const float value : rising) {
    const double place = (value - lo) / (hi - lo) * kBins;
    counts[static_cast<std::size_t>(std::clamp(static_cast<int>(place), 0, kBins - 1))] += 1;
  }
  double total = 0;
  double moment = 0;
  for (int i = 0; i < kBins; ++i) {
    total += counts[static_cast<std::size_t>(i)];
    moment += (i + 0.5) * counts[static_cast<std::size_t>(i)];
  }
  double below = 0;
  double moment_below = 0;
  double best = -1;
  int first_best = 0;
  int last_best = kBins;
  for (int i = 0; i + 1 < kBins; ++i) {
    below += counts[static_cast<std::size_t>(i)];
    moment_below += (i + 0.5) * counts[static_cast<std::size_t>(i)];
    if (below == 0 || below == total) continue;
    const double difference = moment_below / below - (moment - moment_below) / (total - below);
    const double between = below * (total - below) * difference * difference;
    // Between two separate classes all splits are as good: the middle one is the least surprising.
    if (between > best * (1.0 + 1e-9)) first_best = i + 1;
    if (between >= best * (1.0 - 1e-9)) last_best = i + 1;
    best = std::max(best, between);
  }
  return lo + 0.5 * (first_best + last_best) / kBins * (hi - lo);
}

// One side of a background: where it ends, where the dense part begins, and the end of the range.
struct Layers {
  double start, dense, end;
};

// Of distances from the background, rising; empty if nothing stands out.
// `nearest`: the distance of the material next to the background, infinite if none was found.
std::optional<Layers> layers_of(std::span<const float> distances, double spread, double nearest) {
  if (distances.empty() || !(distances.back() > 0)) return std::nullopt;
  const double far = quantile(distances, 0.9999);
  // Noise stays below this; but what it half hides is not given up for its sake.
  const double start = std::max(std::min(5.0 * spread, 0.75 * nearest), 0.04 * far);
  const auto first =
      std::upper_bound(distances.begin(), distances.end(), static_cast<float>(start));
  const auto standing_out = distances.subspan(static_cast<std::size_t>(first - distances.begin()));
  if (standing_out.size() < 4) return std::nullopt;
  const double end = quantile(standing_out, 0.998);
  if (!(end > start)) return std::nullopt;
  const double dense = best_split(standing_out, start, end);
  // A surface lies half-way up to what it encloses; below a third there is only its blur.
  const auto first_dense =
      std::lower_bound(standing_out.begin(), standing_out.end(), static_cast<float>(dense));
  const auto thin = standing_out.first(
      std::max<std::size_t>(1, static_cast<std::size_t>(first_dense - standing_out.begin())));
  return Layers{std::max(start, 0.35 * quantile(thin, 0.5)), dense, end};
}

void add_layers(std::vector<OpacityPoint>& points, double background, double sign,
                const Layers& layers, const Depths& depths, double softness) {
  const double thin = opacity_for_half_depth(depths.thin);
  const double solid = opacity_for_half_depth(depths.solid);
  const double slope = std::lerp(0.15, 0.4, softness) * (layers.end - layers.start);
  const auto at = [&](double distance, double opacity) {
    points.push_back({.x = background + sign * distance, .opacity = opacity});
  };
  const double thin_end =
      std::max(layers.dense - slope, layers.start + 0.5 * (layers.dense - layers.start));
  at(layers.start, 0.0);
  at(layers.start + std::lerp(0.5, 1.0, softness) * (thin_end - layers.start), thin);
  at(thin_end, thin);
  at(std::min(layers.dense + slope, layers.end), solid);
}

bool is_about_zero(const Background& background, const Layers& up, const Layers& down) {
  constexpr double kOff = 0.05;
  return std::abs(background.value) < kOff * (up.end + down.end);
}

// How far the nearest material lies from the background, on the side of `sign`. The background
// itself may be one of them, a little off where noise was cut at zero.
double nearest_material(const Materials& materials, const Background& background, double sign) {
  const auto distance = [&](double value) { return sign * (value - background.value); };
  const auto itself = std::min_element(
      materials.values.begin(), materials.values.end(),
      [&](double a, double b) { return std::abs(distance(a)) < std::abs(distance(b)); });
  double nearest = std::numeric_limits<double>::infinity();
  for (auto i = materials.values.begin(); i != materials.values.end(); ++i) {
    if (i != itself && distance(*i) > 0) nearest = std::min(nearest, distance(*i));
  }
  return nearest;
}

// Vessels through what lies around them: half of the light comes through half of that.
Look vessel_look(const LatticeField& field, const Background& background,
                 const view::Vessels& vessels, double noise) {
  Look look;
  view::set_vessel_colors(look, vessels.tissue, vessels.wall, vessels.bright);
  set_light(look, 3 * noise);
  const Depths depths = depths_of(field, 0);
  const double haze = opacity_for_half_depth(25 * depths.thin);
  const auto between = [](double lo, double hi) { return std::lerp(lo, hi, 0.5); };
  look.transfer_function.opacities = {{.x = between(background.value, vessels.tissue)},
                                      {.x = vessels.tissue, .opacity = haze},
                                      {.x = between(vessels.tissue, vessels.wall), .opacity = haze},
                                      {.x = between(vessels.wall, vessels.bright),
                                       .opacity = opacity_for_half_depth(depths.solid)}};
  return look;
}

std::optional<Look> object_look(const LatticeField& field, const FieldSamples& samples,
                                const Background& background, const Slopes& slopes) {
  std::vector<float> above;
  std::vector<float> below;
  for (const float value : samples.values) {
    const auto distance = static_cast<float>(value - background.value);
    (distance >= 0 ? above : below).push_back(std::abs(distance));
  }
  std::reverse(below.begin(), below.end());
  auto up = layers_of(above, background.spread, nearest_material(slopes.materials, background, 1));
  auto down =
      layers_of(below, background.spread, nearest_material(slopes.materials, background, -1));
  // A side that reaches less than a tenth as far is noise or ringing.
  if (up && down && down->end < 0.1 * up->end) down.reset();
  if (up && down && up->end < 0.1 * down->end) up.reset();
  // Two signs are about zero. Of a gray background what is brighter is meant, if it is much at all.
  if (up && down && !is_about_zero(background, *up, *down)) {
    (up->end < 0.3 * down->end ? up : down).reset();
  }
  Look look;
  if (!up && !down) return std::nullopt;
  const Depths depths = depths_of(field, slopes.materials.noisiness);
  const double lo = down ? background.value - down->end : background.value + up->start;
  const double hi = up ? background.value + up->end : background.value - down->start;
  if (up && down) {
    set_two_sided_colors(look, lo, hi);
  } else {
    set_map(look, samples, lo, hi, slopes.materials.values);
  }
  set_light(
      look,
      std::max(3 * background.spread, 2 * slopes.materials.noise * slopes.materials.noisiness),
      slopes.materials.noisiness);
  auto& points = look.transfer_function.opacities;
  if (down) add_layers(points, background.value, -1.0, *down, depths, slopes.materials.noisiness);
  std::reverse(points.begin(), points.end());
  if (up) add_layers(points, background.value, 1.0, *up, depths, slopes.materials.noisiness);
  return look;
}

// --- what fills its box

std::optional<Look> filled_look(const LatticeField& field, const FieldSamples& samples,
                                const Slopes& slopes) {
  // Half of the samples are the background of the rest, and need no colours. Where as many are
  // equal, the least of the rest may be that value, too.
  const double hi = quantile(samples.values, 0.999);
  const double median = quantile(samples.values, 0.5);
  const double lo = median < hi ? median : quantile(samples.values, 0.001);
  if (!(lo < hi)) return std::nullopt;
  Look look;
  set_map(look, samples, lo, hi, {});  // peaks of waves are no materials
  set_light(look, 2 * slopes.materials.noise * slopes.materials.noisiness,
            slopes.materials.noisiness);
  if (slopes.is_ramp) {
    // It has no surface: light would darken it by where it comes from. Even light leaves a lit
    // surface's mean.
    set_light(look, hi - lo, 1);
    look.material.diffuse = 0.6;
  }
  const Depths depths = depths_of(field, slopes.materials.noisiness);
  auto& points = look.transfer_function.opacities;
  const std::pair<double, double> by_quantile[] = {
      {0.5, 0.0},
      {0.8, opacity_for_half_depth(4 * depths.thin)},
      {0.95, opacity_for_half_depth(depths.thin)},
      {0.998, opacity_for_half_depth(2 * depths.solid)}};
  for (const auto& [q, opacity] : by_quantile) {
    const double x = quantile(samples.values, q);
    if (!points.empty() && x <= points.back().x) continue;
    points.push_back({.x = x, .opacity = opacity});
  }
  return look;
}

std::optional<Look> layered_look(const LatticeField& field, const FieldSamples& samples,
                                 const Slopes& slopes) {
  if (const auto background = background_of(samples)) {
    if (const auto vessels = view::find_vessels(field.samples(), slopes.materials,
                                                background->value, samples.values))
      return vessel_look(field, *background, *vessels, slopes.materials.noise);
    return object_look(field, samples, *background, slopes);
  }
  return filled_look(field, samples, slopes);
}

// --- densities over decades

// Positive values of which a few are thousands of times the median, while the least are not far
// below it: densities of clusters do so. Where values fade away to nothing, as an orbital's do, a
// logarithm would show the fading.
bool asks_for_a_logarithm(const FieldSamples& samples) {
  const double least = quantile(samples.values, 0.01);
  const double median = quantile(samples.values, 0.5);
  return least > 0 && samples.values.front() > 0 && median < 100 * least &&
         quantile(samples.values, 0.9999) > kLogQuotient * median;
}

FieldSamples logarithms(FieldSamples samples) {
  for (std::vector<float>* values : {&samples.values, &samples.on_faces})
    for (float& value : *values) value = std::log10(value);
  return samples;
}

// From a look of logarithms to one of values.
void raise_to_values(TransferFunction& tf) {
  tf.scale = ValueScale::kLog;
  for (ColorPoint& point : tf.colors) point.x = std::pow(10.0, point.x);
  for (OpacityPoint& point : tf.opacities) point.x = std::pow(10.0, point.x);
}

// A look of samples that are neither labels nor scans.
Look look_of_values(const LatticeField& field, const FieldSamples& samples) {
  const bool is_logarithmic = asks_for_a_logarithm(samples);
  std::optional<Look> look = is_logarithmic ? layered_look(field, logarithms(samples), {})
                                            : layered_look(field, samples, slopes_of(field));
  if (look && is_logarithmic) raise_to_values(look->transfer_function);
  return look ? *look : ramp_look(field.value_range());
}

bool says_nothing(const FieldSamples& samples) {
  return samples.values.size() < 16 || samples.values.front() == samples.values.back();
}

Look look_of_lattice(const LatticeField& field, std::string_view unit) {
  const FieldSamples samples = data::take_samples(field.samples());
  if (says_nothing(samples)) return ramp_look(field.value_range());
  if (const std::vector<int> labels = data::labels_of(field.samples()); !labels.empty())
    return view::label_look(labels, samples);
  if (const auto water = water_of(samples, unit)) return hounsfield_look(field, *water);
  return look_of_values(field, samples);
}

// Volume that the kernels fill, at most that of their box.
double filled_volume(const KernelField& field) {
  const KernelSource& source = field.source();
  double volume = 0;
  for (std::int64_t b = 0; b < source.num_bricks(); ++b) {
    const KernelBrick& brick = source.brick(b);
    const double least = brick.least_sigma;
    const double greatest = brick.greatest_sigma;
    volume += 8 * std::sqrt(std::pow(least * greatest, 3)) * brick.count;
  }
  return std::min(volume, field.world_bounds().volume());
}

bool fills_box(const KernelField& field) {
  return filled_volume(field) > 0.9 * field.world_bounds().volume();
}

// Edge, in sheets, of a cube as large as what the kernels fill: a thin wall has little of it.
double filled_edge(const KernelField& field) {
  return std::max(2.0, std::cbrt(filled_volume(field)) / field.default_sampling_distance());
}

// Share of what particles fill that lies above a quantile of their densities: a particle of a mass
// like the others' fills a volume like one over its density.
double share_above(std::span<const float> rising, double q) {
  const auto first = static_cast<std::size_t>(q * static_cast<double>(rising.size() - 1));
  double all = 0;
  double above = 0;
  for (std::size_t i = 0; i < rising.size(); ++i) {
    const double volume = rising[i] > 0 ? 1.0 / static_cast<double>(rising[i]) : 0.0;
    all += volume;
    if (i >= first) above += volume;
  }
  return all > 0 ? above / all : 1.0;
}

// Shares of the edge of what is filled at which half of the light is through, by the quantile of
// the values there; 0: transparent.
struct DepthAt {
  double quantile, share_of_edge;
};

// Meshes of a shape of their own: from haze to solid.
constexpr DepthAt kShapeDepths[] = {
    {0.02, 0.5}, {0.3, 0.25}, {0.7, 0.1}, {0.95, 0.03}, {0.999, 0.012}};
// What fills its box, as adaptive grids do: half of it is the background of the rest.
constexpr DepthAt kBoxDepths[] = {{0.1, 0}, {0.5, 0.3}, {0.8, 0.08}, {0.95, 0.03}, {0.999, 0.012}};
// Sums fade out at their low end, where they are mostly space.
constexpr DepthAt kSumDepths[] = {{0.02, 0}, {0.3, 0.9}, {0.7, 0.3}, {0.95, 0.05}, {0.999, 0.012}};

// Half by value, half by rank: where most values are alike, colours still tell them apart.
void spread_by_rank(TransferFunction& tf, std::span<const float> rising, double q_lo, double q_hi) {
  const double lo = tf.lo();
  const double hi = tf.hi();
  for (ColorPoint& point : tf.colors) {
    const double share = (point.x - lo) / (hi - lo);
    const double by_rank = quantile(rising, std::lerp(q_lo, q_hi, share));
    point.x = std::clamp(0.5 * (point.x + by_rank), lo, hi);
  }
}

// Kernels are where something is, so nothing but sums has a background. Depths go by how much of
// the field lies above.
Look look_of_quantiles(const KernelField& field, const FieldSamples& samples,
                       const FieldSamples& scaled) {
  const double edge = filled_edge(field);
  const bool is_sum = field.reconstruction() == Reconstruction::kSum;
  const double q_lo = is_sum ? 0.1 : 0.002;
  constexpr double kHighest = 0.998;
  const double lo = quantile(scaled.values, q_lo);
  const double hi = quantile(scaled.values, kHighest);
  Look look;
  std::span<const DepthAt> depths = kShapeDepths;
  if (is_sum) {
    set_glowing_colors(look, lo, hi);
    depths = kSumDepths;
  } else if (fills_box(field)) {
    set_glowing_colors(look, lo, hi);
    depths = kBoxDepths;
  } else {
    set_bright_colors(look, lo, hi);
  }
  spread_by_rank(look.transfer_function, scaled.values, q_lo, kHighest);
  auto& points = look.transfer_function.opacities;
  for (const auto& [q, share_of_edge] : depths) {
    const double x = quantile(scaled.values, q);
    if (!points.empty() && x <= points.back().x) continue;
    const double there = is_sum ? edge * std::cbrt(share_above(samples.values, q)) : edge;
    // What few samples reach is solid within one or two.
    const double opacity =
        share_of_edge > 0 ? opacity_for_half_depth(std::max(0.5, share_of_edge * there)) : 0.0;
    points.push_back({.x = x, .opacity = opacity});
  }
  return look;
}

Look look_of_kernel_values(const KernelField& field, const FieldSamples& samples) {
  if (says_nothing(samples) || !(quantile(samples.values, 0.002) < quantile(samples.values, 0.998)))
    return ramp_look(field.value_range());
  // Densities of particles span decades whenever they cluster at all.
  const bool is_logarithmic =
      asks_for_a_logarithm(samples) ||
      (samples.values.front() > 0 &&
       quantile(samples.values, 0.98) > 30 * quantile(samples.values, 0.02));
  Look look = look_of_quantiles(field, samples, is_logarithmic ? logarithms(samples) : samples);
  if (is_logarithmic) raise_to_values(look.transfer_function);
  return look;
}

// Sums of kernels of both signs swing a little about 0 where there is nothing. Without the values
// that are no greater than the least one is below 0.
FieldSamples without_swing(const KernelField& field, FieldSamples samples) {
  constexpr float kMostOfGreatest = 0.2F;
  if (field.reconstruction() != Reconstruction::kSum || samples.values.empty()) return samples;
  const float swing = -samples.values.front();
  if (!(swing > 0) || swing > kMostOfGreatest * samples.values.back()) return samples;
  const auto end = std::upper_bound(samples.values.begin(), samples.values.end(), swing);
  samples.values.erase(samples.values.begin(), end);
  return samples;
}

// Where another attribute gives the colour, colours span its range.
Look look_of_kernels(const KernelField& field) {
  Look look = look_of_kernel_values(field, without_swing(field, view::take_samples(field)));
  if (field.has_own_color()) {
    Look colors = ramp_look(field.color_range());
    TransferFunction& tf = colors.transfer_function;
    set_bright_colors(colors, tf.lo(), tf.hi());
    look.color_function = tf;
  }
  return look;
}

}  // namespace

std::optional<double> value_of_water(const Field& field, std::string_view unit) {
  data::require_field(field);
  if (field.lattice() == nullptr) return std::nullopt;
  const FieldSamples samples = data::take_samples(field.lattice()->samples());
  return says_nothing(samples) ? std::nullopt : water_of(samples, unit);
}

std::optional<std::pair<double, double>> air_and_bone(const Field& field) {
  data::require_field(field);
  if (field.lattice() == nullptr) return std::nullopt;
  const FieldSamples samples = data::take_samples(field.lattice()->samples());
  if (says_nothing(samples)) return std::nullopt;
  const auto background = background_of(samples);
  const double bone = quantile(samples.values, 0.999);
  if (!background || !(background->value < bone)) return std::nullopt;
  return std::pair(background->value, bone);
}

Materials materials_of(const Field& field) {
  data::require_field(field);
  if (field.lattice() == nullptr) return {};
  return view::find_materials(data::take_rises(field.lattice()->samples()));
}

bool holds_labels(const Field& field) {
  data::require_field(field);
  return field.lattice() != nullptr && !data::labels_of(field.lattice()->samples()).empty();
}

Look default_look(const Field& field, std::string_view unit) {
  data::require_field(field);
  Look look = field.lattice() != nullptr ? look_of_lattice(*field.lattice(), unit)
                                         : look_of_kernels(*field.kernels());
  if (look.light != Light::kStudio) set_light(look);
  return look;
}

}  // namespace ovoid
