// SPDX-License-Identifier: Apache-2.0
#include "render/passes/surface_raster.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "view/plan/visible_points.h"

namespace ovoid {
namespace {

// Of the focal distance: what is nearer to the eye is cut.
constexpr double kNear = 1e-3;
constexpr float kFarthest = std::numeric_limits<float>::infinity();

// Twice the signed area of (a, b, p); of the three sides of a triangle that holds p all have one
// sign.
template <class Corner>
double side(const Corner& a, const Corner& b, double x, double y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

// A place exactly on a side belongs to one of the two triangles that share it.
template <class Corner>
bool takes_side(const Corner& a, const Corner& b) {
  return a.y < b.y || (a.y == b.y && a.x > b.x);
}

}  // namespace

struct TileWork {
  struct Entry {
    SurfaceFragment fragment;
    std::uint16_t pixel;
  };
  std::vector<Entry> entries;
  // Of opaque surfaces: the nearest depth at each place.
  std::array<std::array<float, SurfaceRaster::kPlaces>, SurfaceRaster::kTile * SurfaceRaster::kTile>
      nearest;
};

SurfaceRaster::SurfaceRaster(const Surface& surface, const Camera& camera,
                             const RenderOptions& options, Faces faces)
    : surface_(surface),
      is_parallel_(camera.parallel_projection),
      eye_(camera.position),
      width_(options.width),
      height_(options.height),
      tiles_(options.width, options.height),
      faces_(faces) {
  if (faces == Faces::kDrawn) clip_planes_ = options.clip_planes;
  const Vec3 towards = camera.focal_point - camera.position;
  axis_ = towards.normalized();
  right_ = axis_.cross(camera.view_up).normalized();
  up_ = right_.cross(axis_);
  near_ = kNear * towards.norm();
  const double half_height =
      is_parallel_ ? camera.parallel_scale : std::tan(camera.view_angle * (std::numbers::pi / 360));
  scale_ = height_ / (2 * half_height);
  for (std::uint32_t i = 0; i < surface.triangles.size(); ++i) add_triangle(i);

  tiles_.assign(static_cast<std::uint32_t>(parts_.size()), [&](std::uint32_t part) {
    const auto& [a, b, c] = parts_[part].corners;
    const auto [left, right] = std::minmax({a.x, b.x, c.x});
    const auto [top, bottom] = std::minmax({a.y, b.y, c.y});
    return PictureExtent{left, right, top, bottom};
  });
}

SurfaceRaster::Corner SurfaceRaster::corner_of(const Vec3& view) const {
  const double scale = is_parallel_ ? scale_ : scale_ / view.z();
  return {0.5 * width_ + view.x() * scale, 0.5 * height_ - view.y() * scale,
          is_parallel_ ? view.z() : 1 / view.z()};
}

void SurfaceRaster::add_part(const Part& part) {
  const auto& [a, b, c] = part.corners;
  const double area = side(a, b, c.x, c.y);
  if (area != 0 && std::isfinite(area)) parts_.push_back(part);
}

void SurfaceRaster::add_triangle(std::uint32_t number) {
  const Surface::Triangle& triangle = surface_.triangles[number];
  // Corners in the camera's axes, and what they are of the triangle's own.
  struct Point {
    Vec3 view;
    Vec3 shares;
  };
  std::array<Point, 3> own;
  int num_before = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (faces_ == Faces::kDrawn && std::isnan(triangle.values[c])) return;
    const Vec3 from_eye = surface_.places[triangle.corners[c]] - eye_;
    own[c] = {{from_eye.dot(right_), from_eye.dot(up_), from_eye.dot(axis_)},
              Vec3::Unit(static_cast<Eigen::Index>(c))};
    if (own[c].view.z() > near_) ++num_before;
  }
  if (num_before == 0) return;
  const auto part_of = [&](const Point& a, const Point& b, const Point& c, bool is_cut) {
    Part part{number, is_cut, {corner_of(a.view), corner_of(b.view), corner_of(c.view)}, {}};
    std::size_t i = 0;
    for (const Point* point : {&a, &b, &c}) {
      for (std::size_t s = 0; s < 3; ++s)
        part.shares[i][s] = static_cast<float>(point->shares[static_cast<Eigen::Index>(s)]);
      ++i;
    }
    return part;
  };
  if (num_before == 3) return add_part(part_of(own[0], own[1], own[2], false));
  std::vector<Point> left;  // of the triangle, before the near plane
  for (std::size_t c = 0; c < 3; ++c) {
    const Point& from = own[c];
    const Point& to = own[(c + 1) % 3];
    if (from.view.z() > near_) left.push_back(from);
    if ((from.view.z() > near_) == (to.view.z() > near_)) continue;
    const double t = (near_ - from.view.z()) / (to.view.z() - from.view.z());
    left.push_back(
        {from.view + t * (to.view - from.view), from.shares + t * (to.shares - from.shares)});
  }
  for (std::size_t i = 1; i + 1 < left.size(); ++i)
    add_part(part_of(left[0], left[i], left[i + 1], true));
}

void SurfaceRaster::rasterize(const Part& part, int tile, bool is_opaque, TileWork& work) const {
  const int x_first = tile_x(tile);
  const int y_first = tile_y(tile);
  // Turned so that the inside is on the positive side of all three.
  std::array<std::size_t, 3> turn{0, 1, 2};
  const double area = side(part.corners[0], part.corners[1], part.corners[2].x, part.corners[2].y);
  if (area < 0) std::swap(turn[1], turn[2]);
  const std::array<Corner, 3> c{part.corners[turn[0]], part.corners[turn[1]],
                                part.corners[turn[2]]};
  const auto bound = [](double at, int first, int count) {
    return static_cast<int>(
        std::clamp(std::floor(at), static_cast<double>(first), static_cast<double>(first + count)));
  };
  const auto [left, right] = std::minmax({c[0].x, c[1].x, c[2].x});
  const auto [top, bottom] = std::minmax({c[0].y, c[1].y, c[2].y});
  const int x_end = std::min(bound(right, x_first, kTile) + 1, std::min(x_first + kTile, width_));
  const int y_end = std::min(bound(bottom, y_first, kTile) + 1, std::min(y_first + kTile, height_));
  const double inverse_area = 1 / std::abs(area);
  std::array<double, 3> side_length;
  for (std::size_t i = 0; i < 3; ++i) {
    const Corner& to = c[(i + 1) % 3];
    side_length[i] = std::max(std::hypot(to.x - c[i].x, to.y - c[i].y), 1e-12);
  }
  // In the picture these go straight from corner to corner; in space shares go by 1 / depth.
  const auto shares_at = [&](double x, double y) {
    std::array<double, 3> shares;
    for (std::size_t i = 0; i < 3; ++i)
      shares[i] = side(c[(i + 1) % 3], c[(i + 2) % 3], x, y) * inverse_area;
    return shares;
  };
  const auto z_at = [&](const std::array<double, 3>& shares) {
    return shares[0] * c[0].z + shares[1] * c[1].z + shares[2] * c[2].z;
  };
  const auto is_kept = [&](int x, int y, std::size_t place, double z) {
    const Ray ray = ray_through(x, y, static_cast<int>(place));
    return view::is_kept(ray.origin + (is_parallel_ ? z : 1 / z) * ray.direction, clip_planes_);
  };
  for (int y = bound(top, y_first, kTile); y < y_end; ++y) {
    for (int x = bound(left, x_first, kTile); x < x_end; ++x) {
      std::uint8_t covered = 0;
      double mid_x = 0;
      double mid_y = 0;
      for (std::size_t p = 0; p < kPlaces; ++p) {
        const double px = x + kPlacesInPixel[p][0];
        const double py = y + kPlacesInPixel[p][1];
        bool is_inside = true;
        for (std::size_t i = 0; i < 3 && is_inside; ++i) {
          const double s = side(c[i], c[(i + 1) % 3], px, py);
          is_inside = s > 0 || (s == 0 && takes_side(c[i], c[(i + 1) % 3]));
        }
        if (!is_inside) continue;
        if (!clip_planes_.empty() && !is_kept(x, y, p, z_at(shares_at(px, py)))) continue;
        covered = static_cast<std::uint8_t>(covered | 1U << p);
        mid_x += px;
        mid_y += py;
      }
      if (covered == 0) continue;
      const int num_covered = std::popcount(covered);
      mid_x /= num_covered;
      mid_y /= num_covered;
      const std::array<double, 3> shares = shares_at(mid_x, mid_y);
      const double z = z_at(shares);
      const auto depth = static_cast<float>(is_parallel_ ? z : 1 / z);
      TileWork::Entry entry{};
      entry.pixel = static_cast<std::uint16_t>((y - y_first) * kTile + (x - x_first));
      if (is_opaque) {
        const auto& nearest = work.nearest[entry.pixel];
        bool is_hidden = true;
        for (std::size_t p = 0; p < kPlaces; ++p) {
          if ((covered >> p & 1U) != 0 && depth < nearest[p]) is_hidden = false;
        }
        if (is_hidden) continue;
      }
      SurfaceFragment& fragment = entry.fragment;
      fragment.triangle = part.triangle;
      fragment.covered = covered;
      if (surface_.triangles[part.triangle].is_boundary)
        fragment.enters = area < 0 ? 1 : -1;  // seen counterclockwise: y goes down in a picture
      fragment.depth = depth;
      fragment.edge_distance.fill(kFarthest);
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t own = turn[i];
        const auto share = static_cast<float>(is_parallel_ ? shares[i] : shares[i] * c[i].z / z);
        if (!part.is_cut) {
          fragment.shares[own] = share;
          const double distance = side(c[i], c[(i + 1) % 3], mid_x, mid_y) / side_length[i];
          // The side from corner i to the next, turned, is that from the one with the lower number.
          const std::size_t a = turn[i];
          const std::size_t b = turn[(i + 1) % 3];
          fragment.edge_distance[(a + 1) % 3 == b ? a : b] = static_cast<float>(distance);
        } else {
          for (std::size_t s = 0; s < 3; ++s) fragment.shares[s] += share * part.shares[own][s];
        }
      }
      if (is_opaque) {
        auto& nearest = work.nearest[entry.pixel];
        for (std::size_t p = 0; p < kPlaces; ++p) {
          if ((covered >> p & 1U) != 0) nearest[p] = std::min(nearest[p], depth);
        }
      }
      work.entries.push_back(entry);
    }
  }
}

