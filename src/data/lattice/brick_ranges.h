// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "ovoid/lattice.h"

namespace ovoid::data {

// Least and greatest stored number; lo > hi where there is none.
template <class T>
struct Extent {
  T lo;
  T hi;
};

// What the bricks of a linear array (x fastest) know about the samples that can reach them. Brick
// (bx, by, bz) stands at bx + nb.x * (by + nb.y * bz), nb = ceil(cells / edge).
template <class T>
struct BrickTable {
  std::vector<Extent<T>> extents;  // one per brick
  // One per brick, 1 if a sample in reach is missing; empty if no sample is.
  std::vector<std::uint8_t> missing;
  std::int64_t num_missing = 0;  // samples that are NaN or infinite
};

struct BrickTableOptions {
  int edge = 4;        // cells per brick and axis
  double reach = 2.0;  // support radius of the kernels, index units, >= 0
  LatticeKind kind = LatticeKind::kCartesian;
  int threads = 0;  // 0: one per hardware thread
  std::stop_token stop{};
};

// Reads dims.x * dims.y * dims.z numbers of type uint8, int8, uint16, int16 or float. Brick b of an
// axis takes samples at positions b * edge - reach to (b + 1) * edge + reach, both included: what a
// kernel can bring to a position in its cells, their far end included so that rounding of positions
// is harmless. Positions before the first and behind the last sample belong to the first and the
// last brick; no sample reaches them that does not reach the brick's cells. The result does not
// depend on the number of threads. Throws Error(kCancelled). Cost: (edge + 2 reach + 1) / edge
// reads of the array from cache, one from memory.
template <class T>
BrickTable<T> make_brick_table(const T* samples, const Index3& dims,
                               const BrickTableOptions& options);

extern template BrickTable<std::uint8_t> make_brick_table(const std::uint8_t*, const Index3&,
                                                          const BrickTableOptions&);
extern template BrickTable<std::int8_t> make_brick_table(const std::int8_t*, const Index3&,
                                                         const BrickTableOptions&);
extern template BrickTable<std::uint16_t> make_brick_table(const std::uint16_t*, const Index3&,
                                                           const BrickTableOptions&);
extern template BrickTable<std::int16_t> make_brick_table(const std::int16_t*, const Index3&,
                                                          const BrickTableOptions&);
extern template BrickTable<float> make_brick_table(const float*, const Index3&,
                                                   const BrickTableOptions&);

}  // namespace ovoid::data
