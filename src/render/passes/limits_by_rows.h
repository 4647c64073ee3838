// SPDX-License-Identifier: Apache-2.0
// Depth limits that are made pixel by pixel, by all threads.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "data/parallel.h"
#include "ovoid/depth_limits.h"

namespace ovoid {

struct LimitsPlan {
  int width = 0, height = 0;  // of the picture
  int threads = 0;
  std::stop_token stop{};
};

// Limits without coverage. `add_stops(x, y, stops)` appends a pixel's; called from many threads at
// once. Throws Error(kCancelled).
template <class AddStops>
DepthLimits limits_by_rows(const LimitsPlan& plan, const AddStops& add_stops) {
  struct Row {
    std::vector<DepthLimits::Stop> stops;
    std::vector<std::uint32_t> counts;
  };
  std::vector<Row> rows(static_cast<std::size_t>(plan.height));
  data::parallel_ranges(
      {plan.height, 16, plan.threads, plan.stop}, [&](std::int64_t begin, std::int64_t end) {
        for (auto y = static_cast<int>(begin); y < end; ++y) {
          Row& row = rows[static_cast<std::size_t>(y)];
          for (int x = 0; x < plan.width; ++x) {
            const std::size_t before = row.stops.size();
            add_stops(x, y, row.stops);
            row.counts.push_back(static_cast<std::uint32_t>(row.stops.size() - before));
          }
        }
      });
  DepthLimits all;
  all.width = plan.width;
  all.height = plan.height;
  all.first.push_back(0);
  for (const Row& row : rows) {
    for (const std::uint32_t count : row.counts) all.first.push_back(all.first.back() + count);
  }
  all.stops.reserve(all.first.back());
  for (Row& row : rows) {
    all.stops.insert(all.stops.end(), row.stops.begin(), row.stops.end());
    row = {};
  }
  return all;
}

}  // namespace ovoid
