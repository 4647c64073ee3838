// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <string>
#include <vector>

#include "model/lattice/noise.h"
#include "ovoid/error.h"
#include "ovoid/fit.h"

namespace ovoid {
namespace kernel_operator_test {

// Ellipsoids at random in a box of that side, near enough for each other to be reached.
struct RandomKernels {
  std::vector<double> centers, places;
  std::vector<float> shapes, weights, values;

  explicit RandomKernels(int count, double side = 4, std::uint64_t seed = 7) {
    model::Random random(seed);
    for (int i = 0; i < count; ++i) {
      for (int a = 0; a < 3; ++a) centers.push_back(random.uniform(0, side));
      for (const double number :
           {random.uniform(0.3, 0.8), random.uniform(-0.2, 0.2), random.uniform(0.3, 0.8),
            random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), random.uniform(0.3, 0.8)})
        shapes.push_back(static_cast<float>(number));
      weights.push_back(static_cast<float>(random.uniform(0.5, 1.5)));
      values.push_back(static_cast<float>(random.uniform(-1, 1)));
    }
    for (int i = 0; i < 3 * 5000; ++i) places.push_back(random.uniform(-1, side + 1));
  }

  KernelColumns columns() const {
    KernelColumns columns;
    columns.shape = KernelShape::kEllipsoids;
    columns.cutoff = 3.5;
    columns.centers = centers;
    columns.shapes = shapes;
    columns.weights = weights;
    return columns;
  }
  KernelField field(Reconstruction reconstruction) const {
    KernelColumns all = columns();
    all.values.emplace_back(values);
    all.attributes.push_back({"v", "", {}});
    return {make_kernel_source(all), reconstruction};
  }
  std::vector<double> doubles() const { return {values.begin(), values.end()}; }
};

// Fails if a kernel in reach is not found, if a profile ends elsewhere than the sampler's, or if
// rows go to other places.
TEST(KernelOperator, GathersWhatTheSamplerSays) {
  const RandomKernels kernels(300);
  for (const Reconstruction how : {Reconstruction::kNormalized, Reconstruction::kSum}) {
    const KernelOperator op(kernels.columns(), how, kernels.places);
    const KernelSampler sampler(kernels.field(how));
    const std::vector<double> values = op.gather(kernels.doubles());
    ASSERT_EQ(op.num_places(), kernels.places.size() / 3);
    int undefined = 0;
    for (std::size_t k = 0; k < op.num_places(); ++k) {
      const KernelSample sample = sampler.at(Vec3(kernels.places.data() + 3 * k));
      EXPECT_NEAR(static_cast<double>(op.weights()[k]), sample.weight, 2e-5);
      if (how == Reconstruction::kNormalized && std::abs(sample.weight - 0.2) < 1e-4) continue;
      EXPECT_NEAR(values[k], sample.value, 5e-5) << k;
      if (how == Reconstruction::kNormalized) {
        EXPECT_EQ(op.is_defined(k), sample.is_defined);
        undefined += sample.is_defined ? 0 : 1;
      }
    }
    if (how == Reconstruction::kNormalized) {
      EXPECT_GT(undefined, 100);  // the box of the places is wider than the kernels'
    }
  }
}

// <R v, r> = <v, R^T r>; and the diagonal is that of R^T D R.
TEST(KernelOperator, SplatIsTheTransposeOfGather) {
  const RandomKernels kernels(200);
  const KernelOperator op(kernels.columns(), Reconstruction::kNormalized, kernels.places);
  model::Random random(3);
  std::vector<double> numbers(op.num_places());
  for (double& number : numbers) number = random.uniform(-1, 1);
  const std::vector<double> gathered = op.gather(kernels.doubles()), splat = op.splat(numbers);
  double left = 0, right = 0;
  for (std::size_t k = 0; k < numbers.size(); ++k) left += gathered[k] * numbers[k];
  for (std::size_t i = 0; i < splat.size(); ++i) right += splat[i] * kernels.doubles()[i];
  EXPECT_NEAR(left, right, 1e-6);
  std::vector<double> one(op.num_kernels());
  one[17] = 1;
  double square = 0;
  for (std::size_t k = 0; const double entry : op.gather(one))
    square += entry * entry * numbers[k++];
  EXPECT_NEAR(op.splat_squares(numbers)[17], square, 1e-9);
}

TEST(KernelOperator, ThreadsLeaveNoTrace) {
  const RandomKernels kernels(300);
  const auto products = [&](int threads) {
    const KernelOperator op(kernels.columns(), Reconstruction::kNormalized, kernels.places,
                            threads);
    const std::vector<double> gathered = op.gather(kernels.doubles());
    return std::pair(gathered, op.splat(gathered));
  };
  const auto of_one = products(1);
  for (const int threads : {2, 5}) EXPECT_EQ(products(threads), of_one);
}

// Of a lattice's kernels exp(-2 r^2), whole sums: a pattern that changes its sign from sample to
// sample along every axis comes out 0.189 times what a constant does [METHOD 7.3], so that a step
// of Richardson's leaves 0.811 of it; and 0.473 times on a body-centred lattice, whose worst
// pattern has its sign by sublattice.
TEST(KernelOperator, HasTheSymbolOfTheLattice) {
  for (const bool is_body_centred : {false, true}) {
    std::vector<double> centers, pattern;
    // Body-centred: two Cartesian lattices of spacing sqrt(2), half of it apart.
    const double edge = is_body_centred ? std::sqrt(2.0) : 1.0;
    for (int s = 0; s < (is_body_centred ? 2 : 1); ++s) {
      for (int k = 0; k < 13; ++k) {
        for (int j = 0; j < 13; ++j) {
          for (int i = 0; i < 13; ++i) {
            for (const int at : {i, j, k}) centers.push_back(edge * (at + 0.5 * s));
            pattern.push_back(is_body_centred ? 1 - 2 * s : 1 - 2 * ((i + j + k) % 2));
          }
        }
      }
    }
    const std::vector<float> shape = {0.5F, 0, 0.5F, 0, 0, 0.5F}, weight = {1};
    KernelColumns columns;
    columns.shape = KernelShape::kEllipsoids;
    columns.cutoff = 8;
    columns.centers = centers;
    columns.shapes = shape;
    columns.weights = weight;
    const KernelOperator op(columns, Reconstruction::kSum, centers);
    const std::size_t middle = 6 + 13 * (6 + 13 * 6);
    const double constant = op.gather(std::vector<double>(pattern.size(), 1.0))[middle];
    const double worst = op.gather(pattern)[middle];
    EXPECT_NEAR(worst / constant, is_body_centred ? 0.473 : 0.189, 5e-4);
  }
}

// Against the normal equations, written out and solved directly.
TEST(FitValues, AgreesWithADirectSolution) {
  const RandomKernels kernels(60, 3);
  const KernelOperator op(kernels.columns(), Reconstruction::kNormalized, kernels.places);
  model::Random random(5);
  std::vector<double> targets, shares;
  for (std::size_t k = 0; k < op.num_places(); ++k) {
    targets.push_back(std::sin(kernels.places[3 * k]) + random.uniform(-0.1, 0.1));
    shares.push_back(random.uniform(0.5, 1.5));
  }
  constexpr double kRidge = 1e-3;
  const auto count = static_cast<Eigen::Index>(op.num_kernels());
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(op.num_places()), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    std::vector<double> one(op.num_kernels());
    one[static_cast<std::size_t>(i)] = 1;
    const std::vector<double> column = op.gather(one);
    rows.col(i) = Eigen::VectorXd::Map(column.data(), rows.rows());
  }
  Eigen::VectorXd goal = Eigen::VectorXd::Map(targets.data(), rows.rows());
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    if (!op.is_defined(static_cast<std::size_t>(k))) goal[k] = 0;
  }
  const auto share = Eigen::VectorXd::Map(shares.data(), rows.rows()).asDiagonal();
  const std::vector<double> start = kernels.doubles();
  const auto begin = Eigen::VectorXd::Map(start.data(), count);
  const Eigen::MatrixXd normal = rows.transpose() * share * rows;
  const Eigen::VectorXd ridge = kRidge * normal.diagonal();
  const Eigen::VectorXd expected =
      (normal + Eigen::MatrixXd(ridge.asDiagonal()))
          .ldlt()
          .solve(rows.transpose() * share * goal + ridge.cwiseProduct(begin));
  std::vector<double> values = start;
  const ValueSolution solution = fit_values(op,
                                            {.targets = targets,
                                             .shares = shares,
                                             .ridge = kRidge,
                                             .iterations = 500,
                                             .tolerance = 1e-10},
                                            values);
  EXPECT_LT(solution.residual_norms.back(), 1e-10);
  for (Eigen::Index i = 0; i < count; ++i)
    EXPECT_NEAR(values[static_cast<std::size_t>(i)], expected[i], 1e-5);
}

