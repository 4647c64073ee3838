// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "ovoid/dataset.h"
#include "ovoid/math.h"

namespace ovoid::model {

// Value at a position of the cube [-1, 1]^3. Called from many threads.
using Formula = std::function<double(const Vec3& position)>;

// Sample data by formula: a function on the cube [-1, 1]^3, whatever the number of samples.
struct SampleKind {
  const char* name;
  const char* description;    // a line for the help text, without the size
  std::int64_t default_size;  // samples per axis
  double lo;  // the formula's values lie in [lo, hi]; integer types are scaled from it
  double hi;
  const char* unit;
  Space space;
  Formula (*make)(std::uint64_t seed, double time);  // time in [0, 1], for those that move
  bool moves = false;
  // The second of two numbers in each sample, as of a second channel; null: there is one.
  Formula (*make_second)(std::uint64_t seed, double time) = nullptr;
};

std::span<const SampleKind> sample_kinds() noexcept;

// A head as a CT scanner sees it: skin, fat, muscle, skull, jaw with teeth, spine, brain and
// airways, in Hounsfield units, -1000 (air) to 1500 (teeth). Patient axes LPS: x to the left, y to
// the back, z up. `seed` chooses the texture.
Formula make_head(std::uint64_t seed, double time);
// The same head's parts as labels: 1 skin and all that is under it, 2 skull and jaw, 3 spine, 4
// teeth, 5 brain, 6 fluid, 7 eyes, 8 airways; 0 outside.
Formula make_head_labels(std::uint64_t seed, double time);

// A cluster of cells with two fluorescent stains: what is in their nuclei, and in the membranes
// between them. `seed` chooses the cells.
Formula make_nuclei(std::uint64_t seed, double time);
Formula make_membranes(std::uint64_t seed, double time);

}  // namespace ovoid::model
