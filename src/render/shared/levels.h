// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace ovoid {

// Least sigma, in samples of a level, of the kernels summed on it (docs/numerics.md, "Levels"; the
// pictures' test holds what the filter then loses).
inline constexpr float kLeastLevelSigma = 1.6F;
inline constexpr float kPublishedLevelSigma = 0.5F;

}  // namespace ovoid
