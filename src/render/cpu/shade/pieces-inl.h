// SPDX-License-Identifier: Apache-2.0
// Stages "shade" and "composite" of refined pieces: what lies between two sheets is classified, lit
// and composited in steps (docs/numerics.md, "Classification", refined).
//
// In:  values, gradients and defined bits of a sheet and of the one before it.
// Out: visible bits (pieces that may show something); the tile's state.
//
// Samples of the pieces that may show are gathered before they are drawn (sample_batch.h).
#if defined(OVOID_RENDER_CPU_PIECES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_PIECES_INL_H_
#undef OVOID_RENDER_CPU_PIECES_INL_H_
#else
#define OVOID_RENDER_CPU_PIECES_INL_H_
#endif

#include "render/cpu/shade/composite-inl.h"
#include "render/cpu/shade/piece_parts-inl.h"
#include "render/cpu/shade/sample_batch-inl.h"
#include "view/look/look_variation.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

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
      : are_whole_((ends.front & ends.back) == group_bits()),
        front_(mask_of(ends.front)),
        back_(mask_of(ends.back)) {}

  HWY_INLINE EndValues operator()(const float* front, const float* back) const {
    const V f = hn::LoadU(d, front);
    const V b = hn::LoadU(d, back);
    if (are_whole_) return {f, b};
    return {hn::IfThenElse(front_, f, b), hn::IfThenElse(back_, b, f)};
  }
  const M& front() const { return front_; }
  const M& back() const { return back_; }

 private:
  bool are_whole_;  // all ends are there
  M front_, back_;
};

// Opacity and variation of a group's samples, which the sheet keeps for the piece behind it.
// `lanes`: those that have a value.
HWY_INLINE VariationAt classify_ends(const CpuFrame& frame, Sheet& sheet, const SampleGroup& group,
                                     std::uint32_t lanes) {
  const int at = sheet.at(group.column, group.row);
  if ((lanes_at(sheet.is_classified[group.row], group.column) & lanes) == lanes)
    return {hn::LoadU(d, sheet.opacity + at), hn::LoadU(d, sheet.variation + at)};
  const V value = hn::LoadU(d, sheet.values + at);
  const VariationAt found = variation_of(frame.look, value);
  // A group at a row's end writes on into what others have there.
  const M mask = mask_of(lanes);
  hn::BlendedStore(found.opacity, mask, d, sheet.opacity + at);
  hn::BlendedStore(found.variation, mask, d, sheet.variation + at);
  sheet.is_classified[group.row] |= RowWord{lanes} << group.column;
  return found;
}

// Depths of a group's pieces at their ends.
HWY_INLINE EndValues depths_of(const CpuFrame& frame, const BlockPlace& place, int s) {
  const V back = hn::Set(d, place.sheets[s].depth);
  return {hn::Sub(back, hn::Set(d, frame.camera.sampling_distance)), back};
}

