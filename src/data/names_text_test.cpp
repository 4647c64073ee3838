// SPDX-License-Identifier: Apache-2.0
#include "data/names_text.h"

#include <gtest/gtest.h>

#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/error.h"
#include "support/where.h"

namespace ovoid::data {
namespace names_text_test {

TEST(NamesText, ShowsAFewNamesAndTheNumberOfTheOthers) {
  OVOID_NOT_UNDER_TSAN();
  EXPECT_EQ(names_text({}), "none");
  EXPECT_EQ(names_text(std::vector<std::string>{"a"}), "'a'");
  std::vector<std::string> names(10, "n");
  EXPECT_EQ(names_text(names), "'n', 'n', 'n', 'n', 'n', 'n', 'n', 'n', 'n', 'n'");
  names.resize(60000);
  EXPECT_EQ(names_text(names), "'n', 'n', 'n', 'n', 'n', 'n', 'n', 'n', 'n', 'n' and 59990 more");
}

TEST(NamesText, CutsLongNamesBetweenCharacters) {
  OVOID_NOT_UNDER_TSAN();
  EXPECT_EQ(name_text(std::string(60, 'x')), "'" + std::string(60, 'x') + "'");
  EXPECT_EQ(name_text(std::string(61, 'x')), "'" + std::string(60, 'x') + "...'");
  EXPECT_EQ(name_text(std::string(59, 'x') + "\xc3\xa9y"), "'" + std::string(59, 'x') + "...'");
}

// Whatever a file calls its arrays, and however many there are, an error is a line.
TEST(NamesText, ADatasetOfManyArraysHasShortErrors) {
  OVOID_NOT_UNDER_TSAN();
  Dataset dataset;
  dataset.source = "a.npz";
  dataset.arrays.resize(60000);
  for (DataArray& array : dataset.arrays) array.name = std::string(1000, 'n');
  try {
    dataset.array("b");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_LT(std::string(error.what()).size(), 1000U);
  }
}

}  // namespace names_text_test
}  // namespace ovoid::data
