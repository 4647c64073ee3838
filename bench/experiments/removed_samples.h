// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "experiments/fields.h"

namespace ovoid::experiments {

// A way to make a field of samples of one spacing.
struct FieldWay {
  std::string name;
  std::function<PointField(const Dataset&)> make;
};

// Trilinear interpolation, kernels with and without prefilter, and B-splines whose values are held
// to the range of the 2^3 or 4^3 samples around a place.
std::vector<FieldWay> field_ways();

// Every second sample along each axis is kept, and the field of these is compared with the removed
// ones: 20 log10(range / rms error). `band_limited`: the samples are limited to half their band
// first, so that those that are kept have all that is in the others.
struct RemovedErrors {
  std::vector<double> as_they_are;   // dB, of each way
  std::vector<double> band_limited;  // likewise
};
RemovedErrors measure_removed(const Dataset& dataset, const std::vector<FieldWay>& ways,
                              int num_places);

}  // namespace ovoid::experiments
