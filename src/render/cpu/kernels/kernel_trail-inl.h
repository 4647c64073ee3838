// SPDX-License-Identifier: Apache-2.0
// The trail behind a kernel field: the mean of other fields of the frame, its moments, on the same
// sheets (docs/numerics.md, "With a trail of kernel sets").
//
// A layer of blocks is summed moment by moment, before the field's own: each moment's sums become
// values on a sheet, which are added up. What is found waits in TrailSheets until the field has its
// sheet composited, then it comes behind that.
#if defined(OVOID_RENDER_CPU_KERNEL_TRAIL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_KERNEL_TRAIL_INL_H_
#undef OVOID_RENDER_CPU_KERNEL_TRAIL_INL_H_
#else
#define OVOID_RENDER_CPU_KERNEL_TRAIL_INL_H_
#endif

#include "render/cpu/kernels/kernel_sums-inl.h"
#include "render/cpu/shade/finish-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// For another tile.
inline void set_up_trail(TrailWorkspace& trail) {
  trail.next = {};
  for (auto& layers : trail.sheets) {
    for (TrailSheets& sheets : layers) sheets.layer = TrailSheets::kNone;
  }
  BlockPlace& place = trail.sums.place;
  place.x0 = place.y0 = 0;
  place.margin = 1;
  place.front_margin = place.back_margin = 0;
}

inline TrailSheets& trail_sheets(TrailWorkspace& trail, int sub, int layer) {
  return trail.sheets[static_cast<std::size_t>(sub)][static_cast<std::size_t>(layer & 1)];
}

// The number of a layer's sheet in the frame's lattice, by which it is in a ring.
inline std::int64_t number_in_ring(const KernelFrame& frame, int layer, int j) {
  return frame.kernel_plan->sheets.first + layer * view::kBlockDepth + j;
}

inline void clear_mean(const BlockPlace& place, Sheet& sheet, float* presence) {
  const std::size_t count =
      static_cast<std::size_t>(place.rows) * static_cast<std::size_t>(kTilePlane.stride);
  std::fill_n(sheet.values, count, 0.0F);
  std::fill_n(sheet.colors, count, 0.0F);
  std::fill_n(presence, count, 0.0F);
  sheet.clear();
}

// Adds the share of one moment, where it has values.
inline void add_moment(const BlockPlace& place, const MomentFrame& of, const Sheet& moment,
                       Sheet& mean, float* presence) {
  const auto add = [](M mask, V weight, const float* from, float* to) {
    const V sum = hn::MulAdd(weight, hn::LoadU(d, from), hn::LoadU(d, to));
    store_masked(mask, sum, to);
  };
  const V weight = hn::Set(d, of.share);
  for (int y = 0; y < place.rows; ++y) {
    mean.defined[y] |= moment.defined[y];
    for_each_group(moment.defined[y], 0, place.columns, [&](int column, std::uint32_t lanes) {
      const int at = mean.at(column, y);
      const M mask = mask_of(lanes);
      add(mask, weight, moment.values + at, mean.values + at);
      if (of.frame->has_own_color) add(mask, weight, moment.colors + at, mean.colors + at);
      store_masked(mask, hn::Add(hn::LoadU(d, presence + at), weight), presence + at);
    });
  }
}

// What has been added up becomes a mean.
inline void divide_mean(const BlockPlace& place, const float* presence, Sheet& mean) {
  for (int y = 0; y < place.rows; ++y) {
    for_each_group(mean.defined[y], 0, place.columns, [&](int column, std::uint32_t lanes) {
      const int at = mean.at(column, y);
      const M mask = mask_of(lanes);
      const V sum = hn::IfThenElse(mask, hn::LoadU(d, presence + at), hn::Set(d, 1.0F));
      for (float* const numbers : {mean.values, mean.colors})
        store_masked(mask, hn::Div(hn::LoadU(d, numbers + at), sum), numbers + at);
    });
  }
}

// The sums of a moment on a subtile become part of the trail's sheets.
inline void take_moment(const MomentFrame& moment, TrailWorkspace& trail, int sub,
                        const SheetRun& run, TrailSheets& sheets) {
  KernelWorkspace& sums = trail.sums;
  for (int j = run.first; j < run.last; ++j) {
    const std::int64_t number = number_in_ring(*moment.frame, sheets.layer, j);
    Sheet& one = trail.moment[number];
    take_values(*moment.frame, sums, sub, j, one);
    add_moment(sums.place, moment, one, sheets.ring[number], sheets.presence_on(j));
  }
}

