// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "ovoid/render_options.h"

namespace ovoid::reference {

// Six coarse samples along one axis that may have weight at a place between them.
struct FilterTaps {
  std::int64_t first;              // number of the first of them
  std::array<double, 6> weight{};  // adds up to 1
};

// `place` in numbers of coarse samples. `how` is a published way.
FilterTaps taps_at(PostConvolution how, double place);

}  // namespace ovoid::reference
