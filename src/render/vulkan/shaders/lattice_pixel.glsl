// SPDX-License-Identifier: Apache-2.0
// A lattice's pixel: its ray, gradients, surfaces between sheets, and what can be stepped over.

// The ray of a place in the picture, in index space: position on sheet 0, change per sheet.
struct Ray {
  Exact start;
  Exact step;
};

Ray ray_at(int field, vec2 pixel) {
  LatticeConstants lattice = frame.fields[field];
  Ray ray;
  ray.start.hi = lattice.place_hi[0].xyz;
  ray.start.lo = lattice.place_lo[0].xyz;
  ray.step.hi = lattice.step_hi[0].xyz;
  ray.step.lo = lattice.step_lo[0].xyz;
  ray.start = add_product(ray.start, lattice.place_hi[1].xyz, lattice.place_lo[1].xyz, pixel.x);
  ray.start = add_product(ray.start, lattice.place_hi[2].xyz, lattice.place_lo[2].xyz, pixel.y);
  if (!has_flag(kIsParallel)) {
    ray.step = add_product(ray.step, lattice.step_hi[1].xyz, lattice.step_lo[1].xyz, pixel.x);
    ray.step = add_product(ray.step, lattice.step_hi[2].xyz, lattice.step_lo[2].xyz, pixel.y);
  }
  return ray;
}

Place place_on(Ray ray, float s) {
  return place_from(add_product(ray.start, ray.step.hi, ray.step.lo, s));
}

bool is_in_support(int field, Place place) {
  vec3 at = vec3(place.cell) + place.fraction;
  return all(greaterThanEqual(at, frame.fields[field].support_lo.xyz)) &&
         all(lessThanEqual(at, frame.fields[field].support_hi.xyz));
}

// The field at a sample beside the one in hand, undefined outside its support.
Gathered gather_beside(int field, vec2 pixel, float s) {
  Ray ray = ray_at(field, pixel);
  Place place = place_on(ray, s);
  Gathered result;
  result.value = 0.0;
  result.is_defined = false;
  if (!is_in_support(field, place)) return result;
  return gather(field, place, s, ray.step.hi, false);
}

// The samples to the left, right, above, below, in front and behind, which are worked out in a
// loop: the code of a sum is long.
struct Neighbours {
  vec3 before, after;  // along x, y and the sheets
  bvec3 has_before, has_after;
};
const int kNumNeighbours = 6;
const Neighbours kNoNeighbours =
    Neighbours(vec3(0.0), vec3(0.0), bvec3(false), bvec3(false));

vec3 way_to_neighbour(int number) {
  vec3 along = vec3(equal(ivec3(number >> 1), ivec3(0, 1, 2)));
  return (number & 1) == 0 ? -along : along;
}

void take_neighbour(inout Neighbours around, int number, Gathered f) {
  if (!f.is_defined) return;
  bvec3 along = equal(ivec3(number >> 1), ivec3(0, 1, 2));
  if ((number & 1) == 0) {
    around.before = mix(around.before, vec3(f.value), along);
    around.has_before = bvec3(uvec3(around.has_before) | uvec3(along));
  } else {
    around.after = mix(around.after, vec3(f.value), along);
    around.has_after = bvec3(uvec3(around.has_after) | uvec3(along));
  }
}

vec3 differences_of(Neighbours around, float value) {
  vec3 differences;
  for (int a = 0; a < 3; ++a)
    differences[a] = difference(around.before[a], value, around.after[a], around.has_before[a],
                                around.has_after[a]);
  return differences;
}

// World gradient by differences of the samples around; `apart` pixels.
vec3 central_gradient(vec2 pixel, float s, float value, float apart) {
  Neighbours around = kNoNeighbours;
  for (int i = 0; i < kNumNeighbours; ++i) {
    vec3 way = way_to_neighbour(i);
    take_neighbour(around, i, gather_beside(0, pixel + way.xy * apart, s + way.z));
  }
  return gradient_of_differences(differences_of(around, value), pixel, s, apart);
}

Place between(Place from, vec3 way, float t) { return moved(from, t * way); }

// The sample in hand.
Ray own_ray;
Place own_place;
bool has_own_gradient = false;  // from nodes, or of a piece's end that was worked out before
vec3 own_gradient;
// The one on the sheet before, of refined pieces.
bool has_front_gradient = false;
vec3 front_gradient;

