#version 450
// SPDX-License-Identifier: Apache-2.0
// Stage "bin", a radix sort: how many pairs of a block have which digit.
#extension GL_GOOGLE_include_directive : require
#include "render/shared/device_layout.h"

layout(local_size_x = 256) in;
layout(std430, binding = 0) readonly buffer PairBuffer { uvec2 pairs[]; };
layout(std430, binding = 1) writeonly buffer CountBuffer { uint counts[]; };
layout(push_constant) uniform PushBlock { KernelPush push; };

shared uint bins[kSortBins];

void main() {
  uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  uint num_blocks = (push.num_items + kSortItems - 1u) / kSortItems;
  uint self = gl_LocalInvocationIndex;
  if (self < kSortBins) bins[self] = 0u;
  barrier();
  for (uint i = self; i < kSortItems; i += kSortGroup) {
    uint at = group * kSortItems + i;
    if (at < push.num_items) atomicAdd(bins[pairs[at].x >> push.shift & (kSortBins - 1u)], 1u);
  }
  barrier();
  if (self < kSortBins && group < num_blocks) counts[self * num_blocks + group] = bins[self];
}
