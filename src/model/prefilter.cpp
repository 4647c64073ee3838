// SPDX-License-Identifier: Apache-2.0
//
// Samples -> coefficients of an interpolating field.
//
// Input and output: one float per sample, x fastest, in place. One pass per axis. Along an axis all
// lines share one matrix G_ji = g(j - i), symmetric and banded, factored once as L D L^T (positive
// definite, since least_response() > 0: no pivots). The right-hand side is the samples times the
// row's sum (normalized) or 1 / w1 (sum). kLanes lines are solved side by side: gathered into a
// buffer [line position][lane] of doubles, eliminated forwards and backwards with the lanes
// innermost, where the compiler makes vectors of them, and scattered back. Along y and z the lanes
// are neighbours in x, a cache line of floats; along x they are rows. Batches share nothing, so
// they may go to any thread.
#include "model/prefilter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "data/parallel.h"
#include "model/holes.h"
#include "ovoid/error.h"

namespace ovoid::model {

namespace {

constexpr std::int64_t kLanes = 16;

// Samples per task.
constexpr std::int64_t kGrainSamples = std::int64_t{1} << 16;

// g(0), g(1), ... to the last within the support: on the cut-off itself it counts half, as the
// field has it there, so that the field's limits on both sides of a sample have the sample's value
// for their mean.
std::vector<double> one_axis_taps(const LatticeKernel& kernel) {
  std::vector<double> taps;
  const double reach = kernel.support_radius();
  for (int k = 0; k <= reach; ++k) {
    const double t = k / kernel.sigma;
    taps.push_back(std::exp(-0.5 * t * t) * (k == reach ? 0.5 : 1.0));
  }
  return taps;
}

// The inverse of one axis' matrix, as factors. Solves lines of `size` samples.
class LineSolver {
 public:
  LineSolver(std::int64_t size, const LatticeKernel& kernel, Reconstruction reconstruction)
      : size_(size), taps_(one_axis_taps(kernel)) {
    taps_.resize(std::min(taps_.size(), static_cast<std::size_t>(size)));
    band_ = static_cast<std::int64_t>(taps_.size()) - 1;
    factor();
    scale_rows(kernel, reconstruction);
  }

  std::int64_t size() const { return size_; }

  // `lines`: [size][kLanes], in place.
  void solve(double* lines) const {
    for (std::int64_t j = 0; j < size_; ++j) {
      double* row = lines + j * kLanes;
      scale(row, right_side_[j]);
      for (std::int64_t k = std::min(band_, j); k >= 1; --k) {
        subtract(row, row - k * kLanes, lower(j, k));
      }
    }
    for (std::int64_t j = size_ - 1; j >= 0; --j) {
      double* row = lines + j * kLanes;
      scale(row, inverse_pivot_[j]);
      for (std::int64_t k = std::min(band_, size_ - 1 - j); k >= 1; --k) {
        subtract(row, row + k * kLanes, lower(j + k, k));
      }
    }
  }

 private:
  // L(j, j - k), 1 <= k <= band.
  double lower(std::int64_t j, std::int64_t k) const { return lower_[j * band_ + k - 1]; }

  // G = L D L^T, row by row: L(j, i) D(i) = G(j, i) - sum_{m < i} L(j, m) D(m) L(i, m).
  void factor() {
    lower_.assign(static_cast<std::size_t>(size_ * band_), 0.0);
    inverse_pivot_.assign(static_cast<std::size_t>(size_), 0.0);
    for (std::int64_t j = 0; j < size_; ++j) {
      double pivot = taps_[0];
      for (std::int64_t k = std::min(band_, j); k >= 1; --k) {
        const std::int64_t i = j - k;
        double value = taps_[k];
        for (std::int64_t m = std::max<std::int64_t>(j - band_, 0); m < i; ++m) {
          value -= lower(j, j - m) * lower(i, i - m) / inverse_pivot_[m];
        }
        lower_[j * band_ + k - 1] = value * inverse_pivot_[i];
        pivot -= value * value * inverse_pivot_[i];
      }
      assert(pivot > 0);
      inverse_pivot_[j] = 1 / pivot;
    }
  }

  void scale_rows(const LatticeKernel& kernel, Reconstruction reconstruction) {
    right_side_.assign(static_cast<std::size_t>(size_),
                       std::sqrt(2 * std::numbers::pi) * kernel.sigma);
    if (reconstruction == Reconstruction::kSum) return;
    for (std::int64_t j = 0; j < size_; ++j) {
      double sum = taps_[0];
      for (std::int64_t k = 1; k <= band_; ++k) {
        sum += (j - k >= 0 ? taps_[k] : 0) + (j + k < size_ ? taps_[k] : 0);
      }
      right_side_[j] = sum;
    }
  }

  static void scale(double* row, double factor) {
    for (std::int64_t lane = 0; lane < kLanes; ++lane) row[lane] *= factor;
  }
  static void subtract(double* row, const double* other, double factor) {
    for (std::int64_t lane = 0; lane < kLanes; ++lane) row[lane] -= factor * other[lane];
  }

