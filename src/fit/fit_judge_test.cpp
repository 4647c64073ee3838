// SPDX-License-Identifier: Apache-2.0
#include "fit/fit_judge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "model/test_datasets.h"

namespace ovoid::fit {
namespace fit_judge_test {

// A row of sixteen particles, a unit apart, of values 0 to 15, and its kernels.
struct Row {
  Row() {
    std::vector<Vec3> points;
    std::vector<float> values;
    for (int i = 0; i < 16; ++i) {
      points.emplace_back(i, 0, 0);
      values.push_back(static_cast<float>(i));
    }
    dataset = model::points_dataset(DatasetKind::kParticles, points, values);
    field = make_kernel_field(dataset);
    source = load_source_kernels(field, 1, {});
  }
  FitJudge judge() const { return {field, source, 15, 1, stop}; }

  Dataset dataset;
  KernelField field;
  SourceKernels source;
  std::stop_token stop;
};

// The kernels of the row's first half alone, as they are.
MergedKernels first_half(const SourceKernels& source, std::vector<double>& values) {
  MergedKernels kernels;
  for (std::size_t i = 0; i < source.count(); ++i) {
    if (source.center(i)[0] > 7.5) continue;
    for (int a = 0; a < 3; ++a) kernels.centers.push_back(source.center(i)[a]);
    for (std::size_t n = 0; n < 6; ++n) kernels.shapes.push_back(source.shapes[6 * i + n]);
    kernels.weights.push_back(source.weights[i]);
    values.push_back(static_cast<double>(source.values[0][i]));
  }
  return kernels;
}

Places at_centers(const SourceKernels& source) {
  Places places;
  places.at = source.centers;
  places.shares.assign(source.count(), 1 / static_cast<double>(source.count()));
  places.sites.resize(source.count());
  std::iota(places.sites.begin(), places.sites.end(), 0U);
  places.targets.emplace_back(source.values[0].begin(), source.values[0].end());
  return places;
}

// Fails if a hole does not count, or as something else than the values' deviation.
TEST(FitJudge, HolesCount) {
  const Row row;
  const FitJudge judge = row.judge();
  EXPECT_NEAR(judge.deviation(), std::sqrt((16 * 16 - 1) / 12.0), 1.2);  // ends stand for more
  std::vector<double> values;
  const MergedKernels half = first_half(row.source, values);
  const Places places = at_centers(row.source);
  const std::vector<double> errors = judge.errors(places, {half, values});
  double holes = 0, square = 0;
  for (const double error : errors) {
    holes += std::isinf(error) ? 1 : 0;
    square += std::isinf(error) ? judge.deviation() * judge.deviation() : error * error;
  }
  EXPECT_GE(holes, 4);
  EXPECT_LE(holes, 8);
  const FitJudge::Errors sum = judge.sum_up(places, {half, values});
  EXPECT_NEAR(sum.mean_square, square / 16, 1e-9);
  EXPECT_LT(sum.greatest, 8);
}

// Fails if the kernel beside the holes is not the one that is widened, or not far enough.
TEST(FitJudge, HolesAreClosedByTheNearestKernel) {
  const Row row;
  std::vector<double> values;
  MergedKernels half = first_half(row.source, values);
  const MergedKernels before = half;
  Places places;
  for (std::size_t i = 0; i < row.source.count(); ++i) {
    if (row.source.center(i)[0] > 13.5) continue;
    for (int a = 0; a < 3; ++a) places.at.push_back(row.source.center(i)[a]);
  }
  const FitJudge judge = row.judge();
  ASSERT_TRUE(judge.close_holes(places, half));
  EXPECT_FALSE(judge.close_holes(places, half));
  for (std::size_t i = 0; i < half.weights.size(); ++i) {
    const bool is_last = half.centers[3 * i] > 6.5;
    EXPECT_EQ(half.weights[i] > before.weights[i], is_last) << half.centers[3 * i];
  }
}

}  // namespace fit_judge_test
}  // namespace ovoid::fit
