#version 450
// SPDX-License-Identifier: Apache-2.0
// Stages "reconstruct" and "post-convolve" of kernel sets: a tile of kGroupEdge^2 samples of a
// level, the sheets of a layer, a thread for a sample.
//
// The tile's splats are taken from their lists as many at a time as there are threads. Each thread
// cuts one with the four sheets; those that meet the tile are named in shared memory, and every
// thread adds them to its sums, in their order. On coarse levels the sums stay in memory for the
// next finer one; on the finest they become field values in a ring of sheets. What the filter
// carries beyond the kernels of coarse levels is no part of a sum: where one is defined, their
// splats are asked once more, until all samples of the tile are known to be reached.
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

// On an H100, work groups of 32 threads with two samples each lost splats now and then.
const uint kThreads = kGroupSize;

// A level's list and how many splats the lists before it have, of those that are gone through.
shared uint list_first[kNumLevels];
shared uint list_before[kNumLevels + 1];
// A splat's cuts lie where its thread has put them, in two vectors each, which threads read all at
// once; `staged_order` names those that meet the tile.
shared vec4 staged_ellipses[kBlockDepth][kThreads];  // center, shape.xy
shared vec4 staged_rests[kBlockDepth][kThreads];     // shape.z, room, scale
shared vec3 staged_values[kThreads];
shared uint staged_order[kThreads];
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
// level in hand, and stages the cuts. True if they meet the tile.
bool stage(DeviceSplat splat, int of_level, int first_sheet, int point, vec2 corner) {
  bool meets = false;
  float unit = float(1 << push.level);
  bool takes_points = set_has(kSetTakesMeans) && kProfile != kProfileGaussian;
  bool takes_means = set_has(kSetTakesMeans) && kProfile == kProfileGaussian;
  vec2 offset = (vec2(frame.center_x, frame.center_y) - 0.5 * (unit - 1.0)) / unit - corner;
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
    float t = s - splat.center.z;
    Section section = kNoSection;
    bool is_cut = is_wanted(j) && abs(t) - (takes_means ? 0.5 : 0.0) < splat.slide.z &&
                  (!set_has(kHasLevels) ||
                   level_for(splat.slide.w, scale_at(depth_at(middle))) == of_level);
    if (is_cut) {
      float factor = scale / unit;
      if (takes_means) {
        float per_depth = set_has(kSetIsParallel) ? 0.0 : frame.sampling_distance / depth;
        section = mean_section(splat, t, factor, offset, per_depth);
      } else {
        section = middle_section(splat, t, factor, offset);
        section.scale *= point_weight;
      }
      // The box around the cut.
      vec3 shape = section.shape;
      float det = max(shape.x * shape.z - 0.25 * shape.y * shape.y, 1e-30);
      vec2 reach = sqrt(max(section.room, 0.0) * shape.zx / det) * 1.001 + 0.01;
      bool is_near =
          section.room > 0.0 &&
          (set_has(kIsFragmentCentric) ||
           (all(lessThanEqual(section.center - reach, vec2(float(kGroupEdge - 1u)))) &&
            all(greaterThanEqual(section.center + reach, vec2(0.0)))));
      if (!is_near) section = kNoSection;
      meets = meets || is_near;
    }
    staged_ellipses[j][gl_LocalInvocationIndex] = vec4(section.center, section.shape.xy);
    staged_rests[j][gl_LocalInvocationIndex] =
        vec4(section.shape.z, section.room, section.scale, 0.0);
  }
  return meets;
}

uint list_of(int level, ivec2 tile, int layer) {
  LevelConstants constants = frame.levels[level];
  return uint(layer - push.first_layer) * uint(frame.num_blocks.w) + constants.first_list +
         uint(tile.y * constants.tiles.x + tile.x);
}

vec3 sums[kBlockDepth];
uint covered_sheets = 0u;  // a bit for each: some kernel reaches the sample there
const uint kAllCovered = (1u << uint(kBlockDepth)) - 1u;

