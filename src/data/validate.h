// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/field.h"

namespace ovoid::data {

// Throws Error(kInvalidArgument) that names the member of LatticeKernel, its value and its range.
void validate_kernel(const LatticeKernel& kernel);

// Throws Error(kInvalidArgument) unless every dimension is at least 1, their product is at most
// kMaxSamples, and world_from_index is finite with axis vectors that have a length and are not
// (nearly) in one plane.
void validate_geometry(const LatticeGeometry& geometry);

// Throws Error(kInvalidArgument) for an empty field. For every public function that takes one.
void require_field(const Field& field);

// 2^48 samples: far beyond any memory, and byte counts of any scalar type stay within 64 bits.
inline constexpr std::int64_t kMaxSamples = std::int64_t{1} << 48;

// Least volume of the parallelepiped of the axis vectors, relative to the box with the same edges,
// that counts as three-dimensional; below, the inverse of world_from_index has lost about ten of
// its sixteen digits.
inline constexpr double kMinRelativeVolume = 1e-6;

}  // namespace ovoid::data
