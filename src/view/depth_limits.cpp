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

}  // namespace ovoid
