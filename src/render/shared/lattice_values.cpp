// SPDX-License-Identifier: Apache-2.0
#include "render/shared/lattice_values.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "data/kernels/kernel_weight.h"
#include "render/shared/device_vectors.h"

namespace ovoid {
namespace {

// Gauss-Legendre points on [-1/2, 1/2], by Newton's method on the Legendre polynomials.
void set_slab(int count, device::LatticeConstants& out) {
  out.num_slab_points = count;
  for (int i = 0; i < count; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5));
    double slope = 1;
    for (int step = 0; step < 20; ++step) {
      double p = 1;
      double before = 0;
      for (int n = 0; n < count; ++n) {
        const double next = ((2 * n + 1) * x * p - n * before) / (n + 1);
        before = p;
        p = next;
      }
      slope = count * (x * p - before) / (x * x - 1);
      x -= p / slope;
    }
    out.slab[i] = {static_cast<float>(x / 2),
                   static_cast<float>(1 / ((1 - x * x) * slope * slope))};
  }
}

// Enough points for the slab's mean to err by less than the agreement tier allows: four per two
// sigmas of the narrowest kernel.
int num_slab_points(const LatticeField& field, const view::ViewLattice& lattice) {
  double longest = 0;  // slab in index units
  const view::SheetMap here = lattice.index_map(0);
  const view::SheetMap next = lattice.index_map(1);
  for (const double x : {0.0, lattice.width() - 1.0}) {
    for (const double y : {0.0, lattice.height() - 1.0}) {
      longest = std::max(longest, (next.at(x, y) - here.at(x, y)).norm());
    }
  }
  return std::clamp(2 + static_cast<int>(std::ceil(2 * longest / field.index_kernel().sigma)), 4,
                    device::kMaxSlabPoints);
}

// What is left of a number once it has been rounded to a float.
device::vec4 rest_of(const Vec3& v) { return device_vector(v - v.cast<float>().cast<double>()); }

void set_place(const view::LatticePlan& plan, device::LatticeConstants& out) {
  const view::SheetMap here = plan.lattice.index_map(plan.sheets.first);
  const view::SheetMap next = plan.lattice.index_map(plan.sheets.first + 1);
  const Vec3 places[3] = {here.origin, here.per_x, here.per_y};
  const Vec3 steps[3] = {next.origin - here.origin, next.per_x - here.per_x,
                         next.per_y - here.per_y};
  for (int i = 0; i < 3; ++i) {
    out.place_hi[i] = device_vector(places[i]);
    out.place_lo[i] = rest_of(places[i]);
    out.step_hi[i] = device_vector(steps[i]);
    out.step_lo[i] = rest_of(steps[i]);
  }
  out.widening_limit = device_vector(plan.widening_limit());
  // Rounding slack; the sums decide exactly.
  out.support_lo = device_vector(plan.index_support.min() - Vec3::Constant(1e-3));
  out.support_hi = device_vector(plan.index_support.max() + Vec3::Constant(1e-3));
  const Index3& bricks = plan.relevance.num_bricks();  // in the field's own order
  out.num_bricks = {static_cast<std::int32_t>(bricks[0]), static_cast<std::int32_t>(bricks[1]),
                    static_cast<std::int32_t>(bricks[2]), plan.relevance.brick_shift()};
}

void set_axes(const LatticeGeometry& geometry, const view::LatticePlan& plan,
              device::LatticeConstants& out) {
  Mat3 world_from_index;
  for (int a = 0; a < 3; ++a)
    world_from_index.col(a) =
        geometry.world_from_index.linear().col(plan.order[static_cast<std::size_t>(a)]);
  const Mat3 gradient = world_from_index.inverse().transpose() / plan.gradient_unit;
  const view::SheetMap map = plan.lattice.world_map(0);
  Mat3 camera;
  camera.row(0) = map.per_x.normalized();
  camera.row(1) = map.per_y.normalized();
  camera.row(2) = plan.lattice.view_axis();
  const Mat3 camera_from_index = camera * world_from_index;
  const Mat3 index_from_camera = camera_from_index.inverse();
  for (int r = 0; r < 3; ++r) {
    out.gradient_rows[r] = device_vector(gradient.row(r).transpose());
    out.camera_rows[r] = device_vector(camera_from_index.row(r).transpose());
    out.camera_columns[r] = device_vector(index_from_camera.row(r).cwiseAbs().transpose());
  }
  out.inverse_spacing =
      device_vector(view::in_order(geometry.spacing(), plan.order).cwiseInverse());
  out.faces_lo = device_vector(plan.faces.min());
  out.faces_hi = device_vector(plan.faces.max());
}

