// SPDX-License-Identifier: Apache-2.0
// One tile, front to back: sets up blocks, decides which can be skipped, and runs the stages on the
// others sheet by sheet, so that a pixel that turns opaque stops costing anything at once.
#if defined(OVOID_RENDER_CPU_TILE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_TILE_INL_H_
#undef OVOID_RENDER_CPU_TILE_INL_H_
#else
#define OVOID_RENDER_CPU_TILE_INL_H_
#endif

#include "render/cpu/lattice/bin-inl.h"
#include "render/cpu/lattice/block-inl.h"
#include "render/cpu/lattice/gradient-inl.h"
#include "render/cpu/lattice/lattice_pieces-inl.h"
#include "render/cpu/lattice/load-inl.h"
#include "render/cpu/lattice/mixed-inl.h"
#include "render/cpu/lattice/nodes.h"
#include "render/cpu/lattice/patch-inl.h"
#include "render/cpu/lattice/reconstruct-inl.h"
#include "render/cpu/lattice/splat-inl.h"
#include "render/cpu/shade/finish-inl.h"
#include "render/cpu/shade/isosurface-inl.h"
#include "render/cpu/shade/shade-inl.h"
#include "render/cpu/ticks.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Samples to be classified now: relevant ones of open pixels.
inline RowBits relevant_now(const CpuFrame& frame, const Workspace& work, int s) {
  const Block& block = work.block;
  const RowBits& defined = work.ring[block.place.number_of(s)].defined;
  RowBits bits;
  for (int y = 0; y < block.place.rows; ++y) {
    bits[y] =
        block.bits.relevant[s][y] & open_samples(frame, block.place, *work.tile, y) & defined[y];
  }
  return bits;
}

// Samples to be reconstructed now: active ones of open pixels, and of their neighbours where
// differences are taken.
inline RowBits wanted_now(const CpuFrame& frame, const Workspace& work, int s) {
  const BlockPlace& place = work.block.place;
  const TileState& tile = *work.tile;
  RowBits bits;
  for (int y = 0; y < place.rows; ++y) {
    RowWord near = open_samples(frame, place, tile, y);
    if (place.margin > 0) {
      near |= near << 1 | near >> 1;
      near |= open_samples(frame, place, tile, y - 1) | open_samples(frame, place, tile, y + 1);
    }
    bits[y] = work.block.bits.active[s][y] & near;
  }
  return bits;
}

// The pieces between sheet s and the one before it.
inline void finish_pieces_of_sheet(const LatticeFrame& frame, Workspace& work, int s,
                                   StageClock& clock) {
  const BlockPlace& place = work.block.place;
  RowBits bits;
  RowWord any = 0;
  for (int y = 0; y < place.rows; ++y) {
    bits[y] = work.block.bits.relevant[s][y] & open_samples(frame, place, *work.tile, y);
    any |= bits[y];
  }
  work.was_visible = {};
  if (any == 0) return;
  finish_pieces(frame, work.in_hand(), s, bits, LatticePieces{frame, work.block}, clock,
                [&] { gradients_of_ends(frame, work, s); });
  work.was_visible = work.shaded.visible;
}

// classify, light and composite sheet s, whose values (and neighbours', if differences are taken)
// are there.
inline void finish_sheet(const LatticeFrame& frame, Workspace& work, int s, StageClock& clock) {
  if (frame.mode == Mode::kIsosurface) {
    if (s > 0) surface_sheet(frame, work, s);
    clock.lap(kShade);
    return;
  }
  // The block before has drawn it.
  if (frame.has_pieces && s < work.block.place.front_margin) return;
  if (frame.is_refined) return finish_pieces_of_sheet(frame, work, s, clock);
  const RowBits bits = relevant_now(frame, work, s);
  finish_samples(frame, work.in_hand(), s, bits, clock, [&] { gradient_of_sheet(frame, work, s); });
  work.was_visible = work.shaded.visible;
}

// With differences, a sheet is finished once its far neighbour is there: so many later.
inline int sheets_late(const CpuFrame& frame) { return frame.takes_differences ? 1 : 0; }

