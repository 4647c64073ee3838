// SPDX-License-Identifier: Apache-2.0
// Stage "composite": one sheet's samples join the tile's pixels, front to back; a pixel that has
// become opaque is closed.
//
// In:  visible samples with opacity and colour (composite), or defined samples (x-ray, maximum,
// minimum, mean). Out: the tile's state.
#if defined(OVOID_RENDER_CPU_COMPOSITE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_COMPOSITE_INL_H_
#undef OVOID_RENDER_CPU_COMPOSITE_INL_H_
#else
#define OVOID_RENDER_CPU_COMPOSITE_INL_H_
#endif

#include "render/cpu/shade/path-inl.h"
#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

HWY_INLINE int tile_row(const BlockPlace& place, int row) { return place.y0 + row - place.margin; }
HWY_INLINE int tile_column(const BlockPlace& place, int column) {
  return place.x0 + column - place.margin;
}

HWY_INLINE void store_masked(M mask, V value, float* to) {
  hn::StoreU(hn::IfThenElse(mask, value, hn::LoadU(d, to)), d, to);
}

// Pixels of a tile that a group draws on.
struct GroupPixels {
  V red, green, blue, alpha, depth;
};

HWY_INLINE GroupPixels load_pixels(const TileState& tile, int at) {
  return {hn::LoadU(d, tile.red + at), hn::LoadU(d, tile.green + at), hn::LoadU(d, tile.blue + at),
          hn::LoadU(d, tile.alpha + at), hn::LoadU(d, tile.depth + at)};
}

HWY_INLINE void store_pixels(const GroupPixels& pixels, TileState& tile, int at) {
  hn::StoreU(pixels.red, d, tile.red + at);
  hn::StoreU(pixels.green, d, tile.green + at);
  hn::StoreU(pixels.blue, d, tile.blue + at);
  hn::StoreU(pixels.alpha, d, tile.alpha + at);
  hn::StoreU(pixels.depth, d, tile.depth + at);
}

struct GroupColor {
  V red, green, blue;
};

// A group's pixels had the opacities `before`, and what has just joined them at a depth brings them
// to `after`. Most have been seen long before, or are not seen yet.
HWY_INLINE void note_front_depth(V before, V after, V depth, float* front_depth) {
  const V least = hn::Set(d, kLeastVisibleOpacity);
  const M is_reached = hn::And(hn::Lt(before, least), hn::Ge(after, least));
  if (!hn::AllFalse(d, is_reached)) store_masked(is_reached, depth, front_depth);
}

// What a pixel has in front of it hides its share.
HWY_INLINE void add_to_pixels(const GroupColor& seen, V alpha, V depth, GroupPixels& pixels,
                              float* front_depth) {
  const V half = hn::Set(d, 0.5F);
  const V before = pixels.alpha;
  const V share = hn::Mul(hn::Sub(hn::Set(d, 1.0F), before), alpha);
  pixels.alpha = hn::Add(before, share);
  pixels.red = hn::MulAdd(share, seen.red, pixels.red);
  pixels.green = hn::MulAdd(share, seen.green, pixels.green);
  pixels.blue = hn::MulAdd(share, seen.blue, pixels.blue);
  const M reaches_half = hn::And(hn::Lt(before, half), hn::Ge(pixels.alpha, half));
  pixels.depth = hn::IfThenElse(reaches_half, depth, pixels.depth);
  note_front_depth(before, pixels.alpha, depth, front_depth);
}

