// SPDX-License-Identifier: Apache-2.0
// Numbers that every test may want, where tests of all parts see them.
#pragma once

#include <limits>

namespace ovoid {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();
inline constexpr float kInfinityF = std::numeric_limits<float>::infinity();

}  // namespace ovoid
