// SPDX-License-Identifier: Apache-2.0
#include "model/team/territory.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "data/kernels/letters.h"

namespace ovoid::model {

bool Territory::is_within(const Bounds3& box, double square) const {
  return !boxes_.empty() && square_between(all_, box) <= square &&
         std::any_of(boxes_.begin(), boxes_.end(),
                     [&](const Bounds3& one) { return square_between(one, box) <= square; });
}

Territory territory_of(const SiteGroups& groups) {
  return territory_of(groups, [](const SiteGroups::Site& site) { return Bounds3(site.at); });
}

// Boxes of subtrees.
Territory territory_of(const SiteGroups& groups,
                       const std::function<Bounds3(const SiteGroups::Site&)>& around) {
  constexpr std::size_t kMostBoxes = 64;
  const std::size_t per_box = std::max<std::size_t>(1, groups.count() / kMostBoxes);
  std::vector<Bounds3> boxes;
  for (std::size_t g = 0; g < groups.count(); ++g) {
    if (g % per_box == 0) boxes.emplace_back();
    for (const SiteGroups::Site& site : groups.group(g).sites) boxes.back().extend(around(site));
  }
  return Territory(std::move(boxes));
}

std::vector<Territory> territories_of_all(const ModelRun& run, const Territory& own) {
  std::vector<Territory> territories;
  for (std::vector<Bounds3>& boxes :
       data::gathered(*run.team, std::span<const Bounds3>(own.boxes())))
    territories.emplace_back(std::move(boxes));
  return territories;
}

}  // namespace ovoid::model
