// SPDX-License-Identifier: Apache-2.0
#include "render/lattice_sheets.h"

#include <algorithm>
#include <string>
#include <vector>

#include "ovoid/error.h"
#include "render/features.h"
#include "view/plan/frame_plan.h"

namespace ovoid {
namespace {

// Of a base plane that nobody insists on: each takes 20 bytes beside the picture's own.
constexpr double kMostSamples = 1 << 26;

// Why a frame cannot have them, whatever its view; empty if it can.
std::string reason_against(const BackEnd& back_end, const FrameJob& job) {
  const RenderOptions& options = job.options;
  if (!draws(back_end.kind(), Feature::kLatticeSheets)) return "backend vulkan has image sheets";
  if (job.field.lattice() == nullptr) return "the field is a set of kernels";
  if (job.trail != nullptr) return "a trail is drawn on image sheets";
  if (options.depth_limits != nullptr) return "depth limits are those of the picture's own pixels";
  if (is_published(options.post_convolution))
    return "the published ways of post-convolution are for image sheets";
  if (options.evaluate == Evaluate::kScatter) return "kernels are scattered to image sheets";
  if (options.gradient == GradientMethod::kCentral && job.look.mode == Mode::kComposite)
    return "central differences are taken on image sheets";
  return {};
}

// True if samples share their weights, which is what makes lattice sheets faster.
bool samples_share_weights(const LatticeField& field) {
  const LatticeKernel kernel = field.index_kernel();
  return field.geometry().num_sublattices() == 1 && kernel.support_radius() == 2.0 &&
         kernel.sigma >= 0.25 && kernel.sigma <= 2.0;
}

// True if a body-centred lattice has fewer samples to sum than on image sheets, or of fewer
// kernels: in pictures so small that kernels would be widened, and in those so large that samples
// are interpolated.
bool saves_samples(const LatticeField& field, const view::BasePlane& base, const FrameJob& job) {
  constexpr double kSmall = 1.2;  // samples per spacing
  if (field.geometry().num_sublattices() == 1 || !job.further.empty()) return false;
  return base.samples_per_spacing < kSmall ||
         view::first_samples_apart(base, steepness_of(job), job.look.mode, job.options) > 1;
}

// The lattice whose planes the sheets of a frame are parallel to: the one with the smallest
// spacing.
const LatticeField& finest_lattice(const FrameJob& job) {
  const LatticeField* finest = job.field.lattice();
  for (const FurtherVolume& volume : job.further) {
    if (volume.field.default_sampling_distance() < finest->default_sampling_distance())
      finest = &volume.field;
  }
  return *finest;
}

// Corners of what all but one of a frame's volumes can show, world.
std::vector<Vec3> corners_of_others(const FrameJob& job, const LatticeField& one, double reach) {
  std::vector<Vec3> corners;
  const auto add = [&](const LatticeField& field) {
    if (&field == &one) return;
    const Bounds3 box = view::support_of(field, 1.0, reach);
    for (int i = 0; i < 8; ++i) {
      corners.emplace_back(field.geometry().world_from_index *
                           box.corner(static_cast<Bounds3::CornerType>(i)));
    }
  };
  add(*job.field.lattice());
  for (const FurtherVolume& volume : job.further) add(volume.field);
  return corners;
}

// Whether samples of the base plane are dense enough for all volumes.
bool is_dense_enough(const view::BasePlane& base, const FrameJob& job) {
  constexpr double kMost = view::kMostSpacings * (1 + 1e-9);
  const auto is_dense = [&](const LatticeField& field) {
    return view::plane_for(base, field.geometry()).samples_apart <= kMost;
  };
  return is_dense(*job.field.lattice()) &&
         std::all_of(job.further.begin(), job.further.end(),
                     [&](const FurtherVolume& volume) { return is_dense(volume.field); });
}

bool are_gentle(const FrameJob& job) {
  return view::is_gentle(job.look, job.field.value_range()) &&
         std::all_of(job.further.begin(), job.further.end(), [](const FurtherVolume& volume) {
           return view::is_gentle(volume.look, volume.field.value_range());
         });
}

}  // namespace

double steepness_of(const FrameJob& job) {
  double steepest = view::steepness_of(job.look, job.field.value_range());
  for (const FurtherVolume& volume : job.further) {
    steepest = std::max(steepest, view::steepness_of(volume.look, volume.field.value_range()));
  }
  return steepest;
}

std::optional<LatticeSheets> lattice_sheets_for(const BackEnd& back_end, const FrameJob& job,
                                                bool is_distance_free) {
  const RenderOptions& options = job.options;
  if (options.sheets == Sheets::kImage) return std::nullopt;
  const bool must = options.sheets == Sheets::kLattice;
  if (const std::string reason = reason_against(back_end, job); !reason.empty()) {
    if (must) throw Error(ErrorCode::kUnsupported, "sheets: lattice: " + reason);
    return std::nullopt;
  }
  const LatticeField& field = finest_lattice(job);
  if (!must &&
      (field.reconstruction() != Reconstruction::kNormalized || options.slab == Slab::kMean))
    return std::nullopt;
  const double reach = options.slab == Slab::kMean
                           ? options.sampling_distance / field.geometry().spacing().minCoeff()
                           : 0.0;
  std::optional<view::BasePlane> base =
      view::base_plane(field, view::support_of(field, 1.0, reach), job.camera, options,
                       corners_of_others(job, field, reach));
  if (base && !job.further.empty() && !is_dense_enough(*base, job)) base.reset();
  if (!base) {
    if (must)
      throw Error(ErrorCode::kUnsupported,
                  "sheets: lattice: needs a camera in front of the whole volume whose rays are "
                  "within 60 degrees of the normal of the lattice's planes, and not far larger a "
                  "picture on these than the one that is seen: take auto or image");
    return std::nullopt;
  }
  if (!must && (static_cast<double>(base->width) * base->height > kMostSamples ||
                !(samples_share_weights(field) || saves_samples(field, *base, job))))
    return std::nullopt;
  const bool is_wide = is_distance_free && view::is_refined(job.look, options) && are_gentle(job);
  const double distance =
      options.sampling_distance * base->closeness * (is_wide ? view::kGentleDistance : 1.0);
  return LatticeSheets{*base, distance};
}

}  // namespace ovoid
