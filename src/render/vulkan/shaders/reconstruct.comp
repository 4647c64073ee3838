#version 450
// SPDX-License-Identifier: Apache-2.0
// Stages "reconstruct" and "post-convolve" of kernel sets: a tile of kGroupEdge^2 samples of a
// level, the sheets of a layer, a thread for a sample.
//
// The tile's splats are taken from their lists sixty-four at a time. Each thread cuts one with the
// four sheets; those that meet the tile are packed in shared memory, and every thread adds them to
// its four sums, in their order. On coarse levels the sums stay in memory for the next finer one;
// on the finest they become field values in a ring of sheets. What the filter carries beyond the
// kernels of coarse levels is no part of a sum: where one is defined, their splats are asked once
// more, until all samples of the tile are known to be reached.
#extension GL_GOOGLE_include_directive : require
#include "kernel_bindings.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 5) const uint kLevelKind = 1u;  // kIsFinest, kHasCoarser

layout(std430, binding = 1) readonly buffer SplatBuffer { DeviceSplat splats[]; };
layout(std430, binding = 2) readonly buffer PairBuffer { uvec2 pairs[]; };
layout(std430, binding = 3) readonly buffer EndBuffer { uint ends[]; };
layout(std430, binding = 4) readonly buffer NeededBuffer { uint needed_blocks[]; };
layout(std430, binding = 5) readonly buffer OpenBuffer { uint open_tiles[]; };
layout(std430, binding = 6) buffer PlaneBuffer { float planes[]; };
layout(std430, binding = 7) writeonly buffer SheetBuffer { uint sheets[]; };
layout(std430, binding = 8) writeonly buffer ColorSheetBuffer { float color_sheets[]; };
layout(std430, binding = 9) buffer CountBuffer { uvec4 counts[]; };

#include "sections.glsl"
#include "post_convolve.glsl"
#include "sheet_bits.glsl"

shared Section staged[kGroupSize][kBlockDepth];
shared vec3 staged_values[kGroupSize];
shared uint staged_bits[2];
shared uint is_any_uncovered;

vec3 coefficients_of(DeviceSplat splat) {
  float weight = splat.center.w;
  float product = weight * splat.values.x;
  if (set_has(kSetIsSum)) return vec3(product, product * splat.values.y, 0.0);
  return vec3(product, weight, weight * splat.values.y);
}

// Whether one of the plan's blocks needs a finest tile: samples border on its pixels.
bool is_needed(ivec2 pixel, int layer) {
  int edge = int(kGroupEdge);
  ivec2 lo = max(ivec2(floor_divided(pixel.x - 1, kPlanEdge), floor_divided(pixel.y - 1, kPlanEdge)),
                 ivec2(0));
  ivec2 hi = min(ivec2(floor_divided(pixel.x + edge, kPlanEdge),
                       floor_divided(pixel.y + edge, kPlanEdge)),
                 frame.num_blocks.xy - 1);
  for (int y = lo.y; y <= hi.y; ++y) {
    for (int x = lo.x; x <= hi.x; ++x) {
      uint block = uint((layer * frame.num_blocks.y + y) * frame.num_blocks.x + x);
      if ((needed_blocks[block >> 2] >> ((block & 3u) * 8u) & kBlockIsNeeded) != 0u) return true;
    }
  }
  return false;
}

// Whether a pixel in it, or beside it, still takes samples.
bool is_open(ivec2 tile, ivec2 tiles) {
  for (int y = max(tile.y - 1, 0); y <= min(tile.y + 1, tiles.y - 1); ++y) {
    for (int x = max(tile.x - 1, 0); x <= min(tile.x + 1, tiles.x - 1); ++x) {
      if (open_tiles[y * tiles.x + x] != 0u) return true;
    }
  }
  return false;
}

// Whether a sheet of the layer is worked out now.
bool is_wanted(int j) { return push.only_sheet < 0 || push.only_sheet == j; }

