// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>

#include "ovoid/kernel_field.h"

namespace ovoid::data {

// Runs `body(brick, view, i)` for every `stride`-th kernel, counted from the first brick on. Throws
// what the source throws.
template <class Body>
void for_every_kernel(const KernelSource& source, std::int64_t stride, const Body& body) {
  const std::shared_ptr<const KernelSource> alone = stride > 1 ? source.every(stride) : nullptr;
  if (alone) {
    for_every_kernel(*alone, 1, body);
    return;
  }
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

// Which makes about `most` kernels (under twice as many), or all if they are fewer.
inline std::int64_t stride_for(std::int64_t num_kernels, std::int64_t most) {
  return std::max<std::int64_t>(1, num_kernels / most);
}

// Of so many.
template <class Body>
void for_some_kernels(const KernelSource& source, std::int64_t most, const Body& body) {
  for_every_kernel(source, stride_for(source.num_kernels(), most), body);
}

}  // namespace ovoid::data
