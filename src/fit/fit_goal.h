// SPDX-License-Identifier: Apache-2.0
// What fits of every kind share: their goal, and how they refuse.
#pragma once

#include <string>

#include "ovoid/fit.h"

namespace ovoid::fit {

// Throws Error(kInvalidArgument).
[[noreturn]] void refuse_fit(const std::string& message);

// 20 log10(range / rms), dB; infinite for no error.
double psnr_of(double range, double mean_square);

// Refuses unless there is exactly one goal, and a possible one.
void check_goal(const FitOptions& options);

}  // namespace ovoid::fit
