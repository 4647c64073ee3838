// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace ovoid::model {

// The sites [n, 3] (finite) in the order of a Morton curve through their bounding cube: what is
// near in the list is near in space. Equal places keep their order.
std::vector<std::uint32_t> morton_order(std::span<const double> sites, int threads);

}  // namespace ovoid::model
