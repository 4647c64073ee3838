// SPDX-License-Identifier: Apache-2.0
#include "ovoid/render_options.h"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>

#include "ovoid/error.h"

namespace ovoid {
namespace {

void require(bool holds, const std::string& message) {
  if (!holds) throw Error(ErrorCode::kInvalidArgument, message);
}

}  // namespace

void RenderOptions::validate() const {
  for (const auto& [name, side] : {std::pair{"width", width}, std::pair{"height", height}}) {
    require(side >= 1 && side <= kMaxImageSide,
            fmt::format("{} = {}: must be 1 to {}", name, side, kMaxImageSide));
  }
  require(std::isfinite(sampling_distance) && sampling_distance >= 0,
          fmt::format("sampling_distance = {}: must be > 0, or 0 for the field's own",
                      sampling_distance));
  require(
      spread == Spread::kGaussian ||
          (post_convolution != PostConvolution::kOff && post_convolution != PostConvolution::kAuto),
      "spread: bilinear needs a published way of post-convolution: bilinear, gaussian or cubic");
  require(opaque_at > 0 && opaque_at <= 1,
          fmt::format("opaque_at = {}: must be > 0 and at most 1", opaque_at));
  require(clip_planes.size() <= kMaxClipPlanes,
          fmt::format("clip_planes: {} given, at most {} are possible", clip_planes.size(),
                      kMaxClipPlanes));
  for (std::size_t i = 0; i < clip_planes.size(); ++i) {
    const ClipPlane& plane = clip_planes[i];
    require(plane.normal.allFinite() && plane.normal.norm() > 0,
            fmt::format("clip_planes[{}].normal: must be finite and not zero", i));
    require(std::isfinite(plane.offset), fmt::format("clip_planes[{}].offset: must be finite", i));
  }
  if (part != nullptr) {
    require(opaque_at >= kOpaque,
            fmt::format("opaque_at = {}: must be at least {} where a part of space is drawn, which "
                        "does not know how opaque it is in front of it",
                        opaque_at, kOpaque));
    for (const SpacePart::Side& side : part->sides) {
      require(side.normal.allFinite() && side.normal.norm() > 0 && std::isfinite(side.offset),
              "part: the planes of its sides must be finite, their normals not zero");
    }
  }
  if (depth_limits == nullptr) return;
  require(depth_limits->width == width && depth_limits->height == height,
          fmt::format("depth_limits: of {} x {} pixels, the picture has {} x {}",
                      depth_limits->width, depth_limits->height, width, height));
  depth_limits->validate();
}

}  // namespace ovoid
