// SPDX-License-Identifier: Apache-2.0
// The last part of a fit: kernels' centres, shapes and weights, with their values, by least
// squares.
#pragma once

#include <functional>
#include <stop_token>
#include <vector>

#include "fit/clusters.h"
#include "fit/fit_places.h"

namespace ovoid::fit {

struct RefineProblem {
  const Places& places;
  std::vector<double> ranges;  // of each attribute whose values are fitted, from the first on
  Reconstruction reconstruction = Reconstruction::kNormalized;
  double cutoff = 4;
  KernelShape shape = KernelShape::kEllipsoids;
  int steps = 0;  // at most
  // What a place counts that no kernel reaches, as a mean square in units of the ranges.
  double square_of_hole = 1;
  int threads = 1;
  std::stop_token stop{};
  std::function<void()> step_done{};
};

// Moves kernels by Gauss-Newton steps towards the least sum of squares over places, of all
// attributes in units of their ranges. Balls stay balls; kernels of a sum keep the integral of them
// all. `values`: of each attribute [n]. Places are in random order: the last of them stay out
// of the fit, and a step that does not lessen the error there is shortened, or is the end. Throws
// Error(kCancelled). docs/numerics.md, "Fitted kernels".
void refine_kernels(const RefineProblem& problem, MergedKernels& kernels,
                    std::vector<std::vector<double>>& values);

}  // namespace ovoid::fit
