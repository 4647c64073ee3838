// SPDX-License-Identifier: Apache-2.0
#include "view.h"

#include <fmt/format.h>
#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::mappers {
namespace {

using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

constexpr double kRounding = 1e-9;
constexpr double kDegrees = 180 / std::numbers::pi;

Matrix4 matrix_of(vtkMatrix4x4* matrix) { return Eigen::Map<const Matrix4>(matrix->GetData()); }

[[noreturn]] void refuse(const std::string& what) {
  throw Error(ErrorCode::kUnsupported, "camera: " + what);
}

// Where the camera stands, whatever transforms of the user's led there.
void place_camera(vtkCamera* camera, Camera* placed) {
  const Matrix4 eye_from_world = matrix_of(camera->GetModelViewTransformMatrix());
  const Mat3 turn = eye_from_world.topLeftCorner<3, 3>();
  const bool is_rotation =
      (turn * turn.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-6 &&
      turn.determinant() > 0 && std::abs(eye_from_world(3, 3) - 1) < kRounding;
  if (!is_rotation)
    refuse("its view transform shears, mirrors or scales: expected one that turns and moves");
  placed->position = -(turn.transpose() * eye_from_world.topRightCorner<3, 1>());
  placed->focal_point = placed->position - camera->GetDistance() * turn.row(2).transpose();
  placed->view_up = turn.row(1).transpose();
}

// One axis of the picture: pixels of the viewport, and where in them the camera's axis is.
struct Side {
  int pixels = 0;
  int before = 0;  // the viewport
};

Side widened(int viewport, double axis_ndc) {
  const double axis = 0.5 * viewport * (1 + axis_ndc);
  const double half = std::max(axis, viewport - axis);
  const auto pixels = static_cast<int>(std::lround(2 * half));
  return {pixels, static_cast<int>(std::lround(half - axis))};
}

}  // namespace

double DepthScale::depth_of(double buffered) const {
  const double ndc = 2 * buffered - 1;
  return is_parallel ? (offset - ndc) / scale : offset / (ndc + scale);
}

View view_of(vtkRenderer* renderer) {
  View view;
  renderer->GetTiledSizeAndOrigin(&view.viewport_width, &view.viewport_height, &view.window_left,
                                  &view.window_bottom);
  if (view.viewport_width < 1 || view.viewport_height < 1) return view;
  vtkCamera* const camera = renderer->GetActiveCamera();
  place_camera(camera, &view.camera);
  view.camera.parallel_projection = camera->GetParallelProjection() != 0;
  camera->GetClippingRange(view.near_depth, view.far_depth);
  const Matrix4 clip_from_eye =
      matrix_of(camera->GetProjectionTransformMatrix(renderer->GetTiledAspectRatio(), -1, 1));
  if (std::abs(clip_from_eye(0, 1)) > kRounding || std::abs(clip_from_eye(1, 0)) > kRounding)
    refuse("its projection shears: expected one that does not");
  const int beside = view.camera.parallel_projection ? 2 : 3;  // of offsets the column that stays 0
  if (std::abs(clip_from_eye(0, beside)) > kRounding ||
      std::abs(clip_from_eye(1, beside)) > kRounding)
    refuse("its projection shears: expected one that does not");
  const double pixel_x = 2 / (clip_from_eye(0, 0) * view.viewport_width);
  const double pixel_y = 2 / (clip_from_eye(1, 1) * view.viewport_height);
  if (!(std::abs(pixel_x - pixel_y) <= 1e-6 * std::abs(pixel_y)))
    refuse(fmt::format("pixels {:g} wide and {:g} high: expected squares", pixel_x, pixel_y));
  const bool is_parallel = view.camera.parallel_projection;
  const Side across =
      widened(view.viewport_width, is_parallel ? clip_from_eye(0, 3) : -clip_from_eye(0, 2));
  const Side up =
      widened(view.viewport_height, is_parallel ? clip_from_eye(1, 3) : -clip_from_eye(1, 2));
  view.width = across.pixels;
  view.left = across.before;
  view.height = up.pixels;
  view.bottom = up.before;
  const double half_height = 0.5 * view.height * pixel_y;  // at distance 1, or in world units
  if (is_parallel)
    view.camera.parallel_scale = half_height;
  else
    view.camera.view_angle = 2 * std::atan(half_height) * kDegrees;
  view.depths = {is_parallel, clip_from_eye(2, 2), clip_from_eye(2, 3)};
  return view;
}

View coarser(const View& view, double distance) {
  View coarse = view;
  // Off the middle the viewport's pixels would fall between the picture's.
  if (!(distance > 1) || view.left != 0 || view.bottom != 0 || view.width != view.viewport_width ||
      view.height != view.viewport_height)
    return view;
  coarse.width = std::max(1, static_cast<int>(std::lround(view.width / distance)));
  coarse.height = std::max(1, static_cast<int>(std::lround(view.height / distance)));
  coarse.coarseness_x = static_cast<double>(view.width) / coarse.width;
  coarse.coarseness_y = static_cast<double>(view.height) / coarse.height;
  return coarse;
}

std::vector<ClipPlane> clipping_range_planes(const View& view, const Bounds3& world_bounds) {
  const Vec3 ahead = (view.camera.focal_point - view.camera.position).normalized();
  double nearest = std::numeric_limits<double>::infinity();
  double farthest = -nearest;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 place = world_bounds.corner(static_cast<Bounds3::CornerType>(corner));
    const double depth = ahead.dot(place - view.camera.position);
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
  }
  // VTK's own near plane, of a camera that stands in the volume, is nearer than this.
  constexpr double kNear = 0.02;
  const bool is_within = nearest < 0;
  std::vector<ClipPlane> planes;
  const double at_eye = ahead.dot(view.camera.position);
  if (view.near_depth > nearest && !(is_within && view.near_depth < kNear * farthest))
    planes.push_back({ahead, at_eye + view.near_depth});
  if (view.far_depth < farthest) planes.push_back({-ahead, -(at_eye + view.far_depth)});
  return planes;
}

}  // namespace ovoid::mappers
