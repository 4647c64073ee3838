// SPDX-License-Identifier: Apache-2.0
// Values of kernels at scattered sites: taken as they are, normalized, or fitted; and what a fit
// begins with where its kernels do not lie at the sites.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "experiments/site_shapes.h"

namespace ovoid::experiments {

// A field over a cube of `side` sites a spacing apart.
struct TestField {
  std::string name;
  int side = 0;
  std::function<double(const Vec3&)> value;
};
// Franke's function in space and the Marschner-Lobb signal [Marschner 1994].
TestField franke_field(int side);
TestField marschner_lobb_field(int side);

// Root mean squares of the error at random places inside, over the field's range there.
struct SiteErrors {
  double raw = 0;         // sum of weights times values
  double normalized = 0;  // over the sum of weights: Shepard's way with these kernels
  double fitted_sum = 0;  // the sum, its values by least squares at the sites
  double fitted = 0;      // normalized, likewise
};
SiteErrors measure_site_errors(const TestField& field, SiteShape shape);

// Kernels elsewhere than the sites.
enum class Centers {
  kMoved,   // each site's, by up to half a spacing along every axis
  kMerged,  // one for each eight neighbours, in their middle
};
// How kernels get their first values from the sites'.
enum class FirstValues {
  kMean,        // all the same
  kNormalized,  // the field of kernels at the sites, Shepard's way
  kSibson,      // natural neighbours
};
const char* name_of(Centers centers);
const char* name_of(FirstValues first);

// Rms error at the sites over the range, after 0, 1, 2, ... steps of conjugate gradients, and of
// all those steps the first that is within a tenth of a decibel of the last.
struct Convergence {
  std::vector<double> errors;
  int steps = 0;
};
Convergence measure_convergence(const TestField& field, Centers centers, FirstValues first,
                                int steps);

}  // namespace ovoid::experiments
