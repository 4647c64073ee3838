#version 450
// SPDX-License-Identifier: Apache-2.0
// Stages "reconstruct", "shade" and "composite" of a lattice, a thread for a pixel. A sheet's
// sample lives in registers from the sum of its kernels to its colour; what cannot show is stepped
// over by the bricks' distance to what can; a pixel stops when it is opaque, a work group when all
// of its pixels have.
#extension GL_GOOGLE_include_directive : require
#include "lattice_bindings.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

#include "view.glsl"
#include "look.glsl"
#include "shade.glsl"
#include "gather.glsl"
#include "composite.glsl"
#include "finish.glsl"
#include "lattice_pixel.glsl"

shared uvec4 group_counts[kGroupSize];

vec3 own_color(vec2 at, float s) { return vec3(0.0); }  // lattices have one attribute

void draw_pixel(uvec2 at) {
  uint index = (at.y - box.first_row) * frame.view.width + at.x;
  Pixel pixel = load_pixel(index);
  if (pixel.is_closed && has_flag(kStopsOpaque)) return;
  vec2 center = vec2(at);
  Ray ray = own_ray = ray_at(0, center);
  ivec2 sheets = sheets_in_box(ray);
  for (int sheet = sheets.x; sheet < sheets.y;) {
    float s = float(sheet);
    int skipped = sheets_to_skip(0, ray, s);
    int trail_skipped = has_flag(kHasTrail) ? sheets_to_skip(1, ray, s) : skipped;
    if (skipped > 0 && trail_skipped > 0) {
      sheet += min(skipped, trail_skipped);
      continue;
    }
    ++sheet;
    Place place = place_on(ray, s);
    if (!is_own(place)) continue;
    float path = path_fraction(center, s);
    if (!(path > 0.0)) continue;
    if (skipped == 0 && is_in_support(0, place)) {
      Gathered f = gather(0, place, s, ray.step.hi, false);
      ++num_samples.x;
      own_place = place;
      if (f.is_defined) take_value(pixel, center, s, path, f.value);
    }
    if (has_flag(kHasTrail) && trail_skipped == 0 && is_in_support(1, place))
      take_trail(pixel, center, ray, place, s, path);
    if (pixel.is_closed && has_flag(kStopsOpaque)) break;
  }
  store_pixel(index, pixel);
}

void main() {
  uvec2 at = gl_GlobalInvocationID.xy + uvec2(box.tile_x, box.tile_y);
  if (at.x < frame.view.width && at.y < box.end_row) draw_pixel(at);
  group_counts[gl_LocalInvocationIndex] = num_samples;
  barrier();
  if (gl_LocalInvocationIndex != 0u) return;
  uvec4 sum = uvec4(0u);
  for (uint i = 0u; i < kGroupSize; ++i) sum += group_counts[i];
  counts[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x] += sum;
}
