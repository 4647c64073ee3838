// SPDX-License-Identifier: Apache-2.0
// Stage "shade": Blinn-Phong in VTK's words, two-sided; flat regions fade to ambient and diffuse.

// Shares of the light around and of the key that arrive at a sample.
const vec2 kAllLight = vec2(1.0);

vec2 light_of_cell(LookConstants look, int cell) {
  uint at = uint(look.volume.dims.w + cell);
  float packed = tables[at >> 2][at & 3u];
  float key = floor(packed * (1.0 / kLightRadix));
  return vec2(packed - key * kLightRadix, key);
}

// At a place in cell coordinates, straight between the middles of cells.
vec2 read_light(LookConstants look, vec3 place) {
  ivec3 dims = look.volume.dims.xyz;
  vec3 inside = clamp(place, vec3(0.0), vec3(dims - 1));
  ivec3 cell = min(ivec3(inside), dims - 2);
  vec3 t = inside - vec3(cell);
  int first = cell.x + dims.x * (cell.y + dims.y * cell.z);
  vec2 rows[4];
  for (int i = 0; i < 4; ++i) {
    int at = first + (i & 1) * dims.x + (i >> 1) * dims.x * dims.y;
    rows[i] = mix(light_of_cell(look, at), light_of_cell(look, at + 1), t.x);
  }
  vec2 steps = mix(mix(rows[0], rows[1], t.y), mix(rows[2], rows[3], t.y), t.z);
  return steps * (1.0 / kLightSteps);
}

// q of docs/numerics.md. `length`: the gradient's. `clearance`: from cut faces, of any size.
float flatness_of(LookConstants look, float length, float clearance) {
  float flatness = min(length * look.flat_gradient_inverse, 1.0);
  return has_flag(kFadesAtCuts) ? flatness * clamp(clearance, 0.0, 1.0) : flatness;
}

// At pixel `at` of sheet s, or between sheets; see view::light_shift().
vec2 arriving_light(LookConstants look, vec2 at, float s, vec3 gradient, vec3 eye) {
  if (!has_flag(kHasLightVolume)) return kAllLight;
  LightConstants light = look.volume;
  vec3 step = light.step[0].xyz + at.x * light.step[1].xyz + at.y * light.step[2].xyz;
  vec3 place =
      light.start[0].xyz + at.x * light.start[1].xyz + at.y * light.start[2].xyz + s * step;
  float squared = max(dot(gradient, gradient), 1e-36);
  float inverse = inversesqrt(squared);
  float flatness = flatness_of(look, squared * inverse, clearance_at(at, s));
  float share =
      flatness * clamp(kLightSteepness * dot(gradient, eye) * inverse, -1.0, 1.0);
  vec3 way = share * inverse * gradient + (1.0 - abs(share)) * eye;
  return read_light(look, place + vec3(dot(light.shift[0].xyz, way), dot(light.shift[1].xyz, way),
                                       dot(light.shift[2].xyz, way)));
}

// What is left of a colour that is not lit.
vec3 dimmed(vec3 color, vec2 arriving) {
  return has_flag(kHasLightVolume) ? color * (arriving.x * arriving.y) : color;
}

float shine_of(LookConstants look, float cosine) {
  return exp2(max(log2(max(min(cosine, 1.0), 1e-30)) * look.specular_power, -126.0));
}

// `arriving`: shares of the light around and of the key. `clearance`: as flatness_of() has it.
vec3 lit(LookConstants look, vec3 color, vec3 gradient, vec3 eye, vec2 arriving, float clearance) {
  float squared = max(dot(gradient, gradient), 1e-36);
  float inverse = inversesqrt(squared);
  vec3 normal = gradient * inverse;
  float flatness = flatness_of(look, squared * inverse, clearance);
  float towards_eye = dot(normal, eye);
  float diffuse = abs(towards_eye);
  float specular = diffuse;
  float bright = look.light_kind == kHeadlight ? arriving.x : arriving.y;
  float flat_light = bright;  // of the diffuse light, where the field is flat
  if (look.light_kind != kHeadlight) {
    vec3 light = look.light.xyz;
    float towards_light = dot(normal, light);
    vec3 middle = light + eye;
    float cosine = abs(dot(normal, middle)) / max(length(middle), 1e-6);
    if (look.light_kind == kSingleLight) {
      diffuse = abs(towards_light) * bright;
      specular = towards_light * towards_eye >= 0.0 ? cosine : 0.0;
    } else {
      if (towards_eye < 0.0) towards_light = -towards_light;  // of the side that is seen
      float key = max((towards_light + kKeyWrap) / (1.0 + kKeyWrap), 0.0);
      float from_key = kKeyShare * bright;
      float from_eye = (1.0 - kKeyShare) * arriving.x;
      diffuse = from_key * key + from_eye * 0.5 * (1.0 + diffuse);
      flat_light = from_key + from_eye;
      specular = towards_light > 0.0 ? cosine : 0.0;
    }
  } else {
    diffuse *= bright;
  }
  float highlight = 0.0;
  if (look.specular > 0.0) highlight = bright * flatness * look.specular * shine_of(look, specular);
  for (uint i = 0u; i < look.num_further_lights; ++i) {
    vec4 from = frame.looks[0].further_lights[i];  // of the copy it would need an array in memory
    vec3 light = from.xyz;
    float share = from.w * arriving.x;
    float towards_light = dot(normal, light);
    diffuse = fma(share, abs(towards_light), diffuse);
    flat_light = fma(share, kMeanCosine, flat_light);
    if (!(look.specular > 0.0) || towards_light * towards_eye < 0.0) continue;
    vec3 middle = light + eye;
    float cosine = abs(dot(normal, middle)) / max(length(middle), 1e-6);
    highlight = fma(share * flatness * look.specular, shine_of(look, cosine), highlight);
  }
  float factor = look.ambient * arriving.x +
                 look.diffuse * fma(flatness, diffuse - flat_light, flat_light);
  return clamp(fma(color, vec3(factor), vec3(highlight)), 0.0, 1.0);
}
