// SPDX-License-Identifier: Apache-2.0
// One tile of a kernel field, front to back. Blocks that can show are reconstructed four sheets at
// a time. Then, one subtile of kTileSize^2 pixels after the other, the sums become the values of a
// sheet of the subtile's ring, and the stages behind, which lattices share, run on that.
//
// A sheet is shaded when the one behind it is there, for differences need both neighbours. Of
// blocks that cannot show only the one sheet is reconstructed that borders on a block that can.
#if defined(OVOID_RENDER_CPU_KERNEL_TILE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_KERNEL_TILE_INL_H_
#undef OVOID_RENDER_CPU_KERNEL_TILE_INL_H_
#else
#define OVOID_RENDER_CPU_KERNEL_TILE_INL_H_
#endif

#include "render/cpu/kernels/kernel_sums-inl.h"
#include "render/cpu/kernels/kernel_surface-inl.h"
#include "render/cpu/kernels/kernel_trail-inl.h"
#include "render/cpu/lattice/differences-inl.h"
#include "render/cpu/shade/finish-inl.h"
#include "render/cpu/shade/limits-inl.h"
#include "render/cpu/shade/shade-inl.h"
#include "render/cpu/ticks.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

inline void difference_gradients(const CpuFrame& frame, const TileInHand& tile, int s,
                                 const RowBits& visible) {
  const BlockPlace& place = tile.place;
  Sheet& sheet = tile.ring[place.number_of(s)];
  for (int y = 0; y < place.rows; ++y) {
    tile.stats.gradients += std::popcount(visible[y]);
    for_each_group(visible[y], place.margin, place.columns - place.margin,
                   [&](int column, std::uint32_t lanes) {
                     const SampleGroup group{s, column, y, lanes};
                     store_gradient(sheet, group,
                                    central_difference_gradient(frame, place, tile.ring, group));
                   });
  }
}

// Gradients of the ends of the visible pieces that end on sheet s.
inline void difference_gradients_of_ends(const CpuFrame& frame, const TileInHand& tile, int s) {
  const BlockPlace& place = tile.place;
  for (const int end : {s - 1, s}) {
    const Sheet& sheet = tile.ring[place.number_of(end)];
    RowBits missing{};
    for (int y = 0; y < place.rows; ++y)
      missing[y] = tile.shaded.visible[y] & sheet.defined[y] & ~sheet.has_gradient[y];
    difference_gradients(frame, tile, end, missing);
  }
}

// The refined pieces between sheet s and the one before it.
inline void finish_subtile_pieces(const CpuFrame& frame, const TileInHand& tile, int s,
                                  StageClock& clock) {
  RowBits bits = visible_candidates(frame, tile, s);
  const RowBits front = visible_candidates(frame, tile, s - 1);
  for (int y = 0; y < tile.place.rows; ++y) bits[y] |= front[y];
  finish_pieces(frame, tile, s, bits, KernelPieces{frame, tile.place}, clock,
                [&] { difference_gradients_of_ends(frame, tile, s); });
}

// classify, light and composite sheet s, whose neighbours are there.
inline void finish_subtile_sheet(const CpuFrame& frame, const TileInHand& tile, int s,
                                 StageClock& clock) {
  if (frame.mode == Mode::kIsosurface) {
    kernel_surface_sheet(frame, tile, s);
    clock.lap(kShade);
    return;
  }
  if (frame.is_refined) return finish_subtile_pieces(frame, tile, s, clock);
  RowBits bits = visible_candidates(frame, tile, s);
  if (frame.plan->is_clipped && tile.place.limits == nullptr)
    drop_without_path(frame, tile.place, s, bits);
  finish_samples(frame, tile, s, bits, clock,
                 [&] { difference_gradients(frame, tile, s, tile.shaded.visible); });
}

// Sheets [first, last) of the frame come in, and those before them from `unfinished` on, whose
// neighbours are then there, are finished.
struct IncomingSheets {
  int first, last;
  int unfinished;
};

