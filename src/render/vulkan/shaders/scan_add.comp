#version 450
// SPDX-License-Identifier: Apache-2.0
// What lies before a block is added to its numbers.
#extension GL_GOOGLE_include_directive : require
#include "render/shared/device_layout.h"

layout(local_size_x = 256) in;
layout(std430, binding = 0) buffer NumberBuffer { uint numbers[]; };
layout(std430, binding = 1) readonly buffer SumBuffer { uint sums[]; };
layout(push_constant) uniform PushBlock { KernelPush push; };

void main() {
  uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  uint first = group * kScanItems + gl_LocalInvocationIndex * 4u;
  for (uint i = 0u; i < 4u; ++i) {
    if (first + i < push.num_items) numbers[first + i] += sums[group];
  }
}
