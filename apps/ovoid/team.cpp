// SPDX-License-Identifier: Apache-2.0
#include "team.h"

#include <vector>

namespace ovoid::cli {

int device_at_place(const DeviceList& list, int place) {
  std::vector<int> processors;
  for (const DeviceInfo& device : list.devices) {
    if (device.is_hardware() && device.is_usable()) processors.push_back(device.index);
  }
  if (processors.size() < 2) return -1;
  return processors[static_cast<std::size_t>(place) % processors.size()];
}

}  // namespace ovoid::cli
