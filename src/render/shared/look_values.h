// SPDX-License-Identifier: Apache-2.0
// A look as every back end but the reference reads it: its tables, its light, its isosurface.
#pragma once

#include <vector>

#include "ovoid/look.h"
#include "render/shared/device_layout.h"
#include "view/plan/frame_plan.h"
#include "view/plan/light_volume.h"

namespace ovoid {

// All tables of a frame, one behind the other, in vectors of four numbers: red, green, blue and
// opacity of an entry side by side.
using FrameTables = std::vector<device::vec4>;

// [kPaddedEntries][4]: the entries of the table, opacities corrected for a path of so many unit
// distances.
std::vector<float> classification_entries(const view::LookTable& table, double path_in_units);

// Appends the look's tables to `tables`. The opacities of the look's own table are corrected for a
// path of one sampling distance, unless the frame corrects late.
device::LookConstants look_constants(const view::FramePlan& plan, const Look& look,
                                     bool corrects_late, FrameTables& tables);

// Where samples of the frame lie in a light volume; `dims.w` is 0.
device::LightConstants light_constants(const view::FramePlan& plan, const view::LightVolume& light);

// The cells of a light volume behind the other tables; returns where they begin, in numbers.
std::int32_t append_light(const view::LightVolume& light, FrameTables& tables);

}  // namespace ovoid
