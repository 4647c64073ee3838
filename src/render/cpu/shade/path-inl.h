// SPDX-License-Identifier: Apache-2.0
// The path of a sample: how much of its slab lies inside all clip half spaces and in front of the
// eye.
#if defined(OVOID_RENDER_CPU_PATH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_PATH_INL_H_
#undef OVOID_RENDER_CPU_PATH_INL_H_
#else
#define OVOID_RENDER_CPU_PATH_INL_H_
#endif

#include "render/cpu/lattice/block.h"
#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Picture coordinates of a group of a plane's samples.
HWY_INLINE V pixel_x(const BlockPlace& place, int column) {
  return hn::Iota(d, static_cast<float>(place.tile_x + place.x0 + column - place.margin));
}
HWY_INLINE float pixel_y(const BlockPlace& place, int row) {
  return static_cast<float>(place.tile_y + place.y0 + row - place.margin);
}

HWY_INLINE V evaluate2d(const view::ClipMap& map, V x, float y) {
  return hn::MulAdd(x, hn::Set(d, static_cast<float>(map.per_x)),
                    hn::Set(d, static_cast<float>(map.origin + y * map.per_y)));
}

// What a half space leaves of a ray, in sheets from where `inside` (a distance to the plane) and
// `slope` (its change over a sheet) hold.
struct SlabCut {
  V from, to;
};

HWY_INLINE SlabCut cut_of(V inside, V slope) {
  const V far = hn::Set(d, 1e30F);
  // inside + t slope >= 0. A slope of nothing keeps or drops the whole ray.
  const M is_parallel = hn::Lt(hn::Abs(slope), hn::Set(d, 1e-20F));
  const V crossing = hn::Div(hn::Neg(inside), hn::IfThenElse(is_parallel, hn::Set(d, 1.0F), slope));
  const M enters = hn::AndNot(is_parallel, hn::Gt(slope, hn::Zero(d)));
  const M leaves = hn::AndNot(is_parallel, hn::Lt(slope, hn::Zero(d)));
  const M is_gone = hn::And(is_parallel, hn::Lt(inside, hn::Zero(d)));
  return {hn::IfThenElse(enters, crossing, hn::Neg(far)),
          hn::IfThenElse(is_gone, hn::Neg(far), hn::IfThenElse(leaves, crossing, far))};
}

// Where a plane's sample lies in the tile's arrays.
HWY_INLINE int tile_index(const BlockPlace& place, int column, int row) {
  return (place.y0 + row - place.margin) * kTileSize + place.x0 + column - place.margin;
}

// What the spans of the depth limits, from those in hand on, leave of the slabs [from, to], in
// sheets around a group's samples: lane by lane.
inline V path_within_all_spans(const CpuFrame& frame, const BlockPlace& place,
                               const SampleGroup& group, V from, V to) {
  alignas(64) float begin[16];
  alignas(64) float end[16];
  alignas(64) float sum[16] = {};
  hn::Store(from, d, begin);
  hn::Store(to, d, end);
  const float depth = place.sheets[group.s].depth;
  const float per_depth = 1 / frame.camera.sampling_distance;
  const TileLimits& limits = *place.limits;
  for (int lane = 0; lane < group_size(); ++lane) {
    const int column = group.column + lane;
    const bool is_of_tile = group.row >= place.margin && group.row < place.rows - place.margin &&
                            column >= place.margin && column < place.columns - place.margin;
    if (!is_of_tile) continue;
    const int pixel = tile_index(place, column, group.row);
    for (std::uint32_t i = limits.span[pixel]; i < limits.end[pixel]; ++i) {
      const DepthLimits::Stop* const stop = frame.limits->stops.data() + i;
      if (!stop->is_field_behind) continue;
      const bool is_last = i + 1 == limits.end[pixel];
      const float enter = (stop[0].depth - depth) * per_depth;
      const float leave = is_last ? end[lane] : (stop[1].depth - depth) * per_depth;
      sum[lane] += std::max(std::min(end[lane], leave) - std::max(begin[lane], enter), 0.0F);
    }
  }
  return hn::Load(d, sum);
}