// A surface joins the lanes of `mask`, behind what is in front of it. Returns those that it closes.
HWY_INLINE std::uint32_t add_surface(const CpuFrame& frame, const GroupColor& lit, float opacity,
                                     M mask, V depth, TileState& tile, int pixel) {
  const V in_front = hn::LoadU(d, tile.alpha + pixel);
  V share = hn::Sub(hn::Set(d, 1.0F), in_front);
  V after = hn::Set(d, 1.0F);
  if (opacity < 1) {
    share = hn::Mul(share, hn::Set(d, opacity));
    after = hn::Add(in_front, share);
  }
  const auto add = [&](float* sum, V color) {
    store_masked(mask, hn::MulAdd(share, color, hn::LoadU(d, sum + pixel)), sum + pixel);
  };
  add(tile.red, lit.red);
  add(tile.green, lit.green);
  add(tile.blue, lit.blue);
  store_masked(mask, after, tile.alpha + pixel);
  const auto note_depth = [&](float bound, float* depths) {
    const V least = hn::Set(d, bound);
    const M is_reached = hn::And(hn::Lt(in_front, least), hn::Ge(after, least));
    store_masked(hn::And(mask, is_reached), depth, depths + pixel);
  };
  note_depth(0.5F, tile.depth);
  note_depth(kLeastVisibleOpacity, tile.front_depth);
  return bits_of(hn::And(mask, hn::Ge(after, hn::Set(d, frame.opaque_at))));
}

// Runs `draw(surface, lanes)` for the surfaces that a group's lanes meet between two values, each
// lane's in the order in which it meets them where the value goes straight.
template <class Draw>
HWY_INLINE void for_each_surface(const CpuFrame& frame, V before, V after, std::uint32_t lanes,
                                 const Draw& draw) {
  const std::vector<FrameSurface>& surfaces = frame.look.surfaces;
  const auto draw_crossed = [&](const FrameSurface& surface, std::uint32_t of) {
    const V iso = hn::Set(d, surface.value);
    const std::uint32_t crossed = bits_of(hn::Xor(hn::Lt(before, iso), hn::Lt(after, iso))) & of;
    if (crossed != 0) draw(surface, crossed);
  };
  if (surfaces.size() == 1) return draw_crossed(surfaces.front(), lanes);
  const std::uint32_t rising = bits_of(hn::Lt(before, after)) & lanes;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (rising != 0) draw_crossed(surfaces[i], rising);
    if (rising != lanes) draw_crossed(surfaces[surfaces.size() - 1 - i], lanes & ~rising);
  }
}

inline void composite_sheet(const CpuFrame& frame, const BlockPlace& place, int s,
                            const ShadedSheet& shaded, TileState& tile) {
  for (int y = 0; y < place.rows; ++y) {
    if (shaded.visible[y] == 0) continue;  // as in all rows of the margin, which the tile lacks
    // Nothing is added behind what is opaque, even if it was worked out.
    RowWord& open = tile.open[tile_row(place, y)];
    for_each_group(shaded.visible[y] & open >> place.x0 << place.margin, place.margin,
                   place.columns - place.margin, [&](int column, std::uint32_t lanes) {
                     const int from = y * kTilePlane.stride + column;
                     const int to = tile_index(place, column, y);
                     GroupPixels pixels = load_pixels(tile, to);
                     add_to_pixels(
                         {hn::LoadU(d, shaded.red + from), hn::LoadU(d, shaded.green + from),
                          hn::LoadU(d, shaded.blue + from)},
                         hn::IfThenElseZero(mask_of(lanes), hn::LoadU(d, shaded.alpha + from)),
                         hn::Set(d, place.sheets[s].depth), pixels, tile.front_depth + to);
                     store_pixels(pixels, tile, to);
                     const M opaque = hn::Ge(pixels.alpha, hn::Set(d, frame.opaque_at));
                     open &= ~(RowWord{bits_of(opaque) & lanes} << tile_column(place, column));
                   });
  }
}

// What a group's samples, or what is left of its pieces, say of their pixels.
struct GroupOfValues {
  V value, depth;
};

