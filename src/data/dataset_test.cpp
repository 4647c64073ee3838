// SPDX-License-Identifier: Apache-2.0
#include "ovoid/dataset.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "ovoid/error.h"

namespace ovoid {
namespace dataset_test {

template <class T>
DataArray array_of(const char* name, ScalarType type, std::vector<T> values, int components = 1) {
  const auto owner = std::make_shared<std::vector<T>>(std::move(values));
  DataArray array;
  array.name = name;
  array.type = type;
  array.num_components = components;
  array.num_tuples = static_cast<std::int64_t>(owner->size()) / components;
  array.bytes = {owner, std::as_bytes(std::span<const T>(*owner))};
  return array;
}

DataArray floats(const char* name, std::vector<float> values, int components = 1) {
  return array_of(name, ScalarType::kFloat32, std::move(values), components);
}

Dataset dataset_of(std::vector<DataArray> arrays) {
  Dataset dataset;
  dataset.source = "some.vti";
  dataset.arrays = std::move(arrays);
  return dataset;
}

TEST(DatasetArray, ByNameOrTheFirstThatVaries) {
  const Dataset dataset =
      dataset_of({floats("flat", {2, 2, 2}),
                  array_of<std::uint8_t>("vtkValidPointMask", ScalarType::kUInt8, {0, 1, 1}),
                  array_of<std::int16_t>("density", ScalarType::kInt16, {-1, -1, 5}),
                  floats("other", {1, 2, 3})});
  EXPECT_EQ(dataset.array().name, "density");
  EXPECT_EQ(dataset.array("flat").name, "flat");
  EXPECT_EQ(dataset.array("vtkValidPointMask").name, "vtkValidPointMask");
}

// Numbers of nodes and blocks are never the default, cells' arrays behind those of nodes.
TEST(DatasetArray, BookkeepingAndCellsComeLast) {
  DataArray cells = floats("strain", {1, 2});
  cells.is_cell_data = true;
  Dataset dataset = dataset_of({cells, floats("GlobalNodeId", {1, 2, 3}), floats("v", {4, 4, 4})});
  EXPECT_EQ(dataset.array().name, "strain");
  dataset.arrays.push_back(floats("w", {4, 4, 5}));
  EXPECT_EQ(dataset.array().name, "w");
  EXPECT_EQ(dataset_of({floats("ObjectId", {1, 2}), floats("a", {3, 3})}).array().name, "a");
}

// Fails if components are compared with one another, or missing samples count as variation.
TEST(DatasetArray, ConstantTuplesAndMissingSamplesDoNotVary) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Dataset dataset =
      dataset_of({floats("normal", {0, 0, 1, 0, 0, 1}, 3), floats("hole", {nan, 4, nan, 4}),
                  floats("zero", {0.0F, -0.0F}), floats("late", {nan, 4, 4, 5})});
  EXPECT_EQ(dataset.array().name, "late");
}

TEST(DatasetArray, FirstIfNoneVaries) {
  EXPECT_EQ(dataset_of({floats("a", {1, 1}), floats("b", {2, 2})}).array().name, "a");
}

// A dataset that claims more tuples than it holds is found out by whoever uses it; choosing an
// array must not read past the end.
TEST(DatasetArray, BelievesTheBytesNotTheCount) {
  DataArray liar = floats("liar", {1, 1});
  liar.num_tuples = 1'000'000'000;
  DataArray empty = floats("empty", {});
  EXPECT_EQ(dataset_of({liar, empty}).array().name, "liar");
}

TEST(DatasetArray, UnknownNameListsTheArrays) {
  try {
    dataset_of({floats("a", {1}), floats("b c", {2})}).array("d");
    FAIL() << "found";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    EXPECT_STREQ(error.what(), "array 'd': not in 'some.vti', which has 'a', 'b c'");
  }
  EXPECT_THROW(dataset_of({}).array(), Error);
}

TEST(Space, HasNames) {
  EXPECT_STREQ(name_of(Space::kNone), "none");
  EXPECT_STREQ(name_of(Space::kLps), "LPS");
  EXPECT_STREQ(name_of(Space::kRas), "RAS");
}

}  // namespace dataset_test
}  // namespace ovoid
