// SPDX-License-Identifier: Apache-2.0
// In: a scene. Out: its picture, by the passes that its parts need: what has a place in depth
// becomes limits on the frame of the fields, what hides them all is drawn alone.
#include "render/passes/scene_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "ovoid/error.h"
#include "render/passes/label_limits.h"
#include "render/passes/mesh_frame.h"
#include "render/passes/plane_frame.h"
#include "render/passes/point_frame.h"
#include "render/passes/scene_limits.h"
#include "render/passes/slice_limits.h"

namespace ovoid {
namespace {

// Whether a label's surface is seen, or it hides the field.
bool changes_picture(const LabelSurfaces& labels) {
  if (labels.map == nullptr) return false;
  return !labels.shows_field_elsewhere ||
         std::any_of(labels.styles.begin(), labels.styles.end(), [&](const LabelStyle& style) {
           return (labels.shows_surfaces && style.opacity > 0) || !style.shows_field;
         });
}

// Whether a mesh says where its field is, or is seen.
bool has_limits(const Volume& volume) {
  return volume.boundary != nullptr &&
         (volume.boundary->encloses_mesh() || volume.walls.opacity > 0);
}

using SceneryClock = std::chrono::steady_clock;

double ms_of_scenery(SceneryClock::time_point start) {
  return std::chrono::duration<double, std::milli>(SceneryClock::now() - start).count();
}

[[noreturn]] void tell_of_memory(const RenderOptions& options) {
  throw Error(ErrorCode::kOutOfMemory,
              fmt::format("surfaces and slices in {} x {} pixels: no memory", options.width,
                          options.height));
}

// The greatest, mean or integrated value of a ray has no place among other things.
void require_layers(const Look& look) {
  if (look.mode == Mode::kComposite || look.mode == Mode::kIsosurface) return;
  throw Error(
      ErrorCode::kUnsupported,
      "surfaces, slices and labels: are for the modes composite and isosurface; the greatest, "
      "mean or integrated value knows no colours beside its own");
}

// A mesh's field ends at its surface, the trail does not.
Frame draw_with_trail(FieldRenderer& renderer, const Volume& volume, const DrawnFields& fields,
                      const Camera& camera, const RenderOptions& options,
                      const RenderHooks& hooks) {
  RenderOptions within = options;
  if (volume.field.kernels() != nullptr && has_limits(volume)) {
    within.depth_limits = limits_within(*volume.boundary, volume.walls, camera, volume.look,
                                        options, renderer.threads(), hooks);
  }
  return renderer.draw(fields, camera, within, hooks);
}

// A mesh's boundary cuts the field, and is not seen.
Frame draw_plane_within(FieldRenderer& renderer, const Volume& volume, const ValuePlane& plane,
                        const DrawnFields& fields, const Camera& camera,
                        const RenderOptions& options, const RenderHooks& hooks) {
  RenderOptions within = options;
  if (volume.boundary != nullptr && volume.boundary->encloses_mesh()) {
    within.depth_limits = limits_within(*volume.boundary, {0, false}, camera, volume.look, options,
                                        renderer.threads(), hooks);
  }
  return draw_with_plane(renderer, fields, plane, camera, within, hooks);
}

// The fields, with surfaces, slices and labels among them.
Frame draw_with_scenery(FieldRenderer& renderer, const Scene& scene, const DrawnFields& fields,
                        const Camera& camera, const RenderOptions& options,
                        const RenderHooks& hooks) try {
  const Volume& volume = scene.volumes.front();
  const Look& look = fields.look;
  require_layers(look);
  const bool has_mesh = has_limits(volume);
  const auto start = SceneryClock::now();
  const int threads = renderer.threads();
  RenderOptions within = options;
  const auto bound = [&](const view::LightVolume* light) {
    within.depth_limits =
        limits_within(*volume.boundary, volume.walls, camera, look, options, threads, hooks, light);
  };
  const bool has_surfaces = !scene.surfaces.empty();
  const bool has_labels = changes_picture(scene.labels);
  if (has_mesh && (!has_surfaces || !scene.slices.empty())) bound(nullptr);
  std::vector<DepthLimits> layers;
  for (const FieldSlice& slice : scene.slices)
    layers.push_back(
        slice_limits(slice, scene.labels, renderer, fields.field, camera, look, within, hooks));
  const bool hides_field =
      has_mesh && volume.walls.opacity >= 1 && volume.boundary->encloses_mesh();
  const LightBlockers blockers{hides_field ? volume.boundary.get() : nullptr, scene.surfaces};
  const auto light_start = SceneryClock::now();
  // Valid until the renderer draws.
  const SurfaceLight light = has_surfaces
                                 ? renderer.light_for(fields, blockers, camera, options, hooks)
                             : has_labels ? renderer.light_for(fields, {}, camera, options, hooks)
                                          : SurfaceLight{};
  const double light_ms = has_surfaces ? ms_of_scenery(light_start) : 0;
  if (has_mesh && has_surfaces) bound(light.volume);
  for (const Geometry& one : scene.surfaces)
    layers.push_back(layers_of(one, camera, look, options, threads, hooks.stop, light.volume));
  std::optional<DepthLimits> labels;
  if (has_labels)
    labels = label_limits(scene.labels, camera, look, options, threads, hooks.stop, light.volume);
  const bool are_alone = labels && layers.empty() && within.depth_limits == nullptr;
  RenderOptions among = options;
  among.depth_limits = std::make_shared<DepthLimits>(
      are_alone ? std::move(*labels)
                : merged_limits(layers, labels ? &*labels : nullptr, within, threads, hooks.stop));
  const double ms = ms_of_scenery(start);
  Frame frame =
      renderer.draw(fields, camera, among, hooks, has_surfaces ? blockers : LightBlockers{});
  frame.profile.frame_ms += ms;
  auto& stages = frame.profile.stages_ms;
  for (auto& [stage, stage_ms] : stages) {  // the field's frame has found it made
    if (stage == "light volume") stage_ms += light_ms;
  }
  if (options.collect_profile) stages.emplace_back("scenery", ms - light_ms);
  return frame;
} catch (const std::bad_alloc&) {
  tell_of_memory(options);
}

// Of what stands in a scene without volumes; never empty.
Bounds3 bounds_of(const Scene& scene) {
  Bounds3 bounds;
  for (const Geometry& one : scene.surfaces) bounds.extend(one.surface->bounds);
  if (scene.labels.map != nullptr) bounds.extend(scene.labels.map->geometry().world_bounds());
  return bounds.isEmpty() ? Bounds3(Vec3::Zero(), Vec3::Ones()) : bounds;
}

// A volume without anything to be seen in it, where the light is worked out and rays go.
Volume nothing_around(const Scene& scene, FieldRenderer& renderer) {
  Volume nothing{renderer.nothing_in(bounds_of(scene)), {}};
  nothing.look.transfer_function.colors = {{0, {0, 0, 0}}};
  nothing.look.transfer_function.opacities = {{0, 0}};
  return nothing;
}

}  // namespace

Frame draw_scene(FieldRenderer& renderer, const Scene& scene, const Camera& camera,
                 const RenderOptions& options, const RenderHooks& hooks) {
  scene.validate();
  camera.validate();
  options.validate();
  if (scene.volumes.empty() || scene.lighting) {
    Scene whole = scene;
    if (scene.volumes.empty()) whole.volumes = {nothing_around(scene, renderer)};
    if (scene.lighting) whole.volumes.front().look.lighting() = *scene.lighting;
    whole.lighting.reset();
    return draw_scene(renderer, whole, camera, options, hooks);
  }
  const Volume& first = scene.volumes.front();
  if (first.points) {
    return paint_points(*first.field.kernels(), camera, first.look, *first.points, options,
                        renderer.threads(), hooks);
  }
  std::vector<FurtherVolume> further;
  for (std::size_t i = 1; i < scene.volumes.size(); ++i)
    further.push_back({*scene.volumes[i].field.lattice(), scene.volumes[i].look});
  const DrawnFields fields{first.field, first.look, first.trail.get(), further, scene.mixing};
  if (first.trail != nullptr)
    return draw_with_trail(renderer, first, fields, camera, options, hooks);
  if (scene.plane)
    return draw_plane_within(renderer, first, *scene.plane, fields, camera, options, hooks);
  if (!scene.surfaces.empty() || !scene.slices.empty() || changes_picture(scene.labels))
    return draw_with_scenery(renderer, scene, fields, camera, options, hooks);
  if (first.boundary != nullptr)
    return draw_mesh(renderer, fields, *first.boundary, first.walls, camera, options, hooks);
  return renderer.draw(fields, camera, options, hooks);
}

}  // namespace ovoid
