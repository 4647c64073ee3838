// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace ovoid::data {

// The number of a type that is nearest: integers rounded, and cut to the type's range.
template <class T>
T stored_number(double number) {
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(number);
  } else {
    // 2^63 and 2^64 are doubles, the greatest integers below them are not.
    if (!(number > static_cast<double>(std::numeric_limits<T>::lowest())))
      return std::numeric_limits<T>::lowest();
    if (number >= std::ldexp(1.0, std::numeric_limits<T>::digits))
      return std::numeric_limits<T>::max();
    return static_cast<T>(std::clamp(std::nearbyint(number),
                                     static_cast<double>(std::numeric_limits<T>::lowest()),
                                     static_cast<double>(std::numeric_limits<T>::max())));
  }
}

}  // namespace ovoid::data
