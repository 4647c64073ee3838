// SPDX-License-Identifier: Apache-2.0
// In: surfaces, and the limits of a field. Out: limits with the surfaces' layers among their stops.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "data/validate.h"
#include "ovoid/error.h"
#include "ovoid/geometry.h"
#include "ovoid/render_mesh.h"
#include "render/label_limits.h"
#include "render/limits_by_rows.h"
#include "render/paint_surface.h"
#include "render/slice_limits.h"
#include "render/surface_light.h"

namespace ovoid {
namespace {

// Behind a layer of this opacity nothing of the same surface is seen.
constexpr float kHides = 1 - 1.0F / 512;

// The colours of its values, or one for all.
Look look_of(const Geometry& geometry, const Look& look) {
  Look own = look;
  own.transfer_function = geometry.colors.value_or(TransferFunction());
  own.transfer_function.opacities.clear();
  if (!geometry.colors) own.transfer_function.colors = {{0, geometry.color}};
  own.color_function.reset();
  return own;
}

// The stops of a pixel: those of the field, and the layers of all surfaces, by depth.
class SceneStops {
 public:
  void begin(std::span<const DepthLimits::Stop> field) {
    layers_.clear();
    field_ = field;
  }

  // The layers of a surface that covers so much of the pixel. What its own opaque layer hides is
  // left out before they are thinned, or an outline would show the far side behind the near one.
  void add(std::span<const DepthLimits::Stop> layers, float coverage) {
    for (DepthLimits::Stop layer : layers) {
      if (layer.rgba[3] == 0) continue;  // bounds a solid, and is not seen
      const bool hides = layer.rgba[3] >= kHides;
      for (float& c : layer.rgba) c *= coverage;
      layers_.push_back(layer);
      if (hides) break;
    }
  }

  bool has_layers() const noexcept { return !layers_.empty(); }

  void write_to(std::vector<DepthLimits::Stop>& stops) {
    std::stable_sort(layers_.begin(), layers_.end(),
                     [](const auto& a, const auto& b) { return a.depth < b.depth; });
    bool is_field_behind = false;
    auto layer = layers_.begin();
    for (const DepthLimits::Stop& stop : field_) {
      for (; layer != layers_.end() && layer->depth < stop.depth; ++layer)
        stops.push_back(layer_with(*layer, is_field_behind));
      is_field_behind = stop.is_field_behind;
      stops.push_back(stop);
    }
    for (; layer != layers_.end(); ++layer) stops.push_back(layer_with(*layer, is_field_behind));
  }

 private:
  static DepthLimits::Stop layer_with(DepthLimits::Stop layer, bool is_field_behind) {
    layer.is_field_behind = is_field_behind;
    return layer;
  }