void set_kernel(const LatticeField& field, const view::AxisOrder& order,
                device::LatticeConstants& out) {
  const LatticeKernel kernel = field.index_kernel();
  const LatticeGeometry& geometry = field.geometry();
  out.sigma = static_cast<float>(kernel.sigma);
  out.support = static_cast<float>(kernel.support_radius());
  out.inverse_variance = 1.0F / (out.sigma * out.sigma);
  out.near_weight = std::exp(-0.5F * out.inverse_variance);
  out.far_weight = std::exp(-2.0F * out.inverse_variance);
  if (data::is_piecewise(kernel.kind)) {
    const data::KernelPieces pieces = data::pieces_of(kernel.kind);
    out.is_piecewise = 1;
    out.inner_piece = device_vector(pieces.inner);
    out.outer_piece = device_vector(pieces.outer);
    out.inverse_unit = static_cast<float>(1 / (2 * kernel.sigma));
  }
  out.sum_weight =
      static_cast<float>(1.0 / (geometry.density() * std::pow(data::axis_mass(kernel), 3)));
  out.value_scale = static_cast<float>(field.source().value_scale());
  out.value_offset = static_cast<float>(field.source().value_offset());
  out.num_sublattices = geometry.num_sublattices();
  for (int s = 0; s < out.num_sublattices; ++s) {
    device::Sublattice& own = out.sublattices[s];
    const Index3 dims = geometry.dims_of(s);
    for (std::size_t a = 0; a < 3; ++a)
      own.dims[a] = static_cast<std::int32_t>(dims[static_cast<std::size_t>(order[a])]);
    own.offset = static_cast<float>(geometry.offset_of(s)[0]);
  }
}

constexpr double kLeastCutoff = 3.99;  // sigmas: less than a thousandth of a kernel is cut off

// The bound of kAuto holds where the field is as smooth as its kernel, and the gradient is no
// difference of neighbours, which would be as far apart as nodes.
bool holds_bound(const LatticeField& field, const FrameTraits& frame) {
  const LatticeKernel kernel = field.index_kernel();
  return field.reconstruction() == Reconstruction::kNormalized && kernel.sigma >= 0.25 &&
         kernel.support_radius() >= kLeastCutoff * kernel.sigma && !frame.takes_differences;
}

}  // namespace

LatticeTraits lattice_traits(const LatticeField& field, const FrameTraits& frame,
                             const RenderOptions& options) {
  const LatticeKernel kernel = field.index_kernel();
  const auto support = static_cast<float>(kernel.support_radius());
  const bool is_double = field.geometry().num_sublattices() > 1;
  // Of two sublattices the kernels are narrower, and reach three of the taps.
  const bool fits_taps = is_double ? support <= 1.5F : support == 2.0F;
  const PostConvolution how = options.post_convolution;
  LatticeTraits traits;
  traits.is_sum = field.reconstruction() == Reconstruction::kSum;
  traits.is_piecewise = data::is_piecewise(kernel.kind);
  traits.takes_means = options.slab == Slab::kMean;
  traits.has_four_taps = fits_taps && kernel.sigma >= 0.25 && kernel.sigma <= 2.0 &&
                         !traits.is_sum && !traits.takes_means;
  traits.corrects_gradient =
      options.gradient != GradientMethod::kExact && !traits.is_sum && !traits.is_piecewise;
  traits.may_have_nodes =
      how != PostConvolution::kOff && (how != PostConvolution::kAuto || holds_bound(field, frame));
  return traits;
}

device::LatticeConstants lattice_constants(const LatticeField& field, const view::LatticePlan& plan,
                                           const LatticeTraits& traits) {
  device::LatticeConstants out{};
  set_place(plan, out);
  set_axes(field.geometry(), plan, out);
  set_kernel(field, plan.order, out);
  out.slab[0] = {0, 1};
  out.num_slab_points = 1;
  if (traits.takes_means) set_slab(num_slab_points(field, plan.lattice), out);
  return out;
}

}  // namespace ovoid
