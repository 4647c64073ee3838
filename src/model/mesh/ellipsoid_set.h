// SPDX-License-Identifier: Apache-2.0
// From the shapes of sites to ellipsoids with fitted weights: what meshes, boxes and Voronoi cells
// have in common.
#pragma once

#include <vector>

#include "model/mesh/ellipsoid_shape.h"
#include "model/particles/kernel_parts.h"

namespace ovoid::model {

// Meshes and boxes, by default: exp(-3.5^2 / 2) = 0.002, the largest step that a cut-off leaves.
// It reaches a third fewer kernels than 4 sigmas.
inline constexpr double kMeshCutoff = 3.5;

// Sites that become ellipsoids, one kernel each.
struct EllipsoidSites {
  KernelParts parts;  // centres, values, attributes
  std::vector<SiteKernel> kernels;
};

// Gives sites that are alone balls by their nearest sites, fits the weights (`amplitude_passes`)
// and reports degenerate shapes and the sum of weights.
KernelParts fit_ellipsoids(const ModelRun& run, EllipsoidSites sites);

}  // namespace ovoid::model
