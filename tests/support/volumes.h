// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "ovoid/field.h"
#include "ovoid/lattice.h"
#include "ovoid/math.h"

namespace ovoid::test {

inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

// The sample (i, j, k) of a volume; kMissing for no kernel.
using VolumeFunction = std::function<double(std::int64_t i, std::int64_t j, std::int64_t k)>;

// A brick source of its own kind, which tests the seam as well as what stands behind it: float
// samples by formula; every brick has memory of its own, with its neighbours' nearest samples
// around it and padded rows, and the bytes between the rows are NaN. So a back end that takes
// strides, origins or covered samples for granted shows.
class FunctionSource final : public BrickSource {
 public:
  struct Options {
    int brick_edge = 8;
    double range_reach = 2.0;  // at least the support radius of the kernels put on it
    // The function tells stored numbers; values are number * scale + offset.
    double value_scale = 1.0;
    double value_offset = 0.0;
  };

  FunctionSource(LatticeGeometry geometry, const VolumeFunction& function, Options options);

  const LatticeGeometry& geometry() const noexcept override { return geometry_; }
  int brick_edge() const noexcept override { return options_.brick_edge; }
  double value_scale() const noexcept override { return options_.value_scale; }
  double value_offset() const noexcept override { return options_.value_offset; }
  ValueRange brick_range(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept override;
  double range_reach() const noexcept override { return options_.range_reach; }
  bool has_missing(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept override;
  BrickView acquire(std::int64_t bx, std::int64_t by, std::int64_t bz, double time) const override;
  std::size_t resident_bytes() const noexcept override;

 private:
  struct Brick {
    std::vector<float> samples;
    BrickView view;
    ValueRange range;
    bool has_missing = false;
  };

  Brick make_brick(const Index3& brick, const VolumeFunction& function) const;
  const Brick& brick(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept;

  LatticeGeometry geometry_;
  Options options_;
  Index3 num_bricks_;
  std::vector<Brick> bricks_;
};

// How a test's lattice lies in the world and what its kernels are.
struct FieldSetup {
  Affine3 world_from_index = Affine3::Identity();
  LatticeKernel kernel;
  Reconstruction reconstruction = Reconstruction::kNormalized;
  int brick_edge = 8;
  double value_scale = 1.0;
  double value_offset = 0.0;
  LatticeKind lattice = LatticeKind::kCartesian;
};

LatticeField make_field(const Index3& dims, const VolumeFunction& function,
                        const FieldSetup& setup = {});

// A volume of one value.
LatticeField constant_field(const Index3& dims, double value, const FieldSetup& setup = {});

// Axes of the given spacings, sample (0, 0, 0) at `origin`.
Affine3 scaled_axes(const Vec3& spacing, const Vec3& origin = Vec3::Zero());

// Anisotropic, oblique and left-handed, off the origin: what a transform of gradients or rays must
// survive.
Affine3 oblique_axes();

}  // namespace ovoid::test
