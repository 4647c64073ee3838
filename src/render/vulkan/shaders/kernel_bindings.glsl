// SPDX-License-Identifier: Apache-2.0
// What the shaders of kernel sets have in common.
#extension GL_EXT_scalar_block_layout : require
#include "render/shared/device_layout.h"

layout(constant_id = 0) const uint kMode = 0u;
layout(constant_id = 1) const uint kFrameFlags = 0u;
layout(constant_id = 2) const uint kSetFlags = 0u;
layout(constant_id = 3) const uint kProfile = 0u;
layout(constant_id = 4) const uint kChannels = 2u;

layout(std430, binding = 0) uniform FrameBlock { KernelFrame frame; };
layout(push_constant) uniform PushBlock { KernelPush push; };

bool has_flag(uint flag) { return (kFrameFlags & flag) != 0u; }
bool set_has(uint flag) { return (kSetFlags & flag) != 0u; }

float depth_at(float s) { return fma(s, frame.sampling_distance, frame.first_depth); }

// Of a sheet's scale against the focal plane's.
float scale_at(float depth) {
  return set_has(kSetIsParallel) ? 1.0 : frame.focal_depth / depth;
}

// Greatest whole number whose power of two is not more than the smaller sigma, in the samples that
// a level needs of it: the coarsest level whose samples show the splat.
int level_for(float minor, float scale) {
  float sigma = min(minor * scale / frame.least_level_sigma, 1e6);
  if (!(sigma >= 2.0)) return 0;
  return min(frame.max_level, findMSB(uint(sigma)));
}

int floor_divided(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }
