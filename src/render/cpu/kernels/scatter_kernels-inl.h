// SPDX-License-Identifier: Apache-2.0
// Stage "reconstruct" of kernel sets: adds splats to the sheets of a block.
//
// In:  the block's splats; which sheets of the block are wanted.
// Out: the levels' planes, [sheet][channel][row][column].
// One splat after the other; its cut with each sheet is an ellipse. Where the cuts of Gaussians lie
// is found for all sheets of the block at once, then each is added row by row (add_sections-inl.h).
// A splat goes to the coarsest level on which it is still wide enough to be brought up faithfully,
// so it costs a few hundred samples per sheet at most, however large it is in the picture.
#if defined(OVOID_RENDER_CPU_SCATTER_KERNELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_SCATTER_KERNELS_INL_H_
#undef OVOID_RENDER_CPU_SCATTER_KERNELS_INL_H_
#else
#define OVOID_RENDER_CPU_SCATTER_KERNELS_INL_H_
#endif

#include <algorithm>
#include <cstring>
#include <span>
#include <vector>

#include <hwy/cache_control.h>

#include "render/cpu/kernels/add_sections-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

HWY_INLINE std::size_t plane_size(int level) {
  const LevelExtent& extent = kLevelExtents[static_cast<std::size_t>(level)];
  return static_cast<std::size_t>(extent.size) * extent.stride;
}

// Channel 0 of a sheet's planes on a level.
HWY_INLINE float* planes_of(const KernelFrame& frame, KernelWorkspace& work, int level, int sheet) {
  return work.levels[static_cast<std::size_t>(level)].data.get() +
         static_cast<std::size_t>(sheet * frame.num_channels) * plane_size(level);
}

inline void clear_level(const KernelFrame& frame, KernelWorkspace& work, int level,
                        const SheetRun& run) {
  const std::size_t size = plane_size(level) * static_cast<std::size_t>(frame.num_channels);
  float* buffer = work.levels[static_cast<std::size_t>(level)].reserve(size * view::kBlockDepth +
                                                                       kPlanePadding);
  std::memset(buffer + size * static_cast<std::size_t>(run.first), 0,
              sizeof(float) * size * static_cast<std::size_t>(run.last - run.first));
}

HWY_INLINE void touch_level(const KernelFrame& frame, KernelWorkspace& work, int level,
                            const SheetRun& run) {
  bool& is_touched = work.is_touched[static_cast<std::size_t>(level)];
  if (is_touched) return;
  is_touched = true;
  clear_level(frame, work, level, run);
}

HWY_INLINE void set_coefficients(const KernelFrame& frame, const Splat& splat, float* out) {
  out[0] = splat.weight * splat.value;
  if (frame.is_sum) {
    out[1] = out[0] * splat.color;
  } else {
    out[1] = splat.weight;
    out[2] = splat.weight * splat.color;
  }
}

// The coarsest level whose samples show the splat on a sheet of that scale.
HWY_INLINE int level_for(const KernelFrame& frame, const Splat& splat, float scale) {
  const float sigma = splat.minor * scale / frame.least_level_sigma;
  if (!(sigma >= 2.0F)) return 0;
  return std::min(frame.max_level, static_cast<int>(std::ilogb(sigma)));
}

inline void clear_cover(KernelWorkspace& work, const SheetRun& run) {
  work.has_cover = true;
  work.is_all_covered = {};
  const std::size_t size = plane_size(0);
  float* cover = work.cover.reserve(size * view::kBlockDepth + kPlanePadding);
  std::memset(cover + size * static_cast<std::size_t>(run.first), 0,
              sizeof(float) * size * static_cast<std::size_t>(run.last - run.first));
}

// The pixels that a section reaches, as level 0 would have them.
inline void cover_section(KernelWorkspace& work, const Section& section, int j) {
  const LevelExtent& extent = kLevelExtents[0];
  RowRuns runs;
  find_rows<RowWay::kProfile>(section, extent, runs);
  float* const cover = work.cover.data.get() + static_cast<std::size_t>(j) * plane_size(0);
  bool is_all = runs.count == extent.size;
  for (int i = 0; i < runs.count; ++i) {
    const int first = runs.first[i];
    const int last = runs.last[i];
    is_all = is_all && first == 0 && last == extent.size - 1;
    if (first > last) continue;
    std::fill_n(cover + static_cast<std::size_t>(runs.row0 + i) * extent.stride + first,
                last - first + 1, 1.0F);
  }
  if (is_all) work.is_all_covered[static_cast<std::size_t>(j)] = true;
}

