// SPDX-License-Identifier: Apache-2.0
// Conjugate gradients on the normal equations of ValueProblem. The unknown is how far values leave
// their start, so that the ridge is a multiple of the diagonal.
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "fit/conjugate_gradients.h"
#include "fit/kept_sum.h"
#include "ovoid/error.h"
#include "ovoid/fit.h"

namespace ovoid {
namespace {

void require_problem(const KernelOperator& kernels, const ValueProblem& problem,
                     const std::vector<double>& values) {
  const auto require = [](const char* name, std::size_t length, std::size_t expected) {
    if (length != expected)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: has {} numbers, expected {}", name, length, expected));
  };
  require("targets", problem.targets.size(), kernels.num_places());
  require("shares", problem.shares.size(), kernels.num_places());
  require("values", values.size(), kernels.num_kernels());
  if (!problem.keeps.empty()) require("keeps", problem.keeps.size(), kernels.num_kernels());
  if (!(problem.ridge > 0) || !std::isfinite(problem.ridge))
    throw Error(ErrorCode::kInvalidArgument, fmt::format("ridge = {}: must be > 0", problem.ridge));
  if (problem.iterations < 0)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("iterations = {}: must be 0 or more", problem.iterations));
}

// The transpose of the operator, on residuals weighted by the places' shares.
std::vector<double> weighted_splat(const KernelOperator& kernels, const ValueProblem& problem,
                                   std::vector<double> residuals) {
  for (std::size_t k = 0; k < residuals.size(); ++k) residuals[k] *= problem.shares[k];
  return kernels.splat(residuals);
}

}  // namespace

ValueSolution fit_values(const KernelOperator& kernels, const ValueProblem& problem,
                         std::vector<double>& values, const std::stop_token& stop) {
  require_problem(kernels, problem, values);
  const std::vector<double> diagonal = kernels.splat_squares(problem.shares);
  std::vector<double> misfit = kernels.gather(values);
  for (std::size_t k = 0; k < misfit.size(); ++k)
    misfit[k] = kernels.is_defined(k) ? problem.targets[k] - misfit[k] : 0;
  // Kernels that no place knows of stay as they are.
  const auto over_diagonal = [&](std::size_t i, double number) {
    return diagonal[i] > 0 ? number / ((1 + problem.ridge) * diagonal[i]) : 0;
  };
  const fit::KeptSum kept(problem.keeps, over_diagonal);
  const auto precondition = [&](const std::vector<double>& residual, std::vector<double>& scaled) {
    for (std::size_t i = 0; i < residual.size(); ++i) scaled[i] = over_diagonal(i, residual[i]);
    kept.hold(scaled);
  };
  const auto multiply = [&](const std::vector<double>& direction, std::vector<double>& product) {
    if (stop.stop_requested()) throw Error(ErrorCode::kCancelled, "the fit was stopped");
    product = weighted_splat(kernels, problem, kernels.gather(direction));
    for (std::size_t i = 0; i < product.size(); ++i)
      product[i] += problem.ridge * diagonal[i] * direction[i];
  };
  fit::PlainSystem system(values, weighted_splat(kernels, problem, std::move(misfit)), multiply,
                          precondition);
  ValueSolution solution;
  solution.residual_norms.push_back(1);
  solution.iterations = fit::conjugate_gradients(
      system, problem.iterations, problem.tolerance * problem.tolerance,
      [&](double energy) { solution.residual_norms.push_back(std::sqrt(energy)); });
  return solution;
}

}  // namespace ovoid
