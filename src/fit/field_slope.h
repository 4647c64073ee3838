// SPDX-License-Identifier: Apache-2.0
// What a small change of kernels makes of their field, to first order.
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include "fit/clusters.h"
#include "ovoid/fit.h"

namespace ovoid::fit {

// The derivative of a field at places by how its kernels change: a linear map, like KernelOperator,
// of `kMoves` numbers for each kernel and one more for each attribute. The numbers are: by how many
// sigmas the centre moves, c + L a (3); how the factor grows, L (1 + B) with B lower triangular as
// shapes are stored (6); the weight's logarithm (1); the changes of values, in units of the
// attribute's range. A kernel of a sum keeps its integral as B changes. The same bytes for any
// number of threads.
class FieldSlope {
 public:
  static constexpr std::size_t kMoves = 10, kWeight = 9;
  // Of B: its diagonal among the moves.
  static constexpr std::size_t kDiagonal[] = {3, 5, 8};

  // `rows`: of the kernels at the places [num_places, 3], which are borrowed. `ranges`: of the
  // attributes whose values these are, at least one.
  FieldSlope(KernelOperator rows, const MergedKernels& kernels,
             const std::vector<std::vector<double>>& values, std::span<const double> ranges,
             std::span<const double> places, Reconstruction reconstruction, double cutoff,
             int threads);

  const KernelOperator& rows() const noexcept { return rows_; }

  std::size_t numbers_per_kernel() const noexcept { return kMoves + num_attributes_; }
  std::size_t size() const noexcept { return num_kernels_ * numbers_per_kernel(); }
  // Fields at the places in units of ranges, [num_places, num_attributes]; 0 where not defined.
  const std::vector<double>& field() const noexcept { return field_; }

  // The change of the field, laid out as it is, for a change of the kernels [size()].
  std::vector<double> gather(std::span<const double> change, const std::stop_token& stop) const;
  // The transpose, and the transpose of the squares.
  std::vector<double> splat(std::span<const double> numbers) const;
  std::vector<double> splat_squares(std::span<const double> numbers) const;

 private:
  // A kernel at a place: the place in its own coordinates; what it is of the field there, and how
  // fast that falls with half the square of u.
  struct Near {
    Vec3 u;
    double share, fall;
  };
  struct Kernel {
    Vec3 center;
    double per_xx, yx, per_yy, zx, zy, per_zz, weight;
  };

  Near near(const KernelOperator::Row& row, std::size_t entry) const;
  // What the moves are multiplied by, for an attribute.
  double lever(std::size_t kernel, std::size_t place, std::size_t attribute) const;
  template <class Power>
  std::vector<double> splat_powers(std::span<const double> numbers, const Power& power) const;

  KernelOperator rows_;
  std::span<const double> places_;
  bool is_sum_;
  double most_, at_end_;
  int threads_;
  std::size_t num_kernels_, num_attributes_;
  std::vector<Kernel> kernels_;
  std::vector<double> values_;  // [n, num_attributes], in units of ranges
  std::vector<double> field_;
};

// Moves a kernel by `length` times the numbers [kMoves] that FieldSlope defines; its sigmas and its
// weight by their exponentials, so that they stay above 0.
void move_kernel(MergedKernels& kernels, std::size_t i, const double* moves, double length);

}  // namespace ovoid::fit