// Bits [first, last] of kSubtiles in which places [lo, hi] along an axis count, samples of level 0;
// gradients take the samples around a subtile, too.
HWY_INLINE std::uint32_t subtiles_along(float lo, float hi) {
  constexpr auto kTile = static_cast<float>(kTileSize);
  constexpr auto kLo = static_cast<float>(kLevelExtents[0].lo);
  constexpr float kAround = 1.5F;  // a sample, and rounding
  constexpr auto kLast = static_cast<float>(kSubtiles - 1);
  const float first = std::max((lo + kLo - kAround) / kTile - 1.0F, -1.0F);
  const float last = std::min((hi + kLo + kAround) / kTile, kLast);
  if (!(first < last + 1.0F) || first > kLast || last < 0.0F) return 0;
  const int begin = static_cast<int>(std::floor(first)) + 1;
  const int end = static_cast<int>(std::floor(last)) + 1;
  return begin < end ? (1U << end) - (1U << begin) : 0U;
}

// Whether a cut on level 0 reaches a subtile that is open.
HWY_INLINE bool reaches_open(const KernelWorkspace& work, const Section& section) {
  if (work.open_subtiles == kAllSubtiles) return true;
  const float det = section.axx * section.ayy - section.axy * section.axy;
  const float reach_x = std::sqrt(section.room * section.ayy / det);
  const float reach_y = std::sqrt(section.room * section.axx / det);
  const std::uint32_t columns = subtiles_along(section.x - reach_x, section.x + reach_x);
  const std::uint32_t rows = subtiles_along(section.y - reach_y, section.y + reach_y);
  for (int row = 0; row < kSubtiles; ++row) {
    if ((rows >> row & 1U) != 0 && (work.open_subtiles >> (row * kSubtiles) & columns) != 0)
      return true;
  }
  return false;
}

// The cuts of a Gaussian with a block's sheets on the samples of a level, a lane for each sheet.
// The shape is the splat's over factor^2.
struct SheetCuts {
  static constexpr int kMost = 16;
  alignas(64) float x[kMost], y[kMost], per_shape[kMost], room[kMost], amplitude[kMost];
  alignas(64) std::int32_t first_row[kMost], past_row[kMost], first_column[kMost],
      past_column[kMost];
};

HWY_INLINE void find_cuts(const KernelFrame& frame, const Splat& splat, const SplatBlock& block,
                          int level, SheetCuts& cuts) {
  const LevelMap map = level_map(frame, block.tile_x, block.tile_y, level, 1.0F);
  const LevelExtent& extent = kLevelExtents[static_cast<std::size_t>(level)];
  const float per_det = 1.0F / (splat.axx * splat.ayy - splat.axy * splat.axy);
  const V wide = hn::Set(d, std::sqrt(splat.ayy * per_det));
  const V high = hn::Set(d, std::sqrt(splat.axx * per_det));
  const V top = hn::Set(d, static_cast<float>(extent.size - 1));
  const V far = hn::Set(d, 1e6F);  // clamped before they are turned into integers
  const auto store_span = [&](V at, V reach, std::int32_t* first, std::int32_t* past) {
    const V lo = hn::Min(hn::Max(hn::Ceil(hn::Sub(at, reach)), hn::Zero(d)), far);
    const V hi = hn::Max(hn::Min(hn::Floor(hn::Add(at, reach)), top), hn::Neg(far));
    hn::Store(hn::ConvertTo(di, lo), di, first);
    hn::Store(hn::ConvertTo(di, hn::Add(hi, hn::Set(d, 1.0F))), di, past);
  };
  for (int j = 0; j < view::kBlockDepth; j += group_size()) {
    const V t = hn::Sub(hn::Load(d, block.sheets + j), hn::Set(d, splat.s));
    const V along = hn::Mul(hn::Mul(t, t), hn::Set(d, splat.inverse_var_s));
    const V room = hn::Sub(hn::Set(d, frame.cutoff * frame.cutoff), along);
    const V factor = hn::Mul(hn::Load(d, block.scales + j), hn::Set(d, map.factor));
    const V x = hn::MulAdd(hn::Set(d, splat.mx), t, hn::Set(d, splat.x));
    const V y = hn::MulAdd(hn::Set(d, splat.my), t, hn::Set(d, splat.y));
    const V at_x = hn::MulAdd(factor, x, hn::Set(d, map.offset_x));
    const V at_y = hn::MulAdd(factor, y, hn::Set(d, map.offset_y));
    const V reach = hn::Mul(hn::Sqrt(hn::Max(room, hn::Zero(d))), factor);
    hn::Store(at_x, d, cuts.x + j);
    hn::Store(at_y, d, cuts.y + j);
    hn::Store(hn::Div(hn::Set(d, 1.0F), hn::Mul(factor, factor)), d, cuts.per_shape + j);
    hn::Store(room, d, cuts.room + j);
    hn::Store(gaussian_at(along), d, cuts.amplitude + j);
    store_span(at_x, hn::Mul(reach, wide), cuts.first_column + j, cuts.past_column + j);
    store_span(at_y, hn::Mul(reach, high), cuts.first_row + j, cuts.past_row + j);
  }
}