inline void take_sheets_of_subtile(const KernelFrame& frame, KernelTileWorkspace& work,
                                   const TileRect& rect, int sub, const IncomingSheets& sheets,
                                   StageClock& clock) {
  Subtile& subtile = work.subtiles[static_cast<std::size_t>(sub)];
  const TileInHand tile = work.in_hand(subtile);
  for (int sheet = sheets.first; sheet < sheets.last; ++sheet) {
    const int s = sheet - sheets.first + work.place.front_margin;
    Sheet& incoming = subtile.ring[work.place.number_of(s)];
    if (sheet >= 0 && sheet < num_sheets(frame)) {
      take_values(frame, work, sub, sheet % view::kBlockDepth, incoming);
    } else {
      incoming.clear();
    }
    clock.lap(kReconstruct);
    if (sheet <= sheets.unfinished) continue;
    if (work.trail != nullptr) add_trail_before(frame, work, rect, sub, sheet - 1, clock);
    finish_subtile_sheet(frame, tile, s - 1, clock);
  }
}

// On all subtiles. The channels of those sheets that the frame has are there.
inline void take_sheets(const KernelFrame& frame, KernelTileWorkspace& work, const TileRect& rect,
                        const IncomingSheets& sheets, StageClock& clock) {
  BlockPlace& place = work.place;
  place.first_sheet = frame.kernel_plan->sheets.first + sheets.first - place.front_margin;
  place.num_sheets = sheets.last - sheets.first + place.front_margin;
  for (int s = 0; s < place.num_sheets; ++s)
    place.sheets[s] = place_of_sheet(*frame.plan, place.number_of(s));
  for (int sub = 0; sub < kSubtiles * kSubtiles; ++sub) {
    if (!place_subtile(frame, work, rect, sub)) continue;
    Subtile& subtile = work.subtiles[static_cast<std::size_t>(sub)];
    if (frame.options->stop_opaque && !subtile.pixels.any_open(0, 0, place.x1, place.y1)) continue;
    if ((work.open_subtiles >> sub & 1U) != 0) {
      take_sheets_of_subtile(frame, work, rect, sub, sheets, clock);
    } else {
      for (int s = place.front_margin; s < place.num_sheets; ++s)
        subtile.ring[place.number_of(s)].clear();
    }
  }
}

// A sheet of a block that cannot show, or beyond the frame, where the field is undefined.
inline void take_neighbour(const KernelFrame& frame, KernelTileWorkspace& work,
                           const TileRect& rect, const IncomingSheets& sheet, StageClock& clock) {
  if (sheet.first >= 0 && sheet.last <= num_sheets(frame))
    reconstruct_sheets(frame, work, rect, sheet.first, sheet.last);
  take_sheets(frame, work, rect, sheet, clock);
}

// Subtiles of which some pixel has a span that reaches into sheets [first, last) of the frame, or
// into those around them that are finished with them, a bit each.
inline std::uint32_t reached_subtiles(const KernelFrame& frame, KernelWorkspace& work,
                                      const TileRect& rect, int first, int last) {
  // A sheet is finished late, with the piece and the neighbour before it.
  constexpr int kAround = 3;
  const auto depth = [&](int sheet) {
    return static_cast<float>(frame.plan->lattice.depth(frame.kernel_plan->sheets.first + sheet));
  };
  std::uint32_t reached = 0;
  for (int sub = 0; sub < kSubtiles * kSubtiles; ++sub) {
    if (!place_subtile(frame, work, rect, sub)) continue;
    const BlockPlace& place = work.place;
    RowBits all{};
    std::fill_n(all.begin() + place.margin, place.y1, first_bits(place.x1) << place.margin);
    const RowBits bits =
        reached_by_spans(frame, place, all, depth(first - kAround), depth(last + kAround),
                         work.subtiles[static_cast<std::size_t>(sub)].pixels);
    reached |= std::uint32_t{count_bits(bits, place.rows) > 0} << sub;
  }
  return reached;
}

inline void set_up_tile(const KernelFrame& frame, KernelTileWorkspace& work, const TileRect& rect) {
  BlockPlace& place = work.place;
  place.x0 = place.y0 = 0;
  place.margin = 1;
  place.front_margin = 2;  // a sheet is finished late, and isosurfaces lie in front of theirs
  place.back_margin = 0;
  work.shaded.visible = {};
  if (work.trail != nullptr) set_up_trail(*work.trail);
  for (int sub = 0; sub < kSubtiles * kSubtiles; ++sub) {
    Subtile& subtile = work.subtiles[static_cast<std::size_t>(sub)];
    const int width = std::clamp(rect.x1 - rect.x0 - sub % kSubtiles * kTileSize, 0, kTileSize);
    const int height = std::clamp(rect.y1 - rect.y0 - sub / kSubtiles * kTileSize, 0, kTileSize);
    subtile.pixels.reset(width, width > 0 ? height : 0);
    set_up_rays(frame, rect.x0 + sub % kSubtiles * kTileSize, rect.y0 + sub / kSubtiles * kTileSize,
                subtile.rays);
    set_up_limits(frame, rect.x0 + sub % kSubtiles * kTileSize,
                  rect.y0 + sub / kSubtiles * kTileSize, subtile.limits, subtile.pixels);
  }
}

