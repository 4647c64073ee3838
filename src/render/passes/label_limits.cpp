// SPDX-License-Identifier: Apache-2.0
// In: a label map and how its labels are drawn. Out: stops for every pixel.
//
// First one ray goes through the middle of every pixel. Where it meets other surfaces than a
// neighbour's does, there is an outline in the pixel: four rays more say how much of it each
// surface covers.
#include "render/passes/label_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "data/parallel.h"
#include "labels/label_rays.h"
#include "ovoid/crop.h"
#include "render/passes/limits_by_rows.h"
#include "view/look/light.h"
#include "view/plan/pixel_rays.h"

namespace ovoid {
namespace {

using labels::Bodies;
using labels::LabelCrossing;
using labels::LabelRay;
using labels::Rank;

// Depths of neighbouring pixels that are further apart, in spacings and in pixels, are of two
// surfaces.
constexpr double kJumpInSpacings = 1.0;
constexpr double kJumpInPixels = 4.0;
// Of a pixel's width, from its middle: a square that is turned a little, so that upright and level
// outlines have four steps.
constexpr std::array<std::array<double, 2>, 4> kSubrays{
    {{-0.125, -0.375}, {0.375, -0.125}, {-0.375, 0.125}, {0.125, 0.375}}};

// A surface that a ray meets.
struct Hit {
  float depth = 0;
  Rank rank = 0;
  std::array<float, 4> rgba{};  // premultiplied
};

// From a depth on the field is shown, or not.
struct FieldChange {
  float depth = 0;
  bool is_shown = false;
};

struct TracedRay {
  std::vector<Hit> hits;             // by depth; nothing is behind an opaque one
  std::vector<FieldChange> changes;  // by depth; before the first the field is shown as elsewhere

  void clear() {
    hits.clear();
    changes.clear();
  }
};

// How labels are drawn, by rank.
class RankStyles {
 public:
  explicit RankStyles(const LabelSurfaces& surfaces) {
    const std::vector<int>& labels = surfaces.map->labels();
    const std::size_t num = labels.size();
    colors.assign(num, {});
    opacities.assign(num, 0);
    std::vector<bool> shows_field(num, surfaces.shows_field_elsewhere);
    for (const LabelStyle& style : surfaces.styles) {
      const auto at = std::lower_bound(labels.begin(), labels.end(), style.label);
      if (at == labels.end() || *at != style.label) continue;
      const auto rank = static_cast<std::size_t>(at - labels.begin());
      colors[rank] = style.color;
      opacities[rank] = surfaces.shows_surfaces ? style.opacity : 0;
      shows_field[rank] = style.shows_field;
    }
    // What is hidden is one body, and what is opaque; what is see-through is each label by itself.
    std::map<std::pair<int, bool>, Bodies::Id> alike;
    const auto body_of = [&](double opacity, bool shows, std::size_t rank) {
      const int kind = opacity <= 0 ? -2 : opacity >= 1 ? -1 : static_cast<int>(rank);
      const auto [at, is_new] =
          alike.try_emplace({kind, shows}, static_cast<Bodies::Id>(bodies.all.size()));
      if (is_new) {
        bodies.all.push_back({opacity > 0, opacity >= 1});
        body_shows_field.push_back(shows);
      }
      return at->second;
    };
    for (std::size_t r = 0; r < num; ++r)
      bodies.of_rank.push_back(body_of(opacities[r], shows_field[r], r));
    bodies.of_missing = body_of(0, surfaces.shows_field_elsewhere, 0);
  }

  Bodies bodies;
  std::vector<bool> body_shows_field;
  std::vector<Rgb> colors;
  std::vector<double> opacities;
};

class LabelView {
 public:
  LabelView(const LabelSurfaces& surfaces, const Camera& camera, const Look& look,
            const RenderOptions& options, const view::LightVolume* light)
      : map_(*surfaces.map),
        shows_elsewhere_(surfaces.shows_field_elsewhere),
        look_(look),
        clip_planes_(options.clip_planes),
        light_(light),
        styles_(surfaces),
        lattice_(camera, options.width, options.height, map_.geometry().spacing().minCoeff(),
                 map_.geometry()),
        rays_(lattice_),
        key_(view::direction_of_light(look, camera)),
        index_from_world_(map_.geometry().world_from_index.inverse()),
        normal_from_slope_(index_from_world_.linear().transpose()),
        bounds_(map_.geometry().index_bounds()) {}

