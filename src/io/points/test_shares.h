// SPDX-License-Identifier: Apache-2.0
// For tests of readers: do the shares of a file's rows, put together, make the whole?
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

using ReadWith = std::function<Dataset(const ReadOptions&)>;

// The bytes of an array are those of `whole` from row `first` on.
inline void expect_rows(const DataArray& part, const DataArray& whole, std::int64_t first) {
  EXPECT_EQ(part.name, whole.name);
  EXPECT_EQ(part.unit, whole.unit);
  ASSERT_EQ(part.type, whole.type);
  ASSERT_EQ(part.num_components, whole.num_components);
  const std::size_t row_size = size_of(whole.type) * static_cast<std::size_t>(whole.num_components);
  const std::size_t num_bytes = static_cast<std::size_t>(part.num_tuples) * row_size;
  ASSERT_EQ(part.bytes.view.size(), num_bytes);
  const auto expected =
      whole.bytes.view.subspan(static_cast<std::size_t>(first) * row_size, num_bytes);
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), part.bytes.view.begin()))
      << whole.name << " from row " << first;
}

// Reads the whole and shares of it, also more than there are rows. Returns the whole.
inline Dataset expect_shares(const ReadWith& read, ReadOptions options = {}) {
  const Dataset whole = read(options);
  EXPECT_FALSE(whole.share.has_value());
  const std::int64_t total = whole.num_positions();
  EXPECT_GT(total, 0);
  for (const int count : {1, 2, 3, 7, static_cast<int>(total) + 3}) {
    std::int64_t next = 0;
    for (int number = 0; number < count; ++number) {
      SCOPED_TRACE("share " + std::to_string(number) + " of " + std::to_string(count));
      options.share = RowShare{number, count};
      const Dataset part = read(options);
      if (!part.share) {
        ADD_FAILURE() << "is no share";
        return whole;
      }
      EXPECT_EQ(part.share->first, next);
      EXPECT_EQ(part.share->first, total * number / count);
      EXPECT_EQ(part.share->total, total);
      EXPECT_EQ(part.kind, whole.kind);
      EXPECT_EQ(part.notes, whole.notes);
      EXPECT_EQ(part.step, whole.step);
      EXPECT_EQ(part.num_steps, whole.num_steps);
      EXPECT_EQ(part.times, whole.times);
      EXPECT_EQ(part.reconstruction, whole.reconstruction);
      EXPECT_EQ(part.cutoff, whole.cutoff);
      EXPECT_EQ(part.periodic_box.has_value(), whole.periodic_box.has_value());
      expect_rows(part.positions, whole.positions, next);
      EXPECT_EQ(part.arrays.size(), whole.arrays.size());
      for (std::size_t i = 0; i < std::min(part.arrays.size(), whole.arrays.size()); ++i) {
        EXPECT_EQ(part.arrays[i].num_tuples, part.num_positions());
        expect_rows(part.arrays[i], whole.arrays[i], next);
      }
      next += part.num_positions();
    }
    EXPECT_EQ(next, total) << "in " << count << " shares";
  }
  return whole;
}

}  // namespace ovoid::io
