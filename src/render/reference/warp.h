// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/renderer.h"
#include "view/plan/base_plane.h"

namespace ovoid::reference {

// The picture of a base plane's samples: docs/numerics.md, "Lattice sheets".
Image warped(const view::BasePlane& base, const Image& samples, const RenderOptions& options);

}  // namespace ovoid::reference
