// SPDX-License-Identifier: Apache-2.0
#include "view/plan/frame_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "data/kernels/kernel_weight.h"
#include "ovoid/error.h"
#include "view/look/isosurfaces.h"
#include "view/plan/finished_pixel.h"
#include "view/plan/space_part.h"

namespace ovoid {

double sheet_distance(const Field& field, const Look& look, const RenderOptions& options) {
  if (options.sampling_distance > 0) return options.sampling_distance;
  if (!view::is_refined(look, options)) return field.default_sampling_distance();
  const KernelField* const set = field.kernels();
  return set != nullptr ? set->refined_sampling_distance()
                        : 0.5 * field.default_sampling_distance();
}

namespace view {

bool is_refined(const Look& look, const RenderOptions& options) {
  return options.classification == Classification::kRefined && look.mode == Mode::kComposite &&
         !is_published(options.post_convolution) && options.spread == Spread::kGaussian;
}

bool draws_pieces(const Field& field, const Look& look, const RenderOptions& options) {
  if (!shows_values(look.mode)) return is_refined(look, options);
  const bool is_of_means =
      options.slab == Slab::kMean ||
      (options.slab == Slab::kAuto && look.mode == Mode::kXray && field.kernels() != nullptr);
  return !options.clip_planes.empty() && !is_of_means && !is_published(options.post_convolution) &&
         options.spread == Spread::kGaussian;
}

bool is_gentle(const Look& look, const ValueRange& range) {
  const TransferFunction& transfer = look.transfer_function;
  if (!(range.lo < range.hi) || !transfer.gradient_opacities.empty() || look.transfer_function_2d ||
      transfer.scale != ValueScale::kLinear)
    return false;
  const double span = static_cast<double>(range.hi) - static_cast<double>(range.lo);
  const auto rises = [&](double rise, double width, double most) {
    return rise > 0 && rise * span > most * width;
  };
  const auto& opacities = transfer.opacities;
  for (std::size_t i = 1; i < opacities.size(); ++i) {
    const OpacityPoint& from = opacities[i - 1];
    // Sharpness 1 is a step, and so is a midpoint at an end.
    const double width = (opacities[i].x - from.x) * (1 - from.sharpness) * 2 *
                         std::min(from.midpoint, 1 - from.midpoint);
    const double rise = std::abs(opacities[i].opacity - from.opacity);
    if (rises(rise, width, kGentleOpacity)) return false;
  }
  const auto& colors = transfer.colors;
  for (std::size_t i = 1; i < colors.size(); ++i) {
    double rise = 0;
    for (std::size_t c = 0; c < 3; ++c)
      rise = std::max(rise, std::abs(colors[i].rgb[c] - colors[i - 1].rgb[c]));
    if (rises(rise, colors[i].x - colors[i - 1].x, kGentleColor)) return false;
  }
  return true;
}

double steepness_of(const Look& look, const ValueRange& range) {
  if (look.mode == Mode::kIsosurface) return kSurfaceSteepness;
  double steepness = 0;
  if (look.mode != Mode::kComposite || !(range.lo < range.hi)) return steepness;
  const auto& points = look.transfer_function.opacities;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double rise = std::abs(points[i].opacity - points[i - 1].opacity);
    // Sharpness 1 is a step.
    const double width = (points[i].x - points[i - 1].x) * (1 - points[i - 1].sharpness);
    const double span = static_cast<double>(range.hi) - static_cast<double>(range.lo);
    if (rise > 0) steepness = std::max(steepness, std::min(rise * span / width, kMostSteepness));
  }
  return steepness;
}

namespace {

ViewLattice::SheetRange checked_sheets(const ViewLattice& lattice, const Bounds3& box) {
  const ViewLattice::SheetRange range = lattice.sheets_meeting(box);
  if (range.last - range.first > kMaxSheets) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format(
            "sampling_distance = {}: gives {} sheets through the field, must give at most {}",
            lattice.sampling_distance(), range.last - range.first, kMaxSheets));
  }
  return range;
}

ViewLattice view_lattice_of(const LatticeField& field, const Camera& camera, const Look& look,
                            const RenderOptions& options, const BasePlane* base) {
  const double distance = sheet_distance(field, look, options);
  return base == nullptr
             ? ViewLattice(camera, options.width, options.height, distance, field.geometry())
             : ViewLattice(*base, camera, distance, field.geometry());
}

// The farthest that the ray of any pixel advances along a lattice axis per sheet, spacings.
double greatest_step(const ViewLattice& lattice) {
  const SheetMap near = lattice.index_map(0);
  const SheetMap next = lattice.index_map(1);
  double step = 0;
  for (const double x : {0.0, lattice.width() - 1.0}) {
    for (const double y : {0.0, lattice.height() - 1.0}) {
      step = std::max(step, (next.at(x, y) - near.at(x, y)).cwiseAbs().maxCoeff());
    }
  }
  return step;
}

