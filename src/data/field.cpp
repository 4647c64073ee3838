// SPDX-License-Identifier: Apache-2.0
#include "ovoid/field.h"

#include <atomic>
#include <utility>

#include "data/merged_range.h"
#include "data/validate.h"
#include "ovoid/error.h"

namespace ovoid {

namespace {

std::uint64_t next_field_id() noexcept {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}  // namespace

LatticeField::LatticeField(std::shared_ptr<const BrickSource> source, LatticeKernel kernel,
                           Reconstruction reconstruction, ValueRange value_range)
    : source_(std::move(source)),
      kernel_(kernel),
      reconstruction_(reconstruction),
      value_range_(value_range) {
  if (!source_) {
    throw Error(ErrorCode::kInvalidArgument, "source = null: a field needs a brick source");
  }
  data::validate_geometry(source_->geometry());
  data::validate_kernel(kernel_);
  if (value_range_.is_empty()) value_range_ = data::merged_range(*source_);
  id_ = next_field_id();
  version_ = 1;
}

double LatticeField::default_sampling_distance() const noexcept {
  return geometry().spacing().minCoeff();
}

}  // namespace ovoid
