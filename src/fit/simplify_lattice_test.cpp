// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <stop_token>
#include <string>
#include <vector>

#include "io/images/test_volumes.h"
#include "ovoid/error.h"
#include "ovoid/simplify.h"

namespace ovoid {
namespace simplify_lattice_test {

using io::values_of;
using testing::HasSubstr;

using Place = std::array<std::int64_t, 3>;

Dataset scan_of(const Index3& dims, ScalarType type,
                const std::function<double(const Place&)>& value) {
  Dataset dataset;
  dataset.lattice.dims = dims;
  std::vector<float> values;
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    for (std::int64_t y = 0; y < dims[1]; ++y) {
      for (std::int64_t x = 0; x < dims[0]; ++x)
        values.push_back(static_cast<float>(value({x, y, z})));
    }
  }
  dataset.arrays = {
      type == ScalarType::kFloat32
          ? io::make_array("v", type, values)
          : io::make_array("v", type, std::vector<std::uint8_t>(values.begin(), values.end()))};
  return dataset;
}

double wave(const Place& p) {
  const auto [x, y, z] = p;
  return 100 + 60 * std::sin(0.21 * static_cast<double>(x) + 0.1 * static_cast<double>(y * z % 7)) +
         (x * 31 + y * 17 + z * 11) % 5;
}

SimplifyOptions with(double tolerance, Primitives primitives = Primitives::kBoxes,
                     RunSearch search = RunSearch::kGreedy) {
  SimplifyOptions options;
  options.tolerance = tolerance;
  options.primitives = primitives;
  options.search = search;
  return options;
}

double greatest_error(const Dataset& dataset, const LatticeBoxes& boxes) {
  const std::vector<float> read = samples_of(boxes);
  const DataArray& array = dataset.array();
  const std::vector<float> values =
      array.type == ScalarType::kFloat32 ? values_of<float>(array) : [&] {
        const std::vector<std::uint8_t> bytes = values_of<std::uint8_t>(array);
        return std::vector<float>(bytes.begin(), bytes.end());
      }();
  double greatest = 0;
  for (std::size_t i = 0; i < read.size(); ++i)
    greatest = std::max(greatest, std::abs(static_cast<double>(read[i] - values[i])));
  return greatest;
}

// Floats far from 0: fails if the tolerance grows with how large they are, or a box's numbers are
// rounded as floats.
TEST(Simplify, AnOffsetCostsNoAccuracy) {
  const Dataset dataset = scan_of({40, 21, 9}, ScalarType::kFloat32,
                                  [](const Place& p) { return 1e6 + wave(p) / 200; });
  for (const double share : {0.0, 0.01, 0.2}) {
    SimplifyOptions options;
    options.relative_tolerance = share;
    SimplifyReport report;
    const LatticeBoxes boxes = simplify_lattice(dataset, options, &report);
    const double most = std::max(share, SimplifyOptions::kLeastTolerance) * report.range;
    EXPECT_DOUBLE_EQ(report.tolerance, most);
    EXPECT_LE(greatest_error(dataset, boxes), most);
  }
}

// Three plates of one value each, which go through all layers, in nothing.
double plates(const Place& p) {
  if (p[1] < 2 || p[1] > 6) return 0;
  return p[0] < 4 ? 0 : p[0] < 9 ? 50 : p[0] < 15 ? 80 : p[0] < 18 ? 50 : 0;
}

// Fails if runs are cut, if the background needs any, or if boxes do not grow along y and z.
TEST(Simplify, APiecewiseConstantScanHasAsManyPrimitivesAsRuns) {
  const Dataset dataset = scan_of({20, 10, 8}, ScalarType::kUInt8, plates);
  for (const Primitives primitives : {Primitives::kConstants, Primitives::kRamps}) {
    for (const RunSearch search : {RunSearch::kGreedy, RunSearch::kFewest}) {
      const LatticeBoxes runs = simplify_lattice(dataset, with(0, primitives, search));
      EXPECT_EQ(runs.boxes.size(), 3U * 5 * 8);
      EXPECT_EQ(greatest_error(dataset, runs), 0);
    }
  }
  SimplifyReport report;
  const LatticeBoxes boxes = simplify_lattice(dataset, with(0), &report);
  EXPECT_EQ(boxes.boxes.size(), 3U);
  EXPECT_EQ(boxes.boxes[1].size, (std::array<std::int32_t, 3>{6, 5, 8}));
  EXPECT_EQ(report.primitives, 3);
  EXPECT_EQ(report.relevant, 14 * 5 * 8);
  EXPECT_EQ(report.greatest_error, 0);
  EXPECT_EQ(report.range, 80);
}

// Fails if the slopes of one axis leak into another's, or rounding of the numbers adds up.
TEST(Simplify, AnEvenRiseIsOneBox) {
  const Dataset dataset = scan_of({17, 9, 5}, ScalarType::kFloat32, [](const Place& p) {
    return 3.0 * static_cast<double>(p[0]) - 2.5 * static_cast<double>(p[1]) +
           0.75 * static_cast<double>(p[2]);
  });
  const LatticeBoxes boxes = simplify_lattice(dataset, with(0.01));
  ASSERT_EQ(boxes.boxes.size(), 1U);
  EXPECT_NEAR(boxes.step * boxes.boxes[0].rise[0], 48, 0.01);
  EXPECT_NEAR(boxes.step * boxes.boxes[0].rise[1], -20, 0.01);
  EXPECT_NEAR(boxes.step * boxes.boxes[0].rise[2], 3, 0.01);
}

// Fails if any sample errs by more, whatever stands for it, or if another error is told.
TEST(Simplify, TheToleranceHoldsAtEverySample) {
  for (const ScalarType type : {ScalarType::kUInt8, ScalarType::kFloat32}) {
    const Dataset dataset = scan_of({40, 21, 40}, type, wave);
    for (const double tolerance : {0.0, 0.7, 1.0, 2.5, 9.0, 40.0}) {
      for (const Primitives primitives :
           {Primitives::kConstants, Primitives::kRamps, Primitives::kBoxes}) {
        SimplifyReport report;
        const LatticeBoxes boxes = simplify_lattice(dataset, with(tolerance, primitives), &report);
        const double least =
            type == ScalarType::kFloat32 ? SimplifyOptions::kLeastTolerance * report.range : 0;
        EXPECT_LE(greatest_error(dataset, boxes), std::max(tolerance, least));
        EXPECT_FLOAT_EQ(static_cast<float>(report.greatest_error),
                        static_cast<float>(greatest_error(dataset, boxes)));
        EXPECT_LE(report.primitives, report.samples);
      }
    }
  }
}

// Fails if the search misses a better way, or the greedy one is no way at all. The values make
// greedy runs end too late: least squares fit the whole where they do not fit a part.
TEST(Simplify, FewestRunsAreNeverMoreThanGreedyOnes) {
  const Dataset dataset = scan_of({60, 6, 4}, ScalarType::kUInt8, wave);
  bool is_better_somewhere = false;
  for (const Primitives primitives : {Primitives::kConstants, Primitives::kRamps}) {
    for (const double tolerance : {1.0, 3.0, 8.0}) {
      const LatticeBoxes greedy = simplify_lattice(dataset, with(tolerance, primitives));
      const LatticeBoxes fewest =
          simplify_lattice(dataset, with(tolerance, primitives, RunSearch::kFewest));
      EXPECT_LE(fewest.boxes.size(), greedy.boxes.size());
      EXPECT_LE(greatest_error(dataset, fewest), tolerance);
      is_better_somewhere |= fewest.boxes.size() < greedy.boxes.size();
    }
  }
  EXPECT_TRUE(is_better_somewhere);
}

// The fewest runs that end at a tolerance of 1 along a row, of which the background stands for
// nothing.
std::size_t fewest_runs(const std::vector<double>& row) {
  const Dataset dataset = scan_of(
      {std::ssize(row) + 1, 1, 1}, ScalarType::kUInt8,
      [&](const Place& p) { return p[0] == 0 ? 0 : row[static_cast<std::size_t>(p[0]) - 1]; });
  SimplifyOptions options = with(1, Primitives::kRamps, RunSearch::kFewest);
  options.relevant_above = 0;
  return simplify_lattice(dataset, options).boxes.size();
}

// All ways to cut a row, against the dynamic programming: fails if one is overlooked.
TEST(Simplify, FewestRunsAreAsFewAsThereCanBe) {
  const std::vector<double> row = {10, 13, 15, 19, 30, 33, 31, 28, 27, 40, 44, 44};
  std::size_t best = row.size();
  for (unsigned cuts = 0; cuts < 1U << (row.size() - 1); ++cuts) {
    std::size_t count = 0;
    auto begin = row.begin();
    bool are_even = true;
    for (auto end = row.begin() + 1; are_even; ++end) {
      if (end == row.end() || (cuts >> (end - row.begin() - 1) & 1) != 0) {
        are_even = fewest_runs({begin, end}) == 1;
        begin = end;
        ++count;
      }
      if (end == row.end()) break;
    }
    if (are_even) best = std::min(best, count);
  }
  EXPECT_LT(best, 8U);
  EXPECT_EQ(fewest_runs(row), best);
}

TEST(Simplify, TheRmsIsBoundedToo) {
  const Dataset dataset = scan_of({64, 8, 8}, ScalarType::kFloat32, wave);
  SimplifyOptions options = with(4);
  SimplifyReport loose, tight;
  simplify_lattice(dataset, options, &loose);
  options.rms_share = 0.3;
  simplify_lattice(dataset, options, &tight);
  EXPECT_GT(tight.primitives, loose.primitives);
  EXPECT_GE(tight.psnr, 20 * std::log10(tight.range / 1.2));
  EXPECT_LT(loose.psnr, 20 * std::log10(tight.range / 1.2));
}

// Fails if holes get values, or lattices lose them.
TEST(Simplify, MissingSamplesStayMissing) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const Dataset dataset = scan_of({12, 9, 7}, ScalarType::kFloat32, [](const Place& p) {
    return p[0] > 3 && p[0] < 8 && p[1] > 2 ? static_cast<double>(kNone) : wave(p);
  });
  const std::vector<float> read = samples_of(simplify_lattice(dataset, with(3)));
  const std::vector<float> values = values_of<float>(dataset.array());
  for (std::size_t i = 0; i < read.size(); ++i)
    EXPECT_EQ(std::isnan(read[i]), std::isnan(values[i])) << i;
}

