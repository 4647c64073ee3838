// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <stop_token>
#include <vector>

#include "data/lattice/relevant_runs.h"
#include "ovoid/dataset.h"

namespace ovoid::data {

struct ReachOptions {
  double reach = 2.0;  // support radius of the kernels, index units
  int threads = 0;
  std::stop_token stop{};
};

// A copy of the samples, of a type that a BrickView can show, in which all that no kernel brings to
// a brick (4 cells per axis) with a relevant value in its bounds, or to a place up to 1 index unit
// beside it, have the stored number `background`. Throws Error: kUnsupported for other types,
// kCancelled.
std::vector<std::byte> keep_in_reach(const LatticeGeometry& geometry, ScalarType type,
                                     const Bytes& samples, const RelevantValues& relevant,
                                     double background, const ReachOptions& options);

}  // namespace ovoid::data
