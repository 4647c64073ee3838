// SPDX-License-Identifier: Apache-2.0
// How far apart the sheets of a kernel field should be, from sums that parts of the field add up
// to: whoever draws a field in parts has one distance, whatever the parts.
#pragma once

#include <array>
#include <optional>

#include "ovoid/kernel_field.h"

namespace ovoid::mappers {

// Of kernels: their number, the logarithms of their sizes (the geometric means of their sigmas),
// their areas (the products of the two greater sigmas), and, weighted by area, the logarithms of
// their least sigmas and the squares of these.
using KernelSums = std::array<double, 5>;

// Of the kernels whose centres lie in `owned`, lower sides included; none: of all. Throws what the
// field's source throws.
KernelSums kernel_sums(const KernelField& field, const std::optional<Bounds3>& owned);

// About KernelField::refined_sampling_distance(), whose quantiles are here those of the normal
// distributions of the logarithms. 0 without kernels.
double sheet_distance_of(const KernelSums& sums);

}  // namespace ovoid::mappers
