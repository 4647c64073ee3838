// SPDX-License-Identifier: Apache-2.0
#include "ovoid/transfer_function.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "ovoid/error.h"
#include "view/look/color_spaces.h"
#include "view/look/opacity_curve.h"
#include "view/look/value_scale.h"

namespace ovoid {
namespace {

// The first point beyond `value`: neighbours (it - 1, it) enclose it, and at equal x the later
// point holds from there on.
template <class Points>
auto first_beyond(const Points& points, double value) {
  return std::upper_bound(points.begin(), points.end(), value,
                          [](double v, const auto& p) { return v < p.x; });
}

// The curve between two nodes at `s` in [0, 1], shaped by the left one; docs/looks.md, "Opacity".
double shaped_opacity(const OpacityPoint& left, double y2, double s) {
  using namespace view;
  const double y1 = left.opacity;
  const double midpoint = std::clamp(left.midpoint, kMinMidpoint, kMaxMidpoint);
  s = s < midpoint ? 0.5 * s / midpoint : 0.5 + 0.5 * (s - midpoint) / (1.0 - midpoint);
  if (left.sharpness > kStepSharpness) return s < 0.5 ? y1 : y2;
  if (left.sharpness < kLinearSharpness) return (1.0 - s) * y1 + s * y2;

  const double power = 1.0 + 10.0 * left.sharpness;
  if (s < 0.5) {
    s = 0.5 * std::pow(2.0 * s, power);
  } else if (s > 0.5) {
    s = 1.0 - 0.5 * std::pow(2.0 * (1.0 - s), power);
  }
  // Cubic Hermite with one slope at both ends, which sharpness flattens.
  const double ss = s * s;
  const double sss = ss * s;
  const double slope = (1.0 - left.sharpness) * (y2 - y1);
  const double y = (2.0 * sss - 3.0 * ss + 1.0) * y1 + (3.0 * ss - 2.0 * sss) * y2 +
                   (sss - 2.0 * ss + s) * slope + (sss - ss) * slope;
  return std::clamp(y, std::min(y1, y2), std::max(y1, y2));
}

template <class Point>
bool is_before(const Point& a, const Point& b) {
  // NaN after everything, so that the order stays a strict one whatever is in the points.
  return a.x < b.x || (std::isnan(b.x) && !std::isnan(a.x));
}

// How much of the way from lo < hi lies before `value`, along the scale; in [0, 1] for values
// between the two.
double fraction(const TransferFunction& tf, double lo, double hi, double value) {
  if (tf.scale == ValueScale::kLinear) return (value - lo) / (hi - lo);
  const auto g = [&](double x) { return view::along(tf.scale, tf.linear_width, x); };
  const double from = g(lo);
  const double width = g(hi) - from;
  // Neighbouring doubles can have one logarithm, and logarithms round.
  return width > 0.0 ? std::clamp((g(value) - from) / width, 0.0, 1.0) : 0.0;
}

void require_range(double lo, double hi, ValueScale scale) {
  if (!(lo < hi) || !std::isfinite(lo) || !std::isfinite(hi)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("range = {}, {}: must be two finite values, the lower first", lo, hi));
  }
  if (scale == ValueScale::kLog && !(lo > 0.0)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("range = {}, {}: must be > 0 on a logarithmic scale", lo, hi));
  }
}

}  // namespace

Rgb TransferFunction::color_at(double value) const {
  if (std::isnan(value)) return nan_color;
  const double first = colors.empty() ? 0.0 : colors.front().x;
  const double last = colors.empty() ? 1.0 : colors.back().x;
  if (below_color && value < first) return *below_color;
  if (above_color && value > last) return *above_color;
  if (colors.empty()) {
    const double gray = std::clamp(value, 0.0, 1.0);
    return {gray, gray, gray};
  }
  const auto right = first_beyond(colors, value);
  if (right == colors.begin()) return colors.front().rgb;
  if (right == colors.end()) return colors.back().rgb;
  const ColorPoint& left = right[-1];
  return view::interpolate(color_space, left.rgb, right->rgb,
                           fraction(*this, left.x, right->x, value));
}

