// SPDX-License-Identifier: Apache-2.0
// Depth limits: where along its ray each pixel of a tile draws the field, and what joins it there
// (docs/numerics.md, "Depth limits").
//
// A pixel is at one span of its ray at a time. What stands before the span joins the pixel when
// something of the span does; a pixel that has no further span takes what is left, and closes. A
// pixel has a few stops and hundreds of samples: groups of pixels are asked together whether any of
// them comes to a stop, and only those that do are looked at one by one.
#if defined(OVOID_RENDER_CPU_LIMITS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_LIMITS_INL_H_
#undef OVOID_RENDER_CPU_LIMITS_INL_H_
#else
#define OVOID_RENDER_CPU_LIMITS_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <limits>

#include "render/cpu/shade/composite-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

inline void close_pixel(TileState& tile, int pixel) {
  tile.open[pixel / kTileSize] &= ~(RowWord{1} << (pixel % kTileSize));
}

// Stops before number `end` join a pixel.
inline void show_stops(const CpuFrame& frame, std::uint32_t end, int pixel, TileLimits& limits,
                       TileState& tile) {
  for (std::uint32_t& next = limits.shown[pixel]; next < end; ++next) {
    const float before = tile.alpha[pixel];
    if (!frame.takes_colors_of_stops || before >= frame.opaque_at) continue;
    const DepthLimits::Stop& stop = frame.limits->stops[next];
    tile.red[pixel] += (1 - before) * stop.rgba[0];
    tile.green[pixel] += (1 - before) * stop.rgba[1];
    tile.blue[pixel] += (1 - before) * stop.rgba[2];
    tile.alpha[pixel] = before + (1 - before) * stop.rgba[3];
    const auto note_depth = [&](float opacity, float* depths) {
      if (before < opacity && tile.alpha[pixel] >= opacity) depths[pixel] = stop.depth;
    };
    note_depth(0.5F, tile.depth);
    note_depth(kLeastVisibleOpacity, tile.front_depth);
    if (tile.alpha[pixel] >= frame.opaque_at) close_pixel(tile, pixel);
  }
}

// The pixel's first span that begins at stop `from` or later.
inline void enter_span(const CpuFrame& frame, std::uint32_t from, int pixel, TileLimits& limits,
                       TileState& tile) {
  const std::uint32_t end = limits.end[pixel];
  const DepthLimits::Stop* const stops = frame.limits->stops.data();
  while (from < end && !stops[from].is_field_behind) ++from;
  limits.span[pixel] = from;
  constexpr float kEndless = std::numeric_limits<float>::infinity();
  limits.enter[pixel] = from < end ? stops[from].depth : kEndless;
  limits.leave[pixel] = from + 1 < end ? stops[from + 1].depth : kEndless;
  limits.begins[pixel] = from < end && stops[from].is_seam ? -kEndless : limits.enter[pixel];
  limits.ends[pixel] = from + 1 < end && stops[from + 1].is_seam ? kEndless : limits.leave[pixel];
  if (from < end || frame.draws_beyond_limits) return;
  show_stops(frame, end, pixel, limits, tile);
  close_pixel(tile, pixel);
}

// Of the tile at a pixel of the picture, whose state is empty.
inline void set_up_limits(const CpuFrame& frame, int tile_x, int tile_y, TileLimits& limits,
                          TileState& tile) {
  if (frame.limits == nullptr) return;
  // Pixels that the picture lacks have no stops.
  std::fill_n(limits.shown, TileState::kPixels, 0U);
  std::fill_n(limits.end, TileState::kPixels, 0U);
  for (int y = 0; y < kTileSize; ++y) {
    for (RowWord open = tile.open[y]; open != 0; open &= open - 1) {
      const int x = std::countr_zero(open);
      const std::size_t at =
          static_cast<std::size_t>(tile_y + y) * static_cast<std::size_t>(frame.limits->width) +
          static_cast<std::size_t>(tile_x + x);
      const int pixel = y * kTileSize + x;
      limits.shown[pixel] = frame.limits->first[at];
      limits.end[pixel] = frame.limits->first[at + 1];
      enter_span(frame, frame.limits->first[at], pixel, limits, tile);
    }
  }
}

// Runs `body(row, column, pixel)` for those samples of a plane, be they open or not, for whose
// pixels `is_due(first pixel of a group)` says so.
template <class IsDue, class Body>
HWY_INLINE void for_each_pixel_where(const BlockPlace& place, const RowBits& bits,
                                     const IsDue& is_due, const Body& body) {
  for (int y = place.margin; y < place.rows - place.margin; ++y) {
    for_each_group(
        bits[y], place.margin, place.columns - place.margin, [&](int column, std::uint32_t lanes) {
          const int pixel = tile_index(place, column, y);
          for (std::uint32_t due = bits_of(is_due(pixel)) & lanes; due != 0; due &= due - 1) {
            const int lane = std::countr_zero(due);
            body(y, column + lane, pixel + lane);
          }
        });
  }
}

// Pixels of a group whose spans in hand end at `depth` or before it.
HWY_INLINE M end_by(const TileLimits& limits, int pixel, float depth) {
  return hn::Le(hn::LoadU(d, limits.leave + pixel), hn::Set(d, depth));
}

// Pixels of a group whose spans in hand begin with stops that have not joined them.
HWY_INLINE M begin_unseen(const TileLimits& limits, int pixel) {
  const hn::RebindToUnsigned<D> du;
  const auto is_seen =
      hn::Gt(hn::LoadU(du, limits.shown + pixel), hn::LoadU(du, limits.span + pixel));
  return hn::Not(hn::RebindMask(d, is_seen));
}

