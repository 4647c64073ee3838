// SPDX-License-Identifier: Apache-2.0
#include "ovoid/transfer_function_2d.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "ovoid/error.h"

namespace ovoid {

struct TransferFunction2D::Content {
  Axis values, gradients;
  std::vector<Rgba> entries;
  std::vector<LookRegion> regions;
};

namespace {

using Axis = TransferFunction2D::Axis;
using Rgba = TransferFunction2D::Rgba;

// Of ParaView's vtkPVTransferFunction2DBox: share of the box's sides.
constexpr double kGaussianSigma = 0.3;

[[noreturn]] void refuse_2d(const std::string& what) {
  throw Error(ErrorCode::kInvalidArgument, "2-D transfer function: " + what);
}

void require_range(const std::string& member, double first, double last) {
  if (!std::isfinite(first) || !std::isfinite(last) || !std::isfinite(last - first) ||
      !(first < last)) {
    refuse_2d(fmt::format("{} = {}, {}: must be two finite numbers, the lower first", member, first,
                          last));
  }
}

void require_gradients(const std::string& member, double first, double last) {
  require_range(member, first, last);
  if (first < 0) refuse_2d(fmt::format("{} = {}, {}: must be >= 0", member, first, last));
}

void require_share(const std::string& member, double value) {
  if (!(value >= 0 && value <= 1))
    refuse_2d(fmt::format("{} = {}: must be in [0, 1]", member, value));
}

void require_count(const char* member, int count) {
  if (count < 2 || count > TransferFunction2D::kMaxEntriesAlong) {
    refuse_2d(fmt::format("{} along {}: must be 2 to {}", count, member,
                          TransferFunction2D::kMaxEntriesAlong));
  }
}

void require_table(const Axis& values, const Axis& gradients, const std::vector<Rgba>& entries) {
  require_count("the value", values.count);
  require_count("the gradient", gradients.count);
  require_range("values", values.first, values.last);
  require_gradients("gradients", gradients.first, gradients.last);
  const auto expected =
      static_cast<std::size_t>(values.count) * static_cast<std::size_t>(gradients.count);
  if (expected > TransferFunction2D::kMaxEntries) {
    refuse_2d(fmt::format("{} x {} entries: must be at most {}", values.count, gradients.count,
                          TransferFunction2D::kMaxEntries));
  }
  if (entries.size() != expected) {
    refuse_2d(
        fmt::format("{} entries: must be {} x {}", entries.size(), values.count, gradients.count));
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    for (std::size_t c = 0; c < 4; ++c) {
      const auto component = static_cast<double>(entries[i][c]);
      if (component >= 0 && component <= 1) continue;
      refuse_2d(fmt::format("entry {} of row {} has {} as {}: must be in [0, 1]",
                            i % static_cast<std::size_t>(values.count),
                            i / static_cast<std::size_t>(values.count), component,
                            c == 3 ? "opacity" : "a colour"));
    }
  }
}

void require_regions(const std::vector<LookRegion>& regions) {
  if (regions.empty() || regions.size() > TransferFunction2D::kMaxRegions) {
    refuse_2d(fmt::format("{} regions: must be 1 to {}", regions.size(),
                          TransferFunction2D::kMaxRegions));
  }
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const LookRegion& region = regions[i];
    const std::string name = fmt::format("regions[{}].", i);
    require_range(name + "values", region.values[0], region.values[1]);
    require_gradients(name + "gradients", region.gradients[0], region.gradients[1]);
    for (std::size_t c = 0; c < 3; ++c)
      require_share(fmt::format("{}rgb[{}]", name, c), region.rgb[c]);
    require_share(name + "opacity", region.opacity);
    require_share(name + "softness", region.softness);
    require_share(name + "foot", region.foot);
  }
}

// Where a number lies between two, from -1 to 1.
double place_between(double x, double lo, double hi) { return (x - lo) / (hi - lo) * 2 - 1; }

// 1 in the middle, 0 at the edges and beyond.
double rise_from_edge(double place, double softness) {
  const double inside = 1 - std::abs(place);
  if (inside < 0) return 0;
  return inside < softness ? inside / softness : 1;
}

double opacity_in(const LookRegion& region, double value, double gradient) {
  const double v = place_between(value, region.values[0], region.values[1]);
  const double g = place_between(gradient, region.gradients[0], region.gradients[1]);
  if (std::abs(v) > 1 || std::abs(g) > 1) return 0;
  if (region.shape == LookRegion::Shape::kGaussian) {
    const double squared = 0.25 * (v * v + g * g);  // in sides of the box
    return region.opacity * std::exp(-0.5 * squared / (kGaussianSigma * kGaussianSigma));
  }
  const double width = std::lerp(region.foot, 1.0, 0.5 * (g + 1));
  if (std::abs(v) > width) return 0;
  const double across = width > 0 ? rise_from_edge(v / width, region.softness) : 1;
  const bool is_on_ground = region.gradients[0] == 0 && g < 0;
  return region.opacity * across * (is_on_ground ? 1 : rise_from_edge(g, region.softness));
}

// `count` entries, of which the outermost lie beyond [lo, hi]; the first not, if it begins at an
// end of the world.
Axis axis_around(double lo, double hi, int count, bool begins_at_lo) {
  const double step = (hi - lo) / (count - (begins_at_lo ? 2 : 3));
  Axis axis{begins_at_lo ? lo : lo - step, hi + step, count};
  // Of a range so narrow that a step is lost in rounding.
  if (!(axis.first < lo) && !begins_at_lo) axis.first = std::nextafter(lo, -HUGE_VAL);
  if (!(axis.last > hi)) axis.last = std::nextafter(hi, HUGE_VAL);
  return axis;
}

double place_of_entry(const Axis& axis, int i) {
  return std::lerp(axis.first, axis.last, static_cast<double>(i) / (axis.count - 1));
}

// The entries from first to last that may lie between two places; none where first > last.
struct Entries {
  int first = 0, last = -1;
};

Entries entries_between(const Axis& axis, double lo, double hi) {
  const double step = (axis.last - axis.first) / (axis.count - 1);
  const double most = axis.count - 1;
  return {static_cast<int>(std::clamp(std::floor((lo - axis.first) / step) - 1, 0.0, most)),
          static_cast<int>(std::clamp(std::ceil((hi - axis.first) / step) + 1, 0.0, most))};
}

std::vector<Rgba> entries_of(const std::vector<LookRegion>& regions, const Axis& values,
                             const Axis& gradients) {
  struct Sum {
    std::array<double, 3> color{};  // premultiplied
    double alpha = 0;
  };
  const auto columns = static_cast<std::size_t>(values.count);
  std::vector<Sum> sums(columns * static_cast<std::size_t>(gradients.count));
  for (const LookRegion& region : regions) {
    const Entries across = entries_between(values, region.values[0], region.values[1]);
    const Entries up = entries_between(gradients, region.gradients[0], region.gradients[1]);
    for (int j = up.first; j <= up.last; ++j) {
      const double gradient = place_of_entry(gradients, j);
      Sum* const row = &sums[static_cast<std::size_t>(j) * columns];
      for (int i = across.first; i <= across.last; ++i) {
        const double own = opacity_in(region, place_of_entry(values, i), gradient);
        if (own == 0) continue;
        Sum& sum = row[i];
        for (std::size_t c = 0; c < 3; ++c)
          sum.color[c] = own * region.rgb[c] + (1 - own) * sum.color[c];
        sum.alpha = own + (1 - own) * sum.alpha;
      }
    }
  }
  std::vector<Rgba> entries(sums.size());
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const Sum& sum = sums[k];
    if (!(sum.alpha > 0)) continue;
    for (std::size_t c = 0; c < 3; ++c)
      entries[k][c] = static_cast<float>(std::min(sum.color[c] / sum.alpha, 1.0));
    entries[k][3] = static_cast<float>(sum.alpha);
  }
  return entries;
}

