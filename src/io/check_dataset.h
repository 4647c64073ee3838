// SPDX-License-Identifier: Apache-2.0
// What everything that was read goes through before anything indexes it, whoever has read it.
#pragma once

#include "ovoid/dataset.h"

namespace ovoid::io {

// Throws Error(kFileFormat), whose message says what contradicts itself and names no file, unless
// - the step that was read is one of the steps, of which there is at least one;
// - there is a time for every step, or none; those of a staggered series lie at equal distances;
// - a lattice has samples along every axis, axes that span space, and at least one array;
// - points have three floating-point coordinates each, boxes a size for each;
// - every array has a tuple for each sample, point or cell, bytes for all of them or samples that
//   stay in their file, and a finite scale that is not 0.
// The numbers in the arrays are not looked at. Cost: by the number of arrays and steps.
void check_dataset(const Dataset& dataset);

}  // namespace ovoid::io