// A Gaussian's cuts with the sheets of a block, all on one level, which is there.
template <int kChannels>
HWY_INLINE void add_cuts(const KernelFrame& frame, KernelWorkspace& work, const Splat& splat,
                         const float* coefficients, const SplatBlock& block, const SheetRun& run,
                         int level) {
  SheetCuts cuts;
  find_cuts(frame, splat, block, level, cuts);
  const LevelExtent& extent = kLevelExtents[static_cast<std::size_t>(level)];
  const SectionWay way = way_of(splat.axx, splat.axy, splat.ayy, frame.cutoff * frame.cutoff);
  V coefficient[kChannels];
  for (int c = 0; c < kChannels; ++c) coefficient[c] = hn::Set(d, coefficients[c]);
  for (int j = run.first; j < run.last; ++j) {
    const SectionBox box = {{cuts.first_row[j], cuts.past_row[j]},
                            {cuts.first_column[j], cuts.past_column[j]}};
    if (!(cuts.room[j] > 0) || box.is_empty()) continue;
    const float per_shape = cuts.per_shape[j];
    const Section section = {cuts.x[j],
                             cuts.y[j],
                             splat.axx * per_shape,
                             splat.axy * per_shape,
                             splat.ayy * per_shape,
                             cuts.amplitude[j],
                             0.0F,
                             cuts.room[j],
                             block.tail};
    if (level == 0 && !reaches_open(work, section)) continue;
    add_gaussian<kChannels>(section, box, way, coefficient, extent,
                            planes_of(frame, work, level, j), plane_size(level));
  }
}

template <int kChannels, bool kIsGaussian>
HWY_INLINE void add_splat(const KernelFrame& frame, KernelWorkspace& work, const Splat& splat,
                          const SplatBlock& block, const SheetRun& run) {
  float coefficients[kMaxChannels] = {};
  set_coefficients(frame, splat, coefficients);
  if (kIsGaussian && !frame.takes_means) {
    const int level = level_for(frame, splat, block.scales[run.first]);
    const bool needs_cover = level > 0 && frame.finds_cover;
    if (!needs_cover && level == level_for(frame, splat, block.scales[run.last - 1])) {
      touch_level(frame, work, level, run);
      return add_cuts<kChannels>(frame, work, splat, coefficients, block, run, level);
    }
  }
  for (int j = run.first; j < run.last; ++j) {
    const int level = level_for(frame, splat, block.scales[j]);
    const auto l = static_cast<std::size_t>(level);
    touch_level(frame, work, level, run);
    // A kernel of the value 0 does not define a sum.
    if (level > 0 && frame.finds_cover && coefficients[0] != 0.0F) {
      if (!work.has_cover) clear_cover(work, run);
      if (!work.is_all_covered[static_cast<std::size_t>(j)])
        for_each_section(frame, splat, block, j, 0,
                         [&](const Section& section) { cover_section(work, section, j); });
    }
    for_each_section(frame, splat, block, j, level, [&](const Section& section) {
      if (level == 0 && !reaches_open(work, section)) return;
      add_section<kChannels, kIsGaussian>(frame, section, coefficients, kLevelExtents[l],
                                          planes_of(frame, work, level, j), plane_size(level));
    });
  }
}

