// SPDX-License-Identifier: Apache-2.0
#include "fit/refine_kernels.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

#include "fit/field_slope.h"
#include "model/lattice/noise.h"
#include "ovoid/error.h"

namespace ovoid::fit {
namespace refine_kernels_test {

constexpr double kCutoff = 4;
using Values = std::vector<std::vector<double>>;

// Kernels at random in a cube of side 4, of all shapes, that overlap.
MergedKernels some_kernels(std::size_t count, std::uint64_t seed) {
  model::Random random(seed);
  MergedKernels kernels;
  for (std::size_t i = 0; i < count; ++i) {
    for (int a = 0; a < 3; ++a) kernels.centers.push_back(random.uniform(0, 4));
    for (int number = 0; number < 6; ++number) {
      const bool is_diagonal = number == 0 || number == 2 || number == 5;
      kernels.shapes.push_back(
          static_cast<float>(is_diagonal ? random.uniform(1.2, 2) : random.uniform(-0.4, 0.4)));
    }
    kernels.weights.push_back(static_cast<float>(random.uniform(0.5, 1.5)));
  }
  return kernels;
}

Values some_values(std::size_t num_attributes, std::size_t count, std::uint64_t seed) {
  model::Random random(seed);
  Values values(num_attributes, std::vector<double>(count));
  for (std::vector<double>& column : values) {
    for (double& value : column) value = random.uniform(1, 3);
  }
  return values;
}

Places random_places(std::size_t count, std::uint64_t seed) {
  model::Random random(seed);
  Places places;
  for (std::size_t k = 0; k < 3 * count; ++k) places.at.push_back(random.uniform(0, 4));
  places.shares.assign(count, 1 / static_cast<double>(count));
  return places;
}

KernelOperator rows_of(const MergedKernels& kernels, Reconstruction reconstruction,
                       const Places& places, int threads = 1) {
  return {kernels.columns(kCutoff), reconstruction, places.at, threads};
}

double det_of(const MergedKernels& kernels, std::size_t i) {
  const float* const l = kernels.shapes.data() + 6 * i;
  return static_cast<double>(l[0]) * static_cast<double>(l[2]) * static_cast<double>(l[5]);
}

// The kernels after `moves`, as FieldSlope defines them, to first order.
void move(MergedKernels& kernels, Values& values, std::span<const double> ranges,
          Reconstruction reconstruction, const std::vector<double>& moves) {
  const std::size_t each = FieldSlope::kMoves + ranges.size();
  for (std::size_t i = 0; i < kernels.weights.size(); ++i) {
    const double* const m = moves.data() + i * each;
    float* const l = kernels.shapes.data() + 6 * i;
    const double before = det_of(kernels, i);
    Mat3 factor, growth;
    factor << l[0], 0, 0, l[1], l[2], 0, l[3], l[4], l[5];
    growth << 1 + m[3], 0, 0, m[4], 1 + m[5], 0, m[6], m[7], 1 + m[8];
    const Vec3 shift = factor * Vec3(m[0], m[1], m[2]);
    for (int a = 0; a < 3; ++a) kernels.centers[3 * i + static_cast<std::size_t>(a)] += shift[a];
    const Mat3 grown = factor * growth;
    for (int row = 0, number = 0; row < 3; ++row) {
      for (int column = 0; column <= row; ++column)
        l[number++] = static_cast<float>(grown(row, column));
    }
    const bool is_sum = reconstruction == Reconstruction::kSum;
    if (!is_sum) kernels.weights[i] *= static_cast<float>(1 + m[FieldSlope::kWeight]);
    for (std::size_t a = 0; a < ranges.size(); ++a) {
      values[a][i] += m[FieldSlope::kMoves + a] * ranges[a];
      if (is_sum) values[a][i] *= before / det_of(kernels, i);
    }
  }
}

class FieldSlopes : public testing::TestWithParam<Reconstruction> {};

// The slope is what differences of fields are, for every number of every kernel.
TEST_P(FieldSlopes, AreDifferences) {
  const MergedKernels kernels = some_kernels(4, 1);
  const Values values = some_values(2, 4, 2);
  const std::vector<double> ranges = {2, 0.5};
  const Places places = random_places(60, 3);
  const FieldSlope slope(rows_of(kernels, GetParam(), places), kernels, values, ranges, places.at,
                         GetParam(), kCutoff, 1);
  constexpr double kStep = 2e-3;  // shapes and entries are floats
  const auto field_of = [&](std::size_t number, double step) {
    MergedKernels moved = kernels;
    Values moved_values = values;
    std::vector<double> moves(slope.size());
    moves[number] = step;
    move(moved, moved_values, ranges, GetParam(), moves);
    const KernelOperator rows = rows_of(moved, GetParam(), places);
    return std::array{rows.gather(moved_values[0]), rows.gather(moved_values[1])};
  };
  for (std::size_t number = 0; number < slope.size(); ++number) {
    const auto after = field_of(number, kStep), before = field_of(number, -kStep);
    std::vector<double> unit(slope.size());
    unit[number] = 1;
    const std::vector<double> expected = slope.gather(unit, {});
    for (std::size_t k = 0; k < places.count(); ++k) {
      for (std::size_t a = 0; a < 2; ++a) {
        const double difference = (after[a][k] - before[a][k]) / (2 * kStep * ranges[a]);
        EXPECT_NEAR(expected[2 * k + a], difference, 2e-3)
            << "number " << number << " place " << k << " attribute " << a;
      }
    }
  }
}

TEST_P(FieldSlopes, SplatIsTheTransposeOfGather) {
  const MergedKernels kernels = some_kernels(30, 4);
  const Values values = some_values(2, 30, 5);
  const std::vector<double> ranges = {2, 0.5};
  const Places places = random_places(5000, 6);
  const FieldSlope slope(rows_of(kernels, GetParam(), places, 2), kernels, values, ranges,
                         places.at, GetParam(), kCutoff, 2);
  model::Random random(7);
  std::vector<double> change(slope.size()), numbers(slope.field().size());
  for (double& number : change) number = random.uniform(-1, 1);
  for (double& number : numbers) number = random.uniform(-1, 1);
  const std::vector<double> gathered = slope.gather(change, {}), splat = slope.splat(numbers);
  double of_places = 0, of_kernels = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i) of_places += numbers[i] * gathered[i];
  for (std::size_t i = 0; i < change.size(); ++i) of_kernels += change[i] * splat[i];
  EXPECT_NEAR(of_places, of_kernels, 1e-9 * std::abs(of_places));
  // The squares are those of single numbers.
  const std::vector<double> squares = slope.splat_squares(std::vector<double>(numbers.size(), 1.0));
  for (const std::size_t number : {0, 4, 9, 10, 11, 150}) {
    std::vector<double> unit(slope.size());
    unit[number] = 1;
    double square = 0;
    for (const double entry : slope.gather(unit, {})) square += entry * entry;
    EXPECT_NEAR(squares[number], square, 1e-9 * square);
  }
}

INSTANTIATE_TEST_SUITE_P(Both, FieldSlopes,
                         testing::Values(Reconstruction::kNormalized, Reconstruction::kSum),
                         [](const auto& info) {
                           return info.param == Reconstruction::kSum ? "Sum" : "Normalized";
                         });

// Kernels that make a field, the same ones a little off, and places that both reach.
struct Displaced {
  MergedKernels truth, kernels;
  Values values;
  Places places;
};

Displaced displaced(Reconstruction reconstruction, std::size_t count) {
  Displaced all;
  all.truth = some_kernels(count, 11);
  const Values values = some_values(1, count, 12);
  all.kernels = all.truth;
  all.values = values;
  model::Random random(14);
  std::vector<double> moves((FieldSlope::kMoves + 1) * count);
  for (double& number : moves) number = random.uniform(-0.25, 0.25);
  move(all.kernels, all.values, std::vector<double>{1}, reconstruction, moves);
  const Places places = random_places(200 * count, 13);
  const KernelOperator of_truth = rows_of(all.truth, reconstruction, places),
                       of_moved = rows_of(all.kernels, reconstruction, places);
  const std::vector<double> targets = of_truth.gather(values[0]);
  all.places.targets.resize(1);
  for (std::size_t k = 0; k < places.count(); ++k) {
    if (!of_truth.is_defined(k) || !of_moved.is_defined(k)) continue;
    for (std::size_t a = 0; a < 3; ++a) all.places.at.push_back(places.at[3 * k + a]);
    all.places.shares.push_back(places.shares[k]);
    all.places.targets[0].push_back(targets[k]);
  }
  return all;
}

double rms(const MergedKernels& kernels, const Values& values, Reconstruction reconstruction,
           const Places& places) {
  const std::vector<double> field = rows_of(kernels, reconstruction, places).gather(values[0]);
  double square = 0;
  for (std::size_t k = 0; k < field.size(); ++k)
    square += (field[k] - places.targets[0][k]) * (field[k] - places.targets[0][k]);
  return std::sqrt(square / static_cast<double>(field.size()));
}

RefineProblem problem_of(const Places& places, Reconstruction reconstruction, int steps) {
  return {.places = places,
          .ranges = {1},
          .reconstruction = reconstruction,
          .cutoff = kCutoff,
          .shape = KernelShape::kEllipsoids,
          .steps = steps,
          .threads = 2};
}

double integral(const MergedKernels& kernels, const Values& values) {
  double sum = 0;
  for (std::size_t i = 0; i < kernels.weights.size(); ++i)
    sum += static_cast<double>(kernels.weights[i]) * det_of(kernels, i) * values[0][i];
  return sum;
}

// Fails if steps do not find kernels again that were moved, or a sum's integral changes.
TEST(RefineKernels, FindsWhatMadeTheField) {
  for (const Reconstruction reconstruction : {Reconstruction::kNormalized, Reconstruction::kSum}) {
    Displaced all = displaced(reconstruction, 8);
    const double before = rms(all.kernels, all.values, reconstruction, all.places);
    const double mass = integral(all.kernels, all.values);
    refine_kernels(problem_of(all.places, reconstruction, 12), all.kernels, all.values);
    const double after = rms(all.kernels, all.values, reconstruction, all.places);
    EXPECT_GT(before, 0.02);
    EXPECT_LT(after, before / 20);
    if (reconstruction == Reconstruction::kSum) {
      EXPECT_NEAR(integral(all.kernels, all.values), mass, 1e-4 * mass);
    }
  }
}

TEST(RefineKernels, ThreadsLeaveNoTrace) {
  const Displaced all = displaced(Reconstruction::kNormalized, 20);
  MergedKernels first;
  for (const int threads : {1, 3}) {
    MergedKernels kernels = all.kernels;
    Values values = all.values;
    RefineProblem problem = problem_of(all.places, Reconstruction::kNormalized, 2);
    problem.threads = threads;
    refine_kernels(problem, kernels, values);
    if (threads == 1) {
      first = kernels;
      continue;
    }
    EXPECT_EQ(kernels.centers, first.centers);
    EXPECT_EQ(kernels.shapes, first.shapes);
    EXPECT_EQ(kernels.weights, first.weights);
  }
}

TEST(RefineKernels, BallsStayBalls) {
  Displaced all = displaced(Reconstruction::kNormalized, 8);
  for (std::size_t i = 0; i < 8; ++i) {
    float* const l = all.kernels.shapes.data() + 6 * i;
    l[1] = l[3] = l[4] = 0;
    l[2] = l[5] = l[0];
  }
  const MergedKernels before = all.kernels;
  const double error = rms(all.kernels, all.values, Reconstruction::kNormalized, all.places);
  RefineProblem problem = problem_of(all.places, Reconstruction::kNormalized, 6);
  problem.shape = KernelShape::kBalls;
  refine_kernels(problem, all.kernels, all.values);
  EXPECT_LT(rms(all.kernels, all.values, Reconstruction::kNormalized, all.places), error / 1.5);
  EXPECT_NE(all.kernels.shapes, before.shapes);
  for (std::size_t i = 0; i < 8; ++i) {
    const float* const l = all.kernels.shapes.data() + 6 * i;
    EXPECT_EQ(l[1], 0);
    EXPECT_EQ(l[3], 0);
    EXPECT_EQ(l[4], 0);
    EXPECT_EQ(l[2], l[0]);
    EXPECT_EQ(l[5], l[0]);
  }
}

// A place that no kernel reaches any more counts: kernels do not let go of the border.
TEST(RefineKernels, PlacesStayReached) {
  Displaced all = displaced(Reconstruction::kNormalized, 8);
  const auto num_empty = [&] {
    const KernelOperator rows = rows_of(all.kernels, Reconstruction::kNormalized, all.places);
    int empty = 0;
    for (std::size_t k = 0; k < all.places.count(); ++k) empty += rows.is_defined(k) ? 0 : 1;
    return empty;
  };
  const int before = num_empty();
  refine_kernels(problem_of(all.places, Reconstruction::kNormalized, 6), all.kernels, all.values);
  EXPECT_LE(num_empty(), before + 2);
}

// The same least squares for a solver that knows neither kernels nor slopes.
struct Oracle {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  const Displaced& all;
  int num_inputs;