// The same; of a group none of whose spans in hand ends within the slabs, in which no other then
// lies, at once.
HWY_INLINE V path_within_spans(const CpuFrame& frame, const BlockPlace& place,
                               const SampleGroup& group, V from, V to) {
  const int pixel = tile_index(place, group.column, group.row);
  const auto sheets_to = [&](const float* depths) {
    return hn::Mul(hn::Sub(hn::LoadU(d, depths + pixel), hn::Set(d, place.sheets[group.s].depth)),
                   hn::Set(d, 1 / frame.camera.sampling_distance));
  };
  const M ends = hn::Lt(sheets_to(place.limits->leave), to);
  if ((bits_of(ends) & group.lanes) != 0)
    return path_within_all_spans(frame, place, group, from, to);
  const V length = hn::Sub(to, hn::Max(from, sheets_to(place.limits->enter)));
  return hn::Max(length, hn::Zero(d));
}

// What the half spaces leave of `around`, in sheets around the sample; each cuts off an end.
HWY_INLINE SlabCut kept_around(const CpuFrame& frame, const BlockPlace& place, int s, int column,
                               int row, const SlabCut& around) {
  const view::FramePlan& plan = *frame.plan;
  const std::int64_t sheet = place.number_of(s);
  V from = around.from;
  V to = around.to;
  const V x = pixel_x(place, column);
  const float y = pixel_y(place, row);
  for (const ClipPlane& plane : plan.clip_planes) {
    const V inside = evaluate2d(plan.clip_distance(plane, sheet), x, y);
    const V slope = hn::Mul(evaluate2d(plan.clip_slope(plane), x, y),
                            hn::Set(d, frame.camera.sampling_distance));
    const SlabCut cut = cut_of(inside, slope);
    from = hn::Max(from, cut.from);
    to = hn::Min(to, cut.to);
  }
  return {from, to};
}

// The same of the slab, [-1/2, 1/2].
HWY_INLINE SlabCut slab_of(const CpuFrame& frame, const BlockPlace& place, int s, int column,
                           int row) {
  return kept_around(frame, place, s, column, row,
                     {hn::Set(d, place.sheets[s].near_cut), hn::Set(d, 0.5F)});
}

// False for sheets before the near plane, where differences have values, samples and pieces none.
inline bool exists(const BlockPlace& place, int s) { return place.sheets[s].near_cut < 0; }

// Lanes of a group whose samples half spaces leave a path: those that exist. What depth limits
// leave of it is another matter, as a piece has a front end that may have none.
HWY_INLINE std::uint32_t with_path_by_planes(const CpuFrame& frame, const BlockPlace& place, int s,
                                             int column, int row) {
  if (!frame.plan->is_clipped) return group_bits();
  if (!exists(place, s)) return 0;
  const SlabCut slab = slab_of(frame, place, s, column, row);
  return bits_of(hn::Gt(slab.to, slab.from));
}

// The same of samples with a piece on either side of which half spaces leave something: it may be
// the half next to an end where the field is not defined.
HWY_INLINE std::uint32_t with_pieces_by_planes(const CpuFrame& frame, const BlockPlace& place,
                                               int s, int column, int row) {
  if (!frame.plan->is_clipped) return group_bits();
  if (!exists(place, s)) return 0;
  const float near_cut = place.sheets[s].near_cut;
  const SlabCut kept =
      kept_around(frame, place, s, column, row,
                  {hn::Set(d, near_cut > -0.5F ? near_cut : -1.0F), hn::Set(d, 1.0F)});
  return bits_of(hn::Gt(kept.to, kept.from));
}

// Fraction of the slab, in [0, 1].
HWY_INLINE V path_fraction(const CpuFrame& frame, const BlockPlace& place, int s, int column,
                           int row) {
  const SlabCut slab = slab_of(frame, place, s, column, row);
  if (place.limits != nullptr)
    return path_within_spans(frame, place, {s, column, row, group_bits()}, slab.from, slab.to);
  return hn::Max(hn::Sub(slab.to, slab.from), hn::Zero(d));
}

