// SPDX-License-Identifier: Apache-2.0
#include "simd/peak.h"

#include <gtest/gtest.h>

namespace ovoid::simd {
namespace peak_test {

// Between what the slowest and the fastest of machines can do. Fails if lanes or time are
// forgotten.
TEST(Peak, IsThatOfAMachine) {
  for (const std::string& name : SimdTarget::usable()) {
    const double peak = multiply_add_peak(SimdTarget(name));
    EXPECT_GT(peak, 1e6) << name;
    EXPECT_LT(peak, 1e13) << name;
    const double bandwidth = bandwidth_peak(SimdTarget(name));
    EXPECT_GT(bandwidth, 1e7) << name;
    EXPECT_LT(bandwidth, 1e13) << name;
  }
}

}  // namespace peak_test
}  // namespace ovoid::simd
