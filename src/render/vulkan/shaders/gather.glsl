// SPDX-License-Identifier: Apache-2.0
// Stage "reconstruct" of lattices, by gathering: a sample sums the kernels that reach it, in an
// order that is always the same.
//
// Samples lie in cubes of kStoredEdge^3, four along x in as many words as they have bytes, so that
// a row of four taps is two words of a cube and of its neighbour, or one, and rays in any direction
// find neighbours near in memory.
//
// Two ways, same numbers: four taps along each axis, unrolled, for the default kernel; and loops,
// for all others, holes, sums, means and widened kernels.


struct Gathered {
  float value;
  vec3 gradient;  // index space; where asked for
  bool is_defined;
};

ivec3 dims_of(LatticeConstants lattice, int sublattice) {
  Sublattice own = lattice.sublattices[sublattice];
  return ivec3(own.dims[0], own.dims[1], own.dims[2]);
}

uint type_of(int field) { return field == 0 ? kType0 : kType1; }
uint flags_of(int field) { return field == 0 ? kFieldFlags0 : kFieldFlags1; }
bool field_has(int field, uint flag) { return (flags_of(field) & flag) != 0u; }

uint word_at(int field, uint at) { return field == 0 ? words0[at] : words1[at]; }
uvec2 two_words_at(int field, uint at) { return field == 0 ? words0_by_two[at] : words1_by_two[at]; }
uvec4 four_words_at(int field, uint at) {
  return field == 0 ? words0_by_four[at] : words1_by_four[at];
}

// Words for four samples of a row.
uint words_per_four(int field) {
  uint type = type_of(field);
  return type == kTypeF32 ? 4u : type == kTypeU16 || type == kTypeI16 ? 2u : 1u;
}

// Of row (y, z) of the first sublattice: the fours of samples before that of x = 0 of the stored
// box. A sum of a part by y and one by z.
uint fours_to_row(int y, int z) {
  uvec2 at = uvec2(y - box.stored_lo.y, z - box.stored_lo.z);
  uint cubes_per_row = uint(box.stored_bricks.x) * 16u;
  return ((at.y >> 2) * uint(box.stored_bricks.y) * cubes_per_row + (at.y & 3u) * 4u) +
         ((at.x >> 2) * cubes_per_row + (at.x & 3u));
}

// Of row (y, z) of a sublattice: the word of sample x = 0 of the stored box.
uint row_at(int field, int sublattice, int y, int z) {
  return (uint(sublattice) * uint(box.stored_bricks.w) + fours_to_row(y, z)) *
         words_per_four(field);
}

float number_of(uint type, uint bits) {
  if (type == kTypeU8) return float(bits & 255u);
  if (type == kTypeI8) return float(bitfieldExtract(int(bits), 0, 8));
  if (type == kTypeU16) return float(bits & 65535u);
  return float(bitfieldExtract(int(bits), 0, 16));
}

// Sample x of a row, as stored.
float sample_at(int field, uint row, int x) {
  uint at = uint(x - box.stored_lo.x);
  uint type = type_of(field);
  uint four = words_per_four(field);
  uint cube = row + (at >> 2) * 16u * four;
  uint within = at & 3u;
  if (four == 4u) return uintBitsToFloat(word_at(field, cube + within));
  if (four == 2u)
    return number_of(type, word_at(field, cube + (within >> 1)) >> ((within & 1u) * 16u));
  return number_of(type, word_at(field, cube) >> (within * 8u));
}

// A small whole number, as the exponent of 2^23 makes it one: faster than a conversion.
float number_of_bits(uint bits) { return uintBitsToFloat(bits | 0x4B000000u) - 8388608.0; }

vec4 numbers_of_bytes(uint type, uint word) {
  if (type == kTypeI8) word ^= 0x80808080u;
  vec4 numbers = vec4(number_of_bits(word & 255u), number_of_bits(word >> 8 & 255u),
                      number_of_bits(word >> 16 & 255u), number_of_bits(word >> 24));
  return type == kTypeI8 ? numbers - 128.0 : numbers;
}

vec4 numbers_of_halves(uint type, uvec2 words) {
  if (type == kTypeI16) words ^= 0x80008000u;
  vec4 numbers = vec4(number_of_bits(words.x & 65535u), number_of_bits(words.x >> 16),
                      number_of_bits(words.y & 65535u), number_of_bits(words.y >> 16));
  return type == kTypeI16 ? numbers - 32768.0 : numbers;
}

