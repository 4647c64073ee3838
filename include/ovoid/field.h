// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <variant>

#include "ovoid/export.h"
#include "ovoid/kernel_field.h"
#include "ovoid/kernels.h"
#include "ovoid/lattice.h"

namespace OVOID_API ovoid {

// Samples of a lattice somewhere in memory, as acquired from a brick source: sample (i, j, k) of
// the lattice, k the layer, for lo <= (i, j, k) < hi, is at data + ((i - lo.x) + (j - lo.y) *
// stride_y + (k - lo.z) * stride_z) * size_of(type).
struct BrickView {
  const void* data = nullptr;
  ScalarType type = ScalarType::kFloat32;  // kUInt8, kInt8, kUInt16, kInt16 or kFloat32; NaN and
                                           // infinities in kFloat32 are missing
  Index3 lo{};                             // first sample
  Index3 hi{};                             // one past the last
  std::int64_t stride_y = 0;               // samples
  std::int64_t stride_z = 0;               // samples
  std::shared_ptr<const void> pin;         // keeps `data` valid while the view lives; may be empty
};

// Where a lattice field gets its samples: in memory, out of core, varying in time or kept by
// another process, all behind this one interface. The lattice is cut into bricks of brick_edge()
// cells per axis, and there are ceil(cells / edge) along each; brick (bx, by, bz) is the box [b *
// edge, (b + 1) * edge) of index space with the samples of all sublattices in it: bx * edge <= i <
// min((bx + 1) * edge, dims.x), y likewise, and layers bz * edge * num_sublattices and following.
// Implementations are immutable and all members are called from many threads at once. A sample's
// stored number s stands for the value s * value_scale() + value_offset().
class BrickSource {
 public:
  virtual ~BrickSource() = default;

  virtual const LatticeGeometry& geometry() const noexcept = 0;
  virtual int brick_edge()
      const noexcept = 0;  // a power of two, 4 to 64; 4 skips best, larger costs less to keep

  virtual double value_scale() const noexcept { return 1.0; }
  virtual double value_offset() const noexcept { return 0.0; }

  // Value range of ALL samples that a kernel of support radius range_reach() can bring to a
  // position inside the brick's cells [b * edge, (b + 1) * edge) (index space, every axis), missing
  // ones excluded. Empty if there is none. Cheap: called for every brick and frame.
  virtual ValueRange brick_range(std::int64_t bx, std::int64_t by,
                                 std::int64_t bz) const noexcept = 0;
  virtual double range_reach() const noexcept = 0;  // index units

  // True if a sample that reaches the brick (as above) is missing; then weights are summed there,
  // else known.
  virtual bool has_missing(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept = 0;

  // The samples of one brick at a time (ignored by data without time). The view covers at least the
  // brick and may cover more. Throws Error (file trouble of out-of-core data).
  virtual BrickView acquire(std::int64_t bx, std::int64_t by, std::int64_t bz,
                            double time) const = 0;

  virtual std::size_t resident_bytes() const noexcept = 0;  // memory held, samples and ranges

  // Where this holds coefficients (prefiltered), the samples that they were made of, of the same
  // geometry; else null.
  virtual const BrickSource* samples() const noexcept { return nullptr; }
};

// What is drawn: kernels on a lattice and how they are summed. A value type: copies share the data.
// Identity and version tell back ends what they may keep between frames: equal (id, version) means
// equal data.
class LatticeField {
 public:
  // An empty field: no samples, empty bounds and range. source(), geometry() and index_kernel() are
  // not to be called on it, and functions that take a field refuse it, Error(kInvalidArgument).
  LatticeField() = default;
  // `value_range`: of the samples that exist; empty: taken from the brick ranges of the samples. To
  // be given where the source holds coefficients (prefiltered) and does not know the samples.
  // Throws Error(kInvalidArgument) for a null source, a degenerate geometry or a kernel out of
  // range.
  LatticeField(std::shared_ptr<const BrickSource> source, LatticeKernel kernel,
               Reconstruction reconstruction, ValueRange value_range = {});

  bool is_empty() const noexcept { return source_ == nullptr; }
  const BrickSource& source() const noexcept { return *source_; }
  // The samples as the data have them, which looks and histograms are about; of a prefiltered field
  // source() holds coefficients instead. Where a source does not know its samples, itself.
  const BrickSource& samples() const noexcept {
    const BrickSource* samples = source_->samples();
    return samples != nullptr ? *samples : *source_;
  }
  const LatticeGeometry& geometry() const noexcept { return source_->geometry(); }
  const LatticeKernel& kernel() const noexcept { return kernel_; }
  // The kernel in index units, where spacings of a body-centred lattice are 1 / sqrt(2).
  LatticeKernel index_kernel() const noexcept {
    return {kernel_.sigma * geometry().unit_spacing(), kernel_.cutoff, kernel_.kind};
  }
  Reconstruction reconstruction() const noexcept { return reconstruction_; }

  std::int64_t num_kernels() const noexcept { return source_ ? num_samples(geometry().dims) : 0; }
  Bounds3 world_bounds() const { return source_ ? geometry().world_bounds() : Bounds3(); }
  ValueRange value_range() const noexcept {
    return value_range_;
  }  // of the samples that exist, not of coefficients
  double default_sampling_distance() const noexcept;  // the smallest spacing, world units; empty: 1
  std::uint64_t id() const noexcept { return id_; }
  std::uint64_t version() const noexcept { return version_; }

 private:
  std::shared_ptr<const BrickSource> source_;
  LatticeKernel kernel_;
  Reconstruction reconstruction_ = Reconstruction::kNormalized;
  ValueRange value_range_;
  std::uint64_t id_ = 0;
  std::uint64_t version_ = 0;
};

// What a renderer takes: a lattice field or a kernel field. A value type, made from either.
class Field {
 public:
  Field() = default;                                      // an empty lattice field
  Field(LatticeField field) : kind_(std::move(field)) {}  // NOLINT(google-explicit-constructor)
  Field(KernelField field) : kind_(std::move(field)) {}   // NOLINT(google-explicit-constructor)

  // The field if it is of that kind, else null.
  const LatticeField* lattice() const noexcept { return std::get_if<LatticeField>(&kind_); }
  const KernelField* kernels() const noexcept { return std::get_if<KernelField>(&kind_); }

  // What both kinds have, as their own members say.
  bool is_empty() const noexcept;
  std::int64_t num_kernels() const noexcept;
  Bounds3 world_bounds() const;
  ValueRange value_range() const noexcept;
  ValueRange color_range() const noexcept;  // of a lattice: value_range()
  Reconstruction reconstruction() const noexcept;
  double default_sampling_distance() const noexcept;
  std::size_t resident_bytes() const noexcept;
  std::uint64_t id() const noexcept;
  std::uint64_t version() const noexcept;

 private:
  std::variant<LatticeField, KernelField> kind_;
};

}  // namespace ovoid
