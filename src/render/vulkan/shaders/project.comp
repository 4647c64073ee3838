#version 450
// SPDX-License-Identifier: Apache-2.0
// Stage "project": kernels -> splats, a work group for a brick, and how many lists each belongs to.
//
// No double precision is needed where factors are worked on instead of covariances: what of the
// kernel's factor lies across the view axis is found by orthogonal projection, and its least width
// by Jacobi's rotations of its columns, which keep the digits of the smallest.
#extension GL_GOOGLE_include_directive : require
#include "kernel_bindings.glsl"

layout(local_size_x = 256) in;

layout(std430, binding = 1) readonly buffer PageBuffer { float numbers[]; };
layout(std430, binding = 2) readonly buffer BrickBuffer { BrickConstants bricks[]; };
layout(std430, binding = 3) readonly buffer NeededBuffer { uint needed_layers[]; };
layout(std430, binding = 4) writeonly buffer SplatBuffer { DeviceSplat splats[]; };
layout(std430, binding = 5) writeonly buffer CountBuffer { uint list_counts[]; };
layout(std430, binding = 6) buffer MostBuffer { uint coarsest_level; };

uint num_lists = 0u;
uint coarsest = 0u;

void emit_list(uint list) {
  ++num_lists;
  uint in_layer = list % uint(frame.num_blocks.w);
  for (int level = kNumLevels - 1; level > 0; --level) {
    if (in_layer < frame.levels[level].first_list) continue;
    coarsest = max(coarsest, uint(level));
    break;
  }
}

#include "splat_lists.glsl"

// Makes the columns orthogonal: what is left are the axes of the ellipsoid.
void rotate_columns(inout vec3 a, inout vec3 b) {
  float ab = dot(a, b);
  float aa = dot(a, a);
  float bb = dot(b, b);
  if (!(abs(ab) > 1e-7 * sqrt(aa * bb))) return;
  float zeta = (bb - aa) / (2.0 * ab);
  float t = (zeta >= 0.0 ? 1.0 : -1.0) / (abs(zeta) + sqrt(1.0 + zeta * zeta));
  float c = inversesqrt(1.0 + t * t);
  float s = c * t;
  vec3 before = a;
  a = c * before - s * b;
  b = s * before + c * b;
}

// Columns shorter than the least sigma are made that long, one that has no direction left by way of
// the other two. Returns the factor by which the amplitude falls for the mass to stay.
float widen(inout vec3 axes[3]) {
  float mass = 1.0;
  for (int i = 0; i < 3; ++i) {
    float sigma = length(axes[i]);
    if (sigma >= kLeastSigma) continue;
    mass *= sigma / kLeastSigma;
    vec3 direction = axes[i] / max(sigma, 1e-30);
    if (!(sigma > 1e-6 * max(length(axes[(i + 1) % 3]), length(axes[(i + 2) % 3]))))
      direction = normalize(cross(axes[(i + 1) % 3], axes[(i + 2) % 3]));
    axes[i] = kLeastSigma * direction;
  }
  return mass;
}

void set_ellipsoid(inout DeviceSplat splat, mat3 factor, float lateral) {
  vec3 axes[3] = vec3[3](factor[0], factor[1], factor[2]);
  for (int sweep = 0; sweep < 6; ++sweep) {
    rotate_columns(axes[0], axes[1]);
    rotate_columns(axes[0], axes[2]);
    rotate_columns(axes[1], axes[2]);
  }
  splat.center.w = widen(axes);
  // Rows: to the right and down, in pixels of the focal plane, and along the view axis.
  vec3 right = lateral * vec3(axes[0].x, axes[1].x, axes[2].x);
  vec3 down = lateral * vec3(axes[0].y, axes[1].y, axes[2].y);
  vec3 along = vec3(axes[0].z, axes[1].z, axes[2].z);
  float vss = dot(along, along);
  vec2 m = vec2(dot(right, along), dot(down, along)) / vss;
  vec3 x = right - m.x * along;
  vec3 y = down - m.y * along;
  vec3 area = cross(x, y);
  float det = dot(area, area);
  float cxx = dot(x, x), cxy = dot(x, y), cyy = dot(y, y);
  float half_trace = 0.5 * (cxx + cyy);
  float spread = sqrt(max(half_trace * half_trace - det, 0.0));
  splat.shape = vec4(cyy / det, -cxy / det, cxx / det, 1.0 / vss);
  splat.slide = vec4(m, frame.cutoff * sqrt(vss), sqrt(det / (half_trace + spread)));
  splat.values.zw = frame.cutoff * sqrt(vec2(cxx, cyy));
}

