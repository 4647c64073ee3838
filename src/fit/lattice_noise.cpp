// SPDX-License-Identifier: Apache-2.0
#include "fit/lattice_noise.h"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "data/field_samples.h"
#include "data/lattice/slope_noise.h"

namespace ovoid::fit {
namespace {

constexpr std::int64_t kWanted = std::int64_t{1} << 17;  // places at which differences are taken
// Differences over twice the distance may be that many times as large.
constexpr double kAlike = 1.25;
// Of a normal distribution: the median of what it is away from its mean, in deviations.
constexpr double kMedian = 0.6744897501960817;
// An axis with fewer samples has no second differences over twice the distance.
constexpr std::int64_t kFewest = 5;

// Second differences 1, -2, 1 along each axis in turn, `step` samples apart.
class Differences {
 public:
  Differences(const Index3& dims, std::int64_t step) : dims_(dims) {
    offsets_ = {0};
    weights_ = {1};
    const Index3 strides{1, dims[0], dims[0] * dims[1]};
    for (std::size_t a = 0; a < 3; ++a) {
      if (dims[a] < kFewest) continue;
      margin_[a] = step;
      const std::size_t count = offsets_.size();
      for (const std::int64_t side : {-1, 1}) {
        for (std::size_t i = 0; i < count; ++i) {
          offsets_.push_back(offsets_[i] + side * step * strides[a]);
          weights_.push_back(weights_[i]);
        }
      }
      for (std::size_t i = 0; i < count; ++i) weights_[i] *= -2;
    }
  }

  // The deviation of independent noise with such differences, over all samples.
  double deviation(std::span<const float> samples) const {
    if (offsets_.size() == 1) return 0;
    std::int64_t all = 1;
    Index3 inner{};
    for (std::size_t a = 0; a < 3; ++a) all *= inner[a] = dims_[a] - 2 * margin_[a];
    const std::int64_t every = (all + kWanted - 1) / kWanted;
    std::vector<double> sizes;  // where a difference is not 0
    double count = 0;
    for (std::int64_t n = 0; n < all; n += every) {
      const std::int64_t at = n % inner[0] + margin_[0] +
                              dims_[0] * (n / inner[0] % inner[1] + margin_[1] +
                                          dims_[1] * (n / inner[0] / inner[1] + margin_[2]));
      double sum = 0;
      for (std::size_t i = 0; i < offsets_.size(); ++i)
        sum +=
            weights_[i] * static_cast<double>(samples[static_cast<std::size_t>(at + offsets_[i])]);
      if (std::isnan(sum)) continue;  // a sample is missing
      ++count;
      if (sum != 0) sizes.push_back(std::abs(sum));
    }
    if (sizes.empty()) return 0;
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    double squares = 0;
    for (const double weight : weights_) squares += weight * weight;
    return *middle / kMedian / std::sqrt(squares) *
           std::sqrt(static_cast<double>(sizes.size()) / count);
  }

 private:
  Index3 dims_, margin_{};
  std::vector<std::int64_t> offsets_;
  std::vector<double> weights_;
};

// Of cubes of samples, what the best quadratic function leaves.
class Cubes {
 public:
  explicit Cubes(const Index3& dims) : dims_(dims) {
    std::vector<Eigen::Vector3d> places;
    for (std::size_t a = 0; a < 3; ++a) sides_[a] = std::min(kSide, dims[a]);
    for (std::int64_t z = 0; z < sides_[2]; ++z) {
      for (std::int64_t y = 0; y < sides_[1]; ++y) {
        for (std::int64_t x = 0; x < sides_[0]; ++x) {
          offsets_.push_back(x + dims[0] * (y + dims[1] * z));
          places.emplace_back(x, y, z);
        }
      }
    }
    Eigen::MatrixXd terms(static_cast<Eigen::Index>(places.size()), 10);
    for (Eigen::Index i = 0; i < terms.rows(); ++i) {
      const Eigen::Vector3d p = places[static_cast<std::size_t>(i)] - Eigen::Vector3d::Constant(2);
      terms.row(i) << 1, p[0], p[1], p[2], p[0] * p[0], p[1] * p[1], p[2] * p[2], p[0] * p[1],
          p[0] * p[2], p[1] * p[2];
    }
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(terms);
    quadratics_ = Eigen::MatrixXd(qr.householderQ()).leftCols(qr.rank());
  }

  // That deviation which a quarter of the cubes stay below, of those whose samples differ; times
  // the root of their share.
  double deviation(std::span<const float> samples) const {
    const auto freedom = static_cast<double>(quadratics_.rows() - quadratics_.cols());
    if (freedom < 1) return 0;
    std::int64_t all = 1;
    Index3 firsts{};
    for (std::size_t a = 0; a < 3; ++a) all *= firsts[a] = dims_[a] - sides_[a] + 1;
    const std::int64_t every = (all + kCubes - 1) / kCubes;
    std::vector<float> squares;
    double count = 0;
    Eigen::VectorXd values(quadratics_.rows());
    for (std::int64_t n = 0; n < all; n += every) {
      const std::int64_t at = n % firsts[0] + dims_[0] * (n / firsts[0] % firsts[1] +
                                                          dims_[1] * (n / firsts[0] / firsts[1]));
      for (Eigen::Index i = 0; i < values.size(); ++i)
        values[i] = static_cast<double>(
            samples[static_cast<std::size_t>(at + offsets_[static_cast<std::size_t>(i)])]);
      if (values.hasNaN()) continue;
      ++count;
      values.array() -= values.mean();
      if (values.isZero(0)) continue;
      const double left = values.squaredNorm() - (quadratics_.transpose() * values).squaredNorm();
      squares.push_back(static_cast<float>(std::max(0.0, left) / freedom));
    }
    if (squares.empty()) return 0;
    std::sort(squares.begin(), squares.end());
    return std::sqrt(data::quantile(squares, 0.25) * static_cast<double>(squares.size()) / count);
  }

 private:
  static constexpr std::int64_t kSide = 5, kCubes = 20000;

  Index3 dims_, sides_{};
  std::vector<std::int64_t> offsets_;
  Eigen::MatrixXd quadratics_;  // orthonormal
};

}  // namespace

double noise_of_lattice(const BrickSource& source, std::span<const float> samples, double least) {
  const Index3& dims = source.geometry().dims;
  const double near = Differences(dims, 1).deviation(samples);
  const double far = Differences(dims, 2).deviation(samples);
  const bool is_independent = near > 0 && far < kAlike * near;
  const double noise = is_independent            ? near
                       : data::has_noise(source) ? Cubes(dims).deviation(samples)
                                                 : 0;
  return noise >= least ? noise : 0;
}

}  // namespace ovoid::fit
