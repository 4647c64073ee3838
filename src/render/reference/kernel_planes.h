// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "ovoid/field.h"
#include "ovoid/render_options.h"
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
// adds to every sample that its support holds, in double precision, one after the other.
class KernelPlanes {
 public:
  struct Rows {
    int y0, y1;  // half open
    int width;
  };
  // `is_mean`: samples are means over their slabs. Throws Error(kOutOfMemory).
  KernelPlanes(const KernelField& field, const std::vector<ViewedKernel>& kernels,
               const ViewRays& view, const SheetRange& sheets, const Rows& rows, bool is_mean);

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
  // A section of a kernel: amplitude times the profile of the distance in the plane.
  struct Section {
    double x, y;  // world, right and down
    Eigen::Matrix2d covariance;
    double amplitude;
    double q_along;  // part of m^2 that is not in the plane
    double room;     // what is left of the cut-off for the part in the plane
  };

  void add_kernel(const ViewedKernel& kernel);
  void add_section(const ViewedKernel& kernel, const Section& section, std::int64_t sheet,
                   double z);
  Section middle_section(const ViewedKernel& kernel, double z) const;
  Section mean_section(const ViewedKernel& kernel, double z) const;
  void add_sheet(const ViewedKernel& kernel, std::int64_t sheet);
  bool holds(int x, int y, std::int64_t sheet) const;
  std::size_t index_of(int x, int y, std::int64_t sheet) const;

  const ViewRays& view_;
  SheetRange sheets_;
  Rows rows_;
  KernelProfile profile_;
  double cutoff_;
  bool is_sum_;
  bool has_own_color_;
  bool is_mean_;
  std::vector<Cell> cells_;
};

}  // namespace ovoid::reference