// How far from its place a sample sees the field, for its slab's sake, spacings.
double slab_reach(const ViewLattice& lattice, const RenderOptions& options) {
  return options.slab == Slab::kMean ? 0.5 * greatest_step(lattice) : 0.0;
}

// Of the sheets that meet a box, and where pieces are refined of the one behind them, too.
double greatest_pitch(const ViewLattice& lattice, const Bounds3& index_box, bool is_refined) {
  if (lattice.is_parallel()) return lattice.pitch(0);
  const ViewLattice::SheetRange range = lattice.sheets_meeting(index_box);
  if (range.first >= range.last) return 0.0;
  return lattice.pitch(is_refined ? range.last : range.last - 1);
}

// Of the drawn range, per smallest spacing (docs/numerics.md, "Light").
double flat_gradient_of(const Field& field, const Look& look) {
  constexpr double kFlatSurface = 1e-4;
  constexpr double kLeast = 1e-6;  // gradients keep their digits, light shows no difference
  const ValueRange range = field.value_range();
  const double rise =
      look.mode == Mode::kIsosurface
          ? kFlatSurface * (static_cast<double>(range.hi) - static_cast<double>(range.lo))
          : std::max(look.flat_rise, kLeast) *
                (look.transfer_function.hi() - look.transfer_function.lo());
  return rise > 0 ? rise / field.default_sampling_distance() : 0.0;
}

double gradient_unit_of(double flat_gradient) {
  return flat_gradient > 0 ? std::exp2(std::ilogb(flat_gradient)) : 1.0;
}

// Bricks by which the relevant set grows: slabs reach into others, and both samples around an
// isosurface's crossing, or at the ends of a piece, must be taken.
int relevance_grow(const ViewLattice& lattice, const LatticeField& field,
                   const RenderOptions& options, bool has_pieces) {
  const double step = has_pieces ? greatest_step(lattice) : 0.0;
  const double reach = step + slab_reach(lattice, options);
  return static_cast<int>(std::ceil(reach / field.source().brick_edge()));
}

// Wider kernels reach farther, where pixels are wider still; the second time that is next to
// nothing.
double greatest_widening_of(const FramePlan& plan, const LatticeField& field, double reach) {
  double widening = 1.0;
  for (int round = 0; round < 2; ++round) {
    const double pitch =
        greatest_pitch(plan.lattice, support_of(field, widening, reach), plan.is_refined);
    widening = std::max(widening, pitch / field.geometry().spacing().minCoeff());
  }
  return widening;
}

// Whether the eye is on the side that a plane, whose normal has unit length, cuts away
// (docs/numerics.md, "Cut faces").
bool is_cut_seen(const ClipPlane& plane, const ViewLattice& lattice) {
  constexpr double kEdgeOn = 1e-6;
  if (lattice.is_parallel()) return plane.normal.dot(lattice.view_axis()) > kEdgeOn;
  return plane.normal.dot(lattice.eye()) < plane.offset;
}

MayMatter may_matter_for(const Look& look, const LookTable& table) {
  if (look.mode == Mode::kComposite) {
    return [&table](float lo, float hi) { return table.any_opacity(lo, hi); };
  }
  if (look.mode == Mode::kIsosurface) {
    std::vector<float> values;
    for (const Isosurface& surface : surfaces_of(look))
      values.push_back(static_cast<float>(surface.value));
    return [values](float lo, float hi) {
      return std::any_of(values.begin(), values.end(),
                         [&](float value) { return lo <= value && value <= hi; });
    };
  }
  return [](float, float) { return true; };
}

}  // namespace

// Places of samples that can be defined: `sum` wherever a kernel reaches the slab; normalized to
// where 0.48 of the weights exist, a little beyond the faces of the outermost cells, or 0.02 of a
// slab's length if that is more. Cells of a body-centred lattice reach half an axis vector from
// their sample: where kernels are narrow, twice as far as the plane on which the faces lie.
Bounds3 support_of(const LatticeField& field, double widening, double reach) {
  const LatticeKernel kernel = field.index_kernel();
  Bounds3 box = field.geometry().index_bounds();
  const double half_cell = 0.5 / field.geometry().num_sublattices();
  const double bulge = 0.5 - half_cell;
  const double beyond = field.reconstruction() == Reconstruction::kSum
                            ? kernel.support_radius() * widening - half_cell + reach
                            : data::face_reach(kernel) * widening + 0.05 * reach + bulge + 1e-3;
  box.min().array() -= beyond;
  box.max().array() += beyond;
  return box;
}