TEST(Simplify, WhatIsNotRelevantBecomesTheLeastValue) {
  const Dataset dataset = scan_of({30, 9, 7}, ScalarType::kUInt8, wave);
  SimplifyOptions options = with(2);
  SimplifyReport all, some;
  simplify_lattice(dataset, options, &all);
  options.relevant_above = 120;
  const std::vector<float> read = samples_of(simplify_lattice(dataset, options, &some));
  const std::vector<std::uint8_t> values = values_of<std::uint8_t>(dataset.array());
  const auto least = static_cast<float>(*std::min_element(values.begin(), values.end()));
  for (std::size_t i = 0; i < read.size(); ++i) {
    if (values[i] <= 120)
      EXPECT_EQ(read[i], least);
    else
      EXPECT_NEAR(read[i], values[i], 2);
  }
  EXPECT_LT(some.primitives, all.primitives);
  EXPECT_LT(some.relevant, all.relevant);
}

// Fails if threads see each other's boxes, or the order of layers is theirs.
TEST(Simplify, IsTheSameForAnyNumberOfThreads) {
  const Dataset dataset = scan_of({20, 15, 70}, ScalarType::kUInt8, wave);
  std::vector<LatticeBox> before;
  for (const int threads : {1, 2, 5}) {
    SimplifyOptions options = with(3);
    options.threads = threads;
    std::vector<double> told;
    options.progress = [&](double fraction) { told.push_back(fraction); };
    const std::vector<LatticeBox> boxes = simplify_lattice(dataset, options).boxes;
    EXPECT_TRUE(before.empty() || boxes == before);
    before = boxes;
    EXPECT_EQ(told.back(), 1);
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  }
}

