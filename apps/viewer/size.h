// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace ovoid::viewer {

struct Size {
  int width = 0, height = 0;
  bool operator==(const Size&) const = default;
};

}  // namespace ovoid::viewer
