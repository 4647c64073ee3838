// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "render/cpu/kernels/splat.h"

namespace ovoid::cpu {
namespace bin_kernels_test {

constexpr int kSide = 320;  // pixels
constexpr int kKernels = 400;
constexpr double kCutoff = 3;

// Inclined ellipsoids of many sizes, in a unit cube.
KernelField scattered_ellipsoids() {
  std::mt19937 random(20261129);
  std::uniform_real_distribution<double> place(-0.5, 0.5), size(0.005, 0.03), lean(-0.02, 0.02);
  std::vector<double> centers;
  std::vector<float> shapes, values;
  for (int i = 0; i < kKernels; ++i) {
    for (int a = 0; a < 3; ++a) centers.push_back(place(random));
    for (const bool is_diagonal : {true, false, true, false, false, true})
      shapes.push_back(static_cast<float>(is_diagonal ? size(random) : lean(random)));
    values.push_back(static_cast<float>(i % 7 + 1));
  }
  KernelColumns columns;
  columns.shape = KernelShape::kEllipsoids;
  columns.cutoff = kCutoff;
  const std::vector<float> weights{1.0F};
  columns.centers = centers;
  columns.shapes = shapes;
  columns.weights = weights;
  columns.values = {values};
  columns.attributes = {{"value", "", {}}};
  return {make_kernel_source(columns), Reconstruction::kNormalized};
}

view::KernelPlan plan_of(const KernelField& field, bool is_parallel) {
  Camera camera;
  camera.position = Vec3(0.3, 0.8, 3);
  camera.focal_point = Vec3(0, 0, 0);
  camera.parallel_projection = is_parallel;
  camera.parallel_scale = 0.7;
  Look look;
  look.transfer_function.colors = {{0, {1, 1, 1}}, {10, {1, 1, 1}}};
  look.transfer_function.opacities = {{0, 0.1}, {10, 1}};
  RenderOptions options;
  options.width = options.height = kSide;
  return {field, camera, look, options};
}

// A block's samples on one of its sheets: those of its pixels, and one more on each side, which
// differences read.
struct SampleRange {
  explicit SampleRange(int block)
      : first(block * view::kBlockEdge - 1), last((block + 1) * view::kBlockEdge) {}
  int first, last;
};

// True if a sample of the block lies inside the splat's cutoff, less a share of 1e-3 that the
// splat's single precision may take.
bool has_sample_inside(const view::KernelPlan& plan, const Splat& splat, int x, int y, int layer) {
  const SampleRange columns(x), rows(y);
  for (int j = layer * view::kBlockDepth; j < (layer + 1) * view::kBlockDepth; ++j) {
    const double t = j - splat.s;
    const double depth = plan.space.depth_of(j);
    if (depth < plan.lattice.near_depth()) continue;
    const double scale = plan.space.scale(depth);
    const double left = kCutoff * kCutoff * 0.999 - t * t * splat.inverse_var_s;
    if (left < 0) continue;
    for (int row = rows.first; row <= rows.last; ++row) {
      const double v = (row - plan.space.center_y) / scale - splat.y - splat.my * t;
      // The splat holds the columns between the two roots of a square equation.
      const double b = splat.axy * v, c = splat.ayy * v * v - left;
      const double under_root = b * b - splat.axx * c;
      if (under_root < 0) continue;
      const double middle = plan.space.center_x + (splat.x + splat.mx * t - b / splat.axx) * scale;
      const double half = std::sqrt(under_root) / splat.axx * scale;
      const double first = std::max<double>(std::ceil(middle - half), columns.first);
      if (first <= std::min<double>(middle + half, columns.last)) return true;
    }
  }
  return false;
}

// Fails if a block lacks a splat that one of its samples needs, those one pixel beside the block
// included, or if blocks get many more splats than they need.
TEST(BinKernels, EveryBlockHasTheSplatsOfItsSamples) {
  const KernelField field = scattered_ellipsoids();
  for (const bool is_parallel : {true, false}) {
    const view::KernelPlan plan = plan_of(field, is_parallel);
    const auto runner = make_runner(2);
    const BinnedSplats binned = bin_splats(field, plan, Merging::kNone, *runner);
    std::int64_t num_needed = 0;
    for (int layer = 0; layer < plan.num_blocks[2]; ++layer) {
      for (int y = 0; y < plan.num_blocks[1]; ++y) {
        for (int x = 0; x < plan.num_blocks[0]; ++x) {
          const auto block = static_cast<std::size_t>(plan.block_index(x, y, layer));
          if (plan.is_needed[block] == 0) continue;
          const auto splats = binned.of_block(block);
          for (std::uint32_t i = 0; i < binned.num_kernels; ++i) {
            if (!has_sample_inside(plan, binned.splats[i], x, y, layer)) continue;
            ++num_needed;
            EXPECT_NE(std::ranges::find(splats, i), splats.end())
                << "splat " << i << " is missing in block " << x << ' ' << y << ' ' << layer;
          }
        }
      }
    }
    EXPECT_GT(num_needed, 5 * kKernels);
    EXPECT_LT(binned.first.back(), static_cast<std::uint64_t>(1.3 * num_needed));
  }
}

}  // namespace bin_kernels_test
}  // namespace ovoid::cpu
