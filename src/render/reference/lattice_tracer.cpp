// SPDX-License-Identifier: Apache-2.0
#include "render/reference/lattice_tracer.h"

namespace ovoid::reference {

LatticeTracer::LatticeTracer(const LatticeField& field, const FieldEvaluator& evaluator,
                             const Camera& camera, const Look& look, const RenderOptions& options)
    : PixelTracer(field, ViewRays(field, camera, options), look, options),
      evaluator_(evaluator),
      slab_(options.slab),
      gradient_method_(options.gradient),
      index_from_world_(field.geometry().world_from_index.inverse()),
      support_(evaluator.support_bounds(view().greatest_widening())) {}

SheetRange LatticeTracer::sheets_of(const Ray& ray) const {
  return view().sheets_within(ray, support_);
}

// The sample of a sheet, if there is one.
std::optional<LatticeTracer::RaySample> LatticeTracer::sample(const PixelRay& pixel,
                                                              std::int64_t sheet,
                                                              TraceCounts& counts) const {
  if (!view().exists(sheet)) return std::nullopt;
  const double path = view().path(pixel.ray, sheet);
  if (!(path > 0)) return std::nullopt;
  ++counts.samples;
  const FieldSample at = field_at(pixel.x, pixel.y, sheet);
  if (!at.is_defined) return std::nullopt;
  return RaySample{sheet, view().z_of(sheet), path, at.value, at.value, at.gradient};
}

// The field on the sample (x, y, sheet) of the view lattice.
FieldSample LatticeTracer::field_at(int x, int y, std::int64_t sheet) const {
  return field_on_ray(view().ray(x, y), view().z_of(sheet), view().widening(sheet));
}

// The field where a ray meets the plane at z, or its mean over the slab around that plane.
FieldSample LatticeTracer::field_on_ray(const Ray& ray, double z, const Vec3& widening) const {
  if (slab_ != Slab::kMean) return evaluator_.at_index(index_from_world_ * ray.at(z), widening);
  const double half_slab = 0.5 * view().sampling_distance();
  return evaluator_.mean_over(index_from_world_ * ray.at(z - half_slab),
                              index_from_world_ * ray.at(z + half_slab), widening);
}

Vec3 LatticeTracer::gradient(const PixelRay& pixel, const RaySample& sample) const {
  if (gradient_method_ == GradientMethod::kCentral) return central_gradient(pixel, sample);
  return own_gradient(sample.exact_gradient, pixel.ray.at(sample.z), view().widening(sample.sheet));
}

// Half-way between two sheets; central differences are the second one's.
Vec3 LatticeTracer::piece_gradient(const PixelRay& pixel, const RaySample& from,
                                   const RaySample& to) const {
  if (gradient_method_ == GradientMethod::kCentral) return central_gradient(pixel, to);
  const double z = 0.5 * (from.z + to.z);
  const Vec3 widening = view().widening(to.sheet);
  const FieldSample middle = field_on_ray(pixel.ray, z, widening);
  return own_gradient(middle.gradient, pixel.ray.at(z), widening);
}

// The kernels' own gradient at a place, corrected if so asked.
Vec3 LatticeTracer::own_gradient(const Vec3& exact, const Vec3& position,
                                 const Vec3& widening) const {
  if (gradient_method_ == GradientMethod::kExact) return exact;
  return evaluator_.corrected_gradient(exact, index_from_world_ * position, widening);
}

Vec3 LatticeTracer::central_gradient(const PixelRay& pixel, const RaySample& sample) const {
  const auto difference = [&](int dx, int dy, int dk) -> double {
    const FieldSample before = field_at(pixel.x - dx, pixel.y - dy, sample.sheet - dk);
    const FieldSample behind = field_at(pixel.x + dx, pixel.y + dy, sample.sheet + dk);
    if (before.is_defined && behind.is_defined) return 0.5 * (behind.value - before.value);
    if (before.is_defined) return sample.value - before.value;
    if (behind.is_defined) return behind.value - sample.value;
    return 0;
  };
  const Vec3 differences(difference(1, 0, 0), difference(0, 1, 0), difference(0, 0, 1));
  return view().position_derivatives(pixel.ray, sample.sheet).transpose().inverse() * differences;
}

PixelTracer::Crossing LatticeTracer::crossing(const PixelRay& pixel, const RaySample& near,
                                              const RaySample& far) const {
  Crossing at{refined_crossing(pixel, near, far), look().isovalue, Vec3::Zero()};
  if (!look().shade) return at;
  const Vec3 widening = view().widening(far.sheet);
  const FieldSample there = field_on_ray(pixel.ray, at.z, widening);
  at.gradient = own_gradient(there.gradient, pixel.ray.at(at.z), widening);
  return at;
}

// Where between two neighbouring sheets the field on the ray meets the isovalue: docs/numerics.md,
// "Modes".
double LatticeTracer::refined_crossing(const PixelRay& pixel, const RaySample& near,
                                       const RaySample& far) const {
  constexpr int kNumBisections = 8;
  const double iso = look().isovalue;
  const Vec3 widening = view().widening(far.sheet);
  double z_near = near.z;
  double z_far = far.z;
  double f_near = near.value;
  double f_far = far.value;
  bool far_is_defined = true;
  for (int step = 0; step < kNumBisections; ++step) {
    const double z_middle = 0.5 * (z_near + z_far);
    const FieldSample middle = field_on_ray(pixel.ray, z_middle, widening);
    if (middle.is_defined && (middle.value < iso) == (near.value < iso)) {
      z_near = z_middle;
      f_near = middle.value;
    } else {
      z_far = z_middle;
      f_far = middle.value;
      far_is_defined = middle.is_defined;
    }
  }
  if (!far_is_defined) return z_near;
  return z_near + (iso - f_near) / (f_far - f_near) * (z_far - z_near);
}

}  // namespace ovoid::reference
