// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "experiments/fields.h"
#include "ovoid/image.h"
#include "ovoid/renderer.h"

namespace ovoid::experiments {

// One way to sample a frame: what it costs and how near it comes to the picture of 8 times finer
// sheets.
struct PictureCost {
  Slab slab = Slab::kMid;
  GradientMethod gradient = GradientMethod::kCorrected;
  double sheets_per_spacing = 1;
  double psnr_db = 0;
  double cpu_ms = 0;  // of all threads; the least of several frames
  Image image;
};

// The sample head, `size`^3, behind a semi-transparent look with light, `pixels` squared. The
// picture compared with has the corrected gradient and 8 sheets per spacing, sampled on their
// middles.
std::vector<PictureCost> measure_picture_cost(std::int64_t size, int pixels);

// Processor times of fields on one volume and look, relative to the first: what a kernel costs.
std::vector<double> measure_kernel_cost(const std::vector<KernelChoice>& choices, std::int64_t size,
                                        int pixels);

}  // namespace ovoid::experiments
