// SPDX-License-Identifier: Apache-2.0
// What of a 2-D transfer function can be said by value alone, and how much it varies: the first
// decides what is skipped, the second in how many steps a piece is drawn.
#pragma once

#include <optional>
#include <vector>

#include "ovoid/look.h"
#include "view/look/look_table.h"

namespace ovoid::view {

// At each value the greatest opacity that any gradient has there, with the colour it has; the unit
// distance is `of`'s. So what has no opacity here shows nothing, whatever its gradient.
TransferFunction envelope_of(const TransferFunction2D& function, const TransferFunction& of);

// The look with the envelope for its transfer function, if it has a 2-D one.
Look with_envelope(Look look);

// How much a look changes between two places of the plane: at most the difference of by_value, as
// look_variation() has it, plus that of by_gradient.
struct Variation2D {
  std::vector<float> by_value;     // [LookTable::kPaddedEntries], of the envelope's table
  std::vector<float> by_gradient;  // [gradients().count], at the function's own entries
};

// `envelope`: the table of envelope_of(). Cost: a few milliseconds for 1024 x 128 entries.
Variation2D variation_of(const TransferFunction2D& function, const LookTable& envelope,
                         double path_in_units);

// Between two entries straight, beyond them as at the ends.
double variation_at(const std::vector<float>& by_gradient,
                    const TransferFunction2D::Axis& gradients, double gradient);

}  // namespace ovoid::view
