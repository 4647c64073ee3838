// SPDX-License-Identifier: Apache-2.0
// In: a mesh's field and surface. Out: one picture of both, by limits on the field's frame, or by
// lids on the surface's.
#include "render/passes/mesh_frame.h"

#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "ovoid/error.h"
#include "render/passes/boundary_limits.h"
#include "render/passes/lids.h"
#include "render/passes/surface_frame.h"

namespace ovoid {
namespace {

using SurfaceClock = std::chrono::steady_clock;

double ms_since(SurfaceClock::time_point start) {
  return std::chrono::duration<double, std::milli>(SurfaceClock::now() - start).count();
}

// The surface, and behind it nothing that could be seen but through cuts.
Frame draw_opaque(FieldRenderer& renderer, const DrawnFields& fields, const Surface& surface,
                  const SurfaceStyle& walls, const Camera& camera, const RenderOptions& options,
                  const RenderHooks& hooks) {
  FrameProfile lids_profile;
  std::optional<Lids> lids;
  if (!options.clip_planes.empty() && surface.encloses_mesh()) {
    RenderOptions whole = options;
    whole.part = nullptr;
    lids = make_lids(renderer, fields, surface, camera, whole, hooks, &lids_profile);
  }
  SurfaceLight light;
  const SurfaceClock::time_point start = SurfaceClock::now();
  if (surface.encloses_mesh())
    light = renderer.light_for(fields, {&surface}, camera, options, hooks);
  const double light_ms = ms_since(start);
  Frame frame = paint_surface(surface, camera, fields.look, walls, options, renderer.threads(),
                              hooks, {lids ? &*lids : nullptr, light.volume});
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

std::shared_ptr<const DepthLimits> limits_within(const Surface& boundary, const SurfaceStyle& walls,
                                                 const Camera& camera, const Look& look,
                                                 const RenderOptions& options, int threads,
                                                 const RenderHooks& hooks,
                                                 const view::LightVolume* light) {
  const DepthLimits* const others = options.depth_limits.get();
  if (others != nullptr && walls.opacity > 0)
    throw Error(ErrorCode::kUnsupported, "walls: are for pictures without depth limits");
  DepthLimits limits =
      boundary_limits(boundary, camera, look, walls, options, threads, hooks.stop, light);
  return std::make_shared<const DepthLimits>(others != nullptr ? intersection(*others, limits)
                                                               : std::move(limits));
}

Frame draw_mesh(FieldRenderer& renderer, const DrawnFields& fields, const Surface& boundary,
                const SurfaceStyle& walls, const Camera& camera, const RenderOptions& options,
                const RenderHooks& hooks) {
  if (walls.opacity >= 1 && options.depth_limits == nullptr)
    return draw_opaque(renderer, fields, boundary, walls, camera, options, hooks);
  if (!boundary.encloses_mesh()) {
    if (walls.opacity == 0) return renderer.draw(fields, camera, options, hooks);
    return paint_surface(boundary, camera, fields.look, walls, options, renderer.threads(), hooks);
  }
  const SurfaceClock::time_point start = SurfaceClock::now();
  SurfaceLight light;  // what the field within lets through reaches the walls
  if (walls.opacity > 0) light = renderer.light_for(fields, {}, camera, options, hooks);
  RenderOptions within = options;
  within.depth_limits = limits_within(boundary, walls, camera, fields.look, options,
                                      renderer.threads(), hooks, light.volume);
  const double boundary_ms = ms_since(start);
  Frame frame = renderer.draw(fields, camera, within, hooks);
  frame.profile.frame_ms += boundary_ms;
  if (options.collect_profile) frame.profile.stages_ms.emplace_back("boundary", boundary_ms);
  return frame;
}

}  // namespace ovoid