TEST(Simplify, ScaledIntegersKeepTheirScale) {
  Dataset dataset = scan_of({20, 9, 7}, ScalarType::kUInt8, wave);
  SimplifyReport plain, scaled;
  const LatticeBoxes boxes = simplify_lattice(dataset, with(3), &plain);
  dataset.arrays[0].value_scale = -0.5;
  dataset.arrays[0].value_offset = 1000;
  const LatticeBoxes same = simplify_lattice(dataset, with(1.5), &scaled);
  EXPECT_EQ(samples_of(same), samples_of(boxes));
  EXPECT_EQ(scaled.range, 0.5 * plain.range);
  EXPECT_EQ(scaled.greatest_error, 0.5 * plain.greatest_error);
  EXPECT_TRUE(same.whole);
}

TEST(Simplify, RefusesInWords) {
  const Dataset dataset = scan_of({6, 5, 4}, ScalarType::kUInt8, wave);
  const auto refusal = [&](const SimplifyOptions& options, const Dataset& from) {
    try {
      simplify_lattice(from, options);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_THAT(refusal(with(-1), dataset), HasSubstr("tolerance = -1"));
  SimplifyOptions both = with(1);
  both.relative_tolerance = 0.1;
  EXPECT_THAT(refusal(both, dataset), HasSubstr("both given"));
  SimplifyOptions rms = with(1);
  rms.rms_share = 0;
  EXPECT_THAT(refusal(rms, dataset), HasSubstr("rms_share = 0"));
  EXPECT_THAT(refusal(with(1, Primitives::kBoxes, RunSearch::kFewest), dataset),
              HasSubstr("fewest runs"));
  SimplifyOptions absent = with(1);
  absent.array = "w";
  EXPECT_THAT(refusal(absent, dataset), HasSubstr("'w'"));
  Dataset other = dataset;
  other.kind = DatasetKind::kMesh;
  EXPECT_THAT(refusal(with(1), other), HasSubstr("is no lattice"));
  Dataset body = dataset;
  body.lattice.kind = LatticeKind::kBodyCentred;
  EXPECT_THAT(refusal(with(1), body), HasSubstr("boxes hold Cartesian lattices"));
  std::stop_source source;
  source.request_stop();
  SimplifyOptions stopped = with(1);
  stopped.stop = source.get_token();
  EXPECT_THAT(refusal(stopped, dataset), HasSubstr("cancelled"));
}

// Constant data, one sample: fails if a range of nothing divides anything.
TEST(Simplify, TakesWhatHasNoRange) {
  for (const ScalarType type : {ScalarType::kUInt8, ScalarType::kFloat32}) {
    for (const Index3& dims : {Index3{1, 1, 1}, Index3{7, 5, 3}}) {
      const Dataset dataset = scan_of(dims, type, [](const Place&) { return 42.0; });
      SimplifyReport report;
      const LatticeBoxes boxes = simplify_lattice(dataset, {}, &report);
      EXPECT_EQ(boxes.boxes.size(), 0U);
      EXPECT_EQ(greatest_error(dataset, boxes), 0);
      EXPECT_EQ(report.relevant, 0);
    }
  }
}

}  // namespace simplify_lattice_test
}  // namespace ovoid
