// SPDX-License-Identifier: Apache-2.0
// What every kind of field does with a sample of a picture of colours: classify, light, composite.

// How many samples were worked out, showed something, had their gradient taken.
uvec4 num_samples = uvec4(0u);

// World gradient of the sample in hand, or of the middle of its piece: the including shader's.
vec3 gradient_of_sample(vec2 at, float s, float value, bool has_before);

// Its colour, where another attribute gives it.
vec3 own_color(vec2 at, float s);

// What was classified is faded, lit and composited: opacity over a unit distance if the frame
// corrects late, else over one sheet's. `length`: of the path, in sheets. `arriving`: of the light.
// `clearance`: from cut faces.
void draw_seen(inout Pixel pixel, vec2 at, float s, float length, vec4 seen, vec3 gradient,
               vec2 arriving, float clearance) {
  LookConstants look = frame.looks[0];
  float opacity = seen.a;
  if (has_flag(kFades)) opacity *= classify(look.fading, sqrt(dot(gradient, gradient))).a;
  if (has_flag(kIsPreintegrated | kIsRefined | kFades)) {
    if (!(opacity > 0.0)) return;
    opacity = correct_opacity(opacity, length * look.path_in_units);
  } else if (!has_flag(kIsParallel) || has_flag(kIsClipped)) {
    opacity = correct_opacity(opacity, length);
  }
  vec3 color = has_flag(kShades)
                   ? lit(look, seen.rgb, gradient, to_eye(at), arriving, clearance)
                   : dimmed(seen.rgb, arriving);
  composite(pixel, color, opacity, depth_of_sheet(s));
}

void draw_sample(inout Pixel pixel, vec2 at, float s, float path, float value, bool has_before,
                 float before) {
  LookConstants look = frame.looks[0];
  if (!has_before) before = value;
  if (max(value, before) < look.look.visible_lo || min(value, before) > look.look.visible_hi)
    return;
  vec4 color =
      has_flag(kIsPreintegrated) ? classify_from(look, before, value) : classify(look.look, value);
  if (!(color.a > 0.0)) return;
  ++num_samples.y;
  if (has_flag(kHasOwnColor)) color.rgb = own_color(at, s);
  vec3 gradient = vec3(0.0);
  if (has_flag(kTakesGradients)) {
    ++num_samples.z;
    gradient = gradient_of_sample(at, s, value, has_before);
  }
  vec3 slope = has_flag(kShades) ? gradient : vec3(0.0);  // what is not lit has no normal
  vec2 arriving = arriving_light(look, at, s, slope, to_eye(at));
  draw_seen(pixel, at, s, path * ray_length(at), color, gradient, arriving, clearance_at(at, s));
}
