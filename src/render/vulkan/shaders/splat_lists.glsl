// SPDX-License-Identifier: Apache-2.0
// Which lists a splat belongs to: those of a level's tiles, layer by layer, whose samples it
// reaches. With levels it is listed on the level that it is summed on, else on the one whose tiles
// are about as large as it is, so that it is in a few lists at most, however large it is.
//
// `emit_list(list)` is the including shader's.

bool layer_is_needed(int layer) { return needed_layers[layer] != 0u; }

int level_of_tiles(float width) {
  float tiles = min(width / float(kGroupEdge), 1e6);
  return tiles <= 1.0 ? 0 : min(kNumLevels - 1, findMSB(uint(ceil(tiles))) + 1);
}

void list_on_level(int level, int layer, vec2 from, vec2 to) {
  LevelConstants constants = frame.levels[level];
  const float kSlack = 0.02;
  float unit = float(1 << level);
  float edge = float(kGroupEdge) * unit;
  // Samples of a level lie in the middle of its pixels; without levels, and where pixels are asked
  // for too, tiles are of pixels.
  bool is_of_samples = set_has(kHasLevels) && !set_has(kSetFindsCover);
  float middle = is_of_samples ? 0.5 * (unit - 1.0) : 0.0;
  float last = is_of_samples ? float(kGroupEdge - 1u) * unit : edge - 1.0;
  vec2 first_tile = ceil((from - middle - last - kSlack) / edge);
  vec2 last_tile = floor((to - middle + kSlack) / edge);
  vec2 least = vec2(constants.tiles.zw);
  vec2 most = vec2(constants.tiles.zw + constants.tiles.xy - 1);
  ivec2 lo = ivec2(clamp(first_tile, least, most + 1.0)) - constants.tiles.zw;
  ivec2 hi = ivec2(clamp(last_tile, least - 1.0, most)) - constants.tiles.zw;
  uint base = uint(layer - push.first_layer) * uint(frame.num_blocks.w) + constants.first_list;
  for (int y = lo.y; y <= hi.y; ++y) {
    for (int x = lo.x; x <= hi.x; ++x) emit_list(base + uint(y * constants.tiles.x + x));
  }
}

void for_each_list(DeviceSplat splat) {
  float reach = set_has(kSetTakesMeans) ? 0.5 : 0.0;
  float reach_s = splat.slide.z;
  float first_sheet = splat.center.z - reach_s - reach;
  float last_sheet = splat.center.z + reach_s + reach;
  float first_s = float(push.first_layer * kBlockDepth);
  float last_s = float(push.end_layer * kBlockDepth);
  if (!(last_sheet >= first_s - 1.0) || !(first_sheet <= last_s)) return;
  int first = max(int(max(first_sheet, 0.0)) / kBlockDepth - 1, push.first_layer);
  int end = min(int(min(last_sheet, last_s)) / kBlockDepth + 1, push.end_layer);
  vec2 center = vec2(frame.center_x, frame.center_y);
  for (int layer = first; layer < end; ++layer) {
    if (!layer_is_needed(layer)) continue;
    float layer_first = float(layer * kBlockDepth) - reach;
    float layer_last = float(layer * kBlockDepth + kBlockDepth - 1) + reach;
    float t0 = max(first_sheet, layer_first) - splat.center.z;
    float t1 = min(last_sheet, layer_last) - splat.center.z;
    if (t0 > t1) continue;
    // The cut is widest where it is nearest to the centre.
    float width = 1.0;
    if (!set_has(kSetTakesMeans) && (t0 > 0.0 || t1 < 0.0)) {
      float share = (t0 > 0.0 ? t0 : t1) / reach_s;
      width = sqrt(max(0.0, 1.0 - share * share)) + 1e-3;
    }
    float scale_hi = scale_at(max(depth_at(layer_first), frame.near_depth)) * 1.00001;
    float scale_lo = scale_at(max(depth_at(layer_last), frame.near_depth)) * 0.99999;
    vec2 a = splat.slide.xy * t0;
    vec2 b = splat.slide.xy * t1;
    vec2 lo = splat.center.xy + min(a, b) - splat.values.zw * width;
    vec2 hi = splat.center.xy + max(a, b) + splat.values.zw * width;
    vec2 from = center + lo * mix(vec2(scale_lo), vec2(scale_hi), lessThan(lo, vec2(0.0)));
    vec2 to = center + hi * mix(vec2(scale_lo), vec2(scale_hi), greaterThan(hi, vec2(0.0)));
    if (set_has(kHasLevels)) {
      int coarsest = level_for(splat.slide.w, scale_hi);
      for (int level = level_for(splat.slide.w, scale_lo); level <= coarsest; ++level)
        list_on_level(level, layer, from, to);
    } else if (set_has(kIsFragmentCentric)) {
      list_on_level(3, layer, from, to);  // the tiles are the plan's blocks
    } else {
      list_on_level(level_of_tiles(max(to.x - from.x, to.y - from.y)), layer, from, to);
    }
  }
}
