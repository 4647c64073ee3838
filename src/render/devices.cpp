// SPDX-License-Identifier: Apache-2.0
#include "ovoid/devices.h"

namespace ovoid {

const char* name_of(DeviceKind kind) noexcept {
  switch (kind) {
    case DeviceKind::kDiscrete:
      return "discrete";
    case DeviceKind::kIntegrated:
      return "integrated";
    case DeviceKind::kVirtual:
      return "virtual";
    case DeviceKind::kSoftware:
      return "software";
    case DeviceKind::kOther:
      break;
  }
  return "other";
}

}  // namespace ovoid
