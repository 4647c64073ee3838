// SPDX-License-Identifier: Apache-2.0
// Several volumes in one picture: a PET scan over a CT, the channels of a microscope
// (RenderOptions::further; docs/numerics.md, "Several volumes").
#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "ovoid/export.h"
#include "ovoid/field.h"
#include "ovoid/look.h"

namespace OVOID_API ovoid {

// A volume that is drawn with a frame's own field, on the same sheets: what both show at a place is
// mixed as RenderOptions::mixing says. In the modes maximum and minimum each volume makes a picture
// of its own, and these are added, or averaged by their opacities. It lies where its own geometry
// says, in the same world as the field; the two need not overlap.
struct FurtherVolume {
  LatticeField field;  // on any lattice
  // Of the frame's own mode. Of its light, occlusion, shadows and scatter are not used: how much
  // light arrives is what the frame's own look says, of the extinction of all volumes.
  Look look;
};

inline constexpr std::size_t kMostFurtherVolumes = 3;

// As RenderOptions has them.
inline std::shared_ptr<const std::vector<FurtherVolume>> further_volumes(
    std::vector<FurtherVolume> volumes) {
  return std::make_shared<const std::vector<FurtherVolume>>(std::move(volumes));
}

}  // namespace ovoid