vec3 gradient_of_sample(vec2 at, float s, float value, bool has_before) {
  if (has_flag(kTakesDifferences))
    return has_own_gradient ? own_gradient : central_gradient(at, s, value, 1.0);
  if (has_before) {
    Place middle = moved(own_place, -0.5 * own_ray.step.hi);
    return to_world(0, gather(0, middle, s, own_ray.step.hi, true).gradient);
  }
  if (has_own_gradient) return own_gradient;
  return to_world(0, gather(0, own_place, s, own_ray.step.hi, true).gradient);
}

vec3 gradient_of_end(vec2 at, float s, float value, bool is_front) {
  if (is_front && has_front_gradient) return front_gradient;
  if (!is_front && has_own_gradient) return own_gradient;
  vec3 gradient;
  if (has_flag(kTakesDifferences)) {
    gradient = central_gradient(at, s, value, 1.0);
  } else {
    gradient = to_world(0, gather(0, place_on(own_ray, s), s, own_ray.step.hi, true).gradient);
  }
  if (!is_front) {
    own_gradient = gradient;
    has_own_gradient = true;
  }
  return gradient;
}

// The part of a piece that has a field: where a normalized one ends at a face, as far as that.
vec2 part_with_field(Piece piece, float s) {
  vec2 part = part_by_ends(piece);
  if ((piece.has_front && piece.has_back) || field_has(0, kIsSum)) return part;
  Place front = place_on(own_ray, s - 1.0);
  vec3 step = own_ray.step.hi;
  vec3 lo = (frame.fields[0].faces_lo.xyz - vec3(front.cell)) - front.fraction;
  vec3 hi = (frame.fields[0].faces_hi.xyz - vec3(front.cell)) - front.fraction;
  vec3 undefined_end = piece.has_front ? step : vec3(0.0);
  if (all(greaterThanEqual(undefined_end, lo)) && all(lessThanEqual(undefined_end, hi)))
    return part;
  part = vec2(0.0, 1.0);
  for (int a = 0; a < 3; ++a) {
    if (abs(step[a]) < 1e-12) {
      if (lo[a] > 0.0 || hi[a] < 0.0) return vec2(0.0);
      continue;
    }
    float at_lo = lo[a] / step[a];
    float at_hi = hi[a] / step[a];
    part.x = max(part.x, min(at_lo, at_hi));
    part.y = min(part.y, max(at_lo, at_hi));
  }
  return part;
}

// Refined: what the field is on sheet s is known, and the piece that ends there is drawn. The
// gradients that are known of its ends have been set.
void take_end(inout Pixel pixel, vec2 at, float s, bool is_defined, float value) {
  Piece piece;
  piece.has_front = has_before(pixel, s);
  piece.has_back = is_defined;
  if (piece.has_front || piece.has_back) {
    piece.front = piece.front_color = piece.has_front ? pixel.before : value;
    piece.back = piece.back_color = is_defined ? value : pixel.before;
    draw_piece(pixel, at, s, piece, part_with_field(piece, s));
  }
  if (!is_defined) return;
  pixel.before = value;
  pixel.before_sheet = int(s);
}

// Where between sheets s - 1 and s the field takes the isovalue, which its ends lie on both sides
// of: bisections, then a secant. Where it is undefined, the crossing is in front.
float crossing_of(Place from, vec3 way, float s, vec3 step, float before, float after) {
  float iso = frame.looks[0].isovalue;
  bool rises = before < iso;
  float near = 0.0, far = 1.0;
  bool far_is_defined = true;
  for (int i = 0; i < kSurfaceSteps; ++i) {
    float middle = 0.5 * (near + far);
    Gathered f = gather(0, between(from, way, middle), s, step, false);
    if (f.is_defined && (f.value < iso) == rises) {
      near = middle;
      before = f.value;
    } else {
      far = middle;
      after = f.value;
      far_is_defined = f.is_defined;
    }
  }
  if (!far_is_defined) return near;
  float rise = after - before;
  return fma(far - near, clamp((iso - before) / (rise == 0.0 ? 1.0 : rise), 0.0, 1.0), near);
}

