// SPDX-License-Identifier: Apache-2.0
// Moments of a Gaussian over a slab, read as C++ and as GLSL.
#ifndef OVOID_RENDER_SHARED_MOMENT_FORMULAS_H_
#define OVOID_RENDER_SHARED_MOMENT_FORMULAS_H_

#ifdef __cplusplus
#pragma once
#endif

#include "render/shared/device_layout.h"

#ifdef __cplusplus
#include <algorithm>
#include <cmath>

namespace ovoid::device {

using std::exp;
using std::max;
#define OVOID_FORMULA inline
#else
#define OVOID_FORMULA
#endif

// Of exp(-x^2 / 2) over a <= x <= b: its integral, and the mean and variance of x under it.
struct SlabMoments {
  float weight;
  float mean;
  float variance;
};

// For slabs that are not wider than a few: by quadrature, which unlike differences of error
// functions loses no digits in floats, far from the middle or where the slab is thin. A test
// compares it with slab_moments(), which the cpu back end takes.
OVOID_FORMULA SlabMoments slab_moments_by_points(float a, float b) {
  float middle = 0.5f * (a + b);
  float width = b - a;
  float weight = 0.0f;
  float first = 0.0f;
  float second = 0.0f;
  for (int i = 0; i < kProfilePoints; ++i) {
    float at = kProfilePointOffsets[i] * width;
    float g = kProfilePointWeights[i] * exp(-0.5f * (middle + at) * (middle + at));
    weight += g;
    first += g * at;
    second += g * at * at;
  }
  SlabMoments moments;
  moments.weight = weight * width;
  moments.mean = middle;
  moments.variance = 0.0f;
  if (!(moments.weight > 1e-12f)) return moments;
  float mean = first / weight;
  moments.mean = middle + mean;
  moments.variance = max(second / weight - mean * mean, 0.0f);
  return moments;
}

// The m^2 in the plane at which a slab's mean section ends, so that section_at() has the slab's
// mass (docs/numerics.md, "Kernel sets"): the mean of x^2 from that of the whole, and one step of
// Newton's. `most`: the squared cut-off.
OVOID_FORMULA float slab_room(float a, float b, SlabMoments moments, float most) {
  float room = most - moments.mean * moments.mean - moments.variance;
  if (!(room > 1.0f) || !(moments.weight > 1e-12f)) return room;
  float at_end = moments.weight * exp(-0.5f * room);
  float ends = exp(-0.5f * most) * ((2.0f + most + 0.25f * most * most) * (b - a) -
                                    (1.0f + 0.5f * most) * (b * b * b - a * a * a) / 3.0f +
                                    (b * b * b * b * b - a * a * a * a * a) / 20.0f);
  float ours = at_end * (2.0f + room + 0.25f * room * room);
  return room + 8.0f * (ours - ends) / (at_end * room * room);
}

#ifdef __cplusplus
}  // namespace ovoid::device
#endif
#undef OVOID_FORMULA
#endif