  int inputs() const { return num_inputs; }
  int values() const { return static_cast<int>(all.places.count()); }
  // Centres (3), factors (6), logarithms of weights and values (2), in double precision.
  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& misfit) const {
    for (std::size_t k = 0; k < all.places.count(); ++k) {
      double sum = 0, weights = 0;
      for (Eigen::Index i = 0; i < x.size(); i += 11) {
        Mat3 factor;
        factor << x[i + 3], 0, 0, x[i + 4], x[i + 5], 0, x[i + 6], x[i + 7], x[i + 8];
        const Vec3 u = factor.triangularView<Eigen::Lower>().solve(
            Vec3(all.places.at.data() + 3 * k) - x.segment<3>(i));
        const double weight =
            std::exp(x[i + 9]) * profile_value(KernelProfile::kGaussian, u.norm(), kCutoff);
        sum += weight * x[i + 10];
        weights += weight;
      }
      misfit[static_cast<Eigen::Index>(k)] = all.places.targets[0][k] - sum / weights;
    }
    return 0;
  }
};

// Three kernels for the field of eight: no step that Levenberg and Marquardt know gets lower by
// more than a few per cent.
TEST(RefineKernels, AgreesWithLevenbergMarquardt) {
  const Displaced source = displaced(Reconstruction::kNormalized, 8);
  Displaced all;
  all.places = source.places;
  all.kernels = some_kernels(3, 21);
  all.values = some_values(1, 3, 22);
  Eigen::VectorXd x(33);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t n = 0; n < 3; ++n)
      x[static_cast<Eigen::Index>(11 * i + n)] = all.kernels.centers[3 * i + n];
    for (std::size_t n = 0; n < 6; ++n)
      x[static_cast<Eigen::Index>(11 * i + 3 + n)] =
          static_cast<double>(all.kernels.shapes[6 * i + n]);
    x[static_cast<Eigen::Index>(11 * i + 9)] =
        std::log(static_cast<double>(all.kernels.weights[i]));
    x[static_cast<Eigen::Index>(11 * i + 10)] = all.values[0][i];
  }
  const double start = rms(all.kernels, all.values, Reconstruction::kNormalized, all.places);
  refine_kernels(problem_of(all.places, Reconstruction::kNormalized, 60), all.kernels, all.values);
  const double ours = rms(all.kernels, all.values, Reconstruction::kNormalized, all.places);

  Eigen::NumericalDiff<Oracle> oracle(Oracle{all, 33});
  Eigen::LevenbergMarquardt<Eigen::NumericalDiff<Oracle>> solver(oracle);
  solver.minimize(x);
  Eigen::VectorXd misfit(static_cast<Eigen::Index>(all.places.count()));
  oracle(x, misfit);
  const double theirs = misfit.norm() / std::sqrt(static_cast<double>(misfit.size()));
  EXPECT_LT(ours, 0.5 * start);
  EXPECT_LT(ours, 1.1 * theirs);
}

TEST(RefineKernels, StopsWhenItIsTold) {
  Displaced all = displaced(Reconstruction::kNormalized, 8);
  std::stop_source stop;
  RefineProblem problem = problem_of(all.places, Reconstruction::kNormalized, 50);
  problem.stop = stop.get_token();
  int steps = 0;
  problem.step_done = [&] {
    if (++steps == 2) stop.request_stop();
  };
  EXPECT_THROW(refine_kernels(problem, all.kernels, all.values), Error);
  EXPECT_EQ(steps, 2);
}

}  // namespace refine_kernels_test
}  // namespace ovoid::fit
