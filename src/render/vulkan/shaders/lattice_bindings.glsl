// SPDX-License-Identifier: Apache-2.0
// What the shaders of lattices are given.
#extension GL_EXT_scalar_block_layout : require
#include "render/shared/device_layout.h"

layout(constant_id = 0) const uint kMode = 0u;
layout(constant_id = 1) const uint kFrameFlags = 0u;
layout(constant_id = 2) const uint kType0 = 0u;
layout(constant_id = 3) const uint kFieldFlags0 = 0u;
layout(constant_id = 4) const uint kType1 = 0u;
layout(constant_id = 5) const uint kFieldFlags1 = 0u;

layout(std430, binding = 0) uniform FrameBlock { LatticeFrame frame; };
layout(std430, binding = 1) readonly buffer TableBuffer { vec4 tables[]; };
layout(std430, binding = 2) readonly buffer Samples0Buffer { uint words0[]; };
layout(std430, binding = 3) readonly buffer Samples1Buffer { uint words1[]; };
// The same, for reads of several words at once.
layout(std430, binding = 2) readonly buffer Samples0ByTwo { uvec2 words0_by_two[]; };
layout(std430, binding = 3) readonly buffer Samples1ByTwo { uvec2 words1_by_two[]; };
layout(std430, binding = 2) readonly buffer Samples0ByFour { uvec4 words0_by_four[]; };
layout(std430, binding = 3) readonly buffer Samples1ByFour { uvec4 words1_by_four[]; };
layout(std430, binding = 4) readonly buffer Bricks0Buffer { uint bricks0[]; };
layout(std430, binding = 5) readonly buffer Bricks1Buffer { uint bricks1[]; };
layout(std430, binding = 6) buffer ColorBuffer { vec4 colors[]; };
layout(std430, binding = 7) buffer DepthBuffer { vec2 depths[]; };
layout(std430, binding = 8) buffer StateBuffer { PixelState states[]; };
layout(std430, binding = 9) buffer CountBuffer { uvec4 counts[]; };  // one per work group
layout(std430, binding = 10) buffer PixelStopsBuffer { PixelStops pixel_stops[]; };
layout(std430, binding = 11) readonly buffer StopBuffer { DepthStop stops[]; };

layout(push_constant) uniform BoxBlock { BoxConstants box; };

// Pieces with one end stay half a piece where depth limits end them on the other side: lattices end
// at their faces (part_with_field).
const bool kPiecesReachLimits = false;

bool has_flag(uint flag) { return (kFrameFlags & flag) != 0u; }
