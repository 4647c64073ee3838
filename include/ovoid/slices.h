// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/series.h"

namespace ovoid {

// Over which kernels a time slice of a staggered series (D4*) is taken; others have one way.
enum class TimeFilter : std::uint8_t {
  kTwoSteps,  // of each half its two steps around the time, weighted by a Gaussian less what it has
              // at the next step, so that nothing jumps where a step comes in
  kGaussian,  // of each half all steps that the kernel reaches along time, as published
  kExact,     // all kernels of the four-dimensional lattice, both halves for every sample
};

// A step of a series and its share in a time slice.
struct StepWeight {
  std::int64_t step;
  double weight;
};

// The shares of the steps at `time`. Steps: those before and behind it, linearly, or the one that
// it is at. Staggered: of the half `half` (0: even steps, 1: odd ones); a time before its first or
// behind its last step is at that. Shares are positive and add up to 1. `times` as Series::times().
// Throws Error(kInvalidArgument) for a time that is not finite or lies outside of all steps' times.
// Source: [Neophytou 2006, section 2.3].
std::vector<StepWeight> weights_of_steps(const std::vector<double>& times, double time);
std::vector<StepWeight> weights_of_half(const std::vector<double>& times, int half, double time,
                                        TimeFilter filter = TimeFilter::kTwoSteps);

struct TimeSliceOptions {
  TimeFilter filter = TimeFilter::kTwoSteps;
  int threads = 0;  // 0: one per hardware thread
  std::stop_token stop;
};

// The series at a time: a step as it is where it is at one, else a dataset made of several.
// Lattices: arrays of values, float32, NaN where one that has a share is; staggered series become
// body-centred lattices. Meshes whose cells stay, and particles whose numbers ("id" and the like)
// stay, move linearly with their arrays; others do not: the nearest step is taken, and a note says
// why. Throws what Series::step and weights_of_steps throw; kOutOfMemory. Cost: reading the steps
// that are not held, a pass over them.
Dataset slice_at_time(const Series& series, double time, const TimeSliceOptions& options = {});

}  // namespace ovoid
