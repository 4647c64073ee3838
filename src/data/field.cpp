// SPDX-License-Identifier: Apache-2.0
#include "ovoid/field.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "data/validate.h"
#include "ovoid/error.h"

namespace ovoid {

namespace {

std::uint64_t next_field_id() noexcept {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

// Every sample lies in the range of at least its own brick.
ValueRange merged_range(const BrickSource& source) noexcept {
  const Index3& dims = source.geometry().dims;
  const std::int64_t edge = source.brick_edge();
  ValueRange merged;
  for (std::int64_t bz = 0; bz * edge < dims[2]; ++bz) {
    for (std::int64_t by = 0; by * edge < dims[1]; ++by) {
      for (std::int64_t bx = 0; bx * edge < dims[0]; ++bx) {
        const ValueRange range = source.brick_range(bx, by, bz);
        if (range.is_empty()) continue;
        if (merged.is_empty()) {
          merged = range;
        } else {
          merged = {std::min(merged.lo, range.lo), std::max(merged.hi, range.hi)};
        }
      }
    }
  }
  return merged;
}

}  // namespace

LatticeField::LatticeField(std::shared_ptr<const BrickSource> source, LatticeKernel kernel,
                           Reconstruction reconstruction)
    : source_(std::move(source)), kernel_(kernel), reconstruction_(reconstruction) {
  if (!source_) {
    throw Error(ErrorCode::kInvalidArgument, "source = null: a field needs a brick source");
  }
  data::validate_geometry(source_->geometry());
  data::validate_kernel(kernel_);
  value_range_ = merged_range(*source_);
  id_ = next_field_id();
  version_ = 1;
}

double LatticeField::default_sampling_distance() const noexcept {
  return geometry().spacing().minCoeff();
}

}  // namespace ovoid
