// SPDX-License-Identifier: Apache-2.0
// In: a mesh's surface and a camera. Out: stops for every pixel, from the fragments of a tile at a
// time: where the ray at one of its places comes in and goes out, and the walls at all of them.
#include "render/passes/boundary_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "data/parallel.h"
#include "ovoid/error.h"
#include "render/passes/mesh_crossings.h"
#include "render/passes/pixel_stops.h"
#include "render/passes/surface_raster.h"
#include "render/passes/surface_shader.h"
#include "view/plan/visible_points.h"

namespace ovoid {
namespace {

constexpr int kRays = SurfaceRaster::kPlaces;

// Fragments that follow each other and are one wall: triangles that share a side in this pixel.
struct Wall {
  std::span<const SurfaceFragment> fragments;
  std::uint8_t covered = 0;

  bool is_joined_by(const SurfaceFragment& next) const {
    return (covered & next.covered) == 0 && fragments.front().enters == next.enters;
  }
};

// Which rays of a pixel meet the mesh, and the one that speaks for it.
struct Rays {
  int num_shown = 0;  // that are inside somewhere, or meet a flat cell
  int chosen = 0;     // one of those with the most frequent number of spans
};

Rays rays_of(std::span<const SurfaceFragment> fragments) {
  // Most pixels have no outline in them: their rays are alike.
  constexpr unsigned kAll = (1U << kRays) - 1;
  const bool is_plain =
      !fragments.empty() && std::all_of(fragments.begin(), fragments.end(),
                                        [](const SurfaceFragment& f) { return f.covered == kAll; });
  if (is_plain) return {kRays, 0};
  std::array<int, kRays> num_spans{};
  std::array<bool, kRays> is_shown{};
  MeshCount count(fragments);
  std::array<bool, kRays> was_inside{};
  const auto note_ray = [&](int p) {
    const auto at = static_cast<std::size_t>(p);
    const bool is_inside = count.is_inside(p);
    if (is_inside && !was_inside[at]) ++num_spans[at];
    was_inside[at] = is_inside;
    is_shown[at] = is_shown[at] || is_inside;
  };
  for (int p = 0; p < kRays; ++p) note_ray(p);
  for (const SurfaceFragment& fragment : fragments) {
    count.pass(fragment);
    for (int p = 0; p < kRays; ++p) {
      if ((fragment.covered >> p & 1U) == 0) continue;
      note_ray(p);
      if (fragment.enters == 0) is_shown[static_cast<std::size_t>(p)] = true;
    }
  }
  Rays rays;
  std::ptrdiff_t most = 0;
  for (std::size_t p = 0; p < kRays; ++p) {
    if (!is_shown[p]) continue;
    ++rays.num_shown;
    std::ptrdiff_t alike = 0;
    for (std::size_t q = 0; q < kRays; ++q)
      alike += is_shown[q] && num_spans[q] == num_spans[p] ? 1 : 0;
    if (alike <= most) continue;
    most = alike;
    rays.chosen = static_cast<int>(p);
  }
  return rays;
}

class BoundaryPainter {
 public:
  BoundaryPainter(const Surface& surface, const Camera& camera, const Look& look,
                  const SurfaceStyle& walls, const RenderOptions& options,
                  const view::LightVolume* light)
      : surface_(surface),
        clip_planes_(options.clip_planes),
        opacity_(walls.opacity),
        raster_(surface, camera, options, SurfaceRaster::Faces::kAll),
        shader_(surface, raster_, camera, look, walls.shows_edges, light) {}

  const SurfaceRaster& raster() const noexcept { return raster_; }

  // Appends the pixel's stops. Returns its coverage.
  float add_pixel(int x, int y, std::span<const SurfaceFragment> all,
                  std::vector<DepthLimits::Stop>& stops) const {
    thread_local std::vector<SurfaceFragment> kept;
    thread_local std::vector<DepthLimits::Stop> limits, walls;
    drop_inner_boundaries(all, kept);
    const Rays rays = rays_of(kept);
    if (rays.num_shown == 0) return 0;
    const auto depth_of = [&](const SurfaceFragment& fragment) {
      return raster_.depth_at(fragment, x, y, rays.chosen);
    };
    find_limits(kept, rays.chosen, depth_of, limits);
    find_walls(kept, rays, depth_of, walls);
    add_by_depth(limits, walls, stops);
    return static_cast<float>(rays.num_shown) / kRays;
  }

 private:
  // Where the chosen ray comes in and goes out, without gaps between touching cells.
  template <class DepthOf>
  static void find_limits(std::span<const SurfaceFragment> fragments, int chosen,
                          const DepthOf& depth_of, std::vector<DepthLimits::Stop>& limits) {
    thread_local std::vector<std::pair<float, int>> crossings;
    crossings.clear();
    limits.clear();
    int sum = 0;
    for (const SurfaceFragment& fragment : fragments) {
      if ((fragment.covered >> chosen & 1U) == 0 || fragment.enters == 0) continue;
      crossings.emplace_back(depth_of(fragment), fragment.enters);
      sum += fragment.enters;
    }
    std::sort(crossings.begin(), crossings.end());
    const int least = std::min(sum, 0);
    int count = 0;
    bool is_inside = count > least;
    if (is_inside) limits.push_back({-std::numeric_limits<float>::infinity(), true, {}});
    for (const auto& [depth, enters] : crossings) {
      count += enters;
      if (is_inside == (count > least)) continue;
      is_inside = !is_inside;
      if (is_inside && !limits.empty() && is_one_place(limits.back().depth, depth)) {
        limits.pop_back();
      } else {
        limits.push_back({depth, is_inside, {}});
      }
    }
  }