FramePlan::FramePlan(const Field& field, const ViewLattice& view_lattice, const Look& look,
                     const RenderOptions& options)
    : lattice(view_lattice),
      look_table(look.transfer_function),
      is_faded(!look.transfer_function.gradient_opacities.empty() || look.transfer_function_2d),
      is_preintegrated(look.mode == Mode::kComposite &&
                       options.classification == Classification::kPreintegrated),
      is_refined(view::draws_pieces(field, look, options)),
      unit_distance(unit_distance_of(look, field)),
      flat_gradient(flat_gradient_of(field, look)),
      gradient_unit(gradient_unit_of(flat_gradient)),
      clip_planes(options.clip_planes),
      least_spacing(field.default_sampling_distance()),
      is_clipped(!options.clip_planes.empty() || !lattice.is_parallel()) {
  if (options.skip_irrelevant) may_matter = may_matter_for(look, look_table);
  for (ClipPlane& plane : clip_planes) {
    const double length = plane.normal.norm();
    plane.normal /= length;
    plane.offset /= length;
  }
  drawn_within = clip_planes;
  if (options.part != nullptr) {
    const std::vector<ClipPlane> around = planes_around(*options.part, lattice);
    drawn_within.insert(drawn_within.end(), around.begin(), around.end());
  }
  if (look.mode != Mode::kComposite || !look.shade) return;
  const auto behind =
      std::stable_partition(clip_planes.begin(), clip_planes.end(),
                            [this](const ClipPlane& plane) { return is_cut_seen(plane, lattice); });
  num_cut_faces = static_cast<std::size_t>(behind - clip_planes.begin());
}

void FramePlan::set_sheets(const Bounds3& index_box) {
  sheets = checked_sheets(lattice, index_box);
  if (is_refined && sheets.first < sheets.last) ++sheets.last;  // where the last piece ends
}

ClipMap FramePlan::clip_distance(const ClipPlane& plane, std::int64_t sheet) const {
  const SheetMap map = lattice.world_map(sheet);
  return {plane.normal.dot(map.origin) - plane.offset, plane.normal.dot(map.per_x),
          plane.normal.dot(map.per_y)};
}

ClipMap FramePlan::clip_slope(const ClipPlane& plane) const {
  const SheetMap direction = lattice.ray_direction();
  return {plane.normal.dot(direction.origin), plane.normal.dot(direction.per_x),
          plane.normal.dot(direction.per_y)};
}

LatticePlan::LatticePlan(const LatticeField& field, const Camera& camera, const Look& look,
                         const RenderOptions& options, PieceRelevance pieces, const BasePlane* base)
    : FramePlan(field, view_lattice_of(field, camera, look, options, base), look, options),
      order(base == nullptr ? kOwnOrder : base->order),
      greatest_widening(
          base == nullptr ? greatest_widening_of(*this, field, slab_reach(lattice, options)) : 1.0),
      relevance(
          field, greatest_widening,
          relevance_grow(lattice, field, options,
                         look.mode == Mode::kIsosurface || is_preintegrated ||
                             (is_refined && pieces == PieceRelevance::kWholePieces)),
          is_refined && pieces == PieceRelevance::kPieceEnds ? 0.5 * greatest_step(lattice) : 0.0),
      node_reach_((data::is_piecewise(field.kernel().kind) ? kNodeSigmasOfPieces : kNodeSigmas) *
                  field.index_kernel().sigma *
                  std::pow(kNodeSteepness /
                               std::max(kNodeSteepness, steepness_of(look, field.value_range())),
                           0.25)),
      widens_kernels_(base == nullptr),
      spacing_(in_order(field.geometry().spacing(), order)),
      unit_spacing_(field.geometry().unit_spacing()) {
  const Index3 cells = field.geometry().cells();
  for (int a = 0; a < 3; ++a) {
    widening_limit_[a] = static_cast<double>(cells[static_cast<std::size_t>(order[a])]) /
                         (4 * field.index_kernel().sigma);
  }
  faces = in_order(field.geometry().index_bounds(), order);
  const double reach = slab_reach(lattice, options);
  index_support = in_order(support_of(field, greatest_widening, reach), order);
  narrow_support = in_order(support_of(field, 1.0, reach), order);
  set_sheets(index_support);
}

Vec3 LatticePlan::widening(std::int64_t sheet) const {
  if (!widens_kernels_) return Vec3::Ones();
  return (lattice.pitch(sheet) / spacing_.array()).min(widening_limit_.array()).max(1.0).matrix();
}

double LatticePlan::node_step(PostConvolution how, std::int64_t sheet) const {
  if (how == PostConvolution::kOff) return 1.0;
  // Pixels are widest on the layer's rearmost sheet.
  const SheetMap map = lattice.index_map(next_layer(sheet) - 1);
  const double step = std::max(map.per_x.norm(), map.per_y.norm());  // of a pixel, index space
  const double reach = how == PostConvolution::kAuto ? node_reach_ : unit_spacing_;
  const double node_step = step > 0 ? reach / step : kGreatestNodeStep;
  return node_step < kLeastNodeStep ? 1.0 : std::min(node_step, kGreatestNodeStep);
}

}  // namespace view
}  // namespace ovoid
