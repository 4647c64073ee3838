// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/resident_lattice.h"

#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <utility>

#include "data/scalar_visit.h"
#include "data/validate.h"
#include "ovoid/error.h"

namespace ovoid {

namespace {

[[noreturn]] void refuse_samples(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

void validate(const Bytes& samples, ScalarType type, const Index3& dims) {
  const std::size_t expected = static_cast<std::size_t>(num_samples(dims)) * size_of(type);
  if (samples.view.size() != expected) {
    refuse_samples(fmt::format("samples: {} bytes, must be {} for {} x {} x {} of {}",
                               samples.view.size(), expected, dims[0], dims[1], dims[2],
                               name_of(type)));
  }
  if (reinterpret_cast<std::uintptr_t>(samples.view.data()) % size_of(type) != 0) {
    refuse_samples(
        fmt::format("samples: must be aligned to {} bytes for {}", size_of(type), name_of(type)));
  }
}

}  // namespace

void ResidentLatticeOptions::validate() const {
  if (!(range_reach >= 0) || !std::isfinite(range_reach)) {
    refuse_samples(fmt::format("range_reach = {}: must be >= 0 and finite", range_reach));
  }
  if (!std::isfinite(value_scale) || value_scale == 0) {
    refuse_samples(fmt::format("value_scale = {}: must be finite and not 0", value_scale));
  }
  if (!std::isfinite(value_offset)) {
    refuse_samples(fmt::format("value_offset = {}: must be finite", value_offset));
  }
}

bool ResidentLattice::can_show(ScalarType type) noexcept {
  return type == ScalarType::kUInt8 || type == ScalarType::kInt8 || type == ScalarType::kUInt16 ||
         type == ScalarType::kInt16 || type == ScalarType::kFloat32;
}

ResidentLattice::ResidentLattice(const LatticeGeometry& geometry, ScalarType type, Bytes samples,
                                 const ResidentLatticeOptions& options)
    : geometry_(geometry),
      type_(type),
      samples_(std::move(samples)),
      range_reach_(options.range_reach),
      value_scale_(options.value_scale),
      value_offset_(options.value_offset) {
  data::validate_geometry(geometry_);
  if (!can_show(type)) {
    refuse_samples(
        fmt::format("type = {}: must be uint8, int8, uint16, int16 or float32", name_of(type)));
  }
  options.validate();
  validate(samples_, type, geometry_.dims);
  const Index3 cells = geometry_.cells();
  for (int a = 0; a < 3; ++a) num_bricks_[a] = (cells[a] + kBrickEdge - 1) / kBrickEdge;

  const data::BrickTableOptions table_options = {kBrickEdge, options.range_reach, geometry_.kind,
                                                 options.threads, options.stop};
  const auto build = [&]<class T>(std::type_identity<T>) {
    data::BrickTable<T> table = data::make_brick_table(
        reinterpret_cast<const T*>(samples_.view.data()), geometry_.dims, table_options);
    extents_ = std::move(table.extents);
    missing_ = std::move(table.missing);
    num_missing_ = table.num_missing;
  };
  data::visit_scalar(type, [&]<class T>(std::type_identity<T> tag) {
    if constexpr (std::is_same_v<T, float> || (std::is_integral_v<T> && sizeof(T) <= 2)) build(tag);
  });
}

std::int64_t ResidentLattice::brick_index(std::int64_t bx, std::int64_t by,
                                          std::int64_t bz) const noexcept {
  assert(bx >= 0 && bx < num_bricks_[0] && by >= 0 && by < num_bricks_[1] && bz >= 0 &&
         bz < num_bricks_[2]);
  return bx + num_bricks_[0] * (by + num_bricks_[1] * bz);
}

ValueRange ResidentLattice::brick_range(std::int64_t bx, std::int64_t by,
                                        std::int64_t bz) const noexcept {
  const std::int64_t index = brick_index(bx, by, bz);
  const ValueRange stored = std::visit(
      [index](const auto& extents) {
        const auto& extent = extents[static_cast<std::size_t>(index)];
        return ValueRange{static_cast<float>(extent.lo), static_cast<float>(extent.hi)};
      },
      extents_);
  if (stored.is_empty()) return {};
  if (value_scale_ == 1.0 && value_offset_ == 0.0) return stored;
  const auto lo = static_cast<float>(stored.lo * value_scale_ + value_offset_);
  const auto hi = static_cast<float>(stored.hi * value_scale_ + value_offset_);
  return value_scale_ > 0 ? ValueRange{lo, hi} : ValueRange{hi, lo};
}

bool ResidentLattice::has_missing(std::int64_t bx, std::int64_t by,
                                  std::int64_t bz) const noexcept {
  return !missing_.empty() && missing_[static_cast<std::size_t>(brick_index(bx, by, bz))] != 0;
}

BrickView ResidentLattice::acquire(std::int64_t, std::int64_t, std::int64_t, double) const {
  const Index3& dims = geometry_.dims;
  return {samples_.view.data(), type_, {0, 0, 0}, dims, dims[0], dims[0] * dims[1], nullptr};
}

std::size_t ResidentLattice::resident_bytes() const noexcept {
  const std::size_t extents =
      std::visit([](const auto& e) { return e.size() * sizeof(e[0]); }, extents_);
  return samples_.view.size() + extents + missing_.size();
}

}  // namespace ovoid
