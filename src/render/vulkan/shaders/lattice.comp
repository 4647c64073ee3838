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
#include "limits.glsl"
#include "finish.glsl"
#include "piece.glsl"
#include "lattice_pixel.glsl"

shared uvec4 group_counts[kGroupSize];

vec3 own_color(vec2 at, float s) { return vec3(0.0); }  // lattices have one attribute

Gathered gather_own(Place place, float s) {
  Gathered f;
  f.value = 0.0;
  f.is_defined = false;
  if (!is_in_support(0, place)) return f;
  ++num_samples.x;
  f = gather(0, place, s, own_ray.step.hi, has_flag(kGathersGradients));
  if (has_flag(kGathersGradients) && f.is_defined) {
    own_gradient = to_world(0, f.gradient);
    has_own_gradient = true;
  }
  return f;
}

// The piece that ends on a sheet. Where a part of the frame or a box begins, its front end is
// another one's: it is worked out again.
int known_sheet = -1;
void take_piece(inout Pixel pixel, vec2 at, int sheet) {
  float s = float(sheet);
  vec2 kept = kept_part(at, s - 1.0, vec2(0.0, 1.0));
  if (!(kept.x < kept.y) || !meets_span(pixel, s)) return;
  bool is_known = known_sheet == sheet - 1;
  bool has_sheet_before = sheet > 0 && sheets_to_skip(0, own_ray, s - 1.0) == 0;
  if (!is_known) {
    pixel.before_sheet = -1;
    has_own_gradient = false;
  }
  for (int k = is_known || !has_sheet_before ? sheet : sheet - 1; k <= sheet; ++k) {
    if (k == sheet) {
      front_gradient = own_gradient;
      has_front_gradient = has_own_gradient;
    }
    has_own_gradient = false;
    Gathered f = gather_own(place_on(own_ray, float(k)), float(k));
    if (k == sheet) {
      take_end(pixel, at, s, f.is_defined, f.value);
    } else if (f.is_defined) {
      pixel.before = f.value;
      pixel.before_sheet = k;
    }
  }
  known_sheet = sheet;
}

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
    own_place = place;
    if (has_flag(kIsRefined)) {
      if (skipped == 0) take_piece(pixel, center, int(s));
    } else if (path > 0.0 && skipped == 0) {
      float drawn = path_within_spans(pixel, center, s, path);
      if (drawn > 0.0 || has_flag(kIsPreintegrated)) {  // else it is no end of a piece either
        Gathered f = gather_own(place, s);
        if (f.is_defined) take_value(pixel, center, s, drawn, f.value);
      }
    }
    if (has_flag(kHasTrail) && path > 0.0 && trail_skipped == 0 && is_in_support(1, place))
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
