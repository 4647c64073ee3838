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

#include "render/cpu/differences-inl.h"
#include "render/cpu/finish-inl.h"
#include "render/cpu/kernel_surface-inl.h"
#include "render/cpu/limits-inl.h"
#include "render/cpu/post_convolve-inl.h"
#include "render/cpu/scatter_kernels-inl.h"
#include "render/cpu/shade-inl.h"
#include "render/cpu/ticks.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

inline SplatBlock place_of_block(const KernelFrame& frame, const TileRect& rect, int layer) {
  SplatBlock place{};
  place.tile_x = rect.x0;
  place.tile_y = rect.y0;
  place.tail = std::exp(-0.5F * frame.cutoff * frame.cutoff);
  const bool has_points = frame.takes_means && frame.profile != KernelProfile::kGaussian;
  for (int j = 0; j < view::kBlockDepth; ++j) {
    const auto sheet = static_cast<float>(layer * view::kBlockDepth + j);
    place.sheets[j] = sheet;
    place.scales[j] = sheet_place(frame, sheet).scale;
    if (!has_points) place.places[j] = sheet_place(frame, sheet);
    for (int n = 0; has_points && n < device::kProfilePoints; ++n)
      place.places[j * device::kProfilePoints + n] =
          sheet_place(frame, sheet + device::kProfilePointOffsets[n]);
  }
  return place;
}

// Sheet j of a block on the samples of a subtile: channels become values.
inline void take_values(const KernelFrame& frame, KernelWorkspace& work, int sub, int j,
                        Sheet& sheet) {
  const int rows = work.place.rows;
  const int columns = work.place.columns;
  const std::size_t size = plane_size(0);
  const std::size_t corner = static_cast<std::size_t>(sub / kSubtiles * kTileSize) * kValueStride +
                             static_cast<std::size_t>(sub % kSubtiles * kTileSize);
  const float* channels = planes_of(frame, work, 0, j) + corner;
  const float* cover = work.has_cover
                           ? work.cover.data.get() + static_cast<std::size_t>(j) * size + corner
                           : nullptr;
  const RowWord all = first_bits(columns);
  for (int y = 0; y < rows; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * kValueStride;
    float* const values = sheet.values + sheet.at(0, y);
    float* const colors = sheet.colors + sheet.at(0, y);
    RowWord defined = 0;
    for (int x = 0; x < columns; x += group_size()) {
      const std::size_t i = row + static_cast<std::size_t>(x);
      const V first = hn::LoadU(d, channels + i);
      V value = first;
      M is_defined;
      if (frame.is_sum) {
        is_defined = hn::Ne(first, hn::Zero(d));
        if (cover != nullptr)
          is_defined = hn::And(is_defined, hn::Ne(hn::LoadU(d, cover + i), hn::Zero(d)));
      } else {
        const V weight = hn::LoadU(d, channels + size + i);
        is_defined = hn::Ge(weight, hn::Set(d, static_cast<float>(KernelField::kLeastWeight)));
        value = hn::Div(first, hn::IfThenElse(is_defined, weight, hn::Set(d, 1.0F)));
      }
      is_defined = hn::And(is_defined, hn::Eq(value, value));
      defined |= RowWord{bits_of(is_defined)} << x;
      hn::StoreU(hn::IfThenElseZero(is_defined, value), d, values + x);
      if (frame.has_own_color) {
        const V part = hn::LoadU(d, channels + (frame.is_sum ? size : 2 * size) + i);
        const V whole = frame.is_sum ? first : hn::LoadU(d, channels + size + i);
        hn::StoreU(hn::Div(part, hn::IfThenElse(is_defined, whole, hn::Set(d, 1.0F))), d,
                   colors + x);
      }
    }
    sheet.defined[y] = defined & all;
    sheet.has_gradient[y] = sheet.is_classified[y] = sheet.has_light[y] = 0;
  }
}

// Pixels that splats of level 0 itself reach, before coarser levels are added there.
inline void cover_own_pixels(const KernelFrame& frame, KernelWorkspace& work, const SheetRun& run) {
  const std::size_t size = plane_size(0);
  for (int j = run.first; j < run.last; ++j) {
    const float* sums = planes_of(frame, work, 0, j);
    float* cover = work.cover.data.get() + static_cast<std::size_t>(j) * size;
    for (std::size_t i = 0; i < size; i += static_cast<std::size_t>(group_size())) {
      const V own = hn::LoadU(d, sums + i);
      const M is_reached = hn::Ne(own, hn::Zero(d));
      hn::StoreU(hn::IfThenElse(is_reached, own, hn::LoadU(d, cover + i)), d, cover + i);
    }
  }
}

