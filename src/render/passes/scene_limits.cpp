// SPDX-License-Identifier: Apache-2.0
#include "render/passes/scene_limits.h"

#include <algorithm>
#include <limits>
#include <span>

#include "render/passes/boundary_limits.h"
#include "render/passes/limits_by_rows.h"

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

// What surfaces are drawn with: the field's clip planes and limits are not theirs.
RenderOptions without_cuts(const RenderOptions& options) {
  RenderOptions whole = options;
  whole.clip_planes.clear();
  whole.depth_limits = nullptr;
  return whole;
}

}  // namespace

DepthLimits layers_of(const Geometry& geometry, const Camera& camera, const Look& look,
                      const RenderOptions& options, int threads, const std::stop_token& stop,
                      const view::LightVolume* light) {
  return boundary_limits(*geometry.surface, camera, look_of(geometry, look),
                         {geometry.opacity, geometry.shows_edges}, without_cuts(options), threads,
                         stop, light);
}

DepthLimits merged_limits(std::span<const DepthLimits> layers, const DepthLimits* labels,
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

}  // namespace ovoid
