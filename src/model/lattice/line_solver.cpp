// SPDX-License-Identifier: Apache-2.0
#include "model/lattice/line_solver.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "data/kernels/kernel_weight.h"

namespace ovoid::model {

namespace {

constexpr double kForgotten = 2e-7;

// row = factor * row - share * other
void scale(float* row, std::int64_t lanes, float factor, const float* other, float share) {
  for (std::int64_t lane = 0; lane < lanes; ++lane)
    row[lane] = factor * row[lane] - share * other[lane];
}

void subtract(float* row, std::int64_t lanes, const float* other, float factor) {
  for (std::int64_t lane = 0; lane < lanes; ++lane) row[lane] -= factor * other[lane];
}

}  // namespace

std::vector<double> one_axis_taps(const LatticeKernel& kernel) {
  std::vector<double> taps;
  const double reach = kernel.support_radius();
  for (int k = 0; k <= reach; ++k)
    taps.push_back(data::axis_weight(kernel, k) * (k == reach ? 0.5 : 1.0));
  while (taps.back() == 0) taps.pop_back();
  return taps;
}

LineSolver::LineSolver(std::int64_t size, const LatticeKernel& kernel,
                       Reconstruction reconstruction)
    : size_(size), taps_(one_axis_taps(kernel)) {
  taps_.resize(std::min(taps_.size(), static_cast<std::size_t>(size)));
  band_ = static_cast<std::int64_t>(taps_.size()) - 1;
  factor();
  scale_rows(kernel, reconstruction);
  look_ahead_ = find_look_ahead();
}

void LineSolver::eliminate(const Lines& lines, std::int64_t begin, std::int64_t end) const {
  for (std::int64_t j = begin; j < end; ++j) {
    float* row = lines.sample(j);
    const std::int64_t before = std::min(band_, j);
    scale(row, lines.lanes, right_side_[j], before > 0 ? row - lines.stride : row,
          before > 0 ? lower(j, 1) : 0.0F);
    for (std::int64_t k = 2; k <= before; ++k)
      subtract(row, lines.lanes, row - k * lines.stride, lower(j, k));
  }
}

void LineSolver::substitute(const Lines& lines, std::int64_t begin, std::int64_t end) const {
  for (std::int64_t j = end - 1; j >= begin; --j) {
    float* row = lines.sample(j);
    const std::int64_t behind = std::min(band_, end - 1 - j);
    scale(row, lines.lanes, inverse_pivot_[j], behind > 0 ? row + lines.stride : row,
          behind > 0 ? lower(j + 1, 1) : 0.0F);
    for (std::int64_t k = 2; k <= behind; ++k)
      subtract(row, lines.lanes, row + k * lines.stride, lower(j + k, k));
  }
}

// G = L D L^T, row by row: L(j, i) D(i) = G(j, i) - sum_{m < i} L(j, m) D(m) L(i, m).
void LineSolver::factor() {
  std::vector<double> exact(static_cast<std::size_t>(size_ * band_), 0.0);
  std::vector<double> inverse(static_cast<std::size_t>(size_), 0.0);
  const auto at = [&](std::int64_t j, std::int64_t k) -> double& {
    return exact[j * band_ + k - 1];
  };
  for (std::int64_t j = 0; j < size_; ++j) {
    double pivot = taps_[0];
    for (std::int64_t k = std::min(band_, j); k >= 1; --k) {
      const std::int64_t i = j - k;
      double value = taps_[k];
      for (std::int64_t m = std::max<std::int64_t>(j - band_, 0); m < i; ++m)
        value -= at(j, j - m) * at(i, i - m) / inverse[m];
      at(j, k) = value * inverse[i];
      pivot -= value * value * inverse[i];
    }
    assert(pivot > 0);
    inverse[j] = 1 / pivot;
  }
  lower_.assign(exact.begin(), exact.end());
  inverse_pivot_.assign(inverse.begin(), inverse.end());
}

void LineSolver::scale_rows(const LatticeKernel& kernel, Reconstruction reconstruction) {
  right_side_.assign(static_cast<std::size_t>(size_), static_cast<float>(data::axis_mass(kernel)));
  if (reconstruction == Reconstruction::kSum) return;
  for (std::int64_t j = 0; j < size_; ++j) {
    double sum = taps_[0];
    for (std::int64_t k = 1; k <= band_; ++k)
      sum += (j - k >= 0 ? taps_[k] : 0) + (j + k < size_ ? taps_[k] : 0);
    right_side_[j] = static_cast<float>(sum);
  }
}

// What an error of 1 at a line's end becomes on its way back.
std::int64_t LineSolver::find_look_ahead() const {
  if (band_ == 0) return 0;
  std::vector<double> error(static_cast<std::size_t>(size_), 0.0);
  error.back() = 1;
  std::int64_t forgotten = 0;
  for (std::int64_t j = size_ - 2; j >= 0; --j) {
    for (std::int64_t k = 1; k <= std::min(band_, size_ - 1 - j); ++k)
      error[j] -= static_cast<double>(lower(j + k, k)) * error[j + k];
    forgotten = std::abs(error[j]) < kForgotten ? forgotten + 1 : 0;
    if (forgotten >= band_) return size_ - 1 - j;
  }
  return size_;
}

}  // namespace ovoid::model
