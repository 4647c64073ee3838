// SPDX-License-Identifier: Apache-2.0
// What the device layouts copy of the host's constants, held together: a constant that is changed
// on one side alone would let the host write past an array that a shader reads, or the two back
// ends draw different pictures, so it does not compile. What the cpu back end copies is held where
// it stands there.
#include "ovoid/image.h"
#include "ovoid/kernel_field.h"
#include "ovoid/lattice.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"
#include "render/shared/device_layout.h"
#include "render/shared/filters.h"
#include "view/look/look_table.h"
#include "view/look/look_variation.h"
#include "view/plan/frame_plan.h"
#include "view/plan/kernel_plan.h"
#include "view/plan/light_volume.h"

namespace ovoid::device {
namespace {

// Arrays.
static_assert(kMaxClips == RenderOptions::kMaxClipPlanes);
static_assert(kTableCells == view::LookTable::kCells);
static_assert(kBrickGroup == KernelBrick::kMaxBrickKernels);
static_assert(1 << (kNumLevels - 1) == static_cast<int>(view::kWidestSample));
static_assert(sizeof(KernelFrame::taps) == 2 * kFilterTaps * sizeof(float));
// The nodes between and around kNodeTile pixels where they are closest.
static_assert((kNodeTile - 1) / view::kLeastNodeStep + 1 + kFilterTaps <= kMostNodes);
static_assert(kMostNodes <= 32);  // a bit for each

// Divisions of space and of work.
static_assert(kBlockDepth == view::kBlockDepth);
static_assert(kPlanEdge == view::kBlockEdge);
static_assert(kGroupSize == kGroupEdge * kGroupEdge);
static_assert(kScanItems == 4 * kScanGroup);
static_assert(kSortItems == 8 * kSortGroup);
static_assert(kSortBins == 1U << kSortBits);
static_assert(kSortGroup == 16 * kSortBins);  // sort_scatter.comp: sixteen threads for a digit
static_assert(kStoredEdge == 4);              // gather.glsl: shifts by two bits
static_assert(kFarBricks <= static_cast<int>(kDistanceBits));
static_assert((kDistanceBits & kMissingBit) == 0);

// Numbers of the definition.
static_assert(kLeastVisibleOpacity == ovoid::kLeastVisibleOpacity);
static_assert(kLeastSetWeight == static_cast<float>(KernelField::kLeastWeight));
static_assert(kTapsBefore == 2);  // post_convolve.glsl
static_assert(kMostSteps == view::kMostSteps);
static_assert(kStepsPerVariation == view::kStepsPerVariation);
static_assert(kLightSteps == view::kLightSteps);
static_assert(kLightRadix == view::kLightRadix);
static_assert(kLightSteepness == static_cast<float>(view::kLightSteepness));

// Enumerators by their numbers.
static_assert(kScaleLinear == static_cast<uint>(ValueScale::kLinear));
static_assert(kScaleLog == static_cast<uint>(ValueScale::kLog));
static_assert(kComposite == static_cast<uint>(Mode::kComposite));
static_assert(kXray == static_cast<uint>(Mode::kXray));
static_assert(kMaximum == static_cast<uint>(Mode::kMaximum));
static_assert(kMean == static_cast<uint>(Mode::kMean));
static_assert(kIsosurface == static_cast<uint>(Mode::kIsosurface));
static_assert(kMinimum == static_cast<uint>(Mode::kMinimum));
static_assert(kFilterBilinear == static_cast<uint>(PostConvolution::kBilinear));
static_assert(kFilterGaussian == static_cast<uint>(PostConvolution::kGaussian));
static_assert(kFilterCubic == static_cast<uint>(PostConvolution::kCubic));
static_assert(kFilterLagrange == static_cast<uint>(PostConvolution::kAuto));
static_assert(kProfileGaussian == static_cast<uint>(KernelProfile::kGaussian));
static_assert(kProfileCubicSpline == static_cast<uint>(KernelProfile::kCubicSpline));
static_assert(kProfileWendland == static_cast<uint>(KernelProfile::kWendlandC2));
static_assert(kProfileEpanechnikov == static_cast<uint>(KernelProfile::kEpanechnikov));

}  // namespace
}  // namespace ovoid::device
