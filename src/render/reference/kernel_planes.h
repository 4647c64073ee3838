// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "ovoid/field.h"
#include "ovoid/render_options.h"
#include "render/reference/post_convolution.h"
#include "render/reference/view_rays.h"

namespace ovoid::reference {

// A kernel as one frame sees it, in the camera's frame (right, down, z), world units.
struct ViewedKernel {
  Vec3 center;
  Mat3 covariance;  // widened where it is narrower than a pixel or sheet
  double weight;    // and so much lower that its mass stays
  double value, color_value;
};

// All kernels of a field. Throws what the source throws.
std::vector<ViewedKernel> view_kernels(const KernelField& field, const ViewRays& view);

// The field's samples for some rows of pixels, one more on every side, on all sheets: every kernel
// adds to every sample that its support holds, in double precision, one after the other. In a
// published way of post-convolution the samples are those of a level of the kernel's own on each
// sheet; coarse levels are then brought to finer ones.
class KernelPlanes {
 public:
  struct Rows {
    int y0, y1;  // half open
    int width;
  };
  struct Way {
    bool is_mean = false;  // samples are means over their slabs
    PostConvolution post_convolution = PostConvolution::kOff;
  };
  // Throws Error(kOutOfMemory).
  KernelPlanes(const KernelField& field, const std::vector<ViewedKernel>& kernels,
               const ViewRays& view, const SheetRange& sheets, const Rows& rows, const Way& way);

  struct Sample {
    double value = 0, color_value = 0;
    bool is_defined = false;
  };
  // Samples beyond the rows' margin or the sheets are undefined.
  Sample at(int x, int y, std::int64_t sheet) const;

 private:
  struct Cell {
    double numerator = 0, denominator = 0, color_numerator = 0;
  };
  // The samples of a level on all sheets: sample i of level l lies at the pixel 2^l i + (2^l - 1)
  // / 2.
  struct Level {
    int step;            // 2^l pixels
    int x0, x1, y0, y1;  // samples, half open
    std::vector<Cell> cells;

    double pixel_of(int i) const { return step * i + 0.5 * (step - 1); }
    double sample_of(double pixel) const { return (pixel - 0.5 * (step - 1)) / step; }
    std::size_t index_of(int x, int y, std::int64_t plane) const {
      const auto columns = static_cast<std::size_t>(x1 - x0);
      const auto rows = static_cast<std::size_t>(y1 - y0);
      return (static_cast<std::size_t>(plane) * rows + static_cast<std::size_t>(y - y0)) * columns +
             static_cast<std::size_t>(x - x0);
    }
  };
  // A section of a kernel: amplitude times the profile of the distance in the plane.
  struct Section {
    double x, y;  // world, right and down
    Eigen::Matrix2d covariance;
    double amplitude;
    double q_along;  // part of m^2 that is not in the plane
    double room;     // what is left of the cut-off for the part in the plane
  };

  void add_levels(const Rows& rows);
  void add_kernel(const ViewedKernel& kernel);
  void add_section(const ViewedKernel& kernel, const Section& section, std::int64_t sheet, double z,
                   Level& level);
  std::size_t level_for(const ViewedKernel& kernel, double z) const;
  void post_convolve(const Level& coarse, Level& fine) const;
  Section middle_section(const ViewedKernel& kernel, double z) const;
  Section mean_section(const ViewedKernel& kernel, double z) const;
  void add_sheet(const ViewedKernel& kernel, std::int64_t sheet);

  const ViewRays& view_;
  SheetRange sheets_;
  KernelProfile profile_;
  double cutoff_;
  bool is_sum_;
  bool has_own_color_;
  Way way_;
  std::vector<Level> levels_;  // the finest, the pixels, first
};

}  // namespace ovoid::reference
