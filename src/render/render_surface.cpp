// SPDX-License-Identifier: Apache-2.0
// In: a surface, camera and look. Out: a picture. Each tile's fragments are shaded where they can
// be seen, and composited at four places of each pixel by themselves, so that triangles which share
// a side leave no seam.
#include "ovoid/render_surface.h"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>
#include <new>
#include <optional>
#include <span>

#include "data/parallel.h"
#include "ovoid/error.h"
#include "render/surface_raster.h"
#include "view/color_attribute.h"
#include "view/light.h"

namespace ovoid {
namespace {

constexpr int kPlaces = SurfaceRaster::kPlaces;
constexpr double kEdgeWidth = 0.8;   // pixels, from the middle of a line to where it has faded
constexpr double kEdgeShade = 0.35;  // of the colour, in the middle of a line

class SurfacePainter {
 public:
  SurfacePainter(const Surface& surface, const Camera& camera, const Look& look,
                 const SurfaceStyle& style, const RenderOptions& options)
      : surface_(surface),
        look_(look),
        style_(style),
        colors_(view::colors_alone(view::color_function_of(look))),
        raster_(surface, camera, options),
        opaque_at_(options.opaque_at) {
    if (look.light_direction) {
      key_ = look.light_direction->normalized();
    } else if (look.light == Light::kStudio) {
      key_ = view::studio_key(camera).normalized();
    }
    image_.width = options.width;
    image_.height = options.height;
    const auto count =
        static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height);
    image_.rgba.assign(4 * count, 0.0F);
    image_.depth.assign(count, std::numeric_limits<float>::infinity());
  }

  int num_tiles() const noexcept { return raster_.num_tiles(); }

  // Returns how many fragments were shaded.
  std::int64_t paint_tile(int tile) {
    const auto fragments = raster_.tile_fragments(tile, style_.opacity >= 1);
    const int x0 = raster_.tile_x(tile);
    const int y0 = raster_.tile_y(tile);
    std::int64_t num_shaded = 0;
    for (int y = 0; y < SurfaceRaster::kTile && y0 + y < image_.height; ++y) {
      for (int x = 0; x < SurfaceRaster::kTile && x0 + x < image_.width; ++x)
        num_shaded += paint_pixel(x0 + x, y0 + y, fragments.of_pixel(x, y));
    }
    return num_shaded;
  }

  Image& image() noexcept { return image_; }

 private:
  std::int64_t paint_pixel(int x, int y, std::span<const SurfaceFragment> fragments) {
    if (fragments.empty()) return 0;
    std::array<double, kPlaces> through;  // what light is left at each place
    through.fill(1);
    Rgb sum{0, 0, 0};
    double opacity = 0;
    float depth = std::numeric_limits<float>::infinity();
    std::int64_t num_shaded = 0;
    for (const SurfaceFragment& fragment : fragments) {
      double seen = 0;
      for (int p = 0; p < kPlaces; ++p) {
        auto& left = through[static_cast<std::size_t>(p)];
        if ((fragment.covered >> p & 1U) == 0 || 1 - left >= opaque_at_) continue;
        seen += left * style_.opacity / kPlaces;
        left *= 1 - style_.opacity;
      }
      if (seen == 0) continue;
      const Rgb color = shade(fragment);
      ++num_shaded;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += seen * color[c];
      opacity += seen;
      if (opacity >= 0.5 && !(depth < std::numeric_limits<float>::infinity()))
        depth = fragment.depth;
    }
    const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) +
                           static_cast<std::size_t>(x);
    for (std::size_t c = 0; c < 3; ++c) image_.rgba[4 * at + c] = static_cast<float>(sum[c]);
    image_.rgba[4 * at + 3] = static_cast<float>(std::min(opacity, 1.0));
    image_.depth[at] = depth;
    return num_shaded;
  }

  Rgb shade(const SurfaceFragment& fragment) const {
    const Surface::Triangle& triangle = surface_.triangles[fragment.triangle];
    float value = 0;
    Vec3 normal = Vec3::Zero();
    for (std::size_t c = 0; c < 3; ++c) {
      value += fragment.shares[c] * triangle.values[c];
      normal += (fragment.shares[c] * triangle.normals[c]).cast<double>();
    }
    const view::LookTable::Sample own = colors_.at(value);
    Rgb color{own.r, own.g, own.b};
    if (style_.shows_edges) darken_edges(fragment, triangle, color);
    if (!look_.shade) return color;
    const Vec3 to_eye = raster_.towards_eye(raster_.place_of(fragment));
    const view::LightShares light =
        view::light_shares(look_, normal.normalized(), key_.value_or(to_eye), to_eye);
    return view::lit_color(color, look_.material, light, 1);
  }

  static void darken_edges(const SurfaceFragment& fragment, const Surface::Triangle& triangle,
                           Rgb& color) {
    double factor = 1;
    for (std::size_t i = 0; i < 3; ++i) {
      if ((triangle.edges >> i & 1U) == 0 || fragment.edge_distance[i] >= kEdgeWidth) continue;
      factor = std::min(factor, std::lerp(kEdgeShade, 1.0, fragment.edge_distance[i] / kEdgeWidth));
    }
    for (double& c : color) c *= factor;
  }

  const Surface& surface_;
  const Look& look_;
  const SurfaceStyle style_;
  const view::LookTable colors_;
  const SurfaceRaster raster_;
  const double opaque_at_;
  std::optional<Vec3> key_;  // none: from the eye
  Image image_;
};

}  // namespace

Frame render_surface(const Surface& surface, const Camera& camera, const Look& look,
                     const SurfaceStyle& style, const RenderOptions& options, int threads,
                     const RenderHooks& hooks) try {
  camera.validate();
  look.validate();
  options.validate();
  if (!(style.opacity > 0 && style.opacity <= 1)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("surface opacity = {}: must be in (0, 1]", style.opacity));
  }
  const auto start = std::chrono::steady_clock::now();
  SurfacePainter painter(surface, camera, look, style, options);
  std::atomic<std::int64_t> num_shaded = 0;
  std::mutex telling;
  std::int64_t num_done = 0;
  data::parallel_ranges({painter.num_tiles(), 1, threads, hooks.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          for (auto tile = static_cast<int>(begin); tile < end; ++tile)
                            num_shaded += painter.paint_tile(tile);
                          if (!hooks.progress) return;
                          const std::lock_guard lock(telling);
                          num_done += end - begin;
                          hooks.progress(static_cast<double>(num_done) / painter.num_tiles());
                        });
  Frame frame;
  frame.image = std::move(painter.image());
  frame.profile.backend = "cpu";
  frame.profile.threads = data::resolve_threads(threads);
  frame.profile.samples_shaded = num_shaded;
  frame.profile.frame_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  if (options.collect_profile) frame.profile.stages_ms = {{"surface", frame.profile.frame_ms}};
  if (hooks.tile_done) hooks.tile_done({0, 0, options.width, options.height, &frame.image});
  return frame;
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::kOutOfMemory,
              fmt::format("a picture of {} x {} pixels of {} triangles: no memory", options.width,
                          options.height, surface.triangles.size()));
}

}  // namespace ovoid
