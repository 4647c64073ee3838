// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "ovoid/field.h"

namespace ovoid {

// A brick source that is the weighted sum of others of the same lattice, or, body-centred, of those
// of each of its two sublattices: float32, missing where a part is. A cube of bricks is summed when
// one of them is acquired for the first time, and kept; what nobody asks for is never summed.
// Ranges are the sums of the parts' and may be wider than the samples'. All members may be called
// from many threads.
class BlendedLattice final : public BrickSource {
 public:
  struct Part {
    std::shared_ptr<const BrickSource> source;  // Cartesian; of the sublattice's own samples
    double weight;                              // > 0
  };
  // `parts` of each sublattice, at least one, all of one brick edge; those of sublattices with a
  // range_reach half an index unit more than this field's, since they do not know of their shift.
  // `samples`: where the parts are coefficients, the samples' own sum; else null.
  BlendedLattice(const LatticeGeometry& geometry, std::array<std::vector<Part>, 2> parts,
                 double range_reach, std::shared_ptr<const BrickSource> samples = nullptr);
  ~BlendedLattice() override;
  BlendedLattice(const BlendedLattice&) = delete;
  BlendedLattice& operator=(const BlendedLattice&) = delete;

  const LatticeGeometry& geometry() const noexcept override { return geometry_; }
  int brick_edge() const noexcept override { return edge_; }
  ValueRange brick_range(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept override;
  double range_reach() const noexcept override { return range_reach_; }
  bool has_missing(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept override;
  // A cube of bricks around that one; valid as long as this lattice lives.
  BrickView acquire(std::int64_t bx, std::int64_t by, std::int64_t bz, double time) const override;
  std::size_t resident_bytes() const noexcept override;  // of the parts, and what is summed so far
  const BrickSource* samples() const noexcept override { return samples_.get(); }

 private:
  // Its samples; `cube` says where they lie, without them.
  std::unique_ptr<float[]> summed(const BrickView& cube) const;

  LatticeGeometry geometry_;
  std::array<std::vector<Part>, 2> parts_;
  double range_reach_;
  std::shared_ptr<const BrickSource> samples_;
  int edge_;
  Index3 num_cubes_{};
  mutable std::vector<std::atomic<const float*>> cubes_;  // null: not summed yet
  mutable std::atomic<std::size_t> summed_bytes_ = 0;
};

}  // namespace ovoid
