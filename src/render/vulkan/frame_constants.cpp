// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/frame_constants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "render/shared/look_nodes.h"
#include "render/shared/slab_nodes.h"

namespace ovoid::vulkan {
namespace {

device::vec4 vector(const Vec3& v, double w = 0) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()),
          static_cast<float>(w)};
}

// What is left of a number once it has been rounded to a float.
device::vec4 rest_of(const Vec3& v) {
  const auto rest = [](double x) { return x - static_cast<double>(static_cast<float>(x)); };
  return vector(Vec3(rest(v.x()), rest(v.y()), rest(v.z())));
}

device::vec4 along(const Vec3& v, const view::SheetMap& map) {
  return vector(Vec3(v.dot(map.origin), v.dot(map.per_x), v.dot(map.per_y)));
}

std::uint32_t append(Tables& tables, std::span<const float> numbers) {
  const auto at = static_cast<std::uint32_t>(tables.size());
  tables.resize(tables.size() + (numbers.size() + 3) / 4);
  std::copy(numbers.begin(), numbers.end(), &tables[at].x);
  return at;
}

device::TableConstants table_constants(const view::LookTable& table, double path_in_units,
                                       Tables& tables) {
  const view::LookAxis& axis = table.axis();
  device::TableConstants out{};
  out.scale = static_cast<std::uint32_t>(axis.scale);
  out.origin = axis.origin;
  out.origin_bits = axis.origin_bits;
  out.cells_per_step = axis.cells_per_step;
  out.inverse_width = axis.inverse_width;
  const VisibleValues visible = visible_values(table);
  out.visible_lo = visible.lo;
  out.visible_hi = visible.hi;
  out.nodes_at = append(tables, classification_nodes(table, path_in_units));
  out.steps_at = device::kNoTable;
  if (table.has_steps())
    out.steps_at = 4 * append(tables, {table.step(), view::LookTable::kPaddedNodes});
  return out;
}

device::vec4 vector(const std::array<float, 4>& v) { return {v[0], v[1], v[2], v[3]}; }

}  // namespace

device::ViewConstants view_constants(const view::FramePlan& plan, const RenderOptions& options) {
  const view::ViewLattice& lattice = plan.lattice;
  const std::int64_t first = plan.sheets.first;
  device::ViewConstants out{};
  const view::SheetMap map = lattice.world_map(0);
  // A sheet behind the eye is mirrored.
  const double sign = lattice.is_parallel() || lattice.depth(0) > 0 ? 1.0 : -1.0;
  const Vec3 right = map.per_x.normalized() * sign;
  const Vec3 up = -map.per_y.normalized() * sign;
  const view::SheetMap ray = lattice.ray_direction();
  out.right = vector(right);
  out.up = vector(up);
  out.axis = vector(lattice.view_axis());
  out.ray[0] = vector(ray.origin);
  out.ray[1] = vector(ray.per_x);
  out.ray[2] = vector(ray.per_y);
  out.slope_right = along(right, ray);
  out.slope_up = along(up, ray);
  for (std::size_t i = 0; i < plan.clip_planes.size(); ++i) {
    const view::ClipMap here = plan.clip_distance(plan.clip_planes[i], first);
    const view::ClipMap next = plan.clip_distance(plan.clip_planes[i], first + 1);
    out.clips[i].at_first = vector(Vec3(here.origin, here.per_x, here.per_y));
    out.clips[i].per_sheet =
        vector(Vec3(next.origin - here.origin, next.per_x - here.per_x, next.per_y - here.per_y));
  }
  out.width = static_cast<std::uint32_t>(options.width);
  out.height = static_cast<std::uint32_t>(options.height);
  out.num_sheets = static_cast<std::int32_t>(std::max<std::int64_t>(plan.sheets.last - first, 0));
  out.num_clips = static_cast<std::uint32_t>(plan.clip_planes.size());
  out.sampling_distance = static_cast<float>(lattice.sampling_distance());
  out.first_depth = static_cast<float>(lattice.depth(first));
  out.near_cut = lattice.is_parallel()
                     ? -std::numeric_limits<float>::infinity()
                     : static_cast<float>((lattice.near_depth() - lattice.depth(first)) /
                                          lattice.sampling_distance());
  out.pitch = static_cast<float>(lattice.pitch(first));
  out.pitch_per_sheet = static_cast<float>(lattice.pitch(first + 1) - lattice.pitch(first));
  return out;
}

