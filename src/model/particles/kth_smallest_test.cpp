// SPDX-License-Identifier: Apache-2.0
#include "model/particles/kth_smallest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace ovoid::model {
namespace kth_smallest_test {

// Against a sort, with all numbers different and with few different ones.
TEST(KthSmallest, IsWhatASortSays) {
  std::mt19937 random(7);
  for (const unsigned kinds : {1U, 2U, 5U, 1000000U}) {
    for (std::size_t count = 1; count <= 100; ++count) {
      std::vector<double> numbers(count), spare(count);
      for (double& number : numbers) number = static_cast<double>(random() % kinds);
      std::vector<double> sorted = numbers;
      std::sort(sorted.begin(), sorted.end());
      for (const std::size_t k : {std::size_t{1}, (count + 1) / 2, count}) {
        std::vector<double> changed = numbers;
        EXPECT_EQ(kth_smallest(changed, k, spare), sorted[k - 1]);
        EXPECT_EQ(changed[k - 1], sorted[k - 1]);
        std::sort(changed.begin(), changed.begin() + static_cast<std::ptrdiff_t>(k));
        EXPECT_TRUE(std::equal(changed.begin(), changed.begin() + static_cast<std::ptrdiff_t>(k),
                               sorted.begin()))
            << kinds << " kinds, " << k << " of " << count;
        std::sort(changed.begin(), changed.end());
        EXPECT_EQ(changed, sorted);
      }
    }
  }
}

}  // namespace kth_smallest_test
}  // namespace ovoid::model
