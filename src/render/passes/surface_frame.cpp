// SPDX-License-Identifier: Apache-2.0
// In: a surface, camera and look. Out: a picture. Each tile's fragments are shaded where they can
// be seen, and composited at four places of each pixel by themselves, so that triangles which share
// a side leave no seam.
#include "render/passes/surface_frame.h"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <new>
#include <span>

#include "data/parallel.h"
#include "ovoid/error.h"
#include "render/passes/picture_tiles.h"
#include "render/passes/surface_raster.h"
#include "render/passes/surface_shader.h"
#include "view/plan/space_part.h"

namespace ovoid {
namespace {

constexpr int kPlaces = SurfaceRaster::kPlaces;
constexpr float kNoLayer = std::numeric_limits<float>::infinity();

class SurfacePainter {
 public:
  SurfacePainter(const Surface& surface, const Camera& camera, const Look& look,
                 const SurfaceStyle& style, const RenderOptions& options,
                 const SurfaceSurroundings& around)
      : raster_(surface, camera, options, SurfaceRaster::Faces::kDrawn),
        shader_(surface, raster_, camera, look, style.shows_edges, around.light),
        opacity_(style.opacity),
        opaque_at_(options.opaque_at),
        lids_(around.lids) {
    image_.width = options.width;
    image_.height = options.height;
    const auto count =
        static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height);
    image_.rgba.assign(4 * count, 0.0F);
    image_.depth.assign(count, kNoLayer);
    image_.front_depth.assign(count, kNoLayer);
  }

  int num_tiles() const noexcept { return raster_.num_tiles(); }

  // Returns how many fragments were shaded.
  std::int64_t paint_tile(int tile) {
    const auto fragments = raster_.tile_fragments(tile, opacity_ >= 1);
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
  // A pixel while its layers join it, from front to back: each of its places by itself.
  struct Pixel {
    std::array<double, kPlaces> through;  // what light is left
    Rgb sum{0, 0, 0};
    double opacity = 0;
    float depth = kNoLayer;
    float front_depth = kNoLayer;

    // How much of the pixel a layer of this opacity would take.
    double take(std::uint8_t covered, double layer_opacity, double opaque_at) {
      double seen = 0;
      for (std::size_t p = 0; p < kPlaces; ++p) {
        if ((covered >> p & 1U) == 0 || 1 - through[p] >= opaque_at) continue;
        seen += through[p] * layer_opacity / kPlaces;
        through[p] *= 1 - layer_opacity;
      }
      return seen;
    }
    void add(const Rgb& color, double seen, float at) {
      for (std::size_t c = 0; c < 3; ++c) sum[c] += seen * color[c];
      opacity += seen;
      if (opacity >= 0.5 && !(depth < kNoLayer)) depth = at;
      if (opacity >= double{kLeastVisibleOpacity} && !(front_depth < kNoLayer)) front_depth = at;
    }
  };

  std::int64_t paint_pixel(int x, int y, std::span<const SurfaceFragment> fragments) {
    const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) +
                           static_cast<std::size_t>(x);
    bool awaits_lid = lids_ != nullptr && lids_->covered[at] != 0;
    if (fragments.empty() && !awaits_lid) return 0;
    Pixel pixel;
    pixel.through.fill(1);
    std::int64_t num_shaded = 0;
    for (const SurfaceFragment& fragment : fragments) {
      if (awaits_lid && lids_->depth[at] <= fragment.depth) {
        add_lid(at, pixel);
        awaits_lid = false;
      }
      const double seen = pixel.take(fragment.covered, opacity_, opaque_at_);
      if (seen == 0) continue;
      pixel.add(shader_.color_of(fragment), seen, fragment.depth);
      ++num_shaded;
    }
    if (awaits_lid) add_lid(at, pixel);
    for (std::size_t c = 0; c < 3; ++c) image_.rgba[4 * at + c] = static_cast<float>(pixel.sum[c]);
    image_.rgba[4 * at + 3] = static_cast<float>(std::min(pixel.opacity, 1.0));
    image_.depth[at] = pixel.depth;
    image_.front_depth[at] = pixel.front_depth;
    return num_shaded;
  }

  void add_lid(std::size_t at, Pixel& pixel) const {
    const float* const rgba = lids_->colors.rgba.data() + 4 * at;
    if (!(rgba[3] > 0)) return;
    const double seen = pixel.take(lids_->covered[at], rgba[3], opaque_at_);
    pixel.add({rgba[0] / rgba[3], rgba[1] / rgba[3], rgba[2] / rgba[3]}, seen, lids_->depth[at]);
  }

  const SurfaceRaster raster_;
  const SurfaceShader shader_;
  const double opacity_;  // of a layer
  const double opaque_at_;
  const Lids* const lids_;  // or null
  Image image_;
};

}  // namespace

Frame paint_surface(const Surface& surface, const Camera& camera, const Look& look,
                    const SurfaceStyle& style, const RenderOptions& options, int threads,
                    const RenderHooks& hooks, const SurfaceSurroundings& around) try {
  camera.validate();
  look.validate();
  options.validate();
  if (!(style.opacity > 0 && style.opacity <= 1)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("surface opacity = {}: must be in (0, 1]", style.opacity));
  }
  const auto start = std::chrono::steady_clock::now();
  SurfacePainter painter(surface, camera, look, style, options, around);
  std::atomic<std::int64_t> num_shaded = 0;
  paint_tiles(painter.num_tiles(), threads, hooks,
              [&](int tile) { num_shaded += painter.paint_tile(tile); });
  Frame frame;
  frame.image = std::move(painter.image());
  frame.profile.backend = "cpu";
  frame.profile.threads = data::resolve_threads(threads);
  frame.profile.samples_shaded = num_shaded;
  frame.profile.frame_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  if (options.collect_profile) frame.profile.stages_ms = {{"surface", frame.profile.frame_ms}};
  if (hooks.tile_done) hooks.tile_done({0, 0, options.width, options.height, &frame.image});
  if (options.part != nullptr)
    frame.seen = view::runs_of_surfaces(frame.image, *options.part, camera);
  return frame;
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::kOutOfMemory,
              fmt::format("a picture of {} x {} pixels of {} triangles: no memory", options.width,
                          options.height, surface.triangles.size()));
}

}  // namespace ovoid
