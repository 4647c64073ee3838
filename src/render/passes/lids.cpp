// SPDX-License-Identifier: Apache-2.0
// In: a mesh, its field, clip planes. Out: colours where rays pass from what is cut away into the
// mesh. The field is drawn in a span behind the cut that is too thin for anything to change in it.
#include "render/passes/lids.h"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "render/passes/mesh_crossings.h"
#include "render/passes/pixel_stops.h"
#include "render/passes/surface_raster.h"

namespace ovoid {
namespace {

// Of the field's sampling distance.
constexpr double kThickness = 1.0 / 16;

// From where on a ray is before the clip planes' cuts; +inf: nowhere.
double first_kept(const SurfaceRaster::Ray& ray, std::span<const ClipPlane> planes) {
  double begin = 0;
  double end = std::numeric_limits<double>::infinity();
  for (const ClipPlane& plane : planes) {
    const double slope = plane.normal.dot(ray.direction);
    const double missing = plane.offset - plane.normal.dot(ray.origin);
    if (slope > 0) begin = std::max(begin, missing / slope);
    if (slope < 0) end = std::min(end, missing / slope);
    if (slope == 0 && missing > 0) end = begin;
  }
  return begin < end ? begin : std::numeric_limits<double>::infinity();
}

class LidFinder {
 public:
  LidFinder(const SurfaceRaster& raster, const RenderOptions& options, double thickness, Lids& lids)
      : raster_(raster), planes_(options.clip_planes), thickness_(thickness), lids_(lids) {
    const auto count =
        static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height);
    lids.covered.assign(count, 0);
    lids.depth.assign(count, 0.0F);
  }

  // The span behind a pixel's lid; whole pixels, since a lid's colour is that of all of it.
  float add_pixel(int x, int y, std::span<const SurfaceFragment> fragments,
                  std::vector<DepthLimits::Stop>& stops) const {
    std::uint8_t covered = 0;
    float depth = 0;
    for (int p = 0; p < SurfaceRaster::kPlaces; ++p) {
      const double cut = first_kept(raster_.ray_through(x, y, p), planes_);
      if (!(cut > 0) || cut == std::numeric_limits<double>::infinity()) continue;
      const auto at = static_cast<float>(cut);
      MeshCount count(fragments);
      for (const SurfaceFragment& fragment : fragments) {
        if (fragment.depth > at) break;
        count.pass(fragment);
      }
      if (!count.is_inside(p)) continue;
      if (covered == 0) depth = at;
      covered = static_cast<std::uint8_t>(covered | 1U << p);
    }
    if (covered == 0) return 0;
    const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(raster_.width()) +
                          static_cast<std::size_t>(x);
    lids_.covered[i] = covered;
    lids_.depth[i] = depth;
    stops.push_back({depth, true, {}});
    stops.push_back({depth + static_cast<float>(thickness_), false, {}});
    return 1;
  }

 private:
  const SurfaceRaster& raster_;
  const std::vector<ClipPlane>& planes_;
  const double thickness_;
  Lids& lids_;
};

// The look's colours, and nothing that can be seen through.
Look opaque_colors(const Look& look, double thickness) {
  Look opaque = look;
  opaque.mode = Mode::kComposite;
  opaque.transfer_function.opacities.clear();
  opaque.transfer_function.gradient_opacities.clear();
  opaque.transfer_function_2d.reset();
  opaque.unit_distance = thickness;
  opaque.shade = false;
  opaque.occlusion = opaque.shadows = 0;
  return opaque;
}

}  // namespace

std::optional<Lids> make_lids(FieldRenderer& renderer, const DrawnFields& fields,
                              const Surface& surface, const Camera& camera,
                              const RenderOptions& options, const RenderHooks& hooks,
                              FrameProfile* profile) {
  const double thickness = kThickness * fields.field.default_sampling_distance();
  Lids lids;
  RenderOptions behind = options;
  {
    const SurfaceRaster raster(surface, camera, options, SurfaceRaster::Faces::kAll);
    const LidFinder finder(raster, options, thickness, lids);
    auto limits = std::make_shared<DepthLimits>(
        limits_of_tiles(raster, renderer.threads(), hooks.stop,
                        [&](int x, int y, std::span<const SurfaceFragment> fragments, auto& stops) {
                          return finder.add_pixel(x, y, fragments, stops);
                        }));
    if (limits->stops.empty()) return std::nullopt;
    behind.depth_limits = std::move(limits);
  }
  // The cut itself is what is drawn: a clip plane through the same place would take pieces away.
  behind.clip_planes.clear();
  RenderHooks inner;
  inner.stop = hooks.stop;
  const Look look = opaque_colors(fields.look, thickness);
  Frame frame = renderer.draw({fields.field, look}, camera, behind, inner);
  lids.colors = std::move(frame.image);
  *profile = std::move(frame.profile);
  return lids;
}

}  // namespace ovoid
