// SPDX-License-Identifier: Apache-2.0
// One tile of a kernel field, front to back. Blocks that can show are reconstructed four sheets at
// a time into a ring of sheets of field values; the stages behind, which lattices share, run on
// windows of that ring, one subtile of kTileSize^2 pixels after the other.
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
#include "render/cpu/post_convolve-inl.h"
#include "render/cpu/scatter_kernels-inl.h"
#include "render/cpu/shade-inl.h"
#include "render/cpu/ticks.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

inline constexpr std::size_t kValuePlane =
    static_cast<std::size_t>(kValueRows) * static_cast<std::size_t>(kValueStride);

HWY_INLINE std::size_t ring_offset(int sheet) {
  return static_cast<std::size_t>(sheet & (kValueRing - 1)) * kValuePlane;
}

inline BlockPlace place_of_block(const KernelFrame& frame, const TileRect& rect, int layer) {
  BlockPlace place{rect.x0, rect.y0, {}, {}};
  const bool has_points = frame.takes_means && frame.profile != KernelProfile::kGaussian;
  for (int j = 0; j < view::kBlockDepth; ++j) {
    const auto sheet = static_cast<float>(layer * view::kBlockDepth + j);
    place.scales[j] = sheet_place(frame, sheet).scale;
    if (!has_points) place.places[j] = sheet_place(frame, sheet);
    for (int n = 0; has_points && n < device::kProfilePoints; ++n)
      place.places[j * device::kProfilePoints + n] =
          sheet_place(frame, sheet + device::kProfilePointOffsets[n]);
  }
  return place;
}

// Channels become values, NaN where the field is undefined.
inline void finish_values(const KernelFrame& frame, KernelWorkspace& work, int j, int sheet) {
  const float* channels = planes_of(frame, work, 0, j);
  const std::size_t size = plane_size(0);
  float* values = work.values.data.get() + ring_offset(sheet);
  const float* cover =
      work.has_cover ? work.cover.data.get() + static_cast<std::size_t>(j) * size : nullptr;
  const V nan = hn::Set(d, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < size; i += static_cast<std::size_t>(group_size())) {
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
    hn::StoreU(hn::IfThenElse(is_defined, value, nan), d, values + i);
    if (frame.has_own_color) {
      const V part = hn::LoadU(d, channels + (frame.is_sum ? size : 2 * size) + i);
      const V whole = frame.is_sum ? first : hn::LoadU(d, channels + size + i);
      hn::StoreU(hn::Div(part, hn::IfThenElse(is_defined, whole, hn::Set(d, 1.0F))), d,
                 work.colors.data.get() + ring_offset(sheet) + i);
    }
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
      post_convolve<true>(from, coarse.stride, band, band, 0, fine.size - 1, fine.size, to,
                          fine.stride);
      from += plane_size(level);
      to += plane_size(level - 1);
    }
  }
}

// Sheets [first, last) of the frame, all of one layer of blocks, into the ring.
inline void reconstruct_sheets(const KernelFrame& frame, KernelWorkspace& work,
                               const TileRect& rect, int first, int last) {
  const view::KernelPlan& plan = *frame.kernel_plan;
  const int layer = first / view::kBlockDepth;
  const auto block = static_cast<std::size_t>(
      plan.block_index(rect.x0 / view::kBlockEdge, rect.y0 / view::kBlockEdge, layer));
  const SheetRun run{first - layer * view::kBlockDepth, last - layer * view::kBlockDepth};
  const std::span<const std::uint32_t> indices = frame.binned->of_block(block);
  work.shading.stats.kernels_loaded += static_cast<std::int64_t>(indices.size());
  sum_splats(frame, work, indices, place_of_block(frame, rect, layer), run);
  if (work.has_cover) cover_own_pixels(frame, work, run);
  for (int level = kMaxLevel; level > 0; --level) {
    if (work.is_touched[static_cast<std::size_t>(level)])
      post_convolve_level(frame, work, level, run);
  }
  for (int j = run.first; j < run.last; ++j) {
    const int sheet = layer * view::kBlockDepth + j;
    finish_values(frame, work, j, sheet);
    work.ring_sheets[static_cast<std::size_t>(sheet & (kValueRing - 1))] = sheet;
  }
  work.shading.stats.samples_reconstructed +=
      static_cast<std::int64_t>(run.last - run.first) * (rect.x1 - rect.x0) * (rect.y1 - rect.y0);
}

// A sheet that is only a neighbour: reconstructed unless it is there; without kernels, undefined.
inline void provide_sheet(const KernelFrame& frame, KernelWorkspace& work, const TileRect& rect,
                          int sheet) {
  auto& held = work.ring_sheets[static_cast<std::size_t>(sheet & (kValueRing - 1))];
  if (held == sheet) return;
  const int num_sheets =
      static_cast<int>(frame.kernel_plan->sheets.last - frame.kernel_plan->sheets.first);
  if (sheet >= 0 && sheet < num_sheets) {
    reconstruct_sheets(frame, work, rect, sheet, sheet + 1);
    return;
  }
  std::fill_n(work.values.data.get() + ring_offset(sheet), kValuePlane,
              std::numeric_limits<float>::quiet_NaN());
  held = sheet;
}

