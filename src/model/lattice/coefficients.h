// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "model/lattice/convert.h"
#include "model/lattice/prefilter.h"

namespace ovoid::model {

// True for whole numbers of so few levels that 16 bits resolve their coefficients to a quarter of
// one: samples of 8 bits, and others within 4096 levels. `range`: of their values.
bool have_few_levels(const ScalarSamples& samples, const ValueRange& range);

// What prefilter() makes of Cartesian samples of few levels, rounded to 16 bits: the values of what
// is returned are the coefficients, to 3e-5 of the range, or 8e-6 of the coefficients' own range
// where that is more than four times the samples'. No volume of floats is held: slices go through a
// window of some 50. Errors and cost as of prefilter(); twice the time where coefficients reach
// beyond four times the range. Does not depend on the number of threads.
ScalarSamples make_coefficients(const ScalarSamples& samples, const Index3& dims,
                                const PrefilterOptions& options);

}  // namespace ovoid::model
