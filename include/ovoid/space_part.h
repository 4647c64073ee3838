// SPDX-License-Identifier: Apache-2.0
// Parts of space, each of which somebody draws: one picture's work for several processes.
// docs/numerics.md, "Parts of a picture".
#pragma once

#include <cstdint>
#include <vector>

#include "ovoid/camera.h"
#include "ovoid/export.h"
#include "ovoid/field.h"
#include "ovoid/math.h"

namespace OVOID_API ovoid {

// A convex part of space: what lies on the named side of each plane. Without planes it is all of
// it. Parts that share a plane say so with the same numbers, so that each place belongs to one.
struct SpacePart {
  struct Side {
    Vec3 normal{1, 0, 0};  // need not have unit length
    double offset = 0;
    bool is_beyond = true;  // dot(normal, x) >= offset; else less
  };
  std::vector<Side> sides;
};

// Space in `count` parts with about as many samples or kernels of the field in each; the same on
// every machine. Lattices are cut across their axes, between bricks of 8 samples where there are
// enough; kernel sets through the middle of their kernels. The outer parts reach without end.
// Throws Error(kInvalidArgument) unless 1 <= count <= kMostParts. Cost: of lattices none; of kernel
// sets the bricks are sorted.
std::vector<SpacePart> split_space(const Field& field, int count);
inline constexpr int kMostParts = 1 << 16;

// The pieces of each pixel's ray that a part has: those that end on sheets [first, last) of the
// frame. A pixel's ray goes through a convex part once.
struct PartSheets {
  int width = 0, height = 0;
  std::vector<std::int32_t> first, last;  // [height, width]; first >= last: none
};
// Numbers that stand for a ray's near and far end.
inline constexpr std::int32_t kFirstSheet = -(1 << 30);
inline constexpr std::int32_t kLastSheet = 1 << 30;

// `sampling_distance`: of the frame's sheets, world units. Every piece of a ray has its middle in
// one of the parts that space was split into, and belongs to that. Throws Error(kInvalidArgument)
// for an invalid camera, size or distance. Cost: some operations per pixel and side.
PartSheets sheets_of_part(const SpacePart& part, const Camera& camera, int width, int height,
                          double sampling_distance);

}  // namespace ovoid