// Adds the splats of a tile's lists on levels [from, to] to the sums, list after list, or, if
// `only_covers`, notes whom they reach. `tile` is one of the level in hand, counted from the
// picture's.
void add_lists(int from, int to, bool only_covers, ivec2 tile, int layer, int point,
               vec2 sample_at) {
  uint self = gl_LocalInvocationIndex;
  uint num_lists = uint(max(to - from + 1, 0));
  // All lists at once: most have few splats or none.
  if (self == 0u) list_before[0] = 0u;
  if (self < num_lists) {
    int level = from + int(self);
    int up = level - push.level;
    ivec2 of = ivec2(tile.x >> up, tile.y >> up) - frame.levels[level].tiles.zw;
    uint list = list_of(level, of, layer);
    list_first[self] = ends[2u * list];
    list_before[self + 1u] = ends[2u * list + 1u] - ends[2u * list];
  }
  barrier();
  if (self == 0u) {
    for (uint n = 1u; n <= num_lists; ++n) list_before[n] += list_before[n - 1u];
  }
  barrier();
  uint past = list_before[num_lists];
  uint list = 0u;  // of the thread's splat
  for (uint batch = 0u; batch < past; batch += kThreads) {
    if (self < 2u) staged_bits[self] = 0u;
    if (self == 2u) is_any_uncovered = 0u;
    barrier();
    if (only_covers) {
      if (covered_sheets != kAllCovered) atomicOr(is_any_uncovered, 1u);
      barrier();
      if (is_any_uncovered == 0u) break;
    }
    bool meets = false;
    uint number = batch + self;
    if (number < past) {
      while (number >= list_before[list + 1u]) ++list;
      DeviceSplat splat = splats[pairs[list_first[list] + (number - list_before[list])].y];
      int of_level = only_covers ? from + int(list) : push.level;
      meets = stage(splat, of_level, layer * kBlockDepth, point, vec2(tile) * float(kGroupEdge));
      staged_values[self] = coefficients_of(splat);
    }
    uint bit = 1u << (self & 31u);
    if (meets) atomicOr(staged_bits[self >> 5], bit);
    barrier();
    uint low = staged_bits[0];
    uint high = staged_bits[1];
    if (meets) {
      uint before = self < 32u ? bitCount(low & (bit - 1u))
                               : bitCount(low) + bitCount(high & (bit - 1u));
      staged_order[before] = self;
    }
    barrier();
    uint count = bitCount(low) + bitCount(high);
    for (uint i = 0u; i < count; ++i) {
      uint place = staged_order[i];
      vec3 values = staged_values[place];
      for (int j = 0; j < kBlockDepth; ++j) {
        vec4 ellipse = staged_ellipses[j][place];
        vec4 rest = staged_rests[j][place];
        Section section =
            Section(ellipse.xy, vec3(ellipse.zw, rest.x), rest.y, rest.z);
        float room = room_at(section, sample_at);
        if (!(room >= 0.0)) continue;
        if (only_covers) {
          if (values.x != 0.0) covered_sheets |= 1u << uint(j);
          continue;
        }
        float phi = section_at(section, room);
        sums[j].x = fma(values.x, phi, sums[j].x);
        if (kChannels > 1u) sums[j].y = fma(values.y, phi, sums[j].y);
        if (kChannels > 2u) sums[j].z = fma(values.z, phi, sums[j].z);
      }
    }
    barrier();
  }
  barrier();  // the next lists take the same places
}

// Sums of coarser levels are still to come: where are they a part of the field?
void find_cover(ivec2 tile, int layer, int num_points, vec2 sample_at) {
  for (int j = 0; j < kBlockDepth; ++j) {
    if (sums[j].x != 0.0 || !is_wanted(j)) covered_sheets |= 1u << uint(j);
  }
  for (int point = 0; point < num_points; ++point)
    add_lists(1, push.coarsest, true, tile, layer, point, sample_at);
}

// A finished sheet's value at a sample of the finest level.
void store_value(int sheet, uint at, uint plane_size, float value, float color) {
  uint ring = uint(sheet % frame.ring_sheets);
  if (set_has(kSetHasColor)) color_sheets[ring * plane_size + at] = color;
  if (!set_has(kSetHalfSheets)) sheets[ring * plane_size + at] = floatBitsToUint(value);
}

void finish_sample(uint at, uint plane_size, int first_sheet) {
  uint bits[kBlockDepth];
  for (int j = 0; j < kBlockDepth; ++j) {
    if (!is_wanted(j)) continue;
    vec3 sum = sums[j];
    float whole = set_has(kSetIsSum) ? sum.x : sum.y;
    bool is_defined = set_has(kSetIsSum) ? whole != 0.0 : whole >= kLeastSetWeight;
    if (set_has(kSetFindsCover))
      is_defined = is_defined && (covered_sheets >> uint(j) & 1u) != 0u;
    float part = set_has(kSetIsSum) ? sum.y : sum.z;
    float value = !is_defined ? uintBitsToFloat(0x7FC00000u)
                  : set_has(kSetIsSum) ? sum.x
                                       : sum.x / whole;
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
  // Without levels, the lists of all the larger tiles that this one lies in.
  int last = set_has(kHasLevels) ? push.level : push.coarsest;
  for (int point = 0; point < num_points; ++point)
    add_lists(push.level, last, false, absolute, layer, point, vec2(within));
  if (set_has(kSetFindsCover) && is_finest) find_cover(absolute, layer, num_points, vec2(within));
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
    finish_sample(at, plane_size, first_sheet);
    if (gl_LocalInvocationIndex == 0u)
      atomicAdd(counts[tile.y * level.tiles.x + tile.x].x,
                kGroupSize * (push.only_sheet < 0 ? uint(kBlockDepth) : 1u));
    return;
  }
  for (int j = 0; j < kBlockDepth; ++j) {
    if (!is_wanted(j)) continue;
    for (uint c = 0u; c < kChannels; ++c)
      planes[level.plane_at + (uint(in_chunk + j) * kChannels + c) * plane_size + at] = sums[j][c];
  }
}