// Fragment-centric, for comparison: every sample visits every splat of its block [Jang 2004].
inline void gather_sheet(const KernelFrame& frame, KernelWorkspace& work,
                         std::span<const std::uint32_t> indices, const SplatBlock& block, int j) {
  std::vector<Section> sections;
  std::vector<std::array<float, kMaxChannels>> coefficients;
  for (const std::uint32_t index : indices) {
    const Splat& splat = frame.binned->splats[index];
    for_each_section(frame, splat, block, j, 0, [&](const Section& section) {
      sections.push_back(section);
      coefficients.push_back({});
      set_coefficients(frame, splat, coefficients.back().data());
    });
  }
  const LevelExtent& extent = kLevelExtents[0];
  float* planes = planes_of(frame, work, 0, j);
  for (int y = 0; y < extent.size; ++y) {
    for (int x = 0; x < extent.size; x += group_size()) {
      V sums[kMaxChannels] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
      for (std::size_t i = 0; i < sections.size(); ++i) {
        const Section& section = sections[i];
        const V dx = hn::Iota(d, static_cast<float>(x) - section.x);
        const V dy = hn::Set(d, static_cast<float>(y) - section.y);
        const V q = hn::MulAdd(hn::Mul(dx, dx), hn::Set(d, section.axx),
                               hn::Mul(dy, hn::MulAdd(dx, hn::Set(d, 2.0F * section.axy),
                                                      hn::Mul(dy, hn::Set(d, section.ayy)))));
        const M is_inside = hn::Le(q, hn::Set(d, section.room));
        const V phi = hn::IfThenElseZero(is_inside, section_at(frame, section, q));
        for (int c = 0; c < kMaxChannels; ++c)
          sums[c] =
              hn::MulAdd(hn::Set(d, coefficients[i][static_cast<std::size_t>(c)]), phi, sums[c]);
      }
      for (int c = 0; c < frame.num_channels; ++c) {
        // A group at the row's end writes into the next row, which is still to come.
        hn::StoreU(sums[c], d,
                   planes + static_cast<std::size_t>(c) * plane_size(0) +
                       static_cast<std::size_t>(y) * extent.stride + x);
      }
    }
  }
}

template <int kChannels>
inline void scatter_splats(const KernelFrame& frame, KernelWorkspace& work,
                           std::span<const std::uint32_t> indices, const SplatBlock& block,
                           const SheetRun& run) {
  const Splat* splats = frame.binned->splats.get();
  const bool is_gaussian = frame.profile == KernelProfile::kGaussian;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    // A block's splats are from several bricks, and far apart in memory.
    constexpr std::size_t kAhead = 8;
    // In clusters most splats are in one block, which takes too long to be waited for.
    constexpr std::size_t kSplatsPerLook = 512;
    if (i % kSplatsPerLook == 0 && frame.stop.stop_requested()) return;
    if (i + kAhead < indices.size()) hwy::Prefetch(splats + indices[i + kAhead]);
    if (is_gaussian) {
      add_splat<kChannels, true>(frame, work, splats[indices[i]], block, run);
    } else {
      add_splat<kChannels, false>(frame, work, splats[indices[i]], block, run);
    }
  }
}

// Sums the block's splats on the levels of the wanted sheets; level 0 is always there.
inline void sum_splats(const KernelFrame& frame, KernelWorkspace& work,
                       std::span<const std::uint32_t> indices, const SplatBlock& block,
                       const SheetRun& run) {
  work.is_touched = {};
  work.is_touched[0] = true;
  clear_level(frame, work, 0, run);
  work.has_cover = false;
  if (frame.gathers) {
    for (int j = run.first; j < run.last; ++j) gather_sheet(frame, work, indices, block, j);
  } else if (frame.num_channels == 1) {
    scatter_splats<1>(frame, work, indices, block, run);
  } else if (frame.num_channels == 2) {
    scatter_splats<2>(frame, work, indices, block, run);
  } else {
    scatter_splats<3>(frame, work, indices, block, run);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
