// SPDX-License-Identifier: Apache-2.0
#include "region_plane.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ovoid::viewer {
namespace {

constexpr double kLeastShare = 0.005;  // of the axes, a side of a region that is dragged

// The power of ten that is no more than a thousandth of a span: less than a pixel.
double step_of(double span) { return std::pow(10.0, std::floor(std::log10(span / 1000))); }

// Near 0 a quotient of powers of ten would leave digits that nobody has put there.
double rounded(double x, double span) {
  const double step = step_of(span);
  if (!std::isnormal(step) || std::abs(x) / step > 1e15) return x;
  return step < 1 ? std::round(x / step) / std::round(1 / step) : std::round(x / step) * step;
}

bool is_left(Grip grip) {
  return grip == Grip::kLeft || grip == Grip::kBottomLeft || grip == Grip::kTopLeft;
}
bool is_right(Grip grip) {
  return grip == Grip::kRight || grip == Grip::kBottomRight || grip == Grip::kTopRight;
}
bool is_bottom(Grip grip) {
  return grip == Grip::kBottom || grip == Grip::kBottomLeft || grip == Grip::kBottomRight;
}
bool is_top(Grip grip) {
  return grip == Grip::kTop || grip == Grip::kTopLeft || grip == Grip::kTopRight;
}

// One of two ends by so much, within lo and hi and on its side of the other one.
void move_end(std::array<double, 2>& ends, bool is_upper, double by, double lo, double hi) {
  if (by == 0) return;
  const double span = hi - lo;
  const double least = std::min(kLeastShare * span, ends[1] - ends[0]);
  double& end = ends[is_upper ? 1 : 0];
  const double wanted = rounded(end + by, span);
  const double from = is_upper ? ends[0] + least : lo;
  const double to = is_upper ? hi : ends[1] - least;
  end = std::clamp(wanted, std::min(from, end), std::max(to, end));
}

// Both ends by so much, which is less where they would leave lo and hi. As wide as before but for
// rounding.
void move_both(std::array<double, 2>& ends, double by, double lo, double hi) {
  const double span = hi - lo;
  const double within = std::clamp(by, std::min(lo - ends[0], 0.0), std::max(hi - ends[1], 0.0));
  if (within == 0) return;
  const std::array<double, 2> moved = {std::clamp(rounded(ends[0] + within, span), lo, hi),
                                       std::clamp(rounded(ends[1] + within, span), lo, hi)};
  if (moved[0] < moved[1]) ends = moved;
}

double half_width_share(const LookRegion& region) {
  return region.shape == LookRegion::Shape::kBox ? region.foot : 1;
}

bool is_in(const LookRegion& region, const PlanePoint& at) {
  const double middle = (region.values[0] + region.values[1]) / 2;
  const double half = (region.values[1] - region.values[0]) / 2;
  const double up =
      (at.gradient - region.gradients[0]) / (region.gradients[1] - region.gradients[0]);
  if (up < 0 || up > 1) return false;
  return std::abs(at.value - middle) <= half * std::lerp(half_width_share(region), 1.0, up);
}

// The steep part of what was counted at each value: by the logarithm, so that a small boundary is
// not nothing beside a large one, times how steep it is.
std::vector<double> steepness_by_value(const cli::Histogram2D& histogram, std::size_t first_row) {
  constexpr std::size_t kColumns = cli::Histogram2D::kColumns;
  constexpr std::size_t kHalf = 9;  // of the window that smooths it
  std::vector<double> raw(kColumns);
  for (std::size_t row = first_row; row < cli::Histogram2D::kRows; ++row) {
    for (std::size_t i = 0; i < kColumns; ++i)
      raw[i] += static_cast<double>(row) * std::log1p(histogram.counts[row * kColumns + i]);
  }
  std::vector<double> smooth(kColumns);
  for (std::size_t i = 0; i < kColumns; ++i) {
    for (std::size_t k = i < kHalf ? 0 : i - kHalf; k <= std::min(i + kHalf, kColumns - 1); ++k) {
      const double away = std::abs(static_cast<double>(k) - static_cast<double>(i));
      smooth[i] += (1 + std::cos(std::numbers::pi * away / (kHalf + 1))) * raw[k];
    }
  }
  return smooth;
}

// As far to both sides of the peak as it is half as much.
std::array<std::size_t, 2> columns_of_peak(const std::vector<double>& steepness) {
  const auto peak = std::max_element(steepness.begin(), steepness.end());
  auto first = peak;
  auto last = peak;
  while (first != steepness.begin() && *std::prev(first) > *peak / 2) --first;
  while (std::next(last) != steepness.end() && *std::next(last) > *peak / 2) ++last;
  return {static_cast<std::size_t>(first - steepness.begin()),
          static_cast<std::size_t>(last - steepness.begin())};
}

// The row from `first_row` on below which half of what was counted in the columns lies.
std::size_t median_row(const cli::Histogram2D& histogram, const std::array<std::size_t, 2>& columns,
                       std::size_t first_row) {
  constexpr std::size_t kRows = cli::Histogram2D::kRows;
  std::array<double, kRows> sums{};  // of this row and those below
  double sum = 0;
  for (std::size_t row = first_row; row < kRows; ++row) {
    for (std::size_t i = columns[0]; i <= columns[1]; ++i)
      sum += histogram.counts[row * cli::Histogram2D::kColumns + i];
    sums[row] = sum;
  }
  std::size_t middle = first_row;
  while (middle + 1 < kRows && 2 * sums[middle] < sum) ++middle;
  return middle;
}

}  // namespace