double TransferFunction::opacity_at(double value) const {
  if (std::isnan(value)) return 0.0;
  if (opacities.empty()) return 1.0;
  const auto right = first_beyond(opacities, value);
  if (right == opacities.begin()) return opacities.front().opacity;
  if (right == opacities.end()) return opacities.back().opacity;
  const OpacityPoint& left = right[-1];
  return shaped_opacity(left, right->opacity, fraction(*this, left.x, right->x, value));
}

double TransferFunction::lo() const {
  double least = std::numeric_limits<double>::infinity();
  for (const ColorPoint& p : colors) least = std::min(least, p.x);
  for (const OpacityPoint& p : opacities) least = std::min(least, p.x);
  return colors.empty() && opacities.empty() ? 0.0 : least;
}

double TransferFunction::hi() const {
  double greatest = -std::numeric_limits<double>::infinity();
  for (const ColorPoint& p : colors) greatest = std::max(greatest, p.x);
  for (const OpacityPoint& p : opacities) greatest = std::max(greatest, p.x);
  return colors.empty() && opacities.empty() ? 1.0 : greatest;
}

void TransferFunction::map_range(double new_lo, double new_hi) {
  map_range(new_lo, new_hi, scale, linear_width);
}

void TransferFunction::map_range(double new_lo, double new_hi, ValueScale new_scale,
                                 double new_linear_width) {
  require_range(new_lo, new_hi, new_scale);
  if (new_scale == ValueScale::kSymlog &&
      (!(new_linear_width > 0.0) || !std::isfinite(new_linear_width))) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("linear_width = {}: must be finite and > 0", new_linear_width));
  }
  const double old_lo = lo();
  const double old_hi = hi();
  if (old_lo < old_hi) require_range(old_lo, old_hi, scale);
  if (colors.empty()) colors = {{0.0, {0, 0, 0}}, {1.0, {1, 1, 1}}};
  const bool is_same_scale =
      scale == new_scale && (scale != ValueScale::kSymlog || linear_width == new_linear_width);
  if (old_lo == new_lo && old_hi == new_hi && is_same_scale) return;

  TransferFunction old;
  old.scale = scale;
  old.linear_width = linear_width;
  const double from = view::along(new_scale, new_linear_width, new_lo);
  const double to = view::along(new_scale, new_linear_width, new_hi);
  // Monotonic and exact at both ends: steps stay steps, and the ends land on the range.
  const auto moved = [&](double x) {
    if (!(old_lo < old_hi)) {
      return view::value_at(new_scale, new_linear_width, std::midpoint(from, to));
    }
    if (x == old_lo) return new_lo;
    if (x == old_hi) return new_hi;
    const double place = std::lerp(from, to, fraction(old, old_lo, old_hi, x));
    const double value = view::value_at(new_scale, new_linear_width, place);
    // The gray ramp may reach beyond the span, where a logarithm has no room below.
    if (x < old_lo || x > old_hi)
      return new_scale == ValueScale::kLog ? std::max(value, new_lo) : value;
    return std::clamp(value, new_lo, new_hi);
  };
  for (ColorPoint& p : colors) p.x = moved(p.x);
  for (OpacityPoint& p : opacities) p.x = moved(p.x);
  scale = new_scale;
  linear_width = new_linear_width;
}

void TransferFunction::sort() {
  std::stable_sort(colors.begin(), colors.end(), is_before<ColorPoint>);
  std::stable_sort(opacities.begin(), opacities.end(), is_before<OpacityPoint>);
  std::stable_sort(gradient_opacities.begin(), gradient_opacities.end(), is_before<OpacityPoint>);
}

}  // namespace ovoid
