// SPDX-License-Identifier: Apache-2.0
// Marks that help to read a picture: colour bar, axes, bounding box, scale bar. They are drawn into
// a finished image, anti-aliased, in a stroke font of the library's own, and scale with the
// picture: the same image gives the same bytes on every machine. Each function takes an image with
// a consistent size (else Error(kInvalidArgument)), leaves its depth alone, and clips what does not
// fit. An x-ray's integrals must have been mapped to colours before. Text is UTF-8: ASCII and the
// signs of units (micro, degree, powers, Angstrom); other characters are drawn as boxes. Cost: in
// proportion to the pixels drawn. Safe from several threads on different images.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/camera.h"
#include "ovoid/crop.h"
#include "ovoid/dataset.h"
#include "ovoid/export.h"
#include "ovoid/image.h"
#include "ovoid/look.h"

namespace OVOID_API ovoid {

// Colours and size of text and lines. Around them lies a halo of the other brightness, so that they
// can be read over the volume and over backgrounds not known yet.
struct MarkStyle {
  Rgb ink{1.0, 1.0, 1.0};
  Rgb halo{0.06, 0.07, 0.09};
  double halo_opacity = 0.85;  // in [0, 1]
  double halo_size = 0.2;      // how far it reaches, in lines of text; 0 to 1
  double text_px = 0;          // height of a line of text, pixels; 0: 1/42 of the picture's shorter
                               // side, but at least 10, and at most 1/12 of that side
};

// Light ink for a dark background, dark ink for a light one (r, g, b in [0, 1]), with a narrow
// halo; none, a background not known yet: light ink with the wide, dark halo of the default.
MarkStyle mark_style_on(const std::optional<Rgb>& background);

// The colour of a thick, homogeneous box of one value: the transfer function's, times ambient +
// diffuse where the look shades (a flat field is lit so; docs/numerics.md, "Light").
Rgb shown_color(const Look& look, double value);

// A value that stands for itself, such as a label of a segmentation.
struct ColorBarEntry {
  double value = 0;
  std::string name;
};

// The labels of a look for them as default_look() makes it: one colour for each whole number, from
// half-way to the one before to half-way to the next. Those without opacity are left out. Empty for
// any other transfer function.
std::vector<ColorBarEntry> label_entries(const TransferFunction& transfer_function);

struct ColorBar {
  std::string title;                               // the array's name; may be empty
  std::string unit;                                // of the values; may be empty
  std::optional<std::pair<double, double>> range;  // lo <= hi; none: the transfer function's span
  std::vector<ColorBarEntry> entries;  // if not empty: a list of swatches instead of a ramp
};

// Half open rectangle of pixels.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

// At the right border: shown_color() over the range, ticks at round values (powers of ten where
// the transfer function's scale is logarithmic), the range's ends, title and unit. Beside it the
// opacity curve, if the mode uses one and it is not 1 throughout, scaled to its greatest value,
// which is written under it; for an isosurface a mark at its value. Colours below and above the
// range are shown as pointed ends. Returns the ramp's pixels, lowest value at the bottom, or those
// around all swatches. Throws Error(kInvalidArgument) for a range that is not finite or not lo <=
// hi.
PixelBox draw_color_bar(Image& image, const Look& look, const ColorBar& bar,
                        const MarkStyle& style = {});

// The value whose colour the pixels of row `y` of the ramp have.
double color_bar_value(const Look& look, const ColorBar& bar, const PixelBox& ramp, int y);

// In the lower left corner: the directions of the world's axes as they lie at the focal point,
// those towards the eye drawn last; an axis along the view is a ring with a dot (it points at the
// eye) or a cross (away). Named x, y, z, or by patient direction at both ends: L and R, P and A, S
// and I (LPS and RAS), so that a wrong orientation is seen.
void draw_axes(Image& image, const Camera& camera, Space space, const MarkStyle& style = {});

// The edges of a box around the volume. Those behind it are seen through it as far as its pixels
// are transparent. Labels at the outline: where the box's axes are parallel to the world's, the
// coordinates of its ends and the axis' name; else the lengths along i, j and k. `unit`: of
// lengths, may be empty.
void draw_bounding_box(Image& image, const Camera& camera, const Box& box,
                       const std::string& unit = {}, const MarkStyle& style = {});

// In the lower right corner: a round length (1, 2 or 5 times a power of ten) of about a sixth of
// the picture's width, true at the focal plane: with perspective nearer things are larger.
void draw_scale_bar(Image& image, const Camera& camera, const std::string& unit = {},
                    const MarkStyle& style = {});

}  // namespace ovoid
