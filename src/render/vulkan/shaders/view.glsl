// SPDX-License-Identifier: Apache-2.0
// Where samples lie, and how long their paths are. `view_of` is a frame's ViewConstants.

// A number as the sum of two floats.
struct Exact {
  vec3 hi;
  vec3 lo;
};

// a + b * x. The products' and the sum's rounding errors are kept, so nothing may be fused or
// reordered.
Exact add_product(Exact a, vec3 b_hi, vec3 b_lo, float x) {
  precise vec3 product = b_hi * x;
  precise vec3 product_error = fma(b_hi, vec3(x), -product);
  precise vec3 sum = a.hi + product;
  precise vec3 other = sum - a.hi;
  precise vec3 sum_error = (a.hi - (sum - other)) + (product - other);
  precise vec3 lo = a.lo + (sum_error + (product_error + b_lo * x));
  Exact result;
  result.hi = sum;
  result.lo = lo;
  return result;
}

// Index space: a cell and where in it, in [0, 1).
struct Place {
  ivec3 cell;
  vec3 fraction;
};

Place place_from(vec3 whole, vec3 rest) {
  vec3 carry = floor(rest);
  Place place;
  place.cell = ivec3(whole + carry);
  place.fraction = min(rest - carry, vec3(0.99999994));
  return place;
}

Place place_from(Exact at) {
  vec3 whole = floor(at.hi);
  return place_from(whole, (at.hi - whole) + at.lo);
}

Place moved(Place place, vec3 by) { return place_from(vec3(place.cell), place.fraction + by); }

float depth_of_sheet(float s) {
  return fma(s, frame.view.sampling_distance, frame.view.first_depth);
}

// Length of the ray per unit of depth, and the unit vector to the eye.
vec3 ray_of(vec2 pixel) {
  return frame.view.ray[0].xyz + pixel.x * frame.view.ray[1].xyz + pixel.y * frame.view.ray[2].xyz;
}

float ray_length(vec2 pixel) { return has_flag(kIsParallel) ? 1.0 : length(ray_of(pixel)); }

vec3 to_eye(vec2 pixel) {
  return has_flag(kIsParallel) ? -frame.view.axis.xyz : -normalize(ray_of(pixel));
}

float at_pixel(vec4 map, vec2 pixel) { return map.x + pixel.x * map.y + pixel.y * map.z; }

// The part of `range`, in sheets behind sheet s, that lies in all clip half spaces and in front of
// the eye; empty where its end is not behind its beginning.
vec2 kept_part(vec2 pixel, float s, vec2 range) {
  if (!has_flag(kIsClipped)) return range;
  if (!has_flag(kIsParallel)) range.x = max(range.x, frame.view.near_cut - s);
  for (uint i = 0u; i < frame.view.num_clips; ++i) {
    float slope = at_pixel(frame.view.clips[i].per_sheet, pixel);
    float inside = fma(s, slope, at_pixel(frame.view.clips[i].at_first, pixel));
    if (abs(slope) < 1e-20) {
      if (inside < 0.0) range.y = range.x;
      continue;
    }
    float crossing = -inside / slope;
    if (slope > 0.0) {
      range.x = max(range.x, crossing);
    } else {
      range.y = min(range.y, crossing);
    }
  }
  return range;
}

// How much of a sample's slab is kept, in [0, 1].
float path_fraction(vec2 pixel, float s) {
  if (!has_flag(kIsClipped)) return 1.0;
  vec2 part = kept_part(pixel, s, vec2(-0.5, 0.5));
  return max(part.y - part.x, 0.0);
}

// Whether the place s (between sheets) lies in all clip half spaces.
bool is_kept_by_planes(vec2 pixel, float s) {
  for (uint i = 0u; i < frame.view.num_clips; ++i) {
    float slope = at_pixel(frame.view.clips[i].per_sheet, pixel);
    if (fma(s, slope, at_pixel(frame.view.clips[i].at_first, pixel)) < 0.0) return false;
  }
  return true;
}

// How far the place s lies behind the nearest cut face, smallest spacings; negative before it. Only
// where light fades at cuts.
float clearance_at(vec2 pixel, float s) {
  if (!has_flag(kFadesAtCuts)) return 1.0;
  float least = 1e30;
  for (uint i = 0u; i < frame.view.num_cut_faces; ++i) {
    float slope = at_pixel(frame.view.clips[i].per_sheet, pixel);
    least = min(least, fma(s, slope, at_pixel(frame.view.clips[i].at_first, pixel)));
  }
  return least * frame.view.clearance_per_length;
}

// The reciprocal basis of (pixel right, pixel down, next sheet): pixels are square and orthogonal
// to the view axis, the step to the next sheet leans by the ray's slopes. `differences` are of
// samples `apart` pixels from each other.
vec3 gradient_of_differences(vec3 differences, vec2 pixel, float s, float apart) {
  float inverse_pitch =
      1.0 / ((frame.view.gradient_pitch + s * frame.view.gradient_pitch_per_sheet) * apart);
  float along_right = differences.x * inverse_pitch;
  float along_up = -differences.y * inverse_pitch;
  float along_axis = differences.z / frame.view.gradient_step;
  if (!has_flag(kIsParallel)) {
    along_axis -= at_pixel(frame.view.slope_right, pixel) * along_right;
    along_axis -= at_pixel(frame.view.slope_up, pixel) * along_up;
  }
  return along_right * frame.view.right.xyz + along_up * frame.view.up.xyz +
         along_axis * frame.view.axis.xyz;
}

// Difference of the samples on both sides of the middle one; one-sided, or zero, where they are
// undefined.
float difference(float before, float middle, float after, bool has_before, bool has_after) {
  if (has_before && has_after) return 0.5 * ((after - middle) + (middle - before));
  if (has_after) return after - middle;
  return has_before ? middle - before : 0.0;
}
