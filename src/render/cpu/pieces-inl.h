// SPDX-License-Identifier: Apache-2.0
// Stages "shade" and "composite" of refined pieces: what lies between two sheets is classified, lit
// and composited in steps (docs/numerics.md, "Classification", refined).
//
// In:  values, gradients and defined bits of a sheet and of the one before it.
// Out: visible bits (pieces that may show something); the tile's state.
//
// Samples of the pieces that may show are packed before they are drawn (sample_batch.h).
#if defined(OVOID_RENDER_CPU_PIECES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_PIECES_INL_H_
#undef OVOID_RENDER_CPU_PIECES_INL_H_
#else
#define OVOID_RENDER_CPU_PIECES_INL_H_
#endif

#include "render/cpu/composite-inl.h"
#include "render/cpu/sample_batch-inl.h"
#include "view/look_variation.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// The part of a piece that is drawn, as shares of the way from the sheet before to its own.
struct PiecePart {
  V from, to;
};

// The lanes of a group for which an end of the piece is there.
struct PieceEnds {
  std::uint32_t front, back;
};

// False for sheets before the near plane, where differences have values and pieces none.
inline bool exists(const BlockPlace& place, int s) { return place.sheets[s].near_cut < 0; }

HWY_INLINE PieceEnds ends_of(const BlockPlace& place, const SheetRing& ring,
                             const SampleGroup& group) {
  const auto lanes_of = [&](int s) {
    return exists(place, s) ? lanes_at(ring[place.number_of(s)].defined[group.row], group.column)
                            : 0U;
  };
  return {lanes_of(group.s - 1), lanes_of(group.s)};
}

// Of the pieces that end on sheet s, those that have an end.
inline RowBits with_an_end(const BlockPlace& place, const SheetRing& ring, int s,
                           const RowBits& bits) {
  RowBits out;
  const RowBits& front = ring[place.number_of(s - 1)].defined;
  const RowBits& back = ring[place.number_of(s)].defined;
  for (int y = 0; y < place.rows; ++y) {
    const RowWord ends = (exists(place, s - 1) ? front[y] : 0) | (exists(place, s) ? back[y] : 0);
    out[y] = bits[y] & ends;
  }
  return out;
}

// One number of a group's pieces at both ends.
struct EndValues {
  V front, back;
  V at(V t) const { return hn::MulAdd(hn::Sub(back, front), t, front); }
};

// One number after the other of a group's pieces at both ends; an end that is not there has the
// other's.
class GroupEnds {
 public:
  HWY_INLINE explicit GroupEnds(const PieceEnds& ends)
      : front_(mask_of(ends.front)), back_(mask_of(ends.back)) {}

  HWY_INLINE EndValues operator()(const float* front, const float* back) const {
    const V f = hn::LoadU(d, front);
    const V b = hn::LoadU(d, back);
    return {hn::IfThenElse(front_, f, b), hn::IfThenElse(back_, b, f)};
  }
  const M& front() const { return front_; }
  const M& back() const { return back_; }

 private:
  M front_, back_;
};

// Opacity and variation of a group's samples, which the sheet keeps for the piece behind it.
// `lanes`: those that have a value.
HWY_INLINE VariationAt classify_ends(const CpuFrame& frame, Sheet& sheet, const SampleGroup& group,
                                     std::uint32_t lanes) {
  const int at = sheet.at(group.column, group.row);
  if ((lanes_at(sheet.is_classified[group.row], group.column) & lanes) == lanes)
    return {hn::LoadU(d, sheet.opacity + at), hn::LoadU(d, sheet.variation + at)};
  const VariationAt found = variation_at(frame.look, hn::LoadU(d, sheet.values + at));
  // A group at a row's end writes on into what others have there.
  const M mask = mask_of(lanes);
  hn::BlendedStore(found.opacity, mask, d, sheet.opacity + at);
  hn::BlendedStore(found.variation, mask, d, sheet.variation + at);
  sheet.is_classified[group.row] |= RowWord{lanes} << group.column;
  return found;
}

