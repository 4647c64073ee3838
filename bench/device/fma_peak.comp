#version 450
// SPDX-License-Identifier: Apache-2.0
// Eight independent chains of fused multiply-adds a thread, on registers alone. The factor is below
// 1, so that they converge; what they come to is written, so that they are not left out.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint kSteps = 1024u;
layout(std430, binding = 0) writeonly buffer Out { float sums[]; };

void main() {
  float seed = float(gl_LocalInvocationIndex) * 1e-3;
  vec4 a = vec4(seed, seed + 0.1, seed + 0.2, seed + 0.3);
  vec4 b = a + 0.5;
  for (uint step = 0u; step < kSteps; ++step) {
    a = fma(a, vec4(0.999), vec4(0.001));
    b = fma(b, vec4(0.998), vec4(0.002));
  }
  vec4 sum = a + b;
  sums[gl_GlobalInvocationID.x & 4095u] = sum.x + sum.y + sum.z + sum.w;
}
