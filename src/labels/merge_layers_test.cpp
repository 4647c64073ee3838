// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "ovoid/error.h"
#include "ovoid/labels.h"

namespace ovoid {
namespace merge_layers_test {

template <class T>
Dataset segmentation(ScalarType type, int num_layers, std::vector<T> samples) {
  const auto owner = std::make_shared<const std::vector<T>>(std::move(samples));
  Dataset dataset;
  dataset.source = "two.seg.nrrd";
  DataArray array;
  array.type = type;
  array.num_components = num_layers;
  array.num_tuples = static_cast<std::int64_t>(owner->size()) / num_layers;
  array.bytes = {owner, std::as_bytes(std::span(*owner))};
  dataset.lattice.dims = {array.num_tuples, 1, 1};
  dataset.arrays = {array};
  return dataset;
}

std::vector<int> labels_of(const Dataset& dataset) {
  const DataArray& array = dataset.arrays.at(0);
  EXPECT_EQ(array.type, ScalarType::kUInt16);
  EXPECT_EQ(array.num_components, 1);
  std::vector<int> labels;
  for (std::size_t i = 0; i + 1 < array.bytes.view.size(); i += 2)
    labels.push_back(static_cast<int>(array.bytes.view[i]) +
                     256 * static_cast<int>(array.bytes.view[i + 1]));
  return labels;
}

TEST(MergeLayers, TheSmallerSegmentIsKeptAndNumbersStayWhereTheyCan) {
  // A body of 1 and 2 in one layer; in the next 1 is an organ within, 7 one that reaches out.
  const Dataset dataset = segmentation<std::uint8_t>(
      ScalarType::kUInt8, 2, {1, 0, 1, 1, 1, 1, 1, 0, 2, 7, 0, 7, 0, 7, 0, 0});
  const MergedLayers merged =
      merge_layers(dataset, {{{1, "body", Rgb{1, 0, 0}}, {9, "none"}}, {{1, "organ"}}});
  EXPECT_EQ(labels_of(merged.dataset), (std::vector<int>{1, 3, 3, 1, 2, 7, 7, 0}));
  ASSERT_EQ(merged.table.size(), 4U);
  EXPECT_EQ(merged.table[0].name, "body");
  EXPECT_EQ(merged.table[0].color, (Rgb{1, 0, 0}));
  EXPECT_EQ(merged.table[1].label, 2);
  EXPECT_TRUE(merged.table[1].name.empty());
  EXPECT_EQ(merged.table[2].name, "organ");
  EXPECT_EQ(merged.table[2].label, 3);
  EXPECT_EQ(merged.table[3].label, 7);
}

TEST(MergeLayers, LargeAndNegativeNumbersBecomeSmall) {
  const MergedLayers merged = merge_layers(
      segmentation<std::int32_t>(ScalarType::kInt32, 3, {-5, 0, 0, 0, 1 << 20, 0, 0, 0, 1}), {});
  EXPECT_EQ(labels_of(merged.dataset), (std::vector<int>{2, 3, 1}));
}

TEST(MergeLayers, WhatIsNoSegmentation) {
  EXPECT_THROW(merge_layers(segmentation<float>(ScalarType::kFloat32, 2, {1, 0.5F}), {}), Error);
  EXPECT_THROW(merge_layers(segmentation<std::int64_t>(ScalarType::kInt64, 2, {1LL << 40, 0}), {}),
               Error);
  EXPECT_THROW(merge_layers(Dataset(), {}), Error);
  Dataset scaled = segmentation<std::uint8_t>(ScalarType::kUInt8, 2, {1, 0});
  scaled.arrays[0].value_scale = 2;
  EXPECT_THROW(merge_layers(scaled, {}), Error);
}

}  // namespace merge_layers_test
}  // namespace ovoid
