// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "ovoid/export.h"

namespace OVOID_API ovoid {

using Rgb =
    std::array<double, 3>;  // sRGB-encoded components in [0, 1]; blended as they are, as VTK does

// How colours between two points are found, as vtkColorTransferFunction does (docs/looks.md).
enum class ColorSpace {
  kRgb,        // straight lines in sRGB components
  kHsv,        // hue, saturation, value; the hue never passes 0 (ParaView's HSV: blue to red is a
               // rainbow)
  kLab,        // CIE L*a*b*
  kDiverging,  // Moreland's: two saturated colours of different hue meet in white
  kStep,       // the interval's second colour throughout
  kHsvWrap,    // as kHsv, but the hue takes the shorter way round the circle (ParaView's HSVWrap)
};

struct ColorPoint {
  double x = 0;  // value
  Rgb rgb{0, 0, 0};
};

// A node of the opacity curve. Between two nodes the left one's midpoint and sharpness shape the
// curve, as in vtkPiecewiseFunction: midpoint in [0, 1] moves the half-way value, sharpness in [0,
// 1] goes from linear to a step.
struct OpacityPoint {
  double x = 0;        // value
  double opacity = 0;  // in [0, 1], per unit distance
  double midpoint = 0.5;
  double sharpness = 0;
};

// Along what the curves between two points run: the value itself, its logarithm, or a symmetric
// logarithm that is straight around zero: sign(x) log10(1 + |x| / linear_width).
enum class ValueScale { kLinear, kLog, kSymlog };

// Colour and opacity by value: the content of a ParaView JSON preset. Points are sorted by x; equal
// x is a step, the later point holding from there on. End values extend. An empty curve is a gray
// ramp over [0, 1], straight in the value, or opacity 1. Under kLog all x must be > 0; values <= 0
// lie below every point.
struct TransferFunction {
  std::string name;
  std::vector<ColorPoint> colors;
  std::vector<OpacityPoint> opacities;
  ColorSpace color_space = ColorSpace::kRgb;
  ValueScale scale = ValueScale::kLinear;
  double linear_width = 1.0;       // of kSymlog, > 0, in values
  std::optional<Rgb> below_color;  // of values less than the first colour point's; none: its colour
  std::optional<Rgb> above_color;  // of values greater than the last one's
  Rgb nan_color{1, 1, 0};
  // Factor on the opacity by the length of the gradient (value per world length); empty: 1.
  std::vector<OpacityPoint> gradient_opacities;
  std::optional<double> unit_distance;  // world length over which `opacity` is meant; the file's
                                        // ScalarOpacityUnitDistance

  Rgb color_at(double value) const;       // exact evaluation, in double; nan_color at NaN
  double opacity_at(double value) const;  // exact evaluation, in double; 0 at NaN

  double lo() const;  // least x of all points; 0 if there is none
  double hi() const;  // greatest x; 1 if there is no point
  // Moves all points of colour and opacity so that the span becomes [lo, hi]; what lay at a
  // fraction of the way along the scale stays there (geometric means keep their place under kLog).
  // An empty colour curve's gray ramp becomes points and moves along, a single place goes to the
  // middle. Throws Error(kInvalidArgument) unless lo < hi, both finite, and > 0 under kLog.
  void map_range(double lo, double hi);
  // As above, onto another scale: what lay half way along the old one lies half way along the new
  // one, so that a colour map spreads over the decades of [lo, hi].
  void map_range(double lo, double hi, ValueScale new_scale, double new_linear_width = 1.0);
  void sort();  // stable, by x; called by readers
};

// Colours for categories: points such that every value has the colour of the nearest of `values`
// (half way: the lower's), colours[i % colors.size()] for values[i]. Values are sorted; of equal
// ones the last counts. ColorSpace::kStep, no opacities. Throws Error(kInvalidArgument) if either
// is empty or a value is not finite.
TransferFunction categorical(const std::vector<double>& values, const std::vector<Rgb>& colors);

// Replaces the colours of `tf`, whatever its space, by points in ColorSpace::kLab along the ways
// that vtkColorTransferFunction takes in its space Lab/CIEDE2000 [Zeyen 2018]: from each point to
// the next the shortest chain of colours, steps counted by the CIEDE2000 difference [Sharma 2005],
// among the 17 x 17 x 17 colours whose components are multiples of 1/16, to which the points' own
// colours are rounded, too. Evaluation then agrees with VTK's to an 8-bit step, but at the points
// themselves, where VTK has their own colours. At most kMaxCiede2000Points points; cost: about 2 ms
// for each. Throws Error(kUnsupported) for more.
inline constexpr std::size_t kMaxCiede2000Points = 256;
void follow_ciede2000(TransferFunction& tf);

// The built-in colour maps by name ("viridis", "inferno", "gray", "cool-to-warm", ...; "_r"
// reverses), over [0, 1], without opacity points. Throws Error(kInvalidArgument) that lists the
// names.
TransferFunction color_map(const std::string& name);
std::vector<std::string> color_map_names();

}  // namespace ovoid
