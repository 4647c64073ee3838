// SPDX-License-Identifier: Apache-2.0
// Regions of a look by value and gradient, edited with the mouse before the histogram of both.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gui.h"
#include "region_plane.h"
#include "widgets.h"

namespace ovoid::viewer {

// What is remembered of the editor between frames.
struct RegionEditing {
  int selected = -1;
  // What is held: a region by its grip, or, with no region, a place where a new one begins.
  struct Held {
    RegionHit hit;
    LookRegion region;  // as it was when it was taken hold of
    PlanePoint from;
    PlaneAxes axes;  // stay as they are meanwhile
  };
  std::optional<Held> held;
  // Pictures, and what they are of.
  Texture counts, colors;
  std::shared_ptr<const cli::Histogram2D> counted;
  ImU32 ground = 0;
  std::optional<TransferFunction2D> colored;
};

struct RegionCanvas {
  std::shared_ptr<const cli::Histogram2D> histogram;  // drawn behind; null: none
  PlaneAxes axes;
  std::string unit;  // of the values
};

// The function's colours over the histogram. Of regions each has an outline: click selects, drag
// moves, the selected one's dots change its sides, and its diamonds the width of its foot; a double
// click, or a drag, where there is none makes a new one; right click, or Delete, takes one away.
// The canvas is named NAME, regions NAME.0 ..., the selected one's grips NAME.top-left ... Returns
// whether the function changed. A table is shown only.
bool edit_regions(Widgets& widgets, const std::string& name, TransferFunction2D& function,
                  const RegionCanvas& canvas, RegionEditing& editing);

// The function of other regions, if they make one.
bool take_regions(TransferFunction2D& function, std::vector<LookRegion> regions);

}  // namespace ovoid::viewer
