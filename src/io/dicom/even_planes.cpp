// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/even_planes.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace ovoid::io {
namespace {

// How many planes there may be for `num_heights` heights, and where the least distance needs them.
std::int64_t most_planes(std::size_t num_heights) {
  return std::max<std::int64_t>(256, 4 * static_cast<std::int64_t>(num_heights));
}
std::int64_t most_planes_for_least(std::size_t num_heights) {
  return std::max<std::int64_t>(1024, 8 * static_cast<std::int64_t>(num_heights));
}

// The distance of neighbours: that of most, or of the nearest if most have a gap between them.
double usual_distance(std::vector<double> distances) {
  std::sort(distances.begin(), distances.end());
  const double median = distances[distances.size() / 2], least = distances.front();
  if (median < 1.5 * least) return median;
  double sum = 0, count = 0;
  for (const double d : distances) {
    if (d > 1.4 * least) break;
    sum += d;
    ++count;
  }
  return sum / count;
}

// With the distance that planes `planes` then have.
EvenPlanes measured(std::span<const double> heights, std::vector<std::int64_t> planes) {
  EvenPlanes even;
  even.distance = (heights.back() - heights.front()) / static_cast<double>(planes.back());
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const double place = even.distance * static_cast<double>(planes[i]);
    even.worst = std::max(even.worst, std::abs(heights[i] - heights.front() - place));
  }
  even.planes = std::move(planes);
  return even;
}

// From neighbour to neighbour, so that small errors do not add up.
std::optional<EvenPlanes> by_neighbours(std::span<const double> heights, double distance,
                                        std::int64_t most) {
  std::vector<std::int64_t> planes{0};
  for (std::size_t i = 1; i < heights.size(); ++i) {
    const double steps = std::max(1.0, std::round((heights[i] - heights[i - 1]) / distance));
    if (!(static_cast<double>(planes.back()) + steps < static_cast<double>(most)))
      return std::nullopt;
    planes.push_back(planes.back() + static_cast<std::int64_t>(steps));
  }
  return measured(heights, std::move(planes));
}

// Each height in the nearest plane. In further rounds the distance fits all of them, and the planes
// it.
EvenPlanes by_height(std::span<const double> heights, double distance, int num_rounds) {
  std::vector<std::int64_t> planes(heights.size());
  for (int round = 0; round < num_rounds; ++round) {
    double above = 0, below = 0;
    for (std::size_t i = 0; i < heights.size(); ++i) {
      const double height = heights[i] - heights.front();
      const double plane = std::round(height / distance);
      planes[i] = static_cast<std::int64_t>(plane);
      above += height * plane;
      below += plane * plane;
    }
    if (below > 0) distance = above / below;
  }
  planes.back() = std::max<std::int64_t>(planes.back(), 1);
  return measured(heights, std::move(planes));
}

bool rise(const std::vector<std::int64_t>& planes) {
  return std::adjacent_find(planes.begin(), planes.end(), std::greater_equal<>()) == planes.end();
}

// One height a plane: the nearest to it. The ends keep theirs.
void leave_out_second(std::span<const double> heights, EvenPlanes& even) {
  const auto off = [&](std::size_t i) {
    const bool is_end = i == 0 || i + 1 == heights.size();
    const double place = even.distance * static_cast<double>(even.planes[i]);
    return is_end ? -1 : std::abs(heights[i] - heights.front() - place);
  };
  std::size_t kept = 0;
  for (std::size_t i = 1; i < heights.size(); ++i) {
    if (even.planes[i] == even.planes[kept]) {
      const std::size_t other = off(i) < off(kept) ? kept : i;
      if (other == kept) kept = i;
      even.planes[other] = EvenPlanes::kLeftOut;
    } else {
      kept = i;
    }
  }
}

}  // namespace

EvenPlanes find_even_planes(std::span<const double> heights, double tolerance) {
  constexpr int kRounds = 3;  // after which nothing moves any more
  std::vector<double> distances;
  for (std::size_t i = 1; i < heights.size(); ++i) distances.push_back(heights[i] - heights[i - 1]);
  const double span = heights.back() - heights.front();
  const double least = *std::min_element(distances.begin(), distances.end());
  const std::int64_t most = most_planes(heights.size());
  const std::int64_t most_for_least = most_planes_for_least(heights.size());
  const auto fits = [&](const EvenPlanes& even) {
    return even.worst <= tolerance * even.distance && rise(even.planes);
  };
  auto usual = by_neighbours(heights, usual_distance(distances), most_for_least);
  if (usual && fits(*usual)) {
    usual->is_usual = true;
    return std::move(*usual);
  }
  for (double parts = 1;
       span / least * parts < static_cast<double>(parts > 1 ? most : most_for_least); ++parts) {
    EvenPlanes even = by_height(heights, least / parts, kRounds);
    if (fits(even)) return even;
  }
  const double wanted = std::ceil(span / least) + 1;
  const double count = std::clamp(wanted, static_cast<double>(most),
                                  static_cast<double>(std::max(most, most_for_least)));
  EvenPlanes even = by_height(heights, span / (count - 1), 1);
  leave_out_second(heights, even);
  return even;
}

}  // namespace ovoid::io
