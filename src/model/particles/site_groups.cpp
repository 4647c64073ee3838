// SPDX-License-Identifier: Apache-2.0
#include "model/particles/site_groups.h"

#include <algorithm>
#include <bit>

#include "data/parallel.h"

namespace ovoid::model {

SiteGroups::SiteGroups(std::span<const double> sites, int threads, const std::stop_token& stop) {
  sites_.resize(sites.size() / 3);
  for (std::size_t i = 0; i < sites_.size(); ++i)
    sites_[i] = {{sites[3 * i], sites[3 * i + 1], sites[3 * i + 2]}, static_cast<std::uint32_t>(i)};
  num_groups_ = std::bit_ceil((sites_.size() + kMostInGroup - 1) / kMostInGroup);
  boxes_.resize(2 * num_groups_);
  for (std::size_t first = 1; first <= num_groups_; first *= 2) {  // a level at a time
    const std::int64_t grain = static_cast<std::int64_t>(first) / 64 + 1;
    data::parallel_ranges(
        {static_cast<std::int64_t>(first), grain, threads, stop},
        [&](std::int64_t begin, std::int64_t end) {
          for (auto i = first + static_cast<std::size_t>(begin);
               i < first + static_cast<std::size_t>(end); ++i) {
            const Group whole = node(i);
            Bounds3 box;
            for (const Site& site : whole.sites) box.extend(site.at);
            boxes_[i] = box;
            if (i >= num_groups_ || whole.sites.size() < 2) continue;
            int axis = 0;
            box.sizes().maxCoeff(&axis);
            const auto begin_site = sites_.begin() + (whole.sites.data() - sites_.data());
            const auto half = static_cast<std::ptrdiff_t>(node(2 * i).sites.size());
            std::nth_element(
                begin_site, begin_site + half,
                begin_site + static_cast<std::ptrdiff_t>(whole.sites.size()),
                [axis](const Site& a, const Site& b) { return a.at[axis] < b.at[axis]; });
          }
        });
  }
}

SiteGroups::Group SiteGroups::node(std::size_t index) const {
  const auto level = static_cast<int>(std::bit_width(index)) - 1;
  const std::size_t at = index - (std::size_t{1} << level);
  const std::size_t first = (at * sites_.size()) >> level;
  const std::size_t past = ((at + 1) * sites_.size()) >> level;
  return {boxes_[index], std::span(sites_).subspan(first, past - first), at};
}

}  // namespace ovoid::model