// Finds the pieces named by `bits` on which a value between the ends has any opacity, and how much
// the look changes along them, which is kept in shaded.alpha.
inline void classify_pieces(const CpuFrame& frame, const BlockPlace& place, SheetRing& ring, int s,
                            const RowBits& bits, ShadedSheet& shaded) {
  Sheet& front = ring[place.number_of(s - 1)];
  Sheet& back = ring[place.number_of(s)];
  const device::TableConstants& table = frame.look.constants.look;
  for (int y = 0; y < place.rows; ++y) {
    shaded.visible[y] = 0;
    for_each_group(
        bits[y], place.margin, place.columns - place.margin, [&](int column, std::uint32_t lanes) {
          const int at = back.at(column, y);
          const SampleGroup group{s, column, y, lanes};
          const PieceEnds ends = ends_of(place, ring, group);
          const GroupEnds both(ends);
          const EndValues value = both(front.values + at, back.values + at);
          const M may_show =
              hn::And(hn::Ge(hn::Max(value.front, value.back), hn::Set(d, table.visible_lo)),
                      hn::Le(hn::Min(value.front, value.back), hn::Set(d, table.visible_hi)));
          if ((bits_of(may_show) & lanes) == 0) return;
          // An end that is not there is as the other.
          const VariationAt from = classify_ends(frame, front, group, ends.front & lanes);
          const VariationAt to = classify_ends(frame, back, group, ends.back & lanes);
          const V change = hn::IfThenElseZero(hn::And(both.front(), both.back()),
                                              hn::Abs(hn::Sub(to.variation, from.variation)));
          const V opacity = hn::Max(hn::IfThenElseZero(both.front(), from.opacity),
                                    hn::IfThenElseZero(both.back(), to.opacity));
          const M shows = hn::Or(hn::Gt(opacity, hn::Zero(d)), hn::Gt(change, hn::Zero(d)));
          const std::uint32_t visible = bits_of(shows) & lanes;
          if (visible == 0) return;
          hn::StoreU(change, d, shaded.alpha + at);
          shaded.visible[y] |= RowWord{visible} << column;
        });
  }
}

// What no plane cuts away, the near plane included.
HWY_INLINE PiecePart cut_part(const CpuFrame& frame, const BlockPlace& place,
                              const SampleGroup& group, PiecePart part) {
  const view::FramePlan& plan = *frame.plan;
  const std::int64_t sheet = place.number_of(group.s);
  if (!frame.is_parallel) {
    const double nearest = 1.0 + (plan.lattice.near_depth() - plan.lattice.depth(sheet)) /
                                     plan.lattice.sampling_distance();
    part.from = hn::Max(part.from, hn::Set(d, static_cast<float>(nearest)));
  }
  const V x = pixel_x(place, group.column);
  const float y = pixel_y(place, group.row);
  for (const ClipPlane& plane : plan.clip_planes) {
    const V inside = evaluate2d(plan.clip_distance(plane, sheet), x, y);
    const V slope = hn::Mul(evaluate2d(plan.clip_slope(plane), x, y),
                            hn::Set(d, frame.camera.sampling_distance));
    const SlabCut cut = cut_of(inside, slope);
    const V one = hn::Set(d, 1.0F);
    part.from = hn::Max(part.from, hn::Add(cut.from, one));
    part.to = hn::Min(part.to, hn::Add(cut.to, one));
  }
  return part;
}

// A piece that has one end is half a piece.
struct HalfPieces {
  HWY_INLINE PiecePart operator()(const SampleGroup& /*group*/, const PieceEnds& ends) const {
    const V half = hn::Set(d, 0.5F);
    return {hn::IfThenElse(mask_of(ends.front), hn::Zero(d), half),
            hn::IfThenElse(mask_of(ends.back), hn::Set(d, 1.0F), half)};
  }
};

