// SPDX-License-Identifier: Apache-2.0
// A look as a few straight segments, which a SIMD group keeps in registers: where a look is simple
// enough, permutations of registers replace reading a table.
#pragma once

namespace ovoid::cpu {

// Pieces of a table of the look (view/look/look_table.h), in cells from its entry 0. Segment i
// begins at first[i]; those that are not used begin at infinity.
struct Segments {
  static constexpr int kMost = 16;

  int count = 0;  // 0: the look takes more segments than kMost
  alignas(64) float first[kMost] = {};
};

// At the place p of segment i, red, green, blue and opacity are base[c][i] + slope[c][i] * p.
struct ColorSegments : Segments {
  bool has_logarithms = false;  // number 3 is log2(1 - opacity)
  alignas(64) float base[4][kMost] = {};
  alignas(64) float slope[4][kMost] = {};
};

// How much the look varies up to the place p: terms[0][i] + terms[1][i] * p + terms[2][i] * p^2.
struct VariationSegments : Segments {
  alignas(64) float terms[3][kMost] = {};
  alignas(64) float shows[kMost] = {};  // 0 where the whole segment has no opacity, else 1
};

// How far segments are from the entries that they stand for: colours, and variations; opacities and
// their logarithms, little, since many samples add up. What is 0 stays 0, since that decides what
// is skipped.
inline constexpr double kSegmentColorError = 1.0 / 2048;
inline constexpr double kSegmentVariationError = 1.0 / 4096;  // a four-hundredth of a step
inline constexpr double kSegmentOpacityError = 2e-5;
inline constexpr double kSegmentRelativeOpacityError = 3e-4;  // as well

// Red, green, blue and opacity of `entries`, [kTableCells + 1][4]; or in the place of opacities
// their logarithms, which save a step, if these are few segments, too. Takes some 50 microseconds,
// as below.
ColorSegments color_segments(const float* entries);

// Of `variation`, [kTableCells + 1], and the same entries.
VariationSegments variation_segments(const float* entries, const float* variation);

}  // namespace ovoid::cpu
