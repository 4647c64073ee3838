// SPDX-License-Identifier: Apache-2.0
#include "ovoid/lattice.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <numbers>

#include "data/validate.h"
#include "ovoid/error.h"

namespace ovoid {

namespace {

struct ScalarTraits {
  std::size_t size;
  const char* name;
  bool is_floating;
};

// In the order of ScalarType.
constexpr ScalarTraits kScalars[] = {
    {1, "uint8", false},  {1, "int8", false},   {2, "uint16", false}, {2, "int16", false},
    {4, "uint32", false}, {4, "int32", false},  {8, "uint64", false}, {8, "int64", false},
    {4, "float32", true}, {8, "float64", true},
};
static_assert(std::size(kScalars) == static_cast<std::size_t>(ScalarType::kFloat64) + 1);

const ScalarTraits& traits_of(ScalarType type) noexcept {
  return kScalars[static_cast<std::size_t>(type)];
}

}  // namespace

std::size_t size_of(ScalarType type) noexcept { return traits_of(type).size; }
const char* name_of(ScalarType type) noexcept { return traits_of(type).name; }
bool is_floating(ScalarType type) noexcept { return traits_of(type).is_floating; }

const char* name_of(LatticeKind kind) noexcept {
  return kind == LatticeKind::kBodyCentred ? "body-centred" : "cartesian";
}

Vec3 LatticeGeometry::index_position(const Index3& sample) const noexcept {
  const auto at = [&](int a) { return static_cast<double>(sample[static_cast<std::size_t>(a)]); };
  if (kind == LatticeKind::kCartesian) return {at(0), at(1), at(2)};
  const double shift = sample[2] % 2 == 0 ? 0.0 : 0.5;
  return {at(0) + shift, at(1) + shift, 0.5 * at(2)};
}

double LatticeGeometry::unit_spacing() const noexcept {
  return kind == LatticeKind::kBodyCentred ? 1 / std::numbers::sqrt2 : 1.0;
}

Vec3 LatticeGeometry::spacing() const {
  return unit_spacing() * world_from_index.linear().colwise().norm().transpose();
}

Bounds3 LatticeGeometry::index_bounds(const Index3& lo, const Index3& hi) const {
  const double count = num_sublattices();
  const double half = 0.5 / count;  // of the distance of planes of samples
  Bounds3 box;
  for (int a = 0; a < 3; ++a) {
    const double per_sample = a == 2 ? 1 / count : 1.0;
    const double shift = a == 2 ? 0.0 : offset_of(num_sublattices() - 1)[a];
    const auto i = static_cast<std::size_t>(a);
    box.min()[a] = static_cast<double>(lo[i]) * per_sample - half;
    box.max()[a] = static_cast<double>(hi[i]) * per_sample + shift + half;
  }
  return box;
}

Bounds3 LatticeGeometry::world_bounds() const {
  const Bounds3 box = index_bounds();
  Bounds3 world;
  for (int corner = 0; corner < 8; ++corner) {
    world.extend(world_from_index * box.corner(static_cast<Bounds3::CornerType>(corner)));
  }
  return world;
}

namespace {

void require_rescalable(const LatticeGeometry& cartesian, double spacing_scale) {
  data::validate_geometry(cartesian);
  if (cartesian.kind != LatticeKind::kCartesian)
    throw Error(ErrorCode::kInvalidArgument, "lattice: must be cartesian");
  if (!(spacing_scale > 0) || !std::isfinite(spacing_scale)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("spacing_scale = {}: must be > 0 and finite", spacing_scale));
  }
}

}  // namespace

LatticeGeometry cartesian_like(const LatticeGeometry& cartesian, double spacing_scale) {
  require_rescalable(cartesian, spacing_scale);
  LatticeGeometry lattice = cartesian;
  for (std::int64_t& n : lattice.dims)
    n = std::llround(static_cast<double>(n - 1) / spacing_scale) + 1;
  lattice.world_from_index.scale(spacing_scale);
  data::validate_geometry(lattice);
  return lattice;
}

LatticeGeometry body_centred_like(const LatticeGeometry& cartesian, double spacing_scale) {
  require_rescalable(cartesian, spacing_scale);
  const double unit = std::numbers::sqrt2 * spacing_scale;
  LatticeGeometry lattice;
  lattice.kind = LatticeKind::kBodyCentred;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto extent = static_cast<double>(cartesian.dims[a] - 1);
    const double count = a == 2 ? 2 * extent / unit : extent / unit;
    lattice.dims[a] = std::llround(count) + 1;
  }
  lattice.world_from_index = cartesian.world_from_index;
  lattice.world_from_index.scale(unit);
  data::validate_geometry(lattice);
  return lattice;
}

}  // namespace ovoid
