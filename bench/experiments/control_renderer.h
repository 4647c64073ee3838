// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "experiments/fields.h"
#include "ovoid/image.h"
#include "ovoid/transfer_function.h"

namespace ovoid::experiments {

// How a ray is cut into samples.
enum class Sheets {
  kImageAligned,  // the field on planes that face the camera: the method
  kAxisPlanes,    // the field on the lattice's own planes, of the axis that the view is nearest to
  kAxisSlices,    // a sheet is one slice of the lattice and takes its samples' kernels whole
};

// A small renderer in double precision for controls: parallel rays, no light. Immutable after
// construction.
class ControlRenderer {
 public:
  // For lattices of one spacing along all axes, centred on the origin, with the default kernel.
  // Opacities are per spacing.
  ControlRenderer(const Dataset& dataset, const TransferFunction& transfer_function);

  // A square picture of half height `half_height` (world), turned by `degrees` about the y axis
  // from the view along -z, with the origin in its middle.
  Image draw(double degrees, int pixels, double half_height, Sheets sheets) const;

 private:
  struct Ray {
    Vec3 origin;  // index space, far before the lattice
    Vec3 step;    // unit length, spacings
  };
  struct Compositor;

  void trace_image_aligned(const Ray& ray, Compositor& pixel) const;
  void trace_axis_aligned(const Ray& ray, Sheets sheets, Compositor& pixel) const;
  reference::FieldSample slice_at(const Ray& ray, const Vec3& place, int axis) const;

  Dataset dataset_;  // keeps values_ alive
  const float* values_;
  Index3 dims_;
  LatticeKernel kernel_;
  PointField field_;
  TransferFunction transfer_function_;
};

}  // namespace ovoid::experiments
