// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/look.h"
#include "ovoid/math.h"
#include "view/plan/light_volume.h"

namespace ovoid::reference {

// What "Classification" and "Light" of docs/numerics.md need beside the look.
struct ShadingContext {
  double unit_distance;  // world length of the opacities
  double least_spacing;  // h_min, world units
  double flat_rise;      // over h_min, in values, below which the field counts as flat
};

// q: 0 where the field is flat, 1 where its gradient tells a direction; without cut faces.
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

// What a sample's light depends on.
struct LitPlace {
  Vec3 gradient;         // world units
  Vec3 to_eye;           // from the sample, unit length
  double clearance = 1;  // from cut faces, smallest spacings, of any size and sign
};

// The colour C under the light.
Rgb shaded(const Rgb& color, const LitPlace& place, const Look& look, const ShadingContext& context,
           const view::ArrivingLight& arriving = {});

// The light that arrives at a sample at `position`.
view::ArrivingLight arriving_light(const view::LightVolume& volume, const Vec3& position,
                                   const LitPlace& place, const ShadingContext& context);

}  // namespace ovoid::reference
