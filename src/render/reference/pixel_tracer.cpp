// SPDX-License-Identifier: Apache-2.0
// A ray's samples and what becomes of them. Each mode is one loop over the sheets in order of
// increasing k; a sheet has a sample where the field is defined and a part of the segment is left
// by the clip planes.
#include "render/reference/pixel_tracer.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ovoid::reference {
namespace {

double unit_distance_of(const Look& look, const LatticeField& field) {
  if (look.unit_distance > 0) return look.unit_distance;
  return look.transfer_function.unit_distance.value_or(default_unit_distance(field));
}

double span_of(const Look& look, const LatticeField& field) {
  if (look.mode == Mode::kIsosurface) {
    const ValueRange range = field.value_range();
    return range.is_empty() ? 0.0 : static_cast<double>(range.hi) - static_cast<double>(range.lo);
  }
  return look.transfer_function.hi() - look.transfer_function.lo();
}

// Opacity by the gradient's length, as a curve of its own.
TransferFunction fading_of(const Look& look) {
  TransferFunction fading;
  fading.opacities = look.transfer_function.gradient_opacities;
  return fading;
}

Pixel premultiplied(const Rgb& color, double alpha, double depth) {
  return {{alpha * color[0], alpha * color[1], alpha * color[2], alpha}, depth};
}

}  // namespace

PixelTracer::PixelTracer(const LatticeField& field, const FieldEvaluator& evaluator,
                         const Camera& camera, const Look& look, const RenderOptions& options)
    : evaluator_(evaluator),
      look_(look),
      slab_(options.slab),
      gradient_method_(options.gradient),
      classification_(options.classification),
      fading_(fading_of(look)),
      view_(field, camera, options),
      index_from_world_(field.geometry().world_from_index.inverse()),
      support_(evaluator.support_bounds(view_.greatest_widening())),
      shading_{unit_distance_of(look, field), field.geometry().spacing().minCoeff(),
               span_of(look, field)} {}

Pixel PixelTracer::trace(int x, int y, TraceCounts& counts) const {
  const Ray ray = view_.ray(x, y);
  const PixelRay pixel{x, y, ray, view_.sheets_within(ray, support_)};
  switch (look_.mode) {
    case Mode::kComposite:
      return composite(pixel, counts);
    case Mode::kXray:
      return xray(pixel, counts);
    case Mode::kMaximum:
      return maximum(pixel, counts);
    case Mode::kMean:
      return mean(pixel, counts);
    case Mode::kIsosurface:
      return isosurface(pixel, counts);
  }
  return {};
}

// The sample of a sheet, if there is one.
std::optional<PixelTracer::RaySample> PixelTracer::sample(const PixelRay& pixel, std::int64_t sheet,
                                                          TraceCounts& counts) const {
  if (!view_.exists(sheet)) return std::nullopt;
  const double path = view_.path(pixel.ray, sheet);
  if (!(path > 0)) return std::nullopt;
  ++counts.samples;
  const FieldSample at = field_at(pixel.x, pixel.y, sheet);
  if (!at.is_defined) return std::nullopt;
  return RaySample{sheet, view_.z_of(sheet), path, at.value, at.gradient};
}

// The field on the sample (x, y, sheet) of the view lattice.
FieldSample PixelTracer::field_at(int x, int y, std::int64_t sheet) const {
  return field_on_ray(view_.ray(x, y), view_.z_of(sheet), view_.widening(sheet));
}

// The field where a ray meets the plane at z, or its mean over the slab around that plane.
FieldSample PixelTracer::field_on_ray(const Ray& ray, double z, const Vec3& widening) const {
  if (slab_ == Slab::kMid) return evaluator_.at_index(index_from_world_ * ray.at(z), widening);
  const double half_slab = 0.5 * view_.sampling_distance();
  return evaluator_.mean_over(index_from_world_ * ray.at(z - half_slab),
                              index_from_world_ * ray.at(z + half_slab), widening);
}

Vec3 PixelTracer::gradient(const PixelRay& pixel, const RaySample& sample) const {
  if (gradient_method_ == GradientMethod::kCentral) return central_gradient(pixel, sample);
  return own_gradient(sample.exact_gradient, pixel.ray.at(sample.z), view_.widening(sample.sheet));
}

// Half-way between two sheets; central differences are the second one's.
Vec3 PixelTracer::piece_gradient(const PixelRay& pixel, const RaySample& from,
                                 const RaySample& to) const {
  if (gradient_method_ == GradientMethod::kCentral) return central_gradient(pixel, to);
  const double z = 0.5 * (from.z + to.z);
  const Vec3 widening = view_.widening(to.sheet);
  const FieldSample middle = field_on_ray(pixel.ray, z, widening);
  return own_gradient(middle.gradient, pixel.ray.at(z), widening);
}

// The kernels' own gradient at a place, corrected if so asked.
Vec3 PixelTracer::own_gradient(const Vec3& exact, const Vec3& position,
                               const Vec3& widening) const {
  if (gradient_method_ == GradientMethod::kExact) return exact;
  return evaluator_.corrected_gradient(exact, index_from_world_ * position, widening);
}

Vec3 PixelTracer::central_gradient(const PixelRay& pixel, const RaySample& sample) const {
  const auto difference = [&](int dx, int dy, int dk) -> double {
    const FieldSample before = field_at(pixel.x - dx, pixel.y - dy, sample.sheet - dk);
    const FieldSample behind = field_at(pixel.x + dx, pixel.y + dy, sample.sheet + dk);
    if (before.is_defined && behind.is_defined) return 0.5 * (behind.value - before.value);
    if (before.is_defined) return sample.value - before.value;
    if (behind.is_defined) return behind.value - sample.value;
    return 0;
  };
  const Vec3 differences(difference(1, 0, 0), difference(0, 1, 0), difference(0, 0, 1));
  return view_.position_derivatives(pixel.ray, sample.sheet).transpose().inverse() * differences;
}