// The window of a subtile, with a margin of one sample: values and where they are defined.
inline void load_window(const KernelFrame& frame, KernelWorkspace& work, int sub_x, int sub_y,
                        int sheet, int s) {
  Block& block = work.shading.block;
  float* values = block.values[s & (kRingSheets - 1)];
  RowBits& defined = block.defined[s & (kRingSheets - 1)];
  const std::size_t corner = ring_offset(sheet) +
                             static_cast<std::size_t>(sub_y * kTileSize) * kValueStride +
                             static_cast<std::size_t>(sub_x * kTileSize);
  const float* from = work.values.data.get() + corner;
  const std::uint32_t all = (1U << block.columns) - 1U;
  for (int y = 0; y < block.rows; ++y, from += kValueStride) {
    std::uint32_t bits = 0;
    for (int x = 0; x < block.columns; x += group_size()) {
      const V value = hn::LoadU(d, from + x);
      const M is_defined = hn::Eq(value, value);
      bits |= bits_of(is_defined) << x;
      hn::StoreU(hn::IfThenElseZero(is_defined, value), d, values + y * kPlaneStride + x);
    }
    defined[y] = bits & all;
  }
  if (!frame.has_own_color) return;
  const float* color = work.colors.data.get() + corner;
  for (int y = 0; y < block.rows; ++y, color += kValueStride)
    std::memcpy(work.color_window[s & (kRingSheets - 1)] + y * kPlaneStride, color,
                sizeof(float) * static_cast<std::size_t>(block.columns));
}

// Samples to be classified: defined ones of open pixels.
inline RowBits visible_candidates(const KernelFrame& frame, const Block& block,
                                  const TileState& tile, int s) {
  RowBits bits;
  for (int y = 0; y < block.rows; ++y) {
    const int row = tile_row(block, y);
    const bool is_inside = row >= 0 && row < block.y1 - block.y0;
    const std::uint32_t pixels =
        is_inside
            ? (frame.options->stop_opaque ? tile.open[row] : (1U << (block.x1 - block.x0)) - 1U)
            : 0U;
    bits[y] = block.defined[s & (kRingSheets - 1)][y] & pixels << block.margin;
  }
  return bits;
}

// Where the paths of a group's samples have a length.
inline void drop_clipped(const CpuFrame& frame, const Block& block, int s, RowBits& bits) {
  if (!frame.plan->is_clipped) return;
  for (int y = 0; y < block.rows; ++y) {
    for_each_group(bits[y], block.margin, block.columns - block.margin,
                   [&](int column, std::uint32_t lanes) {
                     const V path = path_fraction(frame, block, s, column, y);
                     const std::uint32_t gone = bits_of(hn::Le(path, hn::Zero(d))) & lanes;
                     bits[y] &= ~(gone << column);
                   });
  }
}

inline void difference_gradients(const CpuFrame& frame, Workspace& work, int s) {
  Block& block = work.block;
  for (int y = 0; y < block.rows; ++y) {
    work.stats.gradients += std::popcount(block.visible[y]);
    for_each_group(block.visible[y], block.margin, block.columns - block.margin,
                   [&](int column, std::uint32_t lanes) {
                     store_gradient(block, column, y, lanes,
                                    central_difference_gradient(frame, block, s, column, y));
                   });
  }
}

// classify, light and composite sheet s of the window.
inline void finish_window_sheet(const KernelFrame& frame, KernelWorkspace& work, TileState& tile,
                                int s, StageClock& clock) {
  Block& block = work.shading.block;
  if (frame.mode == Mode::kIsosurface) {
    kernel_surface_sheet(frame, work, tile, s);
    clock.lap(kShade);
    return;
  }
  RowBits bits = visible_candidates(frame, block, tile, s);
  drop_clipped(frame, block, s, bits);
  finish_samples(frame, block, tile, work.shading.stats, s, bits,
                 work.color_window[s & (kRingSheets - 1)], clock,
                 [&] { difference_gradients(frame, work.shading, s); });
}

