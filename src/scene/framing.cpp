// SPDX-License-Identifier: Apache-2.0
// A silhouette first: opacity on a coarse raster across the view axis, as if seen from far away,
// added up from regions that show (visible_points.h). A trail has a silhouette of its own. What
// they leave is fitted exactly, perspective included: each side of the view's pyramid must lie
// outside of every region.
#include "ovoid/framing.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "data/validate.h"
#include "ovoid/error.h"
#include "view/plan/visible_points.h"

namespace ovoid {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
constexpr double kFaintest = 0.05;        // of the most opaque
constexpr double kUnseen = 0.02;          // opacity of a trail that nobody sees
constexpr double kFaintestRegion = 1e-3;  // the same, of a region by itself
constexpr double kSpecks = 1e-3;          // of what shows, at each border
constexpr double kFlatBox = 0.25;         // shortest side over the next
constexpr int kRaster = 128;

// A region that shows, along the camera's axes from the middle of the field: to the right, up, and
// away from the eye.
struct Region {
  float right, up, away;
  float half_width, half_height;
  float absorption;
};

// An interval of one coordinate.
struct Extent {
  double lo = kUnbounded;
  double hi = -kUnbounded;
  void take(double x, double half = 0) {
    lo = std::min(lo, x - half);
    hi = std::max(hi, x + half);
  }
  double middle() const { return 0.5 * (lo + hi); }
  double half() const { return 0.5 * (hi - lo); }
};

// Rows are along `up`.
class Silhouette {
 public:
  // `least`: opacity from which on something counts.
  Silhouette(const std::vector<Region>& regions, double least) {
    Extent across;
    Extent along;
    for (const Region& region : regions) {
      across.take(region.right, region.half_width);
      along.take(region.up, region.half_height);
    }
    lo_ = {across.lo, along.lo};
    cell_ = 2 * std::max(across.half(), along.half()) / kRaster;
    for (const Region& region : regions) {
      add(region);
      most_ = std::max(most_, optical_depth(region));
    }
    for (float& depth : cells_) depth = 1 - std::exp(-depth);  // opacity from here on
    const float most = *std::max_element(cells_.begin(), cells_.end());
    for (float& opacity : cells_) {
      if (opacity < std::max(kFaintest * most, least)) opacity = 0;
    }
    drop_specks();
  }

  // It may be seen, and not by what lies before or behind it alone.
  bool shows(const Region& region) const {
    const auto x = static_cast<int>((region.right - lo_[0]) / cell_);
    const auto y = static_cast<int>((region.up - lo_[1]) / cell_);
    const bool is_in_sight = x >= first_[0] && x <= last_[0] && y >= first_[1] && y <= last_[1];
    if (optical_depth(region) < kFaintestRegion * most_) return false;
    return is_in_sight && cells_[cell_at(x, y)] > 0;
  }

 private:
  // Cells that a span covers, and how far each.
  struct Span {
    int first, last;
    double lo, hi;  // in cells

    double share(int cell) const {
      return std::max(0.0, std::min(hi, cell + 1.0) - std::max(lo, static_cast<double>(cell)));
    }
  };
  Span span(double middle, double half, std::size_t axis) const {
    const double wide = std::max(half / cell_, 0.5);
    const double at = (middle - lo_[axis]) / cell_;
    const auto clamped = [](double cell) {
      return std::clamp(static_cast<int>(std::floor(cell)), 0, kRaster - 1);
    };
    return {clamped(at - wide), clamped(at + wide), at - wide, at + wide};
  }

  static std::size_t cell_at(int x, int y) {
    return static_cast<std::size_t>(y) * kRaster + static_cast<std::size_t>(x);
  }

  static double optical_depth(const Region& region) {
    return region.absorption / (4.0 * region.half_width * region.half_height);
  }

  void add(const Region& region) {
    const Span x = span(region.right, region.half_width, 0);
    const Span y = span(region.up, region.half_height, 1);
    const double depth = region.absorption / ((x.hi - x.lo) * (y.hi - y.lo) * cell_ * cell_);
    for (int row = y.first; row <= y.last; ++row) {
      for (int column = x.first; column <= x.last; ++column) {
        cells_[cell_at(column, row)] += static_cast<float>(depth * x.share(column) * y.share(row));
      }
    }
  }

