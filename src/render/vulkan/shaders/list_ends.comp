#version 450
// SPDX-License-Identifier: Apache-2.0
// Stage "bin", last part: where in the sorted pairs each list begins and ends. Lists without splats
// keep the zeros that were there.
#extension GL_GOOGLE_include_directive : require
#include "render/shared/device_layout.h"

layout(local_size_x = 256) in;
layout(std430, binding = 0) readonly buffer PairBuffer { uvec2 pairs[]; };
layout(std430, binding = 1) writeonly buffer EndBuffer { uint ends[]; };  // first, past
layout(push_constant) uniform PushBlock { KernelPush push; };

void main() {
  uint at = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 256u +
            gl_LocalInvocationIndex;
  if (at >= push.num_items) return;
  uint list = pairs[at].x;
  if (list == kNoList) return;
  if (at == 0u || pairs[at - 1u].x != list) ends[2u * list] = at;
  if (at + 1u == push.num_items || pairs[at + 1u].x != list) ends[2u * list + 1u] = at + 1u;
}