SurfaceRaster::TileFragments SurfaceRaster::tile_fragments(int tile, bool is_opaque) const {
  TileWork work;
  for (auto& places : work.nearest) places.fill(kFarthest);
  for (const std::uint32_t part : tiles_.of_tile(tile))
    rasterize(parts_[part], tile, is_opaque, work);
  // Dealt to their pixels, of which each has few.
  TileFragments out;
  for (const TileWork::Entry& entry : work.entries)
    ++out.first[static_cast<std::size_t>(entry.pixel) + 1];
  for (std::size_t i = 1; i < out.first.size(); ++i) out.first[i] += out.first[i - 1];
  out.fragments.resize(work.entries.size());
  std::array<std::uint32_t, kTile * kTile> next;
  std::copy_n(out.first.begin(), next.size(), next.begin());
  for (const TileWork::Entry& entry : work.entries)
    out.fragments[next[entry.pixel]++] = entry.fragment;
  const auto is_before = [](const SurfaceFragment& a, const SurfaceFragment& b) {
    return std::tie(a.depth, a.triangle) < std::tie(b.depth, b.triangle);
  };
  for (std::size_t pixel = 0; pixel < next.size(); ++pixel)
    std::sort(out.fragments.begin() + out.first[pixel],
              out.fragments.begin() + out.first[pixel + 1], is_before);
  return out;
}