// Adds a level to the next finer one.
inline void post_convolve_level(const KernelFrame& frame, KernelWorkspace& work, int level,
                                const SheetRun& run) {
  auto& is_finer_touched = work.is_touched[static_cast<std::size_t>(level) - 1];
  if (!is_finer_touched) clear_level(frame, work, level - 1, run);
  is_finer_touched = true;
  const LevelBand& band = (*frame.level_bands)[static_cast<std::size_t>(level) - 1];
  const LevelExtent& coarse = kLevelExtents[static_cast<std::size_t>(level)];
  const LevelExtent& fine = kLevelExtents[static_cast<std::size_t>(level) - 1];
  for (int j = run.first; j < run.last; ++j) {
    const float* from = planes_of(frame, work, level, j);
    float* to = planes_of(frame, work, level - 1, j);
    for (int c = 0; c < frame.num_channels; ++c) {
      post_convolve<true>({from, coarse.stride}, band, band, {0, fine.size - 1, fine.size},
                          {to, fine.stride});
      from += plane_size(level);
      to += plane_size(level - 1);
    }
  }
}

// The channels of sheets [first, last) of the frame, all of one layer of blocks.
inline void reconstruct_sheets(const KernelFrame& frame, KernelWorkspace& work,
                               const TileRect& rect, int first, int last) {
  const view::KernelPlan& plan = *frame.kernel_plan;
  const int layer = first / view::kBlockDepth;
  const auto block = static_cast<std::size_t>(
      plan.block_index(rect.x0 / view::kBlockEdge, rect.y0 / view::kBlockEdge, layer));
  const SheetRun run{first - layer * view::kBlockDepth, last - layer * view::kBlockDepth};
  const std::span<const std::uint32_t> indices = frame.binned->of_block(block);
  work.stats.kernels_loaded += static_cast<std::int64_t>(indices.size());
  sum_splats(frame, work, indices, place_of_block(frame, rect, layer), run);
  if (work.has_cover) cover_own_pixels(frame, work, run);
  for (int level = kMaxLevel; level > 0; --level) {
    if (work.is_touched[static_cast<std::size_t>(level)])
      post_convolve_level(frame, work, level, run);
  }
  work.stats.samples_reconstructed +=
      static_cast<std::int64_t>(run.last - run.first) * (rect.x1 - rect.x0) * (rect.y1 - rect.y0);
}

// Samples to be classified: defined ones of open pixels.
inline RowBits visible_candidates(const CpuFrame& frame, const TileInHand& tile, int s) {
  const BlockPlace& place = tile.place;
  const RowBits& defined = tile.ring[place.number_of(s)].defined;
  RowBits bits;
  for (int y = 0; y < place.rows; ++y) {
    const int row = tile_row(place, y);
    const bool is_inside = row >= 0 && row < place.y1 - place.y0;
    RowWord pixels = 0;
    if (is_inside)
      pixels = frame.options->stop_opaque ? tile.pixels.open[row] : first_bits(place.x1 - place.x0);
    bits[y] = defined[y] & pixels << place.margin;
  }
  return bits;
}

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

inline int num_sheets(const KernelFrame& frame) {
  return static_cast<int>(frame.kernel_plan->sheets.last - frame.kernel_plan->sheets.first);
}

inline void take_sheets_of_subtile(const KernelFrame& frame, KernelWorkspace& work, int sub,
                                   const IncomingSheets& sheets, StageClock& clock) {
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
    if (sheet > sheets.unfinished) finish_subtile_sheet(frame, tile, s - 1, clock);
  }
}

