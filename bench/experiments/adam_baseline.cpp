// SPDX-License-Identifier: Apache-2.0
#include "experiments/adam_baseline.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>
#include <utility>

#include "fit/field_slope.h"
#include "fit/fit_goal.h"
#include "fit/fit_places.h"
#include "fit/refine_kernels.h"
#include "fit/source_kernels.h"
#include "ovoid/fit.h"

namespace ovoid::experiments {
namespace {

using fit::FieldSlope;
using fit::MergedKernels;
using fit::Places;
using fit::SourceKernels;

constexpr std::size_t kTestPlaces = 100'000;
// As in the product, for each kernel.
constexpr double kPlacesPerKernel = 48;
// Of the published method.
constexpr double kBeta1 = 0.9, kBeta2 = 0.999, kEpsilon = 1e-8;
// What the rate falls to, over what it begins with.
constexpr double kLastRate = 0.01;
// Points of a curve: after these shares of the steps.
constexpr int kShares[] = {16, 4, 2, 1};

struct State {
  MergedKernels kernels;
  std::vector<std::vector<double>> values;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

State state_of(const SourceKernels& kernels) {
  State state{{kernels.centers, kernels.shapes, kernels.weights, {}}, {}};
  for (const std::vector<float>& column : kernels.values)
    state.values.emplace_back(column.begin(), column.end());
  return state;
}

// The places [begin, end).
Places part_of(const Places& places, std::size_t begin, std::size_t end) {
  const auto cut = [&](const std::vector<double>& numbers, std::size_t each) {
    return std::vector<double>(numbers.begin() + static_cast<std::ptrdiff_t>(each * begin),
                               numbers.begin() + static_cast<std::ptrdiff_t>(each * end));
  };
  Places part{cut(places.at, 3), cut(places.shares, 1), {}};
  for (const std::vector<double>& column : places.targets) part.targets.push_back(cut(column, 1));
  return part;
}

// What is refined, and against what.
class Problem {
 public:
  Problem(const Dataset& dataset, std::int64_t kernels) {
    FitOptions options;
    options.kernels = kernels;
    options.refinements = 0;
    FitReport report;
    start_ = state_of(fit::load_source_kernels(fit_kernels(dataset, options, &report), 0, {}));
    const KernelField field = make_kernel_field(dataset);
    const SourceKernels source = fit::load_source_kernels(field, 0, {});
    cutoff_ = source.cutoff;
    range_ = report.range;
    const auto maker = fit::make_place_maker(dataset, field, source, {{}, 1, 0, kTestPlaces, 0});
    test_ = maker->make().unseen;
    places_ = maker->make_evenly(start_.kernels.columns(cutoff_), kPlacesPerKernel);
  }

  const State& start() const { return start_; }
  const Places& places() const { return places_; }
  std::span<const double> ranges() const { return {&range_, 1}; }
  double cutoff() const { return cutoff_; }

  double psnr_of(const State& state) const {
    const KernelOperator rows = rows_of(state, test_);
    const std::vector<double> field = rows.gather(state.values[0]);
    double square = 0, share = 0;
    for (std::size_t k = 0; k < field.size(); ++k) {
      if (!rows.is_defined(k)) continue;
      const double error = field[k] - test_.targets[0][k];
      square += test_.shares[k] * error * error;
      share += test_.shares[k];
    }
    return fit::psnr_of(range_, square / share);
  }

  FieldSlope slope_of(const State& state, const Places& places) const {
    return {
        rows_of(state, places), state.kernels, state.values, ranges(), places.at, kHow, cutoff_, 0};
  }

  State refined(int steps) const {
    State state = start_;
    fit::refine_kernels(
        {places_, {range_}, kHow, cutoff_, KernelShape::kEllipsoids, steps, 0, {}, {}},
        state.kernels, state.values);
    return state;
  }

 private:
  static constexpr Reconstruction kHow = Reconstruction::kNormalized;

  KernelOperator rows_of(const State& state, const Places& places) const {
    return {state.kernels.columns(cutoff_), kHow, places.at};
  }

