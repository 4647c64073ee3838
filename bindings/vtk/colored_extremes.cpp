// SPDX-License-Identifier: Apache-2.0
#include "colored_extremes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "ovoid/depth_limits.h"
#include "ovoid/look.h"
#include "ovoid/sampler.h"
#include "rays.h"

namespace ovoid::mappers {
namespace {

// How far around a place its colours are taken, as a share of the distance of sheets: what a value
// changes over this is not seen. At least a few steps of a float's, so that the span is not empty.
constexpr double kShareOfSheets = 0.02;
constexpr double kLeastOfDepth = 4 * 0x1p-23;

// Around the depths of all pixels that show something.
DepthLimits spans_around(const Image& image, double sheets) {
  DepthLimits limits;
  limits.width = image.width;
  limits.height = image.height;
  limits.first.reserve(image.depth.size() + 1);
  limits.first.push_back(0);
  limits.stops.reserve(2 * image.depth.size());
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    const double depth = image.depth[i];
    if (image.rgba[4 * i + 3] > 0 && std::isfinite(depth)) {
      const double half = std::max(0.5 * kShareOfSheets * sheets, kLeastOfDepth * std::abs(depth));
      limits.stops.push_back({static_cast<float>(depth - half), true, false, {}});
      limits.stops.push_back({static_cast<float>(depth + half), false, false, {}});
    }
    limits.first.push_back(static_cast<std::uint32_t>(limits.stops.size()));
  }
  return limits;
}

// The colours of single places. A frame has none in the outermost half of a spacing where two faces
// of the field meet: kernels there have too little weight. An extreme may still be met there.
class PlaceColors {
 public:
  explicit PlaceColors(const Scene& scene)
      : colors_(scene.volumes.begin() + 1, scene.volumes.end()) {
    const LatticeField& field = *scene.volumes.front().field.lattice();
    world_from_index_ = field.geometry().world_from_index;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      last_[static_cast<Eigen::Index>(axis)] = static_cast<double>(field.geometry().dims[axis]) - 1;
    }
    probes_.reserve(colors_.size());
    for (const Volume& color : colors_) probes_.emplace_back(color.field);
  }

  // Of a place beyond the outermost samples those of the nearest within.
  Rgb at(const Vec3& world) const {
    const Vec3 index = world_from_index_.inverse() * world;
    const Vec3 within = index.cwiseMax(0).cwiseMin(last_);
    Rgb sum{0, 0, 0};
    for (std::size_t i = 0; i < probes_.size(); ++i) {
      const double value = probes_[i].at(world_from_index_ * within).value;
      const Rgb own = colors_[i].look.transfer_function.color_at(value);
      for (std::size_t c = 0; c < 3; ++c) sum[c] = std::min(sum[c] + own[c], 1.0);
    }
    return sum;
  }

 private:
  Affine3 world_from_index_;
  std::vector<Volume> colors_;
  std::vector<FieldProbe> probes_;
  Vec3 last_;
};

Look opaque_look() {
  Look look;
  look.transfer_function.colors = {{0, {1, 1, 1}}};
  look.transfer_function.opacities = {{0, 1}};
  look.shade = false;
  return look;
}

}  // namespace

double color_extremes(Renderer& renderer, const Scene& scene, const View& view,
                      const RenderOptions& options, Image* image) {
  Scene colored = scene;
  Volume& first = colored.volumes.front();
  first.look = opaque_look();
  colored.mixing = Mixing::kColored;
  RenderOptions of_colors = options;
  of_colors.depth_limits = std::make_shared<const DepthLimits>(
      spans_around(*image, sheet_distance(first.field, first.look, options)));
  const Frame colors = renderer.render(colored, view.camera, of_colors);
  std::optional<PlaceColors> places;
  const Rays rays(view);
  for (std::size_t pixel = 0; pixel < image->depth.size(); ++pixel) {
    float* const rgba = &image->rgba[4 * pixel];
    const float* const color = &colors.image.rgba[4 * pixel];
    if (!(rgba[3] > 0)) continue;
    if (color[3] > 0) {
      for (std::size_t c = 0; c < 3; ++c) rgba[c] *= color[c] / color[3];
      continue;
    }
    if (!places) places.emplace(scene);
    const auto column = static_cast<int>(pixel % static_cast<std::size_t>(image->width));
    const auto row = static_cast<int>(pixel / static_cast<std::size_t>(image->width));
    Vec3 origin, direction;
    rays.at(column, row, &origin, &direction);
    const Rgb there = places->at(origin + image->depth[pixel] * direction);
    for (std::size_t c = 0; c < 3; ++c) rgba[c] *= static_cast<float>(there[c]);
  }
  return colors.profile.frame_ms;
}

}  // namespace ovoid::mappers
