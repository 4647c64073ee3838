// SPDX-License-Identifier: Apache-2.0
// vtkCamera and the viewport as the library's camera and picture.
#pragma once

#include <vector>

#include "ovoid/camera.h"
#include "ovoid/math.h"
#include "ovoid/render_options.h"

class vtkRenderer;

namespace ovoid::mappers {

// How depths of OpenGL's buffer and along the view axis go together: the third and fourth numbers
// of the projection's third row.
struct DepthScale {
  bool is_parallel = false;
  double scale = 0;
  double offset = 0;

  // `buffered` in [0, 1), as OpenGL keeps it; distance from the camera plane along the view axis.
  double depth_of(double buffered) const;
};

// The picture that is drawn holds the viewport; it is larger where the camera's axis does not go
// through the viewport's middle (WindowCenter, tiles), because the library's always does.
struct View {
  Camera camera;
  int width = 0;  // of the picture, pixels
  int height = 0;
  int left = 0;  // of the viewport in it
  int bottom = 0;
  int viewport_width = 0;
  int viewport_height = 0;
  int window_left = 0;  // of the viewport in the window
  int window_bottom = 0;
  double coarseness_x = 1;  // pixels of the viewport for one of the picture
  double coarseness_y = 1;
  DepthScale depths;
  double near_depth = 0;  // the camera's clipping range
  double far_depth = 0;

  // The viewport's pixel at a picture's, both counted from the left and from the bottom; what lies
  // beside the viewport is < 0 or beyond its size.
  int viewport_column(int x) const { return static_cast<int>((x + 0.5) * coarseness_x) - left; }
  int viewport_row(int y) const { return static_cast<int>((y + 0.5) * coarseness_y) - bottom; }
};

// Throws Error(kUnsupported) for a camera that shears, mirrors or scales, and for pixels that are
// not square.
View view_of(vtkRenderer* renderer);

// The same view with one pixel for `distance` x `distance` of the viewport's.
View coarser(const View& view, double distance);

// Planes for what of `world_bounds` lies before or behind the camera's clipping range; none where
// the range holds all of it, or the eye is within the bounds and near the near plane.
std::vector<ClipPlane> clipping_range_planes(const View& view, const Bounds3& world_bounds);

}  // namespace ovoid::mappers
