// SPDX-License-Identifier: Apache-2.0
#include "ovoid/version.h"

namespace ovoid {

Version version() noexcept { return {}; }

}  // namespace ovoid
