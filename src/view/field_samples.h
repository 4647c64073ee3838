// SPDX-License-Identifier: Apache-2.0
// A few hundred thousand samples of a field, spread evenly: enough for quantiles that a person can
// rely on, few enough to cost a moment whatever the field's size.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ovoid/field.h"

namespace ovoid::view {

// Values as the field has them (scaled), missing ones left out. The same field gives the same
// samples.
struct FieldSamples {
  std::vector<float> values;    // rising
  std::vector<float> on_faces;  // rising: the part of them that lies on the lattice's outer faces
  double share_of_equals = 0;   // of neighbours along x that exist: those with the same value
};

// At most about kWantedSamples of the lattice's and as many of its faces'. Cost: some ten
// milliseconds. Throws what the field's source throws.
inline constexpr std::int64_t kWantedSamples = std::int64_t{1} << 18;
FieldSamples take_samples(const LatticeField& field);

// The same of the kernels' own values; where kernels are summed, of the field at their centres, of
// which a few thousand do. No faces.
FieldSamples take_samples(const KernelField& field);

// The value below which a share `q` in [0, 1] of the rising values lies. `sorted` is not empty.
double quantile(std::span<const float> sorted, double q);

// The different values of all samples, rising; empty if one is not an integer in [0, 65535] or if
// there are more than `most`. Cost: one pass, which ends at the first sample that does not fit.
std::vector<int> few_integers(const LatticeField& field, std::size_t most);

}  // namespace ovoid::view
