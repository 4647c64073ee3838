// SPDX-License-Identifier: Apache-2.0
#include "view/plan/base_plane.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace ovoid::view {
namespace {

constexpr double kLeastCosine = 0.5;  // of a ray and the sheets' normal: 60 degrees

// For the filter that makes pixels, so many samples around the field; and around the picture as
// many pixels, if these are wider than samples.
constexpr double kSamplesAround = 3.0;

// A base plane of many more samples than pixels is a view that is better drawn otherwise.
constexpr double kMostSamplesPerPixel = 16.0;
constexpr double kFewSamples = 1 << 16;
// Nor one that is smaller than a pixel: the filter that makes it would be far wider than the plane.
constexpr double kMostSamplesAlongPixel = 4.0 * RenderOptions::kMaxImageSide;

// Of what is drawn first: at least so many samples a spacing.
constexpr double kLeastSamplesPerSpacing = 1.5;
constexpr int kMostApart = 8;
// And at least so many samples in all: of fewer too little can be seen.
constexpr double kFewestSamples = 32 * 32;

// Looks that are steeper, in opacity over the field's range, draw lines too thin for samples apart.
constexpr double kGreatestSteepness = 25;
// Of looks that are steeper than this, most samples are drawn after all, unless there are so many
// that those drawn first cost next to nothing.
constexpr double kSteepness = 4;
constexpr int kLeastApartIfSteep = 4;

struct ViewAxes {
  Vec3 eye, right, up, axis;
  double across, upwards;  // half of the picture: world units, or at z = 1
};

ViewAxes view_axes(const Camera& camera, const RenderOptions& options) {
  ViewAxes view;
  view.eye = camera.position;
  view.axis = (camera.focal_point - camera.position).normalized();
  view.right = view.axis.cross(camera.view_up).normalized();
  view.up = view.right.cross(view.axis);
  view.upwards = camera.parallel_projection
                     ? camera.parallel_scale
                     : std::tan(camera.view_angle * std::numbers::pi / 360.0);
  view.across = view.upwards * options.width / options.height;
  return view;
}

// The lattice's planes that the view axis meets most nearly at a right angle: the axes that span
// them, and the one that leads from plane to plane.
AxisOrder order_for(const Mat3& axes, const Vec3& view_axis) {
  constexpr std::array<AxisOrder, 3> kOrders{{{1, 2, 0}, {0, 2, 1}, {0, 1, 2}}};
  AxisOrder best = kOrders[2];
  double greatest = -1;
  for (const AxisOrder& order : {kOrders[2], kOrders[1], kOrders[0]}) {
    const Vec3 normal = axes.col(order[0]).cross(axes.col(order[1])).normalized();
    const double cosine = std::abs(normal.dot(view_axis));
    if (cosine > greatest * (1 + 1e-12)) {
      greatest = cosine;
      best = order;
    }
  }
  return best;
}

// Pixel coordinates of (X, Y, 1) in units of the picture plane's world axes.
Mat3 pixels_from_plane(const ViewAxes& view, const RenderOptions& options) {
  Mat3 map;
  map << options.width / (2 * view.across), 0, options.width / 2.0 - 0.5,   //
      0, -options.height / (2 * view.upwards), options.height / 2.0 - 0.5,  //
      0, 0, 1;
  return map;
}

// Lengths, pixels, of steps of one along the base plane's axes.
Eigen::Vector2d stretch_at(const Mat3& picture_from_plane, const Eigen::Vector2d& at) {
  const Vec3 mapped = picture_from_plane * Vec3(at[0], at[1], 1);
  const Eigen::Vector2d place = mapped.head<2>() / mapped[2];
  Eigen::Vector2d stretch;
  for (int a = 0; a < 2; ++a) {
    const Vec3 column = picture_from_plane.col(a);
    stretch[a] = (column.head<2>() - place * column[2]).norm() / mapped[2];
  }
  return stretch;
}

}  // namespace

