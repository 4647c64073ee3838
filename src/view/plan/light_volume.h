// SPDX-License-Identifier: Apache-2.0
// How much of the light arrives where, on a coarse lattice (docs/numerics.md, "Light from a coarse
// volume"). Every back end reads the same numbers.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "ovoid/lattice.h"
#include "ovoid/math.h"

namespace ovoid::view {

// Where the light on a surface is read, in cell edges from it: beyond the cells that the surface is
// blurred into.
inline constexpr double kEdgesAway = 2;

// Shares of the light that arrive at a place: of the light from everywhere and of that from the
// key. In [0, 1].
struct ArrivingLight {
  double around = 1, key = 1;
};

// What is left of a colour that is not lit.
inline double unlit_share(const ArrivingLight& light) { return light.around * light.key; }

// Both shares in one float, a whole number of 24 bits, so that a shader and a SIMD register read
// both at once: key * kLightSteps, rounded, times kLightRadix, plus around * kLightSteps, rounded.
inline constexpr float kLightSteps = 4095;
inline constexpr float kLightRadix = 4096;

inline float packed_light(const ArrivingLight& light) {
  const auto steps = [](double share) {
    return std::round(static_cast<float>(std::clamp(share, 0.0, 1.0)) * kLightSteps);
  };
  return steps(light.key) * kLightRadix + steps(light.around);
}

inline ArrivingLight unpacked_light(float packed) {
  const float key = std::floor(packed / kLightRadix);
  return {(packed - key * kLightRadix) / kLightSteps, key / kLightSteps};
}

// How far along the normal a place is moved before its light is read, in cell edges, so that a
// surface does not hide its own light: one towards the side that is seen, less where the field is
// flat, and less where the normal turns away from the eye, as that side is not certain there. The
// rest of one cell edge goes towards the eye. `towards_eye`: cosine between normal and eye.
inline constexpr double kLightSteepness = 4;
inline double light_shift(double towards_eye, double flatness) {
  return flatness * std::clamp(kLightSteepness * towards_eye, -1.0, 1.0);
}

struct LightVolume {
  Index3 dims{};  // at least 2 along each axis
  // To cell coordinates, in which the middle of cell (i, j, k) is at (i, j, k). Beyond the
  // outermost middles the light is theirs.
  Affine3 cell_from_world = Affine3::Identity();
  double cell_edge = 1;       // world: the mean edge of a cell
  bool has_key = true;        // false: all of the key's light arrives everywhere
  std::vector<float> packed;  // [dims[2]][dims[1]][dims[0]]

  // Straight between the middles of cells, along each axis.
  ArrivingLight at(const Vec3& world) const {
    const Vec3 place = cell_from_world * world;
    std::int64_t cell[3];
    double fraction[3];
    for (int a = 0; a < 3; ++a) {
      const auto last = static_cast<double>(dims[static_cast<std::size_t>(a)] - 1);
      const double inside = place[a] > 0 ? std::min(place[a], last) : 0.0;  // also of no number
      const double whole = std::min(std::floor(inside), last - 1);
      cell[a] = static_cast<std::int64_t>(whole);
      fraction[a] = inside - whole;
    }
    ArrivingLight sum{0, 0};
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::int64_t at[3];
      for (int a = 0; a < 3; ++a) {
        const int side = corner >> a & 1;
        weight *= side != 0 ? fraction[a] : 1 - fraction[a];
        at[a] = cell[a] + side;
      }
      const ArrivingLight there = unpacked_light(
          packed[static_cast<std::size_t>((at[2] * dims[1] + at[1]) * dims[0] + at[0])]);
      sum.around += weight * there.around;
      sum.key += weight * there.key;
    }
    return sum;
  }

  // Of a place with a normal, seen from the direction `to_eye`, both of unit length; read so many
  // cell edges away from it.
  ArrivingLight arriving_at(const Vec3& world, const Vec3& normal, const Vec3& to_eye,
                            double flatness, double edges = 1) const {
    const double shift = light_shift(normal.dot(to_eye), flatness);
    return at(world + edges * cell_edge * (shift * normal + (1 - std::abs(shift)) * to_eye));
  }
};

}  // namespace ovoid::view
