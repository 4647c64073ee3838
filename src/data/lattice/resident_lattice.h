// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stop_token>
#include <variant>
#include <vector>

#include "data/lattice/brick_ranges.h"
#include "ovoid/dataset.h"
#include "ovoid/field.h"

namespace ovoid {

// What a resident lattice needs to know beside its samples.
struct ResidentLatticeOptions {
  // Support radius of the kernels that will be used, index units, finite, >= 0.
  double range_reach = 2.0;
  double value_scale = 1.0;  // value = stored number * scale + offset; finite, scale not 0
  double value_offset = 0.0;
  int threads = 0;  // for the brick ranges; 0: one per hardware thread
  std::stop_token stop{};

  void validate() const;  // throws Error(kInvalidArgument)
};

// A brick source over one linear array in memory (x fastest), which is borrowed, not copied:
// acquire() shows the whole array whatever brick is asked for. Bricks of 4 cells per axis; the
// brick ranges, two stored numbers for up to 64 samples (body-centred: 128), are found on
// construction. Memory: samples
// + 3 % (bricks that the lattice's faces cut hold fewer samples: a single slice has + 12 %), and
// one byte per brick if any sample is missing. Positions before the first sample belong to the
// first brick, those behind the last to the last one. Immutable; all members may be called from
// many threads.
class ResidentLattice : public BrickSource {
 public:
  static constexpr int kBrickEdge = 4;

  // `type` is kUInt8, kInt8, kUInt16, kInt16 or kFloat32; `samples` holds num_samples(dims) of
  // them, native byte order, aligned to the type. Throws Error: kInvalidArgument for anything else
  // or a degenerate geometry, kCancelled.
  ResidentLattice(const LatticeGeometry& geometry, ScalarType type, Bytes samples,
                  const ResidentLatticeOptions& options = {});

  // The types a BrickView can show.
  static bool can_show(ScalarType type) noexcept;

  const LatticeGeometry& geometry() const noexcept override { return geometry_; }
  int brick_edge() const noexcept override { return kBrickEdge; }
  double value_scale() const noexcept override { return value_scale_; }
  double value_offset() const noexcept override { return value_offset_; }

  // Values (scaled; rounded to the nearest float). See make_brick_table() for which samples count.
  ValueRange brick_range(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept override;
  double range_reach() const noexcept override { return range_reach_; }
  bool has_missing(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept override;

  // The whole array; valid as long as this lattice lives (the view's pin is empty, so that threads
  // share no counter).
  BrickView acquire(std::int64_t bx, std::int64_t by, std::int64_t bz, double time) const override;
  std::size_t resident_bytes() const noexcept override;

  std::int64_t num_missing() const noexcept { return num_missing_; }

 private:
  template <class T>
  using Extents = std::vector<data::Extent<T>>;

  std::int64_t brick_index(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept;

  LatticeGeometry geometry_;
  ScalarType type_;
  Bytes samples_;
  Index3 num_bricks_{};
  double range_reach_;
  double value_scale_;
  double value_offset_;
  std::variant<Extents<std::uint8_t>, Extents<std::int8_t>, Extents<std::uint16_t>,
               Extents<std::int16_t>, Extents<float>>
      extents_;
  std::vector<std::uint8_t> missing_;
  std::int64_t num_missing_ = 0;
};

}  // namespace ovoid
