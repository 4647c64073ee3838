// SPDX-License-Identifier: Apache-2.0
// One tile, front to back: sets up blocks, decides which can be skipped, and runs the stages on the
// others sheet by sheet, so that a pixel that turns opaque stops costing anything at once.
#if defined(OVOID_RENDER_CPU_TILE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_TILE_INL_H_
#undef OVOID_RENDER_CPU_TILE_INL_H_
#else
#define OVOID_RENDER_CPU_TILE_INL_H_
#endif

#include "render/cpu/bin-inl.h"
#include "render/cpu/composite-inl.h"
#include "render/cpu/gradient-inl.h"
#include "render/cpu/isosurface-inl.h"
#include "render/cpu/load-inl.h"
#include "render/cpu/reconstruct-inl.h"
#include "render/cpu/shade-inl.h"
#include "render/cpu/splat-inl.h"
#include "render/cpu/ticks.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// A part of a tile's work: pixels of the tile x consecutive sheets.
struct Part {
  int x0, y0, x1, y1;
  std::int64_t first_sheet, last_sheet;  // without margins
};

// Index-space box around a part's samples, margins and slabs included.
inline Bounds3 box_of(const CpuFrame& frame, const Block& block, const Part& part, int margin) {
  const view::ViewLattice& lattice = frame.plan->lattice;
  Bounds3 box;
  for (const std::int64_t sheet :
       {part.first_sheet - block.front_margin, part.last_sheet - 1 + block.back_margin}) {
    const view::SheetMap map = lattice.index_map(sheet);
    for (const int x : {part.x0 - margin, part.x1 - 1 + margin}) {
      for (const int y : {part.y0 - margin, part.y1 - 1 + margin}) {
        box.extend(map.at(block.tile_x + x, block.tile_y + y));
      }
    }
  }
  return box;
}

// True if every sample's slab lies outside one of the half spaces.
inline bool is_clipped_away(const CpuFrame& frame, const Block& block, const Part& part) {
  const view::FramePlan& plan = *frame.plan;
  for (const ClipPlane& plane : plan.clip_planes) {
    double nearest = -1;
    for (const std::int64_t sheet : {part.first_sheet, part.last_sheet - 1}) {
      const view::ClipMap distance = plan.clip_distance(plane, sheet);
      const view::ClipMap slope = plan.clip_slope(plane);
      for (const int x : {part.x0, part.x1 - 1}) {
        for (const int y : {part.y0, part.y1 - 1}) {
          const double px = block.tile_x + x;
          const double py = block.tile_y + y;
          const double inside = distance.origin + px * distance.per_x + py * distance.per_y;
          const double lean = std::abs(slope.origin + px * slope.per_x + py * slope.per_y);
          nearest = std::max(nearest, inside + 0.5 * lean * plan.lattice.sampling_distance());
        }
      }
    }
    if (nearest < 0) return true;
  }
  return false;
}

// Positions are affine in the sheet's number, too: every sheet's map is the first one's plus a
// multiple of `step`.
inline void set_up_sheet(const CpuFrame& frame, Block& block, int s, const view::SheetMap& first,
                         const view::SheetMap& step, const Vec3& widening) {
  const view::ViewLattice& lattice = frame.plan->lattice;
  const double x = block.tile_x + block.x0 - block.margin;
  const double y = block.tile_y + block.y0 - block.margin;
  SheetSetup& setup = block.sheets[s];
  for (int a = 0; a < 3; ++a) {
    const double per_x = first.per_x[a] + s * step.per_x[a];
    const double per_y = first.per_y[a] + s * step.per_y[a];
    const double base = first.origin[a] + s * step.origin[a] + x * per_x + y * per_y;
    setup.base[a] = static_cast<float>(base - static_cast<double>(block.origin[a]));
    setup.per_x[a] = static_cast<float>(per_x);
    setup.per_y[a] = static_cast<float>(per_y);
    setup.step[a] = static_cast<float>(step.origin[a] + x * step.per_x[a] + y * step.per_y[a]);
    setup.step_per_x[a] = static_cast<float>(step.per_x[a]);
    setup.step_per_y[a] = static_cast<float>(step.per_y[a]);
    setup.widening[a] = static_cast<float>(widening[a]);
  }
  const std::int64_t sheet = block.first_sheet + s;
  setup.depth = static_cast<float>(lattice.depth(sheet));
  setup.inverse_pitch = static_cast<float>(1.0 / lattice.pitch(sheet));
}

