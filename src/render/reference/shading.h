// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/look.h"
#include "ovoid/math.h"
#include "view/light_volume.h"

namespace ovoid::reference {

// What "Classification" and "Light" of docs/numerics.md need beside the look.
struct ShadingContext {
  double unit_distance;  // world length of the opacities
  double least_spacing;  // h_min, world units
  double flat_rise;      // over h_min, in values, below which the field counts as flat
};

// q: 0 where the field is flat, 1 where its gradient tells a direction.
double flatness(const Vec3& gradient, const ShadingContext& context);

struct ClassifiedSample {
  Rgb color;
  double opacity;  // over a unit distance
};

// The piece of a ray along which the value goes straight from `from` to `to`, which differ:
// docs/numerics.md, "Classification", pre-integrated.
ClassifiedSample classified_piece(const TransferFunction& tf, double from, double to);

// The gradient's direction; zero stays zero.
Vec3 normal_of(const Vec3& gradient);

// The opacity of a path through material of opacity `opacity` per unit distance.
double opacity_over(double opacity, double path, double unit_distance);

// The colour C under the light. `gradient` in world units; `to_eye` points from the sample to the
// eye, unit length.
Rgb shaded(const Rgb& color, const Vec3& gradient, const Vec3& to_eye, const Look& look,
           const ShadingContext& context, const view::ArrivingLight& arriving = {});

// The light that arrives at a sample at `position` with that gradient.
view::ArrivingLight arriving_light(const view::LightVolume& volume, const Vec3& position,
                                   const Vec3& gradient, const Vec3& to_eye,
                                   const ShadingContext& context);

}  // namespace ovoid::reference
