// SPDX-License-Identifier: Apache-2.0
// What OpenGL has drawn so far, and the picture over it.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "ovoid/image.h"
#include "view.h"

class vtkRenderer;
class vtkWindow;

namespace ovoid::mappers {

class Screen {
 public:
  Screen();
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  // How far from the camera plane, along the view axis, each pixel of the viewport is covered, row
  // 0 at the bottom; infinite where it is not. Empty if nothing covers any before `farthest`.
  // Until the next call. Throws Error(kUnsupported) if the window tells no depths.
  std::span<const float> depths(vtkRenderer* renderer, const View& view, double farthest);

  // Blends the picture, which is premultiplied, over the viewport: its floats as they are, pixel on
  // pixel, or between the pixels of a coarser one. Writes no depth. Throws Error(kUnsupported) for
  // a window that is not OpenGL's.
  void show(vtkRenderer* renderer, const View& view, const Image& image);

  void release(vtkWindow* window);

 private:
  struct Gl;
  std::unique_ptr<Gl> gl_;
  std::vector<float> depths_;
};

}  // namespace ovoid::mappers