std::optional<BasePlane> base_plane(const LatticeField& field, const Bounds3& support,
                                    const Camera& camera, const RenderOptions& options,
                                    std::span<const Vec3> also) {
  const ViewAxes view = view_axes(camera, options);
  const Affine3& world_from_index = field.geometry().world_from_index;
  const Mat3 axes = world_from_index.linear();
  BasePlane base;
  base.order = order_for(axes, view.axis);
  base.is_parallel = camera.parallel_projection;
  base.eye = view.eye;
  base.axis = view.axis;
  const Vec3 along = axes.col(base.order[0]).normalized();
  const Vec3 down = axes.col(base.order[1]).normalized();
  Vec3 normal = along.cross(down).normalized();
  if (normal.dot(view.axis) < 0) normal = -normal;

  // Of (X, Y, 1), the place axis + X along + Y down.
  Mat3 plane;
  plane << along.dot(view.right), down.dot(view.right), 0,  //
      along.dot(view.up), down.dot(view.up), 0,             //
      0, 0, 1;
  if (!base.is_parallel) plane.row(2) << along.dot(view.axis), down.dot(view.axis), 1;
  const Mat3 picture_from_plane = pixels_from_plane(view, options) * plane;
  if (!(normal.dot(view.axis) >= kLeastCosine)) return std::nullopt;
  const Mat3 plane_from_picture = picture_from_plane.inverse();

  // What the picture shows of the plane.
  Eigen::AlignedBox2d shown;
  for (const double x : {-0.5, options.width - 0.5}) {
    for (const double y : {-0.5, options.height - 0.5}) {
      const Vec3 corner = plane_from_picture * Vec3(x, y, 1);
      if (!(corner[2] > 0)) return std::nullopt;  // its ray runs beside the plane
      shown.extend(Eigen::Vector2d(corner.head<2>() / corner[2]));
    }
  }

  // What the field covers of it, and how far it reaches.
  Mat3 basis;
  basis << along, down, view.axis;
  const Mat3 from_world = basis.inverse();
  Eigen::AlignedBox2d covered;
  double farthest = -std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 world = world_from_index * support.corner(static_cast<Bounds3::CornerType>(corner));
    const Vec3 place = from_world * (world - view.eye);
    if (!base.is_parallel && !(place[2] > 0)) return std::nullopt;
    const double scale = base.is_parallel ? 1.0 : place[2];
    covered.extend(Eigen::Vector2d(place.head<2>() / scale));
    farthest = std::max(farthest, place[2]);
  }
  for (const Vec3& world : also) {
    const Vec3 place = from_world * (world - view.eye);
    if (!base.is_parallel && !(place[2] > 0)) return std::nullopt;
    covered.extend(Eigen::Vector2d(place.head<2>() / (base.is_parallel ? 1.0 : place[2])));
  }
  Eigen::AlignedBox2d window = shown.intersection(covered);
  if (window.isEmpty()) window = Eigen::AlignedBox2d(Eigen::Vector2d(shown.center()));

  if (!base.is_parallel) {
    for (int corner = 0; corner < 4; ++corner) {
      const Eigen::Vector2d at =
          window.corner(static_cast<Eigen::AlignedBox2d::CornerType>(corner));
      const Vec3 ray = view.axis + at[0] * along + at[1] * down;
      if (!(normal.dot(ray) >= kLeastCosine * ray.norm())) return std::nullopt;
    }
    const Eigen::Vector2d middle = window.center();
    const Vec3 ray = view.axis + middle[0] * along + middle[1] * down;
    base.closeness = 1 / std::max(1.0, view.axis.dot(ray));
  }

  // Half way from as dense as the picture in the window's middle to as dense as anywhere; of the
  // lattice where it is farthest.
  Eigen::Vector2d stretch = Eigen::Vector2d::Zero();
  for (int corner = 0; corner < 4; ++corner) {
    stretch = stretch.cwiseMax(stretch_at(
        picture_from_plane, window.corner(static_cast<Eigen::AlignedBox2d::CornerType>(corner))));
  }
  stretch = (stretch + stretch_at(picture_from_plane, window.center())) / 2;
  Eigen::Vector2d step;
  Eigen::Vector2d first;
  std::array<int, 2> count{};
  base.samples_per_spacing = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 2; ++a) {
    const double spacing = axes.col(base.order[static_cast<std::size_t>(a)]).norm();
    const double least = spacing / (base.is_parallel ? 1.0 : farthest);  // on the rearmost sheet
    step[a] = std::min(1 / (kBaseDensity * stretch[a]), kMostSpacings * least);
    base.samples_per_spacing = std::min(base.samples_per_spacing, least / step[a]);
    if (!(1 / (stretch[a] * step[a]) <= kMostSamplesAlongPixel)) return std::nullopt;
    const double samples_around = kSamplesAround * step[a];
    const double pixels_around = std::max(samples_around, kSamplesAround / stretch[a]);
    first[a] = std::min(window.min()[a], std::max(shown.min()[a] - pixels_around,
                                                  covered.min()[a] - samples_around));
    const double last = std::max(window.max()[a], std::min(shown.max()[a] + pixels_around,
                                                           covered.max()[a] + samples_around));
    const double samples = std::ceil((last - first[a]) / step[a]) + 1;
    if (!(samples <= 4.0 * RenderOptions::kMaxImageSide)) return std::nullopt;
    count[static_cast<std::size_t>(a)] = static_cast<int>(samples);
  }
  const double samples = static_cast<double>(count[0]) * count[1];
  const double pixels = static_cast<double>(options.width) * options.height;
  if (samples > std::max(kFewSamples, kMostSamplesPerPixel * pixels)) return std::nullopt;

  base.width = count[0];
  base.height = count[1];
  base.picture_width = options.width;
  base.picture_height = options.height;
  base.corner = first[0] * along + first[1] * down;
  base.per_x = step[0] * along;
  base.per_y = step[1] * down;
  Mat3 plane_from_base;
  plane_from_base << step[0], 0, first[0], 0, step[1], first[1], 0, 0, 1;
  base.picture_from_base.matrix = picture_from_plane * plane_from_base;
  base.base_from_picture.matrix = base.picture_from_base.matrix.inverse();
  base.depth = {base.corner.dot(view.axis) + (base.is_parallel ? 0.0 : 1.0),
                base.per_x.dot(view.axis), base.per_y.dot(view.axis)};
  return base;
}