  State start_;
  Places places_, test_;
  double range_ = 0, cutoff_ = 4;
};

class Adam {
 public:
  Adam(const Problem& problem, const AdamWay& way)
      : problem_(problem),
        way_(way),
        state_(problem.start()),
        mean_(state_.kernels.weights.size() * kEach),
        square_(mean_.size()) {
    const std::size_t count = problem.places().count();
    const auto num_parts = static_cast<std::size_t>(way.parts);
    for (std::size_t p = 0; p < num_parts; ++p)
      parts_.push_back(
          part_of(problem.places(), p * count / num_parts, (p + 1) * count / num_parts));
  }

  const State& state() const { return state_; }

  void step() {
    const std::vector<double> gradient =
        gradient_at(parts_[static_cast<std::size_t>(done_) % parts_.size()]);
    ++done_;
    const double rate = way_.rate * std::pow(kLastRate, static_cast<double>(done_) / way_.steps);
    const double mean_so_far = 1 - std::pow(kBeta1, done_);
    const double square_so_far = 1 - std::pow(kBeta2, done_);
    for (std::size_t i = 0; i < state_.kernels.weights.size(); ++i) {
      double moves[kEach];
      for (std::size_t m = 0; m < kEach; ++m) {
        const double slope = gradient[i * kEach + m];
        double& mean = mean_[i * kEach + m];
        double& square = square_[i * kEach + m];
        mean += (1 - kBeta1) * (slope - mean);
        square += (1 - kBeta2) * (slope * slope - square);
        moves[m] = -rate * (mean / mean_so_far) / (std::sqrt(square / square_so_far) + kEpsilon);
      }
      fit::move_kernel(state_.kernels, i, moves, 1);
      state_.values[0][i] += moves[FieldSlope::kMoves] * problem_.ranges()[0];
    }
  }

 private:
  static constexpr std::size_t kEach = FieldSlope::kMoves + 1;

  // Of half the sum of squares, times the number of kernels: a number's is then about as large
  // however many there are.
  std::vector<double> gradient_at(const Places& places) const {
    const FieldSlope slope = problem_.slope_of(state_, places);
    double share = 0;
    for (const double of_place : places.shares) share += of_place;
    const double factor = static_cast<double>(state_.kernels.weights.size()) / share;
    std::vector<double> excess(places.count());
    for (std::size_t k = 0; k < excess.size(); ++k) {
      if (!slope.rows().is_defined(k)) continue;
      excess[k] = factor * places.shares[k] *
                  (slope.field()[k] - places.targets[0][k] / problem_.ranges()[0]);
    }
    return slope.splat(excess);
  }

  const Problem& problem_;
  AdamWay way_;
  State state_;
  int done_ = 0;
  std::vector<Places> parts_;
  std::vector<double> mean_, square_;  // of the gradient, [n, kEach]
};

RefineCurve gauss_newton(const Problem& problem, int most) {
  RefineCurve curve{"Gauss-Newton", {}};
  for (int steps = 1; steps <= most; steps *= 2) {
    const auto start = std::chrono::steady_clock::now();
    const State state = problem.refined(steps);
    curve.points.push_back({steps, seconds_since(start), problem.psnr_of(state)});
  }
  return curve;
}

RefineCurve adam(const Problem& problem, const AdamWay& way) {
  const std::string parts =
      way.parts == 1 ? "all places" : fmt::format("1/{} of the places", way.parts);
  RefineCurve curve{fmt::format("Adam, {} a step, rate {:g}", parts, way.rate), {}};
  Adam solver(problem, way);
  double seconds = 0;
  int done = 0;
  for (const int share : kShares) {
    const auto start = std::chrono::steady_clock::now();
    for (; done < way.steps / share; ++done) solver.step();
    seconds += seconds_since(start);
    curve.points.push_back({done, seconds, problem.psnr_of(solver.state())});
  }
  return curve;
}

}  // namespace

RefineComparison compare_refinement(const Dataset& dataset, const RefineOptions& options) {
  const Problem problem(dataset, options.kernels);
  RefineComparison comparison;
  comparison.kernels = static_cast<std::int64_t>(problem.start().kernels.weights.size());
  comparison.places = problem.places().count();
  comparison.start = problem.psnr_of(problem.start());
  comparison.curves.push_back(gauss_newton(problem, options.gauss_newton_steps));
  for (const AdamWay& way : options.adam) comparison.curves.push_back(adam(problem, way));
  return comparison;
}

}  // namespace ovoid::experiments