void draw_surface(inout Pixel pixel, vec2 at, float s, float value) {
  LookConstants look = frame.looks[0];
  if (!has_before(pixel, s)) return;
  if ((pixel.before < look.isovalue) == (value < look.isovalue)) return;
  if (pixel.is_closed) return;
  vec3 step = own_ray.step.hi;
  Place from = place_on(own_ray, s - 1.0);
  vec3 way = vec3(own_place.cell - from.cell) + (own_place.fraction - from.fraction);
  float t = crossing_of(from, way, s, step, pixel.before, value);
  float sheet = s - 1.0 + t;
  if (!is_kept_by_planes(at, sheet) || !is_within_span(pixel, depth_of_sheet(sheet))) return;
  ++num_samples.y;
  vec3 color = clamp(look.isosurface_color.rgb, 0.0, 1.0);
  if (has_flag(kShades)) {
    ++num_samples.z;
    vec3 gradient = to_world(0, gather(0, between(from, way, t), s, step, true).gradient);
    vec3 eye = to_eye(at);
    color = lit(look, look.isosurface_color.rgb, gradient, eye,
                arriving_light(look, at, sheet, gradient, eye), 1.0);
  } else {
    color = dimmed(color, arriving_light(look, at, sheet, vec3(0.0), to_eye(at)));
  }
  composite_surface(pixel, color, depth_of_sheet(sheet));
}

// Sheet s of the field has a value here. One without a path is only the end of a piece.
void take_value(inout Pixel pixel, vec2 at, float s, float path, float value) {
  if (!(path > 0.0)) {
    // Nothing is drawn.
  } else if (kMode == kComposite) {
    bool is_piece = has_flag(kIsPreintegrated) && has_before(pixel, s);
    draw_sample(pixel, at, s, path, value, is_piece, pixel.before);
  } else if (kMode == kIsosurface) {
    draw_surface(pixel, at, s, value);
  } else {
    accumulate(pixel, value, path * ray_length(at) * frame.view.sampling_distance,
               depth_of_sheet(s));
  }
  pixel.before = value;
  pixel.before_sheet = int(s);
}

// Sheet s of the trail: classified, not lit.
void take_trail(inout Pixel pixel, vec2 at, Ray ray, Place place, float s, float path) {
  Gathered f = gather(1, place, s, ray.step.hi, false);
  ++num_samples.x;
  if (!f.is_defined) return;
  vec4 color = classify(frame.looks[1].look, f.value);
  if (!(color.a > 0.0)) return;
  ++num_samples.y;
  if (!has_flag(kIsParallel) || has_flag(kIsClipped))
    color.a = correct_opacity(color.a, path * ray_length(at));
  composite(pixel, color.rgb, color.a, depth_of_sheet(s));
}

// How many sheets from s on cannot show (0: this one can), by the distance to the nearest brick
// that can.
int sheets_to_skip(int field, Ray ray, float s) {
  vec3 at = fma(ray.step.hi, vec3(s), ray.start.hi);
  uint distance = brick_byte(field, at) & kDistanceBits;
  if (distance == 0u) return 0;
  float room = float((int(distance) - 1) << frame.fields[field].num_bricks.w) - 0.05;
  vec3 step = abs(ray.step.hi);
  return 1 + int(clamp(room / max(max(step.x, step.y), step.z), 0.0, 1e6));
}

// Sheets [x, y) whose samples can lie in the box and where a field can be defined, some more
// rather than fewer.
ivec2 sheets_in_box(Ray ray) {
  vec3 lo = frame.fields[0].support_lo.xyz;
  vec3 hi = frame.fields[0].support_hi.xyz;
  if (has_flag(kHasTrail)) {
    lo = min(lo, frame.fields[1].support_lo.xyz);
    hi = max(hi, frame.fields[1].support_hi.xyz);
  }
  lo = max(lo, vec3(box.own_lo.xyz)) - 0.01;
  hi = min(hi, vec3(box.own_hi.xyz)) + 0.01;
  float first = float(box.first_sheet);
  float last = float(box.end_sheet - 1);
  for (int a = 0; a < 3; ++a) {
    float step = ray.step.hi[a];
    float start = ray.start.hi[a];
    if (abs(step) < 1e-12) {
      if (start < lo[a] || start > hi[a]) return ivec2(0);
      continue;
    }
    float at_lo = (lo[a] - start) / step;
    float at_hi = (hi[a] - start) / step;
    first = max(first, min(at_lo, at_hi) - 1e-3 * abs(at_lo) - 1.0);
    last = min(last, max(at_lo, at_hi) + 1e-3 * abs(at_hi) + 1.0);
  }
  if (!(first <= last)) return ivec2(0);
  return ivec2(int(ceil(first)), int(floor(last)) + 1);
}

bool is_own(Place place) {
  return all(greaterThanEqual(place.cell, box.own_lo.xyz)) &&
         all(lessThan(place.cell, box.own_hi.xyz));
}