  std::int64_t size_;
  std::int64_t band_ = 0;
  std::vector<double> taps_;
  std::vector<double> lower_;          // [size][band]
  std::vector<double> inverse_pivot_;  // [size]
  std::vector<double> right_side_;     // [size]
};

// Up to kLanes lines side by side.
struct Batch {
  float* first;            // the first sample of the first line
  std::int64_t lane_step;  // samples from line to line
  std::int64_t line_step;  // samples along a line
  std::int64_t num_lanes;
};

void solve_batch(const LineSolver& solver, const Batch& batch, std::vector<double>& lines) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  for (std::int64_t j = 0; j < solver.size(); ++j) {
    const float* from = batch.first + j * batch.line_step;
    for (std::int64_t lane = 0; lane < batch.num_lanes; ++lane) {
      lines[j * kLanes + lane] = from[lane * batch.lane_step];
    }
  }
  solver.solve(lines.data());
  for (std::int64_t j = 0; j < solver.size(); ++j) {
    float* to = batch.first + j * batch.line_step;
    for (std::int64_t lane = 0; lane < batch.num_lanes; ++lane) {
      to[lane * batch.lane_step] =
          static_cast<float>(std::clamp(lines[j * kLanes + lane], -kLargest, kLargest));
    }
  }
}

void filter_axis(std::span<float> samples, const Index3& dims, int axis,
                 const PrefilterOptions& options) {
  const LineSolver solver(dims[axis], options.kernel, options.reconstruction);
  const std::int64_t slice = dims[0] * dims[1];
  // Lanes run over rows for lines along x, else over x; `outer` counts what is left beside them.
  const std::int64_t lanes_in_all = axis == 0 ? dims[1] * dims[2] : dims[0];
  const std::int64_t outer = axis == 0 ? 1 : axis == 1 ? dims[2] : dims[1];
  const std::int64_t outer_step = axis == 1 ? slice : dims[0];
  const std::int64_t lane_step = axis == 0 ? dims[0] : 1;
  const std::int64_t line_step = axis == 0 ? 1 : axis == 1 ? dims[0] : slice;

  const std::int64_t batches = (lanes_in_all + kLanes - 1) / kLanes;
  const std::int64_t grain = std::max<std::int64_t>(kGrainSamples / (kLanes * solver.size()), 1);
  data::parallel_ranges(
      {batches * outer, grain, options.threads, options.stop},
      [&](std::int64_t begin, std::int64_t end) {
        std::vector<double> lines(static_cast<std::size_t>(solver.size() * kLanes));
        for (std::int64_t i = begin; i < end; ++i) {
          const std::int64_t lane = i % batches * kLanes;
          const std::int64_t first = lane * lane_step + i / batches * outer_step;
          solve_batch(
              solver,
              {samples.data() + first, lane_step, line_step, std::min(kLanes, lanes_in_all - lane)},
              lines);
        }
      });
}

}  // namespace

double least_response(const LatticeKernel& kernel) {
  // A cosine polynomial of at most 64 terms (kMaxSigma * kMaxCutoff): 1024 steps resolve each of
  // its waves 16-fold.
  constexpr int kSteps = 1024;
  const std::vector<double> taps = one_axis_taps(kernel);
  double constant = taps[0];
  for (std::size_t k = 1; k < taps.size(); ++k) constant += 2 * taps[k];
  double least = constant;
  for (int step = 1; step <= kSteps; ++step) {
    const double frequency = std::numbers::pi * step / kSteps;
    double response = taps[0];
    for (std::size_t k = 1; k < taps.size(); ++k) {
      response += 2 * taps[k] * std::cos(static_cast<double>(k) * frequency);
    }
    least = std::min(least, response);
  }
  return least / constant;
}

void require_interpolating(const LatticeKernel& kernel) {
  const double response = least_response(kernel);
  if (response >= kMinResponse) return;
  // The largest smaller sigma that will do, to two digits.
  LatticeKernel narrower = kernel;
  for (int hundredths = static_cast<int>(std::ceil(kernel.sigma * 100)) - 1; hundredths > 0;
       --hundredths) {
    narrower.sigma = hundredths / 100.0;
    if (least_response(narrower) >= kMinResponse) break;
  }
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("kernel sigma = {}: its samples cannot be interpolated (least response "
                          "{:.2g}, must be >= {}); with cutoff {} prefilter needs sigma <= {}",
                          kernel.sigma, response, kMinResponse, kernel.cutoff, narrower.sigma));
}

void prefilter(std::span<float> samples, const Index3& dims, const PrefilterOptions& options) {
  require_interpolating(options.kernel);
  const std::vector<bool> missing = fill_missing(samples, dims, options.stop);
  for (int axis = 0; axis < 3; ++axis) filter_axis(samples, dims, axis, options);
  restore_missing(samples, missing);
}

}  // namespace ovoid::model
