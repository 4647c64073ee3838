// SPDX-License-Identifier: Apache-2.0
// The cut of a splat with a sheet, or its slab's mean, in samples of a level.
#include "render/shared/moment_formulas.h"

// An ellipse, and how high the kernel stands over it. With u, the squared distance that is left to
// the ellipse's edge, the kernel is scale * profile(cutoff^2 - u); a Gaussian, less its tangent
// where it ends,
//
//   exp(-q / 2) - exp(-r / 2) (1 + (r - q) / 2) = exp(-r / 2) (2^u - 1 - u ln 2),
//
// q being the squared distance from the middle, r the edge's, and u = (r - q) log2(e) / 2: its
// squared distances are counted in those units, and its scale has the factor before the bracket.
struct Section {
  vec2 center;
  vec3 shape;  // axx, 2 axy, ayy, per sample^2
  float room;  // of squared distance, in the middle; none: the sheet is not met
  float scale;
};
const Section kNoSection = Section(vec2(0.0), vec3(0.0), -1.0, 0.0);
const float kHalfLog2E = 0.72134752;
const float kLn2 = 0.69314718;
// Farther out than 12.9 sigmas a Gaussian is less than the smallest float.
const float kMostGaussianReach = 166.4;

// What is left of a Section's room at a sample; none or less: it is not reached.
float room_at(Section section, vec2 at) {
  vec2 d = at - section.center;
  float across = fma(section.shape.y, d.y, section.shape.x * d.x);
  return fma(-d.x, across, fma(-d.y * d.y, section.shape.z, section.room));
}

Section gaussian_section(vec2 center, vec3 shape, float room, float amplitude) {
  return Section(center, shape * vec3(kHalfLog2E, 2.0 * kHalfLog2E, kHalfLog2E),
                 room * kHalfLog2E, amplitude * exp(-0.5 * room));
}

Section middle_section(DeviceSplat splat, float t, float factor, vec2 offset) {
  float along = t * t * splat.shape.w;
  vec2 center = offset + factor * (splat.center.xy + splat.slide.xy * t);
  vec3 shape = splat.shape.xyz / (factor * factor);
  float reach = frame.cutoff * frame.cutoff;
  if (kProfile == kProfileGaussian)
    return gaussian_section(center, shape, min(reach, kMostGaussianReach) - along,
                            exp(-0.5 * along));
  return Section(center, shape * vec3(1.0, 2.0, 1.0), reach - along, 1.0);
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
  return gaussian_section(offset + factor * (at + m * (mean - t)),
                          vec3(cyy, -cxy, cxx) * per_sample,
                          slab_room(from, to, moments,
                                    min(frame.cutoff * frame.cutoff, kMostGaussianReach)),
                          moments.weight * sigma / sqrt(det * det3));
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

// The kernel where so much room is left.
float section_at(Section section, float room) {
  if (kProfile == kProfileGaussian)
    return section.scale * max(exp2(room) - fma(kLn2, room, 1.0), 0.0);
  return section.scale * profile_at(frame.cutoff * frame.cutoff - room);
}