// The values of sheet s of a block that is ready.
inline void sum_sheet(const LatticeFrame& frame, Workspace& work, int s, StageClock& clock) {
  const BlockPlace& place = work.block.place;
  RowBits wanted = wanted_now(frame, work, s);
  const std::int64_t num_wanted = count_bits(wanted, place.rows);
  work.stats.samples_reconstructed += num_wanted;
  work.ring[place.number_of(s)].clear();
  if (should_scatter(frame)) {
    splat_sheet(frame, work, s, wanted);
    read_splat_sheet(frame, work, s, wanted);
  } else if (has_rows(frame, work.block)) {
    reconstruct_rows(frame, work, s, wanted);
  } else {
    const RowBits guess = guess_visible(frame, work, wanted);
    reconstruct_with_gradients(frame, work, s, guess);
    clock.lap(kGradient);
    for (int y = 0; y < place.rows; ++y) wanted[y] &= ~guess[y];
    reconstruct_sheet(frame, work, s, wanted);
  }
  clock.lap(kReconstruct);
}

// Sheet s of a block that is ready.
inline void run_sheet(const LatticeFrame& frame, Workspace& work, int s, StageClock& clock) {
  sum_sheet(frame, work, s, clock);
  const int finished = s - sheets_late(frame);
  if (finished >= sheets_late(frame)) finish_sheet(frame, work, finished, clock);
}

// No pixel of the block takes more samples.
inline bool is_closed(const CpuFrame& frame, const Workspace& work) {
  const BlockPlace& place = work.block.place;
  return frame.options->stop_opaque && !work.tile->any_open(place.x0, place.y0, place.x1, place.y1);
}

inline Part first_half(const Part& part, int axis) {
  Part half = part;
  if (axis == 0) half.x1 = (part.x0 + part.x1) / 2;
  if (axis == 1) half.y1 = (part.y0 + part.y1) / 2;
  if (axis == 2) half.last_sheet = (part.first_sheet + part.last_sheet) / 2;
  return half;
}

inline Part second_half(const Part& part, int axis) {
  Part half = part;
  const Part first = first_half(part, axis);
  if (axis == 0) half.x0 = first.x1;
  if (axis == 1) half.y0 = first.y1;
  if (axis == 2) half.first_sheet = first.last_sheet;
  return half;
}

// The axis (pixels x, y, sheets) along which a part spans most of the lattice, or -1 if it is a
// single sample.
inline int longest_axis(const Block& block, const Part& part) {
  const SheetInLattice& sheet = block.sheets[0];
  const auto reach = [](const float* v) {
    return std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]);
  };
  const float spans[3] = {
      static_cast<float>(part.x1 - part.x0 - 1) * reach(sheet.per_x),
      static_cast<float>(part.y1 - part.y0 - 1) * reach(sheet.per_y),
      static_cast<float>(part.last_sheet - part.first_sheet - 1) * reach(sheet.step)};
  const int longest = static_cast<int>(std::max_element(spans, spans + 3) - spans);
  return spans[longest] > 0 ? longest : -1;
}

// Sets up a part's block: kNothing if nothing in it is relevant, kTooLarge if its region is too
// large for the cache and can be halved.
inline PartState prepare_part(const LatticeFrame& frame, Workspace& work, const Part& part,
                              StageClock& clock) {
  Block& block = work.block;
  const Bounds3 box = box_of(frame, block.place, part, block.place.margin);
  set_up_block(frame, block, part, box);
  const RowBits wanted = wanted_of_block(frame, block.place, *work.tile);
  const bool is_relevant = bin_region(frame, block, wanted, box);
  clock.lap(kBin);
  if (!is_relevant) return PartState::kNothing;
  if (block.region.num_samples() > kMaxRegionSamples && longest_axis(block, part) >= 0)
    return PartState::kTooLarge;
  const bool is_scattered = should_scatter(frame);
  load_region(frame, work, is_scattered);
  clock.lap(kLoad);
  if (is_scattered) reserve_splat_planes(work);
  return PartState::kReady;
}