// Four samples of a row, those from the `within`-th on of the cube that begins at `cube`, the rest
// of the one at `next`; counted in fours.
vec4 four_samples(int field, uint cube, uint next, uint within) {
  uint type = type_of(field);
  uint four = words_per_four(field);
  if (four == 1u) {
    uint word = word_at(field, cube);
    uint shift = within * 8u;
    if (within != 0u) word = word >> shift | word_at(field, next) << (32u - shift);
    return numbers_of_bytes(type, word);
  }
  if (four == 2u) {
    uvec2 a = two_words_at(field, cube);
    uvec2 b = two_words_at(field, next);
    uvec3 words = within < 2u ? uvec3(a, b.x) : uvec3(a.y, b);
    if ((within & 1u) != 0u) words.xy = words.xy >> 16 | words.yz << 16;
    return numbers_of_halves(type, words.xy);
  }
  vec4 a = uintBitsToFloat(four_words_at(field, cube));
  vec4 b = uintBitsToFloat(four_words_at(field, next));
  if ((within & 2u) != 0u) {
    a = vec4(a.zw, b.xy);
    b = b.zwzw;
  }
  return (within & 1u) != 0u ? vec4(a.yzw, b.x) : a;
}

bool is_missing(float number) { return (floatBitsToUint(number) & 0x7F800000u) == 0x7F800000u; }

// The weights of the taps -1, 0, 1 and 2 from a cell, of those that exist, summing to 1, and their
// derivatives.
struct FourWeights {
  vec4 weight;
  vec4 slope;
  float share;     // of the endless lattice's weights that exist
  float variance;  // of the tap's number under the endless lattice's
};

const vec4 kTapNumbers = vec4(-1.0, 0.0, 1.0, 2.0);

// Piecewise kernels: the weight at t >= 0 of the kernel's units, and its derivative.
float piece_at(LatticeConstants lattice, float t) {
  vec4 c = t < 1.0 ? lattice.inner_piece : lattice.outer_piece;
  return t < 2.0 ? fma(fma(fma(c.w, t, c.z), t, c.y), t, c.x) : 0.0;
}

float piece_slope_at(LatticeConstants lattice, float t) {
  vec4 c = t < 1.0 ? lattice.inner_piece : lattice.outer_piece;
  return t < 2.0 ? fma(fma(3.0 * c.w, t, 2.0 * c.z), t, c.y) : 0.0;
}

vec4 existing_of(vec4 weights, int cell, int dims) {
  for (int k = 0; k < 4; ++k) {
    int tap = cell + k - 1;
    if (tap < 0 || tap >= dims) weights[k] = 0.0;
  }
  return weights;
}

FourWeights four_piecewise_weights(LatticeConstants lattice, float fraction, int cell, int dims) {
  FourWeights result;
  result.weight =
      vec4(piece_at(lattice, fraction + 1.0), piece_at(lattice, fraction),
           piece_at(lattice, 1.0 - fraction), piece_at(lattice, 2.0 - fraction));
  result.slope =
      vec4(piece_slope_at(lattice, fraction + 1.0), piece_slope_at(lattice, fraction),
           -piece_slope_at(lattice, 1.0 - fraction), -piece_slope_at(lattice, 2.0 - fraction));
  result.share = 1.0;
  result.variance = 0.0;
  if (cell >= 1 && cell + 2 < dims) return result;
  result.weight = existing_of(result.weight, cell, dims);
  result.slope = existing_of(result.slope, cell, dims);
  result.share = dot(result.weight, vec4(1.0));
  float inverse = 1.0 / max(result.share, 1e-6);
  result.weight *= inverse;
  result.slope = result.slope * inverse - result.weight * dot(result.slope, vec4(inverse));
  return result;
}

// g(f + 1) : g(f) : g(1 - f) : g(2 - f) = n : e : n e^2 : F e^3 with e = exp(f / sigma^2). The
// derivatives are d w_k / d f = w_k (k - mean of k) / sigma^2.
FourWeights four_gaussian_weights(LatticeConstants lattice, float fraction, int cell, int dims) {
  float e = exp2(fraction * lattice.inverse_variance * 1.44269504);
  vec4 w = vec4(lattice.near_weight, e, lattice.near_weight * e * e, lattice.far_weight * e * e * e);
  float total = (w.x + w.y) + (w.z + w.w);
  FourWeights result;
  float mean = dot(w, kTapNumbers) / total;
  result.variance = dot(w, kTapNumbers * kTapNumbers) / total - mean * mean;
  if (cell < 1 || cell + 2 >= dims) {
    w = existing_of(w, cell, dims);
    float existing = (w.x + w.y) + (w.z + w.w);
    result.share = existing / total;
    total = max(existing, 1e-30);
  } else {
    result.share = 1.0;
  }
  result.weight = w / total;
  result.slope = result.weight * lattice.inverse_variance *
                 (kTapNumbers - dot(result.weight, kTapNumbers));
  return result;
}