// Sheets [first, last) of the frame, whose neighbours are in the ring, on all subtiles.
inline void finish_sheets(const KernelFrame& frame, KernelWorkspace& work, const TileRect& rect,
                          int first, int last, StageClock& clock) {
  const view::ViewLattice& lattice = frame.kernel_plan->lattice;
  Block& block = work.shading.block;
  // Window sheet s is frame sheet first - 2 + s, so that its neighbours have numbers, too.
  block.first_sheet = frame.kernel_plan->sheets.first + first - 2;
  block.num_sheets = last - first + 3;
  for (int s = 0; s < block.num_sheets; ++s) {
    const std::int64_t sheet = block.first_sheet + s;
    block.sheets[s].depth = static_cast<float>(lattice.depth(sheet));
    block.sheets[s].inverse_pitch = static_cast<float>(1.0 / lattice.pitch(sheet));
    block.sheets[s].near_cut = near_cut_of(lattice, sheet);
  }
  const bool is_surface = frame.mode == Mode::kIsosurface;
  for (int sub = 0; sub < kSubtiles * kSubtiles; ++sub) {
    const int sub_x = sub % kSubtiles;
    const int sub_y = sub / kSubtiles;
    TileState& tile = work.tiles[static_cast<std::size_t>(sub)];
    block.tile_x = rect.x0 + sub_x * kTileSize;
    block.tile_y = rect.y0 + sub_y * kTileSize;
    block.rays = &work.rays[static_cast<std::size_t>(sub)];
    block.x1 = std::min(rect.x1 - block.tile_x, kTileSize);
    block.y1 = std::min(rect.y1 - block.tile_y, kTileSize);
    if (block.x1 <= 0 || block.y1 <= 0) continue;
    block.columns = block.x1 + 2 * block.margin;
    block.rows = block.y1 + 2 * block.margin;
    if (frame.options->stop_opaque && !tile.any_open(0, 0, block.x1, block.y1)) continue;
    const int before = is_surface ? 2 : 1;
    for (int sheet = first - before; sheet < first + 1; ++sheet)
      load_window(frame, work, sub_x, sub_y, sheet, sheet - first + 2);
    for (int sheet = first; sheet < last; ++sheet) {
      const int s = sheet - first + 2;
      load_window(frame, work, sub_x, sub_y, sheet + 1, s + 1);
      clock.lap(kLoad);
      finish_window_sheet(frame, work, tile, s, clock);
    }
  }
}

inline bool any_open(const KernelWorkspace& work) {
  return std::any_of(work.tiles.begin(), work.tiles.end(), [](const TileState& tile) {
    return tile.any_open(0, 0, kTileSize, kTileSize);
  });
}

inline void set_up_tile(const KernelFrame& frame, KernelWorkspace& work, const TileRect& rect) {
  Block& block = work.shading.block;
  block.x0 = block.y0 = 0;
  block.margin = 1;
  block.front_margin = block.back_margin = 0;
  block.visible = {};
  for (int sub = 0; sub < kSubtiles * kSubtiles; ++sub) {
    const int width = std::clamp(rect.x1 - rect.x0 - sub % kSubtiles * kTileSize, 0, kTileSize);
    const int height = std::clamp(rect.y1 - rect.y0 - sub / kSubtiles * kTileSize, 0, kTileSize);
    work.tiles[static_cast<std::size_t>(sub)].reset(width, width > 0 ? height : 0);
    set_up_rays(frame, rect.x0 + sub % kSubtiles * kTileSize, rect.y0 + sub / kSubtiles * kTileSize,
                work.rays[static_cast<std::size_t>(sub)]);
  }
  work.values.reserve(kValueRing * kValuePlane + kPlanePadding);
  work.colors.reserve(kValueRing * kValuePlane + kPlanePadding);
  work.ring_sheets.fill(std::numeric_limits<std::int64_t>::min());
}

inline void render_kernel_tile_on_target(const KernelFrame& frame, KernelWorkspace& work,
                                         const TileRect& rect) {
  const view::KernelPlan& plan = *frame.kernel_plan;
  WorkerStats& stats = work.shading.stats;
  StageClock clock(stats.ticks, frame.options->collect_profile);
  set_up_tile(frame, work, rect);
  const int tile_x = rect.x0 / view::kBlockEdge;
  const int tile_y = rect.y0 / view::kBlockEdge;
  const int num_sheets = static_cast<int>(plan.sheets.last - plan.sheets.first);
  const auto is_relevant = [&](int layer) {
    return layer < plan.num_blocks[2] &&
           plan.is_relevant[static_cast<std::size_t>(plan.block_index(tile_x, tile_y, layer))] != 0;
  };
  int shaded_to = 0;  // sheets before are done
  bool is_running = false;
  for (int layer = 0; layer < plan.num_blocks[2]; ++layer) {
    ++stats.blocks_total;
    if (frame.stop.stop_requested()) return;
    if (frame.options->stop_opaque && !any_open(work)) {
      ++stats.skipped_opaque;
      continue;
    }
    if (!is_relevant(layer)) {
      const auto block = static_cast<std::size_t>(plan.block_index(tile_x, tile_y, layer));
      ++(frame.binned->of_block(block).empty() ? stats.skipped_empty : stats.skipped_irrelevant);
      is_running = false;
      continue;
    }
    ++stats.blocks_drawn;
    const int first = layer * view::kBlockDepth;
    const int last = std::min(first + view::kBlockDepth, num_sheets);
    if (!is_running) {
      shaded_to = first;
      if (frame.mode == Mode::kIsosurface) provide_sheet(frame, work, rect, first - 2);
      provide_sheet(frame, work, rect, first - 1);
    }
    is_running = true;
    reconstruct_sheets(frame, work, rect, first, last);
    // The last sheet waits for the one behind it, which the next block brings if it can show.
    const bool goes_on = last < num_sheets && is_relevant(layer + 1);
    if (!goes_on) provide_sheet(frame, work, rect, last);
    clock.lap(kReconstruct);
    const int shade_to = goes_on ? last - 1 : last;
    finish_sheets(frame, work, rect, shaded_to, shade_to, clock);
    shaded_to = shade_to;
  }
  clock.lap(kBin);
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
