// SPDX-License-Identifier: Apache-2.0
// In: a kernel set, camera and look. Out: a picture of balls. Each tile finds the nearest ball at
// four places of each pixel, then lights what it has found.
#include "render/passes/point_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <new>
#include <numbers>
#include <optional>
#include <vector>

#include "data/kernels/kernel_shape.h"
#include "data/parallel.h"
#include "ovoid/error.h"
#include "render/passes/picture_tiles.h"
#include "render/passes/surface_raster.h"
#include "view/look/color_attribute.h"
#include "view/look/light.h"
#include "view/look/look_table.h"
#include "view/plan/space_part.h"
#include "view/plan/visible_points.h"

namespace ovoid {
namespace {

constexpr int kBallTile = TileLists::kTile;
constexpr double kLeastRadius = 0.6;  // pixels
constexpr float kNoDepth = std::numeric_limits<float>::infinity();

// In the camera's axes: right, up, along the view.
struct Ball {
  Vec3 center;
  double radius = 0;
  float value = 0;
};

// How a picture's pixels look at balls.
class BallView {
 public:
  BallView(const Camera& camera, const RenderOptions& options)
      : is_parallel_(camera.parallel_projection),
        width_(options.width),
        height_(options.height),
        eye_(camera.position) {
    const Vec3 towards = camera.focal_point - camera.position;
    axis_ = towards.normalized();
    right_ = axis_.cross(camera.view_up).normalized();
    up_ = right_.cross(axis_);
    near_ = 1e-3 * towards.norm();
    const double half = is_parallel_ ? camera.parallel_scale
                                     : std::tan(camera.view_angle * (std::numbers::pi / 360));
    scale_ = height_ / (2 * half);
  }

  // None: it reaches the eye, or lies behind it.
  std::optional<Ball> ball_at(const Vec3& world, double radius, float value) const {
    const Vec3 from_eye = world - eye_;
    Ball ball{{from_eye.dot(right_), from_eye.dot(up_), from_eye.dot(axis_)}, radius, value};
    if (!(ball.center.z() - ball.radius > near_)) return std::nullopt;
    const double pixel = is_parallel_ ? 1 / scale_ : ball.center.z() / scale_;
    ball.radius = std::max(ball.radius, std::min(kLeastRadius * pixel, ball.center.z() / 2));
    return ball;
  }

  PictureExtent extent_of(const Ball& ball) const {
    const auto [near_x, far_x] = bounds(ball.center.x(), ball);
    const auto [near_y, far_y] = bounds(ball.center.y(), ball);
    return {0.5 * width_ + scale_ * near_x, 0.5 * width_ + scale_ * far_x,
            0.5 * height_ - scale_ * far_y, 0.5 * height_ - scale_ * near_y};
  }

  // Along the view axis where the ray through a place of the picture meets the ball; +inf: nowhere.
  double depth_of(const Ball& ball, double x, double y) const {
    const Vec3 aside((x - 0.5 * width_) / scale_, (0.5 * height_ - y) / scale_, 0);
    if (is_parallel_) {
      const double rest = ball.radius * ball.radius - (ball.center - aside).head<2>().squaredNorm();
      return rest >= 0 ? ball.center.z() - std::sqrt(rest) : kNoDepth;
    }
    const Vec3 ray = aside + Vec3::UnitZ();
    const double length = ray.squaredNorm();
    const double nearest = ball.center.dot(ray) / length;
    const double rest = ball.radius * ball.radius - (ball.center - nearest * ray).squaredNorm();
    return rest >= 0 ? nearest - std::sqrt(rest / length) : kNoDepth;
  }