  template <class DepthOf>
  void find_walls(std::span<const SurfaceFragment> fragments, const Rays& rays,
                  const DepthOf& depth_of, std::vector<DepthLimits::Stop>& walls) const {
    walls.clear();
    if (opacity_ == 0) return;
    for (std::size_t begin = 0; begin < fragments.size();) {
      const Wall wall = wall_from(fragments.subspan(begin));
      begin += wall.fragments.size();
      const std::array<float, 4> rgba = color_of(wall, rays);
      if (rgba[3] == 0) continue;
      float depth = wall.fragments.front().depth;
      for (const SurfaceFragment& fragment : wall.fragments) {
        if ((fragment.covered >> rays.chosen & 1U) != 0) depth = depth_of(fragment);
      }
      walls.push_back({depth, false, false, rgba});
    }
    std::sort(walls.begin(), walls.end(),
              [](const auto& a, const auto& b) { return a.depth < b.depth; });
  }

  static void add_by_depth(std::span<const DepthLimits::Stop> limits,
                           std::span<const DepthLimits::Stop> walls,
                           std::vector<DepthLimits::Stop>& stops) {
    bool is_inside = false;
    while (!limits.empty() || !walls.empty()) {
      const bool takes_limit =
          walls.empty() || (!limits.empty() && limits.front().depth <= walls.front().depth);
      const bool takes_wall =
          limits.empty() || (!walls.empty() && walls.front().depth <= limits.front().depth);
      DepthLimits::Stop stop{};
      if (takes_wall) {
        stop = walls.front();
        walls = walls.subspan(1);
      }
      if (takes_limit) {
        stop.depth = limits.front().depth;
        is_inside = limits.front().is_field_behind;
        limits = limits.subspan(1);
      }
      stop.is_field_behind = is_inside;
      stops.push_back(stop);
    }
  }

  static Wall wall_from(std::span<const SurfaceFragment> fragments) {
    Wall wall{fragments.first(1), fragments.front().covered};
    while (wall.fragments.size() < fragments.size()) {
      const SurfaceFragment& next = fragments[wall.fragments.size()];
      if (!wall.is_joined_by(next)) break;
      wall.covered = static_cast<std::uint8_t>(wall.covered | next.covered);
      wall.fragments = fragments.first(wall.fragments.size() + 1);
    }
    return wall;
  }

  // Premultiplied: the mean over the rays that are shown.
  std::array<float, 4> color_of(const Wall& wall, const Rays& rays) const {
    std::array<float, 4> rgba{};
    for (const SurfaceFragment& fragment : wall.fragments) {
      if (!is_drawn(fragment)) continue;
      const double alpha = opacity_ * std::popcount(fragment.covered) / rays.num_shown;
      const Rgb color = shader_.color_of(fragment);
      for (std::size_t c = 0; c < 3; ++c) rgba[c] += static_cast<float>(alpha * color[c]);
      rgba[3] += static_cast<float>(alpha);
    }
    for (float& c : rgba) c = std::clamp(c, 0.0F, 1.0F);
    return rgba;
  }

  bool is_drawn(const SurfaceFragment& fragment) const {
    const auto& values = surface_.triangles[fragment.triangle].values;
    if (std::any_of(values.begin(), values.end(), [](float v) { return std::isnan(v); }))
      return false;
    return view::is_kept(raster_.place_of(fragment), clip_planes_);
  }

  const Surface& surface_;
  const std::vector<ClipPlane>& clip_planes_;
  const double opacity_;
  const SurfaceRaster raster_;
  const SurfaceShader shader_;
};

}  // namespace

DepthLimits boundary_limits(const Surface& surface, const Camera& camera, const Look& look,
                            const SurfaceStyle& walls, const RenderOptions& options, int threads,
                            std::stop_token stop, const view::LightVolume* light) try {
  camera.validate();
  look.validate();
  options.validate();
  if (!(walls.opacity >= 0 && walls.opacity <= 1)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("walls.opacity = {}: must be in [0, 1]", walls.opacity));
  }
  const BoundaryPainter painter(surface, camera, look, walls, options, light);
  return limits_of_tiles(painter.raster(), threads, stop,
                         [&](int x, int y, std::span<const SurfaceFragment> fragments,
                             auto& stops) { return painter.add_pixel(x, y, fragments, stops); });
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::kOutOfMemory,
              fmt::format("the boundary in {} x {} pixels of {} triangles: no memory",
                          options.width, options.height, surface.triangles.size()));
}

}  // namespace ovoid