device::LookConstants look_constants(const view::FramePlan& plan, const Look& look,
                                     const ValueRange& range, Tables& tables) {
  device::LookConstants out{};
  const double path_in_units = plan.lattice.sampling_distance() / plan.unit_distance;
  const bool corrects_late =
      look.mode == Mode::kComposite && (plan.is_preintegrated || plan.fading.has_value());
  out.look = table_constants(plan.look_table, corrects_late ? 1.0 : path_in_units, tables);
  if (plan.color_table) out.color = table_constants(*plan.color_table, 1.0, tables);
  if (plan.fading) out.fading = table_constants(*plan.fading, 1.0, tables);
  if (plan.is_preintegrated) {
    const IntegralNodes integrals = integral_nodes(plan.look_table);
    out.integrals_at = append(tables, integrals.nodes);
    out.integral_per_value = integrals.per_value;
    out.integral_lo = integrals.value_lo;
    out.integral_hi = integrals.value_hi;
    out.integrals_before = vector(integrals.before);
    out.integrals_behind = vector(integrals.behind);
  }
  const Rgb color = look.transfer_function.color_at(look.isovalue);
  out.isosurface_color = vector(Vec3(color[0], color[1], color[2]));
  out.has_headlight = look.light_direction ? 0 : 1;
  if (look.light_direction) out.light = vector(look.light_direction->normalized());
  out.ambient = static_cast<float>(look.material.ambient);
  out.diffuse = static_cast<float>(look.material.diffuse);
  out.specular = static_cast<float>(look.material.specular);
  out.specular_power = static_cast<float>(look.material.specular_power);
  out.flat_gradient_inverse = flat_gradient_inverse(look, range, plan.least_spacing);
  out.path_in_units = static_cast<float>(path_in_units);
  out.isovalue = static_cast<float>(look.isovalue);
  return out;
}

device::LatticeConstants lattice_constants(const LatticeField& field, const view::LatticePlan& plan,
                                           const RenderOptions& options) {
  device::LatticeConstants out{};
  const LatticeGeometry& geometry = field.geometry();
  const view::SheetMap here = plan.lattice.index_map(plan.sheets.first);
  const view::SheetMap next = plan.lattice.index_map(plan.sheets.first + 1);
  const Vec3 places[3] = {here.origin, here.per_x, here.per_y};
  const Vec3 steps[3] = {next.origin - here.origin, next.per_x - here.per_x,
                         next.per_y - here.per_y};
  const Mat3 gradient = geometry.world_from_index.linear().inverse().transpose();
  for (int i = 0; i < 3; ++i) {
    out.place_hi[i] = vector(places[i]);
    out.place_lo[i] = rest_of(places[i]);
    out.step_hi[i] = vector(steps[i]);
    out.step_lo[i] = rest_of(steps[i]);
    out.gradient_rows[i] = vector(gradient.row(i).transpose());
  }
  const view::SheetMap map = plan.lattice.world_map(0);
  Mat3 camera;
  camera.row(0) = map.per_x.normalized();
  camera.row(1) = map.per_y.normalized();
  camera.row(2) = plan.lattice.view_axis();
  const Mat3 camera_from_index = camera * geometry.world_from_index.linear();
  const Mat3 index_from_camera = camera_from_index.inverse();
  for (int r = 0; r < 3; ++r) {
    out.camera_rows[r] = vector(camera_from_index.row(r).transpose());
    out.camera_columns[r] = vector(index_from_camera.row(r).cwiseAbs().transpose());
  }
  out.inverse_spacing = vector(geometry.spacing().cwiseInverse());
  out.widening_limit = vector(plan.widening_limit());
  // Rounding slack; the sums decide exactly.
  out.support_lo = vector(plan.index_support.min() - Vec3::Constant(1e-3));
  out.support_hi = vector(plan.index_support.max() + Vec3::Constant(1e-3));
  const Index3& bricks = plan.relevance.num_bricks();
  out.num_bricks = {static_cast<std::int32_t>(bricks[0]), static_cast<std::int32_t>(bricks[1]),
                    static_cast<std::int32_t>(bricks[2]), plan.relevance.brick_shift()};
  for (int s = 0; s < geometry.num_sublattices(); ++s) {
    const Index3 dims = geometry.dims_of(s);
    out.dims[s] = {static_cast<std::int32_t>(dims[0]), static_cast<std::int32_t>(dims[1]),
                   static_cast<std::int32_t>(dims[2]), 0};
    const auto offset = static_cast<float>(geometry.offset_of(s)[0]);
    (s == 0 ? out.sublattice_offset.x : out.sublattice_offset.y) = offset;
  }
  const LatticeKernel kernel = field.index_kernel();
  const double inverse_variance = 1 / (kernel.sigma * kernel.sigma);
  out.sigma = static_cast<float>(kernel.sigma);
  out.support = static_cast<float>(kernel.support_radius());
  out.inverse_variance = static_cast<float>(inverse_variance);
  out.sum_weight = static_cast<float>(
      1.0 / (geometry.density() * std::pow(2 * std::numbers::pi, 1.5) * std::pow(kernel.sigma, 3)));
  out.near_weight = static_cast<float>(std::exp(-0.5 * inverse_variance));
  out.far_weight = static_cast<float>(std::exp(-2.0 * inverse_variance));
  out.value_scale = static_cast<float>(field.source().value_scale());
  out.value_offset = static_cast<float>(field.source().value_offset());
  out.num_slab_nodes = 1;
  if (options.slab == Slab::kMean) {
    const SlabNodes slab = slab_nodes(field, plan.lattice);
    out.num_slab_nodes = slab.count;
    for (std::size_t i = 0; i < slab.nodes.size(); i += 2) {
      out.slab[i / 2] = {slab.nodes[i].offset, slab.nodes[i].weight, slab.nodes[i + 1].offset,
                         slab.nodes[i + 1].weight};
    }
  }
  return out;
}

