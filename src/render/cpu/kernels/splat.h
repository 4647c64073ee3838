// SPDX-License-Identifier: Apache-2.0
// Splats: kernels in splat space (view/plan/kernel_plan.h), and which block they reach.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ovoid/field.h"
#include "render/cpu/runner.h"
#include "view/plan/kernel_plan.h"

namespace ovoid::cpu {

// phi = exp(-1/2 [(u - m t)^T A (u - m t) + t^2 / var_s]), u = (x, y) from the centre, t the sheet
// from the centre's: the cut with a sheet is an ellipse of fixed shape that slides along m
// [METHOD 5.2]. Where kernels are not Gaussian, the bracket is the squared Mahalanobis distance.
struct Splat {
  float x, y, s;           // centre
  float axx, axy, ayy;     // A, per pixel^2 of the focal plane
  float mx, my;            // pixels per sheet
  float inverse_var_s;     // per sheet^2
  float weight;            // times the factor that keeps the mass of widened kernels
  float value, color;      // of the attributes that give opacity and colour
  float reach_s;           // half extent along s, sheets
  float reach_x, reach_y;  // half extents of the cut through the centre, pixels
  float minor;             // smaller sigma of that cut, pixels
};

// Splats and, per block, which of them reach it.
struct BinnedSplats {
  std::int64_t num_kernels = 0;  // that the splats stand for
  std::unique_ptr<Splat[]> splats;
  std::unique_ptr<std::uint32_t[]> indices;  // block after block
  std::vector<std::uint64_t> first;          // [num_blocks + 1] into indices

  std::span<const std::uint32_t> of_block(std::size_t block) const noexcept {
    return {indices.get() + first[block], indices.get() + first[block + 1]};
  }
};

// Stages "project" and "bin". The result does not depend on the number of workers: the splats of a
// block are in the bricks' order. Throws what the source throws.
enum class Merging : std::uint8_t {
  kNone,   // a splat for each kernel
  kSmall,  // of a sum: balls smaller than a sample share one with those beside (project_brick.h)
};
BinnedSplats bin_splats(const KernelField& field, const view::KernelPlan& plan, Merging merging,
                        Runner& runner);

// One kernel in splat space. Kernels narrower than a pixel at their depth, or a sheet, in some
// direction are widened to it (docs/numerics.md, "Kernel sets").
Splat project_kernel(const view::SplatSpace& space, const Vec3& center_world, KernelShape shape,
                     const float* numbers, double cutoff);

Splat project_ball(const view::SplatSpace& space, const Vec3& center_world, double sigma,
                   double cutoff);

// Balls that are all widened to the same size, as one: `sigma` that of any, which the weights go
// by, `spread` the covariance of their places, world units.
Splat project_small_balls(const view::SplatSpace& space, const Vec3& center_world, double sigma,
                          const Mat3& spread, double cutoff);

}  // namespace ovoid::cpu