int first_samples_apart(const BasePlane& base, double steepness, Mode mode,
                        const RenderOptions& options) {
  // An x-ray's numbers are no colours.
  if (options.post_convolution != PostConvolution::kAuto || mode == Mode::kXray ||
      steepness > kGreatestSteepness)
    return 1;
  const double samples = static_cast<double>(base.width) * base.height;
  int n = 1;
  while (n < kMostApart && base.samples_per_spacing >= kLeastSamplesPerSpacing * 2 * n &&
         samples >= kFewestSamples * 4 * n * n)
    n *= 2;
  return steepness > kSteepness && n < kLeastApartIfSteep ? 1 : n;
}

PlaneOfOther plane_for(const BasePlane& base, const LatticeGeometry& lattice) {
  constexpr double kMostDrift = 1e-3;  // spacings
  PlaneOfOther out{base};
  out.base.order = kOwnOrder;
  const Mat3 index_from_world = lattice.world_from_index.linear().inverse();
  double scale = 1;  // of the rearmost sheet that meets the lattice
  if (!base.is_parallel) {
    const Vec3 normal = base.per_x.cross(base.per_y);
    const Bounds3 box = lattice.index_bounds();
    for (int i = 0; i < 8; ++i) {
      const Vec3 corner =
          lattice.world_from_index * box.corner(static_cast<Bounds3::CornerType>(i));
      const double z = normal.dot(corner - base.eye) / normal.dot(base.axis);
      scale = i == 0 ? z : std::max(scale, z);
    }
  }
  const Vec3 steps[2] = {index_from_world * base.per_x * scale,
                         index_from_world * base.per_y * scale};
  out.samples_apart = std::max(steps[0].norm(), steps[1].norm());
  const std::array<double, 2> samples = {1.0 * base.width, 1.0 * base.height};
  AxisOrder order = kOwnOrder;
  for (std::size_t i = 0; i < 2; ++i) {
    Eigen::Index along = 0;
    steps[i].cwiseAbs().maxCoeff(&along);
    order[i] = static_cast<int>(along);
    Vec3 drift = steps[i];
    drift[along] = 0;
    // Rows that share weights go from lesser samples to greater ones.
    if (!(steps[i][along] > 0) || drift.cwiseAbs().maxCoeff() * samples[i] > kMostDrift) return out;
  }
  order[2] = 3 - order[0] - order[1];
  if (order[0] == order[1]) return out;
  out.base.order = order;
  out.is_aligned = true;
  return out;
}

}  // namespace ovoid::view