// Draws a part, a large one in halves, the front half first. Returns false if nothing in it was
// relevant.
inline bool draw_part(const LatticeFrame& frame, Workspace& work, const Part& part,
                      StageClock& clock) {
  const PartState state = prepare_part(frame, work, part, clock);
  if (state == PartState::kTooLarge) {
    const int axis = longest_axis(work.block, part);
    draw_part(frame, work, first_half(part, axis), clock);
    draw_part(frame, work, second_half(part, axis), clock);
  } else if (state == PartState::kReady) {
    for (int s = 0; s < work.block.place.num_sheets && !is_closed(frame, work); ++s)
      run_sheet(frame, work, s, clock);
  }
  return state != PartState::kNothing;
}

// What a frame's fields have on a sheet of the frame, whose values are there: mixed, or first the
// field's own, then what is behind it.
inline void finish_sheet_of_all(const LatticeFrame& frame, LatticeWorkspace& work, Layers& layers,
                                std::int64_t sheet, StageClock& clock) {
  const auto number_in = [&](const Layer& layer) {
    return static_cast<int>(sheet - layer.work->block.place.first_sheet);
  };
  if (frame.is_mixed)
    return finish_mixed_sheet(frame, layers, *work.mixed, number_in(layers[0]), clock);
  for (const Layer& layer : layers) {
    if (layer.is_ready()) finish_sheet(*layer.frame, *layer.work, number_in(layer), clock);
  }
}

// The same of a frame of several fields, sheet by sheet.
inline bool draw_part_of_all(const LatticeFrame& frame, LatticeWorkspace& work, const Part& part,
                             StageClock& clock) {
  Layers layers = layers_of(frame, work);
  bool is_relevant = false;
  for (Layer& layer : layers) {
    layer.state = prepare_part(*layer.frame, *layer.work, part, clock);
    is_relevant = is_relevant || layer.state != PartState::kNothing;
    if (!is_relevant && !may_be_alone(frame)) return false;
  }
  for (const Layer& layer : layers) {
    if (layer.state != PartState::kTooLarge) continue;
    const int axis = longest_axis(layer.work->block, part);
    draw_part_of_all(frame, work, first_half(part, axis), clock);
    draw_part_of_all(frame, work, second_half(part, axis), clock);
    return true;
  }
  for (std::int64_t sheet = part.first_sheet; sheet < part.last_sheet && is_relevant; ++sheet) {
    if (is_closed(frame, work.pixels)) break;
    for (Layer& layer : layers) {
      const BlockPlace& place = layer.work->block.place;
      const std::int64_t last = sheet - place.first_sheet + sheets_late(*layer.frame);
      for (; layer.is_ready() && layer.next < place.num_sheets && layer.next <= last; ++layer.next)
        sum_sheet(*layer.frame, *layer.work, layer.next, clock);
    }
    finish_sheet_of_all(frame, work, layers, sheet, clock);
  }
  return is_relevant;
}

// A block in which no sample is relevant.
inline void count_without_samples(const LatticeFrame& frame, WorkerStats& stats) {
  ++(frame.lattice_plan->may_matter ? stats.skipped_irrelevant : stats.skipped_empty);
}

// What can be said of a tile's block before anything of it is worked out; true if it may show.
inline bool may_show(const LatticeFrame& frame, Workspace& work, const Part& part,
                     WorkerStats& stats) {
  const view::LatticePlan& plan = *frame.lattice_plan;
  const Bounds3 box = box_of(frame, work.block.place, part, 0);
  if (!box.intersects(plan.index_support) || is_clipped_away(frame, work.block.place, part)) {
    ++stats.skipped_empty;
    return false;
  }
  if (plan.any_relevant(box)) return true;
  count_without_samples(frame, stats);
  return false;
}