// How far a group's samples lie behind the nearest cut face, smallest spacings; negative before it.
// Light fades at cuts.
HWY_INLINE V clearance_of(const CpuFrame& frame, const BlockPlace& place,
                          const SampleGroup& group) {
  const view::FramePlan& plan = *frame.plan;
  const V x = pixel_x(place, group.column);
  const float y = pixel_y(place, group.row);
  V least = hn::Set(d, 1e30F);
  for (std::size_t i = 0; i < plan.num_cut_faces; ++i) {
    const view::ClipMap map = plan.clip_distance(plan.clip_planes[i], place.number_of(group.s));
    least = hn::Min(least, evaluate2d(map, x, y));
  }
  return hn::Mul(least, hn::Set(d, static_cast<float>(1 / plan.least_spacing)));
}

// Length of the ray per unit of depth: 1 for parallel projection.
HWY_INLINE V ray_length(const CpuFrame& frame, const BlockPlace& place, int column, int row) {
  if (frame.is_parallel) return hn::Set(d, 1.0F);
  return hn::LoadU(d, place.rays->length + tile_index(place, column, row));
}

// Works out the rays of the tile at a pixel of the picture. They are the same on all sheets.
inline void set_up_rays(const CpuFrame& frame, int tile_x, int tile_y, TileRays& rays) {
  if (frame.is_parallel) return;
  const view::SheetMap& direction = frame.camera.ray;
  for (int y = 0; y < kTileSize; ++y) {
    for (int column = 0; column < kTileSize; column += group_size()) {
      const V x = hn::Iota(d, static_cast<float>(tile_x + column));
      V along[3];
      V squared = hn::Zero(d);
      for (int a = 0; a < 3; ++a) {
        along[a] = evaluate2d({direction.origin[a], direction.per_x[a], direction.per_y[a]}, x,
                              static_cast<float>(tile_y + y));
        squared = hn::MulAdd(along[a], along[a], squared);
      }
      const V length = hn::Sqrt(squared);
      const V scale = hn::Div(hn::Set(d, -1.0F), length);
      const int at = y * kTileSize + column;
      hn::StoreU(length, d, rays.length + at);
      for (int a = 0; a < 3; ++a) hn::StoreU(hn::Mul(along[a], scale), d, rays.eye[a] + at);
    }
  }
}

// Where the slab of a sheet begins.
inline float near_cut_of(const view::ViewLattice& lattice, std::int64_t sheet) {
  if (lattice.is_parallel()) return -0.5F;
  const double nearest =
      (lattice.near_depth() - lattice.depth(sheet)) / lattice.sampling_distance();
  return nearest > -0.5 ? static_cast<float>(nearest) : -0.5F;
}

// A sheet of pixels.
inline SheetPlace place_of_sheet(const view::FramePlan& plan, std::int64_t sheet) {
  const view::ViewLattice& lattice = plan.lattice;
  return {static_cast<float>(lattice.depth(sheet)),
          static_cast<float>(1.0 / (lattice.pitch(sheet) * plan.gradient_unit)),
          near_cut_of(lattice, sheet)};
}

// Lanes whose place, a share t of the way from sheet s - 1 to sheet s, lies in all clip half
// spaces.
HWY_INLINE std::uint32_t kept_by_planes(const CpuFrame& frame, const BlockPlace& place, int s,
                                        int column, int row, V t) {
  std::uint32_t kept = group_bits();
  const view::FramePlan& plan = *frame.plan;
  const V x = pixel_x(place, column);
  const float y = pixel_y(place, row);
  const V sheets_back = hn::Sub(t, hn::Set(d, 1.0F));
  for (const ClipPlane& plane : plan.clip_planes) {
    const V inside = evaluate2d(plan.clip_distance(plane, place.number_of(s)), x, y);
    const V slope = hn::Mul(evaluate2d(plan.clip_slope(plane), x, y),
                            hn::Set(d, frame.camera.sampling_distance));
    kept &= bits_of(hn::Ge(hn::MulAdd(slope, sheets_back, inside), hn::Zero(d)));
  }
  return kept;
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
