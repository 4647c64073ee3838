// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace ovoid::fit {

// Takes of a direction, in the metric of the preconditioner, what would change the sum that is
// kept: conjugate gradients then run among the values that have it.
class KeptSum {
 public:
  // `keeps`: what each number counts in the sum; empty: nothing is kept. Borrowed.
  template <class OverDiagonal>
  KeptSum(std::span<const double> keeps, const OverDiagonal& over_diagonal) : keeps_(keeps) {
    for (std::size_t i = 0; i < keeps.size(); ++i) {
      scaled_.push_back(over_diagonal(i, keeps[i]));
      square_ += keeps[i] * scaled_[i];
    }
  }
  void hold(std::vector<double>& direction) const {
    if (!(square_ > 0)) return;
    double change = 0;
    for (std::size_t i = 0; i < direction.size(); ++i) change += keeps_[i] * direction[i];
    for (std::size_t i = 0; i < direction.size(); ++i)
      direction[i] -= change / square_ * scaled_[i];
  }

 private:
  std::span<const double> keeps_;
  std::vector<double> scaled_;
  double square_ = 0;
};

}  // namespace ovoid::fit
