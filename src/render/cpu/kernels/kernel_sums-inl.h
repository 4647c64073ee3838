// SPDX-License-Identifier: Apache-2.0
// The sheets of a block of a kernel field: the sums of its splats, level by level, and the values
// that these are on the samples of a subtile.
#if defined(OVOID_RENDER_CPU_KERNEL_SUMS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_KERNEL_SUMS_INL_H_
#undef OVOID_RENDER_CPU_KERNEL_SUMS_INL_H_
#else
#define OVOID_RENDER_CPU_KERNEL_SUMS_INL_H_
#endif

#include "render/cpu/kernels/post_convolve-inl.h"
#include "render/cpu/kernels/scatter_kernels-inl.h"
#include "render/cpu/shade/composite-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

inline int num_sheets(const KernelFrame& frame) {
  return static_cast<int>(frame.kernel_plan->sheets.last - frame.kernel_plan->sheets.first);
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

inline std::uint32_t open_subtiles_of(const KernelWorkspace& work) {
  std::uint32_t bits = 0;
  for (std::size_t sub = 0; sub < work.subtiles.size(); ++sub) {
    const bool is_open = work.subtiles[sub].pixels.any_open(0, 0, kTileSize, kTileSize);
    bits |= std::uint32_t{is_open} << sub;
  }
  return bits;
}

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

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
