// SPDX-License-Identifier: Apache-2.0
// Axes, colour bar and scale bar over the picture: the library's own, drawn on small pieces when
// they change, so that they cost little while the picture moves.
#pragma once

#include <imgui.h>

#include <cstdint>
#include <utility>

#include "document.h"
#include "gui.h"

namespace ovoid::viewer {

class Marks {
 public:
  // Draws the marks of the document's view into the rectangle of `size` units at `at`; `density`:
  // pixels per unit; `scale`: of the interface. `xray_range`: over which an x-ray's colours are
  // spread.
  void draw(const Document& document, const std::pair<double, double>& xray_range, ImDrawList& list,
            ImVec2 at, ImVec2 size, float density, float scale);

 private:
  // What of a piece is not clear, and where in the piece that is.
  struct Mark {
    Texture texture;
    int x = 0, y = 0;
  };
  Mark axes_, color_bar_, scale_bar_;
  // The document's versions of which they are.
  std::uint64_t version_ = ~std::uint64_t{0}, view_version_ = ~std::uint64_t{0};
  std::pair<double, double> xray_range_;
  Size drawn_for_;
};

}  // namespace ovoid::viewer