PlaneAxes plane_axes(const cli::Histogram2D* histogram, const TransferFunction2D* function,
                     const ValueRange& range) {
  PlaneAxes axes;
  if (histogram != nullptr) {
    axes = {histogram->value_lo, histogram->value_hi, histogram->gradient_hi};
  } else if (function != nullptr) {
    axes = {function->values().first, function->values().last, function->gradients().last};
  } else if (!range.is_empty()) {
    axes.value_lo = range.lo;
    axes.value_hi = range.hi;
  }
  if (!(axes.value_lo < axes.value_hi)) axes.value_hi = axes.value_lo + 1;
  if (function == nullptr) return axes;
  const auto& regions = function->regions();
  double lo = regions.empty() ? function->values().first : HUGE_VAL;
  double hi = regions.empty() ? function->values().last : -HUGE_VAL;
  double top = regions.empty() ? function->gradients().last : 0;
  for (const LookRegion& region : regions) {  // whose table is a little wider
    lo = std::min(lo, region.values[0]);
    hi = std::max(hi, region.values[1]);
    top = std::max(top, region.gradients[1]);
  }
  const double span = axes.value_hi - axes.value_lo;
  const double more = (kBeyond - 1) / 2 * span;
  const PlaneAxes counted = axes;
  axes.value_lo = std::min(axes.value_lo, std::max(lo, counted.value_lo - more));
  axes.value_hi = std::max(axes.value_hi, std::min(hi, counted.value_hi + more));
  axes.gradient_hi = std::max(axes.gradient_hi, std::min(top, kBeyond * counted.gradient_hi));
  return axes;
}

double PlaneCanvas::x_of(double value) const {
  return x0 + (value - axes.value_lo) / (axes.value_hi - axes.value_lo) * (x1 - x0);
}
double PlaneCanvas::y_of(double gradient) const {
  return y1 - gradient / axes.gradient_hi * (y1 - y0);
}
PlanePoint PlaneCanvas::at(double x, double y) const {
  return {axes.value_lo + (x - x0) / (x1 - x0) * (axes.value_hi - axes.value_lo),
          (y1 - y) / (y1 - y0) * axes.gradient_hi};
}

const char* name_of(Grip grip) {
  constexpr std::array kNames = {"none",     "body",      "left",        "right",
                                 "bottom",   "top",       "bottom-left", "bottom-right",
                                 "top-left", "top-right", "left-foot",   "right-foot"};
  static_assert(kNames.size() == static_cast<std::size_t>(Grip::kRightFoot) + 1);
  return kNames[static_cast<std::size_t>(grip)];
}

std::vector<Grip> grips_of(const LookRegion& region) {
  std::vector<Grip> grips = {Grip::kBottomLeft, Grip::kBottomRight, Grip::kTopLeft, Grip::kTopRight,
                             Grip::kLeft,       Grip::kRight,       Grip::kBottom,  Grip::kTop};
  if (region.shape == LookRegion::Shape::kBox)
    grips.insert(grips.begin(), {Grip::kLeftFoot, Grip::kRightFoot});
  return grips;
}

