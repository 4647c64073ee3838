// SPDX-License-Identifier: Apache-2.0
// Slices at uneven distances, with gaps, of a tilted gantry. What would make these fail: a slice
// that is not where its file says, or has not its own samples; a gap without samples; a refusal.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "io/core/test_folder.h"
#include "io/dicom/test_dicom_series.h"
#include "io/images/test_volumes.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace dicom_places_test {

using testing::ElementsAre;
using testing::HasSubstr;

void expect_near(const Vec3& actual, const Vec3& expected) {
  EXPECT_LT((actual - expected).norm(), 1e-12) << actual.transpose();
}

Vec3 step_of(const Dataset& dataset) { return dataset.lattice.world_from_index.linear().col(2); }

// A slice's own samples stay as they are, those of a gap lie on the line between its neighbours.
void expect_samples(const Dataset& dataset, const std::vector<double>& firsts) {
  const auto values = values_of<float>(dataset.arrays.at(0));
  ASSERT_EQ(values.size(), 6 * firsts.size());
  for (std::size_t i = 0; i < firsts.size(); ++i) {
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_NEAR(values[6 * i + k], firsts[i] + static_cast<double>(k), 1e-3)
          << "slice " << i << ", sample " << k;
    }
  }
}

// Slice i has the samples 10 i + 1 to 10 i + 6.
void write_slice(const TestFolder& folder, int i, const std::string& position) {
  TestSlice slice = slice_in_time(0, i);
  slice.position = position;
  folder.write("s" + std::to_string(i), dicom_slice(slice));
}

// `slant`: the way along y for each mm of height.
Dataset read_at(const std::vector<double>& heights, double slant = 0) {
  const TestFolder folder;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    write_slice(folder, static_cast<int>(i),
                fmt::format("-10\\{}\\{}", 20 + slant * heights[i], heights[i]));
  }
  return read_dataset({folder.file("")});
}

TEST(DicomPlaces, MissingSlicesAreInterpolated) {
  const Dataset dataset = read_at({0, 3, 6, 15, 18});
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 7));
  expect_near(step_of(dataset), {0, 0, 3});
  expect_samples(dataset, {1, 11, 21, 21 + 10 / 3.0, 21 + 20 / 3.0, 31, 41});
  ASSERT_EQ(dataset.notes.size(), 1U);
  EXPECT_THAT(dataset.notes[0], HasSubstr("2 of 7 slices are missing between "));
  EXPECT_THAT(dataset.notes[0], HasSubstr("s2 and "));
  EXPECT_THAT(dataset.notes[0], HasSubstr("s3: interpolated"));
}

TEST(DicomPlaces, AWideGapIsNoError) {
  const Dataset dataset = read_at({0, 5, 10, 50});
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 11));
  expect_samples(dataset, {1, 11, 21, 22.25, 23.5, 24.75, 26, 27.25, 28.5, 29.75, 31});
}

TEST(DicomPlaces, UnevenSlicesKeepTheirPlaces) {
  const double third = 10.0 / 3;
  for (const double slant : {0.0, 0.25}) {
    const Dataset dataset = read_at({0, 5, 10, 17.5, 25}, slant);
    EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 11));
    expect_near(step_of(dataset), {0, 2.5 * slant, 2.5});
    expect_near(dataset.lattice.world_from_index.translation(), {-10, 20, 0});
    expect_samples(dataset, {1, 6, 11, 16, 21, 21 + third, 21 + 2 * third, 31, 31 + third,
                             31 + 2 * third, 41});
    EXPECT_THAT(dataset.notes,
                ElementsAre(HasSubstr("slices lie 5 to 7.5 mm apart: 11 of 2.5 mm are made of "
                                      "them, those between by linear interpolation")));
  }
  const Dataset down = read_at({0, -5, -10, -17.5, -25});
  expect_near(down.lattice.world_from_index.translation(), {-10, 20, -25});
  expect_samples(
      down, {41, 41 - third, 41 - 2 * third, 31, 31 - third, 31 - 2 * third, 21, 16, 11, 6, 1});
}

TEST(DicomPlaces, SlicesThatShareNoDistanceLieNearTheirPlaces) {
  const std::vector<double> heights{0, 1, 2.618, 3.7, 5.9, 7.141, 9.05};
  const Dataset dataset = read_at(heights);
  const auto values = values_of<float>(dataset.arrays.at(0));
  const double distance = step_of(dataset).z();
  EXPECT_LE(dataset.lattice.dims[2], 256);
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const auto plane = static_cast<std::size_t>(std::lround(heights[i] / distance));
    EXPECT_NEAR(static_cast<double>(plane) * distance, heights[i], 0.02);
    EXPECT_FLOAT_EQ(values[6 * plane], 10 * static_cast<float>(i) + 1);
  }
}

TEST(DicomPlaces, NearlyEvenSlicesAreNoted) {
  const Dataset dataset = read_at({0, 3, 6.2, 9});
  expect_near(step_of(dataset), {0, 0, 3});
  EXPECT_EQ(dataset.arrays.at(0).type, ScalarType::kUInt16);
  EXPECT_THAT(dataset.notes, ElementsAre(HasSubstr("s2: slices are not evenly spaced: this one "
                                                   "is 0.2 mm off; the mean distance, 3 mm")));
}

TEST(DicomPlaces, SlicesOnABentLineAreRefused) {
  const TestFolder folder;
  for (int i = 0; i < 4; ++i)
    write_slice(folder, i, fmt::format("-10\\{}\\{}", i == 2 ? 1 : 0, 3 * i));
  EXPECT_THAT(error_of([&] { read_dataset({folder.file("")}); }),
              HasSubstr("s2: lies 1 mm beside the line between the first and the last"));
}

// Values of slices with scales of their own, and of words of 32 bits, between others.
TEST(DicomPlaces, ValuesAreInterpolatedNotNumbers) {
  const TestFolder folder;
  for (int i = 0; i < 3; ++i) {
    TestSlice slice = slice_in_time(0, i);
    slice.position = fmt::format("0\\0\\{}", i == 2 ? 9 : 3 * i);
    slice.slope = i == 2 ? "10" : "1";
    folder.write(std::to_string(i), dicom_slice(slice));
  }
  const auto values = values_of<float>(read_dataset({folder.file("")}).arrays.at(0));
  EXPECT_FLOAT_EQ(values[12], (11 + 210) / 2.0F);
}

}  // namespace dicom_places_test
}  // namespace ovoid::io
