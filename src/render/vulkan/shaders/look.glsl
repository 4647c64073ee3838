// SPDX-License-Identifier: Apache-2.0
// Classification: values become colour and opacity, by the tables of a look (view::LookTable).

float place_of(TableConstants table, float value) {
  float steps;
  if (table.scale == kScaleLinear) {
    steps = value - table.origin;
  } else if (table.scale == kScaleLog) {
    steps = float(floatBitsToInt(max(value, 1.17549435e-38)) - table.origin_bits);
  } else {
    int bits = floatBitsToInt(fma(abs(value), table.inverse_width, 1.0)) - floatBitsToInt(1.0);
    steps = float((value < 0.0 ? -bits : bits) - table.origin_bits);
  }
  return steps * table.cells_per_step;
}

float step_of(TableConstants table, uint entry) {
  uint at = table.steps_at + entry;
  return tables[at >> 2][at & 3u];
}

// The entry at or before a value, and how far on the way to the next one the value lies.
struct TablePlace {
  uint entry;
  float fraction;
};

TablePlace find_place(TableConstants table, float value) {
  float at = clamp(place_of(table, value), 0.0, float(kTableCells));
  float entry = floor(at);
  TablePlace place = TablePlace(uint(entry), at - entry);
  if (table.steps_at != kNoTable) {
    float step = step_of(table, place.entry);
    if (step >= 0.0) place.fraction = place.fraction >= step ? 1.0 : 0.0;
  }
  return place;
}

// Colour, not premultiplied, and opacity.
vec4 classify(TableConstants table, float value) {
  TablePlace place = find_place(table, value);
  vec4 lo = tables[table.entries_at + place.entry];
  vec4 hi = tables[table.entries_at + place.entry + 1u];
  return fma(hi - lo, vec4(place.fraction), lo);
}

struct Integrals {
  vec4 high;
  vec4 low;
};

Integrals integrals_to(LookConstants look, float value) {
  float inside = clamp(value, look.integral_lo, look.integral_hi);
  float at = clamp(place_of(look.look, inside), 0.0, float(kTableCells));
  float entry = floor(at);
  vec4 fraction = vec4(at - entry);
  uint i = look.integrals_at + 2u * uint(entry);
  precise vec4 a = tables[i];
  precise vec4 b = tables[i + 2u];
  precise vec4 a_low = tables[i + 1u];
  precise vec4 b_low = tables[i + 3u];
  precise float excess = (value - inside) * look.integral_per_value;
  vec4 end = excess < 0.0 ? look.integrals_before : look.integrals_behind;
  Integrals result;
  result.high = a;
  // (b - a) is exact where it is small against a; the rest is small.
  precise vec4 low = fma(end, vec4(excess), fma((b - a) + (b_low - a_low), fraction, a_low));
  result.low = low;
  return result;
}

// What a piece of straight values between `from` and `to` shows: the mean of what is integrated.
vec4 classify_segment(LookConstants look, float from, float to) {
  Integrals begin = integrals_to(look, from);
  Integrals end = integrals_to(look, to);
  precise vec4 sums = (end.high - begin.high) + (end.low - begin.low);
  if (sums.w == 0.0) return vec4(0.0);
  float mean = max(sums.w / ((to - from) * look.integral_per_value), 0.0);
  return vec4(clamp(sums.rgb / sums.w, 0.0, 1.0), 1.0 - exp(-mean));
}

vec4 classify_from(LookConstants look, float before, float value) {
  float cells = abs(place_of(look.look, value) - place_of(look.look, before));
  if (cells > kClosePieces) return classify_segment(look, before, value);
  return classify(look.look, fma(value - before, 0.5, before));
}

// 1 - (1 - a)^exponent. An opaque sample stays opaque however short its path.
float correct_opacity(float a, float exponent) {
  if (a >= 1.0) return a;
  return 1.0 - exp2(max(log2(max(1.0 - a, 1e-30)) * exponent, -126.0));
}