  std::span<const DepthLimits::Stop> field_;
  std::vector<DepthLimits::Stop> layers_;
};

constexpr DepthLimits::Stop kEverywhere{-std::numeric_limits<float>::infinity(), true, false, {}};

// A pixel's stops where the field is shown if both say so.
void append_both(std::span<const DepthLimits::Stop> field,
                 std::span<const DepthLimits::Stop> labels, std::vector<DepthLimits::Stop>& stops) {
  bool in_field = false;
  bool in_labels = false;
  auto label = labels.begin();
  const auto pass_label = [&] {
    DepthLimits::Stop stop = *label++;
    in_labels = stop.is_field_behind;
    stop.is_field_behind = in_field && in_labels;
    stops.push_back(stop);
  };
  for (DepthLimits::Stop stop : field) {
    while (label != labels.end() && label->depth < stop.depth) pass_label();
    in_field = stop.is_field_behind;
    stop.is_field_behind = in_field && in_labels;
    stops.push_back(stop);
  }
  while (label != labels.end()) pass_label();
}

// `labels`: null: none.
DepthLimits merged_limits(const std::vector<DepthLimits>& layers, const DepthLimits* labels,
                          const RenderOptions& options, int threads, const std::stop_token& stop) {
  const DepthLimits* const field = options.depth_limits.get();
  std::vector<float> coverage;
  if (field != nullptr) coverage = field->coverage;
  DepthLimits all = limits_by_rows(
      {options.width, options.height, threads, stop}, [&](int x, int y, auto& stops) {
        thread_local SceneStops pixel;
        std::span within = field != nullptr ? field->of_pixel(x, y) : std::span(&kEverywhere, 1);
        if (labels != nullptr) {
          thread_local std::vector<DepthLimits::Stop> both;
          both.clear();
          append_both(within, labels->of_pixel(x, y), both);
          within = both;
        }
        pixel.begin(within);
        const std::size_t at =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(options.width) +
            static_cast<std::size_t>(x);
        for (const DepthLimits& layer : layers)
          pixel.add(layer.of_pixel(x, y), layer.coverage.empty() ? 1.0F : layer.coverage[at]);
        // The outline of what the field is within is hard where a surface is behind it.
        if (!coverage.empty() && pixel.has_layers()) coverage[at] = 1;
        pixel.write_to(stops);
      });
  all.coverage = std::move(coverage);
  return all;
}

// What surfaces are drawn with: the field's clip planes and limits are not theirs.
RenderOptions without_cuts(const RenderOptions& options) {
  RenderOptions whole = options;
  whole.clip_planes.clear();
  whole.depth_limits = nullptr;
  return whole;
}

DepthLimits layers_of(const Geometry& geometry, const Camera& camera, const Look& look,
                      const RenderOptions& options, int threads, const std::stop_token& stop,
                      const view::LightVolume* light) {
  geometry.validate();
  return boundary_limits_in_light(*geometry.surface, camera, look_of(geometry, look),
                                  {geometry.opacity, geometry.shows_edges}, without_cuts(options),
                                  threads, stop, light);
}

// Whether a label's surface is seen, or it hides the field.
bool changes_picture(const LabelSurfaces& labels) {
  if (labels.map == nullptr) return false;
  return !labels.shows_field_elsewhere ||
         std::any_of(labels.styles.begin(), labels.styles.end(), [&](const LabelStyle& style) {
           return (labels.shows_surfaces && style.opacity > 0) || !style.shows_field;
         });
}

// Whether a mesh says where its field is, or is seen.
bool has_limits(const Scenery& scenery) {
  return scenery.mesh != nullptr && (scenery.mesh->encloses_mesh() || scenery.walls.opacity > 0);
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

void require_valid_frame(const Camera& camera, const Look& look, const RenderOptions& options) {
  camera.validate();
  look.validate();
  options.validate();
}

void require_valid_scenery(const Scenery& scenery, const Look& look, const RenderOptions& options) {
  for (const Geometry& one : scenery.geometry) one.validate();
  for (const FieldSlice& slice : scenery.slices) slice.validate();
  scenery.labels.validate();
  if (look.mode != Mode::kComposite && look.mode != Mode::kIsosurface) {
    throw Error(
        ErrorCode::kUnsupported,
        "surfaces, slices and labels: are for the modes composite and isosurface; the greatest, "
        "mean or integrated value knows no colours beside its own");
  }
  if (has_limits(scenery) && options.depth_limits != nullptr)
    throw Error(ErrorCode::kInvalidArgument, "depth_limits: the mesh's boundary makes them");
}

}  // namespace

void Geometry::validate() const {
  if (surface == nullptr) throw Error(ErrorCode::kInvalidArgument, "geometry: has no surface");
  for (const double c : color) {
    if (!(c >= 0 && c <= 1))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("geometry.color: {} must be in [0, 1]", c));
  }
  if (!(opacity > 0 && opacity <= 1))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("geometry.opacity = {}: must be in (0, 1]", opacity));
  if (!colors) return;
  Look look;
  look.transfer_function = *colors;
  look.validate();
}

