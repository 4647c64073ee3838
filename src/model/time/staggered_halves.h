// SPDX-License-Identifier: Apache-2.0
// The two halves of a lattice in space and time of the kind D4*: what each has at a time, and what
// makes one volume of them.
#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <stop_token>
#include <vector>

#include "model/time/step_blend.h"
#include "ovoid/slices.h"

namespace ovoid::model {

// The kernel over space and time along one axis, `distance` in units of T.
double kernel_along_axis(double distance);
inline constexpr double kKernelSupport = 2;                 // T
inline constexpr double kOwnSpacing = std::numbers::sqrt2;  // of a half's samples and steps, T

// Weights of a half's steps within `reach`, T, by the kernel less `floor`; not divided by their
// sum.
std::vector<StepWeight> kernel_weights_of_half(const std::vector<double>& times, int half,
                                               double time, double reach, double floor);

// By the cubic through four steps of the half [Keys 1981]; add up to 1, outer ones are negative.
// Before its first and behind its last step the half goes on in a straight line.
std::vector<StepWeight> cubic_weights_of_half(const std::vector<double>& times, int half,
                                              double time);

// What TimeFilter::kFourSteps takes for the part that moves: the cubic through four steps less the
// mean over two periods, the time from one step of the half to its next. Adds up to 0.
std::vector<StepWeight> moving_weights_of_half(const std::vector<double>& times, int half,
                                               double time);

struct HalvesOptions {
  int threads = 0;
  std::stop_token stop{};
};

// Takes out of a volume what alternates from half to half and moves. `moving`: of each half, its
// samples by moving_weights_of_half(); what is missing there counts nothing. `volume`: the layers
// of both in turn. `dims`: of a half. Why: docs/time.md, "Between steps".
void take_out_alternation(std::array<Floats, 2> moving, const Index3& dims, int components,
                          const HalvesOptions& options, float* volume);

}  // namespace ovoid::model
