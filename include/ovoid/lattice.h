// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "ovoid/export.h"
#include "ovoid/math.h"

namespace OVOID_API ovoid {

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

// How the samples of a lattice lie to each other.
enum class LatticeKind : std::uint8_t {
  kCartesian,    // one sample per cell of the axis vectors
  kBodyCentred,  // two: one at the cell's corner, one in its middle (BCC)
};
const char* name_of(LatticeKind kind) noexcept;  // "cartesian", "body-centred"

// A regular arrangement of samples: of one sublattice (Cartesian), or of two that are alike but for
// a shift by half of each axis vector (body-centred). Positions in units of the axis vectors are in
// INDEX SPACE; `world_from_index` maps it to the world; its columns are the axis vectors and may be
// oblique or left-handed, but not degenerate.
//
// Samples are kept as layers [dims[2]][dims[1]][dims[0]], x fastest. Sample (i, j, k) is at index
// position (i, j, k), or, body-centred, in layer k / 2 of sublattice k mod 2: at (i, j, k / 2) if k
// is even and (i + 1/2, j + 1/2, k / 2) if k is odd, k / 2 not rounded.
struct LatticeGeometry {
  Index3 dims{0, 0, 0};                            // samples along x, y and layers; each >= 1
  Affine3 world_from_index = Affine3::Identity();  // finite, |determinant| > 0
  LatticeKind kind = LatticeKind::kCartesian;

  // Sublattices, their offsets in index space and their own samples.
  int num_sublattices() const noexcept { return kind == LatticeKind::kBodyCentred ? 2 : 1; }
  Vec3 offset_of(int sublattice) const noexcept { return Vec3::Constant(0.5 * sublattice); }
  Index3 dims_of(int sublattice) const noexcept {
    return {dims[0], dims[1], (dims[2] - sublattice + num_sublattices() - 1) / num_sublattices()};
  }
  Vec3 index_position(const Index3& sample) const noexcept;
  Index3 cells() const noexcept { return dims_of(0); }  // of the axis vectors along each axis

  // T, the spacing that sets the width of kernels, in index units: 1, or 1 / sqrt(2) where it is
  // that of the Cartesian lattice that keeps the same (spherically band-limited) signals with
  // sqrt(2) times as many samples [Theussl 2001].
  double unit_spacing() const noexcept;
  Vec3 spacing() const;  // T along each axis vector, world units

  // Samples per unit of index space.
  double density() const noexcept { return num_sublattices(); }
  // The box in index space of the samples lo to hi, both included: half of the distance of
  // neighbouring planes of samples beyond the outermost, which is [lo - 1/2, hi + 1/2], or, body-
  // centred, [lo - 1/4, hi + 3/4] along x and y and [lo / 2 - 1/4, hi / 2 + 1/4] for layers.
  Bounds3 index_bounds(const Index3& lo, const Index3& hi) const;
  // Of all samples. Where a normalized field is defined lies within it, but for 0.02 spacings, in
  // proportion to the kernels' width, and body-centred in front of single samples for a quarter of
  // an axis vector at most (docs/numerics.md).
  Bounds3 index_bounds() const {
    return index_bounds({0, 0, 0}, {dims[0] - 1, dims[1] - 1, dims[2] - 1});
  }
  Bounds3 world_bounds()
      const;  // axis-aligned box around the corners of index_bounds(), world units
};

// The Cartesian lattice of another spacing whose first sample is on that of `cartesian`, and which
// has round((n - 1) / spacing_scale) + 1 samples along each axis. Throws as body_centred_like().
LatticeGeometry cartesian_like(const LatticeGeometry& cartesian, double spacing_scale);

// A body-centred lattice whose T is the spacing of a Cartesian one and which has samples wherever
// that has: round((n - 1) / sqrt(2)) + 1 along x and y and round((n - 1) sqrt(2)) + 1 layers, its
// first sample on the other's first. 128 x 128 x 128 becomes 91 x 91 x 181. `spacing_scale`: T in
// spacings of the other. Throws Error(kInvalidArgument) unless it is finite and > 0 and `cartesian`
// is Cartesian and valid. Source: [Neophytou 2006, section 2.4].
LatticeGeometry body_centred_like(const LatticeGeometry& cartesian, double spacing_scale = 1.0);

}  // namespace ovoid
