// SPDX-License-Identifier: Apache-2.0
// Sheets of 16 bits (docs/numerics.md, "Half sheets"): how they hold a kernel set's values, and
// which pictures they are good enough for.
#pragma once

#include <string>

#include "ovoid/renderer.h"
#include "view/plan/frame_plan.h"

namespace ovoid::vulkan {

// A sheet holds (value - offset) * scale (shaders/sheet_bits.glsl).
struct SheetRange {
  float scale, offset;
};
SheetRange sheet_range(const ValueRange& range, Reconstruction reconstruction);

// The greatest error of a value that is held so.
double half_sheet_error(double value, const ValueRange& range, Reconstruction reconstruction);

// Of one sample, in any channel, premultiplied: an eighth of what the tier of such pictures allows
// the whole ray.
inline constexpr double kMostHalfSheetChange = 0.5 / 255;

// Why 16 bits could be seen in a picture; empty: they could not.
std::string why_not_half_sheets(const KernelField& field, const view::FramePlan& plan,
                                const Look& look);

}  // namespace ovoid::vulkan
