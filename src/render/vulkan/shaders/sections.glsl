// SPDX-License-Identifier: Apache-2.0
// The cut of a splat with a sheet, or its slab's mean, in samples of a level.
#include "render/shared/moment_formulas.h"

struct Section {
  vec2 center;
  vec3 shape;       // axx, axy, ayy, per sample^2
  float amplitude;  // Gaussian: with the part along s
  float tail_or_q_along;  // Gaussian: what amplitude * exp(-q / 2) falls to where the cut ends;
                          // others: the part of the squared distance along s
  float room;       // the cut ends where the rest of it exceeds this; none: it does not meet it
};

Section middle_section(DeviceSplat splat, float t, float factor, vec2 offset) {
  float along = t * t * splat.shape.w;
  float per_sample = 1.0 / (factor * factor);
  bool is_gaussian = kProfile == kProfileGaussian;
  Section section;
  section.center = offset + factor * (splat.center.xy + splat.slide.xy * t);
  section.shape = splat.shape.xyz * per_sample;
  section.amplitude = is_gaussian ? exp(-0.5 * along) : 1.0;
  section.tail_or_q_along = is_gaussian ? exp(-0.5 * frame.cutoff * frame.cutoff) : along;
  section.room = frame.cutoff * frame.cutoff - along;
  return section;
}

// As one Gaussian: the weight that lies in the slab, at the mean of its places, wider by their
// variance. `per_depth`: of a ray, lateral position over depth, per sheet.
Section mean_section(DeviceSplat splat, float t, float factor, vec2 offset, float per_depth) {
  float sigma = inversesqrt(splat.shape.w);
  float reach = splat.slide.z;
  float from = clamp(t - 0.5, -reach, reach) / sigma;
  float to = clamp(t + 0.5, -reach, reach) / sigma;
  SlabMoments moments = slab_moments_by_points(from, to);
  float mean = moments.mean * sigma;
  float variance = moments.variance * sigma * sigma;
  vec2 at = splat.center.xy + splat.slide.xy * t;
  vec2 m = splat.slide.xy - at * per_depth;
  float det = splat.shape.x * splat.shape.z - splat.shape.y * splat.shape.y;
  float cxx = splat.shape.z / det + variance * m.x * m.x;
  float cxy = -splat.shape.y / det + variance * m.x * m.y;
  float cyy = splat.shape.x / det + variance * m.y * m.y;
  float det3 = cxx * cyy - cxy * cxy;
  float per_sample = 1.0 / (factor * factor * det3);
  Section section;
  section.center = offset + factor * (at + m * (mean - t));
  section.shape = vec3(cyy, -cxy, cxx) * per_sample;
  section.amplitude = moments.weight * sigma / sqrt(det * det3);
  section.room = slab_room(from, to, moments, frame.cutoff * frame.cutoff);
  section.tail_or_q_along = section.amplitude * exp(-0.5 * section.room);
  return section;
}

// A profile other than the Gaussian at the squared Mahalanobis distance q.
float profile_at(float q) {
  float tt = min(q / (frame.cutoff * frame.cutoff), 1.0);
  if (kProfile == kProfileEpanechnikov) return 1.0 - tt;
  float t = sqrt(tt);
  float rest = 1.0 - t;
  if (kProfile == kProfileWendland) return rest * rest * rest * rest * fma(4.0, t, 1.0);
  return t < 0.5 ? 1.0 - 6.0 * tt * rest : 2.0 * rest * rest * rest;
}

// A section where the part of the squared distance in its plane is q. A Gaussian is less by its
// tangent where the cut ends.
float section_at(Section section, float q) {
  if (kProfile == kProfileGaussian)
    return max(fma(section.amplitude, exp2(q * -0.72134752),
                   -section.tail_or_q_along * (1.0 + 0.5 * (section.room - q))),
               0.0);
  return section.amplitude * profile_at(q + section.tail_or_q_along);
}