// The sheets [first, last) of a block that can show. `begins`: the block before it cannot; `ends`:
// the block behind it cannot.
struct BlockSheets {
  int first, last;
  bool begins, ends;
};

inline void draw_block(const KernelFrame& frame, KernelTileWorkspace& work, const TileRect& rect,
                       const BlockSheets& block, StageClock& clock) {
  const auto& [first, last, begins, ends] = block;
  if (begins) {
    if (frame.mode == Mode::kIsosurface || frame.is_refined)
      take_neighbour(frame, work, rect, {first - 2, first - 1, first}, clock);
    take_neighbour(frame, work, rect, {first - 1, first, first}, clock);
  }
  reconstruct_sheets(frame, work, rect, first, last);
  clock.lap(kReconstruct);
  take_sheets(frame, work, rect, {first, last, begins ? first : first - 1}, clock);
  // The last sheet waits for the one behind it, which the next block brings if it can show.
  if (ends) take_neighbour(frame, work, rect, {last, last + 1, last - 1}, clock);
}

// The field's part of a layer. `has_before`: the last sheet of the layer before waits for this one.
// Returns whether the last sheet of this one waits for the next layer.
inline bool draw_field_layer(const KernelFrame& frame, KernelTileWorkspace& work,
                             const TileRect& rect, int layer, bool has_before, StageClock& clock) {
  const view::KernelPlan& plan = *frame.kernel_plan;
  WorkerStats& stats = work.stats;
  const auto block_in = [&](int of) {
    return static_cast<std::size_t>(
        plan.block_index(rect.x0 / view::kBlockEdge, rect.y0 / view::kBlockEdge, of));
  };
  const auto is_relevant = [&](int of) {
    return of < plan.num_blocks[2] && frame.is_visible[block_in(of)] != 0;
  };
  const int first = layer * view::kBlockDepth;
  const int last = std::min(first + view::kBlockDepth, num_sheets(frame));
  if (frame.limits != nullptr)
    work.open_subtiles &= reached_subtiles(frame, work, rect, first, last);
  if (!is_relevant(layer) || work.open_subtiles == 0) {
    ++(frame.binned->of_block(block_in(layer)).empty() ? stats.skipped_empty
                                                       : stats.skipped_irrelevant);
    return false;
  }
  ++stats.blocks_drawn;
  const bool goes_on = last < num_sheets(frame) && is_relevant(layer + 1);
  draw_block(frame, work, rect, {first, last, !has_before, !goes_on}, clock);
  return goes_on;
}

// Not inline: other units call it (ovoid_simd_sources in cmake/OvoidTargets.cmake).
// NOLINTNEXTLINE(misc-definitions-in-headers)
void render_kernel_tile_on_target(const KernelFrame& frame, KernelTileWorkspace& work,
                                  const TileRect& rect) {
  WorkerStats& stats = work.stats;
  StageClock clock(stats.ticks, frame.options->collect_profile);
  set_up_tile(frame, work, rect);
  bool is_running = false;
  for (int layer = 0; layer < frame.kernel_plan->num_blocks[2]; ++layer) {
    ++stats.blocks_total;
    if (frame.stop.stop_requested()) return;
    work.open_subtiles = frame.options->stop_opaque ? open_subtiles_of(work) : kAllSubtiles;
    if (work.open_subtiles == 0) {
      ++stats.skipped_opaque;
      continue;
    }
    if (work.trail != nullptr) sum_trail(frame, work, rect, layer, clock);
    is_running = draw_field_layer(frame, work, rect, layer, is_running, clock);
    if (work.trail == nullptr) continue;
    const int last = std::min((layer + 1) * view::kBlockDepth, num_sheets(frame));
    for (int sub = 0; sub < kSubtiles * kSubtiles; ++sub)
      add_trail_before(frame, work, rect, sub, is_running ? last - 1 : last, clock);
  }
  for (Subtile& subtile : work.subtiles) show_last_stops(frame, subtile.limits, subtile.pixels);
  clock.lap(kBin);
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
