#version 450
// SPDX-License-Identifier: Apache-2.0
// How many bricks away the nearest one is that can show, at most kFarBricks, in the greatest of the
// three directions: one axis after the other. A byte per brick, a word of four per thread; a bit of
// the byte is of another meaning and stays as it is.
#extension GL_GOOGLE_include_directive : require
#include "render/shared/device_layout.h"

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer InBuffer { uint bricks_in[]; };
layout(std430, binding = 1) writeonly buffer OutBuffer { uint bricks_out[]; };
layout(push_constant) uniform Block { DistanceConstants constants; };

uint byte_at(uint index) { return bricks_in[index >> 2] >> ((index & 3u) * 8u) & 255u; }

uint nearest(uint index, uint total) {
  if (index >= total) return 0u;
  int axis = constants.num_bricks.w;
  int count = constants.num_bricks[axis];
  int stride = axis == 0   ? 1
               : axis == 1 ? constants.num_bricks.x
                           : constants.num_bricks.x * constants.num_bricks.y;
  int at = int(index) / stride % count;
  uint own = byte_at(index);
  int least = int(own & kDistanceBits);
  for (int k = 1; k < least; ++k) {
    if (at >= k)
      least = min(least, max(k, int(byte_at(uint(int(index) - k * stride)) & kDistanceBits)));
    if (at + k < count)
      least = min(least, max(k, int(byte_at(uint(int(index) + k * stride)) & kDistanceBits)));
  }
  return (own & ~kDistanceBits) | uint(least);
}

void main() {
  uint total = uint(constants.num_bricks.x * constants.num_bricks.y * constants.num_bricks.z);
  uint first = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 256u +
               gl_LocalInvocationIndex * 4u;
  if (first >= total) return;
  uint word = 0u;
  for (uint i = 0u; i < 4u; ++i) word |= nearest(first + i, total) << (i * 8u);
  bricks_out[first >> 2] = word;
}
