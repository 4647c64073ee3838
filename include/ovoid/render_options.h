// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "ovoid/depth_limits.h"
#include "ovoid/export.h"
#include "ovoid/math.h"
#include "ovoid/space_part.h"

namespace OVOID_API ovoid {

class Field;
struct Look;

// What a sample stands for: the field on its slab's middle plane, or the slab's mean
// (docs/numerics.md, "Slabs"). Auto: the middle, but for x-ray pictures of kernel sets the mean, so
// that no mass is lost.
enum class Slab { kAuto, kMid, kMean };

// Where the gradient comes from: the kernels' own derivative corrected so that a linear field has a
// constant gradient (no grid pattern on shaded surfaces), the derivative as it is, or central
// differences over neighbouring samples (docs/numerics.md, "Gradients").
// Auto: corrected for lattices, central for kernel sets, which know no other.
enum class GradientMethod { kAuto, kCorrected, kExact, kCentral };

// What of a ray gets colour and opacity (docs/numerics.md, "Classification"). Mode composite only.
//   kSampled        the samples on the sheets, as published
//   kPreintegrated  the pieces between two sheets, by integrals of the look over their values
//   kRefined        the pieces between two sheets, in as many steps as look and light need; value
//                   and gradient go straight between the sheets, which lie closer by default
enum class Classification { kSampled, kPreintegrated, kRefined };

// How the cpu back end evaluates a block: each sample sums its kernels, each kernel adds to its
// samples, or the cheaper of both. Of kernel sets: gather is the fragment-centric way, every sample
// visits all kernels of its block, on the vulkan back end, too; its lattices always gather.
enum class Evaluate { kAuto, kGather, kScatter };

// How sheets finer than the field are made (docs/numerics.md, "Post-convolution"): every sample
// from the kernels (kOff), or from coarser samples that a filter brings to the pixels, of a lattice
// from nodes some pixels apart, of a kernel set from levels whose samples are 2, 4, 8, ... pixels
// wide. On lattice sheets kAuto draws few samples and fills in what is smooth between them. kAuto:
// as coarse as the picture bears it (50 dB). The others are the published ways, with a node per
// spacing or sigmas of half a sample, for comparison: they blur.
enum class PostConvolution { kOff, kBilinear, kGaussian, kCubic, kAuto };
constexpr bool is_published(PostConvolution how) {
  return how != PostConvolution::kOff && how != PostConvolution::kAuto;
}

// How a lattice's samples add to nodes: by their kernel, or, as published, shared among the four
// nodes around (2 x 2 patterns and blur, for comparison). With a published way of post-convolution
// only.
enum class Spread { kGaussian, kBilinear };

// How exactly the vulkan back end keeps a kernel set's sheets before they are classified: as
// floats, or in half the memory where that cannot be seen (docs/numerics.md, "Half sheets"). Where
// it could be, for lattices and in the other back ends there are floats, and FrameProfile::notice
// says so.
enum class SheetPrecision { kSingle, kHalf };

// How the sheets of a lattice lie (docs/numerics.md, "Lattice sheets"): parallel to the picture, or
// parallel to the lattice's own planes, which takes less time; the picture on them is then warped
// to the one that is seen. kAuto: as the lattice's where that can be and is faster, by a rule that
// looks at the frame alone. Kernel sets, and the vulkan back end, have image sheets.
enum class Sheets { kAuto, kImage, kLattice };

// A half space: points with dot(normal, x) >= offset are kept (world). `normal` need not have unit
// length.
struct ClipPlane {
  Vec3 normal{1, 0, 0};
  double offset = 0;
};

// What one frame is computed from beside scene and camera. The default is valid.
struct RenderOptions {
  int width = 1024;  // pixels, 1 to kMaxImageSide
  int height = 768;
  double sampling_distance = 0.0;  // distance of sheets, world units; 0: sheet_distance()
  Slab slab = Slab::kAuto;
  GradientMethod gradient = GradientMethod::kAuto;
  Classification classification = Classification::kRefined;
  Sheets sheets = Sheets::kAuto;
  Evaluate evaluate = Evaluate::kAuto;
  PostConvolution post_convolution = PostConvolution::kAuto;
  Spread spread = Spread::kGaussian;
  SheetPrecision sheet_precision = SheetPrecision::kSingle;
  std::vector<ClipPlane> clip_planes;  // at most kMaxClipPlanes
  // Where along each pixel's ray the field is drawn, and what is seen there beside it; of the
  // picture's size. Null: everywhere, and nothing. On image sheets alone, and in pictures without a
  // trail.
  std::shared_ptr<const DepthLimits> depth_limits;
  // Draws what this part of space has of the picture, into Frame::seen; null: the whole. On image
  // sheets alone, and in pictures without a trail or value plane.
  std::shared_ptr<const SpacePart> part;
  bool skip_irrelevant = true;  // off: every block is reconstructed (time changes, pixels do not)
  // Off: covered samples are still worked out (time changes, pixels do not).
  bool stop_opaque = true;
  double opaque_at = kOpaque;  // a pixel takes no more once its opacity has reached this; in (0, 1]
  bool pack_sheets = true;  // off: the vulkan back end sums a set's kernels on one sheet at a time
                            // (time changes, pixels do not)
  bool collect_profile = false;  // stage times cost a few per cent

  static constexpr int kMaxImageSide = 32768;
  static constexpr int kMaxClipPlanes = 16;
  static constexpr double kOpaque = 1.0 - 1.0 / 1024.0;

  // Throws Error(kInvalidArgument) that names the member.
  void validate() const;
};

// The distance of a frame's sheets, world units: that of the options, or else the field's default
// sampling distance, of which refined pieces take half, those of kernel sets
// KernelField::refined_sampling_distance().
double sheet_distance(const Field& field, const Look& look, const RenderOptions& options);

}  // namespace ovoid
