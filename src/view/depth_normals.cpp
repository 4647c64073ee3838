// SPDX-License-Identifier: Apache-2.0
// In: a picture of depths, and its camera. Out: normals of the surface in it.
//
// Along a row or a column of pixels the depth of a plane goes straight in parallel projection; in
// perspective one over it does. So slopes are those of this number, the `height`, by differences
// that are exact for planes in either.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <numbers>
#include <optional>
#include <vector>

#include "data/parallel.h"
#include "ovoid/error.h"
#include "ovoid/image.h"

namespace ovoid {
namespace {

constexpr int kReach = 2;                // pixels to either side that are looked at
constexpr int kWindow = 2 * kReach + 1;  // along a side
constexpr double kNoHeight = std::numeric_limits<double>::infinity();

struct HeightSlopes {
  double x = 0, y = 0;  // per pixel to the right and down
};

// Rows of heights, with kReach more around them; kNoHeight where there are none.
class HeightRows {
 public:
  HeightRows(std::span<const float> depths, int width, int height, bool is_parallel, int first,
             int end)
      : stride_(width + 2 * kReach), first_(first - kReach) {
    const int rows = end - first + 2 * kReach;
    heights_.assign(static_cast<std::size_t>(rows) * static_cast<std::size_t>(stride_), kNoHeight);
    for (int y = std::max(first_, 0); y < std::min(end + kReach, height); ++y) {
      const float* const from = depths.data() + static_cast<std::size_t>(y) * width;
      double* const to = heights_.data() + at(0, y);
      for (int x = 0; x < width; ++x) {
        const double z = static_cast<double>(from[x]);
        if (std::isfinite(z) && (is_parallel || z > 0)) to[x] = is_parallel ? z : 1 / z;
      }
    }
  }

  const double* of_pixel(int x, int y) const noexcept { return heights_.data() + at(x, y); }
  std::ptrdiff_t stride() const noexcept { return stride_; }

 private:
  std::size_t at(int x, int y) const noexcept {
    return static_cast<std::size_t>((y - first_) * stride_ + x + kReach);
  }

  std::ptrdiff_t stride_;
  int first_;
  std::vector<double> heights_;
};

// The slopes of the parabola nearest to the window around a height, if all of it lies within `most`
// of a plane. They are the plane's: the bends are even, and the window has a middle.
std::optional<HeightSlopes> slopes_of_window(const double* middle, std::ptrdiff_t stride,
                                             double most) {
  constexpr double kSquares = kWindow * 2 * (1 + 4);  // sum of x^2 over the window
  constexpr double kCount = kWindow * kWindow;
  double sum = 0;
  HeightSlopes slopes;
  for (int y = -kReach; y <= kReach; ++y) {
    const double* const row = middle + y * stride;
    const double of_row = row[-2] + row[-1] + row[0] + row[1] + row[2];
    sum += of_row;
    slopes.x += 2 * (row[2] - row[-2]) + (row[1] - row[-1]);
    slopes.y += y * of_row;
  }
  if (!std::isfinite(sum)) return std::nullopt;
  slopes.x /= kSquares;
  slopes.y /= kSquares;
  const double mean = sum / kCount;
  double farthest = 0;
  for (int y = -kReach; y <= kReach; ++y) {
    const double* const row = middle + y * stride;
    for (int x = -kReach; x <= kReach; ++x)
      farthest = std::max(farthest, std::abs(row[x] - (mean + slopes.x * x + slopes.y * y)));
  }
  if (farthest > most) return std::nullopt;
  return slopes;
}

// The slope along one axis, whose heights are `step` apart, at `middle`: of the parabola through
// the three that bend least. Where there are no three, of the nearer of two.
double slope_along(const double* middle, std::ptrdiff_t step) {
  const auto at = [&](std::ptrdiff_t i) { return middle[i * step]; };
  const double here = at(0);
  struct Way {
    double bend, slope;
  };
  const std::array<Way, 3> ways{
      Way{at(-1) - 2 * here + at(1), 0.5 * (at(1) - at(-1))},
      Way{here - 2 * at(-1) + at(-2), 0.5 * (3 * here - 4 * at(-1) + at(-2))},
      Way{here - 2 * at(1) + at(2), -0.5 * (3 * here - 4 * at(1) + at(2))}};
  double least = kNoHeight;
  double slope = 0;
  for (const Way& way : ways) {
    if (!(std::abs(way.bend) < least)) continue;  // not if one of the three is not there
    least = std::abs(way.bend);
    slope = way.slope;
  }
  if (least < kNoHeight) return slope;
  for (const double difference : {here - at(-1), at(1) - here}) {
    if (!(std::abs(difference) < least)) continue;
    least = std::abs(difference);
    slope = difference;
  }
  return slope;
}

class NormalsOfView {
 public:
  NormalsOfView(const Camera& camera, int width, int height)
      : is_parallel_(camera.parallel_projection),
        middle_x_(0.5 * (width - 1)),
        middle_y_(0.5 * (height - 1)) {
    axis_ = (camera.focal_point - camera.position).normalized();
    right_ = axis_.cross(camera.view_up).normalized();
    down_ = axis_.cross(right_);
    const double half =
        is_parallel_ ? camera.parallel_scale : std::tan(camera.view_angle * std::numbers::pi / 360);
    pixel_ = 2 * half / height;
  }

