// SPDX-License-Identifier: Apache-2.0
// Ovoid's own lattice files in HDF5; docs/formats.md, "Ovoid's HDF5 lattices", is their definition.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "ovoid/dataset.h"

namespace ovoid::io {

inline constexpr const char* kHdf5LatticeFormat = "ovoid-lattice";
inline constexpr std::int64_t kHdf5LatticeVersion = 1;

// No text that is read or written is longer, bytes.
inline constexpr std::size_t kMaxHdf5Text = 4096;

// So much of a step is packed, and has to be unpacked, at once: a few layers.
inline constexpr std::int64_t kChunkBytes = std::int64_t{1} << 20;

// The four words of the attribute `lattice`.
struct Hdf5LatticeWord {
  const char* word;
  LatticeKind kind;
  SeriesKind series;
  bool has_steps;  // told apart for people only
};
inline constexpr std::array<Hdf5LatticeWord, 4> kHdf5LatticeWords{{
    {"cartesian", LatticeKind::kCartesian, SeriesKind::kSteps, false},
    {"body-centred", LatticeKind::kBodyCentred, SeriesKind::kSteps, false},
    {"cc4", LatticeKind::kCartesian, SeriesKind::kSteps, true},
    {"d4star", LatticeKind::kCartesian, SeriesKind::kStaggered, true},
}};

// Samples that levels and boxes may stand for: those whose numbers a float holds.
inline bool are_simple_samples(ScalarType type) {
  return type == ScalarType::kFloat32 || (!is_floating(type) && size_of(type) <= 2);
}

// Steps of staggered times may differ by so much of their mean distance: times of 32-bit floats do.
inline constexpr double kMaxTimeDeviation = 1e-3;

// Are the times of a staggered series those of two halves that lie half-way between each other:
// rising, in equal distances but for kMaxTimeDeviation?
template <class Times>
bool are_staggered_times(const Times& times) {
  if (times.size() < 2) return true;
  const double mean = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  for (std::size_t i = 1; i < times.size(); ++i) {
    const double distance = times[i] - times[i - 1];
    if (!(distance > 0) || !(std::abs(distance - mean) <= kMaxTimeDeviation * mean)) return false;
  }
  return true;
}

}  // namespace ovoid::io
