// SPDX-License-Identifier: Apache-2.0
// Gauss-Newton: the field is replaced by its slope, whose least squares are solved by conjugate
// gradients; then the kernels move, and so on.
#include "fit/refine_kernels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fit/conjugate_gradients.h"
#include "fit/field_slope.h"
#include "fit/kept_sum.h"

namespace ovoid::fit {
namespace {

// Of conjugate gradients within a step.
constexpr int kStepIterations = 12;
constexpr double kLeastStepEnergy = 1e-4;
// What keeps a step short: shares of the diagonal of the normal equations, and of what the same
// change of a value, by its whole range, would have there.
constexpr double kDamping = 0.03, kRidge = 3e-3;
// A kernel's moves in one step are at most this: sigmas, or logarithms.
constexpr double kMostMove = 0.4;
// One of so many places is not fitted to.
constexpr std::size_t kPlacesPerTest = 5;
// A step is tried whole, then halved so many times.
constexpr int kMostHalves = 4;
// Steps end that lessen the sum of squares by less.
constexpr double kLeastGain = 0.01;

struct State {
  MergedKernels kernels;
  std::vector<std::vector<double>> values;
};

// A state at the places.
struct Seen {
  FieldSlope slope;
  std::vector<double> misfit;  // laid out as the slope's field; 0 where a place has no row
  // Of the places that stay out of the fit: the sum of squares, weighted by shares; the shares of
  // those that have no row.
  double square = 0, holes = 0;
};

class Refiner {
 public:
  explicit Refiner(const RefineProblem& problem)
      : problem_(problem),
        num_attributes_(problem.ranges.size()),
        num_fitted_(problem.places.count() - problem.places.count() / kPlacesPerTest),
        shares_(problem.places.shares) {
    std::fill(shares_.begin() + static_cast<std::ptrdiff_t>(num_fitted_), shares_.end(), 0.0);
  }

  void run(MergedKernels& kernels, std::vector<std::vector<double>>& values) const {
    if (problem_.places.count() < kPlacesPerTest) return;
    State state{std::move(kernels), std::move(values)};
    Seen now = look(state);
    for (int step = 0; step < problem_.steps; ++step) {
      const double before = now.square + problem_.square_of_hole * now.holes;
      const std::vector<double> change = change_for(state, now);
      double after = before;
      for (int half = 0; half <= kMostHalves && after == before; ++half) {
        State next = moved(state, change, std::exp2(-half));
        Seen then = look(next);
        const double sum = then.square + problem_.square_of_hole * then.holes;
        if (!(sum < before)) continue;
        after = sum;
        state = std::move(next);
        now = std::move(then);
      }
      if (problem_.step_done) problem_.step_done();
      if (!(after < (1 - kLeastGain) * before)) break;
    }
    kernels = std::move(state.kernels);
    values = std::move(state.values);
  }

 private:
  std::size_t numbers_per_kernel() const { return FieldSlope::kMoves + num_attributes_; }
  bool is_sum() const { return problem_.reconstruction == Reconstruction::kSum; }

  Seen look(const State& state) const {
    const std::span<const double> at = std::span(problem_.places.at);
    KernelOperator rows(state.kernels.columns(problem_.cutoff), problem_.reconstruction, at,
                        problem_.threads, problem_.stop);
    FieldSlope slope(std::move(rows), state.kernels, state.values, problem_.ranges, at,
                     problem_.reconstruction, problem_.cutoff, problem_.threads);
    Seen seen{std::move(slope), std::vector<double>(problem_.places.count() * num_attributes_)};
    for (std::size_t k = 0; k < problem_.places.count(); ++k) {
      const double share = k < num_fitted_ ? 0 : problem_.places.shares[k];
      if (!is_sum() && !seen.slope.rows().is_defined(k)) {
        seen.holes += share;
        continue;
      }
      for (std::size_t a = 0; a < num_attributes_; ++a) {
        double& misfit = seen.misfit[k * num_attributes_ + a];
        misfit = problem_.places.targets[a][k] / problem_.ranges[a] -
                 seen.slope.field()[k * num_attributes_ + a];
        seen.square += share * misfit * misfit;
      }
    }
    return seen;
  }

  // Times the places' shares in the fit.
  std::vector<double> weighted(std::vector<double> numbers) const {
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] *= shares_[i / num_attributes_];
    return numbers;
  }