  void drop_specks() {
    std::array<std::vector<double>, 2> sums{std::vector<double>(kRaster),
                                            std::vector<double>(kRaster)};
    double total = 0;
    for (int y = 0; y < kRaster; ++y) {
      for (int x = 0; x < kRaster; ++x) {
        const double opacity = cells_[cell_at(x, y)];
        sums[0][static_cast<std::size_t>(x)] += opacity;
        sums[1][static_cast<std::size_t>(y)] += opacity;
        total += opacity;
      }
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const auto passed = [&](double seen) { return seen > kSpecks * total; };
      double seen = 0;
      for (int i = 0; i < kRaster && !passed(seen += sums[axis][static_cast<std::size_t>(i)]); ++i)
        first_[axis] = i + 1;
      seen = 0;
      for (int i = kRaster - 1; i >= 0 && !passed(seen += sums[axis][static_cast<std::size_t>(i)]);
           --i)
        last_[axis] = i - 1;
    }
  }

  std::array<double, 2> lo_{};
  double cell_ = 1;
  double most_ = 0;  // optical depth of any region
  std::vector<float> cells_ = std::vector<float>(static_cast<std::size_t>(kRaster) * kRaster);
  std::array<int, 2> first_{0, 0};
  std::array<int, 2> last_{kRaster - 1, kRaster - 1};
};

struct CameraAxes {
  Vec3 right, up, away;
};

CameraAxes axes_of(const Camera& camera) {
  const Vec3 away = (camera.focal_point - camera.position).normalized();
  const Vec3 right = away.cross(camera.view_up).normalized();
  return {right, right.cross(away), away};
}

// Regions by the camera's axes, from `middle`.
class RegionList {
 public:
  RegionList(const CameraAxes& axes, const Vec3& middle) : axes_(axes), middle_(middle) {}

  void add(const view::VisiblePoint& point) {
    const Vec3 from_middle = point.place - middle_;
    const auto along = [&](const Vec3& axis) { return static_cast<float>(from_middle.dot(axis)); };
    const auto reach = [&](const Vec3& axis) {
      return static_cast<float>((point.extent.transpose() * axis).norm());
    };
    regions_.push_back({along(axes_.right), along(axes_.up), along(axes_.away), reach(axes_.right),
                        reach(axes_.up), static_cast<float>(point.absorption)});
  }
  std::vector<Region> take() { return std::move(regions_); }

 private:
  const CameraAxes axes_;
  const Vec3 middle_;
  std::vector<Region> regions_;
};

// Those that show; `least` as in Silhouette.
std::vector<Region> regions_seen(std::vector<Region> regions, double least) {
  if (regions.empty()) return regions;
  const Silhouette silhouette(regions, least);
  std::erase_if(regions, [&](const Region& region) { return !silhouette.shows(region); });
  return regions;
}

// Of many moments each has its part of the points, but as many as tell what it is like.
std::int64_t points_of_moment(std::size_t num_moments) {
  constexpr std::int64_t kLeast = 20'000;
  return std::max(kLeast, view::kVisiblePoints / static_cast<std::int64_t>(num_moments));
}

// `look`: of the field that it is the trail of.
void add_trail(const Trail& trail, const Look& look, const std::vector<ClipPlane>& planes,
               RegionList* list) {
  Look own;
  own.transfer_function = trail.transfer_function;
  own.unit_distance = look.unit_distance;
  if (trail.moments.empty()) {
    view::for_visible_points(trail.field, own, planes,
                             [&](const view::VisiblePoint& point) { list->add(point); });
  }
  double sum = 0;
  for (const KernelMoment& moment : trail.moments) sum += moment.share;
  for (const KernelMoment& moment : trail.moments) {
    view::for_visible_points(
        moment.field, own, planes,
        [&](view::VisiblePoint point) {
          point.absorption *= moment.share / sum;
          list->add(point);
        },
        points_of_moment(trail.moments.size()));
  }
}

// Everything that shows, as a box along the camera's axes.
struct VisibleBox {
  Extent right, up, away;
  double radius = 0;  // of the ball around the box's middle that holds all
};

VisibleBox box_of(const std::vector<Region>& regions) {
  VisibleBox box;
  for (const Region& region : regions) {
    box.right.take(region.right, region.half_width);
    box.up.take(region.up, region.half_height);
    box.away.take(region.away, 0.5F * (region.half_width + region.half_height));
  }
  const Vec3 middle(box.right.middle(), box.up.middle(), box.away.middle());
  for (const Region& region : regions) {
    const double reach = std::max(region.half_width, region.half_height);
    box.radius =
        std::max(box.radius, (Vec3(region.right, region.up, region.away) - middle).norm() + reach);
  }
  return box;
}

// Where the eye is, along the camera's axes: as near as two opposite sides of the pyramid, whose
// slope is `tangent`, allow, and half-way between them. `sides`: greatest of +-x - tangent * away.
struct Sides {
  double high = -kUnbounded;
  double low = -kUnbounded;