  Vec3 normal_at(int x, int y, const HeightRows& rows) const {
    const double* const here = rows.of_pixel(x, y);
    if (*here == kNoHeight) return Vec3::Zero();
    // A pixel's width along the view axis, as a height.
    const double wide = is_parallel_ ? pixel_ : pixel_ * *here;
    const std::optional<HeightSlopes> smooth = slopes_of_window(here, rows.stride(), wide);
    const HeightSlopes slopes =
        smooth ? *smooth : HeightSlopes{slope_along(here, 1), slope_along(here, rows.stride())};
    const Vec3 across = (slopes.x * right_ + slopes.y * down_) / pixel_;
    if (is_parallel_) return (across - axis_).normalized();
    // Of a plane n p = 1 about the eye the height is n (axis + pixel (x right + y down)).
    const double along = *here - (x - middle_x_) * slopes.x - (y - middle_y_) * slopes.y;
    return -(along * axis_ + across).normalized();
  }

 private:
  bool is_parallel_;
  double middle_x_, middle_y_;
  Vec3 axis_, right_, down_;
  double pixel_;  // parallel: world; perspective: at depth 1
};

}  // namespace

std::vector<float> depth_normals(std::span<const float> depths, int width, int height,
                                 const Camera& camera, int threads) try {
  camera.validate();
  if (width < 1 || height < 1 ||
      depths.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("depths: {} numbers: must be {} x {}, at least one", depths.size(),
                            height, width));
  }
  const NormalsOfView view(camera, width, height);
  std::vector<float> normals(3 * depths.size());
  constexpr std::int64_t kRowsEach = 32;
  data::parallel_ranges(
      {height, kRowsEach, threads, {}}, [&](std::int64_t begin, std::int64_t end) {
        const HeightRows rows(depths, width, height, camera.parallel_projection,
                              static_cast<int>(begin), static_cast<int>(end));
        for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
          for (int x = 0; x < width; ++x) {
            const Vec3 normal = view.normal_at(x, y, rows);
            const std::size_t pixel = static_cast<std::size_t>(y) * width + x;
            for (int a = 0; a < 3; ++a)
              normals[3 * pixel + static_cast<std::size_t>(a)] = static_cast<float>(normal[a]);
          }
        }
      });
  return normals;
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::kOutOfMemory,
              fmt::format("normals of {} x {} pixels: no memory", width, height));
}

}  // namespace ovoid
