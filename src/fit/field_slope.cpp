// SPDX-License-Identifier: Apache-2.0
#include "fit/field_slope.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "data/parallel.h"

namespace ovoid::fit {
namespace {

constexpr std::int64_t kRowGrain = 1024;
// A splat adds up in so many sums, each of its own range of rows, which are added in order.
constexpr std::int64_t kSums = 4;

}  // namespace

FieldSlope::FieldSlope(KernelOperator rows, const MergedKernels& kernels,
                       const std::vector<std::vector<double>>& values,
                       std::span<const double> ranges, std::span<const double> places,
                       Reconstruction reconstruction, double cutoff, int threads)
    : rows_(std::move(rows)),
      places_(places),
      is_sum_(reconstruction == Reconstruction::kSum),
      most_(cutoff * cutoff),
      at_end_(std::exp(-0.5 * most_)),
      threads_(threads),
      num_kernels_(kernels.weights.size()),
      num_attributes_(ranges.size()),
      kernels_(num_kernels_),
      values_(num_kernels_ * num_attributes_),
      field_(rows_.num_places() * num_attributes_) {
  for (std::size_t i = 0; i < num_kernels_; ++i) {
    const double* const c = kernels.centers.data() + 3 * i;
    const float* const l = kernels.shapes.data() + 6 * i;
    const auto at = [l](int number) { return static_cast<double>(l[number]); };
    kernels_[i] = {{c[0], c[1], c[2]},
                   1 / at(0),
                   at(1),
                   1 / at(2),
                   at(3),
                   at(4),
                   1 / at(5),
                   static_cast<double>(kernels.weights[i])};
  }
  for (std::size_t a = 0; a < num_attributes_; ++a) {
    for (std::size_t i = 0; i < num_kernels_; ++i)
      values_[i * num_attributes_ + a] = values[a][i] / ranges[a];
    const std::vector<double> field = rows_.gather(values[a]);
    for (std::size_t k = 0; k < field.size(); ++k)
      field_[k * num_attributes_ + a] = field[k] / ranges[a];
  }
}

FieldSlope::Near FieldSlope::near(const KernelOperator::Row& row, std::size_t entry) const {
  const Kernel& kernel = kernels_[row.kernels[entry]];
  const double* const at = places_.data() + 3 * row.place;
  Near near;
  near.u[0] = (at[0] - kernel.center[0]) * kernel.per_xx;
  near.u[1] = (at[1] - kernel.center[1] - kernel.yx * near.u[0]) * kernel.per_yy;
  near.u[2] =
      (at[2] - kernel.center[2] - kernel.zx * near.u[0] - kernel.zy * near.u[1]) * kernel.per_zz;
  near.share = static_cast<double>(row.entries[entry]);
  // The profile, and what was taken off it so that it ends at 0.
  near.fall = kernel.weight * at_end_ * 0.5 * std::max(0.0, most_ - near.u.squaredNorm());
  if (!is_sum_) near.fall /= static_cast<double>(rows_.weights()[row.place]);
  near.fall += near.share;
  return near;
}

double FieldSlope::lever(std::size_t kernel, std::size_t place, std::size_t attribute) const {
  const double value = values_[kernel * num_attributes_ + attribute];
  return is_sum_ ? value : value - field_[place * num_attributes_ + attribute];
}

std::vector<double> FieldSlope::gather(std::span<const double> change,
                                       const std::stop_token& stop) const {
  std::vector<double> result(field_.size());
  data::parallel_ranges(
      {static_cast<std::int64_t>(rows_.num_places()), kRowGrain, threads_, stop},
      [&](std::int64_t begin, std::int64_t end) {
        for (auto r = static_cast<std::size_t>(begin); r < static_cast<std::size_t>(end); ++r) {
          const KernelOperator::Row row = rows_.row(r);
          double* const out = result.data() + row.place * num_attributes_;
          for (std::size_t e = 0; e < row.kernels.size(); ++e) {
            const std::size_t kernel = row.kernels[e];
            const double* const n = change.data() + kernel * numbers_per_kernel();
            const Near at = near(row, e);
            const Vec3 grown(n[3] * at.u[0], n[4] * at.u[0] + n[5] * at.u[1],
                             n[6] * at.u[0] + n[7] * at.u[1] + n[8] * at.u[2]);
            double moved = at.fall * at.u.dot(Vec3(n[0], n[1], n[2]) + grown);
            moved += at.share * (is_sum_ ? -(n[3] + n[5] + n[8]) : n[kWeight]);
            for (std::size_t a = 0; a < num_attributes_; ++a)
              out[a] += lever(kernel, row.place, a) * moved + at.share * n[kMoves + a];
          }
        }
      });
  return result;
}

// For each kernel's numbers the sum over places of their slopes, or of the slopes' squares, each
// times the place's numbers.
template <class Power>
std::vector<double> FieldSlope::splat_powers(std::span<const double> numbers,
                                             const Power& power) const {
  const auto num_rows = static_cast<std::int64_t>(rows_.num_places());
  std::vector<std::vector<double>> sums(kSums);
  data::parallel_ranges({kSums, 1, threads_}, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t s = begin; s < end; ++s) {
      std::vector<double>& sum = sums[static_cast<std::size_t>(s)];
      sum.assign(size(), 0.0);
      for (std::int64_t r = s * num_rows / kSums; r < (s + 1) * num_rows / kSums; ++r) {
        const KernelOperator::Row row = rows_.row(static_cast<std::size_t>(r));
        const double* const of_place = numbers.data() + row.place * num_attributes_;
        for (std::size_t e = 0; e < row.kernels.size(); ++e) {
          const std::size_t kernel = row.kernels[e];
          double* const out = sum.data() + kernel * numbers_per_kernel();
          const Near at = near(row, e);
          double of_moves = 0;
          for (std::size_t a = 0; a < num_attributes_; ++a) {
            of_moves += power(lever(kernel, row.place, a)) * of_place[a];
            out[kMoves + a] += power(at.share) * of_place[a];
          }
          std::size_t move = 0;
          for (int i = 0; i < 3; ++i) out[move++] += power(at.fall * at.u[i]) * of_moves;
          for (int i = 0; i < 3; ++i) {
            for (int j = 0; j <= i; ++j) {
              const double kept = is_sum_ && i == j ? at.share : 0;
              out[move++] += power(at.fall * at.u[i] * at.u[j] - kept) * of_moves;
            }
          }
          if (!is_sum_) out[kWeight] += power(at.share) * of_moves;
        }
      }
    }
  });
  for (std::size_t s = 1; s < sums.size(); ++s) {
    for (std::size_t i = 0; i < size(); ++i) sums[0][i] += sums[s][i];
  }
  return std::move(sums[0]);
}

