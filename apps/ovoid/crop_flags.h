// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "flags.h"
#include "ovoid/crop.h"
#include "ovoid/field.h"

namespace ovoid::cli {

// The part of the data that is drawn. An end that is not given is the data's own.
struct CropFlags {
  struct Range {
    std::optional<std::int64_t> first, last;  // samples, both included
  };
  std::optional<std::array<Range, 3>> samples;
  std::optional<Bounds3> world;  // infinite where not given
};

void add_crop_flags(Flags& flags, CropFlags* crop);
void check_crop_flags(const Flags& flags);  // throws UsageError for contradictions

// Adds the crop's clip planes to the options and returns the box that is left: all of the field
// without a crop. Throws Error: what lies outside the data, too many planes.
Box apply_crop(const CropFlags& crop, const Field& field, RenderOptions* options);

}  // namespace ovoid::cli
