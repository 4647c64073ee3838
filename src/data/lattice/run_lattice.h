// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "data/lattice/relevant_runs.h"
#include "data/lattice/resident_lattice.h"
#include "ovoid/field.h"

namespace ovoid {

// A brick source that holds the relevant samples of a lattice alone, as runs; all others have the
// runs' background. Bricks of 16 samples per axis (body-centred: of 16 x 16 samples and 32 layers,
// so that a brick is a cube of index space) are unpacked when they are acquired; one without runs
// is shared. Memory: the runs, 9 bytes per brick, one brick of background. Immutable; all members
// may be called from many threads.
class RunLattice final : public BrickSource {
 public:
  static constexpr int kBrickEdge = data::RelevantRuns::kGroupRows;

  // The runs' type is kUInt8, kInt8, kUInt16, kInt16 or kFloat32 and their box has the lattice's
  // dims. Throws Error: kInvalidArgument for anything else, a degenerate geometry, or options out
  // of range, kCancelled. Cost: every brick is unpacked once, with its surroundings.
  RunLattice(const LatticeGeometry& geometry, data::RelevantRuns runs,
             const ResidentLatticeOptions& options = {});

  const LatticeGeometry& geometry() const noexcept override { return geometry_; }
  int brick_edge() const noexcept override { return kBrickEdge; }
  double value_scale() const noexcept override { return value_scale_; }
  double value_offset() const noexcept override { return value_offset_; }
  // Of body-centred lattices the reach counts whole axis vectors: the ranges
  // are those of somewhat more samples than need be.
  ValueRange brick_range(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept override;
  double range_reach() const noexcept override { return range_reach_; }
  bool has_missing(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept override;
  // That brick alone; pinned by the view, or valid as long as this lattice lives.
  BrickView acquire(std::int64_t bx, std::int64_t by, std::int64_t bz, double time) const override;
  std::size_t resident_bytes() const noexcept override;

  const data::RelevantRuns& runs() const noexcept { return runs_; }

 private:
  std::size_t brick_index(const Index3& brick) const noexcept;
  template <class T>
  void find_range(const Index3& brick, std::vector<std::byte>& scratch);

  LatticeGeometry geometry_;
  data::RelevantRuns runs_;
  Index3 num_bricks_{};
  double range_reach_, value_scale_, value_offset_;
  std::vector<ValueRange> ranges_;     // values, of all bricks
  std::vector<std::uint8_t> missing_;  // of all bricks; bytes, since threads write neighbours
  std::vector<std::byte> background_;  // a brick of it
};

}  // namespace ovoid
