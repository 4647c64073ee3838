#version 450
// SPDX-License-Identifier: Apache-2.0
// Stages "shade" and "composite" of kernel sets: a thread for a pixel goes through finished sheets
// of the ring, whose neighbours are there for differences.
#extension GL_GOOGLE_include_directive : require
#include "kernel_bindings.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 1) readonly buffer TableBuffer { vec4 tables[]; };
layout(std430, binding = 2) readonly buffer SheetBuffer { uint sheets[]; };
layout(std430, binding = 3) readonly buffer ColorSheetBuffer { float color_sheets[]; };
layout(std430, binding = 4) readonly buffer NeededBuffer { uint needed_blocks[]; };
layout(std430, binding = 5) buffer OpenBuffer { uint open_tiles[]; };
layout(std430, binding = 6) buffer ColorBuffer { vec4 colors[]; };
layout(std430, binding = 7) buffer DepthBuffer { vec2 depths[]; };
layout(std430, binding = 8) buffer StateBuffer { PixelState states[]; };
layout(std430, binding = 9) buffer CountBuffer { uvec4 counts[]; };
layout(std430, binding = 10) buffer PixelStopsBuffer { PixelStops pixel_stops[]; };
layout(std430, binding = 11) readonly buffer StopBuffer { DepthStop stops[]; };

// A mesh is whole up to its boundary.
const bool kPiecesReachLimits = true;

#include "view.glsl"
#include "look.glsl"
#include "shade.glsl"
#include "composite.glsl"
#include "limits.glsl"
#include "finish.glsl"
#include "piece.glsl"
#include "sheet_bits.glsl"

struct Sample {
  float value;
  bool is_defined;
};

uint plane_size() {
  return uint(frame.levels[0].tiles.x * frame.levels[0].tiles.y) * kGroupSize;
}

uint place_in_plane(ivec2 pixel) {
  ivec2 at = pixel - frame.levels[0].tiles.zw * int(kGroupEdge);
  return uint(at.y * frame.levels[0].tiles.x) * kGroupEdge + uint(at.x);
}

// The sheet in hand, and its place in the ring. Only sheets near it are asked for.
int own_sheet;
int own_ring;

uint ring_of(int sheet) {
  int ring = own_ring + (sheet - own_sheet);
  if (ring < 0) ring += frame.ring_sheets;
  return uint(ring >= frame.ring_sheets ? ring - frame.ring_sheets : ring);
}

void take_sheet(int sheet) {
  own_sheet = sheet;
  own_ring = sheet % frame.ring_sheets;
}

Sample sample_at(ivec2 pixel, int sheet) {
  Sample found;
  found.value = 0.0;
  found.is_defined = false;
  if (sheet < 0 || sheet >= frame.num_sheets) return found;
  uint ring = ring_of(sheet);
  uint at = place_in_plane(pixel);
  if (set_has(kSetHalfSheets)) {
    uint word = sheets[(ring >> 1) * plane_size() + at];
    found.is_defined = read_sheet_bits((ring & 1u) == 0u ? word & 0xFFFFu : word >> 16,
                                       set_has(kSetIsSum), frame.sheet_scale, frame.sheet_offset,
                                       found.value);
    return found;
  }
  float value = uintBitsToFloat(sheets[ring * plane_size() + at]);
  found.is_defined = (floatBitsToUint(value) & 0x7F800000u) != 0x7F800000u;
  if (found.is_defined) found.value = value;
  return found;
}

float color_value_at(ivec2 pixel, int sheet) {
  return color_sheets[ring_of(sheet) * plane_size() + place_in_plane(pixel)];
}

vec3 central_gradient(ivec2 pixel, int sheet, float value) {
  Sample left = sample_at(pixel - ivec2(1, 0), sheet);
  Sample right = sample_at(pixel + ivec2(1, 0), sheet);
  Sample above = sample_at(pixel - ivec2(0, 1), sheet);
  Sample below = sample_at(pixel + ivec2(0, 1), sheet);
  Sample front = sample_at(pixel, sheet - 1);
  Sample back = sample_at(pixel, sheet + 1);
  vec3 differences =
      vec3(difference(left.value, value, right.value, left.is_defined, right.is_defined),
           difference(above.value, value, below.value, above.is_defined, below.is_defined),
           difference(front.value, value, back.value, front.is_defined, back.is_defined));
  return gradient_of_differences(differences, vec2(pixel), float(sheet), 1.0);
}

vec3 gradient_of_sample(vec2 at, float s, float value, bool has_before) {
  return central_gradient(ivec2(at), int(s), value);
}

// A piece's end is the next one's front.
vec3 kept_gradient;
int kept_sheet = -1;

vec3 gradient_of_end(vec2 at, float s, float value, bool is_front) {
  if (kept_sheet == int(s)) return kept_gradient;
  vec3 gradient = central_gradient(ivec2(at), int(s), value);
  if (!is_front) {
    kept_gradient = gradient;
    kept_sheet = int(s);
  }
  return gradient;
}

vec3 own_color(vec2 at, float s) {
  return classify(frame.looks[0].color, color_value_at(ivec2(at), int(s))).rgb;
}

// What a pixel has on a sheet, the front of the next one's piece.
Sample kept_sample;
int kept_sample_sheet = -1;

