// SPDX-License-Identifier: Apache-2.0
// Regions of a look by value and gradient (docs/looks2d.md) on a canvas: where they lie, what of
// them the mouse takes hold of, and what it makes of them. Knows no window.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "histogram_2d.h"
#include "ovoid/field.h"
#include "ovoid/transfer_function_2d.h"

namespace ovoid::viewer {

// What a canvas shows: values to the right, gradients upwards from 0.
struct PlaneAxes {
  double value_lo = 0, value_hi = 1;
  double gradient_hi = 1;
};

// All that was counted and all that the function names, but no more of the latter than kBeyond
// times what was counted. `histogram`, `function`: null if there is none. Without a histogram the
// values are `range`.
PlaneAxes plane_axes(const cli::Histogram2D* histogram, const TransferFunction2D* function,
                     const ValueRange& range);
inline constexpr double kBeyond = 3;

struct PlanePoint {
  double value = 0, gradient = 0;
};

// The axes in a rectangle of the window's units, whose y is downwards.
struct PlaneCanvas {
  PlaneAxes axes;
  double x0 = 0, y0 = 0, x1 = 1, y1 = 1;

  double x_of(double value) const;
  double y_of(double gradient) const;
  PlanePoint at(double x, double y) const;  // also beyond the rectangle
};

// What of a region is taken hold of. The feet are where a box's sides begin, at its least gradient.
enum class Grip {
  kNone,
  kBody,
  kLeft,
  kRight,
  kBottom,
  kTop,
  kBottomLeft,
  kBottomRight,
  kTopLeft,
  kTopRight,
  kLeftFoot,
  kRightFoot
};
const char* name_of(Grip grip);  // "top-left"
// Those that a region has, without the body.
std::vector<Grip> grips_of(const LookRegion& region);

struct PlanePlace {
  double x = 0, y = 0;
};
// The middle of a grip. Feet lie below the edge by so much, that they are not under its corners.
PlanePlace place_of(const LookRegion& region, Grip grip, const PlaneCanvas& canvas, double below);

// Its border: the lower corners, by the foot, then the upper ones.
std::array<PlanePlace, 4> outline_of(const LookRegion& region, const PlaneCanvas& canvas);

struct RegionHit {
  int region = -1;  // -1: none
  Grip grip = Grip::kNone;
};
struct Reach {
  double grip = 9;   // how near the mouse must come to one
  double below = 8;  // as place_of() has it
};
// What lies under the mouse: the selected region's grips first, then the selected region, then that
// which lies over the others. `selected`: -1 for none.
RegionHit region_under(std::span<const LookRegion> regions, const PlaneCanvas& canvas,
                       const PlanePlace& mouse, int selected, const Reach& reach);

// The region as it was taken hold of, moved by its grip from one place to another: within the axes,
// or where it was beyond them already; gradients >= 0, no edge over the opposite one. Numbers that
// change are as round as pixels let them be.
LookRegion moved_region(const LookRegion& region, Grip grip, const PlanePoint& from,
                        const PlanePoint& to, const PlaneAxes& axes);

// A box between two corners in any order, cut at the axes' ends; none if that is less than a
// hundredth of the axes wide or high.
std::optional<LookRegion> region_between(const PlanePoint& a, const PlanePoint& b,
                                         const PlaneAxes& axes);
// A box of a usual size with this middle, or as near as the axes let it.
LookRegion region_around(const PlanePoint& middle, const PlaneAxes& axes);

// A colour that differs from those of the regions that are there.
Rgb color_for_region(std::span<const LookRegion> regions);

// The box over the boundary that the most of what was counted belongs to: where the gradients are
// steep and often. In the colour that the look has there. Without a histogram, or with one that has
// no steep places, over the upper half of the values.
LookRegion first_region(const cli::Histogram2D* histogram, const TransferFunction& look,
                        const PlaneAxes& axes);

// Round numbers between two, rising, at most one more than so many.
std::vector<double> round_numbers(double lo, double hi, int most);

}  // namespace ovoid::viewer