// What is kept is kept to rounding, and costs little.
TEST(FitValues, KeepsASum) {
  const RandomKernels kernels(60, 3);
  const KernelOperator op(kernels.columns(), Reconstruction::kSum, kernels.places);
  const std::vector<double> targets(op.num_places(), 1.0), shares(op.num_places(), 1.0);
  std::vector<double> keeps;
  for (int i = 0; i < 60; ++i) keeps.push_back(0.1 + 0.01 * i);
  const auto sum = [&](const std::vector<double>& values) {
    double all = 0;
    for (std::size_t i = 0; i < values.size(); ++i) all += keeps[i] * values[i];
    return all;
  };
  const auto error = [&](const std::vector<double>& values) {
    double square = 0;
    for (const double value : op.gather(values)) square += (value - 1) * (value - 1);
    return square;
  };
  const std::vector<double> start(60, 0.7);
  std::vector<double> values = start, free = start;
  fit_values(op, {.targets = targets, .shares = shares, .keeps = keeps}, values);
  fit_values(op, {.targets = targets, .shares = shares}, free);
  EXPECT_NEAR(sum(values), sum(start), 1e-9);
  EXPECT_GT(std::abs(sum(free) - sum(start)), 0.1);
  EXPECT_LT(error(values), error(start));
  EXPECT_LE(error(free), error(values));
}

