// SPDX-License-Identifier: Apache-2.0
// Depth limits: where along its ray each pixel of a tile draws the field, and what joins it there
// (docs/numerics.md, "Depth limits").
//
// A pixel is at one span of its ray at a time. What stands before the span joins the pixel when
// something of the span does; a pixel that has no further span takes what is left, and closes. All
// of it is scalar: a pixel has a few stops, and hundreds of samples.
#if defined(OVOID_RENDER_CPU_LIMITS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_LIMITS_INL_H_
#undef OVOID_RENDER_CPU_LIMITS_INL_H_
#else
#define OVOID_RENDER_CPU_LIMITS_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <limits>

#include "render/cpu/composite-inl.h"

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
  if (from < end) return;
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

// Runs `body(pixel)` for each sample of a plane, be it open or not, whose pixel is the tile's.
template <class Body>
HWY_INLINE void for_each_pixel(const BlockPlace& place, const RowBits& bits, const Body& body) {
  for (int y = place.margin; y < place.rows - place.margin; ++y) {
    for (RowWord left = bits[y]; left != 0; left &= left - 1) {
      const int column = std::countr_zero(left);
      body(y, column, tile_index(place, column, y));
    }
  }
}

// Leaves the spans that end at `depth` or before it, of the pixels of a plane's samples.
inline void leave_spans(const CpuFrame& frame, const BlockPlace& place, const RowBits& bits,
                        float depth, TileState& tile) {
  TileLimits& limits = *place.limits;
  for_each_pixel(place, bits, [&](int, int, int pixel) {
    while (limits.leave[pixel] <= depth)
      enter_span(frame, limits.span[pixel] + 1, pixel, limits, tile);
  });
}

// Of samples, those whose span reaches into the depths from `near` to `far`; what stands before
// these spans joins the pixels.
inline RowBits within_spans(const CpuFrame& frame, const BlockPlace& place, const RowBits& bits,
                            float near, float far, TileState& tile) {
  TileLimits& limits = *place.limits;
  RowBits within{};
  for_each_pixel(place, bits, [&](int row, int column, int pixel) {
    if (!(limits.enter[pixel] < far && limits.leave[pixel] > near)) return;
    show_stops(frame, limits.span[pixel] + 1, pixel, limits, tile);
    within[row] |= RowWord{1} << column;
  });
  return within;
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
  for_each_pixel(place, with_path, [&](int, int, int pixel) {
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