// Gradients of a group's pieces at both ends.
struct EndGradients {
  EndValues x, y, z;
  WorldVector at(V t) const { return {x.at(t), y.at(t), z.at(t)}; }

  // The distance between the ends of both normals, which are shorter where the field is flat.
  V turn(float flat_gradient_inverse) const {
    const auto factor = [&](V a, V b, V c) {
      const V squared = hn::MulAdd(a, a, hn::MulAdd(b, b, hn::Mul(c, c)));
      return hn::Min(reciprocal_sqrt(hn::Max(squared, hn::Set(d, 1e-36F))),
                     hn::Set(d, flat_gradient_inverse));
    };
    const V front = factor(x.front, y.front, z.front);
    const V back = factor(x.back, y.back, z.back);
    const auto change = [&](const EndValues& g) {
      return hn::NegMulAdd(g.front, front, hn::Mul(g.back, back));
    };
    const V dx = change(x), dy = change(y), dz = change(z);
    return hn::Sqrt(hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz))));
  }
};

// view::steps_for().
HWY_INLINE V steps_for(V need) {
  V steps = hn::Set(d, 1.0F);
  for (int count = 1; count < view::kMostSteps; count *= 2) {
    const auto least = static_cast<float>(count);
    steps = hn::IfThenElse(hn::Gt(need, hn::Set(d, least)), hn::Set(d, 2 * least), steps);
  }
  return steps;
}

// Packs the samples of the pieces that end at a group's samples, whose gradients are there.
template <class PartOf>
HWY_INLINE void add_to_batch(const CpuFrame& frame, const TileInHand& tile,
                             const SampleGroup& group, const PartOf& part_of) {
  const BlockPlace& place = tile.place;
  const device::LookConstants& look = frame.look.constants;
  SampleBatch& batch = tile.batch;
  const Sheet& front = tile.ring[place.number_of(group.s - 1)];
  const Sheet& back = tile.ring[place.number_of(group.s)];
  const int at = back.at(group.column, group.row);
  const PieceEnds ends = ends_of(place, tile.ring, group);
  const GroupEnds of_ends(ends);
  const auto both = [&](const float* f, const float* b) { return of_ends(f + at, b + at); };
  const EndValues value = both(front.values, back.values);
  PiecePart part{hn::Zero(d), hn::Set(d, 1.0F)};
  if ((ends.front & ends.back & group.lanes) != group.lanes) part = part_of(group, ends);
  if (frame.is_clipped) part = cut_part(frame, place, group, part);
  V need = hn::Mul(hn::LoadU(d, tile.shaded.alpha + at), hn::Set(d, view::kStepsPerVariation));
  EndGradients gradient{};
  if (frame.takes_gradients) {
    gradient = {both(front.gradient[0], back.gradient[0]),
                both(front.gradient[1], back.gradient[1]),
                both(front.gradient[2], back.gradient[2])};
    need = hn::Add(need, gradient.turn(look.flat_gradient_inverse));
  }
  const V steps = steps_for(need);
  const V step = hn::Div(hn::Max(hn::Sub(part.to, part.from), hn::Zero(d)), steps);
  const V path = hn::Mul(hn::Mul(step, hn::Set(d, look.path_in_units)),
                         ray_length(frame, place, group.column, group.row));
  const V sheet_distance = hn::Set(d, frame.camera.sampling_distance);
  const V front_depth = hn::Sub(hn::Set(d, place.sheets[group.s].depth), sheet_distance);
  M active = hn::And(mask_of(group.lanes), hn::Gt(step, hn::Zero(d)));
  for (V m = hn::Set(d, 0.5F);; m = hn::Add(m, hn::Set(d, 1.0F))) {
    active = hn::And(active, hn::Lt(m, steps));
    const std::uint32_t lanes = bits_of(active);
    if (lanes == 0) return;
    const int first = batch.num_samples;
    const auto pack = [&](V numbers, SampleBatch::Floats& floats) {
      hn::StoreU(hn::Compress(numbers, active), d, &floats[first]);
    };
    const V t = hn::MulAdd(m, step, part.from);
    pack(value.at(t), batch.value);
    pack(path, batch.path);
    pack(hn::MulAdd(t, sheet_distance, front_depth), batch.depth);
    if (frame.takes_gradients) {
      pack(gradient.x.at(t), batch.gradient[0]);
      pack(gradient.y.at(t), batch.gradient[1]);
      pack(gradient.z.at(t), batch.gradient[2]);
    }
    if (frame.has_own_color) pack(both(front.colors, back.colors).at(t), batch.color_value);
    if (!frame.is_parallel) {
      const WorldVector eye = direction_to_eye(frame, place, group.column, group.row);
      pack(eye.x, batch.eye[0]);
      pack(eye.y, batch.eye[1]);
      pack(eye.z, batch.eye[2]);
    }
    batch.steps[batch.num_steps++] = {group.column, group.row, lanes, first};
    batch.num_samples += std::popcount(lanes);
  }
}

