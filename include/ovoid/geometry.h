// SPDX-License-Identifier: Apache-2.0
// What stands in a scene beside its field: surfaces, such as implants, electrodes and hulls, slices
// through it, and the surfaces of labels. docs/geometry.md, and docs/numerics.md, "Geometry".
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "ovoid/depth_limits.h"
#include "ovoid/export.h"
#include "ovoid/field.h"
#include "ovoid/labels.h"
#include "ovoid/look.h"
#include "ovoid/render_surface.h"
#include "ovoid/renderer.h"
#include "ovoid/surface.h"
#include "ovoid/transfer_function.h"

namespace OVOID_API ovoid {

// A surface, lit as the look lights the field. Where the look has occlusion or shadows
// (Look::occlusion, Look::shadows) it takes light from the field, from other surfaces and from
// itself, and they from it: each layer lets `1 - opacity` through.
struct Geometry {
  // Not null; where a value is NaN it is not drawn. It must not change once it has been drawn: a
  // renderer keeps the light of those that live, and knows them by where they lie in memory.
  std::shared_ptr<const Surface> surface;
  Rgb color{0.9, 0.9, 0.9};  // each in [0, 1]
  double opacity = 1;        // of each layer, in (0, 1]
  bool shows_edges = false;  // of the faces, as dark lines
  // Of its values, instead of the one colour; opacities in it do not count.
  std::optional<TransferFunction> colors{};

  // Throws Error(kInvalidArgument) that names what is wrong.
  void validate() const;
};

// A plane through the field that shows its values, without light; it takes none from others.
struct FieldSlice {
  Vec3 normal{0, 0, 1};     // any length > 0
  double offset = 0;        // of the places x with dot(normal, x) == offset; world
  TransferFunction colors;  // of the values, or of what gives colour; without opacities opaque
  double opacity = 1;       // factor, in (0, 1]; where the field is not defined nothing is
  // Of a line along where the plane leaves the field's box, 1/360 of the picture's shorter side
  // wide, at least one and a half pixels; each in [0, 1].
  std::optional<Rgb> outline{};

  // Throws Error(kInvalidArgument) that names what is wrong.
  void validate() const;
};

// What is seen beside a field.
struct Scenery {
  std::vector<Geometry> geometry;
  std::vector<FieldSlice> slices;
  LabelSurfaces labels;
  // Of the mesh whose field it is, as render_mesh() takes it; null: the field has no bounds, or
  // RenderOptions::depth_limits says where it is. Must live as long as the call.
  const Surface* mesh = nullptr;
  SurfaceStyle walls{0, false};  // of the mesh

  // Whether there is nothing beside the field.
  bool empty() const noexcept {
    return geometry.empty() && slices.empty() && labels.map == nullptr;
  }
};

// `options.depth_limits`, or else a field without limits, with the surfaces among its stops: what
// is behind an opaque one is hidden, what is before it, field or surface, is seen before it.
// Outlines are smooth: a pixel of which a part is covered shows that part of the colour. Clip
// planes cut the field, not the surfaces. Throws
// Error: kInvalidArgument, kCancelled, kOutOfMemory. Cost: in proportion to the triangles,
// and the pixels that they cover; 28 bytes for every pixel.
DepthLimits limits_with(std::span<const Geometry> geometry, const Camera& camera, const Look& look,
                        const RenderOptions& options, int threads = 0, std::stop_token stop = {});

// A picture of the field with surfaces, slices and labels in it: Renderer::render() with such
// limits; slices where `options.depth_limits` show the field, and cut by no clip plane; labels cut
// by them as the field is. Where the look has a light volume surfaces, labels and the walls of a
// mesh are under its light, and surfaces take light away, in and around the field's box; slices and
// labels take none (docs/numerics.md, "Surfaces in the light"). Without surfaces walls have all of
// the light. By the back ends that take limits (RenderOptions::depth_limits). Throws what they
// throw, and Error(kUnsupported) for modes other than composite and isosurface. Cost: the frame's,
// that of limits_with(), for each slice that of a value plane (value_plane.h), for labels about
// that of an isosurface of their size, and where the look has a light volume a pass over the
// triangles, once for surfaces that stay where they are.
Frame render_with_scenery(Renderer& renderer, const Field& field, const Camera& camera,
                          const Look& look, const Scenery& scenery,
                          const RenderOptions& options = {}, const RenderHooks& hooks = {});

}  // namespace ovoid