Pixel PixelTracer::composite(const PixelRay& pixel, TraceCounts& counts) const {
  const Vec3 to_eye = -pixel.ray.direction.normalized();
  Pixel result;
  double& alpha = result.rgba[3];
  std::optional<RaySample> before;
  for (std::int64_t k = pixel.sheets.first; k <= pixel.sheets.last; ++k) {
    if (alpha >= RenderOptions::kOpaque) break;
    const std::optional<RaySample> at = sample(pixel, k, counts);
    if (!at) {
      before.reset();
      continue;
    }
    const std::optional<RaySample> start = classification_ == Classification::kPreintegrated
                                               ? std::exchange(before, at)
                                               : std::nullopt;
    ClassifiedSample seen = classified_sample(start, *at);
    if (seen.opacity == 0) continue;
    ++counts.visible;
    if (look_.shade || !fading_.opacities.empty()) {
      ++counts.gradients;
      const Vec3 slope = start ? piece_gradient(pixel, *start, *at) : gradient(pixel, *at);
      seen.opacity *= fading_.opacity_at(slope.norm());
      if (look_.shade) seen.color = shaded(seen.color, slope, to_eye, look_, shading_);
    }
    const Rgb& color = seen.color;
    const double a = opacity_over(seen.opacity, at->path, shading_.unit_distance);
    for (std::size_t c = 0; c < 3; ++c) result.rgba[c] += (1 - alpha) * a * color[c];
    alpha += (1 - alpha) * a;
    if (alpha >= 0.5 && std::isinf(result.depth)) result.depth = at->z;
  }
  return result;
}

// Colour, and opacity over a unit distance, of a sample, or of the piece that ends at it.
ClassifiedSample PixelTracer::classified_sample(const std::optional<RaySample>& before,
                                                const RaySample& at) const {
  const TransferFunction& tf = look_.transfer_function;
  if (before && before->value != at.value) return classified_piece(tf, before->value, at.value);
  return {tf.color_at(at.value), tf.opacity_at(at.value)};
}

Pixel PixelTracer::xray(const PixelRay& pixel, TraceCounts& counts) const {
  double integral = 0;
  double depth = std::numeric_limits<double>::infinity();
  bool is_defined = false;
  for (std::int64_t k = pixel.sheets.first; k <= pixel.sheets.last; ++k) {
    const std::optional<RaySample> at = sample(pixel, k, counts);
    if (!at) continue;
    ++counts.visible;
    integral += at->value * at->path;
    if (!is_defined) depth = at->z;
    is_defined = true;
  }
  if (!is_defined) return {};
  return {{integral, integral, integral, 1}, depth};
}

Pixel PixelTracer::maximum(const PixelRay& pixel, TraceCounts& counts) const {
  std::optional<RaySample> greatest;
  for (std::int64_t k = pixel.sheets.first; k <= pixel.sheets.last; ++k) {
    const std::optional<RaySample> at = sample(pixel, k, counts);
    if (at && (!greatest || at->value > greatest->value)) greatest = at;
  }
  return greatest ? classified(greatest->value, greatest->z, counts) : Pixel{};
}

Pixel PixelTracer::mean(const PixelRay& pixel, TraceCounts& counts) const {
  double integral = 0;
  double length = 0;
  double depth = std::numeric_limits<double>::infinity();
  for (std::int64_t k = pixel.sheets.first; k <= pixel.sheets.last; ++k) {
    const std::optional<RaySample> at = sample(pixel, k, counts);
    if (!at) continue;
    if (length == 0) depth = at->z;
    integral += at->value * at->path;
    length += at->path;
  }
  return length > 0 ? classified(integral / length, depth, counts) : Pixel{};
}

// A pixel that one value stands for; the opacity is not corrected by a distance.
Pixel PixelTracer::classified(double value, double depth, TraceCounts& counts) const {
  const double opacity = look_.transfer_function.opacity_at(value);
  if (opacity > 0) ++counts.visible;
  return premultiplied(look_.transfer_function.color_at(value), opacity, depth);
}

Pixel PixelTracer::isosurface(const PixelRay& pixel, TraceCounts& counts) const {
  const Vec3 to_eye = -pixel.ray.direction.normalized();
  const double iso = look_.isovalue;
  std::optional<RaySample> near;
  for (std::int64_t k = pixel.sheets.first; k <= pixel.sheets.last; ++k) {
    const std::optional<RaySample> far = sample(pixel, k, counts);
    if (near && far && (near->value < iso) != (far->value < iso)) {
      const double z = refined_crossing(pixel, *near, *far);
      if (view_.is_kept(pixel.ray.at(z))) {
        ++counts.visible;
        Rgb color = look_.transfer_function.color_at(iso);
        if (look_.shade) {
          ++counts.gradients;
          const Vec3 widening = view_.widening(far->sheet);
          const FieldSample at = field_on_ray(pixel.ray, z, widening);
          const Vec3 gradient = own_gradient(at.gradient, pixel.ray.at(z), widening);
          color = shaded(color, gradient, to_eye, look_, shading_);
        }
        return premultiplied(color, 1, z);
      }
    }
    near = far;
  }
  return {};
}

// Where between two neighbouring sheets the field on the ray meets the isovalue: docs/numerics.md,
// "Modes".
double PixelTracer::refined_crossing(const PixelRay& pixel, const RaySample& near,
                                     const RaySample& far) const {
  constexpr int kNumBisections = 8;
  const double iso = look_.isovalue;
  const Vec3 widening = view_.widening(far.sheet);
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
