// SPDX-License-Identifier: Apache-2.0
#include "io/core/cf_conventions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "io/images/test_volumes.h"

namespace ovoid::io {
namespace cf_conventions_test {

TEST(MissingNumbers, BecomeNaNAndIntegersFloats) {
  std::vector<std::string> notes;
  const CfNumbers missing{.missing = {-1, 300, std::nan("")}};
  DataArray array = make_array<std::int16_t>("a", ScalarType::kInt16, {1, -1, 300, 2});
  hide_missing_numbers("a", missing, array, notes);
  ASSERT_EQ(array.type, ScalarType::kFloat32);
  const auto values = values_of<float>(array);
  EXPECT_TRUE(std::isnan(values[1]) && std::isnan(values[2]));
  EXPECT_EQ(values[3], 2);
  EXPECT_EQ(notes,
            std::vector<std::string>{"a: int16 becomes float32: -1 stands for missing samples"});

  array = make_array<std::int32_t>("a", ScalarType::kInt32, {16777217, -1});
  hide_missing_numbers("a", missing, array, notes);
  ASSERT_EQ(array.type, ScalarType::kFloat64);
  EXPECT_EQ(values_of<double>(array)[0], 16777217);
  notes.clear();
  array = make_array<float>("a", ScalarType::kFloat32, {1, -1});
  hide_missing_numbers("a", missing, array, notes);
  EXPECT_TRUE(std::isnan(values_of<float>(array)[1]));
  EXPECT_TRUE(notes.empty());
}

// A number that the type does not hold is none of its samples: 255 is not -1.
TEST(MissingNumbers, OthersChangeNothing) {
  std::vector<std::string> notes;
  DataArray array = make_array<std::uint8_t>("a", ScalarType::kUInt8, {255, 0, 44});
  const CfNumbers missing{.missing = {-1, 300, 0.5, 1e300, std::nan("")}};
  hide_missing_numbers("a", missing, array, notes);
  EXPECT_EQ(array.type, ScalarType::kUInt8);
  EXPECT_TRUE(notes.empty());
}

// Numbers of 8 bytes are compared as they are drawn; a bound in double is no more than one in
// float.
TEST(MissingNumbers, AreAsExactAsSamples) {
  std::vector<std::string> notes;
  DataArray wide = make_array<std::uint64_t>("a", ScalarType::kUInt64,
                                             {1, std::numeric_limits<std::uint64_t>::max() - 1});
  hide_missing_numbers("a", cf_numbers({}, ScalarType::kUInt64, CfFill::kOfNetcdf), wide, notes);
  ASSERT_EQ(wide.type, ScalarType::kFloat64);
  EXPECT_TRUE(std::isnan(values_of<double>(wide)[1]));
  DataArray narrow = make_array<float>("a", ScalarType::kFloat32, {0.1F, 0.2F});
  hide_missing_numbers("a", {.valid_max = 0.1}, narrow, notes);
  EXPECT_EQ(values_of<float>(narrow)[0], 0.1F);
  EXPECT_TRUE(std::isnan(values_of<float>(narrow)[1]));
}

TEST(CfAttributes, AreNumbersAndText) {
  const CfAttributes attributes{{"units", " m \n"},
                                {"missing_value", "-99.5"},
                                {"_Unsigned", "true"},
                                {"_FillValue", "", {-1}}};
  EXPECT_EQ(cf_text(attributes, "units"), "m");
  EXPECT_EQ(cf_number(attributes, "missing_value"), -99.5);
  EXPECT_EQ(cf_number(attributes, "scale_factor"), std::nullopt);
  EXPECT_EQ(cf_type(attributes, ScalarType::kInt16), ScalarType::kUInt16);
  EXPECT_EQ(cf_numbers(attributes, ScalarType::kUInt16, CfFill::kNone).missing.front(), 65535);
}

TEST(EvenPlaces, AreEvenToAThousandth) {
  EXPECT_EQ(even_places(std::vector<double>{3, 2.5, 2.0004}).has_value(), true);
  EXPECT_EQ(even_places(std::vector<double>{1, 2, 3})->second, 1);
  EXPECT_FALSE(even_places(std::vector<double>{3, 2.5, 2.01}).has_value());
  EXPECT_FALSE(even_places(std::vector<double>{3}).has_value());
  EXPECT_FALSE(even_places(std::vector<double>{3, 3}).has_value());
  EXPECT_FALSE(even_places(std::vector<double>{1, 2, std::nan("")}).has_value());
}

}  // namespace cf_conventions_test
}  // namespace ovoid::io
