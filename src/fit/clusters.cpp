// SPDX-License-Identifier: Apache-2.0
#include "fit/clusters.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "data/parallel.h"
#include "model/mesh/amplitudes.h"
#include "model/mesh/ellipsoid_shape.h"
#include "model/particles/kernel_parts.h"

namespace ovoid::fit {
namespace {

constexpr std::int64_t kClusterGrain = 64;
// An axis may be cut if the cluster's variance along it, in units of its kernels, is at least this
// share of the greatest one's: halves are at most about four times as long as they are wide.
constexpr double kLeastVariance = 1.0 / 16;
// Of larger clusters so many kernels are looked at.
constexpr std::size_t kMostLookedAt = 1024;
// Below it, lines fit everything.
constexpr std::size_t kLeastForLines = 12;

// What a cluster's kernels are as a whole.
struct Moments {
  double volume = 0;
  Vec3 center = Vec3::Zero();
  Mat3 spread = Mat3::Zero();  // covariance of the centres
  Mat3 shape = Mat3::Zero();   // mean covariance of the kernels
};

Moments moments_of(const SourceKernels& source, std::span<const std::uint32_t> members) {
  Moments moments;
  const Vec3 origin = source.center(members[0]);
  for (const std::uint32_t i : members) {
    moments.volume += source.volumes[i];
    moments.center += source.volumes[i] * (source.center(i) - origin);
  }
  moments.center /= moments.volume;
  for (const std::uint32_t i : members) {
    const double share = source.volumes[i] / moments.volume;
    const Vec3 d = source.center(i) - origin - moments.center;
    const Mat3 factor = source.factor(i);
    moments.spread += share * d * d.transpose();
    moments.shape += share * factor * factor.transpose();
  }
  moments.center += origin;
  return moments;
}

// What is left of values after the best straight line in three coordinates: sums of squares, of
// which each value adds to one side or the other.
class LineFit {
 public:
  void add(const Vec3& at, double value, double share) {
    const Eigen::Vector4d row(1, at[0], at[1], at[2]);
    matrix_ += share * row * row.transpose();
    right_ += share * value * row;
    square_ += share * value * value;
  }
  double rest() const {
    const Eigen::Matrix4d ridge = 1e-9 * (matrix_.trace() + 1e-300) * Eigen::Matrix4d::Identity();
    const Eigen::Vector4d line = (matrix_ + ridge).ldlt().solve(right_);
    return std::max(0.0, square_ - right_.dot(line));
  }

 private:
  Eigen::Matrix4d matrix_ = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right_ = Eigen::Vector4d::Zero();
  double square_ = 0;
};

// Members in coordinates in which the cluster's mean kernel is the unit ball.
struct Whitened {
  std::vector<Vec3> at;
  Mat3 axes;       // columns, by falling variance
  Vec3 variances;  // of them
};

Whitened whitened(const SourceKernels& source, std::span<const std::uint32_t> members) {
  const Moments moments = moments_of(source, members);
  const Mat3 factor = model::shape_of_covariance(moments.shape).factor;
  const auto lower = factor.triangularView<Eigen::Lower>();
  Whitened result;
  result.at.reserve(members.size());
  Mat3 covariance = Mat3::Zero();
  for (const std::uint32_t i : members) {
    result.at.push_back(lower.solve(source.center(i) - moments.center));
    covariance += result.at.back() * result.at.back().transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance /
                                                   static_cast<double>(members.size()));
  result.axes = solver.eigenvectors().rowwise().reverse();
  result.variances = solver.eigenvalues().reverse();
  return result;
}

// What two lines leave of the values on the two sides of the middle along an axis.
double rest_of_halves(const SourceKernels& source, std::span<const std::uint32_t> members,
                      const Whitened& places, const Vec3& axis) {
  std::vector<double> along(members.size());
  for (std::size_t i = 0; i < members.size(); ++i) along[i] = axis.dot(places.at[i]);
  std::vector<double> sorted = along;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  double rest = 0;
  for (std::size_t a = 0; a < source.values.size(); ++a) {
    const double first = static_cast<double>(source.values[a][members[0]]);
    const ValueRange& of = source.attributes[a].range;
    const double range = std::max(static_cast<double>(of.hi) - static_cast<double>(of.lo), 1e-300);
    LineFit halves[2];
    for (std::size_t i = 0; i < members.size(); ++i) {
      const double value = (static_cast<double>(source.values[a][members[i]]) - first) / range;
      halves[along[i] < *middle ? 0 : 1].add(places.at[i], value, source.volumes[members[i]]);
    }
    rest += halves[0].rest() + halves[1].rest();
  }
  return rest;
}

Vec3 axis_to_cut(const SourceKernels& source, std::span<const std::uint32_t> members,
                 const Whitened& places) {
  if (members.size() < kLeastForLines) return places.axes.col(0);
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    if (!(places.variances[a] >= kLeastVariance * places.variances[0])) break;
    const double rest = rest_of_halves(source, members, places, places.axes.col(a));
    // Where lines leave nothing along any axis, the longest is cut.
    if (rest < 0.999 * least) {
      least = rest;
      best = a;
    }
  }
  return places.axes.col(best);
}

// Sorts members about the middle of the axis; returns the first half's size.
std::size_t cut(const SourceKernels& source, std::span<std::uint32_t> members) {
  std::vector<std::uint32_t> some;
  const std::size_t every = (members.size() + kMostLookedAt - 1) / kMostLookedAt;
  for (std::size_t i = 0; i < members.size(); i += every) some.push_back(members[i]);
  const Whitened places = whitened(source, some);
  // The axis in the world: along it, whitened coordinates are a linear function.
  const Moments moments = moments_of(source, some);
  const Mat3 factor = model::shape_of_covariance(moments.shape).factor;
  const Vec3 normal =
      factor.transpose().triangularView<Eigen::Upper>().solve(axis_to_cut(source, some, places));
  std::vector<std::pair<double, std::uint32_t>> along(members.size());
  for (std::size_t i = 0; i < members.size(); ++i)
    along[i] = {normal.dot(source.center(members[i]) - moments.center), members[i]};
  const std::size_t half = members.size() / 2;
  std::nth_element(along.begin(), along.begin() + static_cast<std::ptrdiff_t>(half), along.end());
  std::transform(along.begin(), along.end(), members.begin(),
                 [](const auto& item) { return item.second; });
  return half;
}

}  // namespace

