// SPDX-License-Identifier: Apache-2.0
// A ray's samples and what becomes of them. Each mode is one loop over the sheets in order of
// increasing k; a sheet has a sample where the field is defined and a part of the segment is left
// by the clip planes. The modes that show one value of a ray are in pixel_values.cpp.
#include "render/reference/pixel_tracer.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "view/look/isosurfaces.h"
#include "view/look/look_2d.h"
#include "view/look/look_variation.h"
#include "view/plan/frame_plan.h"

namespace ovoid::reference {
namespace {

constexpr double kNowhere = std::numeric_limits<double>::infinity();  // a depth

// The most optical depth that colours are mixed by: docs/numerics.md, "Several volumes".
constexpr double kMostDepthMixed = 12;

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

view::Variation2D variation_of(const Look& look, const view::LookTable& table,
                               double path_in_units) {
  if (look.transfer_function_2d)
    return view::variation_of(*look.transfer_function_2d, table, path_in_units);
  return {view::look_variation(table, path_in_units), {}};
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
                         const RenderOptions& options, const BesideTracer& beside,
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
          variation_of(look, table_, view.sampling_distance() / unit_distance_of(look, field))),
      view_(view),
      shading_{unit_distance_of(look, field), field.default_sampling_distance(),
               flat_rise_of(look, field)},
      beside_(beside),
      all_{this},
      light_(light) {
  all_.insert(all_.end(), beside.further.begin(), beside.further.end());
}

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
  SheetRange all = sheets_of(ray);
  const auto join = [&](const PixelTracer& other) {
    const SheetRange more = other.sheets_of_all(ray);
    if (more.first > more.last) return;
    all = all.first > all.last
              ? more
              : SheetRange{std::min(all.first, more.first), std::max(all.last, more.last)};
  };
  if (beside_.trail != nullptr) join(*beside_.trail);
  for (const PixelTracer* further : beside_.further) join(*further);
  return all;
}

// Of a sample, or the piece that ends at it.
std::optional<PixelTracer::Share> PixelTracer::share_of_sample(
    const PixelRay& pixel, const std::optional<RaySample>& start, const RaySample& at,
    TraceCounts& counts) const {
  const ClassifiedSample seen = classified_sample(start, at);
  if (seen.opacity == 0) return std::nullopt;
  ++counts.visible;
  Vec3 slope = Vec3::Zero();
  if (uses_gradients()) {
    ++counts.gradients;
    slope = start ? piece_gradient(pixel, *start, at) : gradient(pixel, at);
  }
  return share_of(pixel, {at.value, seen, slope, clearance_at(pixel, at.z),
                          light_at(pixel, at.z, slope), at.z, at.path});
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

// What was classified is faded and lit.
PixelTracer::Share PixelTracer::share_of(const PixelRay& pixel, const SeenSample& seen) const {
  auto [color, opacity] = seen.look;
  if (!fading_.opacities.empty()) opacity *= fading_.opacity_at(seen.slope.norm());
  if (look_.transfer_function_2d) {
    const auto [r, g, b, a] = look_.transfer_function_2d->at(seen.value, seen.slope.norm());
    color = {r, g, b};
    opacity = a;
  }
  color = seen_color(color, lit_place(pixel, seen.slope, seen.clearance), seen.arriving);
  return {color, opacity_over(opacity, seen.path, shading_.unit_distance), seen.z};
}

// docs/numerics.md, "Several volumes".
PixelTracer::Share PixelTracer::mixed(const std::vector<Share>& shares) const {
  Share all{{0, 0, 0}, 0, shares.front().z};
  if (beside_.mixing == Mixing::kColored && !beside_.further.empty()) {
    if (!shares.front().is_own) return all;
    for (const Share& share : std::span(shares).subspan(1))
      for (std::size_t c = 0; c < 3; ++c) all.color[c] += share.color[c];
    for (std::size_t c = 0; c < 3; ++c)
      all.color[c] = std::min(all.color[c], 1.0) * shares.front().color[c];
    all.opacity = shares.front().opacity;
    return all;
  }
  if (shares.size() == 1) return shares.front();
  const bool is_added = beside_.mixing == Mixing::kAdded;
  double through = 1;
  double weight = 0;
  for (const Share& share : shares) {
    const double own_through = 1 - share.opacity;
    through = is_added ? std::min(through, own_through) : through * own_through;
    const double depth = std::min(-std::log1p(-share.opacity), kMostDepthMixed);
    weight = is_added ? std::max(weight, depth) : weight + depth;
    for (std::size_t c = 0; c < 3; ++c) all.color[c] += depth * share.color[c];
  }
  all.opacity = 1 - through;
  for (double& c : all.color) c = weight > 0 ? std::min(c / weight, 1.0) : 0;
  return all;
}

// What the fields show at a place joins what is in front of it.
void PixelTracer::add_shares(const std::vector<Share>& shares, Pixel& result) const {
  if (shares.empty()) return;
  const Share seen = mixed(shares);
  double& alpha = result.rgba[3];
  for (std::size_t c = 0; c < 3; ++c) result.rgba[c] += (1 - alpha) * seen.opacity * seen.color[c];
  alpha += (1 - alpha) * seen.opacity;
  note_depth(seen.z, result);
}

// What the trail has on a sheet.
void PixelTracer::add_trail(const PixelRay& pixel, std::int64_t sheet, Pixel& result,
                            TraceCounts& counts) const {
  const PixelTracer* const trail = beside_.trail;
  if (trail == nullptr || result.rgba[3] >= opaque_at_) return;
  const std::optional<RaySample> at = trail->sample(pixel, sheet, counts);
  if (!at) return;
  std::optional<Share> share = trail->share_of_sample(pixel, std::nullopt, *at, counts);
  if (!share) return;
  share->opacity = opacity_over(share->opacity, at->presence, 1);
  add_stops(pixel, at->z, result);
  if (result.rgba[3] < opaque_at_) add_shares({*share}, result);
}

Pixel PixelTracer::composite(const PixelRay& pixel, TraceCounts& counts) const {
  Pixel result;
  std::vector<std::optional<RaySample>> before(all_.size());
  for (std::int64_t k = pixel.sheets.first; k <= pixel.sheets.last; ++k) {
    if (result.rgba[3] >= opaque_at_) break;
    std::vector<Share> shares;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      const PixelTracer& own = *all_[i];
      const std::optional<RaySample> sample = own.sample(pixel, k, counts);
      if (const std::optional<RaySample> at = own.within_limits(pixel, sample)) {
        add_stops(pixel, at->z, result);
        std::optional<RaySample> start;
        if (before[i] && is_preintegrated_) start = own.front_end(pixel, *before[i], *at);
        if (const auto share = own.share_of_sample(pixel, start, *at, counts))
          shares.push_back({share->color, share->opacity, share->z, i == 0});
      }
      before[i] = sample;
    }
    add_shares(shares, result);
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
    return static_cast<double>(table_.read(variation_.by_value, static_cast<float>(value)));
  };
  double change = std::abs(variation_to(piece.back->value) - variation_to(piece.front->value));
  if (look_.transfer_function_2d) {
    const auto variation_by = [&](const Vec3& slope) {
      return view::variation_at(variation_.by_gradient, look_.transfer_function_2d->gradients(),
                                slope.norm());
    };
    change += std::abs(variation_by(back_slope) - variation_by(front_slope));
  }
  const auto seen_normal = [&](const Vec3& slope) -> Vec3 {
    return flatness(slope, shading_) * normal_of(slope);
  };
  const double turn = (seen_normal(back_slope) - seen_normal(front_slope)).norm();
  return view::steps_for(view::kStepsPerVariation * change + (uses_gradients() ? turn : 0.0));
}

// What a span, planes and the field's end leave of a piece.
std::optional<ZRange> PixelTracer::part_within(const PixelRay& pixel, const Piece& piece,
                                               const Span& span) const {
  ZRange whole = range_of(pixel, piece);
  if (reaches_limits_) {
    if (!span.begins_at_seam && span.lo > view_.z_of(piece.sheet - 1))
      whole.lo = view_.z_of(piece.sheet - 1);
    if (!span.ends_at_seam && span.hi < view_.z_of(piece.sheet)) whole.hi = view_.z_of(piece.sheet);
  }
  const ZRange part =
      view_.kept(pixel.ray, {std::max(whole.lo, span.lo), std::min(whole.hi, span.hi)});
  if (!(part.lo < part.hi)) return std::nullopt;
  return part;
}

// The same of all spans, front to back.
std::vector<ZRange> PixelTracer::parts_left(const PixelRay& pixel, const Piece& piece) const {
  std::vector<ZRange> parts;
  for (const Span& span : pixel.spans) {
    if (const std::optional<ZRange> part = part_within(pixel, piece, span)) parts.push_back(*part);
  }
  return parts;
}

// The pieces between two sheets in steps: docs/numerics.md, "Classification", refined, and "Several
// volumes".
void PixelTracer::add_pieces(const PixelRay& pixel, const std::vector<OwnedPiece>& pieces,
                             Pixel& result, TraceCounts& counts) const {
  for (const Span& span : pixel.spans) {
    std::vector<std::pair<OwnedPiece, ZRange>> left;
    double first = std::numeric_limits<double>::infinity();
    for (const OwnedPiece& of : pieces) {
      if (!of.owner->may_show(of.piece)) continue;
      const std::optional<ZRange> part = of.owner->part_within(pixel, of.piece, span);
      if (!part) continue;
      left.emplace_back(of, *part);
      first = std::min(first, part->lo);
    }
    if (left.empty()) continue;
    add_stops(pixel, first, result);
    if (result.rgba[3] >= opaque_at_) return;
    std::vector<PiecePart> parts;
    parts.reserve(left.size());
    for (const auto& [of, part] : left)
      parts.push_back(of.owner->part_in_steps(pixel, of.piece, part, counts));
    add_parts(pixel, parts, result, counts);
  }
}

PixelTracer::PiecePart PixelTracer::part_in_steps(const PixelRay& pixel, const Piece& piece,
                                                  const ZRange& part, TraceCounts& counts) const {
  PiecePart out{.of = {this, piece}, .part = part};
  const RaySample& front = piece.front ? *piece.front : *piece.back;
  const RaySample& back = piece.back ? *piece.back : *piece.front;
  if (uses_gradients()) {
    counts.gradients += 2;
    out.front_slope = gradient(pixel, front);
    out.back_slope = gradient(pixel, back);
  }
  // Light goes straight from end to end, as the gradient does.
  out.front_light = light_at(pixel, front.z, out.front_slope);
  out.back_light = light_at(pixel, back.z, out.back_slope);
  out.front_clearance = clearance_at(pixel, view_.z_of(piece.sheet - 1));
  out.back_clearance = clearance_at(pixel, view_.z_of(piece.sheet));
  out.steps = num_steps(piece, out.front_slope, out.back_slope);
  return out;
}

std::optional<PixelTracer::Share> PixelTracer::share_of_step(const PixelRay& pixel,
                                                             const PiecePart& part, int step,
                                                             int steps, TraceCounts& counts) const {
  const Piece& piece = part.of.piece;
  const RaySample& front = piece.front ? *piece.front : *piece.back;
  const RaySample& back = piece.back ? *piece.back : *piece.front;
  const double length = (part.part.hi - part.part.lo) / steps;
  const double z = part.part.lo + (step + 0.5) * length;
  const double t = (z - view_.z_of(piece.sheet - 1)) / view_.sampling_distance();
  const double value = front.value + t * (back.value - front.value);
  const double opacity = look_.transfer_function.opacity_at(value);
  if (opacity == 0) return std::nullopt;
  ++counts.visible;
  const Rgb color = color_of(front.color_value + t * (back.color_value - front.color_value));
  return share_of(pixel, {value,
                          {color, opacity},
                          part.front_slope + t * (part.back_slope - part.front_slope),
                          std::lerp(part.front_clearance, part.back_clearance, t),
                          {std::lerp(part.front_light.around, part.back_light.around, t),
                           std::lerp(part.front_light.key, part.back_light.key, t)},
                          z,
                          length * pixel.ray.direction.norm()});
}

// In as many steps as the one of them needs that needs most.
void PixelTracer::add_parts(const PixelRay& pixel, const std::vector<PiecePart>& parts,
                            Pixel& result, TraceCounts& counts) const {
  int steps = 1;
  for (const PiecePart& part : parts) steps = std::max(steps, part.steps);
  for (int m = 0; m < steps && result.rgba[3] < parts.front().of.owner->opaque_at_; ++m) {
    std::vector<Share> shares;
    for (const PiecePart& part : parts) {
      if (const auto share = part.of.owner->share_of_step(pixel, part, m, steps, counts))
        shares.push_back({share->color, share->opacity, share->z, part.of.owner == this});
    }
    add_shares(shares, result);
  }
}

Pixel PixelTracer::refined(const PixelRay& pixel, TraceCounts& counts) const {
  Pixel result;
  std::vector<std::optional<RaySample>> before(all_.size());
  for (std::int64_t k = pixel.sheets.first; k <= pixel.sheets.last + 1; ++k) {
    if (result.rgba[3] >= opaque_at_) break;
    std::vector<OwnedPiece> pieces;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      const std::optional<RaySample> at = all_[i]->sample(pixel, k, counts);
      if (before[i] || at) pieces.push_back({all_[i], {k, before[i], at}});
      before[i] = at;
    }
    add_pieces(pixel, pieces, result, counts);
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
