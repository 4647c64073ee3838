// SPDX-License-Identifier: Apache-2.0
// What is in a picture: volumes, and what stands in the same space. Renderer::render() draws it.
// All parts are values that own, or share, what they show; nobody changes what is shared, so scenes
// are cheap to copy and may be kept. docs/scene.md.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "ovoid/export.h"
#include "ovoid/field.h"
#include "ovoid/kernel_field.h"
#include "ovoid/labels.h"
#include "ovoid/look.h"
#include "ovoid/math.h"
#include "ovoid/surface.h"
#include "ovoid/transfer_function.h"

namespace OVOID_API ovoid {

// How a surface with colours by its values is drawn.
struct SurfaceStyle {
  double opacity = 1;        // of each layer, in [0, 1]; 0: not drawn
  bool shows_edges = false;  // of the cells' faces, as dark lines
};

// What was in a field some time ago ("motion blur"), drawn with it sheet by sheet: behind what the
// field shows on a sheet comes what the trail shows there, so that nothing of it is seen through a
// nearer surface. It has colours and opacities of its own and takes no light, nor opacity by the
// gradient; opacities are over the look's unit distance, if it has one. Source: [Neophytou 2006,
// section 2.2].
struct Trail {
  LatticeField field;  // on the lattice of the field that it is drawn with: trail_before()
  TransferFunction transfer_function;
  // Of a kernel field, in place of `field`: the trail is their mean (docs/numerics.md, "With a
  // trail of kernel sets"), kernel_trail_before(). All alike: sums, of which there is one, or
  // normalized; with an attribute of its own for the colours, or without. Shares are divided by
  // their sum.
  std::vector<KernelMoment> moments{};
};

// The kernels themselves in place of their field, each an opaque ball about its centre, in the
// look's colour of its own value (of the colour attribute, where the field has one of its own; of
// fields that are sums the field's value is estimated from the kernel alone). Lit by the look's
// light and material, whether it lights the field or not. Outlines are smooth; balls are at least
// 1.2 pixels wide, so that none is lost. Clip planes take whole balls, by their centres; so does
// the eye, of balls that reach it. Opacities and mode of the look do not count. Cost: in proportion
// to the kernels, and the pixels that they cover.
struct PointStyle {
  // Of the usual radius, half a kernel's sigma: a quarter of the spacing of kernels on a grid. Of
  // an ellipsoid that is its axes' geometric mean; balls count with the median sigma at most, so
  // that lone particles, whose kernels are wide, do not hide the rest. > 0.
  double size = 1;

  static constexpr double kUsualRadius = 0.5;  // sigmas
};

// A field and how it looks.
struct Volume {
  Field field;
  Look look;
  std::shared_ptr<const Trail> trail{};  // null: none
  // Of the mesh whose field it is (make_surface()): the field ends there. Null, or a surface that
  // does not enclose the mesh (Surface::encloses_mesh()): it has no such end. Where the boundary is
  // not closed a ray is inside up to, or from, the boundary that it does meet.
  std::shared_ptr<const Surface> boundary{};
  // The boundary itself, in the colours and light of the look. Opaque walls hide the field, which
  // then is seen on the lids that close what clip planes have cut open, without light; walls of
  // flat cells alone are drawn without the field. Clip planes take walls away, and leave the mesh
  // where it is.
  SurfaceStyle walls{0, false};
  std::optional<PointStyle> points{};  // none: the field is drawn
};

// What a picture of several volumes shows at a place (docs/numerics.md, "Several volumes").
//   kAveraged   extinctions add, colours are mixed in proportion to them: fogs in one room
//   kAdded      the greatest extinction; colours add in proportion to theirs: lights of one stain
//               each, as the channels of a microscope are
//   kColored    the first volume's own extinction and light; the others, on its lattice, are its
//               colours, which add: a volume of red, green and blue
// In the modes maximum and minimum each volume makes a picture of its own, and these are added, or
// averaged by their opacities.
enum class Mixing { kAveraged, kAdded, kColored };

// A surface that stands in a scene, such as an implant, an electrode, a hull; lit as the first
// volume's look lights its field, by its material. Where the look has occlusion or shadows
// (Look::occlusion, Look::shadows) it takes light from the volumes, from other surfaces and from
// itself, and they from it, in and around the first field's box: each layer lets `1 - opacity`
// through (docs/numerics.md, "Surfaces in the light"). Clip planes leave it whole.
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

// A plane through the first volume's field that shows its values, without light; it takes none from
// others. Where the field ends it ends; clip planes leave it whole.
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

// What lies between the eye and a value plane: drawn over it, or cut away.
enum class PlaneFront { kShown, kRemoved };

// An opaque plane that shows the field itself, its colours by value, without light or opacity: the
// points with dot(normal, x) == offset (world; ClipPlane's words). `normal` need not have unit
// length, and its sign does not matter to the picture (docs/numerics.md, "Value plane").
//
// A pixel holds, front to back: the volume in front of the plane (kShown alone), the plane's
// colour, opaque where the field is defined on it and the place lies inside all clip planes, and
// the volume behind it. The volume looks as it does without the plane, cut along it as by a
// ClipPlane. In front is the half space that holds the eye; with parallel projection, the one from
// which rays come. A plane that no ray of the picture meets (seen edge-on, or behind the eye) has
// nothing in front of it.
//
// The plane's colours are those of the look's transfer function, or, for fields with a colour
// attribute of their own, of its color_function, at the field's value there. Where a pixel's rays
// meet the plane, depth is the plane's unless the volume in front reaches opacity 1/2. Where the
// field is not defined on the plane and it takes both halves to reach 1/2, depth is that of the
// half behind, or, if that does not reach it by itself, the plane's. The front depth likewise.
struct ValuePlane {
  Vec3 normal{1, 0, 0};
  double offset = 0;
  PlaneFront front = PlaneFront::kRemoved;
};

struct Scene {
  static constexpr std::size_t kMaxVolumes = 4;

  // The first gives the picture its mode; surfaces, slices and a value plane go by its field and
  // look. The others are lattices drawn on the same sheets, in the same world; they need not
  // overlap. Of their looks all counts but the light: there is one in a picture, and how much of it
  // arrives goes by the extinction of all volumes.
  std::vector<Volume> volumes;
  Mixing mixing = Mixing::kAveraged;
  std::vector<Geometry> surfaces;
  std::vector<FieldSlice> slices;
  LabelSurfaces labels;
  std::optional<ValuePlane> plane;
  // Of the whole picture; none: that of the first volume's look, or, without one, a headlight.
  std::optional<Lighting> lighting;

  Scene() = default;
  // One volume and nothing else.
  Scene(Field field, Look look) : volumes{{std::move(field), std::move(look)}} {}

  // Whether there is something beside the volumes that goes among them by depth.
  bool has_scenery() const noexcept {
    return !surfaces.empty() || !slices.empty() || labels.map != nullptr;
  }

  // Throws Error that says what cannot be drawn, and why: kInvalidArgument for what is wrong in
  // itself, kUnsupported for parts that are not drawn together. Not all is found so early:
  // Renderer::render() knows the options, too.
  void validate() const;
};

}  // namespace ovoid