  // `nothing_before`: a depth before which nothing is looked for. Returns false if the ray would
  // begin there within something.
  bool trace(double x, double y, TracedRay& out,
             double nothing_before = -std::numeric_limits<double>::infinity()) const {
    out.clear();
    const Vec3 origin = rays_.origins().at(x, y);
    const Vec3 direction = rays_.directions().at(x, y);
    LabelRay ray{index_from_world_ * origin, index_from_world_.linear() * direction};
    std::optional<Vec3> face = clip(origin, direction, ray);
    const bool is_late = nothing_before > ray.begin;
    if (is_late) {
      ray.begin = nothing_before;
      face.reset();
    }
    if (!(ray.begin < ray.end)) return true;
    thread_local std::vector<LabelCrossing> crossings;
    crossings.clear();
    Rank first = labels::kNoLabel;
    const Bodies::Id start = labels::trace(map_.grid(), styles_.bodies, ray, &first, crossings);
    if (is_late && styles_.bodies.all[start].is_shown) return false;
    const auto add_hit = [&](double depth, Rank rank, const Vec3& normal, bool is_cut) {
      const Rgb color = color_at(origin + depth * direction, direction, normal, rank, is_cut);
      const double opacity = styles_.opacities[rank];
      Hit hit{static_cast<float>(depth), rank, {}};
      for (std::size_t c = 0; c < 3; ++c)
        hit.rgba[c] = static_cast<float>(opacity * std::clamp(color[c], 0.0, 1.0));
      hit.rgba[3] = static_cast<float>(opacity);
      out.hits.push_back(hit);
    };
    const auto note_field = [&](double depth, bool is_shown) {
      const bool before = out.changes.empty() ? shows_elsewhere_ : out.changes.back().is_shown;
      if (is_shown != before) out.changes.push_back({static_cast<float>(depth), is_shown});
    };
    note_field(ray.begin, styles_.body_shows_field[start]);
    if (face && styles_.bodies.all[start].is_shown && first != labels::kNoLabel)
      add_hit(ray.begin, first, *face, true);
    for (const LabelCrossing& crossing : crossings) {
      if (crossing.rank != labels::kNoLabel)
        add_hit(crossing.t, crossing.rank, normal_from_slope_ * crossing.into, false);
      note_field(crossing.t, styles_.body_shows_field[crossing.behind]);
    }
    note_field(ray.end, shows_elsewhere_);
    return true;
  }

  // Of a step to the next pixel at a depth where two surfaces part.
  double jump_at(double depth) const {
    const double pixel = rays_.origins().per_x.norm() + depth * rays_.directions().per_x.norm();
    return std::max(kJumpInSpacings * map_.geometry().spacing().minCoeff(), kJumpInPixels * pixel);
  }

 private:
  // To the map's box, what is in front of the eye, and what clip planes leave. Returns the normal
  // of the face by which the ray comes in; none: it begins inside.
  std::optional<Vec3> clip(const Vec3& origin, const Vec3& direction, LabelRay& ray) const {
    ray.begin = lattice_.near_depth();
    ray.end = std::numeric_limits<double>::infinity();
    std::optional<Vec3> face;
    // Of the half space where distance + t * along >= 0.
    const auto cut = [&](double distance, double along, const Vec3& normal) {
      if (along > 0) {
        const double t = -distance / along;
        if (t > ray.begin) {
          ray.begin = t;
          face = normal;
        }
      } else if (along < 0) {
        ray.end = std::min(ray.end, -distance / along);
      } else if (distance < 0) {
        ray.end = ray.begin;
      }
    };
    for (int a = 0; a < 3; ++a) {
      const Vec3 side = index_from_world_.linear().row(a).transpose();
      cut(ray.origin[a] - bounds_.min()[a], ray.direction[a], side);
      cut(bounds_.max()[a] - ray.origin[a], -ray.direction[a], -side);
    }
    for (const ClipPlane& plane : clip_planes_)
      cut(plane.normal.dot(origin) - plane.offset, plane.normal.dot(direction), plane.normal);
    return face;
  }