FourWeights four_weights(int field, float fraction, int cell, int dims) {
  LatticeConstants lattice = frame.fields[field];
  return field_has(field, kIsPiecewise)
             ? four_piecewise_weights(lattice, fraction, cell, dims)
             : four_gaussian_weights(lattice, fraction, cell, dims);
}

Gathered gather_four(int field, Place place, bool wants_gradient) {
  LatticeConstants lattice = frame.fields[field];
  ivec3 dims = dims_of(lattice, 0);
  FourWeights x = four_weights(field, place.fraction.x, place.cell.x, dims.x);
  FourWeights y = four_weights(field, place.fraction.y, place.cell.y, dims.y);
  FourWeights z = four_weights(field, place.fraction.z, place.cell.z, dims.z);
  Gathered result;
  result.gradient = vec3(0.0);
  result.value = 0.0;
  result.is_defined = x.share * y.share * z.share >= kLeastShare;
  if (!result.is_defined) return result;
  ivec3 first = place.cell - 1;
  bool is_inside = all(greaterThanEqual(first, ivec3(0))) && all(lessThan(first + 3, dims));
  uvec3 at = uvec3(first - box.stored_lo.xyz);
  uint cube = at.x >> 2;  // the last has no next one, and needs none
  uint next = min(cube + 1u, uint(box.stored_bricks.x) - 1u) * 16u;
  cube *= 16u;
  vec4 sum = vec4(0.0), sum_y = vec4(0.0), sum_z = vec4(0.0);
  for (int k = 0; k < 4; ++k) {
    int tap_z = clamp(first.z + k, 0, dims.z - 1);
    vec4 slice = vec4(0.0), slice_y = vec4(0.0);
    for (int j = 0; j < 4; ++j) {
      int tap_y = clamp(first.y + j, 0, dims.y - 1);
      vec4 taps;
      if (is_inside) {
        uint row = fours_to_row(tap_y, tap_z);
        taps = four_samples(field, row + cube, row + next, at.x & 3u);
      } else {
        uint row = row_at(field, 0, tap_y, tap_z);
        for (int i = 0; i < 4; ++i)
          taps[i] = sample_at(field, row, clamp(first.x + i, 0, dims.x - 1));
      }
      slice = fma(taps, vec4(y.weight[j]), slice);
      if (wants_gradient) slice_y = fma(taps, vec4(y.slope[j]), slice_y);
    }
    sum = fma(slice, vec4(z.weight[k]), sum);
    if (wants_gradient) {
      sum_y = fma(slice_y, vec4(z.weight[k]), sum_y);
      sum_z = fma(slice, vec4(z.slope[k]), sum_z);
    }
  }
  result.value = fma(dot(sum, x.weight), lattice.value_scale, lattice.value_offset);
  if (wants_gradient) {
    vec3 gradient = vec3(dot(sum, x.slope), dot(sum_y, x.weight), dot(sum_z, x.weight));
    if (field_has(field, kCorrects)) {
      vec3 variance = vec3(x.variance, y.variance, z.variance);
      vec3 answer = variance * lattice.inverse_variance;
      gradient = mix(gradient, gradient / answer, greaterThan(variance, vec3(kLeastVariance)));
    }
    result.gradient = gradient * lattice.value_scale;
  }
  return result;
}

// Sum of samples, or of what exists, times weights, and its derivatives in index space.
struct Sums {
  vec4 samples;  // xyz: derivatives, w: the sum
  vec4 weights;  // of `sum` w alone, of magnitudes: is there a kernel that reaches?
  float endless;
};

// Numbers of the taps of one axis that a kernel reaches, the cell being 0, and the weights' sums.
struct AxisTaps {
  int first, last;              // of those that exist
  float existing, derivative;  // sums
  float endless;
};

