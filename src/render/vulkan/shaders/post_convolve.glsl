// SPDX-License-Identifier: Apache-2.0
// Stage "post-convolve" of kernel sets: sums of a coarse level at a sample of the next finer one,
// which lies a quarter before or behind a coarse sample along either axis.

float tap_at(int k) { return frame.taps[k >> 2][k & 3]; }

// `fine`: the sample, counted from the picture's corner; `coarse`: the level.
float post_convolved(int coarse, int sheet, uint channel, ivec2 fine) {
  LevelConstants level = frame.levels[coarse];
  ivec2 size = level.tiles.xy * int(kGroupEdge);
  ivec2 corner = level.tiles.zw * int(kGroupEdge);
  bvec2 is_behind = bvec2((fine.x & 1) != 0, (fine.y & 1) != 0);
  ivec2 first = ivec2(fine.x >> 1, fine.y >> 1) - 2 - corner - ivec2(not(is_behind));
  int at_x = is_behind.x ? 0 : 6;
  int at_y = is_behind.y ? 0 : 6;
  uint plane = level.plane_at + (uint(sheet) * kChannels + channel) * uint(size.x * size.y);
  float sum = 0.0;
  for (int j = 0; j < 6; ++j) {
    int y = first.y + j;
    if (y < 0 || y >= size.y) continue;
    float row = 0.0;
    for (int i = 0; i < 6; ++i) {
      int x = first.x + i;
      if (x >= 0 && x < size.x) row = fma(planes[plane + uint(y * size.x + x)], tap_at(at_x + i), row);
    }
    sum = fma(row, tap_at(at_y + j), sum);
  }
  return sum;
}