std::vector<double> FieldSlope::splat(std::span<const double> numbers) const {
  return splat_powers(numbers, [](double slope) { return slope; });
}

std::vector<double> FieldSlope::splat_squares(std::span<const double> numbers) const {
  return splat_powers(numbers, [](double slope) { return slope * slope; });
}

void move_kernel(MergedKernels& kernels, std::size_t i, const double* moves, double length) {
  float* const l = kernels.shapes.data() + 6 * i;
  Mat3 factor, growth;
  factor << l[0], 0, 0, l[1], l[2], 0, l[3], l[4], l[5];
  const double* const b = moves + 3;
  growth << std::exp(length * b[0]), 0, 0,        //
      length * b[1], std::exp(length * b[2]), 0,  //
      length * b[3], length * b[4], std::exp(length * b[5]);
  const Vec3 shift = length * factor * Vec3(moves[0], moves[1], moves[2]);
  for (int a = 0; a < 3; ++a) kernels.centers[3 * i + static_cast<std::size_t>(a)] += shift[a];
  const Mat3 grown = factor * growth;
  int number = 0;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column <= row; ++column)
      l[number++] = static_cast<float>(grown(row, column));
  }
  kernels.weights[i] *= static_cast<float>(std::exp(length * moves[FieldSlope::kWeight]));
}

}  // namespace ovoid::fit