PlanePlace place_of(const LookRegion& region, Grip grip, const PlaneCanvas& canvas, double below) {
  const double left = canvas.x_of(region.values[0]);
  const double right = canvas.x_of(region.values[1]);
  const double bottom = canvas.y_of(region.gradients[0]);
  const double top = canvas.y_of(region.gradients[1]);
  const double half = (right - left) / 2;
  PlanePlace place{left + half, (bottom + top) / 2};
  if (is_left(grip)) place.x = left;
  if (is_right(grip)) place.x = right;
  if (is_bottom(grip)) place.y = bottom;
  if (is_top(grip)) place.y = top;
  if (grip == Grip::kLeftFoot || grip == Grip::kRightFoot) {
    place.x += (grip == Grip::kLeftFoot ? -half : half) * region.foot;
    place.y = bottom + below;
  }
  // On the side of a trapezoid.
  if (grip == Grip::kLeft || grip == Grip::kRight)
    place.x = left + half +
              (grip == Grip::kLeft ? -half : half) * std::lerp(half_width_share(region), 1.0, 0.5);
  return place;
}

std::array<PlanePlace, 4> outline_of(const LookRegion& region, const PlaneCanvas& canvas) {
  const double left = canvas.x_of(region.values[0]);
  const double right = canvas.x_of(region.values[1]);
  const double middle = (left + right) / 2;
  const double foot = half_width_share(region) * (right - left) / 2;
  const double bottom = canvas.y_of(region.gradients[0]);
  const double top = canvas.y_of(region.gradients[1]);
  return {{{middle - foot, bottom}, {middle + foot, bottom}, {right, top}, {left, top}}};
}

RegionHit region_under(std::span<const LookRegion> regions, const PlaneCanvas& canvas,
                       const PlanePlace& mouse, int selected, const Reach& reach) {
  const PlanePoint at = canvas.at(mouse.x, mouse.y);
  if (selected >= 0 && selected < static_cast<int>(regions.size())) {
    const LookRegion& region = regions[static_cast<std::size_t>(selected)];
    Grip nearest = Grip::kNone;
    double least = reach.grip;
    for (const Grip grip : grips_of(region)) {
      const PlanePlace place = place_of(region, grip, canvas, reach.below);
      const double distance = std::hypot(place.x - mouse.x, place.y - mouse.y);
      if (distance >= least) continue;
      least = distance;
      nearest = grip;
    }
    if (nearest != Grip::kNone) return {selected, nearest};
    if (is_in(region, at)) return {selected, Grip::kBody};
  }
  for (int i = static_cast<int>(regions.size()) - 1; i >= 0; --i) {
    if (is_in(regions[static_cast<std::size_t>(i)], at)) return {i, Grip::kBody};
  }
  return {};
}

LookRegion moved_region(const LookRegion& region, Grip grip, const PlanePoint& from,
                        const PlanePoint& to, const PlaneAxes& axes) {
  LookRegion moved = region;
  const double lo = std::min(axes.value_lo, region.values[0]);
  const double hi = std::max(axes.value_hi, region.values[1]);
  const double top = std::max(axes.gradient_hi, region.gradients[1]);
  const double right = to.value - from.value;
  const double up = to.gradient - from.gradient;
  if (grip == Grip::kBody) {
    move_both(moved.values, right, lo, hi);
    move_both(moved.gradients, up, 0, top);
  }
  if (is_left(grip)) move_end(moved.values, false, right, lo, hi);
  if (is_right(grip)) move_end(moved.values, true, right, lo, hi);
  if (is_bottom(grip)) move_end(moved.gradients, false, up, 0, top);
  if (is_top(grip)) move_end(moved.gradients, true, up, 0, top);
  if ((grip == Grip::kLeftFoot || grip == Grip::kRightFoot) && right != 0) {
    const double outwards = grip == Grip::kLeftFoot ? -right : right;
    const double half = (region.values[1] - region.values[0]) / 2;
    moved.foot = std::clamp(std::round(100 * (region.foot + outwards / half)) / 100, 0.0, 1.0);
  }
  return moved;
}

std::optional<LookRegion> region_between(const PlanePoint& a, const PlanePoint& b,
                                         const PlaneAxes& axes) {
  constexpr double kLeast = 0.01;
  const double span = axes.value_hi - axes.value_lo;
  LookRegion region;
  const auto ends = [](double p, double q, double lo, double hi) {
    const double round_p = rounded(std::clamp(p, lo, hi), hi - lo);
    const double round_q = rounded(std::clamp(q, lo, hi), hi - lo);
    return std::array{std::max(lo, std::min(round_p, round_q)),
                      std::min(hi, std::max(round_p, round_q))};
  };
  region.values = ends(a.value, b.value, axes.value_lo, axes.value_hi);
  region.gradients = ends(a.gradient, b.gradient, 0, axes.gradient_hi);
  if (region.values[1] - region.values[0] < kLeast * span ||
      region.gradients[1] - region.gradients[0] < kLeast * axes.gradient_hi)
    return std::nullopt;
  return region;
}