SurfaceRaster::Ray SurfaceRaster::ray_through(int x, int y, int place) const {
  const auto& [across, down] = kPlacesInPixel[static_cast<std::size_t>(place)];
  const Vec3 aside =
      ((x + across - 0.5 * width_) * right_ - (y + down - 0.5 * height_) * up_) / scale_;
  return is_parallel_ ? Ray{eye_ + aside, axis_} : Ray{eye_, axis_ + aside};
}

float SurfaceRaster::depth_at(const SurfaceFragment& fragment, int x, int y, int place) const {
  const auto& [a, b, c] = surface_.triangles[fragment.triangle].corners;
  const Vec3& corner = surface_.places[a];
  const Vec3 normal = (surface_.places[b] - corner).cross(surface_.places[c] - corner);
  const Ray ray = ray_through(x, y, place);
  const double depth = normal.dot(corner - ray.origin) / normal.dot(ray.direction);
  // Of triangles seen edge-on rounding decides; the middle of what is covered does then.
  const bool is_sound = std::isfinite(depth) && depth > near_;
  return is_sound ? static_cast<float>(depth) : fragment.depth;
}

Vec3 SurfaceRaster::place_of(const SurfaceFragment& fragment) const {
  const Surface::Triangle& triangle = surface_.triangles[fragment.triangle];
  Vec3 place = Vec3::Zero();
  for (std::size_t c = 0; c < 3; ++c)
    place += static_cast<double>(fragment.shares[c]) * surface_.places[triangle.corners[c]];
  return place;
}

Vec3 SurfaceRaster::towards_eye(const Vec3& place) const {
  return is_parallel_ ? Vec3(-axis_) : Vec3((eye_ - place).normalized());
}

}  // namespace ovoid
