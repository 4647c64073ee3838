// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "ovoid/math.h"

namespace ovoid {

// What a sample stands for: the field on its slab's middle plane, or the slab's mean
// (docs/numerics.md, "Slabs").
enum class Slab { kMid, kMean };

// Where the gradient comes from: the kernels' own derivative corrected so that a linear field has a
// constant gradient (no grid pattern on shaded surfaces), the derivative as it is, or central
// differences over neighbouring samples (docs/numerics.md, "Gradients").
enum class GradientMethod { kCorrected, kExact, kCentral };

// What of a ray gets colour and opacity: the sample itself, or the piece from the sample before it,
// along which the field is taken for straight, so that what lies between two sheets is not missed
// (docs/numerics.md, "Classification"). Mode composite only.
enum class Classification { kSampled, kPreintegrated };

// How the cpu back end evaluates a block: each sample sums its kernels, each kernel adds to its
// samples, or the cheaper of both.
enum class Evaluate { kAuto, kGather, kScatter };

// A half space: points with dot(normal, x) >= offset are kept (world). `normal` need not have unit
// length.
struct ClipPlane {
  Vec3 normal{1, 0, 0};
  double offset = 0;
};

// What one frame is computed from beside field, camera and look. The default is valid.
struct RenderOptions {
  int width = 1024;  // pixels, 1 to kMaxImageSide
  int height = 768;
  double sampling_distance = 0.0;  // distance of sheets, world units; 0: the field's default
  Slab slab = Slab::kMid;
  GradientMethod gradient = GradientMethod::kCorrected;
  Classification classification = Classification::kSampled;
  Evaluate evaluate = Evaluate::kAuto;
  std::vector<ClipPlane> clip_planes;  // at most kMaxClipPlanes
  bool skip_irrelevant = true;  // off: every block is reconstructed (time changes, pixels do not)
  bool stop_opaque =
      true;  // off: covered samples are still worked out (time changes, pixels do not)
  bool collect_profile = false;  // stage times cost a few per cent

  static constexpr int kMaxImageSide = 32768;
  static constexpr int kMaxClipPlanes = 16;
  static constexpr double kOpaque =
      1.0 - 1.0 / 1024.0;  // a pixel takes no sample once its opacity has reached this

  // Throws Error(kInvalidArgument) that names the member.
  void validate() const;
};

}  // namespace ovoid