KernelColumns MergedKernels::columns(double cutoff) const {
  KernelColumns columns;
  columns.shape = KernelShape::kEllipsoids;
  columns.cutoff = cutoff;
  columns.centers = centers;
  columns.shapes = shapes;
  columns.weights = weights;
  return columns;
}

double MergedKernels::mass(std::size_t i) const noexcept {
  const float* const l = shapes.data() + 6 * i;
  return static_cast<double>(weights[i]) * static_cast<double>(l[0]) * static_cast<double>(l[2]) *
         static_cast<double>(l[5]);
}

Clusters::Clusters(const SourceKernels& source, int threads)
    : source_(&source), threads_(threads), order_(source.count()) {
  std::iota(order_.begin(), order_.end(), 0U);
  list.push_back({0, static_cast<std::uint32_t>(order_.size()), {}});
}

void Clusters::halve(const std::vector<std::uint32_t>& which, const std::stop_token& stop) {
  const std::size_t first_new = list.size();
  list.resize(first_new + which.size());
  data::parallel_ranges(
      {static_cast<std::int64_t>(which.size()), kClusterGrain, threads_, stop},
      [&](std::int64_t begin, std::int64_t end) {
        for (auto w = static_cast<std::size_t>(begin); w < static_cast<std::size_t>(end); ++w) {
          Cluster& cluster = list[which[w]];
          const std::size_t half =
              cut(*source_, std::span(order_).subspan(cluster.begin, cluster.count()));
          const auto middle = cluster.begin + static_cast<std::uint32_t>(half);
          list[first_new + w] = {middle, cluster.end, cluster.excess};
          cluster.end = middle;
        }
      });
}

MergedKernels Clusters::merged(const MergeRule& rule, const std::stop_token& stop) const {
  const std::size_t count = list.size();
  MergedKernels kernels;
  kernels.centers.resize(3 * count);
  kernels.shapes.resize(6 * count);
  kernels.weights.resize(count);
  kernels.means.assign(source_->values.size(), std::vector<double>(count));
  std::vector<float> targets(count);
  const bool is_sum = source_->reconstruction == Reconstruction::kSum;
  data::parallel_ranges(
      {static_cast<std::int64_t>(count), kClusterGrain, threads_, stop},
      [&](std::int64_t begin, std::int64_t end) {
        std::vector<float> factor;
        for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c) {
          const std::span members = std::span(order_).subspan(list[c].begin, list[c].count());
          const Moments moments = moments_of(*source_, members);
          const Mat3 covariance = moments.shape + rule.spread * moments.spread;
          Mat3 lower = model::shape_of_covariance(covariance).factor;
          if (rule.shape == KernelShape::kBalls)
            lower = Mat3(Mat3::Identity() * std::cbrt(lower.diagonal().prod()));
          factor.clear();
          model::append_factor(lower, factor);
          std::copy_n(factor.begin(), 6,
                      kernels.shapes.begin() + static_cast<std::ptrdiff_t>(6 * c));
          for (int a = 0; a < 3; ++a)
            kernels.centers[3 * c + static_cast<std::size_t>(a)] = moments.center[a];
          double mass = 0, target = 0;
          for (const std::uint32_t i : members) {
            mass += static_cast<double>(source_->weights[i]) * source_->det(i);
            target += source_->volumes[i] * static_cast<double>(source_->sums[i]);
          }
          kernels.weights[c] = static_cast<float>(mass / lower.diagonal().prod());
          targets[c] = static_cast<float>(target / moments.volume);
          for (std::size_t a = 0; a < kernels.means.size(); ++a) {
            double sum = 0, part = 0;
            for (const std::uint32_t i : members) {
              const double share = is_sum
                                       ? static_cast<double>(source_->weights[i]) * source_->det(i)
                                       : source_->volumes[i];
              sum += share * static_cast<double>(source_->values[a][i]);
              part += share;
            }
            kernels.means[a][c] = sum / part;
          }
        }
      });
  if (!is_sum && count < source_->count())
    model::fit_amplitudes({kernels.centers, kernels.shapes, targets, source_->cutoff,
                           rule.amplitude_passes, threads_, stop},
                          kernels.weights);
  return kernels;
}

}  // namespace ovoid::fit