  // Least squares of the slope.
  std::vector<double> change_for(const State& state, const Seen& now) const {
    const FieldSlope& slope = now.slope;
    std::vector<double> diagonal =
        slope.splat_squares(weighted(std::vector<double>(now.misfit.size(), 1.0)));
    const std::vector<double> extra = damping_of(diagonal);
    for (std::size_t i = 0; i < diagonal.size(); ++i) diagonal[i] += extra[i];
    const auto over_diagonal = [&](std::size_t i, double number) {
      return diagonal[i] > 0 ? number / diagonal[i] : 0;
    };
    const std::vector<double> integrals = integrals_of(state);
    const KeptSum kept(integrals, over_diagonal);
    const auto precondition = [&](const std::vector<double>& residual,
                                  std::vector<double>& scaled) {
      for (std::size_t i = 0; i < residual.size(); ++i) scaled[i] = over_diagonal(i, residual[i]);
      if (problem_.shape == KernelShape::kBalls) keep_round(residual, diagonal, scaled);
      kept.hold(scaled);
    };
    const auto multiply = [&](const std::vector<double>& direction, std::vector<double>& product) {
      product = slope.splat(weighted(slope.gather(direction, problem_.stop)));
      for (std::size_t i = 0; i < product.size(); ++i) product[i] += extra[i] * direction[i];
    };
    std::vector<double> change(slope.size());
    PlainSystem system(change, slope.splat(weighted(now.misfit)), multiply, precondition);
    conjugate_gradients(system, kStepIterations, kLeastStepEnergy, [](double) {});
    return change;
  }

  std::vector<double> damping_of(const std::vector<double>& diagonal) const {
    const std::size_t each = numbers_per_kernel();
    std::vector<double> extra(diagonal.size());
    for (std::size_t first = 0; first < diagonal.size(); first += each) {
      const double of_value = diagonal[first + FieldSlope::kMoves];
      for (std::size_t i = 0; i < each; ++i) {
        const double own = i < FieldSlope::kMoves ? kDamping * diagonal[first + i] : 0;
        extra[first + i] = own + kRidge * of_value;
      }
    }
    return extra;
  }

  // What the values' changes are multiplied by in the integral of a sum; empty: nothing is kept.
  std::vector<double> integrals_of(const State& state) const {
    if (!is_sum()) return {};
    const std::size_t each = numbers_per_kernel();
    std::vector<double> integrals(state.kernels.weights.size() * each);
    for (std::size_t i = 0; i < state.kernels.weights.size(); ++i) {
      integrals[i * each + FieldSlope::kMoves] = state.kernels.mass(i);
    }
    return integrals;
  }

  // The three along the diagonal are one number, and below it there is none.
  void keep_round(const std::vector<double>& residual, const std::vector<double>& diagonal,
                  std::vector<double>& scaled) const {
    const std::size_t each = numbers_per_kernel();
    for (std::size_t first = 0; first < residual.size(); first += each) {
      double sum = 0, of_diagonal = 0;
      for (const std::size_t move : FieldSlope::kDiagonal) {
        sum += residual[first + move];
        of_diagonal += diagonal[first + move];
      }
      for (std::size_t move = FieldSlope::kDiagonal[0]; move < FieldSlope::kWeight; ++move)
        scaled[first + move] = 0;
      for (const std::size_t move : FieldSlope::kDiagonal)
        scaled[first + move] = of_diagonal > 0 ? sum / of_diagonal : 0;
    }
  }

  State moved(const State& state, const std::vector<double>& change, double length) const {
    const std::size_t each = numbers_per_kernel();
    State next = state;
    for (std::size_t i = 0; i < next.kernels.weights.size(); ++i) {
      const double* const numbers = change.data() + i * each;
      double most = 0;
      for (std::size_t m = 0; m < FieldSlope::kMoves; ++m)
        most = std::max(most, std::abs(numbers[m]));
      move_kernel(next.kernels, i, numbers, std::min(length, kMostMove / most));
      for (std::size_t a = 0; a < num_attributes_; ++a) {
        double& value = next.values[a][i];
        value += length * numbers[FieldSlope::kMoves + a] * problem_.ranges[a];
        if (is_sum()) value *= state.kernels.mass(i) / next.kernels.mass(i);
      }
    }
    return next;
  }

  const RefineProblem& problem_;
  std::size_t num_attributes_;
  std::size_t num_fitted_;      // the first so many places
  std::vector<double> shares_;  // in the fit: 0 of places that stay out
};

}  // namespace

void refine_kernels(const RefineProblem& problem, MergedKernels& kernels,
                    std::vector<std::vector<double>>& values) {
  Refiner(problem).run(kernels, values);
}

}  // namespace ovoid::fit