// The kernel along one axis, widened.
struct AxisKernel {
  float support;
  float inverse_variance;
  float inverse_unit;
};

AxisKernel axis_kernel(LatticeConstants lattice, float widening) {
  return AxisKernel(lattice.support * widening, lattice.inverse_variance / (widening * widening),
                    lattice.inverse_unit / widening);
}

float tap_weight(int field, AxisKernel kernel, float distance) {
  if (field_has(field, kIsPiecewise))
    return piece_at(frame.fields[field], abs(distance) * kernel.inverse_unit);
  return exp2(distance * distance * kernel.inverse_variance * -0.72134752);
}

// Its derivative by the position, `distance` behind the tap.
float tap_slope(int field, AxisKernel kernel, float distance, float weight) {
  if (field_has(field, kIsPiecewise)) {
    float slope = piece_slope_at(frame.fields[field], abs(distance) * kernel.inverse_unit);
    return (distance < 0.0 ? -slope : slope) * kernel.inverse_unit;
  }
  return -weight * distance * kernel.inverse_variance;
}

AxisTaps taps_of(int field, AxisKernel kernel, float fraction, int cell, int dims) {
  int reach_first = int(ceil(fraction - kernel.support));
  int reach_last = int(floor(fraction + kernel.support));
  AxisTaps taps;
  taps.first = max(reach_first, -cell);
  taps.last = min(reach_last, dims - 1 - cell);
  taps.existing = taps.derivative = taps.endless = 0.0;
  for (int k = reach_first; k <= reach_last; ++k) {
    float distance = fraction - float(k);
    float weight = tap_weight(field, kernel, distance);
    taps.endless += weight;
    if (k < taps.first || k > taps.last) continue;
    taps.existing += weight;
    taps.derivative += tap_slope(field, kernel, distance, weight);
  }
  return taps;
}

// Adds what the kernels of one sublattice bring to a place, which is relative to it.
void add_sublattice(int field, int sublattice, Place place, vec3 widening, float point_weight,
                    bool may_miss, inout Sums sums) {
  LatticeConstants lattice = frame.fields[field];
  ivec3 dims = dims_of(lattice, sublattice);
  AxisKernel kernel_x = axis_kernel(lattice, widening.x);
  AxisKernel kernel_y = axis_kernel(lattice, widening.y);
  AxisKernel kernel_z = axis_kernel(lattice, widening.z);
  AxisTaps x = taps_of(field, kernel_x, place.fraction.x, place.cell.x, dims.x);
  AxisTaps y = taps_of(field, kernel_y, place.fraction.y, place.cell.y, dims.y);
  AxisTaps z = taps_of(field, kernel_z, place.fraction.z, place.cell.z, dims.z);
  sums.endless += point_weight * x.endless * y.endless * z.endless;
  if (x.first > x.last || y.first > y.last || z.first > z.last) return;
  vec4 samples = vec4(0.0);
  vec4 weights = vec4(0.0);
  for (int k = z.first; k <= z.last; ++k) {
    float distance_z = place.fraction.z - float(k);
    float weight_z = tap_weight(field, kernel_z, distance_z);
    vec3 slice = vec3(0.0), slice_weights = vec3(0.0);  // x, y, sum
    for (int j = y.first; j <= y.last; ++j) {
      float distance_y = place.fraction.y - float(j);
      float weight_y = tap_weight(field, kernel_y, distance_y);
      uint row = row_at(field, sublattice, place.cell.y + j, place.cell.z + k);
      vec2 line = vec2(0.0), line_weights = vec2(0.0);  // derivative along x, sum
      for (int i = x.first; i <= x.last; i += 4) {
        vec4 weight, derivatives, numbers;
        for (int n = 0; n < 4; ++n) {
          float distance = place.fraction.x - float(i + n);
          weight[n] = tap_weight(field, kernel_x, distance);
          derivatives[n] = tap_slope(field, kernel_x, distance, weight[n]);
          numbers[n] = sample_at(field, row, place.cell.x + min(i + n, x.last));
          bool counts_not = i + n > x.last || (may_miss && is_missing(numbers[n]));
          if (counts_not) numbers[n] = weight[n] = derivatives[n] = 0.0;
        }
        numbers = fma(numbers, vec4(lattice.value_scale), vec4(lattice.value_offset));
        line += vec2(dot(numbers, derivatives), dot(numbers, weight));
        vec4 shares = field_has(field, kIsSum) ? abs(weight) : weight;
        line_weights += vec2(dot(vec4(1.0), derivatives), dot(vec4(1.0), shares));
      }
      float slope_y = tap_slope(field, kernel_y, distance_y, weight_y);
      slice += vec3(weight_y * line.x, slope_y * line.y, weight_y * line.y);
      float share_y = field_has(field, kIsSum) ? abs(weight_y) : weight_y;
      slice_weights +=
          vec3(weight_y * line_weights.x, slope_y * line_weights.y, share_y * line_weights.y);
    }
    float slope_z = tap_slope(field, kernel_z, distance_z, weight_z);
    samples += vec4(weight_z * slice.xy, slope_z * slice.z, weight_z * slice.z);
    float share_z = field_has(field, kIsSum) ? abs(weight_z) : weight_z;
    weights += vec4(weight_z * slice_weights.xy, slope_z * slice_weights.z,
                    share_z * slice_weights.z);
  }
  if (!may_miss) {
    weights = vec4(x.derivative * y.existing * z.existing, x.existing * y.derivative * z.existing,
                   x.existing * y.existing * z.derivative, x.existing * y.existing * z.existing);
  }
  sums.samples += point_weight * samples;
  sums.weights += point_weight * weights;
}

