// SPDX-License-Identifier: Apache-2.0
#include "view/look/vessels.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "data/field_samples.h"
#include "data/lattice/sample_reader.h"
#include "data/lattice/shared_layers.h"
#include "view/look/field_samples.h"

namespace ovoid::view {
namespace {

// Whether nothing darker than `limit` lies within `reach` samples along any axis. Beyond the
// lattice, and beyond what the source shows at once, nothing is known to lie.
bool is_enclosed(data::SampleReader& reader, const Index3& index, std::int64_t reach,
                 double limit) {
  const BrickView view = reader.view();
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t first = std::max(view.lo[a], index[a] - reach);
    const std::int64_t last = std::min(view.hi[a] - 1, index[a] + reach);
    Index3 at = index;
    for (at[a] = first; at[a] <= last; ++at[a]) {
      if (static_cast<double>(reader.at(at)) < limit) return false;
    }
  }
  return true;
}

// Share of what is brighter than `wall` that is enclosed.
double enclosed_share(const BrickSource& source, double wall, double limit) {
  const Index3& dims = source.geometry().dims;
  const auto edge = static_cast<std::int64_t>(std::cbrt(static_cast<double>(num_samples(dims))));
  const std::int64_t reach = std::max<std::int64_t>(6, edge / 16);
  const std::int64_t every = std::max<std::int64_t>(1, num_samples(dims) / data::kWantedSamples);
  data::SampleReader reader(source);
  std::vector<int> are_enclosed;  // of those that are bright
  const data::SharedLayers layers = data::shared_layers(source);
  data::visit_some({0, 0, layers.first}, {dims[0], dims[1], layers.end}, every,
                   [&](const Index3& index) {
                     if (!(static_cast<double>(reader.at(index)) > wall)) return;
                     are_enclosed.push_back(is_enclosed(reader, index, reach, limit) ? 1 : 0);
                   });
  are_enclosed = layers.of_all(std::move(are_enclosed));
  const auto num_bright = static_cast<double>(are_enclosed.size());
  const auto num_enclosed =
      static_cast<double>(std::count(are_enclosed.begin(), are_enclosed.end(), 1));
  return num_bright > 0 ? num_enclosed / num_bright : 0;
}

}  // namespace

std::optional<Vessels> find_vessels(const BrickSource& source, const Materials& materials,
                                    double background, std::span<const float> rising) {
  constexpr double kLeastShare = 0.0005;
  constexpr double kMostShare = 0.03;
  constexpr double kMostlyEnclosed = 0.6;
  if (materials.values.size() < 2 || materials.values.back() <= background) return std::nullopt;
  Vessels found{.tissue = materials.values.back(), .wall = 0, .bright = quantile(rising, 0.9998)};
  const double height = found.tissue - background;
  const double above = found.bright - found.tissue;
  if (above < height) return std::nullopt;
  found.wall = found.tissue + std::max(0.35 * above, 4 * materials.noise);
  if (found.wall > found.tissue + 0.7 * above) return std::nullopt;
  const auto first = std::upper_bound(rising.begin(), rising.end(), static_cast<float>(found.wall));
  const double share =
      static_cast<double>(rising.end() - first) / static_cast<double>(rising.size());
  if (share < kLeastShare || share > kMostShare) return std::nullopt;
  // Noise of the tissue stays above this.
  const double limit = background + 0.4 * height;
  if (enclosed_share(source, found.wall, limit) < kMostlyEnclosed) return std::nullopt;
  return found;
}

}  // namespace ovoid::view
