// SPDX-License-Identifier: Apache-2.0
#include "render/reference/lattice_tracer.h"

#include <algorithm>
#include <cmath>

namespace ovoid::reference {
namespace {

// docs/numerics.md, "Post-convolution".
constexpr std::int64_t kSheetsOfOnePitch = 16;
constexpr double kLeastNodeStep = 1.45;  // pixels
constexpr double kGreatestNodeStep = 64;

// The last of the group of sheets that a sheet belongs to.
std::int64_t rearmost_of_group(std::int64_t sheet) {
  const std::int64_t place = sheet % kSheetsOfOnePitch;  // of the sign of `sheet`
  const std::int64_t first = sheet - place - (place < 0 ? kSheetsOfOnePitch : 0);
  return first + kSheetsOfOnePitch - 1;
}

}  // namespace

LatticeTracer::LatticeTracer(const LatticeField& field, const FieldEvaluator& evaluator,
                             const Camera& camera, const Look& look, const RenderOptions& options,
                             const BesideTracer& beside, const view::BasePlane* base,
                             const view::LightVolume* light)
    : PixelTracer(field, ViewRays(field, camera, options, base), look, options, beside, light),
      evaluator_(evaluator),
      slab_(options.slab),
      gradient_method_(options.spread == Spread::kBilinear ? GradientMethod::kCentral
                                                           : options.gradient),
      ends_at_faces_(field.reconstruction() == Reconstruction::kNormalized),
      has_nodes_(is_published(options.post_convolution)),
      way_(options.post_convolution),
      spread_(options.spread),
      index_from_world_(field.geometry().world_from_index.inverse()),
      world_from_index_(field.geometry().world_from_index),
      kernel_(field.index_kernel()),
      node_distance_(field.geometry().unit_spacing()),
      support_(evaluator.support_bounds(view().greatest_widening())),
      faces_(field.geometry().index_bounds()) {}

SheetRange LatticeTracer::sheets_of(const Ray& ray) const {
  return view().sheets_within(ray, support_);
}

// The sample of a sheet, if there is one.
std::optional<LatticeTracer::RaySample> LatticeTracer::sample(const PixelRay& pixel,
                                                              std::int64_t sheet,
                                                              TraceCounts& counts) const {
  if (!view().exists(sheet)) return std::nullopt;
  const double path = view().path(pixel.ray, sheet);
  if (!(path > 0) && !is_refined()) return std::nullopt;
  ++counts.samples;
  const double z = view().z_of(sheet);
  if (const std::optional<double> node_step = node_step_on(sheet)) {
    const FieldSample at = value_from(nodes_around(pixel, sheet, *node_step));
    if (at.is_defined) return RaySample{sheet, z, path, at.value, at.value, Vec3::Zero(), true};
  }
  const FieldSample at = field_at({1.0 * pixel.x, 1.0 * pixel.y, sheet});
  if (!at.is_defined) return std::nullopt;
  return RaySample{sheet, z, path, at.value, at.value, at.gradient};
}

// A piece is of one layer: that of the sheet at which it ends.
PixelTracer::RaySample LatticeTracer::front_end(const PixelRay& pixel, const RaySample& before,
                                                const RaySample& at) const {
  RaySample front = before;
  if (at.is_from_nodes) {
    const FieldSample there =
        value_from(nodes_around(pixel, before.sheet, *node_step_on(at.sheet)));
    if (there.is_defined) front.value = front.color_value = there.value;
  } else if (before.is_from_nodes) {
    front.value = front.color_value = field_at({1.0 * pixel.x, 1.0 * pixel.y, before.sheet}).value;
  }
  return front;
}

ZRange LatticeTracer::range_of(const PixelRay& pixel, const Piece& piece) const {
  if (ends_at_faces_ && !(piece.front && piece.back)) {
    const ZRange whole{view().z_of(piece.sheet - 1), view().z_of(piece.sheet)};
    const Vec3 undefined_end = index_from_world_ * pixel.ray.at(piece.front ? whole.hi : whole.lo);
    if (!faces_.contains(undefined_end)) {
      const ZRange inside = view().inside(pixel.ray, faces_);
      return {std::max(whole.lo, inside.lo), std::min(whole.hi, inside.hi)};
    }
  }
  return PixelTracer::range_of(pixel, piece);
}

// None if every pixel of the sheet is worked out by itself.
std::optional<double> LatticeTracer::node_step_on(std::int64_t sheet) const {
  if (!has_nodes_) return std::nullopt;
  const double pixel_step = view().pixel_step(rearmost_of_group(sheet));
  const double node_step = std::min(node_distance_ / pixel_step, kGreatestNodeStep);
  if (!(node_step >= kLeastNodeStep)) return std::nullopt;
  return node_step;
}

LatticeTracer::Nodes LatticeTracer::nodes_around(const PixelRay& pixel, std::int64_t sheet,
                                                 double node_step) const {
  return {node_step, taps_at(way_, pixel.x / node_step), taps_at(way_, pixel.y / node_step), sheet};
}

// Undefined if one of the nodes is, whether it has weight or not.
FieldSample LatticeTracer::value_from(const Nodes& nodes) const {
  FieldSample sum;
  for (std::size_t j = 0; j < nodes.y.weight.size(); ++j) {
    for (std::size_t i = 0; i < nodes.x.weight.size(); ++i) {
      const FieldSample node = node_at(nodes.place(i, j));
      if (!node.is_defined) return {};
      sum.value += nodes.x.weight[i] * nodes.y.weight[j] * node.value;
    }
  }
  sum.is_defined = true;
  return sum;
}

Vec3 LatticeTracer::gradient_from(const Nodes& nodes) const {
  Vec3 sum = Vec3::Zero();
  for (std::size_t j = 0; j < nodes.y.weight.size(); ++j) {
    for (std::size_t i = 0; i < nodes.x.weight.size(); ++i) {
      const double weight = nodes.x.weight[i] * nodes.y.weight[j];
      if (weight != 0) sum += weight * node_gradient(nodes.place(i, j));
    }
  }
  return sum;
}

FieldSample LatticeTracer::node_at(const Place& place) const {
  return spread_ == Spread::kBilinear ? spread_at(place) : field_at(place);
}

// Samples shared among the nodes around them: docs/numerics.md, "Spread".
FieldSample LatticeTracer::spread_at(const Place& place) const {
  const Mat3 axes = view().camera_axes();  // rows: right, down, view axis
  const double z = view().z_of(place.sheet);
  const Vec3 node = view().ray(place.x, place.y).at(z);
  const double distance = place.step * view().pitch_at(z);  // of neighbours
  const double tau = kernel_.sigma * (axes.row(2) * world_from_index_.linear()).norm();
  const Vec3 reach(distance, distance, kernel_.cutoff * tau);
  Bounds3 box;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 sides(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    box.extend(index_from_world_ * (node + axes.transpose() * sides.cwiseProduct(reach)));
  }
  return evaluator_.mean_under(box, [&](const Vec3& index) {
    const Vec3 d = axes * (world_from_index_ * index - node);
    const double a = std::abs(d[0]) / distance;
    const double b = std::abs(d[1]) / distance;
    if (a > 1 || b > 1 || std::abs(d[2]) > reach[2]) return 0.0;
    return (1 - a) * (1 - b) * std::exp(-0.5 * d[2] * d[2] / (tau * tau));
  });
}

// Central differences between nodes, or the kernels' own gradient.
Vec3 LatticeTracer::node_gradient(const Place& place) const {
  if (gradient_method_ == GradientMethod::kCentral) return central_gradient(place);
  const Vec3 widening = view().widening(place.sheet);
  const Vec3 position = view().ray(place.x, place.y).at(view().z_of(place.sheet));
  return own_gradient(field_at(place).gradient, position, widening);
}

// The field on a place of the view lattice.
FieldSample LatticeTracer::field_at(const Place& place) const {
  return field_on_ray(view().ray(place.x, place.y), view().z_of(place.sheet),
                      view().widening(place.sheet));
}

// The field where a ray meets the plane at z, or its mean over the slab around that plane.
FieldSample LatticeTracer::field_on_ray(const Ray& ray, double z, const Vec3& widening) const {
  if (slab_ != Slab::kMean) return evaluator_.at_index(index_from_world_ * ray.at(z), widening);
  const double half_slab = 0.5 * view().sampling_distance();
  return evaluator_.mean_over(index_from_world_ * ray.at(z - half_slab),
                              index_from_world_ * ray.at(z + half_slab), widening);
}

Vec3 LatticeTracer::gradient(const PixelRay& pixel, const RaySample& sample) const {
  const Place place{1.0 * pixel.x, 1.0 * pixel.y, sample.sheet};
  const bool is_central = gradient_method_ == GradientMethod::kCentral;
  // The field's own, of what would be a piece if it had a front end.
  const bool is_piece = is_preintegrated() && !is_central;
  if (sample.is_from_nodes && !is_piece)
    return gradient_from(nodes_around(pixel, sample.sheet, *node_step_on(sample.sheet)));
  if (is_central) return central_gradient(place);
  const Vec3 exact = sample.is_from_nodes ? field_at(place).gradient : sample.exact_gradient;
  return own_gradient(exact, pixel.ray.at(sample.z), view().widening(sample.sheet));
}

// Half-way between two sheets, of the field itself; central differences are the second one's.
Vec3 LatticeTracer::piece_gradient(const PixelRay& pixel, const RaySample& from,
                                   const RaySample& to) const {
  if (gradient_method_ == GradientMethod::kCentral) return gradient(pixel, to);
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

// Differences between a place and its neighbours: nodes if it is one, else pixels.
Vec3 LatticeTracer::central_gradient(const Place& place) const {
  const bool is_node = place.step > 1;
  const auto value_at = [&](double dx, double dy, std::int64_t dk) {
    const Place there{place.x + place.step * dx, place.y + place.step * dy, place.sheet + dk,
                      place.step};
    return is_node ? node_at(there) : field_at(there);
  };
  const auto difference = [&](int dx, int dy, int dk) -> double {
    const FieldSample before = value_at(-dx, -dy, -dk);
    const FieldSample behind = value_at(dx, dy, dk);
    if (before.is_defined && behind.is_defined) return 0.5 * (behind.value - before.value);
    if (before.is_defined) return value_at(0, 0, 0).value - before.value;
    if (behind.is_defined) return behind.value - value_at(0, 0, 0).value;
    return 0;
  };
  const Vec3 differences(difference(1, 0, 0), difference(0, 1, 0), difference(0, 0, 1));
  Mat3 derivatives = view().position_derivatives(view().ray(place.x, place.y), place.sheet);
  derivatives.leftCols<2>() *= place.step;
  return derivatives.transpose().inverse() * differences;
}

PixelTracer::Crossing LatticeTracer::crossing(const PixelRay& pixel, const RaySample& near,
                                              const RaySample& far, double isovalue) const {
  Crossing at{refined_crossing(pixel, near, far, isovalue), isovalue, Vec3::Zero()};
  if (!look().shade) return at;
  const Vec3 widening = view().widening(far.sheet);
  const FieldSample there = field_on_ray(pixel.ray, at.z, widening);
  at.gradient = own_gradient(there.gradient, pixel.ray.at(at.z), widening);
  return at;
}

// Where between two neighbouring sheets the field on the ray meets the isovalue: docs/numerics.md,
// "Modes".
double LatticeTracer::refined_crossing(const PixelRay& pixel, const RaySample& near,
                                       const RaySample& far, double isovalue) const {
  constexpr int kNumBisections = 8;
  const Vec3 widening = view().widening(far.sheet);
  double z_near = near.z;
  double z_far = far.z;
  double f_near = near.value;
  double f_far = far.value;
  bool far_is_defined = true;
  for (int step = 0; step < kNumBisections; ++step) {
    const double z_middle = 0.5 * (z_near + z_far);
    const FieldSample middle = field_on_ray(pixel.ray, z_middle, widening);
    if (middle.is_defined && (middle.value < isovalue) == (near.value < isovalue)) {
      z_near = z_middle;
      f_near = middle.value;
    } else {
      z_far = z_middle;
      f_far = middle.value;
      far_is_defined = middle.is_defined;
    }
  }
  if (!far_is_defined) return z_near;
  return z_near + (isovalue - f_near) / (f_far - f_near) * (z_far - z_near);
}

}  // namespace ovoid::reference
