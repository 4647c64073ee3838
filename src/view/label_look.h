// SPDX-License-Identifier: Apache-2.0
// The default look of labels.
#pragma once

#include <vector>

#include "ovoid/look.h"
#include "view/field_samples.h"

namespace ovoid::view {

// The cpu's table (LookTable) has twice as many cells, so that each band of colour has one to
// itself.
inline constexpr int kMostLabelBands = 2000;

// Where the table has too few cells for clear gaps between bands, what shows is less than opaque
// over the way from one label to another (label_look.cpp).
inline constexpr double kLabelOpacityWithoutGaps = 0.5;

// Each label holds from half-way to its neighbours; the background, 0 or what the faces show, is
// transparent.
// `labels`: rising, at least one.
Look label_look(const std::vector<int>& labels, const FieldSamples& samples);

}  // namespace ovoid::view