void FieldSlice::validate() const {
  if (!normal.allFinite() || !(normal.norm() > 0) || !std::isfinite(normal.norm()))
    throw Error(ErrorCode::kInvalidArgument, "slice.normal: must be finite and not zero");
  if (!std::isfinite(offset))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("slice.offset = {}: must be finite", offset));
  if (!(opacity > 0 && opacity <= 1))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("slice.opacity = {}: must be in (0, 1]", opacity));
  for (const double c : outline.value_or(Rgb{})) {
    if (!(c >= 0 && c <= 1))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("slice.outline: {} must be in [0, 1]", c));
  }
}

DepthLimits limits_with(std::span<const Geometry> geometry, const Camera& camera, const Look& look,
                        const RenderOptions& options, int threads, std::stop_token stop) try {
  require_valid_frame(camera, look, options);
  std::vector<DepthLimits> layers;
  for (const Geometry& one : geometry)
    layers.push_back(layers_of(one, camera, look, options, threads, stop, nullptr));
  return merged_limits(layers, nullptr, options, threads, stop);
} catch (const std::bad_alloc&) {
  tell_of_memory(options);
}

Frame render_with_scenery(Renderer& renderer, const Field& field, const Camera& camera,
                          const Look& look, const Scenery& scenery, const RenderOptions& options,
                          const RenderHooks& hooks) try {
  const bool has_labels = changes_picture(scenery.labels);
  if (scenery.geometry.empty() && scenery.slices.empty() && !has_labels) {
    if (scenery.mesh == nullptr) return renderer.render(field, camera, look, options, hooks);
    return render_mesh(renderer, field, *scenery.mesh, camera, look, scenery.walls, options, hooks);
  }
  data::require_field(field);
  require_valid_frame(camera, look, options);
  require_valid_scenery(scenery, look, options);
  const auto start = SceneryClock::now();
  const int threads = renderer.threads();
  RenderOptions within = options;
  const bool has_mesh = has_limits(scenery);
  const auto bound = [&](const view::LightVolume* light) {
    within.depth_limits = std::make_shared<DepthLimits>(boundary_limits_in_light(
        *scenery.mesh, camera, look, scenery.walls, options, threads, hooks.stop, light));
  };
  const bool has_surfaces = !scenery.geometry.empty();
  if (has_mesh && (!has_surfaces || !scenery.slices.empty())) bound(nullptr);
  std::vector<DepthLimits> layers;
  for (const FieldSlice& slice : scenery.slices)
    layers.push_back(
        slice_limits(slice, scenery.labels, renderer, field, camera, look, within, hooks));
  const bool hides_field = has_mesh && scenery.walls.opacity >= 1 && scenery.mesh->encloses_mesh();
  const LightBlockers blockers{hides_field ? scenery.mesh : nullptr, scenery.geometry};
  const auto light_start = SceneryClock::now();
  // Valid until the renderer draws.
  const SurfaceLight light =
      has_surfaces ? SurfaceLight::of(renderer, field, blockers, camera, look, options, hooks)
      : has_labels ? SurfaceLight::of(renderer, field, {}, camera, look, options, hooks)
                   : SurfaceLight{};
  const double light_ms = has_surfaces ? ms_of_scenery(light_start) : 0;
  if (has_mesh && has_surfaces) bound(light.volume);
  for (const Geometry& one : scenery.geometry)
    layers.push_back(layers_of(one, camera, look, options, threads, hooks.stop, light.volume));
  std::optional<DepthLimits> labels;
  if (has_labels) {
    labels = label_limits(scenery.labels, camera, look, options, threads, hooks.stop, light.volume);
  }
  const bool are_alone = labels && layers.empty() && within.depth_limits == nullptr;
  RenderOptions among = options;
  among.depth_limits = std::make_shared<DepthLimits>(
      are_alone ? std::move(*labels)
                : merged_limits(layers, labels ? &*labels : nullptr, within, threads, hooks.stop));
  const double ms = ms_of_scenery(start);
  Frame frame = has_surfaces
                    ? SurfaceLight::draw(renderer, field, blockers, camera, look, among, hooks)
                    : renderer.render(field, camera, look, among, hooks);
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

}  // namespace ovoid
