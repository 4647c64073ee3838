// SPDX-License-Identifier: Apache-2.0
// Axes, colour bar and scale bar over the picture: the library's own, drawn on small pieces when
// they change, so that they cost little while the picture moves.
#pragma once

#include <imgui.h>

#include <array>
#include <cstdint>
#include <utility>

#include "document.h"
#include "gui.h"
#include "widgets.h"

namespace ovoid::viewer {

class Marks {
 public:
  // Where they are drawn, in the window's units, and with what.
  struct Place {
    Box2 all;           // colour bars stand at its borders
    Box2 picture;       // the other marks lie over it; as high as what the camera sees
    float density = 1;  // pixels per unit
    float scale = 1;    // of the interface
  };
  using XrayRange = std::pair<double, double>;  // over which an x-ray's colours are spread

  // Draws the marks of the document's view; of one that it is compared with the colour bar, at the
  // left border. `xray_ranges`: of the other one, and of the view.
  void draw(const Document& document, const std::array<XrayRange, 2>& xray_ranges, ImDrawList& list,
            const Place& place);
  // How much of the borders the colour bars take that were drawn last; units.
  double width_at_left() const noexcept { return width_at_left_; }
  double width_at_right() const noexcept { return width_at_right_; }

 private:
  // What of a piece is not clear, and where in the piece that is.
  struct Mark {
    Texture texture;
    int x = 0, y = 0;
    int beside = 0, below = 0;  // clear pixels right of it and below
  };
  // What of the document they were drawn for.
  struct DrawnFor {
    std::uint64_t version = ~std::uint64_t{0}, view_version = 0, other_version = 0;
    std::array<XrayRange, 2> xray_ranges;
    Size all, picture;
  };
  // A piece of a picture, at one of its corners.
  struct Piece {
    Size size;  // pixels
    Size of;    // pixels, of the picture
    Camera camera;
    cli::AnnotationFlags marks;
  };
  static Mark drawn(const Document& document, const View& view, const XrayRange& xray_range,
                    const Piece& piece);

  Mark axes_, color_bar_, other_color_bar_, scale_bar_;
  DrawnFor drawn_for_;
  double width_at_left_ = 0, width_at_right_ = 0;
};

}  // namespace ovoid::viewer
