// SPDX-License-Identifier: Apache-2.0
// Ways from one colour to another: what vtkColorTransferFunction does between two of its points.
#pragma once

#include "ovoid/transfer_function.h"

namespace ovoid::view {

// The colour at `s` in [0, 1] of the way from `a` to `b`, sRGB components in [0, 1], in and out.
// Lab and Diverging go through the four-digit matrices of the sRGB standard both ways, as VTK does,
// so that even s = 0 returns `a` only to 3e-3. Sources: [Moreland 2009] for Diverging, IEC
// 61966-2-1 for sRGB, CIE 15 for L*a*b* (D65).
Rgb interpolate(ColorSpace space, const Rgb& a, const Rgb& b, double s);

// L*a*b* of an sRGB colour and back; `rgb_from_lab` brings colours outside the gamut into it (too
// bright: all components are divided by the greatest; negative: 0).
Rgb lab_from_rgb(const Rgb& rgb);
Rgb rgb_from_lab(const Rgb& lab);

// Hue, saturation, value, each in [0, 1]; a gray has hue 0.
Rgb hsv_from_rgb(const Rgb& rgb);
Rgb rgb_from_hsv(const Rgb& hsv);

}  // namespace ovoid::view
