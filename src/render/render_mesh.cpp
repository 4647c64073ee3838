// SPDX-License-Identifier: Apache-2.0
// In: a mesh's field and surface. Out: one picture of both, by limits on the field's frame, or by
// lids on the surface's.
#include "ovoid/render_mesh.h"

#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "data/validate.h"
#include "ovoid/error.h"
#include "render/lids.h"
#include "render/paint_surface.h"
#include "render/surface_light.h"

namespace ovoid {
namespace {

using SurfaceClock = std::chrono::steady_clock;

double ms_since(SurfaceClock::time_point start) {
  return std::chrono::duration<double, std::milli>(SurfaceClock::now() - start).count();
}

// The surface, and behind it nothing that could be seen but through cuts.
Frame render_opaque(Renderer& renderer, const Field& field, const Surface& surface,
                    const Camera& camera, const Look& look, const SurfaceStyle& walls,
                    const RenderOptions& options, const RenderHooks& hooks) {
  FrameProfile lids_profile;
  std::optional<Lids> lids;
  if (!options.clip_planes.empty() && surface.encloses_mesh()) {
    RenderOptions whole = options;
    whole.part = nullptr;
    lids = make_lids(renderer, field, surface, camera, look, whole, hooks, &lids_profile);
  }
  SurfaceLight light;
  const SurfaceClock::time_point start = SurfaceClock::now();
  if (surface.encloses_mesh())
    light = SurfaceLight::of(renderer, field, {&surface}, camera, look, options, hooks);
  const double light_ms = ms_since(start);
  Frame frame = paint_surface(surface, camera, look, walls, options, renderer.threads(), hooks,
                              {lids ? &*lids : nullptr, light.volume});
  frame.profile.frame_ms += light_ms;
  frame.profile.notice = light.notice;
  if (options.collect_profile && light.volume != nullptr)
    frame.profile.stages_ms.emplace_back("light volume", light_ms);
  if (!lids) return frame;
  const FrameProfile of_surface = std::exchange(frame.profile, std::move(lids_profile));
  frame.profile.frame_ms += of_surface.frame_ms;
  frame.profile.stages_ms.insert(frame.profile.stages_ms.end(), of_surface.stages_ms.begin(),
                                 of_surface.stages_ms.end());
  if (frame.profile.notice.empty()) frame.profile.notice = of_surface.notice;
  return frame;
}

}  // namespace

Frame render_mesh(Renderer& renderer, const Field& field, const Surface& surface,
                  const Camera& camera, const Look& look, const SurfaceStyle& walls,
                  const RenderOptions& options, const RenderHooks& hooks) {
  data::require_field(field);
  camera.validate();
  look.validate();
  options.validate();
  if (options.depth_limits != nullptr)
    throw Error(ErrorCode::kInvalidArgument, "depth_limits: the mesh's boundary makes them");
  if (walls.opacity >= 1)
    return render_opaque(renderer, field, surface, camera, look, walls, options, hooks);
  if (!surface.encloses_mesh()) {
    if (walls.opacity == 0) return renderer.render(field, camera, look, options, hooks);
    return render_surface(surface, camera, look, walls, options, renderer.threads(), hooks);
  }
  const SurfaceClock::time_point start = SurfaceClock::now();
  RenderOptions within = options;
  SurfaceLight light;  // what the field within lets through reaches the walls
  if (walls.opacity > 0)
    light = SurfaceLight::of(renderer, field, {}, camera, look, options, hooks);
  within.depth_limits = std::make_shared<DepthLimits>(boundary_limits_in_light(
      surface, camera, look, walls, options, renderer.threads(), hooks.stop, light.volume));
  const double boundary_ms = ms_since(start);
  Frame frame = renderer.render(field, camera, look, within, hooks);
  frame.profile.frame_ms += boundary_ms;
  if (options.collect_profile) frame.profile.stages_ms.emplace_back("boundary", boundary_ms);
  return frame;
}

}  // namespace ovoid
