// SPDX-License-Identifier: Apache-2.0
#include "placed_lattice.h"

#include <memory>
#include <utility>

namespace ovoid::mappers {
namespace {

class PlacedLattice final : public BrickSource {
 public:
  // `owner` keeps `source` alive.
  PlacedLattice(std::shared_ptr<const void> owner, const BrickSource& source,
                const Affine3& world_from_data)
      : owner_(std::move(owner)), source_(source), geometry_(source.geometry()) {
    geometry_.world_from_index = world_from_data * geometry_.world_from_index;
    if (source.samples() != nullptr)
      samples_ = std::make_unique<PlacedLattice>(owner_, *source.samples(), world_from_data);
  }

  const LatticeGeometry& geometry() const noexcept override { return geometry_; }
  int brick_edge() const noexcept override { return source_.brick_edge(); }
  double value_scale() const noexcept override { return source_.value_scale(); }
  double value_offset() const noexcept override { return source_.value_offset(); }
  ValueRange brick_range(std::int64_t bx, std::int64_t by,
                         std::int64_t bz) const noexcept override {
    return source_.brick_range(bx, by, bz);
  }
  double range_reach() const noexcept override { return source_.range_reach(); }
  bool has_missing(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept override {
    return source_.has_missing(bx, by, bz);
  }
  BrickView acquire(std::int64_t bx, std::int64_t by, std::int64_t bz, double time) const override {
    return source_.acquire(bx, by, bz, time);
  }
  std::size_t resident_bytes() const noexcept override { return source_.resident_bytes(); }
  const BrickSource* samples() const noexcept override { return samples_.get(); }

 private:
  std::shared_ptr<const void> owner_;
  const BrickSource& source_;
  LatticeGeometry geometry_;
  std::unique_ptr<const PlacedLattice> samples_;
};

}  // namespace

LatticeField placed(const LatticeField& field, const Affine3& world_from_data) {
  if (world_from_data.isApprox(Affine3::Identity(), 0.0)) return field;
  const auto owner = std::make_shared<const LatticeField>(field);
  return {std::make_shared<PlacedLattice>(owner, owner->source(), world_from_data), field.kernel(),
          field.reconstruction(), field.value_range()};
}

}  // namespace ovoid::mappers
