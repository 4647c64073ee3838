// SPDX-License-Identifier: Apache-2.0
// The values that a kernel set has in a frame, beside those of every frame (view_values.h).
#pragma once

#include "ovoid/field.h"
#include "render/shared/device_layout.h"
#include "view/plan/kernel_plan.h"

namespace ovoid {

// How the set's field is worked out in a frame.
struct KernelTraits {
  KernelProfile profile = KernelProfile::kGaussian;
  float cutoff = 4;
  bool is_sum = false;
  bool takes_means = false;     // of slabs
  int num_channels = 2;         // that are summed over splats: docs/numerics.md, "Kernel sets"
  int max_level = 0;            // the coarsest; 0: post-convolution is off
  float least_level_sigma = 1;  // samples of a level
  bool gathers = false;         // fragment-centric
  // Sums are undefined where no kernel reaches. What the filter carries from coarse levels beyond
  // the kernels' cuts would say otherwise, so it is found for each pixel.
  bool finds_cover = false;
};

KernelTraits kernel_traits(const KernelField& field, const view::KernelPlan& plan, const Look& look,
                           const RenderOptions& options);

// Splat space, the cutoff and the levels' filter; the members about the picture's division and the
// device's memory are left to who divides them.
device::KernelFrame kernel_constants(const view::KernelPlan& plan, const KernelTraits& traits,
                                     PostConvolution how);

}  // namespace ovoid