void expect_refused(const KernelColumns& columns, const std::vector<double>& places,
                    const std::string& words) {
  try {
    const KernelOperator op(columns, Reconstruction::kSum, places);
    FAIL() << words;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

TEST(KernelOperator, RefusesWhatIsNoKernelOrPlace) {
  const RandomKernels kernels(4);
  std::vector<double> places = {0, 0, 0};
  expect_refused({}, places, "holds no kernels");
  places[1] = std::nan("");
  expect_refused(kernels.columns(), places, "places[0]");
  places = {0, 0};
  expect_refused(kernels.columns(), places, "places");
  places = {0, 0, 0};
  KernelColumns columns = kernels.columns();
  columns.profile = KernelProfile::kWendlandC2;
  expect_refused(columns, places, "profile");
  columns = kernels.columns();
  columns.cutoff = 20;
  expect_refused(columns, places, "cutoff = 20");
  std::vector<float> shapes = kernels.shapes;
  shapes[8] = 0;
  columns = kernels.columns();
  columns.shapes = shapes;
  expect_refused(columns, places, "shapes[1]");
  const KernelOperator op(kernels.columns(), Reconstruction::kSum, places);
  EXPECT_THROW(op.gather(std::vector<double>(3)), Error);
  EXPECT_THROW(op.splat(std::vector<double>(3)), Error);
}

}  // namespace kernel_operator_test
}  // namespace ovoid
