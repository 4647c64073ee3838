// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

namespace ovoid::model {

// Gaussian ellipsoids whose weights are to be fitted. Spans are borrowed.
struct AmplitudeProblem {
  std::span<const double> centers;  // [n, 3]
  std::span<const float> shapes;    // [n, 6], as KernelShape::kEllipsoids says
  std::span<const float> targets;   // what the sum of weights should be at each centre, > 0
  double cutoff = 3.5;
  int passes = 3;
  int threads = 1;
  std::stop_token stop{};
  // The last of the kernels are others', which count in the sums but have none of their own:
  // `renew` brings their weights after each change of one's own.
  std::size_t num_others = 0;
  std::function<void(std::vector<float>& weights)> renew{};
};

// `passes` times w_i /= (F_i / target_i)^0.7 with F_i = sum_j w_j phi_j at centre i
// all at once in each pass, so that the order of kernels and threads play no part.
// Returns F after the last pass, without the others'. Cost: about a microsecond per kernel and
// pass. Throws Error(kCancelled).
std::vector<float> fit_amplitudes(const AmplitudeProblem& problem, std::vector<float>& weights);

}  // namespace ovoid::model
