// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "ovoid/kernel_field.h"

namespace ovoid::data {

// Runs `body(brick, view, i)` for about `most` kernels (under twice as many), or all if they are
// fewer, spread evenly over the bricks: every so many-th. Throws what the source throws.
template <class Body>
void for_some_kernels(const KernelSource& source, std::int64_t most, const Body& body) {
  const std::int64_t stride = std::max<std::int64_t>(1, source.num_kernels() / most);
  std::int64_t next = 0;  // in the brick at hand
  for (std::int64_t b = 0; b < source.num_bricks(); ++b) {
    const KernelBrick& brick = source.brick(b);
    if (next < brick.count) {
      const KernelView view = source.acquire(b, 0.0);
      for (; next < brick.count; next += stride) body(brick, view, static_cast<std::int32_t>(next));
    }
    next -= brick.count;
  }
}

}  // namespace ovoid::data
