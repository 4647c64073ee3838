// SPDX-License-Identifier: Apache-2.0
// Images of OME-Zarr [OME-NGFF]: an array for each of several resolutions, and what their axes are.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/core/channel.h"
#include "io/zarr/zarr_array.h"

namespace ovoid::io {

struct OmeLevel {
  std::string path;                        // of its array, from the group's folder
  std::vector<double> scale, translation;  // for each axis: place = scale x index + translation
};

struct OmeImage {
  std::string axes;                // a letter for each (axis_order.h)
  std::vector<std::string> units;  // of each axis; empty: not said
  std::vector<OmeLevel> levels;    // at least one, from fine to coarse
  std::vector<Channel> channels;   // empty: not said
};

// The images that a group's `multiscales` names, versions 0.1 to 0.5; none if it has none. Throws
// Error: kFileFormat for what is broken, kUnsupported for other axes than time, channels and up to
// three of space.
std::vector<OmeImage> ome_images(const ZarrNode& group);

}  // namespace ovoid::io