  // A cut shows its colour as it is, as lids do.
  Rgb color_at(const Vec3& place, const Vec3& direction, Vec3 normal, Rank rank,
               bool is_cut) const {
    Rgb color = styles_.colors[rank];
    const Vec3 to_eye = -direction.normalized();
    const double length = normal.norm();
    normal = length > 0 ? Vec3(normal / length) : to_eye;
    if (normal.dot(to_eye) < 0) normal = -normal;
    const view::ArrivingLight arriving =
        light_ != nullptr ? light_->arriving_at(place, normal, to_eye, 1, view::kEdgesAway)
                          : view::ArrivingLight{};
    if (look_.shade && !is_cut) {
      const view::LightShares light =
          view::light_shares(look_, normal, key_.value_or(to_eye), to_eye, arriving);
      return view::lit_color(color, look_.material, light, 1);
    }
    for (double& c : color) c *= view::unlit_share(arriving);
    return color;
  }

  const LabelMap& map_;
  const bool shows_elsewhere_;
  const Look& look_;
  const std::vector<ClipPlane>& clip_planes_;
  const view::LightVolume* const light_;
  const RankStyles styles_;
  const view::ViewLattice lattice_;
  const view::PixelRays rays_;
  const std::optional<Vec3> key_;  // none: from the eye
  const Affine3 index_from_world_;
  const Mat3 normal_from_slope_;
  const Bounds3 bounds_;
};

// The middle rays of a row of pixels, one after the other.
struct TracedRow {
  std::vector<Hit> hits;
  std::vector<FieldChange> changes;
  std::vector<std::uint32_t> first_hit{0}, first_change{0};

  void add(const TracedRay& ray) {
    hits.insert(hits.end(), ray.hits.begin(), ray.hits.end());
    changes.insert(changes.end(), ray.changes.begin(), ray.changes.end());
    first_hit.push_back(static_cast<std::uint32_t>(hits.size()));
    first_change.push_back(static_cast<std::uint32_t>(changes.size()));
  }
  std::span<const Hit> hits_of(int x) const {
    const auto i = static_cast<std::size_t>(x);
    return {hits.data() + first_hit[i], hits.data() + first_hit[i + 1]};
  }
  std::span<const FieldChange> changes_of(int x) const {
    const auto i = static_cast<std::size_t>(x);
    return {changes.data() + first_change[i], changes.data() + first_change[i + 1]};
  }
};

bool are_of_two_surfaces(std::span<const Hit> a, std::span<const Hit> b, const LabelView& view) {
  if (a.size() != b.size()) return true;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].rank != b[i].rank) return true;
    if (std::abs(a[i].depth - b[i].depth) > view.jump_at(std::min(a[i].depth, b[i].depth)))
      return true;
  }
  return false;
}

// The hits of several rays as one ray's, which lets the same light through: each takes from what
// the nearer ones have left.
class SharedHits {
 public:
  void begin() { parts_.clear(); }
  void add(const TracedRay& ray) {
    float through = 1.0F / kSubrays.size();
    for (const Hit& hit : ray.hits) {
      Hit part = hit;
      for (float& c : part.rgba) c *= through;
      through *= 1 - hit.rgba[3];
      parts_.push_back(part);
    }
  }
  void write_to(std::vector<Hit>& hits) {
    std::stable_sort(parts_.begin(), parts_.end(),
                     [](const Hit& a, const Hit& b) { return a.depth < b.depth; });
    hits.clear();
    float left = 1;
    for (Hit& part : parts_) {
      if (left <= 0) break;
      const float opacity = part.rgba[3];
      for (float& c : part.rgba) c = std::min(c / left, 1.0F);
      left -= opacity;
      hits.push_back(part);
    }
  }

