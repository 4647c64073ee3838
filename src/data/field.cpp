// SPDX-License-Identifier: Apache-2.0
#include "ovoid/field.h"

#include <atomic>
#include <utility>

#include "data/field_id.h"
#include "data/lattice/merged_range.h"
#include "data/validate.h"
#include "ovoid/error.h"

namespace ovoid {

namespace data {

std::uint64_t next_field_id() noexcept {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}  // namespace data

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
  if (value_range_.is_empty()) value_range_ = data::merged_range(samples());
  id_ = data::next_field_id();
  version_ = 1;
}

double LatticeField::default_sampling_distance() const noexcept {
  return source_ ? geometry().spacing().minCoeff() : 1.0;
}

// Every answer is the alternative's own.
bool Field::is_empty() const noexcept {
  return std::visit([](const auto& field) { return field.is_empty(); }, kind_);
}
std::int64_t Field::num_kernels() const noexcept {
  return std::visit([](const auto& field) { return field.num_kernels(); }, kind_);
}
Bounds3 Field::world_bounds() const {
  return std::visit([](const auto& field) -> Bounds3 { return field.world_bounds(); }, kind_);
}
ValueRange Field::value_range() const noexcept {
  return std::visit([](const auto& field) { return field.value_range(); }, kind_);
}
ValueRange Field::color_range() const noexcept {
  const KernelField* set = kernels();
  return set != nullptr ? set->color_range() : value_range();
}
Reconstruction Field::reconstruction() const noexcept {
  return std::visit([](const auto& field) { return field.reconstruction(); }, kind_);
}
double Field::default_sampling_distance() const noexcept {
  return std::visit([](const auto& field) { return field.default_sampling_distance(); }, kind_);
}
std::size_t Field::resident_bytes() const noexcept {
  if (is_empty()) return 0;
  return std::visit([](const auto& field) { return field.source().resident_bytes(); }, kind_);
}
std::uint64_t Field::id() const noexcept {
  return std::visit([](const auto& field) { return field.id(); }, kind_);
}
std::uint64_t Field::version() const noexcept {
  return std::visit([](const auto& field) { return field.version(); }, kind_);
}

}  // namespace ovoid
