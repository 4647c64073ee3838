// SPDX-License-Identifier: Apache-2.0
// Preconditioned conjugate gradients, once for every system that a fit solves.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace ovoid::fit {

// Steps towards A v = b of a symmetric positive definite A. With the residual r = b - A v and its
// preconditioned self P r a system has
//   double energy()                  r . P r
//   void turn(double growth)         direction d = P r + growth d, with d = 0 at the start
//   double look()                    d . A d, for which A d is worked out and kept
//   void step(double length)         v += length d, r -= length A d, and P r anew
// At most `iterations` steps, until the energy is `least_share` of what it was. visit(energy over
// what it was at the start) is called after each. Returns the number of steps.
template <class System, class Visit>
int conjugate_gradients(System& system, int iterations, double least_share, const Visit& visit) {
  double before = system.energy();
  const double start = before, least = least_share * before;
  double growth = 0;
  int steps = 0;
  while (steps < iterations && before > least) {
    system.turn(growth);
    const double square = system.look();
    if (!(square > 0)) break;
    system.step(before / square);
    ++steps;
    const double now = system.energy();
    growth = now / before;
    before = now;
    visit(now / start);
  }
  return steps;
}

// A system whose numbers lie in plain vectors: multiply(d, out) fills out = A d, and
// precondition(r, out) out = P r.
template <class Multiply, class Precondition>
class PlainSystem {
 public:
  // `values`: those at the start, which are changed; `residual`: theirs.
  PlainSystem(std::vector<double>& values, std::vector<double> residual, const Multiply& multiply,
              const Precondition& precondition)
      : values_(values),
        residual_(std::move(residual)),
        multiply_(multiply),
        precondition_(precondition),
        direction_(residual_.size()),
        scaled_(residual_.size()),
        product_(residual_.size()) {
    precondition_(residual_, scaled_);
  }

  double energy() const { return dot(residual_, scaled_); }
  void turn(double growth) {
    for (std::size_t i = 0; i < direction_.size(); ++i)
      direction_[i] = scaled_[i] + growth * direction_[i];
  }
  double look() {
    multiply_(direction_, product_);
    return dot(direction_, product_);
  }
  void step(double length) {
    for (std::size_t i = 0; i < direction_.size(); ++i) {
      values_[i] += length * direction_[i];
      residual_[i] -= length * product_[i];
    }
    precondition_(residual_, scaled_);
  }

 private:
  static double dot(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
  }

  std::vector<double>& values_;
  std::vector<double> residual_;
  const Multiply& multiply_;
  const Precondition& precondition_;
  std::vector<double> direction_, scaled_, product_;
};

}  // namespace ovoid::fit
