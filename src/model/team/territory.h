// SPDX-License-Identifier: Apache-2.0
// Where the sites of each process of a team are: who may have something near a place.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "model/particles/kernel_parts.h"
#include "model/particles/site_groups.h"

namespace ovoid::model {

// A few boxes around all sites of one process; none of a process without sites.
class Territory {
 public:
  Territory() = default;
  explicit Territory(std::vector<Bounds3> boxes) : boxes_(std::move(boxes)) {
    for (const Bounds3& box : boxes_) all_.extend(box);
  }

  const std::vector<Bounds3>& boxes() const noexcept { return boxes_; }
  // Whether a part of it is at most the root of `square` away from the box.
  bool is_within(const Bounds3& box, double square) const;
  bool meets(const Bounds3& box) const { return is_within(box, 0); }

 private:
  std::vector<Bounds3> boxes_;
  Bounds3 all_;
};

// Around this process' sites, or what is at them.
Territory territory_of(const SiteGroups& groups);
Territory territory_of(const SiteGroups& groups,
                       const std::function<Bounds3(const SiteGroups::Site&)>& around);

// By process. All call it.
std::vector<Territory> territories_of_all(const ModelRun& run, const Territory& own);

}  // namespace ovoid::model
