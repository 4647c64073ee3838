// SPDX-License-Identifier: Apache-2.0
#include "model/time/trail_moments.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ovoid::model {
namespace {

constexpr double kMostCuts = 4096;      // of a part
constexpr double kLeastOfTrail = 1e-5;  // a moment of less is not seen

bool is_at_step(const TrailPart& part, double time) {
  return time == part.first || time == part.second;
}

void add_part(const TrailPart& part, const TrailWeight& weight, std::vector<TimeShare>& moments) {
  if (!part.moves) {
    const double middle = std::clamp(0.5 * (part.first + part.second), part.from, part.until);
    moments.push_back({part.first, weight.integral(part.from, middle)});
    moments.push_back({part.second, weight.integral(middle, part.until)});
    return;
  }
  const int cuts = static_cast<int>(std::clamp(std::ceil(part.steps), 1.0, kMostCuts));
  const double step = (part.until - part.from) / cuts;
  for (int i = 0; i < cuts; ++i) {
    const double from = part.from + i * step;
    const double until = i + 1 < cuts ? part.from + (i + 1) * step : part.until;
    moments.push_back({weight.centroid(from, until), weight.integral(from, until)});
  }
}

void join_equal(std::vector<TimeShare>& moments) {
  std::vector<TimeShare> joined;
  for (const TimeShare& moment : moments) {
    if (!joined.empty() && joined.back().time == moment.time) {
      joined.back().share += moment.share;
    } else {
      joined.push_back(moment);
    }
  }
  moments = std::move(joined);
}

void drop_unseen(std::vector<TimeShare>& moments) {
  double sum = 0;
  for (const TimeShare& moment : moments) sum += moment.share;
  std::erase_if(moments,
                [&](const TimeShare& moment) { return !(moment.share > kLeastOfTrail * sum); });
}

// Runs of neighbours become one each. A moment at a step of a part that does not move stays at one.
void join_neighbours(const std::vector<TrailPart>& parts, std::size_t most,
                     std::vector<TimeShare>& moments) {
  if (moments.size() <= most) return;
  const auto must_stay = [&](double time) {
    return std::any_of(parts.begin(), parts.end(), [&](const TrailPart& part) {
      return !part.moves && is_at_step(part, time);
    });
  };
  std::vector<TimeShare> joined;
  for (std::size_t g = 0; g < most; ++g) {
    const std::size_t first = g * moments.size() / most;
    const std::size_t last = (g + 1) * moments.size() / most;
    TimeShare all{0, 0};
    for (std::size_t i = first; i < last; ++i) {
      all.time += moments[i].share * moments[i].time;
      all.share += moments[i].share;
    }
    all.time /= all.share;
    const auto nearest =
        std::min_element(moments.begin() + static_cast<std::ptrdiff_t>(first),
                         moments.begin() + static_cast<std::ptrdiff_t>(last),
                         [&](const TimeShare& a, const TimeShare& b) {
                           return std::abs(a.time - all.time) < std::abs(b.time - all.time);
                         });
    if (must_stay(nearest->time)) all.time = nearest->time;
    joined.push_back(all);
  }
  moments = std::move(joined);
}

}  // namespace

double TrailWeight::integral(double from, double until) const {
  const double fall = decay / length;
  const double width = until - from;
  const double scale = std::exp(fall * (until - time));
  return fall * width > 0 ? scale * -std::expm1(-fall * width) / fall : width;
}

double TrailWeight::centroid(double from, double until) const {
  constexpr double kSmall = 1e-4;  // the next term of the series is x^3 / 720
  const double width = until - from;
  const double x = decay / length * width;
  // From the middle towards the end, in widths.
  const double at = x < kSmall ? x / 12 : 0.5 - 1 / x + 1 / std::expm1(x);
  return from + width * (0.5 + at);
}

std::vector<TimeShare> moments_of(const std::vector<TrailPart>& parts, const TrailWeight& weight,
                                  int most) {
  std::vector<TimeShare> moments;
  for (const TrailPart& part : parts) add_part(part, weight, moments);
  join_equal(moments);
  drop_unseen(moments);
  join_neighbours(parts, static_cast<std::size_t>(std::max(most, 1)), moments);
  double sum = 0;
  for (const TimeShare& moment : moments) sum += moment.share;
  for (TimeShare& moment : moments) moment.share /= sum;
  return moments;
}

}  // namespace ovoid::model
