// SPDX-License-Identifier: Apache-2.0
#include "ovoid/depth_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "ovoid/error.h"

namespace ovoid {
namespace {

[[noreturn]] void refuse_limits(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, "depth_limits: " + message);
}

void require_limit(bool holds, const std::string& message) {
  if (!holds) refuse_limits(message);
}

bool is_share(float value) { return value >= 0 && value <= 1; }

}  // namespace

bool DepthLimits::shows_field_at(int x, int y, float depth) const {
  const auto here = of_pixel(x, y);
  const auto behind = std::upper_bound(here.begin(), here.end(), depth,
                                       [](float at, const Stop& stop) { return at < stop.depth; });
  return behind != here.begin() && std::prev(behind)->is_field_behind;
}

void DepthLimits::validate() const {
  const auto num_pixels =
      static_cast<std::size_t>(std::max(width, 0)) * static_cast<std::size_t>(std::max(height, 0));
  require_limit(first.size() == num_pixels + 1,
                fmt::format("first has {} numbers, {} x {} pixels need {}", first.size(), width,
                            height, num_pixels + 1));
  require_limit(first.front() == 0 && first.back() == stops.size() &&
                    std::is_sorted(first.begin(), first.end()),
                fmt::format("first must rise from 0 to the number of stops, {}", stops.size()));
  require_limit(coverage.empty() || coverage.size() == num_pixels,
                fmt::format("coverage has {} numbers, {} x {} pixels need {}", coverage.size(),
                            width, height, num_pixels));
  // Frames have millions of these: text is made of a wrong one alone.
  for (std::size_t i = 0; i < coverage.size(); ++i) {
    if (!is_share(coverage[i]))
      refuse_limits(fmt::format("coverage[{}] = {}: must be in [0, 1]", i, coverage[i]));
  }
  for (std::size_t pixel = 0; pixel < num_pixels; ++pixel) {
    for (std::size_t i = first[pixel]; i < first[pixel + 1]; ++i) {
      const Stop& stop = stops[i];
      const bool is_behind = i == first[pixel] || stops[i - 1].depth <= stop.depth;
      if (std::isnan(stop.depth) || !is_behind)
        refuse_limits(fmt::format(
            "stops[{}].depth = {}: a pixel's stops must go from front to back", i, stop.depth));
      if (!std::all_of(stop.rgba.begin(), stop.rgba.end(), is_share))
        refuse_limits(fmt::format("stops[{}].rgba: must be in [0, 1]", i));
    }
  }
}

DepthLimits intersection(const DepthLimits& a, const DepthLimits& b) {
  DepthLimits both;
  both.width = a.width;
  both.height = a.height;
  both.coverage = !a.coverage.empty() ? a.coverage : b.coverage;
  both.first.reserve(a.first.size());
  both.first.push_back(0);
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      const auto of_a = a.of_pixel(x, y), of_b = b.of_pixel(x, y);
      bool is_in_a = false, is_in_b = false, is_drawn = false;
      for (std::size_t i = 0, k = 0; i < of_a.size() || k < of_b.size();) {
        const bool is_next_a =
            k == of_b.size() || (i < of_a.size() && of_a[i].depth <= of_b[k].depth);
        const DepthLimits::Stop& stop = is_next_a ? of_a[i++] : of_b[k++];
        (is_next_a ? is_in_a : is_in_b) = stop.is_field_behind;
        const bool is_next = is_in_a && is_in_b;
        if (is_next == is_drawn) continue;
        is_drawn = is_next;
        both.stops.push_back({stop.depth, is_drawn, stop.is_seam, {}});
      }
      both.first.push_back(static_cast<std::uint32_t>(both.stops.size()));
    }
  }
  return both;
}

}  // namespace ovoid