// One tile's part of a layer of sheets, every sample from the kernels.
inline void draw_tile_layer(const LatticeFrame& frame, Workspace& work, const Part& part,
                            StageClock& clock) {
  WorkerStats& stats = work.stats;
  ++stats.blocks_total;
  if (frame.options->stop_opaque && !work.tile->any_open(0, 0, part.x1, part.y1)) {
    ++stats.skipped_opaque;
  } else if (may_show(frame, work, part, stats)) {
    if (draw_part(frame, work, part, clock)) {
      ++stats.blocks_drawn;
    } else {
      count_without_samples(frame, stats);
    }
  }
}

// The same of all fields.
inline void draw_tile_layer_of_all(const LatticeFrame& frame, LatticeWorkspace& work,
                                   const Part& part, StageClock& clock) {
  WorkerStats& stats = work.pixels.stats;
  WorkerStats ignored;
  ++stats.blocks_total;
  if (frame.options->stop_opaque && !work.pixels.tile->any_open(0, 0, part.x1, part.y1)) {
    ++stats.skipped_opaque;
    return;
  }
  bool shows = false;
  const std::size_t count = may_be_alone(frame) ? frame.beside.size() : 0;
  for (std::size_t i = 0; i < count && !shows; ++i)
    shows = may_show(*frame.beside[i], *work.beside[i], part, ignored);
  if (!shows && !may_show(frame, work.pixels, part, stats)) return;
  if (draw_part_of_all(frame, work, part, clock)) {
    ++stats.blocks_drawn;
  } else {
    count_without_samples(frame, stats);
  }
}

// A workspace's block goes to a tile.
inline void enter_tile(const CpuFrame& frame, LatticeWorkspace& work, Workspace& own,
                       const Patch& patch, const PatchTile& tile) {
  BlockPlace& place = own.block.place;
  place.margin = place.back_margin = frame.takes_differences ? 1 : 0;
  place.front_margin = sheets_before(frame);
  place_tile(patch, tile, place);
  own.tile = &work.tiles[tile.number];
  place.rays = &work.rays[tile.number];
  place.limits = frame.limits == nullptr ? nullptr : &work.limits[tile.number];
}

inline void draw_tiles_layer(const LatticeFrame& frame, LatticeWorkspace& work, const Patch& patch,
                             StageClock& clock) {
  for_each_tile(patch, [&](const PatchTile& at) {
    enter_tile(frame, work, work.pixels, patch, at);
    const Part part = part_of(work.pixels.block.place, patch);
    if (frame.beside.empty()) return draw_tile_layer(frame, work.pixels, part, clock);
    for (std::size_t i = 0; i < frame.beside.size(); ++i)
      enter_tile(*frame.beside[i], work, *work.beside[i], patch, at);
    draw_tile_layer_of_all(frame, work, part, clock);
  });
}

// Nothing more can be seen.
inline bool is_closed(const CpuFrame& frame, const TileState& tile) {
  return frame.options->stop_opaque && !tile.any_open(0, 0, kTileSize, kTileSize);
}

inline bool is_closed(const LatticeFrame& frame, const LatticeWorkspace& work, const Patch& patch) {
  bool are_closed = true;
  for_each_tile(patch, [&](const PatchTile& at) {
    are_closed = are_closed && is_closed(frame, work.tiles[at.number]);
  });
  return are_closed;
}

// A patch from nodes if they save anything and all of them are inside, else tile by tile.
inline void draw_patch_layer(const LatticeFrame& frame, LatticeWorkspace& work, Patch patch,
                             StageClock& clock) {
  patch.nodes_x = nodes_for(patch.node_step, patch.rect.x0, patch.rect.x1 - 1);
  patch.nodes_y = nodes_for(patch.node_step, patch.rect.y0, patch.rect.y1 - 1);
  const PatchResult result = is_closed(frame, work, patch) ? PatchResult::kNothingRelevant
                                                           : draw_patch(frame, work, patch, clock);
  if (result == PatchResult::kTooLarge) {
    Patch half = patch;
    half.last_sheet = (patch.first_sheet + patch.last_sheet) / 2;
    draw_patch_layer(frame, work, half, clock);
    half.first_sheet = half.last_sheet;
    half.last_sheet = patch.last_sheet;
    draw_patch_layer(frame, work, half, clock);
    return;
  }
  if (result == PatchResult::kNeedsPixels) {
    draw_tiles_layer(frame, work, patch, clock);
    return;
  }
  WorkerStats& stats = work.pixels.stats;
  for_each_tile(patch, [&](const PatchTile& at) {
    ++stats.blocks_total;
    if (result == PatchResult::kDrawn && work.bits[at.number].any_relevant) {
      ++stats.blocks_drawn;
    } else if (is_closed(frame, work.tiles[at.number])) {
      ++stats.skipped_opaque;
    } else {
      count_without_samples(frame, stats);
    }
  });
}