Place in_sublattice(Place place, float offset) {
  return offset == 0.0 ? place : moved(place, vec3(-offset));
}

float offset_of(LatticeConstants lattice, int sublattice) {
  return sublattice == 0 ? lattice.sublattices[0].offset : lattice.sublattices[1].offset;
}

int num_sublattices(int field) { return field_has(field, kIsDouble) ? 2 : 1; }

// Of the samples' places along one axis under the weights of an endless lattice: sum of weights,
// mean relative to the place, variance.
vec3 moments_of(int field, AxisKernel kernel, float fraction) {
  float total = 0.0, mean = 0.0, square = 0.0;
  for (int i = int(ceil(fraction - kernel.support)); i <= int(floor(fraction + kernel.support));
       ++i) {
    float distance = float(i) - fraction;
    float weight = tap_weight(field, kernel, distance);
    total += weight;
    mean += weight * distance;
    square += weight * distance * distance;
  }
  if (!(total > 0.0)) return vec3(0.0);
  mean /= total;
  return vec3(total, mean, square / total - mean * mean);
}

// Makes the gradient of ramps constant (docs/numerics.md, "Gradients").
vec3 corrected(int field, Place place, vec3 widening, vec3 gradient) {
  LatticeConstants lattice = frame.fields[field];
  vec3 inverse = lattice.inverse_variance / (widening * widening);
  vec3 squared = 1.0 / inverse;
  float weights[2] = float[2](1.0, 1.0);
  vec3 means[2], variances[2];
  for (int s = 0; s < num_sublattices(field); ++s) {
    Place own = in_sublattice(place, offset_of(lattice, s));
    for (int a = 0; a < 3; ++a) {
      vec3 m = moments_of(field, axis_kernel(lattice, widening[a]), own.fraction[a]);
      weights[s] *= m.x;
      means[s][a] = m.y;
      variances[s][a] = m.z;
    }
    if (!(weights[s] > 0.0)) {
      weights[s] = 0.0;
      means[s] = variances[s] = vec3(0.0);
    }
  }
  if (!field_has(field, kIsDouble))
    return mix(gradient, gradient * squared / variances[0],
               greaterThan(variances[0], vec3(kLeastVariance)));
  float total = weights[0] + weights[1];
  vec3 within = (weights[0] * variances[0] + weights[1] * variances[1]) / total;
  if (!(min(min(within.x, within.y), within.z) > kLeastInnerVariance)) return gradient;
  vec3 apart = means[1] - means[0];
  float c = weights[0] * weights[1] / (total * total);
  vec3 scaled = gradient * squared;
  float share = c * dot(apart, scaled / within) / (1.0 + c * dot(apart, apart / within));
  return (scaled - share * apart) / within;
}

