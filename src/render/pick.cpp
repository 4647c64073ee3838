// SPDX-License-Identifier: Apache-2.0
// In: a finished picture and what it was drawn of. Out: the place that one of its pixels stands
// for. Depths are in the picture already, but where no single place is half of what is seen: there
// the pixel's ray is walked once more, sheet by sheet, in double precision.
#include "ovoid/pick.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "data/validate.h"
#include "ovoid/error.h"
#include "render/reference/shading.h"
#include "render/reference/view_rays.h"

namespace ovoid {
namespace {

using reference::Ray;
using reference::ViewRays;
using reference::ZRange;

// More places along one ray than this would find it no better than a sheet.
constexpr double kMostPlaces = 4096;
// What lies behind so much adds nothing that 8 bits show.
constexpr double kLeastThrough = 1.0 / 1024;

// Of the picture that was drawn, whose sheets are the field's usual ones if nobody says otherwise.
RenderOptions options_of(const Image& image, const PickScene& scene) {
  RenderOptions options = scene.options;
  options.width = image.width;
  options.height = image.height;
  options.sampling_distance = sheet_distance(scene.field, scene.look, scene.options);
  return options;
}

ViewRays rays_of(const Field& field, const Camera& camera, const RenderOptions& options) {
  if (const LatticeField* const lattice = field.lattice()) return {*lattice, camera, options};
  return {*field.kernels(), camera, options};
}

// The greatest of what places along a ray add to their pixel.
class GreatestShare {
 public:
  explicit GreatestShare(const PickScene& scene)
      : look_(scene.look), unit_distance_(unit_distance_of(look_, scene.field)) {
    fading_.opacities = look_.transfer_function.gradient_opacities;
  }

  // The place at a depth, which stands for a path of this length. Returns false if none behind it
  // can add more.
  bool add(double depth, const FieldSample& at, double path) {
    const double share = share_of(at, path);
    if (share > greatest_) {
      greatest_ = share;
      depth_ = depth;
    }
    return through_ > greatest_ && through_ >= kLeastThrough;
  }
  std::optional<double> depth() const { return depth_; }

 private:
  double share_of(const FieldSample& at, double path) {
    if (!at.is_defined) return 0;
    if (look_.mode == Mode::kXray || look_.mode == Mode::kMean) {
      // However little is left, values farther from 0 add more.
      through_ = std::numeric_limits<double>::infinity();
      return std::abs(at.value) * path;
    }
    double opacity = look_.transfer_function_2d
                         ? look_.transfer_function_2d->at(at.value, at.gradient.norm())[3]
                         : look_.transfer_function.opacity_at(at.value);
    if (!fading_.opacities.empty()) opacity *= fading_.opacity_at(at.gradient.norm());
    const double share = through_ * reference::opacity_over(opacity, path, unit_distance_);
    through_ -= share;
    return share;
  }

  const Look& look_;
  TransferFunction fading_;
  double unit_distance_;
  double through_ = 1;
  double greatest_ = 0;
  std::optional<double> depth_;
};

// Where the ray leaves the box of all samples or kernels, and a sheet more.
double end_of(const Field& field, const ViewRays& view, const Ray& ray) {
  const Bounds3 box = field.lattice() != nullptr ? field.lattice()->geometry().index_bounds()
                                                 : field.world_bounds();
  return view.inside(ray, box).hi + view.sampling_distance();
}

// From the nearest place that is seen to the field's end.
std::optional<double> greatest_share(const PickScene& scene, const ViewRays& view, int x, int y,
                                     double front) {
  const Ray ray = view.ray(x, y);
  const double end = end_of(scene.field, view, ray);
  const double step = std::max(view.sampling_distance(), (end - front) / kMostPlaces);
  const double length = ray.direction.norm();
  const DepthLimits* const limits = scene.options.depth_limits.get();
  GreatestShare greatest(scene);
  for (double depth = front; depth <= end; depth += step) {
    if (limits != nullptr && !limits->shows_field_at(x, y, static_cast<float>(depth))) continue;
    const ZRange kept = view.kept(ray, {depth - 0.5 * step, depth + 0.5 * step});
    if (!(kept.lo < kept.hi)) continue;
    const double middle = 0.5 * (kept.lo + kept.hi);
    if (!greatest.add(middle, scene.probe.at(ray.at(middle)), (kept.hi - kept.lo) * length)) break;
  }
  return greatest.depth();
}

// Whether the picture's depth is that of what is seen, wherever there is one.
bool has_own_depth(Mode mode) { return mode != Mode::kXray && mode != Mode::kMean; }

double depth_of(const Image& image, std::size_t pixel, const PickScene& scene,
                const ViewRays& view) {
  const auto depth = static_cast<double>(image.depth[pixel]);
  if (has_own_depth(scene.look.mode) && std::isfinite(depth)) return depth;
  const auto front = static_cast<double>(image.front_depth[pixel]);
  if (scene.look.mode == Mode::kIsosurface) return front;
  const int x = static_cast<int>(pixel % static_cast<std::size_t>(image.width));
  const int y = static_cast<int>(pixel / static_cast<std::size_t>(image.width));
  return greatest_share(scene, view, x, y, front).value_or(front);
}

}  // namespace

Pick pick(const Image& image, int x, int y, const PickScene& scene) {
  if (x < 0 || x >= image.width || y < 0 || y >= image.height) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("pixel {},{}: is outside of the picture, expected 0,0 to {},{}", x, y,
                            image.width - 1, image.height - 1));
  }
  data::require_field(scene.field);
  scene.camera.validate();
  Pick picked;
  picked.x = x;
  picked.y = y;
  const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                            static_cast<std::size_t>(x);
  picked.opacity = static_cast<double>(image.rgba[4 * pixel + 3]);
  if (!std::isfinite(image.front_depth[pixel])) return picked;
  if (scene.look.mode == Mode::kXray) picked.integral = static_cast<double>(image.rgba[4 * pixel]);
  const ViewRays view = rays_of(scene.field, scene.camera, options_of(image, scene));
  const Ray ray = view.ray(x, y);
  Pick::Place place;
  place.depth = depth_of(image, pixel, scene, view);
  place.position = ray.at(place.depth);
  place.direction = ray.direction.normalized();
  place.sample = scene.probe.at(place.position);
  if (const LatticeField* const lattice = scene.field.lattice())
    place.index = lattice->geometry().world_from_index.inverse() * place.position;
  picked.place = place;
  return picked;
}

}  // namespace ovoid
