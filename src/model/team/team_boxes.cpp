// SPDX-License-Identifier: Apache-2.0
#include <numeric>
#include <optional>
#include <utility>

#include "data/kernels/letters.h"
#include "model/mesh/local_mesh.h"
#include "model/particles/site_groups.h"
#include "model/team/team_sites.h"
#include "model/team/territory.h"

namespace ovoid::model {
namespace {

// A little larger than the box, so that boxes which touch meet whatever was rounded.
Bounds3 around_box(const Boxes& boxes, std::size_t i) {
  const Vec3 reach = 0.501 * boxes.edge(i);
  return {boxes.center(i) - reach, boxes.center(i) + reach};
}

Territory territory_of_boxes(const ModelRun& run, const Boxes& boxes) {
  std::vector<double> placed;
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t i = 0; i < boxes.count(); ++i) {
    if (!boxes.center(i).allFinite()) continue;
    numbers.push_back(i);
    for (const double x : boxes.center(i)) placed.push_back(x);
  }
  if (numbers.empty()) return {};
  return territory_of(SiteGroups(placed, run.threads, run.stop), [&](const SiteGroups::Site& site) {
    return around_box(boxes, numbers[site.index]);
  });
}

}  // namespace

LocalBoxes load_local_boxes(const ModelRun& run, const ChosenArrays& chosen) {
  LocalBoxes local;
  local.boxes = load_boxes(run);
  const auto count = static_cast<std::int64_t>(local.boxes.count());
  local.values = load_values(run, chosen, count, "boxes");
  if (run.team == nullptr) return local;
  SiteRows rows;
  rows.orders.resize(local.boxes.count());
  std::iota(rows.orders.begin(), rows.orders.end(),
            static_cast<std::uint64_t>(run.dataset.share->first));
  rows.centers = std::move(local.boxes.centers);
  rows.edges = std::move(local.boxes.edges);
  rows.columns = std::move(local.values.columns);
  rows = share_by_place(run, std::move(rows));
  local.boxes = {std::move(rows.centers), std::move(rows.edges)};
  local.values.columns = std::move(rows.columns);
  return local;
}

Boxes with_neighbors(const ModelRun& run, const Boxes& own) {
  Boxes all = own;
  if (run.team == nullptr) return all;
  const std::vector<Territory> territories = territories_of_all(run, territory_of_boxes(run, own));
  data::RowLists lists(territories.size());
  for (std::uint32_t i = 0; i < own.count(); ++i) {
    if (!own.center(i).allFinite()) continue;
    const Bounds3 box = around_box(own, i);
    for (std::size_t p = 0; p < lists.size(); ++p) {
      if (p != static_cast<std::size_t>(run.team->number()) && territories[p].meets(box))
        lists[p].push_back(i);
    }
  }
  constexpr std::size_t kRowBytes = 6 * sizeof(double);
  KernelTeam::Letters letters = data::letters_of(lists, kRowBytes);
  data::append_rows(letters, lists, 3, own.centers);
  data::append_rows(letters, lists, 3, own.edges);
  for (const data::Letter& letter : run.team->exchange(std::move(letters))) {
    const std::size_t count = letter.size() / kRowBytes;
    data::LetterReader reader(letter);
    reader.take(3 * count, all.centers);
    reader.take(3 * count, all.edges);
  }
  return all;
}

}  // namespace ovoid::model