// Moves the place in hand to a subtile. False if the picture ends before it.
inline bool place_subtile(const KernelFrame& frame, KernelWorkspace& work, const TileRect& rect,
                          int sub) {
  BlockPlace& place = work.place;
  Subtile& subtile = work.subtiles[static_cast<std::size_t>(sub)];
  place.tile_x = rect.x0 + sub % kSubtiles * kTileSize;
  place.tile_y = rect.y0 + sub / kSubtiles * kTileSize;
  place.rays = &subtile.rays;
  place.limits = frame.limits == nullptr ? nullptr : &subtile.limits;
  place.x1 = std::min(rect.x1 - place.tile_x, kTileSize);
  place.y1 = std::min(rect.y1 - place.tile_y, kTileSize);
  place.columns = place.x1 + 2 * place.margin;
  place.rows = place.y1 + 2 * place.margin;
  return place.x1 > 0 && place.y1 > 0;
}

// On all subtiles. The channels of those sheets that the frame has are there.
inline void take_sheets(const KernelFrame& frame, KernelWorkspace& work, const TileRect& rect,
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
      take_sheets_of_subtile(frame, work, sub, sheets, clock);
    } else {
      for (int s = place.front_margin; s < place.num_sheets; ++s)
        subtile.ring[place.number_of(s)].clear();
    }
  }
}

// A sheet of a block that cannot show, or beyond the frame, where the field is undefined.
inline void take_neighbour(const KernelFrame& frame, KernelWorkspace& work, const TileRect& rect,
                           const IncomingSheets& sheet, StageClock& clock) {
  if (sheet.first >= 0 && sheet.last <= num_sheets(frame))
    reconstruct_sheets(frame, work, rect, sheet.first, sheet.last);
  take_sheets(frame, work, rect, sheet, clock);
}

inline std::uint32_t open_subtiles_of(const KernelWorkspace& work) {
  std::uint32_t bits = 0;
  for (std::size_t sub = 0; sub < work.subtiles.size(); ++sub) {
    const bool is_open = work.subtiles[sub].pixels.any_open(0, 0, kTileSize, kTileSize);
    bits |= std::uint32_t{is_open} << sub;
  }
  return bits;
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

inline void set_up_tile(const KernelFrame& frame, KernelWorkspace& work, const TileRect& rect) {
  BlockPlace& place = work.place;
  place.x0 = place.y0 = 0;
  place.margin = 1;
  place.front_margin = 2;  // a sheet is finished late, and isosurfaces lie in front of theirs
  place.back_margin = 0;
  work.shaded.visible = {};
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

inline void draw_block(const KernelFrame& frame, KernelWorkspace& work, const TileRect& rect,
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

inline void render_kernel_tile_on_target(const KernelFrame& frame, KernelWorkspace& work,
                                         const TileRect& rect) {
  const view::KernelPlan& plan = *frame.kernel_plan;
  WorkerStats& stats = work.stats;
  StageClock clock(stats.ticks, frame.options->collect_profile);
  set_up_tile(frame, work, rect);
  const int tile_x = rect.x0 / view::kBlockEdge;
  const int tile_y = rect.y0 / view::kBlockEdge;
  const auto is_relevant = [&](int layer) {
    return layer < plan.num_blocks[2] &&
           frame.is_visible[plan.block_index(tile_x, tile_y, layer)] != 0;
  };
  bool is_running = false;
  for (int layer = 0; layer < plan.num_blocks[2]; ++layer) {
    ++stats.blocks_total;
    if (frame.stop.stop_requested()) return;
    work.open_subtiles = frame.options->stop_opaque ? open_subtiles_of(work) : kAllSubtiles;
    if (work.open_subtiles == 0) {
      ++stats.skipped_opaque;
      continue;
    }
    const int first = layer * view::kBlockDepth;
    const int last = std::min(first + view::kBlockDepth, num_sheets(frame));
    if (frame.limits != nullptr)
      work.open_subtiles &= reached_subtiles(frame, work, rect, first, last);
    if (!is_relevant(layer) || work.open_subtiles == 0) {
      const auto block = static_cast<std::size_t>(plan.block_index(tile_x, tile_y, layer));
      ++(frame.binned->of_block(block).empty() ? stats.skipped_empty : stats.skipped_irrelevant);
      is_running = false;
      continue;
    }
    ++stats.blocks_drawn;
    const bool goes_on = last < num_sheets(frame) && is_relevant(layer + 1);
    draw_block(frame, work, rect, {first, last, !is_running, !goes_on}, clock);
    is_running = true;
  }
  for (Subtile& subtile : work.subtiles) show_last_stops(frame, subtile.limits, subtile.pixels);
  clock.lap(kBin);
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
