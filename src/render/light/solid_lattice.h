// SPDX-License-Identifier: Apache-2.0
// How much of each cell of a coarse lattice the inside of a mesh fills, as extinction: what lets no
// light through, exactly as large as the mesh.
#pragma once

#include <stop_token>
#include <vector>

#include "ovoid/render_options.h"
#include "ovoid/surface.h"
#include "render/light/extinction_lattice.h"

namespace ovoid {

// The surface encloses its mesh. Clip planes take away what they cut. Cost: a picture of some
// thousand pixels. Throws Error(kCancelled).
ExtinctionLattice solid_lattice(const Surface& surface, const std::vector<ClipPlane>& clip_planes,
                                int threads, const std::stop_token& stop);

}  // namespace ovoid