// Cuts one splat of a level with the layer's sheets, at one point of their slabs, in samples of the
// level in hand. True if it meets the tile.
bool stage(DeviceSplat splat, int of_level, int first_sheet, int point, vec2 corner,
           out Section sections[kBlockDepth]) {
  bool meets = false;
  float unit = float(1 << push.level);
  bool takes_points = set_has(kSetTakesMeans) && kProfile != kProfileGaussian;
  bool takes_means = set_has(kSetTakesMeans) && kProfile == kProfileGaussian;
  for (int j = 0; j < kBlockDepth; ++j) {
    float middle = float(first_sheet + j);
    float s = middle;
    float point_weight = 1.0;
    if (takes_points) {
      s += kProfilePointOffsets[point];
      point_weight = kProfilePointWeights[point];
    }
    float depth = depth_at(s);
    float scale = scale_at(depth);
    sections[j].room = -1.0;
    if (!is_wanted(j)) continue;
    float t = s - splat.center.z;
    if (abs(t) - (takes_means ? 0.5 : 0.0) >= splat.slide.z) continue;
    if (set_has(kHasLevels) &&
        level_for(splat.slide.w, scale_at(depth_at(middle))) != of_level)
      continue;
    float factor = scale / unit;
    vec2 offset = (vec2(frame.center_x, frame.center_y) - 0.5 * (unit - 1.0)) / unit - corner;
    if (takes_means) {
      float per_depth =
          set_has(kSetIsParallel) ? 0.0 : frame.sampling_distance / depth;
      sections[j] = mean_section(splat, t, factor, offset, per_depth);
    } else {
      sections[j] = middle_section(splat, t, factor, offset);
      sections[j].amplitude *= point_weight;
    }
    if (!(sections[j].room > 0.0)) continue;
    // The box around the cut.
    vec3 shape = sections[j].shape;
    float det = max(shape.x * shape.z - shape.y * shape.y, 1e-30);
    vec2 reach = sqrt(sections[j].room * shape.zx / det) * 1.001 + 0.01;
    bool is_near = set_has(kIsFragmentCentric) ||
                   (all(lessThanEqual(sections[j].center - reach, vec2(float(kGroupEdge - 1u)))) &&
                    all(greaterThanEqual(sections[j].center + reach, vec2(0.0))));
    if (!is_near) sections[j].room = -1.0;
    meets = meets || is_near;
  }
  return meets;
}

vec3 sums[kBlockDepth];
uint covered_sheets = 0u;  // a bit for each: some kernel reaches the sample there
const uint kAllCovered = (1u << uint(kBlockDepth)) - 1u;

// Adds a list's splats to the sums, or, those of a coarser level, notes whom they reach.
void add_list(uint list, int of_level, int first_sheet, int point, vec2 corner, vec2 sample_at) {
  uint first = ends[2u * list];
  uint past = ends[2u * list + 1u];
  uint self = gl_LocalInvocationIndex;
  bool only_covers = set_has(kSetFindsCover) && of_level != push.level;
  for (uint batch = first; batch < past; batch += kGroupSize) {
    if (self < 2u) staged_bits[self] = 0u;
    if (self == 2u) is_any_uncovered = 0u;
    barrier();
    if (only_covers) {
      if (covered_sheets != kAllCovered) atomicOr(is_any_uncovered, 1u);
      barrier();
      if (is_any_uncovered == 0u) return;
    }
    bool meets = false;
    DeviceSplat splat;
    Section sections[kBlockDepth];
    if (batch + self < past) {
      splat = splats[pairs[batch + self].y];
      meets = stage(splat, of_level, first_sheet, point, corner, sections);
    }
    if (meets) atomicOr(staged_bits[self >> 5], 1u << (self & 31u));
    barrier();
    uint low = staged_bits[0];
    uint high = staged_bits[1];
    if (meets) {
      uint below = (1u << (self & 31u)) - 1u;
      uint slot = self < 32u ? bitCount(low & below) : bitCount(low) + bitCount(high & below);
      for (int j = 0; j < kBlockDepth; ++j) staged[slot][j] = sections[j];
      staged_values[slot] = coefficients_of(splat);
    }
    barrier();
    uint count = bitCount(low) + bitCount(high);
    for (uint i = 0u; i < count; ++i) {
      vec3 values = staged_values[i];
      for (int j = 0; j < kBlockDepth; ++j) {
        Section section = staged[i][j];
        vec2 d = sample_at - section.center;
        float q = fma(d.x * d.x, section.shape.x,
                      d.y * fma(d.x, 2.0 * section.shape.y, d.y * section.shape.z));
        if (q > section.room) continue;
        if (only_covers) {
          if (values.x != 0.0) covered_sheets |= 1u << uint(j);
          continue;
        }
        float phi = section_at(section, q);
        sums[j] = fma(values, vec3(phi), sums[j]);
      }
    }
    barrier();
  }
}

uint list_of(int level, ivec2 tile, int layer) {
  LevelConstants constants = frame.levels[level];
  return uint(layer - push.first_layer) * uint(frame.num_blocks.w) + constants.first_list +
         uint(tile.y * constants.tiles.x + tile.x);
}

// Sums of coarser levels are still to come: where are they a part of the field?
void find_cover(ivec2 tile, int layer, int first_sheet, int num_points, vec2 corner,
                vec2 sample_at) {
  for (int j = 0; j < kBlockDepth; ++j) {
    if (sums[j].x != 0.0 || !is_wanted(j)) covered_sheets |= 1u << uint(j);
  }
  for (int point = 0; point < num_points; ++point) {
    for (int coarse = 1; coarse <= push.coarsest; ++coarse) {
      ivec2 of = ivec2(tile.x >> coarse, tile.y >> coarse) - frame.levels[coarse].tiles.zw;
      add_list(list_of(coarse, of, layer), coarse, first_sheet, point, corner, sample_at);
    }
  }
}

