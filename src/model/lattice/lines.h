// SPDX-License-Identifier: Apache-2.0
// Work on a volume's lines of samples along one axis.
#pragma once

#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "ovoid/lattice.h"

namespace ovoid::model {

struct LineOptions {
  int axis = 0;     // 0, 1 or 2
  int threads = 0;  // 0: one per hardware thread
  std::stop_token stop{};
};

// What makes a line of output samples out of one of input samples; called from many threads. The
// two do not overlap.
using LineTransform = std::function<void(std::span<const float> from, std::span<float> to)>;

// The volume whose lines along the axis are those of `samples` (x fastest), transformed, and have
// `size` samples. Lines across memory are taken some at a time, side by side, so that whole cache
// lines are used. Throws Error(kCancelled); std::bad_alloc.
std::vector<float> transform_lines(std::span<const float> samples, const Index3& dims,
                                   std::int64_t size, const LineTransform& transform,
                                   const LineOptions& options);

}  // namespace ovoid::model