void set_ball(inout DeviceSplat splat, float sigma, float per_pixels, float per_sheets,
              float lateral) {
  float across = sigma * per_pixels;
  float along = sigma * per_sheets;
  float wide_across = max(across, kLeastSigma);
  float wide_along = max(along, kLeastSigma);
  float pixels = wide_across * lateral;
  splat.center.w = (across / wide_across) * (across / wide_across) * (along / wide_along);
  splat.shape = vec4(1.0 / (pixels * pixels), 0.0, 1.0 / (pixels * pixels),
                     1.0 / (wide_along * wide_along));
  splat.slide = vec4(0.0, 0.0, frame.cutoff * wide_along, pixels);
  splat.values.zw = vec2(frame.cutoff * pixels);
}

DeviceSplat project(BrickConstants brick, uint kernel) {
  uint at = (brick.first + kernel) * uint(frame.num_numbers);
  vec3 offset = vec3(numbers[at], numbers[at + 1u], numbers[at + 2u]);
  mat3 rotation = transpose(
      mat3(frame.rotation[0].xyz, frame.rotation[1].xyz, frame.rotation[2].xyz));
  vec3 place = brick.origin.xyz + rotation * offset;  // depth counted from sheet 0
  float depth = place.z + frame.first_depth;
  // Kernels at or behind the eye are as fine as those at the near plane.
  float depth_scale = set_has(kSetIsParallel)
                          ? 1.0
                          : max(depth, 0.5 * frame.sampling_distance) / frame.focal_depth;
  float per_pixels = 1.0 / (frame.pitch * depth_scale * frame.least_pixels);
  float per_sheets = 1.0 / frame.sampling_distance;
  float lateral = depth_scale * frame.least_pixels;
  DeviceSplat splat;
  splat.center = vec4(place.xy / frame.pitch, place.z / frame.sampling_distance, 1.0);
  splat.values = vec4(0.0);
  at += 3u;
  if (set_has(kHasEllipsoids)) {
    mat3 shape = mat3(numbers[at], numbers[at + 1u], numbers[at + 3u],  // columns
                      0.0, numbers[at + 2u], numbers[at + 4u],          //
                      0.0, 0.0, numbers[at + 5u]);
    mat3 units = mat3(per_pixels, 0.0, 0.0, 0.0, per_pixels, 0.0, 0.0, 0.0, per_sheets);
    set_ellipsoid(splat, units * (rotation * shape), lateral);
    at += 6u;
  } else {
    set_ball(splat, numbers[at], per_pixels, per_sheets, lateral);
    at += 1u;
  }
  splat.center.w *= numbers[at];
  splat.values.x = numbers[at + 1u];
  splat.values.y = set_has(kSetHasColor) ? numbers[at + 2u] : splat.values.x;
  return splat;
}

shared uint group_coarsest;

void main() {
  uint number = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  if (gl_LocalInvocationIndex == 0u) group_coarsest = 0u;
  barrier();
  if (number < push.num_items) {
    BrickConstants brick = bricks[push.first_item + number];
    if (gl_LocalInvocationIndex < brick.count) {
      DeviceSplat splat = project(brick, gl_LocalInvocationIndex);
      splats[brick.first_splat + gl_LocalInvocationIndex] = splat;
      for_each_list(splat);
      list_counts[brick.first_splat + gl_LocalInvocationIndex] = num_lists;
      if (coarsest > 0u) atomicMax(group_coarsest, coarsest);
    }
  }
  barrier();
  if (gl_LocalInvocationIndex == 0u && group_coarsest > 0u)
    atomicMax(coarsest_level, group_coarsest);
}