// A finished sheet's value at a sample of the finest level.
void store_value(int sheet, uint at, uint plane_size, float value, float color) {
  uint ring = uint(sheet % frame.ring_sheets);
  if (set_has(kSetHasColor)) color_sheets[ring * plane_size + at] = color;
  if (!set_has(kSetHalfSheets)) sheets[ring * plane_size + at] = floatBitsToUint(value);
}

void finish_samples(uint at, uint plane_size, int first_sheet) {
  uint bits[kBlockDepth];
  for (int j = 0; j < kBlockDepth; ++j) {
    if (!is_wanted(j)) continue;
    float whole = set_has(kSetIsSum) ? sums[j].x : sums[j].y;
    bool is_defined = set_has(kSetIsSum) ? whole != 0.0 : whole >= kLeastSetWeight;
    if (set_has(kSetFindsCover)) is_defined = is_defined && (covered_sheets >> uint(j) & 1u) != 0u;
    float part = set_has(kSetIsSum) ? sums[j].y : sums[j].z;
    float value = !is_defined ? uintBitsToFloat(0x7FC00000u)
                  : set_has(kSetIsSum) ? sums[j].x
                                       : sums[j].x / whole;
    store_value(first_sheet + j, at, plane_size, value, is_defined ? part / whole : 0.0);
    bits[j] = sheet_bits(value, is_defined, set_has(kSetIsSum), frame.sheet_scale,
                         frame.sheet_offset);
  }
  if (!set_has(kSetHalfSheets)) return;
  // Two sheets in a word.
  for (int j = 0; j < kBlockDepth; j += 2) {
    uint ring = uint((first_sheet + j) % frame.ring_sheets) >> 1;
    sheets[ring * plane_size + at] = bits[j] | bits[j + 1] << 16;
  }
}

void main() {
  LevelConstants level = frame.levels[push.level];
  ivec2 tile = ivec2(gl_WorkGroupID.xy);
  int layer = push.layer + int(gl_WorkGroupID.z);
  ivec2 absolute = tile + level.tiles.zw;
  ivec2 corner = absolute * int(kGroupEdge);
  bool is_finest = (kLevelKind & kIsFinest) != 0u;
  if (is_finest && (!is_open(tile, level.tiles.xy) || !is_needed(corner, layer))) return;
  ivec2 within = ivec2(int(gl_LocalInvocationIndex & 7u), int(gl_LocalInvocationIndex >> 3));
  int first_sheet = layer * kBlockDepth;
  for (int j = 0; j < kBlockDepth; ++j) sums[j] = vec3(0.0);
  bool takes_points = set_has(kSetTakesMeans) && kProfile != kProfileGaussian;
  int num_points = takes_points ? kProfilePoints : 1;
  for (int point = 0; point < num_points; ++point) {
    if (set_has(kHasLevels)) {
      add_list(list_of(push.level, tile, layer), push.level, first_sheet, point, vec2(corner),
               vec2(within));
    } else {
      // The lists of all the larger tiles that this one lies in.
      for (int coarse = 0; coarse <= push.coarsest; ++coarse) {
        ivec2 of = ivec2(absolute.x >> coarse, absolute.y >> coarse) -
                   frame.levels[coarse].tiles.zw;
        add_list(list_of(coarse, of, layer), push.level, first_sheet, point, vec2(corner),
                 vec2(within));
      }
    }
  }
  if (set_has(kSetFindsCover) && is_finest)
    find_cover(absolute, layer, first_sheet, num_points, vec2(corner), vec2(within));
  ivec2 size = level.tiles.xy * int(kGroupEdge);
  ivec2 place = tile * int(kGroupEdge) + within;
  uint at = uint(place.y * size.x + place.x);
  uint plane_size = uint(size.x * size.y);
  int in_chunk = (layer - push.layer) * kBlockDepth;
  if ((kLevelKind & kHasCoarser) != 0u) {
    for (int j = 0; j < kBlockDepth; ++j) {
      if (!is_wanted(j)) continue;
      for (uint c = 0u; c < kChannels; ++c)
        sums[j][c] += post_convolved(push.level + 1, in_chunk + j, c, corner + within);
    }
  }
  if (is_finest) {
    finish_samples(at, plane_size, first_sheet);
    if (gl_LocalInvocationIndex == 0u)
      atomicAdd(counts[tile.y * level.tiles.x + tile.x].x, kGroupSize * (push.only_sheet < 0 ? uint(kBlockDepth) : 1u));
    return;
  }
  for (int j = 0; j < kBlockDepth; ++j) {
    if (!is_wanted(j)) continue;
    for (uint c = 0u; c < kChannels; ++c)
      planes[level.plane_at + (uint(in_chunk + j) * kChannels + c) * plane_size + at] = sums[j][c];
  }
}
