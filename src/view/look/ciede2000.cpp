// SPDX-License-Identifier: Apache-2.0
// The colour space Lab/CIEDE2000. CIEDE2000 measures differences of neighbouring colours, not ways
// through a space, so the way between two colours is looked for: [Zeyen 2018] by Dijkstra's method
// on a grid of colours, every one joined to its 26 neighbours. Working back from the last colour,
// as vtkColorTransferFunction does, makes rounding, and so the choice among nearly equal ways, the
// same.
#include "view/look/ciede2000.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>
#include <utility>

#include "ovoid/error.h"
#include "view/look/color_spaces.h"
#include "view/look/value_scale.h"

namespace ovoid::view {
namespace {

constexpr int kSide = 17;  // grid colours along one component: multiples of 1/16
constexpr int kNumColors = kSide * kSide * kSide;
constexpr int kNumSteps = 27;  // to the neighbours, and one to nowhere
constexpr double kTurn = 2.0 * std::numbers::pi;

double to_radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

struct GridColor {
  int r, g, b;

  int index() const { return (r * kSide + g) * kSide + b; }
  bool is_inside() const { return std::min({r, g, b}) >= 0 && std::max({r, g, b}) < kSide; }
  GridColor stepped(int step) const {
    return {r + step / 9 - 1, g + step / 3 % 3 - 1, b + step % 3 - 1};
  }
  Rgb rgb() const {
    constexpr double kSpacing = kSide - 1;
    return {r / kSpacing, g / kSpacing, b / kSpacing};
  }
};

GridColor grid_color(int index) {
  return {index / (kSide * kSide), index / kSide % kSide, index % kSide};
}

GridColor nearest(const Rgb& rgb) {
  const auto rounded = [](double v) { return static_cast<int>(std::lround(v * (kSide - 1))); };
  return {rounded(rgb[0]), rounded(rgb[1]), rounded(rgb[2])};
}

// differences[color * kNumSteps + step]; infinity where a step leaves the grid or goes nowhere.
std::vector<double> make_differences() {
  std::vector<Rgb> lab(kNumColors);
  for (int i = 0; i < kNumColors; ++i) lab[i] = lab_from_rgb(grid_color(i).rgb());
  std::vector<double> differences(std::size_t{kNumColors} * kNumSteps,
                                  std::numeric_limits<double>::infinity());
  for (int i = 0; i < kNumColors; ++i) {
    for (int step = 0; step < kNumSteps; ++step) {
      const GridColor to = grid_color(i).stepped(step);
      if (step == kNumSteps / 2 || !to.is_inside()) continue;
      differences[i * kNumSteps + step] = ciede2000(lab[i], lab[to.index()]);
    }
  }
  return differences;
}

// next[color]: where the shortest way to `target` goes on; known along the way from `source`.
std::vector<int> shortest_ways(int source, int target) {
  static const std::vector<double> differences = make_differences();
  std::vector<double> length(kNumColors, std::numeric_limits<double>::infinity());
  std::vector<int> next(kNumColors, target);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
  length[target] = 0.0;
  front.emplace(0.0, target);
  while (!front.empty()) {
    const auto [so_far, index] = front.top();
    front.pop();
    if (index == source) break;
    if (so_far > length[index]) continue;  // reached on a shorter way since
    const GridColor color = grid_color(index);
    for (int step = 0; step < kNumSteps; ++step) {
      const double longer = so_far + differences[index * kNumSteps + step];
      if (!std::isfinite(longer)) continue;
      const int neighbor = color.stepped(step).index();
      if (longer >= length[neighbor]) continue;
      length[neighbor] = longer;
      next[neighbor] = index;
      front.emplace(longer, neighbor);
    }
  }
  return next;
}

// Chroma and hue in the plane whose a* is stretched near the gray axis.
struct Polar {
  double chroma, hue;  // hue in [0, 2 pi), 0 for a gray
};

Polar polar(const Rgb& lab, double stretch) {
  const double a = stretch * lab[1];
  const double b = lab[2];
  if (a == 0.0 && b == 0.0) return {0.0, 0.0};
  const double hue = std::atan2(b, a);
  return {std::sqrt(a * a + b * b), hue < 0.0 ? hue + kTurn : hue};
}

// How far chroma is from 25, sharply: sqrt(c^7 / (c^7 + 25^7)).
double saturation_weight(double chroma) {
  const double c7 = std::pow(chroma, 7.0);
  return std::sqrt(c7 / (c7 + std::pow(25.0, 7.0)));
}

double mean_hue(const Polar& a, const Polar& b) {
  if (a.chroma * b.chroma == 0.0) return a.hue + b.hue;  // the one that has a hue
  const double sum = a.hue + b.hue;
  if (std::abs(a.hue - b.hue) <= std::numbers::pi) return 0.5 * sum;
  return 0.5 * (sum < kTurn ? sum + kTurn : sum - kTurn);
}

double hue_change(const Polar& a, const Polar& b) {
  if (a.chroma * b.chroma == 0.0) return 0.0;
  const double change = b.hue - a.hue;
  if (change > std::numbers::pi) return change - kTurn;
  return change < -std::numbers::pi ? change + kTurn : change;
}

}  // namespace

double ciede2000(const Rgb& lab_a, const Rgb& lab_b) {
  const double mean_plain_chroma = 0.5 * (std::sqrt(lab_a[1] * lab_a[1] + lab_a[2] * lab_a[2]) +
                                          std::sqrt(lab_b[1] * lab_b[1] + lab_b[2] * lab_b[2]));
  const double stretch = 1.0 + 0.5 * (1.0 - saturation_weight(mean_plain_chroma));
  const Polar a = polar(lab_a, stretch);
  const Polar b = polar(lab_b, stretch);
  const double hue = mean_hue(a, b);
  const double chroma = 0.5 * (a.chroma + b.chroma);
  const double off_middle = std::pow(0.5 * (lab_a[0] + lab_b[0]) - 50.0, 2.0);

  const double lightness_scale = 1.0 + 0.015 * off_middle / std::sqrt(20.0 + off_middle);
  const double chroma_scale = 1.0 + 0.045 * chroma;
  const double hue_term =
      1.0 - 0.17 * std::cos(hue - to_radians(30.0)) + 0.24 * std::cos(2.0 * hue) +
      0.32 * std::cos(3.0 * hue + to_radians(6.0)) - 0.20 * std::cos(4.0 * hue - to_radians(63.0));
  const double hue_scale = 1.0 + 0.015 * chroma * hue_term;
  const double blueness = std::pow((hue - to_radians(275.0)) / to_radians(25.0), 2.0);
  const double rotation =
      -std::sin(2.0 * to_radians(30.0) * std::exp(-blueness)) * 2.0 * saturation_weight(chroma);

  const double dl = (lab_b[0] - lab_a[0]) / lightness_scale;
  const double dc = (b.chroma - a.chroma) / chroma_scale;
  const double dh =
      2.0 * std::sqrt(a.chroma * b.chroma) * std::sin(0.5 * hue_change(a, b)) / hue_scale;
  // The rotation is at most 2 in size: the form is never negative but by rounding.
  return std::sqrt(std::max(dl * dl + dc * dc + dh * dh + rotation * dc * dh, 0.0));
}

std::vector<PathColor> ciede2000_path(const Rgb& a, const Rgb& b) {
  const int source = nearest(a).index();
  const int target = nearest(b).index();
  std::vector<PathColor> path{{0.0, grid_color(source).rgb()}};
  if (source != target) {
    const std::vector<int> next = shortest_ways(source, target);
    for (int i = source; i != target; i = next[i]) {
      path.push_back({0.0, grid_color(next[i]).rgb()});
    }
  }
  double total = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    total += ciede2000(lab_from_rgb(path[i - 1].rgb), lab_from_rgb(path[i].rgb));
    path[i].s = total;
  }
  for (std::size_t i = 1; i < path.size(); ++i) path[i].s /= total;
  return path;
}

}  // namespace ovoid::view