// Samples of one step join the pixels.
HWY_INLINE void composite_step(const CpuFrame& frame, const TileInHand& tile,
                               const SampleBatch::Step& step) {
  const SampleBatch& batch = tile.batch;
  const Expansion expand(step.lanes);
  const auto unpack = [&](const SampleBatch::Floats& floats) {
    return expand(hn::LoadU(d, &floats[step.first]));
  };
  const int at = tile_index(tile.place, step.column, step.row);
  GroupPixels pixels = load_pixels(tile.pixels, at);
  // Nothing is added behind what is opaque, be it by an earlier step.
  const V opaque_at = hn::Set(d, frame.opaque_at);
  const V opacity = unpack(batch.opacity);
  const M is_visible = hn::And(hn::And(mask_of(step.lanes), hn::Lt(pixels.alpha, opaque_at)),
                               hn::Gt(opacity, hn::Zero(d)));
  const std::uint32_t visible = bits_of(is_visible);
  if (visible == 0) return;
  tile.stats.samples_shaded += std::popcount(visible);
  add_to_pixels({unpack(batch.red), unpack(batch.green), unpack(batch.blue)},
                hn::IfThenElseZero(is_visible, opacity), unpack(batch.depth), pixels);
  store_pixels(pixels, tile.pixels, at);
  const M opaque = hn::And(is_visible, hn::Ge(pixels.alpha, opaque_at));
  tile.pixels.open[tile_row(tile.place, step.row)] &=
      ~(RowWord{bits_of(opaque)} << tile_column(tile.place, step.column));
}

// Draws the samples of the batch, and empties it.
inline void flush_batch(const CpuFrame& frame, const TileInHand& tile) {
  SampleBatch& batch = tile.batch;
  shade_batch(frame, batch);
  for (int i = 0; i < batch.num_steps; ++i) composite_step(frame, tile, batch.steps[i]);
  batch.num_samples = batch.num_steps = 0;
}

// Classifies, lights and composites the pieces that end on sheet s and may show something, whose
// ends' gradients are there. `part_of`: what there is of pieces that have one end.
template <class PartOf>
inline void draw_pieces(const CpuFrame& frame, const TileInHand& tile, int s,
                        const PartOf& part_of) {
  const BlockPlace& place = tile.place;
  for (int y = 0; y < place.rows; ++y) {
    if (tile.shaded.visible[y] == 0) continue;  // as in all rows of the margin
    const RowWord open = tile.pixels.open[tile_row(place, y)];
    for_each_group(tile.shaded.visible[y] & open >> place.x0 << place.margin, place.margin,
                   place.columns - place.margin, [&](int column, std::uint32_t lanes) {
                     if (!tile.batch.has_room()) flush_batch(frame, tile);
                     add_to_batch(frame, tile, {s, column, y, lanes}, part_of);
                   });
  }
  flush_batch(frame, tile);
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
