// SPDX-License-Identifier: Apache-2.0
// The labels that a plane goes through: what they cover of it, and lines along where they end.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "ovoid/labels.h"
#include "render/passes/plane_view.h"

namespace ovoid {

// Immutable. Each pixel is asked at 2 x 2 places.
class LabelsOnPlane {
 public:
  // `labels` has a map, and outlives this. Throws Error(kCancelled).
  LabelsOnPlane(const LabelSurfaces& labels, const PlaneView& view, int width, int height,
                double line_width, int threads, const std::stop_token& stop);

  // Puts what labels show in a pixel over `rgba`: premultiplied, of an opaque slice.
  void draw_over(int x, int y, std::array<float, 4>& rgba) const;

 private:
  using Mark = std::uint16_t;        // a style's place among those that are shown, from 1; 0: none
  static constexpr int kPlaces = 2;  // of a pixel, along either axis

  void find_marks(const PlaneView& view, int threads, const std::stop_token& stop);
  void find_edges(int threads, const std::stop_token& stop);
  Mark mark(int x, int y) const {
    return marks_[static_cast<std::size_t>(y) * row() + static_cast<std::size_t>(x)];
  }
  std::size_t row() const {  // of marks
    return static_cast<std::size_t>(kPlaces) * static_cast<std::size_t>(width_);
  }
  bool has_edge_near(int x, int y) const;
  bool is_on_line(int x, int y) const;

  const LabelSurfaces& labels_;
  int width_, height_;                      // of the picture, pixels
  int reach_;                               // of a line, pixels
  std::vector<Rgb> colors_;                 // of marks
  std::vector<Mark> marks_;                 // [kPlaces * height, kPlaces * width]
  std::vector<std::uint8_t> edges_;         // [height, width] whether marks meet in a pixel
  std::vector<std::array<int, 2>> around_;  // places of a line's width, the nearest first
};

}  // namespace ovoid
