// SPDX-License-Identifier: Apache-2.0
#include "ray_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rays.h"

namespace ovoid::mappers {
namespace {

constexpr float kNowhere = std::numeric_limits<float>::infinity();
constexpr unsigned kMiddleRegion = 1U << 13;

DepthLimits empty_limits(const View& view) {
  DepthLimits limits;
  limits.width = view.width;
  limits.height = view.height;
  limits.first.reserve(
      static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height) + 1);
  limits.first.push_back(0);
  return limits;
}

void end_pixel(DepthLimits& limits) {
  limits.first.push_back(static_cast<std::uint32_t>(limits.stops.size()));
}

bool draws(const Cropping& cropping, const Vec3& place) {
  int region = 0;
  for (int axis = 0, step = 1; axis < 3; ++axis, step *= 3) {
    const auto at = static_cast<std::size_t>(2 * axis);
    region += step * (place[axis] < cropping.planes[at]       ? 0
                      : place[axis] < cropping.planes[at + 1] ? 1
                                                              : 2);
  }
  return (cropping.regions >> region & 1U) != 0;
}

// Of a ray, what is drawn of it.
struct Span {
  double enter = -std::numeric_limits<double>::infinity();
  double leave = std::numeric_limits<double>::infinity();
};

// Span of(origin, direction) of each pixel's ray; where one ends the field does, or, at seams,
// another frame goes on.
template <class Of>
DepthLimits limits_of_spans(const View& view, bool are_seams, const Of& of) {
  DepthLimits limits = empty_limits(view);
  const Rays rays(view);
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      Vec3 origin, direction;
      rays.at(x, y, &origin, &direction);
      const auto [enter, leave] = of(origin, direction);
      if (enter < leave) {
        limits.stops.push_back({static_cast<float>(enter), true, are_seams, {}});
        if (leave < kNowhere)
          limits.stops.push_back({static_cast<float>(leave), false, are_seams, {}});
      }
      end_pixel(limits);
    }
  }
  return limits;
}

}  // namespace

bool is_one_box(const Cropping& cropping) { return cropping.regions == kMiddleRegion; }

std::vector<ClipPlane> planes_of_box(const Cropping& cropping, const Affine3& world_from_data) {
  // Normals go by the transposed inverse.
  const Mat3 normals = world_from_data.linear().inverse().transpose();
  std::vector<ClipPlane> planes;
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const double at = cropping.planes[static_cast<std::size_t>(2 * axis + side)];
      const Vec3 normal = (side == 0 ? 1.0 : -1.0) * normals.col(axis);
      planes.push_back({normal, normal.dot(world_from_data * (at * Vec3::Unit(axis)))});
    }
  }
  return planes;
}

DepthLimits region_limits(const Cropping& cropping, const Affine3& world_from_data,
                          const View& view) {
  DepthLimits limits = empty_limits(view);
  const Rays rays(view);
  const Affine3 data_from_world = world_from_data.inverse();
  std::array<double, 6> depths{};  // where the ray crosses planes, rising
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      Vec3 origin, direction;
      rays.at(x, y, &origin, &direction);
      const Vec3 from = data_from_world * origin;
      const Vec3 way = data_from_world.linear() * direction;
      std::size_t count = 0;
      for (std::size_t i = 0; i < 6; ++i) {
        const auto axis = static_cast<Eigen::Index>(i / 2);
        const double depth = (cropping.planes[i] - from[axis]) / way[axis];
        if (!std::isfinite(depth)) continue;
        std::size_t place = count++;
        for (; place > 0 && depths[place - 1] > depth; --place) depths[place] = depths[place - 1];
        depths[place] = depth;
      }
      bool is_drawn = false;
      for (std::size_t i = 0; i <= count; ++i) {  // the stretch before depth i
        const double middle = count == 0   ? 0
                              : i == 0     ? depths[0] - 1
                              : i == count ? depths[i - 1] + 1
                                           : 0.5 * (depths[i - 1] + depths[i]);
        const bool is_next = draws(cropping, from + middle * way);
        if (is_next == is_drawn) continue;
        is_drawn = is_next;
        limits.stops.push_back(
            {i == 0 ? -kNowhere : static_cast<float>(depths[i - 1]), is_drawn, {}});
      }
      end_pixel(limits);
    }
  }
  return limits;
}

DepthLimits plane_limits(std::span<const ClipPlane> planes, const View& view) {
  return limits_of_spans(view, false, [&](const Vec3& origin, const Vec3& direction) {
    Span span;
    for (const ClipPlane& plane : planes) {
      const double slope = plane.normal.dot(direction);
      const double inside = plane.normal.dot(origin) - plane.offset;
      if (slope > 0) span.enter = std::max(span.enter, -inside / slope);
      if (slope < 0) span.leave = std::min(span.leave, -inside / slope);
      if (slope == 0 && inside < 0) span.leave = span.enter;
    }
    return span;
  });
}

std::optional<Bounds3> owned_box(const double bounds[6]) {
  if (std::none_of(bounds, bounds + 6, [](double side) { return std::isfinite(side); })) return {};
  return Bounds3(Vec3(bounds[0], bounds[2], bounds[4]), Vec3(bounds[1], bounds[3], bounds[5]));
}

void widen(double bounds[6]) {
  constexpr double kShare = 0.125;
  const Vec3 lo(bounds[0], bounds[2], bounds[4]), hi(bounds[1], bounds[3], bounds[5]);
  const double beyond = kShare * (hi - lo).norm();
  for (int axis = 0; axis < 3; ++axis) {
    bounds[2 * axis] -= beyond;
    bounds[2 * axis + 1] += beyond;
  }
}

DepthLimits box_limits(const Bounds3& world, const View& view) {
  return limits_of_spans(view, true, [&](const Vec3& origin, const Vec3& direction) {
    Span span;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double slope = direction[axis];
      if (slope == 0) {
        if (origin[axis] < world.min()[axis] || origin[axis] >= world.max()[axis])
          span.leave = span.enter;
        continue;
      }
      const double to_min = (world.min()[axis] - origin[axis]) / slope;
      const double to_max = (world.max()[axis] - origin[axis]) / slope;
      span.enter = std::max(span.enter, std::min(to_min, to_max));
      span.leave = std::min(span.leave, std::max(to_min, to_max));
    }
    return span;
  });
}

void limits_before(std::span<const float> depths, const View& view, DepthLimits* limits) {
  limits->width = view.width;
  limits->height = view.height;
  const auto num_pixels =
      static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
  limits->first.resize(num_pixels + 1);
  limits->stops.resize(2 * num_pixels);  // at most
  std::uint32_t* first = limits->first.data();
  DepthLimits::Stop* const begin = limits->stops.data();
  DepthLimits::Stop* stop = begin;
  for (int y = 0; y < view.height; ++y) {
    const int row = view.viewport_row(view.height - 1 - y);
    const float* const of_row =
        depths.data() + static_cast<std::ptrdiff_t>(row) * view.viewport_width;
    for (int x = 0; x < view.width; ++x) {
      *first++ = static_cast<std::uint32_t>(stop - begin);
      const int column = view.viewport_column(x);
      const bool is_seen =
          row >= 0 && row < view.viewport_height && column >= 0 && column < view.viewport_width;
      if (!is_seen) continue;
      *stop++ = {-kNowhere, true, {}};
      if (of_row[column] < kNowhere) *stop++ = {of_row[column], false, {}};
    }
  }
  *first = static_cast<std::uint32_t>(stop - begin);
  limits->stops.resize(static_cast<std::size_t>(stop - begin));
}

}  // namespace ovoid::mappers
