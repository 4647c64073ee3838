// SPDX-License-Identifier: Apache-2.0
#include "data/varies.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "data/scalar_visit.h"

namespace ovoid::data {

bool varies(const DataArray& array) {
  return visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    const auto stored = static_cast<std::int64_t>(array.bytes.view.size() / sizeof(T));
    const std::int64_t components = std::max(array.num_components, 1);
    const std::byte* bytes = array.bytes.view.data();
    for (std::int64_t c = 0; c < components; ++c) {
      bool has_first = false;
      T first{};
      for (std::int64_t i = c; i < stored; i += components) {
        const T value = load_scalar<T>(bytes, i);
        if constexpr (std::is_floating_point_v<T>) {
          if (!std::isfinite(value)) continue;
        }
        if (!has_first) {
          first = value;
          has_first = true;
        } else if (value != first) {
          return true;
        }
      }
    }
    return false;
  });
}

}  // namespace ovoid::data
