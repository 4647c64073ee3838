#version 450
// SPDX-License-Identifier: Apache-2.0
// Stage "bin", first half: (list, splat) pairs, in the splats' order.
#extension GL_GOOGLE_include_directive : require
#include "kernel_bindings.glsl"

layout(local_size_x = 256) in;

layout(std430, binding = 1) readonly buffer SplatBuffer { DeviceSplat splats[]; };
layout(std430, binding = 2) readonly buffer OffsetBuffer { uint offsets[]; };
layout(std430, binding = 3) readonly buffer NeededBuffer { uint needed_layers[]; };
layout(std430, binding = 4) writeonly buffer PairBuffer { uvec2 pairs[]; };

uint self = 0u;
uint next = 0u;
uint end = 0u;

// Another shader has counted them; should its rounding have been another, a list too many is left
// out, and a place too many belongs to no list.
void emit_list(uint list) {
  if (next < end) pairs[next++] = uvec2(list, self);
}

#include "splat_lists.glsl"

void main() {
  self = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 256u +
         gl_LocalInvocationIndex;
  if (self >= push.num_items) return;
  next = offsets[self];
  end = offsets[self + 1u];
  if (next >= end) return;
  for_each_list(splats[self]);
  while (next < end) pairs[next++] = uvec2(kNoList, self);
}
