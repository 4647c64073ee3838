// SPDX-License-Identifier: Apache-2.0
// Refined pieces (docs/numerics.md, "Classification"): what lies between two sheets is classified,
// lit and composited in steps, along which value and gradient go straight.

// The piece that ends at a sheet. An end where the field is undefined has the other one's value.
struct Piece {
  bool has_front;
  bool has_back;
  float front;
  float back;
  float front_color;  // what the colour is taken at
  float back_color;
};

// World gradient at an end where the field is defined, on sheet s: the including shader's.
vec3 gradient_of_end(vec2 at, float s, float value, bool is_front);

// Where it has a field if what ends it is not known better: next to the ends that there are.
vec2 part_by_ends(Piece piece) {
  return vec2(piece.has_front ? 0.0 : 0.5, piece.has_back ? 1.0 : 0.5);
}

float variation_to(LookConstants look, float value) {
  TablePlace place = find_place(look.look, value);
  uint at = look.variation_at + place.entry;
  float lo = tables[at >> 2][at & 3u];
  ++at;
  return fma(tables[at >> 2][at & 3u] - lo, place.fraction, lo);
}

// Shorter where the field is flat, 0 where there is no gradient. Scaled first: gradients may be too
// small to be squared.
vec3 seen_normal(LookConstants look, vec3 gradient) {
  vec3 size = abs(gradient);
  float greatest = max(max(size.x, size.y), size.z);
  if (!(greatest > 0.0)) return vec3(0.0);
  vec3 scaled = gradient / greatest;
  float inverse_length = inversesqrt(dot(scaled, scaled));
  return scaled * min(inverse_length, greatest * look.flat_gradient_inverse);
}

int steps_for(float need) {
  int steps = 1;
  while (float(steps) < need && steps < kMostSteps) steps *= 2;
  return steps;
}

// What the ends of a piece say of all of it.
struct PieceEnds {
  vec3 front;  // gradients
  vec3 back;
  vec2 front_light;  // as arriving_light()
  vec2 back_light;
  vec2 clearance;  // from cut faces, at either end
  int steps;
};

// `change`: of the look's variation on the way.
PieceEnds ends_of(vec2 at, float s, Piece piece, float change) {
  LookConstants look = frame.looks[0];
  PieceEnds ends = PieceEnds(vec3(0.0), vec3(0.0), kAllLight, kAllLight, vec2(1.0), 1);
  float need = kStepsPerVariation * change;
  if (has_flag(kTakesGradients)) {
    num_samples.z += 2u;
    // A loop, since the code of a lattice's gradient is long.
    for (int end = piece.has_front ? 0 : 1; end < (piece.has_back ? 2 : 1); ++end) {
      bool is_front = end == 0;
      vec3 gradient = gradient_of_end(at, is_front ? s - 1.0 : s,
                                      is_front ? piece.front : piece.back, is_front);
      if (is_front) ends.front = gradient;
      else ends.back = gradient;
    }
    if (!piece.has_front) ends.front = ends.back;
    if (!piece.has_back) ends.back = ends.front;
    need += length(seen_normal(look, ends.back) - seen_normal(look, ends.front));
  }
  if (has_flag(kHasLightVolume)) {
    vec3 eye = to_eye(at);
    vec3 front = has_flag(kShades) ? ends.front : vec3(0.0);  // what is not lit has no normal
    vec3 back = has_flag(kShades) ? ends.back : vec3(0.0);
    ends.front_light = arriving_light(look, at, piece.has_front ? s - 1.0 : s, front, eye);
    ends.back_light = arriving_light(look, at, piece.has_back ? s : s - 1.0, back, eye);
  }
  if (has_flag(kFadesAtCuts))
    ends.clearance = vec2(clearance_at(at, s - 1.0), clearance_at(at, s));
  ends.steps = steps_for(need);
  return ends;
}

