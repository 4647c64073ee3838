// SPDX-License-Identifier: Apache-2.0
// The default look of labels.
#pragma once

#include <vector>

#include "ovoid/look.h"
#include "view/field_samples.h"

namespace ovoid::view {

// Each label holds from half-way to its neighbours; the background, 0 or what the faces show, is
// transparent.
// `labels`: rising, at least one.
Look label_look(const std::vector<int>& labels, const FieldSamples& samples);

}  // namespace ovoid::view
