// SPDX-License-Identifier: Apache-2.0
// Samples of any field, for a look.
#pragma once

#include <span>

#include "data/field_samples.h"
#include "ovoid/field.h"

namespace ovoid::view {

using data::FieldSamples;
using data::quantile;

// Of a lattice: data::take_samples() of its samples. Of a kernel set: the kernels' own values, the
// more often the larger they are (by the root of the volume: between what space shows and what the
// data are about); where kernels are summed, the field at the centres of some thousands. No faces.
FieldSamples take_samples(const KernelField& field);

}  // namespace ovoid::view
