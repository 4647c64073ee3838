// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "ovoid/math.h"

namespace ovoid {

// The stored type of one sample. The order is part of the interface: io tables index by it.
enum class ScalarType : std::uint8_t {
  kUInt8,
  kInt8,
  kUInt16,
  kInt16,
  kUInt32,
  kInt32,
  kUInt64,
  kInt64,
  kFloat32,
  kFloat64
};

std::size_t size_of(ScalarType type) noexcept;  // bytes
const char* name_of(ScalarType type) noexcept;  // "uint8", "float32", ...
bool is_floating(ScalarType type) noexcept;

// Index in a lattice or count of samples along each axis, x fastest in memory.
using Index3 = std::array<std::int64_t, 3>;

inline std::int64_t num_samples(const Index3& dims) noexcept { return dims[0] * dims[1] * dims[2]; }

// A regular arrangement of samples. `world_from_index` maps the index (i, j, k) to the world
// position of that sample; its columns are the axis vectors (direction times spacing) and may be
// oblique or left-handed, but not degenerate.
struct LatticeGeometry {
  Index3 dims{0, 0, 0};                            // samples along x, y, z; each >= 1
  Affine3 world_from_index = Affine3::Identity();  // finite, |determinant| > 0

  Vec3 spacing() const;  // lengths of the axis vectors, world units
  // The box [-1/2, dims - 1/2] in index space: each sample's own cell. Where a normalized field is
  // defined lies within it, but for 0.02 spacings, in proportion to the kernels' width
  // (docs/numerics.md).
  Bounds3 index_bounds() const;
  Bounds3 world_bounds()
      const;  // axis-aligned box around the corners of index_bounds(), world units
};

}  // namespace ovoid