// Does any kernel of a sublattice reach the place, or its slab, `step` long?
bool meets_support_of(int field, int sublattice, Place place, vec3 widening, vec3 step) {
  LatticeConstants lattice = frame.fields[field];
  Place own = in_sublattice(place, offset_of(lattice, sublattice));
  vec3 support = lattice.support * widening;
  vec3 below = -vec3(own.cell) - own.fraction - support;
  vec3 above = vec3(dims_of(lattice, sublattice) - 1 - own.cell) - own.fraction + support;
  float from = -0.5, to = 0.5;
  for (int a = 0; a < 3; ++a) {
    if (!field_has(field, kTakesMeans) || step[a] == 0.0) {
      if (below[a] > 0.0 || above[a] < 0.0) return false;
      continue;
    }
    float at_below = below[a] / step[a];
    float at_above = above[a] / step[a];
    from = max(from, min(at_below, at_above));
    to = min(to, max(at_below, at_above));
    if (from > to) return false;
  }
  return true;
}

Gathered gather_general(int field, Place place, vec3 widening, vec3 step, bool may_miss,
                        bool wants_gradient) {
  LatticeConstants lattice = frame.fields[field];
  Sums sums;
  sums.samples = sums.weights = vec4(0.0);
  sums.endless = 0.0;
  int num_points = field_has(field, kTakesMeans) ? lattice.num_slab_points : 1;
  for (int point = 0; point < num_points; ++point) {
    SlabPoint slab = SlabPoint(0.0, 1.0);
    Place at = place;
    if (field_has(field, kTakesMeans)) {
      slab = lattice.slab[point];
      at = moved(place, slab.offset * step);
    }
    for (int s = 0; s < num_sublattices(field); ++s) {
      add_sublattice(field, s, in_sublattice(at, offset_of(lattice, s)), widening, slab.weight,
                     may_miss, sums);
    }
  }
  Gathered result;
  result.gradient = vec3(0.0);
  if (field_has(field, kIsSum)) {
    result.is_defined = may_miss ? sums.weights.w > 0.0
                                 : meets_support_of(field, 0, place, widening, step) ||
                                       (field_has(field, kIsDouble) &&
                                        meets_support_of(field, 1, place, widening, step));
    float weight = lattice.sum_weight / (widening.x * widening.y * widening.z);
    result.value = weight * sums.samples.w;
    result.gradient = weight * sums.samples.xyz;
    return result;
  }
  result.is_defined =
      sums.weights.w >= kLeastShare * sums.endless && sums.weights.w > 0.0;
  result.value = 0.0;
  if (!result.is_defined) return result;
  float inverse = 1.0 / sums.weights.w;
  result.value = sums.samples.w * inverse;
  if (wants_gradient) {
    result.gradient = (sums.samples.xyz - result.value * sums.weights.xyz) * inverse;
    if (field_has(field, kCorrects))
      result.gradient = corrected(field, place, widening, result.gradient);
  }
  return result;
}

// Whether samples that reach a cell may be missing.
uint brick_byte(int field, vec3 at) {
  LatticeConstants lattice = frame.fields[field];
  ivec3 brick = clamp(ivec3(floor(at)) >> lattice.num_bricks.w, ivec3(0), lattice.num_bricks.xyz - 1);
  uint index = uint((brick.z * lattice.num_bricks.y + brick.y) * lattice.num_bricks.x + brick.x);
  uint word = field == 0 ? bricks0[index >> 2] : bricks1[index >> 2];
  return word >> ((index & 3u) * 8u) & 255u;
}

vec3 widening_on(int field, float s) {
  vec3 pitch = (frame.view.pitch + s * frame.view.pitch_per_sheet) *
               frame.fields[field].inverse_spacing.xyz;
  return max(min(pitch, frame.fields[field].widening_limit.xyz), vec3(1.0));
}

// The field at a place near sheet s, where its slab is `step` long.
Gathered gather(int field, Place place, float s, vec3 step, bool wants_gradient) {
  if (field_has(field, kIsNarrow) && !field_has(field, kMayMiss))
    return gather_four(field, place, wants_gradient);
  bool may_miss = field_has(field, kMayMiss) &&
                  (brick_byte(field, vec3(place.cell)) & kMissingBit) != 0u;
  vec3 widening = widening_on(field, s);
  if (field_has(field, kHasFourTaps) && !may_miss && all(equal(widening, vec3(1.0))))
    return gather_four(field, place, wants_gradient);
  return gather_general(field, place, widening, step, may_miss, wants_gradient);
}

vec3 to_world(int field, vec3 gradient) {
  return vec3(dot(frame.fields[field].gradient_rows[0].xyz, gradient),
              dot(frame.fields[field].gradient_rows[1].xyz, gradient),
              dot(frame.fields[field].gradient_rows[2].xyz, gradient));
}
