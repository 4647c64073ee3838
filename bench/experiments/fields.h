// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "ovoid/field.h"
#include "ovoid/model.h"
#include "ovoid/renderer.h"
#include "render/reference/field_evaluator.h"

namespace ovoid::experiments {

// One way to make a field from samples: what the experiments compare.
struct KernelChoice {
  std::string name;
  LatticeKernel kernel;
  Reconstruction reconstruction = Reconstruction::kNormalized;
  bool prefilter = false;
};

// The default of the library, and the kernel as it was published: a plain sum.
KernelChoice default_choice();
KernelChoice published_choice();
KernelChoice catmull_rom_choice();

// A normalized field whose kernels reach `reach` spacings; with reach 2, four samples per axis.
KernelChoice normalized_choice(double sigma, double reach, bool prefilter);

LatticeField field_of(const Dataset& dataset, const KernelChoice& choice);

// A float32 dataset of `dims` samples by formula, sample (i, j, k) at world position (i, j, k).
using SampleFunction = std::function<double(std::int64_t i, std::int64_t j, std::int64_t k)>;
Dataset dataset_of(const Index3& dims, const SampleFunction& function);

// The field at a position in index space, and its gradient in index units; any number of threads
// may ask at once.
using PointField = std::function<reference::FieldSample(const Vec3& position)>;

// The reference back end's sums, in double precision. For lattices of one spacing along all axes.
// `gradient`: exact or corrected.
PointField kernel_points(const Dataset& dataset, const KernelChoice& choice,
                         GradientMethod gradient = GradientMethod::kExact);

// What most renderers do: the eight samples around a position; the gradient is this function's own.
// The position must lie within the samples.
PointField trilinear_points(const Dataset& dataset);

}  // namespace ovoid::experiments
