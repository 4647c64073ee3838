// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/crop.h"
#include "ovoid/field.h"
#include "settings.h"

namespace ovoid::cli {

// Adds the crop's clip planes to the options and returns the box that is left: all of the field
// without a crop. Throws Error: what lies outside the data, too many planes.
Box apply_crop(const CropFlags& crop, const Field& field, RenderOptions* options);

}  // namespace ovoid::cli
