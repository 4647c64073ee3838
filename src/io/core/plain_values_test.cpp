// SPDX-License-Identifier: Apache-2.0
#include "io/core/plain_values.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "io/images/test_volumes.h"

namespace ovoid::io {
namespace plain_values_test {

template <typename T>
DataArray scaled(ScalarType type, const std::vector<T>& values, double scale, double offset) {
  DataArray array = make_array("x", type, values);
  array.value_scale = scale;
  array.value_offset = offset;
  return array;
}

TEST(PlainValues, WithoutAScaleTheArrayItselfComesBack) {
  const DataArray array = scaled<std::int16_t>(ScalarType::kInt16, {1, 2}, 1, 0);
  EXPECT_EQ(plain_values(array).bytes.view.data(), array.bytes.view.data());
}

// Fails if integers go through float, or the type cannot hold the least or greatest.
TEST(PlainValues, IntegersStayExact) {
  const auto expect = [](const DataArray& array, ScalarType type, const auto& values) {
    const DataArray plain = plain_values(array);
    using Value = typename std::decay_t<decltype(values)>::value_type;
    EXPECT_EQ(plain.type, type);
    EXPECT_FALSE(plain.is_scaled());
    EXPECT_EQ(values_of<Value>(plain), values);
  };
  expect(scaled<std::uint8_t>(ScalarType::kUInt8, {0, 100}, 2, 5), ScalarType::kUInt8,
         std::vector<std::uint8_t>{5, 205});
  expect(scaled<std::uint8_t>(ScalarType::kUInt8, {0, 100}, 1, -100), ScalarType::kInt8,
         std::vector<std::int8_t>{-100, 0});
  expect(scaled<std::uint8_t>(ScalarType::kUInt8, {0, 255}, 1, -1024), ScalarType::kInt16,
         std::vector<std::int16_t>{-1024, -769});
  expect(scaled<std::uint16_t>(ScalarType::kUInt16, {0, 65535}, 1, 0.0 + 1), ScalarType::kInt32,
         std::vector<std::int32_t>{1, 65536});
  expect(scaled<std::int16_t>(ScalarType::kInt16, {0, 32767}, 2, 0), ScalarType::kUInt16,
         std::vector<std::uint16_t>{0, 65534});
  expect(scaled<std::int32_t>(ScalarType::kInt32, {-2147483647 - 1, 2147483647}, -1, 0),
         ScalarType::kFloat64, std::vector<double>{2147483648.0, -2147483647.0});
  expect(scaled<std::int32_t>(ScalarType::kInt32, {16777217, 1}, 3, 0), ScalarType::kInt32,
         std::vector<std::int32_t>{50331651, 3});
}

TEST(PlainValues, OthersBecomeFloats) {
  const DataArray halves =
      plain_values(scaled<std::uint16_t>(ScalarType::kUInt16, {1, 65535}, 0.5, 0));
  EXPECT_EQ(halves.type, ScalarType::kFloat32);
  EXPECT_EQ(values_of<float>(halves), (std::vector<float>{0.5F, 32767.5F}));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const DataArray holes = plain_values(scaled<float>(ScalarType::kFloat32, {nan, 1.5F}, 2, 1));
  EXPECT_EQ(holes.type, ScalarType::kFloat32);
  EXPECT_TRUE(std::isnan(values_of<float>(holes)[0]));
  EXPECT_EQ(values_of<float>(holes)[1], 4);
  const DataArray wide =
      plain_values(scaled<std::int64_t>(ScalarType::kInt64, {1LL << 53, 3}, 2, 0));
  EXPECT_EQ(wide.type, ScalarType::kFloat64);
  EXPECT_EQ(values_of<double>(wide), (std::vector<double>{0x1p54, 6}));
  const DataArray empty = plain_values(scaled<double>(ScalarType::kFloat64, {}, 2, 0));
  EXPECT_EQ(empty.bytes.view.size(), 0U);
}

TEST(PlainValues, KeepsWhatTheArrayIs) {
  DataArray array = make_array("v", ScalarType::kUInt8, counting<std::uint8_t>(6), 3);
  array.value_scale = 2;
  array.unit = "m/s";
  const DataArray plain = plain_values(array);
  EXPECT_EQ(plain.name, "v");
  EXPECT_EQ(plain.unit, "m/s");
  EXPECT_EQ(plain.num_components, 3);
  EXPECT_EQ(plain.num_tuples, 2);
  EXPECT_EQ(values_of<std::uint8_t>(plain), (std::vector<std::uint8_t>{2, 4, 6, 8, 10, 12}));
}

}  // namespace plain_values_test
}  // namespace ovoid::io