  // Of a ball, where a ray through the picture meets it at a depth: world, unit length.
  Vec3 normal_of(const Ball& ball, double x, double y, double depth) const {
    const Vec3 aside((x - 0.5 * width_) / scale_, (0.5 * height_ - y) / scale_, 0);
    const Vec3 place =
        is_parallel_ ? Vec3(aside + depth * Vec3::UnitZ()) : Vec3(depth * (aside + Vec3::UnitZ()));
    return to_world((place - ball.center).normalized());
  }
  Vec3 towards_eye(const Ball& ball) const {
    return is_parallel_ ? Vec3(-axis_) : to_world(-ball.center.normalized());
  }

  int width() const noexcept { return width_; }
  int height() const noexcept { return height_; }

 private:
  // Where a coordinate of the ball's box lies in the picture, per depth.
  std::pair<double, double> bounds(double at, const Ball& ball) const {
    const double lo = at - ball.radius;
    const double hi = at + ball.radius;
    if (is_parallel_) return {lo, hi};
    const double front = ball.center.z() - ball.radius;
    const double back = ball.center.z() + ball.radius;
    return {lo / (lo < 0 ? front : back), hi / (hi > 0 ? front : back)};
  }
  Vec3 to_world(const Vec3& view) const {
    return view.x() * right_ + view.y() * up_ + view.z() * axis_;
  }

  bool is_parallel_;
  int width_, height_;
  Vec3 eye_, right_, up_, axis_;
  double near_, scale_;
};

// The value of a kernel's place, of a sum: what kernels around add to its own part, as a factor
// that is found at a few of them.
double share_of_own(const KernelField& field) {
  constexpr std::int64_t kAsked = 64;
  const KernelSource& source = field.source();
  const KernelSampler sampler(field);
  std::vector<double> factors;
  const std::int64_t step = std::max<std::int64_t>(1, source.num_bricks() / kAsked);
  for (std::int64_t b = 0; b < source.num_bricks(); b += step) {
    const KernelView view = source.acquire(b, 0);
    const double own =
        data::weight_of(view, 0) *
        static_cast<double>(view.value[static_cast<std::size_t>(field.attribute())][0]);
    const double sum = sampler.at(source.brick(b).origin + data::offset_of(view, 0)).value;
    if (own != 0 && std::isfinite(sum / own)) factors.push_back(sum / own);
  }
  if (factors.empty()) return 1;
  const auto middle = factors.begin() + static_cast<std::ptrdiff_t>(factors.size() / 2);
  std::nth_element(factors.begin(), middle, factors.end());
  return *middle;
}

struct Point {
  Vec3 center;
  float sigma, value;
};

// The kernels that no clip plane takes away.
std::vector<Point> points_of(const KernelField& field, const std::vector<ClipPlane>& clip_planes,
                             const std::stop_token& stop) {
  const KernelSource& source = field.source();
  const bool is_own_sum = field.reconstruction() == Reconstruction::kSum && !field.has_own_color();
  const double factor = is_own_sum ? share_of_own(field) : 1;
  const auto attribute = static_cast<std::size_t>(field.color_attribute());
  std::vector<Point> points;
  for (std::int64_t b = 0; b < source.num_bricks(); ++b) {
    if (stop.stop_requested()) throw Error(ErrorCode::kCancelled, "rendering was cancelled");
    const KernelView kernels = source.acquire(b, 0);
    for (std::int32_t i = 0; i < kernels.count; ++i) {
      const Vec3 center = source.brick(b).origin + data::offset_of(kernels, i);
      if (!view::is_kept(center, clip_planes)) continue;
      const auto numbers = data::shape_numbers(kernels, source.shape(), i);
      const Vec3 axes = data::semi_axes(source.shape(), numbers.data());
      const double sigma = std::cbrt(axes[0]) * std::cbrt(axes[1]) * std::cbrt(axes[2]);
      double value = kernels.value[attribute][i];
      if (is_own_sum) value *= factor * static_cast<double>(data::weight_of(kernels, i));
      points.push_back({center, static_cast<float>(sigma), static_cast<float>(value)});
    }
  }
  return points;
}

float median_sigma(const std::vector<Point>& points) {
  std::vector<float> sigmas;
  sigmas.reserve(points.size());
  for (const Point& point : points) sigmas.push_back(point.sigma);
  const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
  std::nth_element(sigmas.begin(), middle, sigmas.end());
  return middle != sigmas.end() ? *middle : 0;
}

std::vector<Ball> balls_of(const KernelField& field, const BallView& view, const PointStyle& style,
                           const std::vector<ClipPlane>& clip_planes, const std::stop_token& stop) {
  const std::vector<Point> points = points_of(field, clip_planes, stop);
  // Particles' kernels are wide where few are; the sizes of stored ellipsoids are their own.
  const bool is_bounded = field.source().shape() == KernelShape::kBalls;
  const float most = is_bounded ? median_sigma(points) : kNoDepth;
  std::vector<Ball> balls;
  for (const Point& point : points) {
    const double sigma = static_cast<double>(std::min(point.sigma, most));
    const auto ball =
        view.ball_at(point.center, style.size * PointStyle::kUsualRadius * sigma, point.value);
    if (ball) balls.push_back(*ball);
  }
  return balls;
}

class BallPainter {
 public:
  BallPainter(const KernelField& field, const Camera& camera, const Look& look,
              const PointStyle& style, const RenderOptions& options, const std::stop_token& stop)
      : view_(camera, options),
        look_(look),
        colors_(view::colors_alone(field.has_own_color() ? view::color_function_of(look)
                                                         : look.transfer_function)),
        balls_(balls_of(field, view_, style, options.clip_planes, stop)),
        tiles_(options.width, options.height),
        key_(view::direction_of_light(look, camera)) {
    tiles_.assign(static_cast<std::uint32_t>(balls_.size()),
                  [&](std::uint32_t ball) { return view_.extent_of(balls_[ball]); });
    image_.width = options.width;
    image_.height = options.height;
    const auto count =
        static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height);
    image_.rgba.assign(4 * count, 0.0F);
    image_.depth.assign(count, kNoDepth);
    image_.front_depth.assign(count, kNoDepth);
  }

