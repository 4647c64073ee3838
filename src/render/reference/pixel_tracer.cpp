// SPDX-License-Identifier: Apache-2.0
// A ray's samples and what becomes of them. Each mode is one loop over the sheets in order of
// increasing k; a sheet has a sample where the field is defined and a part of the segment is left
// by the clip planes.
#include "render/reference/pixel_tracer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "view/frame_plan.h"
#include "view/isosurfaces.h"
#include "view/look_variation.h"

namespace ovoid::reference {
namespace {

constexpr double kNowhere = std::numeric_limits<double>::infinity();  // a depth

double unit_distance_of(const Look& look, const Field& field) {
  if (look.unit_distance > 0) return look.unit_distance;
  return look.transfer_function.unit_distance.value_or(default_unit_distance(field));
}

// Of the drawn range, per smallest spacing.
double flat_rise_of(const Look& look, const Field& field) {
  if (look.mode == Mode::kIsosurface) {
    const ValueRange range = field.value_range();
    return range.is_empty() ? 0.0 : 1e-4 * (static_cast<double>(range.hi) - range.lo);
  }
  const TransferFunction& tf = look.transfer_function;
  return std::max(look.flat_rise, 1e-6) * (tf.hi() - tf.lo());
}

// Opacity by the gradient's length, as a curve of its own.
TransferFunction fading_of(const Look& look) {
  TransferFunction fading;
  fading.opacities = look.transfer_function.gradient_opacities;
  return fading;
}

// What stands for a pixel at one place alone.
Pixel premultiplied(const Rgb& color, double alpha, double depth) {
  return {{alpha * color[0], alpha * color[1], alpha * color[2], alpha},
          depth,
          alpha >= double{kLeastVisibleOpacity} ? depth : kNowhere};
}

// What has just joined a pixel at a depth may be what brings its opacity so far.
void note_depth(double depth, Pixel& pixel) {
  const double alpha = pixel.rgba[3];
  if (alpha >= 0.5 && pixel.depth == kNowhere) pixel.depth = depth;
  if (alpha >= double{kLeastVisibleOpacity} && pixel.front_depth == kNowhere)
    pixel.front_depth = depth;
}

}  // namespace

PixelTracer::PixelTracer(const Field& field, const ViewRays& view, const Look& look,
                         const RenderOptions& options, const PixelTracer* trail,
                         const view::LightVolume* light)
    : look_(look),
      surfaces_(view::surfaces_of(look)),
      has_own_color_(field.kernels() != nullptr && field.kernels()->has_own_color()),
      opaque_at_(options.opaque_at),
      keeps_values_(options.part != nullptr),
      limits_(options.depth_limits),
      reaches_limits_(limits_ != nullptr && field.kernels() != nullptr),
      is_preintegrated_(options.classification == Classification::kPreintegrated),
      is_refined_(view::draws_pieces(field, look, options)),
      fading_(fading_of(look)),
      table_(look.transfer_function),
      variation_(
          view::look_variation(table_, view.sampling_distance() / unit_distance_of(look, field))),
      view_(view),
      shading_{unit_distance_of(look, field), field.default_sampling_distance(),
               flat_rise_of(look, field)},
      trail_(trail),
      light_(light) {}

Pixel PixelTracer::trace(int x, int y, TraceCounts& counts) const {
  const PixelRay pixel = pixel_ray(x, y);
  switch (look_.mode) {
    case Mode::kComposite:
      return is_refined_ ? refined(pixel, counts) : composite(pixel, counts);
    case Mode::kXray:
      return xray(pixel, counts);
    case Mode::kMaximum:
    case Mode::kMinimum:
      return extreme(pixel, counts);
    case Mode::kMean:
      return mean(pixel, counts);
    case Mode::kIsosurface:
      return isosurface(pixel, counts);
  }
  return {};
}

PixelTracer::PixelRay PixelTracer::pixel_ray(int x, int y) const {
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  const Ray ray = view_.ray(x, y);
  PixelRay pixel{x, y, ray, sheets_of_all(ray), {}, {}};
  if (limits_ == nullptr) {
    pixel.spans = {{{-kEndless, kEndless}}};
    return pixel;
  }
  pixel.stops = limits_->of_pixel(x, y);
  for (std::size_t i = 0; i < pixel.stops.size(); ++i) {
    const bool is_last = i + 1 == pixel.stops.size();
    if (pixel.stops[i].is_field_behind)
      pixel.spans.push_back({{pixel.stops[i].depth, is_last ? kEndless : pixel.stops[i + 1].depth},
                             pixel.stops[i].is_seam,
                             !is_last && pixel.stops[i + 1].is_seam});
  }
  return pixel;
}

// A sample whose path is what the limits leave of it.
std::optional<PixelTracer::RaySample> PixelTracer::within_limits(
    const PixelRay& pixel, std::optional<RaySample> at) const {
  if (!at || limits_ == nullptr) return at;
  const double half = 0.5 * view_.sampling_distance();
  at->path = 0;
  for (const Span& span : pixel.spans) {
    const ZRange part =
        view_.kept(pixel.ray, {std::max(at->z - half, span.lo), std::min(at->z + half, span.hi)});
    at->path += std::max(part.hi - part.lo, 0.0) * pixel.ray.direction.norm();
  }
  if (!(at->path > 0)) return std::nullopt;
  return at;
}

bool PixelTracer::is_within(const PixelRay& pixel, double z) const {
  return std::any_of(pixel.spans.begin(), pixel.spans.end(),
                     [&](const Span& span) { return span.lo <= z && z < span.hi; });
}

// What is seen at the limits up to a depth joins the pixel.
void PixelTracer::add_stops(const PixelRay& pixel, double up_to, Pixel& result) const {
  for (; result.num_stops < pixel.stops.size(); ++result.num_stops) {
    const DepthLimits::Stop& stop = pixel.stops[result.num_stops];
    if (stop.depth > up_to) return;
    double& alpha = result.rgba[3];
    if (alpha >= opaque_at_) continue;
    const double through = 1 - alpha;
    for (std::size_t c = 0; c < 4; ++c) result.rgba[c] += through * stop.rgba[c];
    note_depth(stop.depth, result);
  }
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
  Vec3 slope = Vec3::Zero();
  if (uses_gradients()) {
    ++counts.gradients;
    slope = start ? piece_gradient(pixel, *start, at) : gradient(pixel, at);
  }
  add_seen(pixel,
           {seen, slope, clearance_at(pixel, at.z), light_at(pixel, at.z, slope), at.z, at.path},
           result);
}

// From cut faces, in smallest spacings.
double PixelTracer::clearance_at(const PixelRay& pixel, double z) const {
  if (look_.mode != Mode::kComposite) return 1;
  const std::optional<double> distance = view_.clearance(pixel.ray.at(z));
  return distance ? *distance / shading_.least_spacing : 1;
}

LitPlace PixelTracer::lit_place(const PixelRay& pixel, const Vec3& slope, double clearance) const {
  return {slope, -pixel.ray.direction.normalized(), clearance};
}

// How much light arrives at a sample with that gradient, which an unlit look does not use.
view::ArrivingLight PixelTracer::light_at(const PixelRay& pixel, double z,
                                          const Vec3& slope) const {
  if (light_ == nullptr) return {};
  const Vec3 used_slope = look_.shade ? slope : Vec3(Vec3::Zero());
  return arriving_light(*light_, pixel.ray.at(z),
                        lit_place(pixel, used_slope, clearance_at(pixel, z)), shading_);
}

// A colour under the light, or what is left of it where the look is not lit.
Rgb PixelTracer::seen_color(const Rgb& color, const LitPlace& place,
                            const view::ArrivingLight& arriving) const {
  if (look_.shade) return shaded(color, place, look_, shading_, arriving);
  Rgb dimmed = color;
  for (double& c : dimmed) c *= view::unlit_share(arriving);
  return dimmed;
}

// What was classified is faded, lit and composited.
void PixelTracer::add_seen(const PixelRay& pixel, const SeenSample& seen, Pixel& result) const {
  auto [color, opacity] = seen.look;
  if (!fading_.opacities.empty()) opacity *= fading_.opacity_at(seen.slope.norm());
  color = seen_color(color, lit_place(pixel, seen.slope, seen.clearance), seen.arriving);
  double& alpha = result.rgba[3];
  const double a = opacity_over(opacity, seen.path, shading_.unit_distance);
  for (std::size_t c = 0; c < 3; ++c) result.rgba[c] += (1 - alpha) * a * color[c];
  alpha += (1 - alpha) * a;
  note_depth(seen.z, result);
}

// What the trail has on a sheet.
void PixelTracer::add_trail(const PixelRay& pixel, std::int64_t sheet, Pixel& result,
                            TraceCounts& counts) const {
  if (trail_ == nullptr || result.rgba[3] >= opaque_at_) return;
  const std::optional<RaySample> at = trail_->sample(pixel, sheet, counts);
  if (at) trail_->add_sample(pixel, std::nullopt, *at, result, counts);
}

Pixel PixelTracer::composite(const PixelRay& pixel, TraceCounts& counts) const {
  Pixel result;
  std::optional<RaySample> before;
  for (std::int64_t k = pixel.sheets.first; k <= pixel.sheets.last; ++k) {
    if (result.rgba[3] >= opaque_at_) break;
    const std::optional<RaySample> own = sample(pixel, k, counts);
    const std::optional<RaySample> at = within_limits(pixel, own);
    if (at) {
      add_stops(pixel, at->z, result);
      std::optional<RaySample> start;
      if (before && is_preintegrated_) start = front_end(pixel, *before, *at);
      add_sample(pixel, start, *at, result, counts);
    }
    before = own;
    add_trail(pixel, k, result, counts);
  }
  add_stops(pixel, std::numeric_limits<double>::infinity(), result);
  return result;
}

PixelTracer::RaySample PixelTracer::front_end(const PixelRay& /*pixel*/, const RaySample& before,
                                              const RaySample& /*at*/) const {
  return before;
}

// Half of it, next to the end that there is.
ZRange PixelTracer::range_of(const PixelRay& /*pixel*/, const Piece& piece) const {
  const double near = view_.z_of(piece.sheet - 1);
  const double far = view_.z_of(piece.sheet);
  const double middle = 0.5 * (near + far);
  return {piece.front ? near : middle, piece.back ? far : middle};
}

// Whether a value between the ends has any opacity.
bool PixelTracer::may_show(const Piece& piece) const {
  const auto front = static_cast<float>((piece.front ? piece.front : piece.back)->value);
  const auto back = static_cast<float>((piece.back ? piece.back : piece.front)->value);
  return table_.any_opacity(std::min(front, back), std::max(front, back));
}

int PixelTracer::num_steps(const Piece& piece, const Vec3& front_slope,
                           const Vec3& back_slope) const {
  if (!piece.front || !piece.back) return 1;
  const auto variation_to = [&](double value) {
    return static_cast<double>(table_.read(variation_, static_cast<float>(value)));
  };
  const double change =
      std::abs(variation_to(piece.back->value) - variation_to(piece.front->value));
  const auto seen_normal = [&](const Vec3& slope) -> Vec3 {
    return flatness(slope, shading_) * normal_of(slope);
  };
  const double turn = (seen_normal(back_slope) - seen_normal(front_slope)).norm();
  return view::steps_for(view::kStepsPerVariation * change + (uses_gradients() ? turn : 0.0));
}

// What spans, planes and the field's end leave of a piece, front to back.
std::vector<ZRange> PixelTracer::parts_left(const PixelRay& pixel, const Piece& piece) const {
  const ZRange range = range_of(pixel, piece);
  std::vector<ZRange> parts;
  for (const Span& span : pixel.spans) {
    ZRange whole = range;
    if (reaches_limits_) {
      if (!span.begins_at_seam && span.lo > view_.z_of(piece.sheet - 1))
        whole.lo = view_.z_of(piece.sheet - 1);
      if (!span.ends_at_seam && span.hi < view_.z_of(piece.sheet))
        whole.hi = view_.z_of(piece.sheet);
    }
    const ZRange part =
        view_.kept(pixel.ray, {std::max(whole.lo, span.lo), std::min(whole.hi, span.hi)});
    if (part.lo < part.hi) parts.push_back(part);
  }
  return parts;
}

// The piece in steps: docs/numerics.md, "Classification", refined.
void PixelTracer::add_piece(const PixelRay& pixel, const Piece& piece, Pixel& result,
                            TraceCounts& counts) const {
  if (!may_show(piece)) return;
  for (const ZRange& part : parts_left(pixel, piece)) {
    add_stops(pixel, part.lo, result);
    add_part(pixel, piece, part, result, counts);
  }
}

void PixelTracer::add_part(const PixelRay& pixel, const Piece& piece, const ZRange& part,
                           Pixel& result, TraceCounts& counts) const {
  if (result.rgba[3] >= opaque_at_) return;
  const RaySample& front = piece.front ? *piece.front : *piece.back;
  const RaySample& back = piece.back ? *piece.back : *piece.front;
  Vec3 front_slope = Vec3::Zero();
  Vec3 back_slope = Vec3::Zero();
  if (uses_gradients()) {
    counts.gradients += 2;
    front_slope = gradient(pixel, front);
    back_slope = gradient(pixel, back);
  }
  // Light goes straight from end to end, as the gradient does.
  const view::ArrivingLight front_light = light_at(pixel, front.z, front_slope);
  const view::ArrivingLight back_light = light_at(pixel, back.z, back_slope);
  const double front_clearance = clearance_at(pixel, view_.z_of(piece.sheet - 1));
  const double back_clearance = clearance_at(pixel, view_.z_of(piece.sheet));
  const int steps = num_steps(piece, front_slope, back_slope);
  const double length = (part.hi - part.lo) / steps;
  for (int m = 0; m < steps && result.rgba[3] < opaque_at_; ++m) {
    const double z = part.lo + (m + 0.5) * length;
    const double t = (z - view_.z_of(piece.sheet - 1)) / view_.sampling_distance();
    const double value = front.value + t * (back.value - front.value);
    const double opacity = look_.transfer_function.opacity_at(value);
    if (opacity == 0) continue;
    ++counts.visible;
    const Rgb color = color_of(front.color_value + t * (back.color_value - front.color_value));
    add_seen(pixel,
             {{color, opacity},
              front_slope + t * (back_slope - front_slope),
              std::lerp(front_clearance, back_clearance, t),
              {std::lerp(front_light.around, back_light.around, t),
               std::lerp(front_light.key, back_light.key, t)},
              z,
              length * pixel.ray.direction.norm()},
             result);
  }
}

Pixel PixelTracer::refined(const PixelRay& pixel, TraceCounts& counts) const {
  Pixel result;
  std::optional<RaySample> before;
  for (std::int64_t k = pixel.sheets.first; k <= pixel.sheets.last + 1; ++k) {
    if (result.rgba[3] >= opaque_at_) break;
    const std::optional<RaySample> at = sample(pixel, k, counts);
    if (before || at) add_piece(pixel, {k, before, at}, result, counts);
    before = at;
    add_trail(pixel, k, result, counts);
  }
  add_stops(pixel, std::numeric_limits<double>::infinity(), result);
  return result;
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

// Of a part of a piece the end that is the greater or the less, or the middle.
void PixelTracer::add_values(const PixelRay& pixel, const Piece& piece,
                             std::vector<SeenValue>& seen) const {
  const double front = (piece.front ? piece.front : piece.back)->value;
  const double back = (piece.back ? piece.back : piece.front)->value;
  const auto value_at = [&](double z) {
    const double t = (z - view_.z_of(piece.sheet - 1)) / view_.sampling_distance();
    return front + t * (back - front);
  };
  for (const ZRange& part : parts_left(pixel, piece)) {
    const double path = (part.hi - part.lo) * pixel.ray.direction.norm();
    const double first = value_at(part.lo);
    const double last = value_at(part.hi);
    if (look_.mode == Mode::kXray || look_.mode == Mode::kMean) {
      seen.push_back({0.5 * (first + last), part.lo, path});
    } else if (look_.mode == Mode::kMaximum ? last > first : last < first) {
      seen.push_back({last, part.hi, path});
    } else {
      seen.push_back({first, part.lo, path});
    }
  }
}

// Samples with a path, or where planes cut the pieces between them: docs/numerics.md, "Cut values".
std::vector<PixelTracer::SeenValue> PixelTracer::values_along(const PixelRay& pixel,
                                                              TraceCounts& counts) const {
  std::vector<SeenValue> seen;
  std::optional<RaySample> before;
  const std::int64_t last = pixel.sheets.last + (is_refined_ ? 1 : 0);
  for (std::int64_t k = pixel.sheets.first; k <= last; ++k) {
    const std::optional<RaySample> own = sample(pixel, k, counts);
    if (is_refined_) {
      if (before || own) add_values(pixel, {k, before, own}, seen);
      before = own;
    } else if (const std::optional<RaySample> at = within_limits(pixel, own)) {
      seen.push_back({at->value, at->z, at->path});
    }
  }
  return seen;
}

Pixel PixelTracer::xray(const PixelRay& pixel, TraceCounts& counts) const {
  const std::vector<SeenValue> seen = values_along(pixel, counts);
  if (seen.empty()) return {};
  double integral = 0;
  for (const SeenValue& at : seen) integral += at.value * at.path;
  counts.visible += static_cast<std::int64_t>(seen.size());
  const double depth = seen.front().z;
  if (keeps_values_) return kept(integral, 0, depth);
  return {{integral, integral, integral, 1}, depth, depth};
}

Pixel PixelTracer::extreme(const PixelRay& pixel, TraceCounts& counts) const {
  const std::vector<SeenValue> seen = values_along(pixel, counts);
  if (seen.empty()) return {};
  const SeenValue best =
      *std::min_element(seen.begin(), seen.end(), [&](const SeenValue& a, const SeenValue& b) {
        return look_.mode == Mode::kMaximum ? a.value > b.value : a.value < b.value;
      });
  if (keeps_values_) return kept(best.value, 0, best.z);
  return classified(best.value, best.z, counts);
}

Pixel PixelTracer::mean(const PixelRay& pixel, TraceCounts& counts) const {
  const std::vector<SeenValue> seen = values_along(pixel, counts);
  if (seen.empty()) return {};
  double integral = 0;
  double length = 0;
  for (const SeenValue& at : seen) {
    integral += at.value * at.path;
    length += at.path;
  }
  const double depth = seen.front().z;
  return keeps_values_ ? kept(integral, length, depth)
                       : classified(integral / length, depth, counts);
}

// keep_value().
Pixel PixelTracer::kept(double best, double path, double depth) {
  return {{best, path, 0, 1}, depth, depth};
}

// A pixel that one value stands for; the opacity is not corrected by a distance.
Pixel PixelTracer::classified(double value, double depth, TraceCounts& counts) const {
  const double opacity = look_.transfer_function.opacity_at(value);
  if (opacity > 0) ++counts.visible;
  return premultiplied(look_.transfer_function.color_at(value), opacity, depth);
}

void PixelTracer::add_surface(const PixelRay& pixel, const Isosurface& surface, const Crossing& at,
                              Pixel& result, TraceCounts& counts) const {
  ++counts.visible;
  Rgb color =
      surface.color ? *surface.color : color_of(has_own_color_ ? at.color_value : surface.value);
  if (look_.shade) ++counts.gradients;
  color = seen_color(color, lit_place(pixel, at.gradient, clearance_at(pixel, at.z)),
                     light_at(pixel, at.z, at.gradient));
  const double share = (1 - result.rgba[3]) * surface.opacity;
  for (std::size_t c = 0; c < 3; ++c) result.rgba[c] += share * color[c];
  result.rgba[3] = surface.opacity < 1 ? result.rgba[3] + share : 1;
  note_depth(at.z, result);
}

// In the order in which the ray meets them where the value goes straight.
void PixelTracer::add_surfaces_between(const PixelRay& pixel, const RaySample& near,
                                       const RaySample& far, Pixel& result,
                                       TraceCounts& counts) const {
  const bool rises = near.value < far.value;
  for (std::size_t i = 0; i < surfaces_.size() && result.rgba[3] < opaque_at_; ++i) {
    const Isosurface& surface = surfaces_[rises ? i : surfaces_.size() - 1 - i];
    if ((near.value < surface.value) == (far.value < surface.value)) continue;
    const Crossing at = crossing(pixel, near, far, surface.value);
    if (!view_.is_kept(pixel.ray.at(at.z)) || !is_within(pixel, at.z)) continue;
    add_stops(pixel, at.z, result);
    if (result.rgba[3] < opaque_at_) add_surface(pixel, surface, at, result, counts);
  }
}

Pixel PixelTracer::isosurface(const PixelRay& pixel, TraceCounts& counts) const {
  Pixel result;
  std::optional<RaySample> near;
  for (std::int64_t k = pixel.sheets.first; k <= pixel.sheets.last; ++k) {
    if (result.rgba[3] >= opaque_at_) break;
    const std::optional<RaySample> far = sample(pixel, k, counts);
    if (near && far) {
      near = front_end(pixel, *near, *far);
      add_surfaces_between(pixel, *near, *far, result, counts);
    }
    near = far;
    add_trail(pixel, k, result, counts);
  }
  add_stops(pixel, std::numeric_limits<double>::infinity(), result);
  return result;
}

}  // namespace ovoid::reference