// Leaves the spans that end at `depth` or before it, of the pixels of a plane's samples.
inline void leave_spans(const CpuFrame& frame, const BlockPlace& place, const RowBits& bits,
                        float depth, TileState& tile) {
  TileLimits& limits = *place.limits;
  for_each_pixel_where(
      place, bits, [&](int pixel) { return end_by(limits, pixel, depth); },
      [&](int, int, int pixel) {
        while (limits.leave[pixel] <= depth)
          enter_span(frame, limits.span[pixel] + 1, pixel, limits, tile);
      });
}

// Of samples, those whose span in hand reaches into the depths from `near` to `far`.
inline RowBits reached_in_hand(const BlockPlace& place, const RowBits& bits, float near,
                               float far) {
  const TileLimits& limits = *place.limits;
  RowBits reached{};
  for (int y = place.margin; y < place.rows - place.margin; ++y) {
    for_each_group(
        bits[y], place.margin, place.columns - place.margin, [&](int column, std::uint32_t lanes) {
          const int pixel = tile_index(place, column, y);
          const M begins = hn::Lt(hn::LoadU(d, limits.enter + pixel), hn::Set(d, far));
          const std::uint32_t reach = bits_of(hn::AndNot(end_by(limits, pixel, near), begins));
          reached[y] |= RowWord{reach & lanes} << column;
        });
  }
  return reached;
}

// Of samples, those whose span reaches into the depths from `near` to `far`, once spans that end
// before are left.
inline RowBits reached_by_spans(const CpuFrame& frame, const BlockPlace& place, const RowBits& bits,
                                float near, float far, TileState& tile) {
  leave_spans(frame, place, bits, near, tile);
  return reached_in_hand(place, bits, near, far);
}

// The same of spans in hand; what stands before these spans joins the pixels.
inline RowBits within_spans(const CpuFrame& frame, const BlockPlace& place, const RowBits& bits,
                            float near, float far, TileState& tile) {
  TileLimits& limits = *place.limits;
  const RowBits within = reached_in_hand(place, bits, near, far);
  for_each_pixel_where(
      place, within, [&](int pixel) { return begin_unseen(limits, pixel); },
      [&](int, int, int pixel) { show_stops(frame, limits.span[pixel] + 1, pixel, limits, tile); });
  return within;
}

// Of samples, those whose span ends before `far`, which are at their next one then and no farther:
// a short one may end there, too.
inline RowBits at_next_spans(const CpuFrame& frame, const BlockPlace& place, const RowBits& bits,
                             float far, TileState& tile) {
  TileLimits& limits = *place.limits;
  RowBits next{};
  for_each_pixel_where(
      place, bits,
      [&](int pixel) { return hn::Lt(hn::LoadU(d, limits.leave + pixel), hn::Set(d, far)); },
      [&](int row, int column, int pixel) {
        enter_span(frame, limits.span[pixel] + 1, pixel, limits, tile);
        next[row] |= RowWord{1} << column;
      });
  return next;
}

// Drops the samples whose paths have no length.
inline void drop_without_path(const CpuFrame& frame, const BlockPlace& place, int s,
                              RowBits& bits) {
  for (int y = 0; y < place.rows; ++y) {
    for_each_group(bits[y], place.margin, place.columns - place.margin,
                   [&](int column, std::uint32_t lanes) {
                     const V path = path_fraction(frame, place, s, column, y);
                     const std::uint32_t gone = bits_of(hn::Le(path, hn::Zero(d))) & lanes;
                     bits[y] &= ~(RowWord{gone} << column);
                   });
  }
}

// Of samples on sheet s, those with a path; what stands before them joins the pixels.
inline RowBits with_path_within(const CpuFrame& frame, const BlockPlace& place, int s,
                                const RowBits& bits, TileState& tile) {
  const float depth = place.sheets[s].depth;
  leave_spans(frame, place, bits, depth - 0.5F * frame.camera.sampling_distance, tile);
  RowBits with_path = bits;
  drop_without_path(frame, place, s, with_path);
  TileLimits& limits = *place.limits;
  for_each_pixel_where(
      place, with_path,
      [&](int pixel) { return hn::Or(begin_unseen(limits, pixel), end_by(limits, pixel, depth)); },
      [&](int, int, int pixel) {
        std::uint32_t end = limits.span[pixel];
        while (end < limits.end[pixel] && frame.limits->stops[end].depth <= depth) ++end;
        show_stops(frame, end, pixel, limits, tile);
      });
  return with_path;
}

// Lanes of a group whose place at `depth` is within a span; what stands before it joins the pixels.
inline std::uint32_t within_spans(const CpuFrame& frame, const BlockPlace& place,
                                  const SampleGroup& group, V depth, TileState& tile) {
  if (place.limits == nullptr) return group.lanes;
  TileLimits& limits = *place.limits;
  alignas(64) float depths[16];
  hn::Store(depth, d, depths);
  std::uint32_t within = 0;
  for (std::uint32_t left = group.lanes; left != 0; left &= left - 1) {
    const int lane = std::countr_zero(left);
    const int pixel = tile_index(place, group.column, group.row) + lane;
    while (limits.leave[pixel] <= depths[lane])
      enter_span(frame, limits.span[pixel] + 1, pixel, limits, tile);
    if (limits.enter[pixel] > depths[lane]) continue;
    show_stops(frame, limits.span[pixel] + 1, pixel, limits, tile);
    if (tile.alpha[pixel] < frame.opaque_at) within |= 1U << lane;
  }
  return within;
}

// What is left of the stops of a tile that is done.
inline void show_last_stops(const CpuFrame& frame, TileLimits& limits, TileState& tile) {
  if (frame.limits == nullptr) return;
  for (int pixel = 0; pixel < kTileSize * kTileSize; ++pixel)
    show_stops(frame, limits.end[pixel], pixel, limits, tile);
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