// A layer of the trail. Subtiles that are closed have none.
inline void sum_trail(const KernelFrame& frame, KernelTileWorkspace& work, const TileRect& rect,
                      int layer, StageClock& clock) {
  TrailWorkspace& trail = *work.trail;
  KernelWorkspace& sums = trail.sums;
  const view::KernelPlan& plan = *frame.kernel_plan;
  const auto block = static_cast<std::size_t>(
      plan.block_index(rect.x0 / view::kBlockEdge, rect.y0 / view::kBlockEdge, layer));
  const int first = layer * view::kBlockDepth;
  const SheetRun run{0, std::min(view::kBlockDepth, num_sheets(frame) - first)};
  sums.open_subtiles = frame.options->stop_opaque ? open_subtiles_of(work) : kAllSubtiles;
  const auto for_each_open = [&](const auto& body) {
    for (int sub = 0; sub < kSubtiles * kSubtiles; ++sub) {
      if ((sums.open_subtiles >> sub & 1U) != 0 && place_subtile(frame, sums, rect, sub))
        body(sub, trail_sheets(trail, sub, layer));
    }
  };
  for (int sub = 0; sub < kSubtiles * kSubtiles; ++sub)
    trail_sheets(trail, sub, layer).layer = TrailSheets::kNone;
  bool is_any = false;
  for (const MomentFrame& moment : frame.trail) {
    if (moment.frame->is_visible[block] == 0) continue;
    if (!is_any) {
      for_each_open([&](int, TrailSheets& sheets) {
        sheets.layer = layer;
        for (int j = run.first; j < run.last; ++j)
          clear_mean(sums.place, sheets.ring[number_in_ring(frame, layer, j)],
                     sheets.presence_on(j));
      });
    }
    is_any = true;
    reconstruct_sheets(*moment.frame, sums, rect, first, first + run.last);
    for_each_open(
        [&](int sub, TrailSheets& sheets) { take_moment(moment, trail, sub, run, sheets); });
  }
  if (is_any) {
    for_each_open([&](int, TrailSheets& sheets) {
      for (int j = run.first; j < run.last; ++j)
        divide_mean(sums.place, sheets.presence_on(j),
                    sheets.ring[number_in_ring(frame, layer, j)]);
    });
  }
  clock.lap(kReconstruct);
}

// Stops up to a depth join the pixels of a subtile.
inline void show_stops_before(const CpuFrame& frame, float depth, TileLimits& limits,
                              TileState& pixels) {
  for (int pixel = 0; pixel < kTileSize * kTileSize; ++pixel) {
    std::uint32_t end = limits.shown[pixel];
    while (end < limits.end[pixel] && frame.limits->stops[end].depth <= depth) ++end;
    show_stops(frame, end, pixel, limits, pixels);
  }
}

// Opacities of samples, for their paths, become those for the share of the paths that was filled.
inline void thin_sheet(const BlockPlace& place, const float* presence, ShadedSheet& shaded) {
  for (int y = 0; y < place.rows; ++y) {
    for_each_group(shaded.visible[y], place.margin, place.columns - place.margin,
                   [&](int column, std::uint32_t) {
                     const int at = y * kTilePlane.stride + column;
                     const V opacity = hn::LoadU(d, shaded.alpha + at);
                     hn::StoreU(correct_opacity(opacity, hn::LoadU(d, presence + at)), d,
                                shaded.alpha + at);
                   });
  }
}

// What the trail has on a sheet of the frame joins the pixels of a subtile.
inline void add_trail_sheet(const KernelFrame& frame, KernelTileWorkspace& work, int sub, int sheet,
                            StageClock& clock) {
  TrailWorkspace& trail = *work.trail;
  const int layer = sheet / view::kBlockDepth;
  TrailSheets& sheets = trail_sheets(trail, sub, layer);
  if (sheets.layer != layer) return;
  Subtile& subtile = work.subtiles[static_cast<std::size_t>(sub)];
  const KernelFrame& look = *frame.trail.front().frame;
  const int j = sheet % view::kBlockDepth;
  BlockPlace& place = trail.sums.place;
  place.rays = &subtile.rays;
  place.limits = nullptr;
  place.first_sheet = number_in_ring(frame, layer, j);
  place.num_sheets = 1;
  place.sheets[0] = place_of_sheet(*frame.plan, place.first_sheet);
  const TileInHand tile{place,     sheets.ring, subtile.pixels, trail.sums.shaded, trail.sums.batch,
                        work.stats};
  RowBits bits = visible_candidates(look, tile, 0);
  if (look.plan->is_clipped) drop_without_path(look, place, 0, bits);
  if (!shade_samples(look, tile, 0, bits, clock, [] {})) return;
  if (frame.trail.size() > 1) thin_sheet(place, sheets.presence_on(j), trail.sums.shaded);
  if (frame.limits != nullptr)
    show_stops_before(frame, place.sheets[0].depth, subtile.limits, subtile.pixels);
  composite_sheet(look, place, 0, trail.sums.shaded, subtile.pixels);
  clock.lap(kComposite);
}

// The trail of the sheets before `end` that have not joined the pixels of a subtile.
inline void add_trail_before(const KernelFrame& frame, KernelTileWorkspace& work,
                             const TileRect& rect, int sub, int end, StageClock& clock) {
  int& next = work.trail->next[static_cast<std::size_t>(sub)];
  if (next >= end) return;
  if (place_subtile(frame, work.trail->sums, rect, sub)) {
    for (; next < end; ++next) add_trail_sheet(frame, work, sub, next, clock);
  }
  next = end;
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
