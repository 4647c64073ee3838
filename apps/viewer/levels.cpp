// SPDX-License-Identifier: Apache-2.0
#include "levels.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ovoid::viewer {
namespace {

constexpr int kCoarsestPixels = 4;
constexpr double kTolerance = 4.0 / 3.0;

int log2_of(int pixels) {
  int log = 0;
  while (pixels > 1) {
    pixels /= 2;
    ++log;
  }
  return log;
}

int distance(const Level& a, const Level& b) {
  return std::abs(log2_of(a.pixels) - log2_of(b.pixels)) + 2 * std::abs(a.field - b.field);
}

}  // namespace

void LevelChooser::set_scales(double pixel, double spacing, int coarsest_field) {
  levels_.clear();
  for (int pixels = 1; pixels <= kCoarsestPixels; pixels *= 2) {
    for (int field = 0; field <= coarsest_field; ++field) levels_.push_back({pixels, field});
  }
  const auto blur = [&](const Level& level) {
    return std::hypot(pixel * level.pixels, spacing * std::exp2(level.field));
  };
  std::stable_sort(levels_.begin(), levels_.end(),
                   [&](const Level& a, const Level& b) { return blur(a) < blur(b); });
}

void LevelChooser::forget() { measured_.clear(); }

void LevelChooser::measured(const Level& level, const FrameCost& cost) {
  const auto known = std::find_if(measured_.begin(), measured_.end(),
                                  [&](const Measured& other) { return other.level == level; });
  if (known == measured_.end()) {
    measured_.push_back({level, cost});
    return;
  }
  const double change = cost.total_ms() / std::max(known->cost.total_ms(), 1e-3);
  known->cost = cost;
  for (Measured& other : measured_) {
    if (other.level == level) continue;
    other.cost.kernels_ms *= change;
    other.cost.samples_ms *= change;
  }
}

FrameCost LevelChooser::cost_of(const Level& level) const {
  const auto nearest = std::min_element(
      measured_.begin(), measured_.end(), [&](const Measured& a, const Measured& b) {
        return distance(a.level, level) < distance(b.level, level);
      });
  if (nearest == measured_.end()) return {};
  const int finer_field = nearest->level.field - level.field;
  const int finer_pixels = log2_of(nearest->level.pixels) - log2_of(level.pixels);
  return {nearest->cost.kernels_ms * std::exp2(3 * finer_field),
          nearest->cost.samples_ms * std::exp2(finer_field + 2 * finer_pixels)};
}

double LevelChooser::predicted_ms(const Level& level) const { return cost_of(level).total_ms(); }

Level LevelChooser::choose(double budget_ms, const Level& current) const {
  const bool is_known = std::find(levels_.begin(), levels_.end(), current) != levels_.end();
  const double now = is_known ? predicted_ms(current) : std::numeric_limits<double>::infinity();
  const double bound = now <= budget_ms * kTolerance ? budget_ms / kTolerance : budget_ms;
  for (const Level& level : levels_) {
    if (level == current && now <= budget_ms * kTolerance) return current;
    if (predicted_ms(level) <= bound) return level;
  }
  const auto cheapest = std::min_element(
      levels_.begin(), levels_.end(),
      [&](const Level& a, const Level& b) { return predicted_ms(a) < predicted_ms(b); });
  return *cheapest;
}

std::vector<Level> LevelChooser::refinement(const Level& from) const {
  constexpr double kWorthShowing = 3;
  std::vector<Level> steps;
  const double full = predicted_ms(Level{});
  double last = predicted_ms(from);
  const auto start = std::find(levels_.begin(), levels_.end(), from);
  for (auto level = std::make_reverse_iterator(start); level != levels_.rend(); ++level) {
    const double cost = predicted_ms(*level);
    if (cost < last * kWorthShowing || cost * kWorthShowing > full) continue;
    steps.push_back(*level);
    last = cost;
  }
  steps.push_back(Level{});
  return steps;
}

}  // namespace ovoid::viewer
