// SPDX-License-Identifier: Apache-2.0
// Draws the fields of a scene, within the limits that the options have, by the chosen back end.
// What else is in a scene becomes limits, or a picture of its own, before it comes here.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/render_options.h"
#include "ovoid/renderer.h"
#include "ovoid/scene.h"
#include "render/back_end.h"
#include "render/cpu/cpu_renderer.h"
#include "render/field_levels.h"
#include "render/light/light_volume.h"

namespace ovoid {

// What takes light away beside the field, or in its place.
struct LightBlockers {
  const Surface* solid =
      nullptr;  // of the field's mesh, which nothing passes through; null: the field
  std::span<const Geometry> geometry{};  // valid
};

// The fields of one frame.
struct DrawnFields {
  const Field& field;
  const Look& look;
  const Trail* trail = nullptr;              // null: none
  std::span<const FurtherVolume> further{};  // drawn with the field
  Mixing mixing = Mixing::kAveraged;         // of the field and these
};

// The light that reaches surfaces.
struct SurfaceLight {
  // The volume. Null: the look has none, or there is no memory for it, which the notice then says.
  // Valid until the renderer is used again, but for draw() with the same arguments.
  const view::LightVolume* volume = nullptr;
  std::string notice;
};

class FieldRenderer {
 public:
  explicit FieldRenderer(const RendererSetup& setup);  // throws as Renderer

  int threads() const noexcept { return machine_.runner->num_wanted(); }

  // Throws as Renderer::render().
  Frame draw(const DrawnFields& fields, const Camera& camera, const RenderOptions& options,
             const RenderHooks& hooks, const LightBlockers& blockers = {});

  // With geometry it is the light that draw() gives the field. Throws Error(kCancelled), and what
  // the field's source throws.
  SurfaceLight light_for(const DrawnFields& fields, const LightBlockers& blockers,
                         const Camera& camera, const RenderOptions& options,
                         const RenderHooks& hooks);

  // A lattice of zeros that fills a box, kept for the next frame: as fine as shadows are to be.
  const LatticeField& nothing_in(const Bounds3& bounds);

 private:
  // Each volume in a picture of its own, and what these make together.
  Frame draw_each(const DrawnFields& fields, const Camera& camera, const RenderOptions& options,
                  const RenderHooks& hooks);
  // The further volumes as they are drawn, with looks that say everything.
  std::vector<FurtherVolume> further_to_draw(std::span<const FurtherVolume> further,
                                             const Camera& camera, const RenderOptions& options,
                                             const RenderHooks& hooks);
  // Null where the look has none, or where there is no memory for it; then with a notice.
  SurfaceLight light_of(const LitScene& scene, const RenderHooks& hooks);
  // `is_distance_free`: nobody asks for the sampling distance of the job.
  Frame draw_by_choice(const FrameJob& job, bool is_distance_free) const;
  // A job without its field.
  Image trail_alone(const FrameJob& job, FrameProfile& profile) const;

  cpu::Machine machine_;
  FieldLevels levels_;
  LightVolumes lights_;
  std::optional<std::pair<Bounds3, LatticeField>> nothing_;
  std::unique_ptr<BackEnd> back_end_;
  std::unique_ptr<BackEnd> fallback_;  // of kAuto on a device, for what the device fails to draw
};

}  // namespace ovoid