// The first and the last entry of a row that show something.
Entries seen_in_row(const Rgba* row, int count) {
  Entries seen{count, -1};
  for (int i = 0; i < count; ++i) {
    if (!(row[i][3] > 0)) continue;
    seen.first = std::min(seen.first, i);
    seen.last = i;
  }
  return seen;
}

// Of entries without opacity: the mean of their neighbours', as far as these show.
void spread_colors(const Axis& values, const Axis& gradients, std::vector<Rgba>& entries) {
  const std::vector<Rgba> given = entries;
  const auto columns = static_cast<std::size_t>(values.count);
  const auto row_of = [&](int j) { return &given[static_cast<std::size_t>(j) * columns]; };
  for (int j = 0; j < gradients.count; ++j) {
    const int below = std::max(j - 1, 0);
    const int above = std::min(j + 1, gradients.count - 1);
    Entries near{values.count, -1};
    for (int y = below; y <= above; ++y) {
      const Entries seen = seen_in_row(row_of(y), values.count);
      near = {std::min(near.first, seen.first - 1), std::max(near.last, seen.last + 1)};
    }
    near = {std::max(near.first, 0), std::min(near.last, values.count - 1)};
    for (int i = near.first; i <= near.last; ++i) {
      if (row_of(j)[i][3] > 0) continue;
      std::array<float, 4> sum{};
      for (int y = below; y <= above; ++y) {
        for (int x = std::max(i - 1, 0); x <= std::min(i + 1, values.count - 1); ++x) {
          const Rgba& neighbour = row_of(y)[x];
          for (std::size_t c = 0; c < 3; ++c) sum[c] += neighbour[3] * neighbour[c];
          sum[3] += neighbour[3];
        }
      }
      if (!(sum[3] > 0)) continue;
      Rgba& entry = entries[static_cast<std::size_t>(j) * columns + static_cast<std::size_t>(i)];
      for (std::size_t c = 0; c < 3; ++c) entry[c] = std::min(sum[c] / sum[3], 1.0F);
    }
  }
}