// X-ray, maximum, minimum and mean of what planes and depth limits leave of the pieces named by
// `bits` (docs/numerics.md, "Cut values").
template <class PartOf>
inline void accumulate_pieces(const CpuFrame& frame, const TileInHand& tile, int s,
                              const RowBits& bits, const PartOf& part_of) {
  const BlockPlace& place = tile.place;
  const Sheet& front = tile.ring[place.number_of(s - 1)];
  const Sheet& back = tile.ring[place.number_of(s)];
  for (int y = 0; y < place.rows; ++y) {
    for_each_group(
        bits[y], place.margin, place.columns - place.margin, [&](int column, std::uint32_t lanes) {
          SampleGroup group{s, column, y, lanes};
          const PieceEnds ends = ends_of(place, tile.ring, group);
          PiecePart part{hn::Zero(d), hn::Set(d, 1.0F)};
          if ((ends.front & ends.back & lanes) != lanes) part = part_of(group, ends);
          part = cut_part(frame, place, group, part);
          group.lanes &= bits_of(hn::Lt(part.from, part.to));
          if (group.lanes == 0) return;
          const int at = back.at(column, y);
          const EndValues value = GroupEnds(ends)(front.values + at, back.values + at);
          const EndValues depth = depths_of(frame, place, s);
          const V first = value.at(part.from);
          const V last = value.at(part.to);
          if (shows_an_extreme(frame)) {
            const M is_last =
                frame.mode == Mode::kMaximum ? hn::Gt(last, first) : hn::Lt(last, first);
            note_extreme(frame, place, group,
                         {hn::IfThenElse(is_last, last, first),
                          depth.at(hn::IfThenElse(is_last, part.to, part.from))},
                         tile.pixels);
            return;
          }
          const V sheets = hn::Sub(part.to, part.from);
          const V length = hn::Mul(hn::Mul(sheets, ray_length(frame, place, column, y)),
                                   hn::Set(d, frame.camera.sampling_distance));
          add_to_sum(place, group,
                     {hn::Mul(hn::Set(d, 0.5F), hn::Add(first, last)), depth.at(part.from)}, length,
                     tile.pixels);
        });
  }
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

// Gradients of a group's pieces at both ends.
struct EndGradients {
  EndValues x, y, z;

  HWY_INLINE EndValues lengths() const {
    const auto length = [](V a, V b, V c) {
      return hn::Sqrt(hn::MulAdd(a, a, hn::MulAdd(b, b, hn::Mul(c, c))));
    };
    return {length(x.front, y.front, z.front), length(x.back, y.back, z.back)};
  }

  // The squared distance between the ends of both normals, which are shorter where the field is
  // flat.
  HWY_INLINE V turn_squared(float flat_gradient_inverse) const {
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
    return hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
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

// Pieces of a group, by what is known at their ends.
struct PieceGroup {
  SampleGroup at;  // its lanes: pieces that may show something
  PieceEnds ends;
  EndValues value, color;
  EndGradients gradient;
  EndValues around, key;  // how much light arrives
  EndValues clearance;    // from cut faces
  V change;               // of the look, in steps
  V turn_squared;         // of the normal

  // Pieces that take more than one step.
  HWY_INLINE std::uint32_t take_more_steps() const {
    // need = change + turn > 1
    const V rest = hn::Sub(hn::Set(d, 1.0F), change);
    const M is_one = hn::And(hn::Ge(rest, hn::Zero(d)), hn::Le(turn_squared, hn::Mul(rest, rest)));
    return ~bits_of(is_one) & at.lanes;
  }
  HWY_INLINE V need() const { return hn::Add(change, hn::Sqrt(turn_squared)); }
};

// How a group's pieces are cut into steps.
struct PieceSteps {
  V from, step;  // shares of the piece: where what is drawn begins, and of each step
  V count;
  V path;  // of a step, unit distances of the look
};

// One over 1, 2, 4, 8 or 16.
HWY_INLINE V inverse_of_power(V power_of_two) {
  constexpr std::int32_t kTwiceOne = 2 * 0x3F800000;  // the bits of 1
  return hn::BitCast(d, hn::Sub(hn::Set(di, kTwiceOne), hn::BitCast(di, power_of_two)));
}

// Drops the pieces of which nothing is left. `count`: of steps.
template <class PartOf>
HWY_INLINE PieceSteps steps_of(const CpuFrame& frame, const BlockPlace& place, PieceGroup& group,
                               V count, const PartOf& part_of) {
  PieceSteps steps;
  steps.count = count;
  steps.from = hn::Zero(d);
  steps.step = inverse_of_power(count);
  const bool is_whole = (group.ends.front & group.ends.back & group.at.lanes) == group.at.lanes;
  if (!is_whole || frame.is_clipped) {
    PiecePart part{hn::Zero(d), hn::Set(d, 1.0F)};
    if (!is_whole) part = part_of(group.at, group.ends);
    if (frame.is_clipped) part = cut_part(frame, place, group.at, part);
    const V length = hn::Sub(part.to, part.from);
    group.at.lanes &= bits_of(hn::Gt(length, hn::Zero(d)));
    steps.from = part.from;
    steps.step = hn::Mul(length, steps.step);
  }
  steps.path = hn::Mul(steps.step, hn::Set(d, frame.look.constants.path_in_units));
  if (!frame.is_parallel) {
    steps.path = hn::Mul(steps.path, ray_length(frame, place, group.at.column, group.at.row));
  }
  return steps;
}

// What a group's pieces take in either way, in processor cycles: measured, and only to choose by.
inline constexpr int kCyclesOfStep = 90;
inline constexpr int kCyclesOfPiece = 30;
inline constexpr int kCyclesOfSample = 10;

// The most steps that a group's pieces have, or 0 if the lanes of their samples are better steps
// than pixels.
HWY_INLINE int steps_of_pixels(V count, std::uint32_t lanes, std::uint32_t with_more) {
  const int pieces = std::popcount(lanes);
  int samples = pieces + std::popcount(with_more);
  int most = with_more == 0 ? 1 : 2;
  for (; most > 1 && most < view::kMostSteps; most *= 2) {
    const V least = hn::Set(d, static_cast<float>(most));
    const int more = std::popcount(bits_of(hn::Gt(count, least)) & lanes);
    if (more == 0) break;
    samples += most * more;
  }
  return most * kCyclesOfStep < pieces * kCyclesOfPiece + samples * kCyclesOfSample ? most : 0;
}

// Runs `body(numbers at both ends, where they go)` for each number that samples have.
template <class Body>
HWY_INLINE void for_each_number(const CpuFrame& frame, const PieceGroup& group, SampleBatch& batch,
                                const Body& body) {
  body(group.value, batch.value);
  if (frame.has_own_color) body(group.color, batch.color_value);
  if (frame.takes_gradients) {
    body(group.gradient.x, batch.gradient[0]);
    body(group.gradient.y, batch.gradient[1]);
    body(group.gradient.z, batch.gradient[2]);
  }
  if (frame.fades_at_cuts) body(group.clearance, batch.clearance);
  if (frame.light == nullptr) return;
  body(group.around, batch.around);
  if (frame.has_key_light) body(group.key, batch.key);
}

// Lanes are pixels.
HWY_INLINE void add_steps(const CpuFrame& frame, const TileInHand& tile, const PieceGroup& group,
                          const PieceSteps& steps, int most) {
  SampleBatch& batch = tile.batch;
  const int pixel = tile_index(tile.place, group.at.column, group.at.row);
  const EndValues depth = depths_of(frame, tile.place, group.at.s);
  for (int i = 0; i < most; ++i) {
    const int first = batch.num_samples;
    const V m = hn::Set(d, static_cast<float>(i) + 0.5F);
    const V t = hn::MulAdd(m, steps.step, steps.from);
    for_each_number(frame, group, batch, [&](const EndValues& ends, SampleBatch::Floats& to) {
      hn::StoreU(ends.at(t), d, &to[first]);
    });
    hn::StoreU(steps.path, d, &batch.path[first]);
    hn::StoreU(depth.at(t), d, &batch.depth[first]);
    if (!frame.is_parallel) {
      const WorldVector eye = direction_to_eye(frame, tile.place, group.at.column, group.at.row);
      hn::StoreU(eye.x, d, &batch.eye[0][first]);
      hn::StoreU(eye.y, d, &batch.eye[1][first]);
      hn::StoreU(eye.z, d, &batch.eye[2][first]);
    }
    const std::uint32_t lanes = bits_of(hn::Lt(m, steps.count)) & group.at.lanes;
    batch.runs[batch.num_runs++] = {pixel, first, 0, lanes};
    batch.num_samples += group_size();
  }
}

// Lanes are the steps of a piece.
inline void add_pieces_alone(const CpuFrame& frame, const TileInHand& tile, const PieceGroup& group,
                             const PieceSteps& steps) {
  SampleBatch& batch = tile.batch;
  const int pixel = tile_index(tile.place, group.at.column, group.at.row);
  constexpr int kLanes = SampleBatch::kGroup;
  alignas(64) float count[kLanes];
  alignas(64) float path[kLanes];
  hn::Store(steps.count, d, count);
  hn::Store(steps.path, d, path);
  const int first = batch.num_samples;
  const V number = hn::Iota(d, 0.0F);
  // Runs `body(lane, count, where its samples begin)` for each piece.
  const auto for_each_piece = [&](const auto& body) {
    int next = first;
    for (std::uint32_t left = group.at.lanes; left != 0; left &= left - 1) {
      const int lane = std::countr_zero(left);
      const auto samples = static_cast<int>(count[lane]);
      body(lane, samples, next);
      next += samples;
    }
    return next;
  };
  batch.num_samples = for_each_piece([&](int lane, int samples, int to) {
    batch.runs[batch.num_runs++] = {pixel + lane, to, samples, 1U << lane};
    for (int i = 0; i < samples; i += group_size())
      hn::StoreU(hn::Set(d, path[lane]), d, &batch.path[to + i]);
  });
  const V t = hn::MulAdd(steps.step, hn::Set(d, 0.5F), steps.from);
  const auto add_line = [&](const EndValues& ends, SampleBatch::Floats& to) {
    alignas(64) float begin[kLanes];
    alignas(64) float rise[kLanes];
    hn::Store(ends.at(t), d, begin);
    hn::Store(hn::Mul(hn::Sub(ends.back, ends.front), steps.step), d, rise);
    for_each_piece([&](int lane, int samples, int at) {
      for (int i = 0; i < samples; i += group_size()) {
        const V m = hn::Add(number, hn::Set(d, static_cast<float>(i)));
        hn::StoreU(hn::MulAdd(m, hn::Set(d, rise[lane]), hn::Set(d, begin[lane])), d, &to[at + i]);
      }
    });
  };
  for_each_number(frame, group, batch, add_line);
  add_line(depths_of(frame, tile.place, group.at.s), batch.depth);
  if (frame.is_parallel) return;
  for (int a = 0; a < 3; ++a) {
    for_each_piece([&](int lane, int samples, int to) {
      for (int i = 0; i < samples; i += group_size())
        hn::StoreU(hn::Set(d, tile.place.rays->eye[a][pixel + lane]), d, &batch.eye[a][to + i]);
    });
  }
}

// A step of a group's pieces joins the pixels.
HWY_INLINE void composite_step(const CpuFrame& frame, const TileInHand& tile,
                               const SampleBatch::Run& run) {
  const SampleBatch& batch = tile.batch;
  const auto load = [&](const SampleBatch::Floats& floats) {
    return hn::LoadU(d, &floats[run.first]);
  };
  GroupPixels pixels = load_pixels(tile.pixels, run.pixel);
  // Nothing is added behind what is opaque, be it by an earlier step.
  const V opaque_at = hn::Set(d, frame.opaque_at);
  const V opacity = load(batch.opacity);
  const M is_visible = hn::And(hn::And(mask_of(run.lanes), hn::Lt(pixels.alpha, opaque_at)),
                               hn::Gt(opacity, hn::Zero(d)));
  tile.stats.samples_shaded += std::popcount(bits_of(is_visible));
  add_to_pixels({load(batch.red), load(batch.green), load(batch.blue)},
                hn::IfThenElseZero(is_visible, opacity), load(batch.depth), pixels,
                tile.pixels.front_depth + run.pixel);
  store_pixels(pixels, tile.pixels, run.pixel);
  const M opaque = hn::And(is_visible, hn::Ge(pixels.alpha, opaque_at));
  tile.pixels.open[run.pixel / kTileSize] &= ~(RowWord{bits_of(opaque)} << (run.pixel % kTileSize));
}

// A pixel while a piece joins it.
struct PixelSoFar {
  float red, green, blue, alpha, depth, front_depth;
};

// Samples of a piece, front to back, one after the other.
inline int add_samples(const CpuFrame& frame, const SampleBatch& batch, int first, int end,
                       PixelSoFar& pixel) {
  int visible = 0;
  for (int i = first; i < end && pixel.alpha < frame.opaque_at; ++i) {
    const float before = pixel.alpha;
    const float share = (1 - before) * std::max(batch.opacity[i], 0.0F);
    visible += share > 0 ? 1 : 0;
    pixel.red += share * batch.red[i];
    pixel.green += share * batch.green[i];
    pixel.blue += share * batch.blue[i];
    pixel.alpha = before + share;
    if (before < 0.5F && pixel.alpha >= 0.5F) pixel.depth = batch.depth[i];
    if (before < kLeastVisibleOpacity && pixel.alpha >= kLeastVisibleOpacity)
      pixel.front_depth = batch.depth[i];
  }
  return visible;
}

#if HWY_TARGET != HWY_SCALAR
// Of each lane the product of those before it; of the first, 1.
HWY_INLINE V products_before(V x) {
  const VI lane = hn::Iota(di, 0);
  const V one = hn::Set(d, 1.0F);
  const auto from = [&](V v, int lanes) {
    const VI index = hn::Max(hn::Sub(lane, hn::Set(di, lanes)), hn::Zero(di));
    const M is_beyond = hn::RebindMask(d, hn::Lt(lane, hn::Set(di, lanes)));
    return hn::IfThenElse(is_beyond, one, hn::TableLookupLanes(v, hn::IndicesFromVec(d, index)));
  };
  V product = from(x, 1);
  for (int lanes = 1; lanes < group_size(); lanes *= 2)
    product = hn::Mul(product, from(product, lanes));
  return product;
}

// The same of as many as a group has, at once.
HWY_INLINE int add_group_of_samples(const CpuFrame& frame, const SampleBatch& batch, int first,
                                    int count, PixelSoFar& pixel) {
  const auto load = [&](const SampleBatch::Floats& floats) { return hn::LoadU(d, &floats[first]); };
  const M exists = hn::FirstN(d, static_cast<std::size_t>(count));
  const V opacity = hn::IfThenElseZero(exists, hn::Max(load(batch.opacity), hn::Zero(d)));
  const V one = hn::Set(d, 1.0F);
  const V through = hn::Mul(products_before(hn::Sub(one, opacity)), hn::Set(d, 1 - pixel.alpha));
  const M is_open = hn::Lt(hn::Sub(one, through), hn::Set(d, frame.opaque_at));
  const V share = hn::IfThenElseZero(is_open, hn::Mul(through, opacity));
  const auto sum_of = [&](V v) { return hn::GetLane(hn::SumOfLanes(d, v)); };
  pixel.red += sum_of(hn::Mul(share, load(batch.red)));
  pixel.green += sum_of(hn::Mul(share, load(batch.green)));
  pixel.blue += sum_of(hn::Mul(share, load(batch.blue)));
  if (pixel.alpha < 0.5F) {
    const V behind = hn::Sub(one, hn::Sub(through, share));
    const auto note_depth = [&](float opacity, float& depth) {
      const std::uint32_t reach = bits_of(hn::And(exists, hn::Ge(behind, hn::Set(d, opacity))));
      if (reach != 0) depth = batch.depth[first + std::countr_zero(reach)];
    };
    note_depth(0.5F, pixel.depth);
    if (pixel.alpha < kLeastVisibleOpacity) note_depth(kLeastVisibleOpacity, pixel.front_depth);
  }
  pixel.alpha += sum_of(share);
  return std::popcount(bits_of(hn::Gt(share, hn::Zero(d))));
}
#endif

// Shorter runs are quicker one by one.
inline constexpr int kLeastOfGroup = 8;

// The samples of a piece join its pixel.
inline void composite_piece(const CpuFrame& frame, const TileInHand& tile,
                            const SampleBatch::Run& run) {
  TileState& pixels = tile.pixels;
  const int at = run.pixel;
  PixelSoFar pixel{pixels.red[at],   pixels.green[at], pixels.blue[at],
                   pixels.alpha[at], pixels.depth[at], pixels.front_depth[at]};
  if (pixel.alpha >= frame.opaque_at) return;
  const int end = run.first + run.count;
  int next = run.first;
#if HWY_TARGET != HWY_SCALAR
  while (group_size() >= kLeastOfGroup && end - next >= kLeastOfGroup &&
         pixel.alpha < frame.opaque_at) {
    const int count = std::min(end - next, group_size());
    tile.stats.samples_shaded += add_group_of_samples(frame, tile.batch, next, count, pixel);
    next += count;
  }
#endif
  tile.stats.samples_shaded += add_samples(frame, tile.batch, next, end, pixel);
  pixels.red[at] = pixel.red;
  pixels.green[at] = pixel.green;
  pixels.blue[at] = pixel.blue;
  pixels.alpha[at] = pixel.alpha;
  pixels.depth[at] = pixel.depth;
  pixels.front_depth[at] = pixel.front_depth;
  if (pixel.alpha >= frame.opaque_at)
    pixels.open[at / kTileSize] &= ~(RowWord{1} << (at % kTileSize));
}

// Draws the samples of the batch, and empties it.
inline void flush_batch(const CpuFrame& frame, const TileInHand& tile) {
  SampleBatch& batch = tile.batch;
  shade_batch(frame, batch);
  for (int i = 0; i < batch.num_runs; ++i) {
    const SampleBatch::Run& run = batch.runs[i];
    run.count == 0 ? composite_step(frame, tile, run) : composite_piece(frame, tile, run);
  }
  batch.num_samples = batch.num_runs = 0;
}

// Samples of a group's pieces join the batch.
template <class PartOf>
HWY_INLINE void add_pieces(const CpuFrame& frame, const TileInHand& tile, PieceGroup& group,
                           const PartOf& part_of) {
  if (!tile.batch.has_room()) flush_batch(frame, tile);
  const std::uint32_t with_more = group.take_more_steps();
  const V count = with_more == 0 ? hn::Set(d, 1.0F) : steps_for(group.need());
  const PieceSteps steps = steps_of(frame, tile.place, group, count, part_of);
  if (group.at.lanes == 0) return;
  if (const int most = steps_of_pixels(count, group.at.lanes, with_more); most > 0) {
    add_steps(frame, tile, group, steps, most);
  } else {
    add_pieces_alone(frame, tile, group, steps);
  }
}

// How much light arrives at a group's samples, which the sheet keeps for the piece behind it.
// `lanes`: those that are ends.
HWY_INLINE void light_ends(const CpuFrame& frame, const BlockPlace& place, Sheet& sheet,
                           const SampleGroup& group, std::uint32_t lanes) {
  if ((lanes_at(sheet.has_light[group.row], group.column) & lanes) == lanes) return;
  const int at = sheet.at(group.column, group.row);
  WorldVector gradient = no_gradient();
  if (frame.is_lit) {
    gradient = {hn::LoadU(d, sheet.gradient[0] + at), hn::LoadU(d, sheet.gradient[1] + at),
                hn::LoadU(d, sheet.gradient[2] + at)};
  }
  V distance;
  if (frame.fades_at_cuts) distance = clearance_of(frame, place, group);
  const ArrivingShares arriving = arriving_at_sample(
      frame, place, group, gradient, direction_to_eye(frame, place, group.column, group.row),
      frame.fades_at_cuts ? &distance : nullptr);
  const M mask = mask_of(lanes);
  hn::BlendedStore(arriving.around, mask, d, sheet.around + at);
  if (frame.has_key_light) hn::BlendedStore(arriving.key, mask, d, sheet.key + at);
  sheet.has_light[group.row] |= RowWord{lanes} << group.column;
}

// The pieces that end at a group's samples, whose gradients are there, if they are taken.
HWY_INLINE PieceGroup pieces_of(const CpuFrame& frame, const TileInHand& tile,
                                const SampleGroup& at) {
  Sheet& front = tile.ring[tile.place.number_of(at.s - 1)];
  Sheet& back = tile.ring[tile.place.number_of(at.s)];
  const int place = back.at(at.column, at.row);
  PieceGroup group;  // what is not asked for stays as it is
  group.at = at;
  group.ends = ends_of(tile.place, tile.ring, at);
  const GroupEnds of_ends(group.ends);
  const auto both = [&](const float* f, const float* b) { return of_ends(f + place, b + place); };
  group.value = both(front.values, back.values);
  if (frame.has_own_color) group.color = both(front.colors, back.colors);
  group.change =
      hn::Mul(hn::LoadU(d, tile.shaded.alpha + place), hn::Set(d, view::kStepsPerVariation));
  group.turn_squared = hn::Zero(d);
  if (frame.takes_gradients) {
    group.gradient = {both(front.gradient[0], back.gradient[0]),
                      both(front.gradient[1], back.gradient[1]),
                      both(front.gradient[2], back.gradient[2])};
    group.turn_squared = group.gradient.turn_squared(frame.look.constants.flat_gradient_inverse);
  }
  if (frame.look.plane.entries != nullptr) {
    const auto [front_length, back_length] = group.gradient.lengths();
    const V by_gradient = hn::Abs(hn::Sub(plane_variation(frame.look.plane, back_length),
                                          plane_variation(frame.look.plane, front_length)));
    group.change = hn::MulAdd(by_gradient, hn::Set(d, view::kStepsPerVariation), group.change);
  }
  if (frame.fades_at_cuts) {
    group.clearance = {clearance_of(frame, tile.place, {at.s - 1, at.column, at.row, at.lanes}),
                       clearance_of(frame, tile.place, at)};
  }
  if (frame.light != nullptr) {
    light_ends(frame, tile.place, front, {at.s - 1, at.column, at.row, at.lanes},
               group.ends.front & at.lanes);
    light_ends(frame, tile.place, back, at, group.ends.back & at.lanes);
    group.around = both(front.around, back.around);
    if (frame.has_key_light) group.key = both(front.key, back.key);
  }
  return group;
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
                     PieceGroup group = pieces_of(frame, tile, {s, column, y, lanes});
                     add_pieces(frame, tile, group, part_of);
                   });
  }
  flush_batch(frame, tile);
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
