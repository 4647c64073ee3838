// SPDX-License-Identifier: Apache-2.0
// The default look of labels.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ovoid/look.h"
#include "view/look/field_samples.h"

namespace ovoid::view {

// The cpu's table (LookTable) has twice as many cells, so that each band of colour has one to
// itself.
inline constexpr int kMostLabelBands = 2000;

// Where the table has too few cells for clear gaps between bands, what shows is less than opaque
// over the way from one label to another (label_look.cpp).
inline constexpr double kLabelOpacityWithoutGaps = 0.5;

// More colours than these nobody tells apart by name: then each label's colour is its own,
// whichever others there are.
inline constexpr std::size_t kFewLabels = 64;
Rgb color_of_rank(std::size_t i);  // of the i-th label that is shown, of few
Rgb color_of_label(int label);     // a part of the data, or another step, has the same

// A label as its look shows it.
struct LabelColor {
  int label = 0;
  Rgb color;
  double opacity = 1;  // 0: transparent
};

// Each label holds from half-way to its neighbours. `labels`: rising, at least one.
TransferFunction label_function(std::span<const LabelColor> labels);

// The background, 0 or what the faces show, is transparent. `labels`: rising, at least one.
Look label_look(const std::vector<int>& labels, const FieldSamples& samples);

}  // namespace ovoid::view
