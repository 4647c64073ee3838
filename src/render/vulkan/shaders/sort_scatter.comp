#version 450
// SPDX-License-Identifier: Apache-2.0
// Stage "bin", a radix sort: pairs go to their digit's places, those with the same digit in the
// order in which they were, so that a list's splats keep theirs and sums are always the same.
#extension GL_GOOGLE_include_directive : require
#include "render/shared/device_layout.h"

layout(local_size_x = 256) in;
layout(std430, binding = 0) readonly buffer PairBuffer { uvec2 pairs[]; };
layout(std430, binding = 1) readonly buffer PlaceBuffer { uint places[]; };
layout(std430, binding = 2) writeonly buffer SortedBuffer { uvec2 sorted[]; };
layout(push_constant) uniform PushBlock { KernelPush push; };

const uint kOwn = kSortItems / kSortGroup;

// Of each digit and thread: its pairs, then those of the threads before it.
shared uint before[kSortBins][kSortGroup];
shared uint part_sums[kSortBins][16];

void main() {
  uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  uint num_blocks = (push.num_items + kSortItems - 1u) / kSortItems;
  uint self = gl_LocalInvocationIndex;
  uvec2 own[kOwn];
  for (uint b = 0u; b < kSortBins; ++b) before[b][self] = 0u;
  for (uint i = 0u; i < kOwn; ++i) {
    uint at = group * kSortItems + self * kOwn + i;
    own[i] = at < push.num_items ? pairs[at] : uvec2(0u);
    if (at < push.num_items) ++before[own[i].x >> push.shift & (kSortBins - 1u)][self];
  }
  barrier();
  // Sixteen threads for a digit, sixteen numbers each.
  uint bin = self >> 4;
  uint part = self & 15u;
  uint sum = 0u;
  for (uint i = 0u; i < 16u; ++i) {
    uint count = before[bin][part * 16u + i];
    before[bin][part * 16u + i] = sum;
    sum += count;
  }
  part_sums[bin][part] = sum;
  barrier();
  uint others = 0u;
  for (uint p = 0u; p < part; ++p) others += part_sums[bin][p];
  for (uint i = 0u; i < 16u; ++i) before[bin][part * 16u + i] += others;
  barrier();
  for (uint i = 0u; i < kOwn; ++i) {
    uint at = group * kSortItems + self * kOwn + i;
    if (at >= push.num_items) break;
    uint digit = own[i].x >> push.shift & (kSortBins - 1u);
    sorted[places[digit * num_blocks + group] + before[digit][self]++] = own[i];
  }
}