std::uint32_t frame_flags(const view::FramePlan& plan, const Look& look,
                          const RenderOptions& options) {
  const bool is_composite = look.mode == Mode::kComposite;
  const bool fades = is_composite && plan.fading.has_value();
  const bool is_lit = look.shade && (is_composite || look.mode == Mode::kIsosurface);
  const bool takes_gradients = is_composite && (look.shade || fades);
  std::uint32_t flags = 0;
  const auto set = [&](bool is_set, std::uint32_t flag) { flags |= is_set ? flag : 0; };
  set(plan.lattice.is_parallel(), device::kIsParallel);
  set(plan.is_clipped, device::kIsClipped);
  set(is_lit, device::kShades);
  set(plan.is_preintegrated, device::kTakesPieces);
  set(fades, device::kFades);
  set(takes_gradients, device::kTakesGradients);
  const bool takes_differences =
      options.gradient == GradientMethod::kCentral || options.spread == Spread::kBilinear;
  set(takes_gradients && takes_differences, device::kTakesDifferences);
  set(options.spread == Spread::kBilinear, device::kSpreads);
  set(options.post_convolution == PostConvolution::kAuto, device::kNodesKeepBound);
  set(options.stop_opaque, device::kStopsOpaque);
  set(plan.color_table.has_value(), device::kHasOwnColor);
  return flags;
}

std::uint32_t lattice_flags(const LatticeField& field, const RenderOptions& options,
                            bool may_miss) {
  const LatticeKernel kernel = field.index_kernel();
  const bool is_sum = field.reconstruction() == Reconstruction::kSum;
  const bool is_mean = options.slab == Slab::kMean;
  const bool is_double = field.geometry().num_sublattices() > 1;
  const bool has_four_taps = !is_double && static_cast<float>(kernel.support_radius()) == 2.0F &&
                             kernel.sigma >= 0.25 && kernel.sigma <= 2 && !is_sum && !is_mean;
  std::uint32_t flags = 0;
  const auto set = [&](bool is_set, std::uint32_t flag) { flags |= is_set ? flag : 0; };
  set(is_sum, device::kIsSum);
  set(is_mean, device::kTakesMeans);
  set(has_four_taps, device::kHasFourTaps);
  set(options.gradient != GradientMethod::kExact && !is_sum, device::kCorrects);
  set(may_miss, device::kMayMiss);
  set(is_double, device::kIsDouble);
  return flags;
}

std::uint32_t mode_number(Mode mode) {
  switch (mode) {
    case Mode::kComposite:
      return device::kComposite;
    case Mode::kXray:
      return device::kXray;
    case Mode::kMaximum:
      return device::kMaximum;
    case Mode::kMean:
      return device::kMean;
    case Mode::kIsosurface:
      break;
  }
  return device::kIsosurface;
}

std::uint32_t type_number(ScalarType type) {
  switch (type) {
    case ScalarType::kUInt8:
      return device::kTypeU8;
    case ScalarType::kInt8:
      return device::kTypeI8;
    case ScalarType::kUInt16:
      return device::kTypeU16;
    case ScalarType::kInt16:
      return device::kTypeI16;
    default:
      return device::kTypeF32;
  }
}

}  // namespace ovoid::vulkan