namespace ovoid {

void follow_ciede2000(TransferFunction& tf) {
  if (tf.colors.size() > kMaxCiede2000Points) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("Lab/CIEDE2000 with {} points: must have at most {}", tf.colors.size(),
                            kMaxCiede2000Points));
  }
  std::vector<ColorPoint> points;
  for (std::size_t k = 0; k < tf.colors.size(); ++k) {
    const ColorPoint& right = tf.colors[k];
    const ColorPoint& left = tf.colors[k > 0 ? k - 1 : 0];
    if (!(left.x < right.x)) {
      points.push_back({right.x, view::ciede2000_path(right.rgb, right.rgb).back().rgb});
      continue;
    }
    const double from = view::along(tf.scale, tf.linear_width, left.x);
    const double to = view::along(tf.scale, tf.linear_width, right.x);
    const std::vector<view::PathColor> path = view::ciede2000_path(left.rgb, right.rgb);
    for (std::size_t i = 1; i < path.size(); ++i) {
      const double x = view::value_at(tf.scale, tf.linear_width, std::lerp(from, to, path[i].s));
      points.push_back({std::clamp(x, left.x, right.x), path[i].rgb});
    }
    if (path.size() > 1) {
      points.back().x = right.x;
    } else {
      points.push_back({right.x, path.back().rgb});
    }
  }
  tf.colors = std::move(points);
  tf.color_space = ColorSpace::kLab;
}

}  // namespace ovoid
