// SPDX-License-Identifier: Apache-2.0
#include "render/shared/view_values.h"

#include <algorithm>
#include <limits>

#include "render/shared/device_vectors.h"

namespace ovoid {
namespace {

void set(float (&out)[3], const Vec3& v) {
  for (int a = 0; a < 3; ++a) out[a] = static_cast<float>(v[a]);
}

device::vec4 vector_of(const float (&v)[3]) { return {v[0], v[1], v[2], 0}; }

device::vec4 vector_of(const view::ClipMap& map) {
  return device_vector(Vec3(map.origin, map.per_x, map.per_y));
}

}  // namespace

FrameTraits frame_traits(const view::FramePlan& plan, const Look& look,
                         const RenderOptions& options) {
  const bool is_composite = look.mode == Mode::kComposite;
  const bool is_surface = look.mode == Mode::kIsosurface;
  FrameTraits traits;
  traits.opaque_at = static_cast<float>(options.opaque_at);
  traits.mode = look.mode;
  traits.is_parallel = plan.lattice.is_parallel();
  traits.is_clipped = plan.is_clipped || options.depth_limits != nullptr;
  traits.is_lit = look.shade && (is_composite || is_surface);
  traits.has_own_color = plan.color_table.has_value();
  traits.is_preintegrated = is_composite && plan.is_preintegrated;
  traits.is_refined = plan.is_refined;
  traits.has_pieces = traits.is_preintegrated || traits.is_refined || is_surface;
  traits.fades_by_gradient = is_composite && plan.is_faded;
  traits.takes_gradients = is_composite && (look.shade || traits.fades_by_gradient);
  traits.takes_differences =
      traits.takes_gradients &&
      (options.gradient == GradientMethod::kCentral || options.spread == Spread::kBilinear);
  traits.fades_at_cuts = plan.num_cut_faces > 0;
  traits.nodes_keep_bound = options.post_convolution == PostConvolution::kAuto;
  traits.corrects_late = traits.is_preintegrated || traits.is_refined || traits.fades_by_gradient;
  return traits;
}

FrameCamera frame_camera(const view::FramePlan& plan) {
  const view::ViewLattice& lattice = plan.lattice;
  FrameCamera camera;
  camera.sampling_distance = static_cast<float>(lattice.sampling_distance());
  camera.inverse_step = static_cast<float>(1 / (lattice.sampling_distance() * plan.gradient_unit));
  camera.ray = lattice.ray_direction();
  const view::SheetMap map = lattice.world_map(0);
  // A sheet behind the eye is mirrored.
  const double sign = lattice.is_parallel() || lattice.depth(0) > 0 ? 1.0 : -1.0;
  const Vec3 right = map.per_x.normalized() * sign;
  const Vec3 up = -map.per_y.normalized() * sign;
  set(camera.right, right);
  set(camera.up, up);
  set(camera.axis, lattice.view_axis());
  const auto slope_along = [&](const Vec3& v) {
    return view::ClipMap{v.dot(camera.ray.origin), v.dot(camera.ray.per_x),
                         v.dot(camera.ray.per_y)};
  };
  camera.slope_right = slope_along(right);
  camera.slope_up = slope_along(up);
  return camera;
}

device::ViewConstants view_constants(const view::FramePlan& plan, const RenderOptions& options) {
  const view::ViewLattice& lattice = plan.lattice;
  const FrameCamera camera = frame_camera(plan);
  const std::int64_t first = plan.sheets.first;
  device::ViewConstants out{};
  out.right = vector_of(camera.right);
  out.up = vector_of(camera.up);
  out.axis = vector_of(camera.axis);
  out.ray[0] = device_vector(camera.ray.origin);
  out.ray[1] = device_vector(camera.ray.per_x);
  out.ray[2] = device_vector(camera.ray.per_y);
  out.slope_right = vector_of(camera.slope_right);
  out.slope_up = vector_of(camera.slope_up);
  for (std::size_t i = 0; i < plan.clip_planes.size(); ++i) {
    const view::ClipMap here = plan.clip_distance(plan.clip_planes[i], first);
    const view::ClipMap next = plan.clip_distance(plan.clip_planes[i], first + 1);
    out.clips[i].at_first = vector_of(here);
    out.clips[i].per_sheet = vector_of(
        view::ClipMap{next.origin - here.origin, next.per_x - here.per_x, next.per_y - here.per_y});
  }
  out.width = static_cast<std::uint32_t>(options.width);
  out.height = static_cast<std::uint32_t>(options.height);
  out.num_sheets = static_cast<std::int32_t>(std::max<std::int64_t>(plan.sheets.last - first, 0));
  out.num_clips = static_cast<std::uint32_t>(plan.clip_planes.size());
  out.num_cut_faces = static_cast<std::uint32_t>(plan.num_cut_faces);
  out.clearance_per_length = static_cast<float>(1 / plan.least_spacing);
  out.sampling_distance = camera.sampling_distance;
  out.first_depth = static_cast<float>(lattice.depth(first));
  out.near_cut = lattice.is_parallel()
                     ? -std::numeric_limits<float>::infinity()
                     : static_cast<float>((lattice.near_depth() - lattice.depth(first)) /
                                          lattice.sampling_distance());
  out.pitch = static_cast<float>(lattice.pitch(first));
  out.opaque_at = static_cast<float>(options.opaque_at);
  out.pitch_per_sheet = static_cast<float>(lattice.pitch(first + 1) - lattice.pitch(first));
  out.gradient_pitch = static_cast<float>(lattice.pitch(first) * plan.gradient_unit);
  out.gradient_pitch_per_sheet =
      static_cast<float>((lattice.pitch(first + 1) - lattice.pitch(first)) * plan.gradient_unit);
  out.gradient_step = static_cast<float>(lattice.sampling_distance() * plan.gradient_unit);
  return out;
}

}  // namespace ovoid