inline void set_up_block(const CpuFrame& frame, Block& block, const Part& part,
                         const Bounds3& box) {
  block.x0 = part.x0;
  block.y0 = part.y0;
  block.x1 = part.x1;
  block.y1 = part.y1;
  block.columns = part.x1 - part.x0 + 2 * block.margin;
  block.rows = part.y1 - part.y0 + 2 * block.margin;
  block.first_sheet = part.first_sheet - block.front_margin;
  block.num_sheets =
      static_cast<int>(part.last_sheet - part.first_sheet) + block.front_margin + block.back_margin;
  for (int a = 0; a < 3; ++a) block.origin[a] = static_cast<std::int64_t>(std::floor(box.min()[a]));
  const view::LatticePlan& plan = *frame.lattice_plan;
  const view::SheetMap first = plan.lattice.index_map(block.first_sheet);
  view::SheetMap step = plan.lattice.index_map(block.first_sheet + 1);
  step.origin -= first.origin;
  step.per_x -= first.per_x;
  step.per_y -= first.per_y;
  Vec3 widening = plan.widening(block.first_sheet);
  for (int s = 0; s < block.num_sheets; ++s) {
    if (!frame.is_parallel) widening = plan.widening(block.first_sheet + s);
    set_up_sheet(frame, block, s, first, step, widening);
  }
}

// Samples to be classified now: relevant ones of open pixels.
inline RowBits relevant_now(const CpuFrame& frame, const Block& block, const TileState& tile,
                            int s) {
  RowBits bits;
  for (int y = 0; y < block.rows; ++y) {
    bits[y] = block.relevant[s][y] & open_samples(frame, block, tile, y) &
              block.defined[s & (kRingSheets - 1)][y];
  }
  return bits;
}

// Samples to be reconstructed now: active ones of open pixels, and of their neighbours where
// differences are taken.
inline RowBits wanted_now(const CpuFrame& frame, const Block& block, const TileState& tile, int s) {
  RowBits bits;
  for (int y = 0; y < block.rows; ++y) {
    std::uint32_t near = open_samples(frame, block, tile, y);
    if (block.margin > 0) {
      near |= near << 1 | near >> 1;
      near |= open_samples(frame, block, tile, y - 1) | open_samples(frame, block, tile, y + 1);
    }
    bits[y] = block.active[s][y] & near;
  }
  return bits;
}

inline std::int64_t count_bits(const Block& block, const RowBits& bits) {
  std::int64_t count = 0;
  for (int y = 0; y < block.rows; ++y) count += std::popcount(bits[y]);
  return count;
}

// classify, light and composite sheet s, whose values (and neighbours', if differences are taken)
// are there.
inline void finish_sheet(const CpuFrame& frame, Workspace& work, int s, StageClock& clock) {
  Block& block = work.block;
  TileState& tile = work.tile;
  if (frame.mode == Mode::kIsosurface) {
    if (s > 0) surface_sheet(frame, work, s);
    clock.lap(kShade);
    return;
  }
  if (frame.is_preintegrated && s < block.front_margin) return;  // the block before has drawn it
  const RowBits bits = relevant_now(frame, block, tile, s);
  if (frame.mode != Mode::kComposite) {
    accumulate_sheet(frame, block, tile, s, bits);
    clock.lap(kComposite);
    return;
  }
  classify_sheet(frame, block, s, bits);
  const std::int64_t num_visible = count_bits(block, block.visible);
  clock.lap(kShade);
  if (num_visible == 0) return;
  work.stats.samples_shaded += num_visible;
  if (frame.takes_gradients) {
    gradient_of_sheet(frame, work, s);
    clock.lap(kGradient);
  }
  if (frame.corrects_late) correct_sheet(frame, block, s);
  if (frame.shade) light_sheet(frame, block);
  clock.lap(kShade);
  composite_sheet(block, tile, s);
  clock.lap(kComposite);
}

