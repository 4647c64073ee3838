// SPDX-License-Identifier: Apache-2.0
// Adam [Kingma 2015] in the place of a fit's Gauss-Newton steps: from the same clusters, by errors
// at the same places, over the same numbers of each kernel.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ovoid/dataset.h"

namespace ovoid::experiments {

// One way to refine, and where it came to.
struct RefineCurve {
  struct Point {
    int steps = 0;
    double seconds = 0;  // of the steps alone
    double psnr = 0;     // dB, at places that no step saw
  };
  std::string way;
  std::vector<Point> points;  // by rising steps
};

struct AdamWay {
  // A step sees one of so many equal parts of the places, each in turn.
  int parts = 1;
  int steps = 100;  // in all, during which the rate falls to a hundredth
  // Sigmas, logarithms or shares of the range that a step moves a number by, about, at first.
  double rate = 0.02;
};

struct RefineOptions {
  std::int64_t kernels = 1000;
  int gauss_newton_steps = 8;  // of which `ovoid fit` takes 4
  std::vector<AdamWay> adam = {{1, 100, 0.02}, {8, 400, 0.02}, {8, 400, 0.06}};
};

struct RefineComparison {
  std::int64_t kernels = 0;
  std::size_t places = 0;
  double start = 0;  // dB, before any step
  std::vector<RefineCurve> curves;
};

// Of data whose field is normalized. Throws what fit_kernels() throws.
RefineComparison compare_refinement(const Dataset& dataset, const RefineOptions& options);

}  // namespace ovoid::experiments
