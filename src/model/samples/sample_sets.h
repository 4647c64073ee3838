// SPDX-License-Identifier: Apache-2.0
// Sample data that are no lattices: a mesh, particles, stored kernels.
#pragma once

#include <cstdint>
#include <span>

#include "ovoid/dataset.h"

namespace ovoid::model {

struct SampleSet {
  const char* name;
  const char* description;  // a line for the help text, without the count
  std::int64_t default_count;
  std::int64_t least_count;
  const char* noun;  // what is counted
  Dataset (*make)(std::int64_t count, std::uint64_t seed);
};

std::span<const SampleSet> sample_sets() noexcept;

// A flow around a blunt fin on a plate: `count` nodes, nearly, of a C-shaped grid that is cut into
// tetrahedra, six per box, with nodes shaken by a tenth of their spacing. Float64 positions, arrays
// "density" and "pressure".
Dataset make_fin(std::int64_t count, std::uint64_t seed);
inline constexpr std::int64_t kLeastFinNodes = 27;

}  // namespace ovoid::model