inline void run_sheets(const CpuFrame& frame, Workspace& work, bool is_scattered,
                       StageClock& clock) {
  Block& block = work.block;
  if (is_scattered) splat_region(frame, work);
  clock.lap(kReconstruct);
  for (int s = 0; s < block.num_sheets; ++s) {
    if (frame.stop_opaque && !work.tile.any_open(block.x0, block.y0, block.x1, block.y1)) return;
    RowBits wanted = wanted_now(frame, block, work.tile, s);
    work.stats.samples_reconstructed += count_bits(block, wanted);
    block.defined[s & (kRingSheets - 1)] = {};
    block.has_gradient = {};
    if (is_scattered) {
      read_splat_sheet(frame, work, s, wanted);
    } else {
      const RowBits guess = guess_visible(frame, block, wanted);
      reconstruct_with_gradients(frame, work, s, guess);
      clock.lap(kGradient);
      for (int y = 0; y < block.rows; ++y) wanted[y] &= ~guess[y];
      reconstruct_sheet(frame, work, s, wanted);
    }
    clock.lap(kReconstruct);
    // With differences, a sheet is finished once its far neighbour is there.
    if (!frame.central_gradient) {
      finish_sheet(frame, work, s, clock);
    } else if (s >= 2) {
      finish_sheet(frame, work, s - 1, clock);
    }
  }
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
  const SheetSetup& sheet = block.sheets[0];
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

// Draws a part; one whose region is too large for the cache is halved, the front half first.
// Returns false if nothing in it was relevant.
inline bool draw_part(const CpuFrame& frame, Workspace& work, const Part& part, StageClock& clock) {
  Block& block = work.block;
  const Bounds3 box = box_of(frame, block, part, block.margin);
  set_up_block(frame, block, part, box);
  const std::int64_t num_relevant = bin_region(frame, block, work.tile, box);
  clock.lap(kBin);
  if (num_relevant == 0) return false;
  const std::int64_t region =
      num_samples({block.region_size[0], block.region_size[1], block.region_size[2]});
  if (region > kMaxRegionSamples) {
    const int axis = longest_axis(block, part);
    if (axis >= 0) {
      draw_part(frame, work, first_half(part, axis), clock);
      draw_part(frame, work, second_half(part, axis), clock);
      return true;
    }
  }
  const bool is_scattered = should_scatter(frame);
  load_region(frame, work, is_scattered);
  clock.lap(kLoad);
  run_sheets(frame, work, is_scattered, clock);
  return true;
}

// Draws one tile into work.tile; `block` of the workspace holds the tile's place.
inline void render_tile_on_target(const CpuFrame& frame, Workspace& work, const TileRect& rect) {
  const view::LatticePlan& plan = *frame.lattice_plan;
  Block& block = work.block;
  WorkerStats& stats = work.stats;
  StageClock clock(stats.ticks, frame.collect_profile);
  block.tile_x = rect.x0;
  block.tile_y = rect.y0;
  const int width = rect.x1 - rect.x0;
  const int height = rect.y1 - rect.y0;
  block.margin = frame.central_gradient ? 1 : 0;
  block.front_margin =
      frame.central_gradient || frame.is_preintegrated || frame.mode == Mode::kIsosurface ? 1 : 0;
  block.back_margin = block.margin;
  work.tile.reset(width, height);
  block.visible = {};

  const std::int64_t last = plan.sheets.last;
  for (std::int64_t sheet = plan.sheets.first; sheet < last; sheet += kBlockSheets) {
    ++stats.blocks_total;
    if (frame.stop.stop_requested()) return;
    if (frame.stop_opaque && !work.tile.any_open(0, 0, width, height)) {
      ++stats.skipped_opaque;
      continue;
    }
    const Part part{0, 0, width, height, sheet, std::min<std::int64_t>(sheet + kBlockSheets, last)};
    const Bounds3 box = box_of(frame, block, part, 0);
    if (!box.intersects(plan.index_support) || is_clipped_away(frame, block, part)) {
      ++stats.skipped_empty;
    } else if (!plan.relevance.any_in(box.min(), box.max()) ||
               !draw_part(frame, work, part, clock)) {
      ++(plan.may_matter ? stats.skipped_irrelevant : stats.skipped_empty);
    } else {
      ++stats.blocks_drawn;
    }
  }
  clock.lap(kBin);
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
