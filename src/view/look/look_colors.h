// SPDX-License-Identifier: Apache-2.0
// Colours and light of the default look.
#pragma once

#include <span>

#include "ovoid/look.h"

namespace ovoid::view {

// Of what scanners see: clay that turns to ivory where it is dense. As bodies, wood and castings
// are, and whatever else there is, it looks like a thing. `materials`: rising; values between which
// the colours are to differ, by 15 in CIEDE2000 as long as there are no more than three. Those that
// the colours do not span are passed over.
void set_body_colors(Look& look, double lo, double hi, std::span<const double> materials = {});

// Light colours all along, since light and shade need room below them, at the warm end above all,
// which is the most opaque: what surrounds is cool, what is dense is warm. A lit surface keeps
// about six tenths of its colour on the mean, so none has a luminance below one half.
// `materials`: as above, but up to five.
void set_bright_colors(Look& look, double lo, double hi, std::span<const double> materials = {});

// Of clouds, which have no surface that light could show: they glow, from dusk to white. Half of a
// cloud's picture is seen through, so that colours are as bright as they may be and still differ.
void set_glowing_colors(Look& look, double lo, double hi);

// Vessels, from coral to cream, in pale tissue.
void set_vessel_colors(Look& look, double tissue, double wall, double bright);

// Of two sides of zero: cool below, warm above.
void set_two_sided_colors(Look& look, double lo, double hi);

// A key light and a fill, on light colours. Below a rise of `noise` (values) over a spacing normals
// tell nothing; that is taken for at most 6 % of the colours' span, or, the softer the look is (0
// to 1), for up to all of it.
void set_light(Look& look, double noise = 0, double softness = 0);

}  // namespace ovoid::view
