// SPDX-License-Identifier: Apache-2.0
// Depth limits of a picture, worked out tile by tile from a surface's fragments.
#pragma once

#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "ovoid/depth_limits.h"
#include "render/passes/surface_raster.h"

namespace ovoid {

// Appends the stops of pixel (x, y) and returns its coverage; called from many threads at once.
using PixelStops = std::function<float(int x, int y, std::span<const SurfaceFragment> fragments,
                                       std::vector<DepthLimits::Stop>& stops)>;

// Pixels without fragments have no stops, and are not asked for. Throws Error(kCancelled).
DepthLimits limits_of_tiles(const SurfaceRaster& raster, int threads, const std::stop_token& stop,
                            const PixelStops& stops_of);

}  // namespace ovoid
