// SPDX-License-Identifier: Apache-2.0
// What sheets of 16 bits keep of a value: sums, which have no bounds, a half float; normalized
// fields, which have, whole numbers over their range and a little more: differences of neighbours on
// a gentle slope would drown in the steps of half floats. 0 is undefined there, NaN here.

const float kMostSheetBits = 65534.0;

uint sheet_bits(float value, bool is_defined, bool is_sum, float scale, float offset) {
  float held = (value - offset) * scale;
  if (is_sum)
    return is_defined ? packHalf2x16(vec2(clamp(held, -65504.0, 65504.0), 0.0)) & 0xFFFFu : 0x7E00u;
  return is_defined ? 1u + uint(clamp(held, 0.0, 1.0) * kMostSheetBits + 0.5) : 0u;
}

// Whether there is a value; then `value` is it.
bool read_sheet_bits(uint bits, bool is_sum, float scale, float offset, out float value) {
  value = offset;
  if (is_sum) {
    if ((bits & 0x7C00u) == 0x7C00u) return false;
    value += unpackHalf2x16(bits).x / scale;
    return true;
  }
  if (bits == 0u) return false;
  value += float(bits - 1u) / (kMostSheetBits * scale);
  return true;
}
