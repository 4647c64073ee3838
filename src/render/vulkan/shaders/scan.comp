#version 450
// SPDX-License-Identifier: Apache-2.0
// Every number becomes the sum of those before it, in blocks of kScanItems; each block's sum goes
// to the next level, which is scanned likewise.
#extension GL_GOOGLE_include_directive : require
#include "render/shared/device_layout.h"

layout(local_size_x = 256) in;
layout(std430, binding = 0) buffer NumberBuffer { uint numbers[]; };
layout(std430, binding = 1) writeonly buffer SumBuffer { uint sums[]; };
layout(push_constant) uniform PushBlock { KernelPush push; };

shared uint partial[kScanGroup];

void main() {
  uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  uint self = gl_LocalInvocationIndex;
  uint first = group * kScanItems + self * 4u;
  uint own[4];
  uint total = 0u;
  for (uint i = 0u; i < 4u; ++i) {
    own[i] = total;
    if (first + i < push.num_items) total += numbers[first + i];
  }
  partial[self] = total;
  barrier();
  for (uint step = 1u; step < kScanGroup; step <<= 1) {
    uint before = self >= step ? partial[self - step] : 0u;
    barrier();
    partial[self] += before;
    barrier();
  }
  uint before = partial[self] - total;
  for (uint i = 0u; i < 4u; ++i) {
    if (first + i < push.num_items) numbers[first + i] = before + own[i];
  }
  if (self == kScanGroup - 1u && group * kScanItems < push.num_items)
    sums[group] = partial[self];
}