// Between which two entries a place lies, and how far on the way.
struct Cell {
  std::size_t entry;
  double fraction;
};

Cell cell_on(const Axis& axis, double x) {
  const double last = axis.count - 1;
  const double place = std::clamp((x - axis.first) / (axis.last - axis.first), 0.0, 1.0) * last;
  const double entry = std::min(std::floor(place), last - 1);
  return {static_cast<std::size_t>(entry), place - entry};
}

}  // namespace

TransferFunction2D::TransferFunction2D(const Axis& values, const Axis& gradients,
                                       std::vector<Rgba> entries) {
  require_table(values, gradients, entries);
  spread_colors(values, gradients, entries);
  content_ = std::make_shared<const Content>(Content{values, gradients, std::move(entries), {}});
}

TransferFunction2D::TransferFunction2D(std::vector<LookRegion> regions) {
  require_regions(regions);
  std::array<double, 2> v = regions.front().values;
  std::array<double, 2> g = regions.front().gradients;
  for (const LookRegion& region : regions) {
    v = {std::min(v[0], region.values[0]), std::max(v[1], region.values[1])};
    g = {std::min(g[0], region.gradients[0]), std::max(g[1], region.gradients[1])};
  }
  const Axis values = axis_around(v[0], v[1], kRegionValues, false);
  Axis gradients = axis_around(g[0], g[1], kRegionGradients, g[0] == 0);
  gradients.first = std::max(gradients.first, 0.0);
  require_range("values", values.first, values.last);
  require_range("gradients", gradients.first, gradients.last);
  std::vector<Rgba> entries = entries_of(regions, values, gradients);
  spread_colors(values, gradients, entries);
  content_ = std::make_shared<const Content>(
      Content{values, gradients, std::move(entries), std::move(regions)});
}

const TransferFunction2D::Axis& TransferFunction2D::values() const noexcept {
  return content_->values;
}
const TransferFunction2D::Axis& TransferFunction2D::gradients() const noexcept {
  return content_->gradients;
}
std::span<const TransferFunction2D::Rgba> TransferFunction2D::entries() const noexcept {
  return content_->entries;
}
const std::vector<LookRegion>& TransferFunction2D::regions() const noexcept {
  return content_->regions;
}

std::array<double, 4> TransferFunction2D::at(double value, double gradient) const {
  if (std::isnan(value) || std::isnan(gradient)) return {};
  const Cell v = cell_on(values(), value);
  const Cell g = cell_on(gradients(), gradient);
  const auto stride = static_cast<std::size_t>(values().count);
  const Rgba* const corner = &content_->entries[g.entry * stride + v.entry];
  std::array<double, 4> out{};
  for (std::size_t c = 0; c < 4; ++c) {
    out[c] = std::lerp(std::lerp<double>(corner[0][c], corner[1][c], v.fraction),
                       std::lerp<double>(corner[stride][c], corner[stride + 1][c], v.fraction),
                       g.fraction);
  }
  return out;
}

}  // namespace ovoid