 private:
  std::vector<Hit> parts_;
};

// Hits and changes as stops, by depth.
void append_stops(std::span<const Hit> hits, std::span<const FieldChange> changes,
                  bool shows_elsewhere, std::vector<DepthLimits::Stop>& stops) {
  constexpr float kFirst = -std::numeric_limits<float>::infinity();
  bool is_shown = shows_elsewhere;
  if (is_shown) stops.push_back({kFirst, true, false, {}});
  auto change = changes.begin();
  for (const Hit& hit : hits) {
    for (; change != changes.end() && change->depth <= hit.depth; ++change) {
      is_shown = change->is_shown;
      stops.push_back({change->depth, is_shown, false, {}});
    }
    stops.push_back({hit.depth, is_shown, false, hit.rgba});
  }
  for (; change != changes.end(); ++change)
    stops.push_back({change->depth, change->is_shown, false, {}});
}

}  // namespace

DepthLimits label_limits(const LabelSurfaces& surfaces, const Camera& camera, const Look& look,
                         const RenderOptions& options, int threads, const std::stop_token& stop,
                         const view::LightVolume* light) {
  const LabelView view(surfaces, camera, look, options, light);
  const int width = options.width;
  const int height = options.height;
  std::vector<TracedRow> rows(static_cast<std::size_t>(height));
  constexpr std::int64_t kRows = 16;
  constexpr int kColumns = 16;
  data::parallel_ranges({height, kRows, threads, stop}, [&](std::int64_t begin, std::int64_t end) {
    TracedRay ray;
    // Rays that are near each other follow each other: they meet the same bricks.
    for (int left = 0; left < width; left += kColumns) {
      for (std::int64_t y = begin; y < end; ++y) {
        for (int x = left; x < std::min(left + kColumns, width); ++x) {
          view.trace(x, static_cast<double>(y), ray);
          rows[static_cast<std::size_t>(y)].add(ray);
        }
      }
    }
  });
  // Where in a pixel with an outline the first surface can be; none: it has none.
  const auto outline_begin = [&](int x, int y) -> std::optional<double> {
    const std::span<const Hit> own = rows[static_cast<std::size_t>(y)].hits_of(x);
    bool has_outline = false;
    float nearest = std::numeric_limits<float>::infinity();
    const auto note = [&](std::span<const Hit> hits) {
      if (!hits.empty()) nearest = std::min(nearest, hits.front().depth);
    };
    note(own);
    for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      const int nx = x + dx;
      const int ny = y + dy;
      if (nx < 0 || ny < 0 || nx >= width || ny >= height) continue;
      const std::span<const Hit> other = rows[static_cast<std::size_t>(ny)].hits_of(nx);
      note(other);
      has_outline = has_outline || are_of_two_surfaces(own, other, view);
    }
    if (!has_outline) return std::nullopt;
    return nearest - view.jump_at(nearest);
  };
  return limits_by_rows({width, height, threads, stop}, [&](int x, int y, auto& stops) {
    const TracedRow& row = rows[static_cast<std::size_t>(y)];
    std::span<const Hit> hits = row.hits_of(x);
    thread_local std::vector<Hit> shared;
    if (const auto from = outline_begin(x, y)) {
      thread_local SharedHits all;
      thread_local TracedRay ray;
      all.begin();
      for (const auto& [dx, dy] : kSubrays) {
        if (!view.trace(x + dx, y + dy, ray, *from)) view.trace(x + dx, y + dy, ray);
        all.add(ray);
      }
      all.write_to(shared);
      hits = shared;
    }
    append_stops(hits, row.changes_of(x), surfaces.shows_field_elsewhere, stops);
  });
}

}  // namespace ovoid
