// SPDX-License-Identifier: Apache-2.0
// Particles at one place. The sum of kernels of one place and shape is a kernel, so that a heap of
// them is drawn as one: the same field, at the cost of one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/particles/kernel_parts.h"

namespace ovoid::model {

// Where `least` or more of the `candidates` (indices of kernels whose shape follows from their
// place alone) lie at exactly one place, the first of them becomes the sum of all: of their weight,
// with the mean of their values by weight, and of colours by what they weigh in the field. The
// others go. parts.ranges keeps their values. Shapes and weights may still be missing. Returns how
// many went. Cost: a sort of the candidates.
std::int64_t merge_heaps(std::vector<std::uint32_t> candidates, std::size_t least,
                         KernelParts& parts);

}  // namespace ovoid::model
