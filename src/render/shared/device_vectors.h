// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "ovoid/math.h"
#include "render/shared/device_layout.h"

namespace ovoid {

inline device::vec4 device_vector(const Vec3& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), 0};
}

inline device::vec4 device_vector(const std::array<double, 4>& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]),
          static_cast<float>(v[3])};
}

}  // namespace ovoid