  int num_tiles() const noexcept { return tiles_.num_tiles(); }
  std::int64_t num_balls() const noexcept { return static_cast<std::int64_t>(balls_.size()); }
  Image& image() noexcept { return image_; }

  void paint_tile(int tile) {
    Hits hits{};
    const int x0 = tiles_.tile_x(tile);
    const int y0 = tiles_.tile_y(tile);
    const int x_end = std::min(x0 + kBallTile, view_.width());
    const int y_end = std::min(y0 + kBallTile, view_.height());
    for (const std::uint32_t number : tiles_.of_tile(tile)) {
      const Ball& ball = balls_[number];
      const PictureExtent extent = view_.extent_of(ball);
      const int right = static_cast<int>(std::min<double>(std::ceil(extent.right), x_end));
      const int bottom = static_cast<int>(std::min<double>(std::ceil(extent.bottom), y_end));
      for (int y = std::max(y0, static_cast<int>(std::max(extent.top, 0.0))); y < bottom; ++y) {
        for (int x = std::max(x0, static_cast<int>(std::max(extent.left, 0.0))); x < right; ++x) {
          auto& pixel = hits[static_cast<std::size_t>((y - y0) * kBallTile + x - x0)];
          for (std::size_t p = 0; p < pixel.size(); ++p) {
            const auto& [across, down] = SurfaceRaster::kPlacesInPixel[p];
            const double depth = view_.depth_of(ball, x + across, y + down);
            if (depth < pixel[p].depth) pixel[p] = {depth, number};
          }
        }
      }
    }
    for (int y = y0; y < y_end; ++y) {
      for (int x = x0; x < x_end; ++x)
        paint_pixel(x, y, hits[static_cast<std::size_t>((y - y0) * kBallTile + x - x0)]);
    }
  }

