// SPDX-License-Identifier: Apache-2.0
// In: a plane through a field, and what is known of labels. Out: for each pixel the plane's colour
// at its depth: values, labels over them, and the line around it.
#include "render/passes/slice_limits.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "render/passes/labels_on_plane.h"
#include "render/passes/limits_by_rows.h"
#include "render/passes/plane_values.h"
#include "render/passes/plane_view.h"
#include "view/look/color_attribute.h"
#include "view/look/look_table.h"

namespace ovoid {
namespace {

// Of outlines, pixels: alike for the eye in small and large pictures.
double line_width_of(const RenderOptions& options) {
  constexpr double kLeast = 1.5, kOfSide = 1.0 / 360;
  return std::max(kLeast, kOfSide * std::min(options.width, options.height));
}

// How much of a pixel a line covers that lies within the field's box, along where it ends.
float line_coverage(const PlaneView& view, const PlaneHit& hit, double line_width) {
  const double within = view.pixels_within_faces(hit);
  return static_cast<float>(std::clamp(within + 0.5, 0.0, 1.0) *
                            std::clamp(line_width - within + 0.5, 0.0, 1.0));
}

}  // namespace

DepthLimits slice_limits(const FieldSlice& slice, const LabelSurfaces& labels,
                         FieldRenderer& renderer, const Field& field, const Camera& camera,
                         const Look& look, const RenderOptions& options, const RenderHooks& hooks) {
  RenderOptions whole = options;
  whole.clip_planes.clear();
  whole.depth_limits = nullptr;
  const PlaneView view(field, camera, {slice.normal, slice.offset, PlaneFront::kShown}, whole);
  const std::vector<Vec3> footprint = view.is_met() ? view.footprint() : std::vector<Vec3>();
  const LimitsPlan plan{options.width, options.height, renderer.threads(), hooks.stop};
  if (footprint.size() < 3) return limits_by_rows(plan, [](int, int, auto&) {});
  RenderHooks stopping;
  stopping.stop = hooks.stop;
  const PlaneValues values(renderer, field, look, view, footprint, whole, stopping);
  const double line_width = line_width_of(options);
  std::optional<LabelsOnPlane> marks;
  if (labels.map != nullptr && (labels.slice_lines > 0 || labels.slice_areas > 0))
    marks.emplace(labels, view, options.width, options.height, line_width, renderer.threads(),
                  hooks.stop);
  const DepthLimits* const limits = options.depth_limits.get();  // a mesh ends at its surface
  const view::LookTable colors = view::colors_alone(slice.colors);
  const bool is_opaque = slice.colors.opacities.empty();
  return limits_by_rows(plan, [&](int x, int y, auto& stops) {
    const auto hit = view.hit(x, y);
    if (!hit) return;
    const auto depth = static_cast<float>(hit->depth);
    const bool is_within = limits == nullptr || limits->shows_field_at(x, y, depth);
    const auto value = is_within ? values.at(*hit) : std::nullopt;
    const float line = slice.outline ? line_coverage(view, *hit, line_width) : 0;
    if (!value && line == 0) return;
    std::array<float, 4> rgba{};
    if (value) {
      const view::LookTable::Sample c = colors.at(*value);
      const auto opacity = is_opaque ? 1.0F : static_cast<float>(slice.colors.opacity_at(*value));
      rgba = {opacity * c.r, opacity * c.g, opacity * c.b, opacity};
      if (marks) marks->draw_over(x, y, rgba);
      for (float& channel : rgba) channel *= static_cast<float>(slice.opacity);
    }
    for (std::size_t c = 0; line > 0 && c < 4; ++c)
      rgba[c] =
          (1 - line) * rgba[c] + line * (c < 3 ? static_cast<float>((*slice.outline)[c]) : 1.0F);
    stops.push_back({depth, false, false, rgba});
  });
}

}  // namespace ovoid
