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

double unit_distance_of(const Look& look, const Field& field) {
  if (look.unit_distance > 0) return look.unit_distance;
  return look.transfer_function.unit_distance.value_or(default_unit_distance(field));
}

double span_of(const Look& look, const Field& field) {
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

PixelTracer::PixelTracer(const Field& field, const ViewRays& view, const Look& look,
                         const RenderOptions& options, const PixelTracer* trail)
    : look_(look),
      has_own_color_(field.kernels() != nullptr && field.kernels()->has_own_color()),
      classification_(options.classification),
      fading_(fading_of(look)),
      view_(view),
      shading_{unit_distance_of(look, field), field.default_sampling_distance(),
               span_of(look, field)},
      trail_(trail) {}

Pixel PixelTracer::trace(int x, int y, TraceCounts& counts) const {
  const Ray ray = view_.ray(x, y);
  const PixelRay pixel{x, y, ray, sheets_of_all(ray)};
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

SheetRange PixelTracer::sheets_of_all(const Ray& ray) const {
  const SheetRange own = sheets_of(ray);
  if (trail_ == nullptr) return own;
  const SheetRange of_trail = trail_->sheets_of_all(ray);
  if (own.first > own.last) return of_trail;
  if (of_trail.first > of_trail.last) return own;
  return {std::min(own.first, of_trail.first), std::max(own.last, of_trail.last)};
}

// A sample, or the piece that ends at it, joins what is in front of it.
void PixelTracer::add_sample(const PixelRay& pixel, const std::optional<RaySample>& start,
                             const RaySample& at, Pixel& result, TraceCounts& counts) const {
  ClassifiedSample seen = classified_sample(start, at);
  if (seen.opacity == 0) return;
  ++counts.visible;
  if (look_.shade || !fading_.opacities.empty()) {
    ++counts.gradients;
    const Vec3 slope = start ? piece_gradient(pixel, *start, at) : gradient(pixel, at);
    seen.opacity *= fading_.opacity_at(slope.norm());
    if (look_.shade) {
      const Vec3 to_eye = -pixel.ray.direction.normalized();
      seen.color = shaded(seen.color, slope, to_eye, look_, shading_);
    }
  }
  double& alpha = result.rgba[3];
  const double a = opacity_over(seen.opacity, at.path, shading_.unit_distance);
  for (std::size_t c = 0; c < 3; ++c) result.rgba[c] += (1 - alpha) * a * seen.color[c];
  alpha += (1 - alpha) * a;
  if (alpha >= 0.5 && std::isinf(result.depth)) result.depth = at.z;
}

// What the trail has on a sheet.
void PixelTracer::add_trail(const PixelRay& pixel, std::int64_t sheet, Pixel& result,
                            TraceCounts& counts) const {
  if (trail_ == nullptr || result.rgba[3] >= RenderOptions::kOpaque) return;
  const std::optional<RaySample> at = trail_->sample(pixel, sheet, counts);
  if (at) trail_->add_sample(pixel, std::nullopt, *at, result, counts);
}

Pixel PixelTracer::composite(const PixelRay& pixel, TraceCounts& counts) const {
  Pixel result;
  std::optional<RaySample> before;
  for (std::int64_t k = pixel.sheets.first; k <= pixel.sheets.last; ++k) {
    if (result.rgba[3] >= RenderOptions::kOpaque) break;
    const std::optional<RaySample> at = sample(pixel, k, counts);
    if (at) {
      std::optional<RaySample> start;
      if (before && classification_ == Classification::kPreintegrated)
        start = front_end(pixel, *before, *at);
      add_sample(pixel, start, *at, result, counts);
    }
    before = at;
    add_trail(pixel, k, result, counts);
  }
  return result;
}

PixelTracer::RaySample PixelTracer::front_end(const PixelRay& /*pixel*/, const RaySample& before,
                                              const RaySample& /*at*/) const {
  return before;
}

// Colour, and opacity over a unit distance, of a sample, or of the piece that ends at it.
ClassifiedSample PixelTracer::classified_sample(const std::optional<RaySample>& before,
                                                const RaySample& at) const {
  const TransferFunction& tf = look_.transfer_function;
  if (before && before->value != at.value) {
    ClassifiedSample piece = classified_piece(tf, before->value, at.value);
    if (has_own_color_) piece.color = color_of(at.color_value);
    return piece;
  }
  return {color_of(at.color_value), tf.opacity_at(at.value)};
}

Rgb PixelTracer::color_of(double color_value) const {
  const bool is_apart = has_own_color_ && look_.color_function.has_value();
  return (is_apart ? *look_.color_function : look_.transfer_function).color_at(color_value);
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
  Pixel result;  // what is in front of the surface
  std::optional<RaySample> near;
  for (std::int64_t k = pixel.sheets.first; k <= pixel.sheets.last; ++k) {
    if (result.rgba[3] >= RenderOptions::kOpaque) break;
    const std::optional<RaySample> far = sample(pixel, k, counts);
    if (near && far) near = front_end(pixel, *near, *far);
    if (near && far && (near->value < iso) != (far->value < iso)) {
      const Crossing at = crossing(pixel, *near, *far);
      if (view_.is_kept(pixel.ray.at(at.z))) {
        ++counts.visible;
        Rgb color = color_of(has_own_color_ ? at.color_value : iso);
        if (look_.shade) {
          ++counts.gradients;
          color = shaded(color, at.gradient, to_eye, look_, shading_);
        }
        const double rest = 1 - result.rgba[3];
        for (std::size_t c = 0; c < 3; ++c) result.rgba[c] += rest * color[c];
        result.rgba[3] = 1;
        if (std::isinf(result.depth)) result.depth = at.z;
        return result;
      }
    }
    near = far;
    add_trail(pixel, k, result, counts);
  }
  return result;
}

}  // namespace ovoid::reference
