// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "ovoid/field.h"
#include "ovoid/math.h"

namespace ovoid::reference {

// The field at one place. Where it is not defined, value and gradient are zero.
struct FieldSample {
  double value = 0;
  Vec3 gradient = Vec3::Zero();  // world units; the kernels' own derivative
  bool is_defined = false;
  double weight = 0;  // sum of the kernels that exist, over that of the endless lattice
};

// docs/numerics.md, "The field" and "Slabs", word for word: every sum runs over every kernel whose
// support box holds the place, in double precision, without tables. Immutable after construction:
// any number of threads may ask at once.
class FieldEvaluator {
 public:
  // Copies all samples: 9 bytes each. Throws what the field's brick source throws, and
  // Error(kOutOfMemory).
  explicit FieldEvaluator(const LatticeField& field);

  // The same of the samples lo <= (i, j, k) < hi alone, k the layer, a box inside the lattice.
  // Right for places whose kernels in reach are all in it or outside of the lattice; asks for no
  // others.
  FieldEvaluator(const LatticeField& field, const Index3& lo, const Index3& hi);

  // The field at a position in index space. `widening` holds the factors m_a >= 1 of
  // "Minification", per lattice axis.
  FieldSample at_index(const Vec3& position, const Vec3& widening = Vec3::Ones()) const;

  // The field at a position in the world.
  FieldSample at_world(const Vec3& position, const Vec3& widening = Vec3::Ones()) const;

  // The field's mean over the straight segment between two different positions in index space:
  // numerator and denominator are integrated along it before they are divided.
  FieldSample mean_over(const Vec3& from, const Vec3& to,
                        const Vec3& widening = Vec3::Ones()) const;

  // The mean of the samples in a box of index space under `weight`, a function of a position in
  // index space, not negative and zero beyond the box. Not defined, and zero, where no position of
  // the endless lattice has weight, or one that has is no kernel that exists.
  FieldSample mean_under(const Bounds3& box,
                         const std::function<double(const Vec3&)>& weight) const;

  // A world gradient found at a position (of a mean: the segment's middle) in index space, turned
  // into the slope of the ramp to which the endless lattice answers with it: docs/numerics.md,
  // "Gradients". Unchanged for `sum`.
  Vec3 corrected_gradient(const Vec3& gradient, const Vec3& position, const Vec3& widening) const;

  // The positions in index space that any kernel can reach.
  Bounds3 support_bounds(const Vec3& widening) const;

  std::int64_t num_existing() const noexcept { return num_existing_; }  // kernels, of finite value

 private:
  // Sums (or integrals) over the kernels in reach; gradients with respect to index space.
  struct Sums {
    double numerator = 0;    // sum v phi
    double denominator = 0;  // sum phi, over the kernels that exist
    double endless = 0;      // sum phi, over the endless lattice
    bool reaches = false;    // some phi of a kernel that exists is not 0
    Vec3 grad_numerator = Vec3::Zero();
    Vec3 grad_denominator = Vec3::Zero();
  };

  void copy_brick(const BrickSource& source, const Index3& brick);
  void add_sublattice(int sublattice, const Vec3& position, const Vec3& widening, Sums& sums) const;
  void integrate_sublattice(int sublattice, const Vec3& from, const Vec3& step,
                            const Vec3& widening, Sums& sums) const;
  FieldSample reconstruct(const Sums& sums, const Vec3& widening) const;
  // Of sample `index` of a sublattice.
  bool is_inside(int sublattice, const Index3& index) const noexcept;
  std::size_t place_of(int sublattice, const Index3& index) const noexcept;
  std::size_t place_of_sample(const Index3& sample) const noexcept;  // (i, j, layer)

  LatticeGeometry lattice_;
  Mat3 world_gradient_from_index_;  // inverse transpose of the axis vectors
  Affine3 index_from_world_;
  Mat3 index_gradient_from_world_;  // transpose of the axis vectors
  LatticeKernel kernel_;            // in index units
  Reconstruction reconstruction_;
  Index3 lo_, hi_;                    // the samples that are held
  std::vector<double> values_;        // [layer, y, x] of these; 0 where missing
  std::vector<std::uint8_t> exists_;  // [layer, y, x]; 1 where the value is finite, else 0
  std::int64_t num_existing_ = 0;
};

}  // namespace ovoid::reference
