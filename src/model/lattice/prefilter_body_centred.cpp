// SPDX-License-Identifier: Apache-2.0
//
// Samples of a body-centred lattice -> coefficients of an interpolating field.
//
// The field at the samples is G c / D (normalized) or w G c (sum), G_ij = phi(u_j - u_i) over the
// samples of both sublattices, symmetric, D its rows' sums. So G c = D s, or s / w, is solved by
// conjugate gradients. A row of G c is a few rows of c under the weights of y and z, of which the
// taps along x are taken: own sublattice and the other one each by a stencil of its own.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "data/kernels/kernel_weight.h"
#include "data/parallel.h"
#include "model/lattice/holes.h"
#include "model/lattice/prefilter.h"
#include "ovoid/error.h"

namespace ovoid::model {

namespace {

// The published kernel takes 15 steps, the B-spline 17, the widest that converge a few dozen.
constexpr int kMostSteps = 100;

// Weights of the samples first, first + 1, ... along one axis, relative to the sample's own number.
struct Stencil {
  int first;
  std::vector<float> weights;
};

// `shift`: from the sample to the others' number 0, in index space.
Stencil stencil_of(const LatticeKernel& kernel, double shift) {
  const double reach = kernel.support_radius();
  Stencil stencil{static_cast<int>(std::ceil(-reach - shift)), {}};
  for (int k = stencil.first; k + shift <= reach; ++k) {
    const double half = std::abs(k + shift) == reach ? 0.5 : 1.0;
    stencil.weights.push_back(static_cast<float>(half * data::axis_weight(kernel, k + shift)));
  }
  return stencil;
}

class Operator {
 public:
  Operator(const Index3& dims, const PrefilterOptions& options, const LatticeKernel& index_kernel)
      : dims_(dims), options_(options) {
    // Of an even layer's samples to those of odd ones, and the other way round.
    stencils_[0][0] = stencils_[1][1] = stencil_of(index_kernel, 0.0);
    stencils_[0][1] = stencil_of(index_kernel, 0.5);
    stencils_[1][0] = stencil_of(index_kernel, -0.5);
  }

  // to = G from
  void apply(const std::vector<float>& from, std::vector<float>& to) const {
    data::parallel_ranges({dims_[2], 1, options_.threads, options_.stop},
                          [&](std::int64_t begin, std::int64_t end) {
                            std::vector<float> sum(static_cast<std::size_t>(dims_[0]));
                            for (std::int64_t layer = begin; layer < end; ++layer)
                              apply_layer(from, to, layer, sum);
                          });
  }

 private:
  void apply_layer(const std::vector<float>& from, std::vector<float>& to, std::int64_t layer,
                   std::vector<float>& sum) const {
    for (std::int64_t y = 0; y < dims_[1]; ++y) {
      float* row = to.data() + (layer * dims_[1] + y) * dims_[0];
      std::fill_n(row, dims_[0], 0.0F);
      for (std::int64_t other = 0; other < std::min<std::int64_t>(2, dims_[2]); ++other) {
        const Stencil& stencil = stencils_[layer % 2][other];
        std::fill(sum.begin(), sum.end(), 0.0F);
        add_rows(from, stencil, {y, layer / 2, other}, sum);
        add_along_x(sum, stencil, row);
      }
    }
  }

  // The rows of sublattice at[2] around row at[0] of slice at[1], weighted.
  void add_rows(const std::vector<float>& from, const Stencil& stencil, const Index3& at,
                std::vector<float>& sum) const {
    const auto count = static_cast<std::int64_t>(stencil.weights.size());
    for (std::int64_t k = 0; k < count; ++k) {
      const std::int64_t z = at[1] + stencil.first + k;
      if (z < 0 || 2 * z + at[2] >= dims_[2]) continue;
      for (std::int64_t j = 0; j < count; ++j) {
        const std::int64_t y = at[0] + stencil.first + j;
        if (y < 0 || y >= dims_[1]) continue;
        const float weight = stencil.weights[k] * stencil.weights[j];
        const float* other = from.data() + ((2 * z + at[2]) * dims_[1] + y) * dims_[0];
        for (std::int64_t x = 0; x < dims_[0]; ++x) sum[x] += weight * other[x];
      }
    }
  }

  void add_along_x(const std::vector<float>& sum, const Stencil& stencil, float* row) const {
    for (std::size_t k = 0; k < stencil.weights.size(); ++k) {
      const std::int64_t shift = stencil.first + static_cast<std::int64_t>(k);
      const std::int64_t end = std::min(dims_[0], dims_[0] - shift);
      for (std::int64_t x = std::max<std::int64_t>(0, -shift); x < end; ++x)
        row[x] += stencil.weights[k] * sum[x + shift];
    }
  }

  Index3 dims_;
  const PrefilterOptions& options_;
  Stencil stencils_[2][2];
};

double dot(const std::vector<float>& a, const std::vector<float>& b) {
  return std::transform_reduce(
      a.begin(), a.end(), b.begin(), 0.0, std::plus<>(),
      [](float p, float q) { return static_cast<double>(p) * static_cast<double>(q); });
}

}  // namespace

void prefilter_body_centred(std::span<float> samples, const Index3& dims,
                            const PrefilterOptions& options) {
  LatticeKernel kernel = options.kernel;
  kernel.sigma *= std::numbers::sqrt2 / 2;
  const Operator matrix(dims, options, kernel);
  std::vector<bool> missing;
  if (options.may_miss) missing = fill_missing(samples, dims, options.stop);
  const auto [lo, hi] = std::minmax_element(samples.begin(), samples.end());
  const double bound = kBodyCentredError * (static_cast<double>(*hi) - static_cast<double>(*lo));

  std::vector<float> residual(samples.size());
  std::vector<float> change(samples.size(), 1.0F);
  std::vector<float> scale(samples.size(),
                           static_cast<float>(2 * std::pow(data::axis_mass(kernel), 3)));
  if (options.reconstruction == Reconstruction::kNormalized) matrix.apply(change, scale);
  // The samples themselves are near: it goes on from there.
  std::vector<float> image(samples.begin(), samples.end());
  matrix.apply(image, residual);
  for (std::size_t i = 0; i < samples.size(); ++i)
    residual[i] = scale[i] * samples[i] - residual[i];
  change = residual;
  double square = dot(residual, residual);
  const auto is_right = [&] {
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (!(std::abs(residual[i]) <= bound * static_cast<double>(scale[i]))) return false;
    return true;
  };
  for (int step = 0; !is_right(); ++step) {
    matrix.apply(change, image);
    const double curvature = dot(change, image);
    if (step == kMostSteps || !(curvature > 0))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("kernel {}, sigma = {}: its samples on a body-centred lattice cannot "
                              "be interpolated; a narrower kernel's can",
                              name_of(options.kernel.kind), options.kernel.sigma));
    const auto length = static_cast<float>(square / curvature);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      samples[i] += length * change[i];
      residual[i] -= length * image[i];
    }
    const double before = square;
    square = dot(residual, residual);
    const auto share = static_cast<float>(square / before);
    for (std::size_t i = 0; i < samples.size(); ++i) change[i] = residual[i] + share * change[i];
  }
  restore_missing(samples, missing);
}

}  // namespace ovoid::model