// Maximum and minimum. `at`: the group's lanes are those that say something.
HWY_INLINE void note_extreme(const CpuFrame& frame, const BlockPlace& place, const SampleGroup& at,
                             const GroupOfValues& found, TileState& tile) {
  const M mask = mask_of(at.lanes);
  const int to = tile_index(place, at.column, at.row);
  RowWord& seen_row = tile.seen[tile_row(place, at.row)];
  const M seen = mask_of(lanes_at(seen_row, tile_column(place, at.column)));
  const V best = hn::LoadU(d, tile.best + to);
  const M better =
      frame.mode == Mode::kMaximum ? hn::Gt(found.value, best) : hn::Lt(found.value, best);
  const M is_new = hn::And(mask, hn::Or(better, hn::Not(seen)));
  store_masked(is_new, found.value, tile.best + to);
  store_masked(is_new, found.depth, tile.depth + to);
  seen_row |= RowWord{at.lanes} << tile_column(place, at.column);
}

// X-ray and mean. `length`: of the path, world units.
HWY_INLINE void add_to_sum(const BlockPlace& place, const SampleGroup& at,
                           const GroupOfValues& found, V length, TileState& tile) {
  const M mask = mask_of(at.lanes);
  const int to = tile_index(place, at.column, at.row);
  RowWord& seen_row = tile.seen[tile_row(place, at.row)];
  const M seen = mask_of(lanes_at(seen_row, tile_column(place, at.column)));
  const V sum = hn::IfThenElseZero(seen, hn::LoadU(d, tile.best + to));
  store_masked(mask, hn::MulAdd(found.value, length, sum), tile.best + to);
  store_masked(mask, hn::Add(length, hn::LoadU(d, tile.path + to)), tile.path + to);
  store_masked(hn::AndNot(seen, mask), found.depth, tile.depth + to);
  seen_row |= RowWord{at.lanes} << tile_column(place, at.column);
}

inline bool shows_an_extreme(const CpuFrame& frame) {
  return frame.mode == Mode::kMaximum || frame.mode == Mode::kMinimum;
}

// X-ray, maximum, minimum and mean: every defined sample counts.
inline void accumulate_sheet(const CpuFrame& frame, const BlockPlace& place, int s,
                             const float* values, const RowBits& bits, TileState& tile) {
  for (int y = 0; y < place.rows; ++y) {
    for_each_group(
        bits[y], place.margin, place.columns - place.margin, [&](int column, std::uint32_t lanes) {
          const SampleGroup at{s, column, y, lanes};
          const GroupOfValues found{hn::LoadU(d, values + y * kTilePlane.stride + column),
                                    hn::Set(d, place.sheets[s].depth)};
          if (shows_an_extreme(frame)) return note_extreme(frame, place, at, found, tile);
          const V length = hn::Mul(hn::Mul(path_fraction(frame, place, s, column, y),
                                           ray_length(frame, place, column, y)),
                                   hn::Set(d, frame.camera.sampling_distance));
          add_to_sum(place, at, found, length, tile);
        });
  }
}

// X-ray and mean: the sum of all sheets' values at once, all of them defined and their paths whole.
inline void accumulate_sum(const CpuFrame& frame, const BlockPlace& place, const float* sums,
                           TileState& tile) {
  const RowWord all = first_bits(place.columns);
  for (int y = 0; y < place.rows; ++y) {
    for_each_group(all, 0, place.columns, [&](int column, std::uint32_t lanes) {
      const M mask = mask_of(lanes);
      const int to = tile_index(place, column, y);
      const M seen = mask_of(lanes_at(tile.seen[y], column));
      const V length =
          hn::Mul(ray_length(frame, place, column, y), hn::Set(d, frame.camera.sampling_distance));
      const V sum = hn::IfThenElseZero(seen, hn::LoadU(d, tile.best + to));
      const V value = hn::LoadU(d, sums + y * kTilePlane.stride + column);
      store_masked(mask, hn::MulAdd(value, length, sum), tile.best + to);
      store_masked(mask,
                   hn::MulAdd(hn::Set(d, static_cast<float>(place.num_sheets)), length,
                              hn::LoadU(d, tile.path + to)),
                   tile.path + to);
      store_masked(hn::AndNot(seen, mask), hn::Set(d, place.sheets[0].depth), tile.depth + to);
    });
    tile.seen[y] |= all;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