// A part of the piece before sheet s, 0 being the sheet before it, in steps.
void draw_part(inout Pixel pixel, vec2 at, float s, Piece piece, PieceEnds ends, vec2 part) {
  LookConstants look = frame.looks[0];
  float share = (part.y - part.x) / float(ends.steps);
  float path = share * ray_length(at);
  for (int m = 0; m < ends.steps && !pixel.is_closed; ++m) {
    float t = fma(float(m) + 0.5, share, part.x);
    vec4 color = classify(look.look, fma(piece.back - piece.front, t, piece.front));
    if (!(color.a > 0.0)) continue;
    ++num_samples.y;
    if (has_flag(kHasOwnColor))
      color.rgb =
          classify(look.color, fma(piece.back_color - piece.front_color, t, piece.front_color)).rgb;
    draw_seen(pixel, at, s - 1.0 + t, path, color, mix(ends.front, ends.back, t),
              mix(ends.front_light, ends.back_light, t),
              mix(ends.clearance.x, ends.clearance.y, t));
  }
}

// What the span in hand leaves of the part that has a field. Where pieces reach depth limits, one
// without an end has a field as far as a limit on that side, unless at a seam.
vec2 part_in_span(Pixel pixel, float s, vec2 has_field) {
  if (!has_flag(kHasLimits)) return has_field;
  if (!is_in_span(pixel)) return vec2(1.0, 0.0);
  float front = depth_of_sheet(s - 1.0);
  vec2 span = vec2(stops[pixel.next_stop - 1u].depth - front, next_depth(pixel) - front) /
              frame.view.sampling_distance;
  if (kPiecesReachLimits && span.x > 0.0 && !begins_at_seam(pixel)) has_field.x = 0.0;
  if (kPiecesReachLimits && span.y < 1.0 && !ends_at_seam(pixel)) has_field.y = 1.0;
  return vec2(max(has_field.x, span.x), min(has_field.y, span.y));
}

// A part of the piece as its values alone show it: of a maximum or minimum the end that is one.
void accumulate_part(inout Pixel pixel, vec2 at, float s, Piece piece, vec2 part) {
  vec2 ends = fma(vec2(piece.back - piece.front), part, vec2(piece.front));
  float place = part.x;
  float value = 0.5 * (ends.x + ends.y);
  if (kMode == kMaximum || kMode == kMinimum) {
    bool is_behind = kMode == kMaximum ? ends.y > ends.x : ends.y < ends.x;
    value = is_behind ? ends.y : ends.x;
    if (is_behind) place = part.y;
  }
  accumulate(pixel, value, (part.y - part.x) * ray_length(at) * frame.view.sampling_distance,
             depth_of_sheet(s - 1.0 + place));
}

// Whether a value between the ends has any opacity; `change`: of the look's variation on the way.
bool may_show_piece(LookConstants look, Piece piece, out float change) {
  change = 0.0;
  if (max(piece.front, piece.back) < look.look.visible_lo ||
      min(piece.front, piece.back) > look.look.visible_hi)
    return false;
  // Where the look does not change on the way, it shows nothing if it does not at the end.
  change = abs(variation_to(look, piece.back) - variation_to(look, piece.front));
  return change > 0.0 || classify(look.look, piece.back).a > 0.0;
}

// What depth limits and planes leave of the part of a piece that `has_field` names.
void draw_piece(inout Pixel pixel, vec2 at, float s, Piece piece, vec2 has_field) {
  LookConstants look = frame.looks[0];
  bool is_composite = kMode == kComposite;
  if (pixel.is_closed) return;
  float change = 0.0;
  if (is_composite && !may_show_piece(look, piece, change)) return;
  if (!meets_span(pixel, s)) return;
  PieceEnds ends;
  bool has_ends = false;
  bool has_more = false;  // spans
  do {
    vec2 part = kept_part(at, s - 1.0, part_in_span(pixel, s, has_field));
    if (part.x < part.y) {
      if (is_composite && !has_ends) ends = ends_of(at, s, piece, change);
      has_ends = true;
      if (is_composite) draw_part(pixel, at, s, piece, ends, part);
      else accumulate_part(pixel, at, s, piece, part);
    }
    has_more =
        has_flag(kHasLimits) && !pixel.is_closed && next_depth(pixel) < depth_of_sheet(s);
    if (has_more) join_next_stop(pixel);
  } while (has_more);
}