  void take(double x, double half, double away, double tangent) {
    high = std::max(high, x + half - tangent * away);
    low = std::max(low, half - x - tangent * away);
  }
  double away(double tangent) const { return -(high + low) / (2 * tangent); }
  double across() const { return 0.5 * (high - low); }
};

void validate(const Framing& framing) {
  if (!(framing.aspect > 0.0) || !std::isfinite(framing.aspect)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("framing aspect = {}: must be finite and > 0", framing.aspect));
  }
  if (!(framing.fill > 0.0 && framing.fill <= 1.0)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("framing fill = {}: must be in (0, 1]", framing.fill));
  }
}

// The camera moved to where it sees all regions, of which there are some, as `framing` says.
Camera fitted(Camera camera, const std::vector<Region>& regions, const Framing& framing,
              const CameraAxes& axes, const Vec3& middle) {
  const VisibleBox box = box_of(regions);
  const auto to_world = [&](double right, double up, double away) {
    return Vec3(middle + right * axes.right + up * axes.up + away * axes.away);
  };
  const double half_angle = camera.view_angle * (std::numbers::pi / 360);
  const double narrow = std::min(framing.aspect, 1.0);
  if (framing.is_for_turning) {
    const double tangent = std::tan(half_angle) * narrow;
    const double radius = box.radius / framing.fill;
    camera.focal_point = to_world(box.right.middle(), box.up.middle(), box.away.middle());
    camera.position = camera.focal_point - radius / std::sin(std::atan(tangent)) * axes.away;
    camera.parallel_scale = radius / narrow;
    return camera;
  }
  const double vertical = framing.fill * std::tan(half_angle);
  const double horizontal = vertical * framing.aspect;
  Sides across;
  Sides along;
  for (const Region& region : regions) {
    across.take(region.right, region.half_width, region.away, horizontal);
    along.take(region.up, region.half_height, region.away, vertical);
  }
  const double eye = std::min(across.away(horizontal), along.away(vertical));
  if (camera.parallel_projection) {
    camera.focal_point = to_world(box.right.middle(), box.up.middle(), box.away.middle());
  } else {
    camera.focal_point = to_world(across.across(), along.across(), box.away.middle());
  }
  camera.position = camera.focal_point - (box.away.middle() - eye) * axes.away;
  camera.parallel_scale = std::max(box.up.half(), box.right.half() / framing.aspect) / framing.fill;
  return camera;
}

// Where clip planes cut the sides of triangles, in what they keep.
template <class Add>
void add_cuts(const Surface& surface, const std::vector<ClipPlane>& planes, const Add& add) {
  if (planes.empty()) return;
  for (const Surface::Triangle& triangle : surface.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3& from = surface.places[triangle.corners[c]];
      const Vec3 side = surface.places[triangle.corners[(c + 1) % 3]] - from;
      double begin = 0;
      double end = 1;
      for (const ClipPlane& plane : planes) {
        const double slope = plane.normal.dot(side);
        const double missing = plane.offset - plane.normal.dot(from);
        if (slope > 0) begin = std::max(begin, missing / slope);
        if (slope < 0) end = std::min(end, missing / slope);
        if (slope == 0 && missing > 0) end = -1;
      }
      if (begin > end) continue;
      if (begin > 0) add(from + begin * side);
      if (end < 1) add(from + end * side);
    }
  }
}

