// SPDX-License-Identifier: Apache-2.0
#include "model/lattice/even_steps.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "ovoid/error.h"

namespace ovoid::model {

void require_even_steps(const Series& series) {
  constexpr double kEven = 1e-3;  // of the distance, for rounding
  const std::vector<double>& times = series.times();
  const double distance = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (std::abs(times[i] - times[i - 1] - distance) <= kEven * distance) continue;
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: step {} comes {:g} behind the one before, others {:g}: as a "
                            "lattice in space and time, steps must be even",
                            series.source().name(), i, times[i] - times[i - 1], distance));
  }
}

}  // namespace ovoid::model