 private:
  struct Hit {
    double depth = kNoDepth;
    std::uint32_t ball = 0;
  };
  using PixelHits = std::array<Hit, SurfaceRaster::kPlaces>;
  using Hits = std::array<PixelHits, static_cast<std::size_t>(kBallTile) * kBallTile>;

  void paint_pixel(int x, int y, const PixelHits& hits) {
    Rgb sum{0, 0, 0};
    std::array<double, SurfaceRaster::kPlaces> depths;  // what covers nothing is last
    depths.fill(static_cast<double>(kNoDepth));
    int covered = 0;
    for (std::size_t p = 0; p < hits.size(); ++p) {
      if (hits[p].depth == kNoDepth) continue;
      const auto& [across, down] = SurfaceRaster::kPlacesInPixel[p];
      const Rgb color = color_at(x + across, y + down, hits[p]);
      for (std::size_t c = 0; c < 3; ++c) sum[c] += color[c] / SurfaceRaster::kPlaces;
      depths[static_cast<std::size_t>(covered++)] = hits[p].depth;
    }
    if (covered == 0) return;
    const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) +
                           static_cast<std::size_t>(x);
    for (std::size_t c = 0; c < 3; ++c) image_.rgba[4 * at + c] = static_cast<float>(sum[c]);
    image_.rgba[4 * at + 3] = static_cast<float>(covered) / SurfaceRaster::kPlaces;
    constexpr int kHalf = SurfaceRaster::kPlaces / 2;
    std::sort(depths.begin(), depths.end());
    image_.front_depth[at] = static_cast<float>(depths[0]);  // one place in four is seen
    if (covered < kHalf) return;
    image_.depth[at] = static_cast<float>(depths[kHalf - 1]);
  }

  Rgb color_at(double x, double y, const Hit& hit) const {
    const Ball& ball = balls_[hit.ball];
    const view::LookTable::Sample own = colors_.at(ball.value);
    const Vec3 to_eye = view_.towards_eye(ball);
    const view::LightShares light = view::light_shares(
        look_, view_.normal_of(ball, x, y, hit.depth), key_.value_or(to_eye), to_eye);
    return view::lit_color({own.r, own.g, own.b}, look_.material, light, 1);
  }

  const BallView view_;
  const Look& look_;
  const view::LookTable colors_;
  const std::vector<Ball> balls_;
  TileLists tiles_;
  const std::optional<Vec3> key_;  // none: from the eye
  Image image_;
};

}  // namespace

Frame paint_points(const KernelField& field, const Camera& camera, const Look& look,
                   const PointStyle& style, const RenderOptions& options, int threads,
                   const RenderHooks& hooks) try {
  if (field.is_empty()) throw Error(ErrorCode::kInvalidArgument, "field: is empty");
  camera.validate();
  look.validate();
  options.validate();
  if (!(style.size > 0) || !std::isfinite(style.size)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("point size = {}: must be > 0", style.size));
  }
  const auto start = std::chrono::steady_clock::now();
  BallPainter painter(field, camera, look, style, options, hooks.stop);
  paint_tiles(painter.num_tiles(), threads, hooks, [&](int tile) { painter.paint_tile(tile); });
  Frame frame;
  frame.image = std::move(painter.image());
  frame.profile.backend = "cpu";
  frame.profile.threads = data::resolve_threads(threads);
  frame.profile.kernels_total = field.num_kernels();
  frame.profile.kernels_drawn = painter.num_balls();
  frame.profile.frame_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  if (options.collect_profile) frame.profile.stages_ms = {{"points", frame.profile.frame_ms}};
  if (hooks.tile_done) hooks.tile_done({0, 0, options.width, options.height, &frame.image});
  if (options.part != nullptr)
    frame.seen = view::runs_of_surfaces(frame.image, *options.part, camera);
  return frame;
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::kOutOfMemory,
              fmt::format("a picture of {} x {} pixels of {} points: no memory", options.width,
                          options.height, field.num_kernels()));
}

}  // namespace ovoid