// Places have no size; a thousandth of the whole keeps a single one from being infinitely near.
void add_surface(const Surface& surface, const std::vector<ClipPlane>& planes, RegionList* list) {
  const Mat3 speck = Mat3::Identity() * std::max(1e-3 * surface.bounds.diagonal().norm(), 1e-30);
  for (const Vec3& place : surface.places) {
    if (view::is_kept(place, planes)) list->add({place, 1, speck});
  }
  add_cuts(surface, planes, [&](const Vec3& place) { list->add({place, 1, speck}); });
}

bool shows_nothing(const Look& look) {
  const std::vector<OpacityPoint>& opacities = look.transfer_function.opacities;
  return look.mode == Mode::kComposite && !look.transfer_function_2d && !opacities.empty() &&
         std::all_of(opacities.begin(), opacities.end(),
                     [](const OpacityPoint& point) { return point.opacity == 0; });
}

// What of the first volume is to fill the picture, by value.
Look framed_look(const Scene& scene) {
  const Volume& volume = scene.volumes.front();
  Look look = volume.look;
  const bool is_by_slices = !scene.slices.empty() && shows_nothing(look);
  if (!volume.points && !is_by_slices) return look;
  look.transfer_function.opacities.clear();
  if (is_by_slices) look.transfer_function.opacities = scene.slices.front().colors.opacities;
  look.transfer_function.gradient_opacities.clear();
  return look;
}

}  // namespace

Camera first_camera(const Field& field, const Bounds3& bounds, Space space, double aspect) {
  data::require_field(field);
  const LatticeField* const lattice = field.lattice();
  const bool has_spacing =
      lattice == nullptr || lattice->geometry().spacing() != Vec3(Vec3::Constant(1.0));
  if (space != Space::kNone && has_spacing)
    return default_camera(bounds, space, "anterior", aspect);
  const Vec3 sides = bounds.sizes();
  Eigen::Index flat = 0;
  const double least = sides.minCoeff(&flat);
  const double next = std::min(sides[(flat + 1) % 3], sides[(flat + 2) % 3]);
  std::string view = sides.x() >= sides.y() ? "three-quarter" : "three-quarter-side";
  if (least < kFlatBox * next) view = flat == 0 ? "+x" : flat == 1 ? "-y" : "+z";
  return default_camera(bounds, space, view, aspect);
}

Camera framed(Camera camera, const Scene& scene, const Framing& framing) {
  scene.validate();
  camera.validate();
  validate(framing);
  const CameraAxes axes = axes_of(camera);
  const std::vector<ClipPlane>& planes = framing.clip_planes;
  if (scene.volumes.empty()) {
    Bounds3 bounds;
    for (const Geometry& one : scene.surfaces) bounds.extend(one.surface->bounds);
    if (bounds.isEmpty()) return camera;
    RegionList list(axes, bounds.center());
    for (const Geometry& one : scene.surfaces) add_surface(*one.surface, {}, &list);
    return fitted(std::move(camera), list.take(), framing, axes, bounds.center());
  }
  const Volume& first = scene.volumes.front();
  if (first.boundary != nullptr && first.walls.opacity > 0 && first.trail == nullptr) {
    const Vec3 middle = first.boundary->bounds.center();
    RegionList list(axes, middle);
    add_surface(*first.boundary, planes, &list);
    const std::vector<Region> regions = list.take();
    return regions.empty() ? camera : fitted(std::move(camera), regions, framing, axes, middle);
  }
  const Vec3 middle = first.field.world_bounds().center();
  const auto in_list = [](RegionList* list) {
    return [list](const view::VisiblePoint& point) { list->add(point); };
  };
  RegionList list(axes, middle);
  view::for_visible_points(first.field, framed_look(scene), planes, in_list(&list));
  for (std::size_t i = 1; i < scene.volumes.size(); ++i) {
    view::for_visible_points(scene.volumes[i].field, scene.volumes[i].look, planes, in_list(&list));
  }
  std::vector<Region> regions = regions_seen(list.take(), 0);
  if (first.trail != nullptr) {
    RegionList of_trail(axes, middle);
    add_trail(*first.trail, first.look, planes, &of_trail);
    const std::vector<Region> trail = regions_seen(of_trail.take(), kUnseen);
    regions.insert(regions.end(), trail.begin(), trail.end());
  }
  if (regions.empty()) return camera;
  return fitted(std::move(camera), regions, framing, axes, middle);
}

}  // namespace ovoid
