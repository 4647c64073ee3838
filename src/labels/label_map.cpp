// SPDX-License-Identifier: Apache-2.0
#include "ovoid/labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <new>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "labels/label_grid.h"
#include "labels/label_rays.h"
#include "ovoid/error.h"
#include "view/look/label_look.h"
#include "view/look/look_colors.h"

namespace ovoid {
namespace {

// 0, or what the map's faces show most.
int background_of(const LabelMap& map) {
  const std::vector<int>& all = map.labels();
  if (std::binary_search(all.begin(), all.end(), 0)) return 0;
  std::map<labels::Rank, std::int64_t> counts;
  const Index3& dims = map.geometry().dims;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = (a + 1) % 3;
    const std::size_t c = (a + 2) % 3;
    Index3 at{};
    for (at[b] = 0; at[b] < dims[b]; ++at[b]) {
      for (at[c] = 0; at[c] < dims[c]; ++at[c]) {
        for (const std::int64_t end : {std::int64_t{0}, dims[a] - 1}) {
          at[a] = end;
          ++counts[map.grid().rank_at(at[0], at[1], at[2])];
        }
      }
    }
  }
  const auto most =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& x, const auto& y) { return x.second < y.second; });
  return most->first == labels::kNoLabel ? std::numeric_limits<int>::min() : all[most->first];
}

}  // namespace

LabelMap::LabelMap(std::unique_ptr<const labels::LabelGrid> grid) : grid_(std::move(grid)) {}
LabelMap::~LabelMap() = default;

const std::vector<int>& LabelMap::labels() const noexcept { return grid_->labels(); }
const LatticeGeometry& LabelMap::geometry() const noexcept { return grid_->geometry(); }
std::size_t LabelMap::resident_bytes() const noexcept { return grid_->resident_bytes(); }

std::optional<int> LabelMap::label_at(const Vec3& world) const {
  const Vec3 place = geometry().world_from_index.inverse() * world;
  if (!geometry().index_bounds().contains(place)) return std::nullopt;
  const labels::Rank rank = labels::winner_at(*grid_, place);
  if (rank == labels::kNoLabel) return std::nullopt;
  return labels()[rank];
}

std::shared_ptr<const LabelMap> make_label_map(const LatticeField& field, int threads,
                                               std::stop_token stop) try {
  if (field.is_empty()) throw Error(ErrorCode::kInvalidArgument, "labels: the field is empty");
  return std::shared_ptr<const LabelMap>(
      new LabelMap(std::make_unique<const labels::LabelGrid>(field, threads, stop)));
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::kOutOfMemory,
              fmt::format("labels: no memory for {} samples", num_samples(field.geometry().dims)));
}

std::vector<LabelStyle> label_styles(const LabelMap& map, const std::vector<LabelEntry>& table) {
  const std::vector<int>& all = map.labels();
  const int background = background_of(map);
  const bool are_few = all.size() <= view::kFewLabels;
  std::unordered_map<int, const LabelEntry*> entries;
  for (const LabelEntry& entry : table) entries.emplace(entry.label, &entry);
  std::vector<LabelStyle> styles;
  std::size_t num_shown = 0;
  for (const int label : all) {
    LabelStyle style;
    style.label = label;
    const bool is_background = label == background && all.size() > 1;
    if (is_background) {
      style.opacity = 0;
    } else {
      style.color = are_few ? view::color_of_rank(num_shown++) : view::color_of_label(label);
    }
    const auto found = entries.find(label);
    if (found != entries.end()) {
      style.name = found->second->name;
      style.color = found->second->color.value_or(style.color);
      if (!is_background) style.opacity = found->second->opacity.value_or(style.opacity);
    }
    styles.push_back(std::move(style));
  }
  return styles;
}

Look label_look(const std::vector<LabelStyle>& styles) {
  std::vector<view::LabelColor> colors;
  colors.reserve(styles.size());
  for (const LabelStyle& style : styles)
    colors.push_back({style.label, style.color, style.opacity});
  std::sort(colors.begin(), colors.end(),
            [](const auto& a, const auto& b) { return a.label < b.label; });
  Look look;
  look.transfer_function = view::label_function(colors);
  view::set_light(look);
  return look;
}

void LabelSurfaces::validate() const {
  for (const double opacity : {slice_lines, slice_areas}) {
    if (!(opacity >= 0 && opacity <= 1))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("labels: an opacity on slices is {}, expected 0 to 1", opacity));
  }
  std::unordered_set<int> seen;
  for (const LabelStyle& style : styles) {
    if (!seen.insert(style.label).second) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("labels: {} has more than one style", style.label));
    }
    for (const double c : style.color) {
      if (!(c >= 0 && c <= 1)) {
        throw Error(
            ErrorCode::kInvalidArgument,
            fmt::format("labels: the colour of {} has {}, expected 0 to 1", style.label, c));
      }
    }
    if (!(style.opacity >= 0 && style.opacity <= 1)) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("labels: the opacity of {} is {}, expected 0 to 1", style.label,
                              style.opacity));
    }
  }
}

}  // namespace ovoid
