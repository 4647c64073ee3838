#version 450
// SPDX-License-Identifier: Apache-2.0
// Stage "composite", of depth limits: the stops of a pixel that stand behind all that was drawn in
// it join it. A thread for a pixel.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "render/shared/device_layout.h"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kMode = 0u;
layout(constant_id = 1) const uint kFrameFlags = 0u;

// What frames of every kind of field begin with.
struct AnyFrame {
  ViewConstants view;
};

layout(std430, binding = 0) uniform FrameBlock { AnyFrame frame; };
layout(std430, binding = 1) buffer ColorBuffer { vec4 colors[]; };
layout(std430, binding = 2) buffer DepthBuffer { vec2 depths[]; };
layout(std430, binding = 3) buffer StateBuffer { PixelState states[]; };
layout(std430, binding = 4) buffer PixelStopsBuffer { PixelStops pixel_stops[]; };
layout(std430, binding = 5) readonly buffer StopBuffer { DepthStop stops[]; };
layout(push_constant) uniform StripBlock { StripConstants strip; };

bool has_flag(uint flag) { return (kFrameFlags & flag) != 0u; }

#include "view.glsl"
#include "composite.glsl"
#include "limits.glsl"

void main() {
  uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  uint at = group * 64u + gl_LocalInvocationIndex;
  if (at >= strip.num_pixels) return;
  Pixel pixel = load_pixel(at);
  while (pixel.next_stop < pixel.end_stop) join_next_stop(pixel);
  store_pixel(at, pixel);
}
