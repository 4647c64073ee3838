// SPDX-License-Identifier: Apache-2.0
#include "ovoid/lattice.h"

#include <iterator>

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

Vec3 LatticeGeometry::spacing() const {
  return world_from_index.linear().colwise().norm().transpose();
}

Bounds3 LatticeGeometry::index_bounds() const {
  const Vec3 half = Vec3::Constant(0.5);
  return {-half, Vec3(static_cast<double>(dims[0]), static_cast<double>(dims[1]),
                      static_cast<double>(dims[2])) -
                     half};
}

Bounds3 LatticeGeometry::world_bounds() const {
  const Bounds3 box = index_bounds();
  Bounds3 world;
  for (int corner = 0; corner < 8; ++corner) {
    world.extend(world_from_index * box.corner(static_cast<Bounds3::CornerType>(corner)));
  }
  return world;
}

}  // namespace ovoid
