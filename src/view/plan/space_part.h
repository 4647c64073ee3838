// SPDX-License-Identifier: Apache-2.0
// What a frame draws of a part of space (docs/numerics.md, "Parts of a picture").
#pragma once

#include <span>
#include <vector>

#include "ovoid/deep_image.h"
#include "ovoid/depth_limits.h"
#include "ovoid/space_part.h"
#include "view/plan/view_lattice.h"

namespace ovoid::view {

// Of a view lattice whose sheets are parallel to the picture.
PartSheets sheets_of_part(const SpacePart& part, const ViewLattice& lattice);

// Limits that leave of each ray its pieces of a part, within the limits that there are otherwise
// (null: none). A stop belongs to the part in which it lies. They have no coverage: that is of the
// whole pixel.
DepthLimits limits_of_part(const PartSheets& sheets, const ViewLattice& lattice,
                           const DepthLimits* within);

// Planes, of unit length, of half spaces that the part lies in, and two sheets around it: what is
// outside of one need not be worked out.
std::vector<ClipPlane> planes_around(const SpacePart& part, const ViewLattice& lattice);

// What a frame of a part has drawn, whose pixels hold colours or kept values: a run in each pixel
// that shows something. `coverage`: of the pixels; empty: all.
DeepImage runs_of_part(const Image& image, Mode mode, const PartSheets& sheets,
                       std::span<const float> coverage);

// The same of a picture of surfaces alone, each of whose pixels is of the place at its front depth:
// drawn whole by everybody, and of it the pixels whose place is in the part.
DeepImage runs_of_surfaces(const Image& image, const SpacePart& part, const Camera& camera);

}  // namespace ovoid::view
