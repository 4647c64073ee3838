// SPDX-License-Identifier: Apache-2.0
// The weights of post-convolution's filters, for every back end but the reference.
#pragma once

#include <array>

#include "ovoid/render_options.h"
#include "render/shared/filter_formulas.h"

namespace ovoid {

using device::kFilterTaps;
using device::kTapsBefore;
using FilterTaps = std::array<double, kFilterTaps>;

// `phase`: of the place behind sample 0, in [0, 1). The weights' sum is 1.
inline FilterTaps filter_taps(PostConvolution how, double phase) {
  FilterTaps taps{};
  double sum = 0;
  for (int k = 0; k < kFilterTaps; ++k)
    sum += taps[static_cast<std::size_t>(k)] =
        device::filter_weight(static_cast<std::uint32_t>(how), k, phase);
  if (how == PostConvolution::kAuto) return taps;
  for (double& weight : taps) weight /= sum;
  return taps;
}

}  // namespace ovoid