LookRegion region_around(const PlanePoint& middle, const PlaneAxes& axes) {
  constexpr double kWide = 0.1, kHigh = 0.125;  // half of it, as a share of the axes
  const double wide = kWide * (axes.value_hi - axes.value_lo);
  const double high = kHigh * axes.gradient_hi;
  const double value = std::clamp(middle.value, axes.value_lo + wide, axes.value_hi - wide);
  const double gradient = std::clamp(middle.gradient, high, axes.gradient_hi - high);
  return *region_between({value - wide, gradient - high}, {value + wide, gradient + high}, axes);
}

Rgb color_for_region(std::span<const LookRegion> regions) {
  constexpr std::array<Rgb, 6> kColors = {{{0.9, 0.6, 0.4},
                                           {0.4, 0.7, 1},
                                           {0.6, 0.85, 0.4},
                                           {1, 0.85, 0.3},
                                           {0.8, 0.5, 0.9},
                                           {1, 1, 1}}};
  const auto distance = [](const Rgb& a, const Rgb& b) {
    return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
  };
  std::size_t best = 0;
  double most = -1;
  for (std::size_t i = 0; i < kColors.size(); ++i) {
    double nearest = HUGE_VAL;
    for (const LookRegion& region : regions)
      nearest = std::min(nearest, distance(region.rgb, kColors[i]));
    if (nearest <= most) continue;
    most = nearest;
    best = i;
  }
  return kColors[best];
}

LookRegion first_region(const cli::Histogram2D* histogram, const TransferFunction& look,
                        const PlaneAxes& axes) {
  constexpr std::size_t kColumns = cli::Histogram2D::kColumns;
  constexpr std::size_t kRows = cli::Histogram2D::kRows;
  constexpr std::size_t kFirstRow = kRows / 10;  // below it lies what is even
  const double span = axes.value_hi - axes.value_lo;
  const auto in_color_of_look = [&](LookRegion region) {
    region.rgb = look.color_at((region.values[0] + region.values[1]) / 2);
    for (double& part : region.rgb) part = std::round(100 * part) / 100;
    return region;
  };
  LookRegion usual;
  usual.values = {rounded(axes.value_lo + span / 2, span), rounded(axes.value_hi, span)};
  usual.gradients = {rounded(axes.gradient_hi / 4, axes.gradient_hi),
                     rounded(axes.gradient_hi, axes.gradient_hi)};
  if (histogram == nullptr) return in_color_of_look(usual);
  const std::vector<double> steepness = steepness_by_value(*histogram, kFirstRow);
  if (!(*std::max_element(steepness.begin(), steepness.end()) > 0)) return in_color_of_look(usual);
  const std::array<std::size_t, 2> columns = columns_of_peak(steepness);
  // Half of how steep the boundary is where it is as steep as mostly: below lie its two materials.
  const auto least = static_cast<double>(median_row(*histogram, columns, kFirstRow)) / 2;
  const double counted = histogram->value_hi - histogram->value_lo;
  const auto value_of = [&](std::size_t column) {
    return rounded(histogram->value_lo + counted * static_cast<double>(column) / kColumns, counted);
  };
  LookRegion region;
  region.values = {value_of(columns[0]), value_of(columns[1] + 1)};
  const double top = histogram->gradient_hi;
  region.gradients = {rounded(top * least / kRows, top), rounded(top, top)};
  return in_color_of_look(region);
}

std::vector<double> round_numbers(double lo, double hi, int most) {
  std::vector<double> numbers;
  const double least = (hi - lo) / most;
  if (!(least > 0) || !std::isfinite(least)) return numbers;
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  double step = decade;
  for (const double factor : {2.0, 5.0, 10.0}) {
    if (step < least) step = factor * decade;
  }
  if (!std::isnormal(step) || std::abs(lo) / step > 1e9) return numbers;
  const double first = std::ceil(lo / step - 1e-9);
  for (double i = first; i * step <= hi + 1e-9 * step; ++i)
    numbers.push_back(i == 0 ? 0.0 : i * step);
  return numbers;
}

}  // namespace ovoid::viewer
