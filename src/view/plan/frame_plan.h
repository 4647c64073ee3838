// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "ovoid/look.h"
#include "ovoid/render_options.h"
#include "view/look/look_table.h"
#include "view/plan/relevance.h"
#include "view/plan/view_lattice.h"

namespace ovoid::view {

// One clip plane as a function of the sample: distance(x, y) inside the half space (world units, >=
// 0 is kept) on a sheet, and its change per unit of depth along the ray of pixel (x, y).
struct ClipMap {
  double origin, per_x, per_y;
};

// True if pieces between sheets are drawn in steps. Modes other than composite have no layers; the
// published ways of post-convolution classify samples, as published.
bool is_refined(const Look& look, const RenderOptions& options);

// True if what lies between two sheets is drawn, and not the samples on them: refined pieces, and,
// in the modes that show values, what clip planes cut (docs/numerics.md, "Cut values").
bool draws_pieces(const Field& field, const Look& look, const RenderOptions& options);

// True of a look whose opacity and colours change by so little over the field's range that lattice
// sheets may be kGentleDistance times as far from each other, where nothing else is asked for
// (docs/numerics.md, "Lattice sheets").
bool is_gentle(const Look& look, const ValueRange& range);
inline constexpr double kGentleOpacity =
    1.0;  // change over the field's range, were it as fast all along
inline constexpr double kGentleColor = 8.0;
inline constexpr double kGentleDistance = 1.5;

// Greatest change of the opacity over the field's range, were it as fast all along. An isosurface
// is a step, but what is found by nodes is then refined on the field.
double steepness_of(const Look& look, const ValueRange& range);

// Everything about a frame, of whatever field, that can be said before a sample is reconstructed.
struct FramePlan {
  FramePlan(const Field& field, const ViewLattice& lattice, const Look& look,
            const RenderOptions& options);
  // `may_matter` looks into `look_table`. Of a look with a 2-D transfer function the transfer
  // function is its envelope (view::with_envelope()).
  FramePlan(const FramePlan&) = delete;
  FramePlan& operator=(const FramePlan&) = delete;

  ViewLattice lattice;
  ViewLattice::SheetRange sheets;  // that can meet the field
  LookTable look_table;
  std::optional<LookTable> color_table;  // colours of the attribute that gives them, if one does
  bool is_faded;                         // the opacity depends on the gradient's length, too
  bool is_preintegrated;                 // pieces between sheets are classified as one
  bool is_refined;                       // draws_pieces(): in steps, or by their values
  double unit_distance;
  double flat_gradient;  // world; where the gradient is shorter, a region counts as flat
  // World: a power of two, in which back ends hold gradients, since values per length, and squares
  // of them, leave float32's range in some units that people use.
  double gradient_unit;
  MayMatter may_matter;  // whether bounds can show; empty: everything may
  // Normals of unit length. The first num_cut_faces of them have cuts that are seen and at which
  // light fades (docs/numerics.md, "Cut faces").
  std::vector<ClipPlane> clip_planes;
  std::size_t num_cut_faces = 0;
  // Half spaces, of unit length, outside of which nothing is drawn: the clip planes', and those
  // around the part of space that is.
  std::vector<ClipPlane> drawn_within;
  double least_spacing;  // h_min
  bool is_clipped;       // some samples' paths are shortened by planes or the near plane

  ClipMap clip_distance(const ClipPlane& plane, std::int64_t sheet) const;
  ClipMap clip_slope(const ClipPlane& plane) const;

 protected:
  // Sets `sheets` to those that meet a box in index space. Throws Error(kInvalidArgument) if they
  // are too many.
  void set_sheets(const Bounds3& index_box);
};

// A frame of a lattice field.
struct LatticePlan : FramePlan {
  // `relevance`: where refined pieces can show (kWholePieces), or one of their ends is in a brick
  // near which they can (kPieceEnds), which is less.
  enum class PieceRelevance { kWholePieces, kPieceEnds };
  // `base`: of a frame of lattice sheets; null: of sheets that are parallel to the picture.
  LatticePlan(const LatticeField& field, const Camera& camera, const Look& look,
              const RenderOptions& options, PieceRelevance pieces = PieceRelevance::kWholePieces,
              const BasePlane* base = nullptr);

  // Index space, here and in ViewLattice::index_map(), has the axes in this order; the relevance
  // map has them in their own.
  AxisOrder order;
  Bounds3 index_support;     // positions (index space) where the field can be defined
  Bounds3 narrow_support;    // the same on sheets that widen no kernel
  Bounds3 faces;             // of the lattice, index space
  double greatest_widening;  // of any kernel on any sheet; lattice sheets widen none
  RelevanceMap relevance;    // to be filled: one fill_layer() per layer, then finish()

  // True if something relevant touches the box, index space.
  bool any_relevant(const Bounds3& box) const noexcept {
    return relevance.any_in(out_of_order(box.min(), order), out_of_order(box.max(), order));
  }

  // Factors by which kernels are widened along each lattice axis on a sheet.
  Vec3 widening(std::int64_t sheet) const;
  const Vec3& widening_limit() const noexcept { return widening_limit_; }  // along each axis

  // Pixels between the nodes at which a sheet is sampled, 1 if it is sampled at its pixels
  // (docs/numerics.md, "Post-convolution"). The same for the kNodeSheets sheets of a layer.
  double node_step(PostConvolution how, std::int64_t sheet) const;

 private:
  double node_reach_;    // of kAuto, index space
  bool widens_kernels_;  // where pixels are wider than spacings
  Vec3 spacing_;
  double unit_spacing_;
  Vec3 widening_limit_;  // a kernel stays under a quarter of the lattice's extent
};

// Places of samples, index space of the field's own order, where a frame that widens kernels by
// `widening` at most can find the field defined. `reach`: how far a sample's slab reaches,
// spacings.
Bounds3 support_of(const LatticeField& field, double widening, double reach);

// What kAuto keeps: the distance of nodes in sigmas of the lattice's kernel is such that pictures
// have this PSNR, dB, to those of kOff. The published ways have a node per spacing.
inline constexpr double kNodeDecibels = 50;
inline constexpr double kNodeSigmas = 0.8;
// Of kernels that are made of polynomials, whose fields have more of the high frequencies.
inline constexpr double kNodeSigmasOfPieces = 0.7;
// Looks that are steeper than this, in opacity over the field's range, have closer nodes: by the
// fourth root, since the error of interpolation falls with about the fourth power of their distance
// where edges are as sharp as samples can show.
inline constexpr double kNodeSteepness = 10;
inline constexpr double kMostSteepness = 400;
inline constexpr double kSurfaceSteepness = 100;  // of isosurfaces
// Layers: sheets [q kNodeSheets, (q + 1) kNodeSheets) share their nodes' places in the picture.
inline constexpr std::int64_t kNodeSheets = 16;
// Fewer pixels per node save nothing.
inline constexpr double kLeastNodeStep = 1.45;
inline constexpr double kGreatestNodeStep = 64.0;

// The first sheet of the layer behind that of a sheet.
constexpr std::int64_t next_layer(std::int64_t sheet) {
  const std::int64_t within = (sheet % kNodeSheets + kNodeSheets) % kNodeSheets;
  return sheet - within + kNodeSheets;
}

// The most sheets a frame may have; finer sampling distances are refused.
inline constexpr std::int64_t kMaxSheets = std::int64_t{1} << 20;

}  // namespace ovoid::view