// The refined piece that ends on a sheet.
void take_piece(inout Pixel pixel, ivec2 at, int sheet) {
  Sample front = kept_sample;
  if (kept_sample_sheet != sheet - 1) front = sample_at(at, sheet - 1);
  Sample back = sample_at(at, sheet);
  kept_sample = back;
  kept_sample_sheet = sheet;
  if (!front.is_defined && !back.is_defined) return;
  Piece piece;
  piece.has_front = front.is_defined;
  piece.has_back = back.is_defined;
  piece.front = front.is_defined ? front.value : back.value;
  piece.back = back.is_defined ? back.value : front.value;
  piece.front_color = piece.back_color = 0.0;
  if (has_flag(kHasOwnColor)) {
    piece.front_color = color_value_at(at, front.is_defined ? sheet - 1 : sheet);
    piece.back_color = color_value_at(at, back.is_defined ? sheet : sheet - 1);
  }
  draw_piece(pixel, vec2(at), float(sheet), piece, part_by_ends(piece));
}

// The first crossing between two sheets, on the straight line between their values; gradient and
// colour are mixed likewise.
void draw_surface(inout Pixel pixel, ivec2 at, int sheet, float value) {
  LookConstants look = frame.looks[0];
  Sample before = sample_at(at, sheet - 1);
  if (!before.is_defined || pixel.is_closed) return;
  if ((before.value < look.isovalue) == (value < look.isovalue)) return;
  float rise = value - before.value;
  float t = (look.isovalue - before.value) / (rise == 0.0 ? 1.0 : rise);
  float s = float(sheet) - 1.0 + t;
  vec2 place = vec2(at);
  if (!is_kept_by_planes(place, s)) return;
  if (!(path_fraction(place, float(sheet - 1)) > 0.0)) return;
  if (!is_within_span(pixel, depth_of_sheet(s))) return;
  ++num_samples.y;
  vec3 color = look.isosurface_color.rgb;
  if (has_flag(kHasOwnColor)) {
    float mixed = mix(color_value_at(at, sheet - 1), color_value_at(at, sheet), t);
    color = classify(look.color, mixed).rgb;
  }
  if (has_flag(kShades)) {
    ++num_samples.z;
    vec3 gradient = mix(central_gradient(at, sheet - 1, before.value),
                        central_gradient(at, sheet, value), t);
    vec3 eye = to_eye(place);
    color = lit(look, color, gradient, eye, arriving_light(look, place, s, gradient, eye), 1.0);
  } else {
    color = dimmed(color, arriving_light(look, place, s, vec3(0.0), to_eye(place)));
  }
  composite_surface(pixel, clamp(color, 0.0, 1.0), depth_of_sheet(s));
}

void draw_pixel(ivec2 at, inout Pixel pixel) {
  ivec2 of_plan = at / kPlanEdge;
  for (int sheet = push.first_sheet; sheet < push.end_sheet; ++sheet) {
    if (pixel.is_closed && has_flag(kStopsOpaque)) return;
    int layer = sheet / kBlockDepth;
    uint block = uint((layer * frame.num_blocks.y + of_plan.y) * frame.num_blocks.x + of_plan.x);
    if ((needed_blocks[block >> 2] >> ((block & 3u) * 8u) & kBlockIsRelevant) == 0u) {
      sheet = (layer + 1) * kBlockDepth - 1;
      continue;
    }
    take_sheet(sheet);
    if (has_flag(kIsRefined)) {
      take_piece(pixel, at, sheet);
      continue;
    }
    Sample own = sample_at(at, sheet);
    if (!own.is_defined) continue;
    float path = path_fraction(vec2(at), float(sheet));
    if (path > 0.0) path = path_within_spans(pixel, vec2(at), float(sheet), path);
    if (!(path > 0.0)) continue;
    if (kMode == kComposite) {
      Sample before;
      before.is_defined = false;
      before.value = 0.0;
      if (has_flag(kIsPreintegrated) && path_fraction(vec2(at), float(sheet - 1)) > 0.0)
        before = sample_at(at, sheet - 1);
      draw_sample(pixel, vec2(at), float(sheet), path, own.value, before.is_defined, before.value);
    } else if (kMode == kIsosurface) {
      draw_surface(pixel, at, sheet, own.value);
    } else {
      accumulate(pixel, own.value,
                 path * ray_length(vec2(at)) * frame.view.sampling_distance,
                 depth_of_sheet(float(sheet)));
    }
  }
}

shared uint any_open;
shared uvec4 group_counts[kGroupSize];

void main() {
  ivec2 tile = ivec2(gl_WorkGroupID.xy) + ivec2(0, int(push.first_row / kGroupEdge));
  ivec2 at = tile * int(kGroupEdge) + ivec2(gl_LocalInvocationID.xy);
  ivec2 of_level = tile - frame.levels[0].tiles.zw;
  uint number = uint(of_level.y * frame.levels[0].tiles.x + of_level.x);
  if (open_tiles[number] == 0u) return;
  if (gl_LocalInvocationIndex == 0u) any_open = 0u;
  barrier();
  if (at.x < int(frame.view.width) && at.y < int(push.end_row)) {
    uint index = uint(at.y - int(push.first_row)) * frame.view.width + uint(at.x);
    Pixel pixel = load_pixel(index);
    if (!pixel.is_closed || !has_flag(kStopsOpaque)) {
      draw_pixel(at, pixel);
      store_pixel(index, pixel);
    }
    if (!pixel.is_closed) atomicOr(any_open, 1u);
  }
  group_counts[gl_LocalInvocationIndex] = num_samples;
  barrier();
  if (gl_LocalInvocationIndex != 0u) return;
  if (any_open == 0u && has_flag(kStopsOpaque)) open_tiles[number] = 0u;
  uvec4 sum = uvec4(0u);
  for (uint i = 0u; i < kGroupSize; ++i) sum += group_counts[i];
  counts[number] += sum;
}
