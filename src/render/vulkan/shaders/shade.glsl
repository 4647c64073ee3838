// SPDX-License-Identifier: Apache-2.0
// Stage "shade": Blinn-Phong in VTK's words, two-sided; flat regions fade to ambient and diffuse.

vec3 lit(LookConstants look, vec3 color, vec3 gradient, vec3 eye) {
  float squared = max(dot(gradient, gradient), 1e-36);
  float inverse = inversesqrt(squared);
  vec3 normal = gradient * inverse;
  float flatness = min(squared * inverse * look.flat_gradient_inverse, 1.0);
  float towards_eye = dot(normal, eye);
  float diffuse = abs(towards_eye);
  float specular = diffuse;
  if (look.light_kind != kHeadlight) {
    vec3 light = look.light.xyz;
    float towards_light = dot(normal, light);
    vec3 middle = light + eye;
    float cosine = abs(dot(normal, middle)) / max(length(middle), 1e-6);
    if (look.light_kind == kSingleLight) {
      diffuse = abs(towards_light);
      specular = towards_light * towards_eye >= 0.0 ? cosine : 0.0;
    } else {
      if (towards_eye < 0.0) towards_light = -towards_light;  // of the side that is seen
      float key = max((towards_light + kKeyWrap) / (1.0 + kKeyWrap), 0.0);
      diffuse = kKeyShare * key + (1.0 - kKeyShare) * 0.5 * (1.0 + diffuse);
      specular = towards_light > 0.0 ? cosine : 0.0;
    }
  }
  float factor = look.ambient + look.diffuse * fma(flatness, diffuse - 1.0, 1.0);
  float highlight = 0.0;
  if (look.specular > 0.0) {
    float shine = exp2(max(log2(max(min(specular, 1.0), 1e-30)) * look.specular_power, -126.0));
    highlight = flatness * look.specular * shine;
  }
  return clamp(fma(color, vec3(factor), vec3(highlight)), 0.0, 1.0);
}
