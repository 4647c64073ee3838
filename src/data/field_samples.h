// SPDX-License-Identifier: Apache-2.0
// A few hundred thousand samples of a lattice, spread evenly: enough for quantiles that a person
// can rely on, few enough to cost a moment whatever the lattice's size. And whether samples are
// labels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ovoid/field.h"

namespace ovoid::data {

// Values as the field has them (scaled), missing ones left out. The same field gives the same
// samples.
struct FieldSamples {
  std::vector<float> values;    // rising
  std::vector<float> on_faces;  // rising: the part of them that lies on the lattice's outer faces
  double share_of_equals = 0;   // of neighbours along x that exist: those with the same value
  double share_of_jumps = 0;    // of the others: those that differ by more than 1
  bool is_counted = false;      // stored as whole numbers, as scanners do
};

// At most about kWantedSamples of the lattice's and as many of its faces'. Cost: some ten
// milliseconds. Throws what the source throws.
inline constexpr std::int64_t kWantedSamples = std::int64_t{1} << 18;
FieldSamples take_samples(const BrickSource& source);

// The different values of samples that look like labels: three to 64 integers as above, in regions:
// of neighbours along x at least four of five are equal, and of the others some differ by more than
// 1, as those of a rounded field do not. (Two are a mask, which has an inside and no order that
// could mislead.) Or more integers, up to 2^24, if outside the background two of five neighbours
// are equal, and the others change at once from one flat stretch to the next, as scans do not. Else
// empty. Cost: a pass that ends at the first sample that is no integer, or one too many; for a few
// labels that of take_samples(), too, for many two passes.
std::vector<int> labels_of(const BrickSource& source);
// The same from what was looked at: integers, and rows or samples.
class SampleSurvey;
std::vector<int> labels_told_by(const SampleSurvey& survey, const BrickSource& source);

// The value below which a share `q` in [0, 1] of the rising values lies. `sorted` is not empty.
double quantile(std::span<const float> sorted, double q);

}  // namespace ovoid::data
