// SPDX-License-Identifier: Apache-2.0
#include "model/particle_lengths.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "data/parallel.h"
#include "model/nearest_sites.h"

namespace ovoid::model {

namespace {

// The sites nearest to one of them, by offset from it.
struct NearList {
  std::vector<std::uint32_t> indices;
  std::vector<double> squares;
  std::vector<std::pair<double, Vec3>> offsets;  // squared distance first
};

class PeriodicSearch {
 public:
  PeriodicSearch(const ParticleSites& sites, std::size_t k)
      : sites_(sites), tree_(sites.centers), k_(std::min(k, sites.count())) {}

  // list.offsets: the k nearest of all sites and their images in the neighbouring boxes.
  void find(std::size_t site, NearList& list) const {
    const Vec3 at = sites_.center(site);
    list.offsets.clear();
    add_image(at, Vec3::Zero(), list);
    if (!sites_.periodic_box) return;
    const double radius = std::sqrt(list.offsets.back().first);
    const Bounds3& box = *sites_.periodic_box;
    std::array<std::array<double, 3>, 3> shifts{};  // per axis; the first is 0
    std::array<int, 3> counts = {1, 1, 1};
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const double edge = box.sizes()[axis];
      if (at[axis] - radius < box.min()[axis])
        shifts[a][static_cast<std::size_t>(counts[a]++)] = edge;
      if (at[axis] + radius > box.max()[axis])
        shifts[a][static_cast<std::size_t>(counts[a]++)] = -edge;
    }
    if (counts[0] * counts[1] * counts[2] == 1) return;
    for (int z = 0; z < counts[2]; ++z) {
      for (int y = 0; y < counts[1]; ++y) {
        for (int x = 0; x < counts[0]; ++x) {
          if (x + y + z > 0)
            add_image(
                at,
                Vec3(shifts[0][static_cast<std::size_t>(x)], shifts[1][static_cast<std::size_t>(y)],
                     shifts[2][static_cast<std::size_t>(z)]),
                list);
        }
      }
    }
    std::sort(list.offsets.begin(), list.offsets.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    list.offsets.resize(k_);
  }

 private:
  // The sites around `at` as seen from a box shifted by `shift`.
  void add_image(const Vec3& at, const Vec3& shift, NearList& list) const {
    list.indices.resize(k_);
    list.squares.resize(k_);
    const Vec3 place = at + shift;
    const std::size_t found = tree_.find(place, list.indices, list.squares);
    for (std::size_t i = 0; i < found; ++i)
      list.offsets.emplace_back(list.squares[i], sites_.center(list.indices[i]) - place);
  }

  const ParticleSites& sites_;
  NearestSites tree_;
  std::size_t k_;
};

// Second moments about the site itself, over h^2; the trace of a ball's worth is then about 2.4.
void store_covariance(const NearList& list, double length, float* to) {
  Mat3 sum = Mat3::Zero();
  for (const auto& [square, offset] : list.offsets) sum += offset * offset.transpose();
  if (length > 0) sum /= length * length * static_cast<double>(list.offsets.size());
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column <= row; ++column) *to++ = static_cast<float>(sum(row, column));
  }
}

}  // namespace

NearestStatistics nearest_statistics(const ModelRun& run, const ParticleSites& sites,
                                     WithCovariances with) {
  NearestStatistics statistics;
  statistics.lengths.resize(sites.count());
  if (with == WithCovariances::kYes) statistics.covariances.resize(6 * sites.count());
  const PeriodicSearch search(sites, static_cast<std::size_t>(run.options.neighbors));
  data::parallel_ranges(
      {static_cast<std::int64_t>(sites.count()), kSiteGrain, run.threads, run.stop},
      [&](std::int64_t begin, std::int64_t end) {
        NearList list;
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          search.find(i, list);
          const double length = std::sqrt(list.offsets.back().first) / 2;
          statistics.lengths[i] = static_cast<float>(length);
          if (with == WithCovariances::kYes)
            store_covariance(list, length, statistics.covariances.data() + 6 * i);
        }
      });
  return statistics;
}

void raise_zero_lengths(const ModelRun& run, std::vector<float>& lengths) {
  float least = std::numeric_limits<float>::infinity();
  for (const float length : lengths) {
    if (length > 0) least = std::min(least, length);
  }
  if (!std::isfinite(least)) least = 1;
  for (float& length : lengths) {
    if (length > 0) continue;
    length = least;
    ++run.report.num_degenerate;
  }
}

}  // namespace ovoid::model