// Sheets [first, last) of one layer.
inline void draw_layer(const LatticeFrame& frame, LatticeWorkspace& work, const TileRect& rect,
                       std::int64_t first, std::int64_t last, StageClock& clock) {
  Patch patch{rect, first, last, 1.0, {}, {}, false, nullptr};
  if (frame.samples_at_nodes)
    patch.node_step = frame.lattice_plan->node_step(frame.options->post_convolution, first);
  if (patch.node_step <= 1.0) return draw_tiles_layer(frame, work, patch, clock);
  draw_patch_layer(frame, work, patch, clock);
}

// Draws a patch, or one tile where the frame has no nodes, into work.tiles; of the tile the samples
// named by `wanted`, or all.
// Not inline: other units call it (ovoid_simd_sources in cmake/OvoidTargets.cmake).
// NOLINTNEXTLINE(misc-definitions-in-headers)
void render_patch_on_target(const LatticeFrame& frame, LatticeWorkspace& work, const TileRect& rect,
                            const RowWord* wanted) {
  view::ViewLattice::SheetRange sheets = frame.lattice_plan->sheets;
  for (const LatticeFrame* const other : frame.beside) {
    const view::ViewLattice::SheetRange& more = other->lattice_plan->sheets;
    if (more.first >= more.last) continue;
    sheets = sheets.first >= sheets.last
                 ? more
                 : view::ViewLattice::SheetRange{std::min(sheets.first, more.first),
                                                 std::max(sheets.last, more.last)};
  }
  StageClock clock(work.pixels.stats.ticks, frame.options->collect_profile);
  work.pixels.was_visible = {};
  work.pixels.shaded.visible = {};
  for (const auto& other : work.beside) {
    other->was_visible = {};
    other->shaded.visible = {};
  }
  const int num_tiles = frame.samples_at_nodes ? kPatchTiles * kPatchTiles : 1;
  for (int t = 0; t < num_tiles; ++t) {
    const int width = rect.x1 - rect.x0 - t % kPatchTiles * kTileSize;
    const int height = rect.y1 - rect.y0 - t / kPatchTiles * kTileSize;
    work.tiles[static_cast<std::size_t>(t)].reset(std::clamp(width, 0, kTileSize),
                                                  width > 0 ? std::clamp(height, 0, kTileSize) : 0);
    set_up_rays(frame, rect.x0 + t % kPatchTiles * kTileSize, rect.y0 + t / kPatchTiles * kTileSize,
                work.rays[static_cast<std::size_t>(t)]);
    set_up_limits(frame, rect.x0 + t % kPatchTiles * kTileSize,
                  rect.y0 + t / kPatchTiles * kTileSize, work.limits[static_cast<std::size_t>(t)],
                  work.tiles[static_cast<std::size_t>(t)]);
  }
  for (int y = 0; y < kTileSize && wanted != nullptr; ++y) work.tiles[0].open[y] &= wanted[y];
  const std::int64_t last = sheets.last;
  for (std::int64_t sheet = sheets.first; sheet < last;) {
    if (frame.stop.stop_requested()) return;
    const std::int64_t past =
        std::min(last, frame.samples_at_nodes ? view::next_layer(sheet) : sheet + kBlockSheets);
    draw_layer(frame, work, rect, sheet, past, clock);
    sheet = past;
  }
  for (std::size_t t = 0; t < static_cast<std::size_t>(num_tiles); ++t)
    show_last_stops(frame, work.limits[t], work.tiles[t]);
  clock.lap(kBin);
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
