// SPDX-License-Identifier: Apache-2.0
// Stage "reconstruct" of kernel sets: adds splats to the sheets of a block.
//
// In:  the block's splats; which sheets of the block are wanted.
// Out: the levels' planes, [sheet][channel][row][column].
// One splat after the other; on each sheet its cut is an ellipse, on each row of it a Gaussian of
// one variable: row by row the cut's two ends, the middle and the amplitude are found for a vector
// of rows at once, then the row is added a group of samples at a time, an exponential each.
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

#include "render/cpu/kernel_block.h"
#include "render/cpu/simd-inl.h"
#include "render/shared/sections.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

inline constexpr float kHalfLog2E = 0.72134752F;  // exp(-q / 2) = 2^(-q log2(e) / 2)

// The cut of a splat with one sheet, in samples of a level's plane.
struct Section {
  float x, y;           // centre
  float axx, axy, ayy;  // per sample^2
  float amplitude;      // Gaussian: with the part along s; others: 1
  float q_along;        // others: the part of m^2 along s
  float room;           // the cut ends where the rest of m^2 exceeds it
};

// Where sheets lie, per block: offset in splat space and scale.
struct SheetPlace {
  float s;          // number of the sheet in the frame
  float scale;      // perspective
  float per_depth;  // of the ray, per sheet: lateral position over depth
};

// Where a block lies in the picture, and its sheets (or the nodes of their slabs, sheet by sheet).
inline constexpr int kProfileNodes = 8;
struct BlockPlace {
  int tile_x, tile_y;  // pixel of its corner
  float least_scale;   // of its sheets
  SheetPlace places[view::kBlockDepth * kProfileNodes];
};

// Gauss-Legendre on [-1/2, 1/2].
inline constexpr float kProfileNodeOffsets[kProfileNodes] = {
    -0.48014493F, -0.39833324F, -0.26276620F, -0.09171732F,
    0.09171732F,  0.26276620F,  0.39833324F,  0.48014493F};
inline constexpr float kProfileNodeWeights[kProfileNodes] = {0.05061427F, 0.11119052F, 0.15685332F,
                                                             0.18134189F, 0.18134189F, 0.15685332F,
                                                             0.11119052F, 0.05061427F};

// exp(-q / 2), or the profile at m^2 = q.
template <KernelProfile kProfile>
HWY_INLINE V profile_at(V q, float cutoff) {
  if constexpr (kProfile == KernelProfile::kGaussian) {
    return vector_exp2<true>(d, hn::Max(hn::Mul(q, hn::Set(d, -kHalfLog2E)), hn::Set(d, -126.0F)));
  }
  const V one = hn::Set(d, 1.0F);
  const V tt = hn::Mul(q, hn::Set(d, 1.0F / (cutoff * cutoff)));
  if constexpr (kProfile == KernelProfile::kEpanechnikov) {
    return hn::Max(hn::Sub(one, tt), hn::Zero(d));
  }
  const V t = hn::Min(hn::Sqrt(tt), one);
  if constexpr (kProfile == KernelProfile::kWendlandC2) {
    const V rest = hn::Sub(one, t);
    const V square = hn::Mul(rest, rest);
    return hn::Mul(hn::Mul(square, square), hn::MulAdd(hn::Set(d, 4.0F), t, one));
  }
  const V two_t = hn::Add(t, t);
  const V rest = hn::Sub(hn::Set(d, 2.0F), two_t);
  const V outer = hn::Mul(hn::Set(d, 0.25F), hn::Mul(rest, hn::Mul(rest, rest)));
  const V inner = hn::MulAdd(hn::Mul(two_t, two_t),
                             hn::MulAdd(hn::Set(d, 0.75F), two_t, hn::Set(d, -1.5F)), one);
  return hn::IfThenElse(hn::Lt(two_t, one), inner, outer);
}

// Ends and middle of the rows of a section.
struct RowRuns {
  static constexpr int kMost = kValueRows + 16;
  alignas(64) float middle[kMost];
  alignas(64) float amplitude[kMost];
  alignas(64) float q_row[kMost];
  alignas(64) std::int32_t first[kMost];
  alignas(64) std::int32_t last[kMost];
  int row0 = 0, count = 0;
};

template <KernelProfile kProfile>
HWY_INLINE void find_rows(const Section& section, const LevelExtent& extent, RowRuns& runs) {
  const float schur = section.ayy - section.axy * section.axy / section.axx;
  const float reach = std::sqrt(section.room / schur);
  const float top = static_cast<float>(extent.size - 1);
  const float from = std::ceil(std::max(section.y - reach, 0.0F));
  const float to = std::floor(std::min(section.y + reach, top));
  runs.count = 0;
  if (!(from <= to)) return;
  runs.row0 = static_cast<int>(from);
  runs.count = static_cast<int>(to) - runs.row0 + 1;
  const V slant = hn::Set(d, -section.axy / section.axx);
  const V inverse_axx = hn::Set(d, 1.0F / section.axx);
  for (int i = 0; i < runs.count; i += group_size()) {
    const V dy = hn::Sub(hn::Iota(d, static_cast<float>(runs.row0 + i)), hn::Set(d, section.y));
    const V q = hn::Mul(hn::Mul(dy, dy), hn::Set(d, schur));
    const V room = hn::Max(hn::Sub(hn::Set(d, section.room), q), hn::Zero(d));
    const V half = hn::Sqrt(hn::Mul(room, inverse_axx));
    const V middle = hn::MulAdd(slant, dy, hn::Set(d, section.x));
    const V lo = hn::Max(hn::Ceil(hn::Sub(middle, half)), hn::Zero(d));
    const V hi =
        hn::Min(hn::Floor(hn::Add(middle, half)), hn::Set(d, static_cast<float>(extent.size - 1)));
    hn::Store(middle, d, runs.middle + i);
    // Clamped before they are turned into integers: a section may lie far beside the tile.
    hn::Store(hn::ConvertTo(di, hn::Min(lo, hn::Set(d, 1e6F))), di, runs.first + i);
    hn::Store(hn::ConvertTo(di, hn::Max(hi, hn::Set(d, -1e6F))), di, runs.last + i);
    if constexpr (kProfile == KernelProfile::kGaussian) {
      hn::Store(hn::Mul(hn::Set(d, section.amplitude), profile_at<kProfile>(q, 0.0F)), d,
                runs.amplitude + i);
    } else {
      hn::Store(hn::Add(q, hn::Set(d, section.q_along)), d, runs.q_row + i);
    }
  }
}

// Adds coefficient[c] * phi to the planes of one sheet.
template <int kChannels, KernelProfile kProfile>
HWY_INLINE void add_section(const Section& section, const float* coefficients, float cutoff,
                            const LevelExtent& extent, float* planes, std::size_t plane_size) {
  RowRuns runs;
  find_rows<kProfile>(section, extent, runs);
  const V falloff = hn::Set(d, -kHalfLog2E * section.axx);
  V coefficient[kChannels];
  for (int c = 0; c < kChannels; ++c) coefficient[c] = hn::Set(d, coefficients[c]);
  for (int i = 0; i < runs.count; ++i) {
    const int first = runs.first[i];
    const int last = runs.last[i];
    float* row = planes + static_cast<std::size_t>(runs.row0 + i) * extent.stride;
    for (int x = first; x <= last; x += group_size()) {
      const V dx = hn::Iota(d, static_cast<float>(x) - runs.middle[i]);
      V phi;
      if constexpr (kProfile == KernelProfile::kGaussian) {
        const V power = hn::Max(hn::Mul(hn::Mul(dx, dx), falloff), hn::Set(d, -126.0F));
        phi = hn::Mul(hn::Set(d, runs.amplitude[i]), vector_exp2<true>(d, power));
      } else {
        phi = hn::Mul(hn::Set(d, section.amplitude),
                      profile_at<kProfile>(hn::MulAdd(hn::Mul(dx, dx), hn::Set(d, section.axx),
                                                      hn::Set(d, runs.q_row[i])),
                                           cutoff));
      }
      const int left = last - x + 1;
      if (left < group_size())
        phi = hn::IfThenElseZero(hn::FirstN(d, static_cast<std::size_t>(left)), phi);
      for (int c = 0; c < kChannels; ++c) {
        float* at = row + static_cast<std::size_t>(c) * plane_size + x;
        hn::StoreU(hn::MulAdd(coefficient[c], phi, hn::LoadU(d, at)), d, at);
      }
    }
  }
}

// From splat space to a level's samples: position = offset + factor * (x, y).
struct LevelMap {
  float factor, offset_x, offset_y;
};

HWY_INLINE LevelMap level_map(const KernelFrame& frame, int tile_x, int tile_y, int level,
                              float scale) {
  const auto step = static_cast<float>(1 << level);
  const LevelExtent& extent = kLevelExtents[static_cast<std::size_t>(level)];
  const float middle = 0.5F * (step - 1.0F);
  const auto lo = static_cast<float>(extent.lo);
  return {scale / step,
          (static_cast<float>(frame.plan->space.center_x - tile_x) - middle) / step - lo,
          (static_cast<float>(frame.plan->space.center_y - tile_y) - middle) / step - lo};
}

// The cut with the plane t sheets behind the centre.
HWY_INLINE Section middle_section(const Splat& splat, float t, float cutoff, bool is_gaussian,
                                  const LevelMap& map) {
  const float along = t * t * splat.inverse_var_s;
  const float per_sample = 1.0F / (map.factor * map.factor);
  return {map.offset_x + map.factor * (splat.x + splat.mx * t),
          map.offset_y + map.factor * (splat.y + splat.my * t),
          splat.axx * per_sample,
          splat.axy * per_sample,
          splat.ayy * per_sample,
          is_gaussian ? std::exp(-0.5F * along) : 1.0F,
          is_gaussian ? 0.0F : along,
          cutoff * cutoff - along};
}

// The mean over the slab around the plane t sheets behind the centre, as one Gaussian: the weight
// that lies in the slab, at the mean of its places, wider by their variance [METHOD 5.2, step 6].
// `lean` is the ray's own slope, pixels per sheet.
HWY_INLINE Section mean_section(const Splat& splat, float t, float cutoff, float lean_x,
                                float lean_y, const LevelMap& map) {
  const float sigma = 1.0F / std::sqrt(splat.inverse_var_s);
  const SlabMoments moments =
      slab_moments(std::clamp(t - 0.5F, -splat.reach_s, splat.reach_s) / sigma,
                   std::clamp(t + 0.5F, -splat.reach_s, splat.reach_s) / sigma);
  const float mean = moments.mean * sigma;
  const float variance = moments.variance * sigma * sigma;
  const float mx = splat.mx - lean_x;
  const float my = splat.my - lean_y;
  const float det = splat.axx * splat.ayy - splat.axy * splat.axy;
  const float cxx = splat.ayy / det + variance * mx * mx;
  const float cxy = -splat.axy / det + variance * mx * my;
  const float cyy = splat.axx / det + variance * my * my;
  const float det3 = cxx * cyy - cxy * cxy;
  const float per_sample = 1.0F / (map.factor * map.factor * det3);
  return {map.offset_x + map.factor * (splat.x + splat.mx * t + mx * (mean - t)),
          map.offset_y + map.factor * (splat.y + splat.my * t + my * (mean - t)),
          cyy * per_sample,
          -cxy * per_sample,
          cxx * per_sample,
          moments.weight * sigma / std::sqrt(det * det3),
          0.0F,
          cutoff * cutoff};
}

// Which sheets of a block are wanted: [first, last).
struct SheetRun {
  int first = 0, last = 0;
};

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

HWY_INLINE void set_coefficients(const KernelFrame& frame, const Splat& splat, float* out) {
  out[0] = splat.weight * splat.value;
  if (frame.is_sum) {
    out[1] = out[0] * splat.color;
  } else {
    out[1] = splat.weight;
    out[2] = splat.weight * splat.color;
  }
}

// The coarsest level whose samples show the splat, at the least scale of the block's sheets.
HWY_INLINE int level_for(const KernelFrame& frame, const Splat& splat, float scale) {
  const float sigma = splat.minor * scale / kLeastLevelSigma;
  if (!(sigma >= 2.0F)) return 0;
  return std::min(frame.max_level, static_cast<int>(std::ilogb(sigma)));
}

HWY_INLINE SheetPlace sheet_place(const KernelFrame& frame, float sheet) {
  const view::SplatSpace& space = frame.plan->space;
  if (space.is_parallel) return {sheet, 1.0F, 0.0F};
  const double depth = space.depth_of(sheet);
  return {sheet, static_cast<float>(space.scale(depth)),
          static_cast<float>(space.sampling_distance / depth)};
}

// A splat's section at a place, of whatever kind the frame asks for.
template <KernelProfile kProfile, bool kMean>
HWY_INLINE Section section_at(const KernelFrame& frame, const Splat& splat, const SheetPlace& place,
                              const LevelMap& map) {
  const float t = place.s - splat.s;
  constexpr bool kGaussian = kProfile == KernelProfile::kGaussian;
  if constexpr (kMean && kGaussian) {
    const float lean = place.per_depth;
    return mean_section(splat, t, frame.cutoff, (splat.x + splat.mx * t) * lean,
                        (splat.y + splat.my * t) * lean, map);
  } else {
    return middle_section(splat, t, frame.cutoff, kGaussian, map);
  }
}

// Where on its slab a sample is taken, and with which weight: Gaussian sections are integrated in
// closed form, other profiles' at these nodes.
template <KernelProfile kProfile, bool kMean>
inline constexpr int kNumNodes = kMean&& kProfile != KernelProfile::kGaussian ? kProfileNodes : 1;

template <int kChannels, KernelProfile kProfile, bool kMean>
HWY_INLINE void add_splat(const KernelFrame& frame, KernelWorkspace& work, const Splat& splat,
                          const BlockPlace& block, const SheetRun& run) {
  const int level = level_for(frame, splat, block.least_scale);
  if (!work.is_touched[static_cast<std::size_t>(level)]) {
    work.is_touched[static_cast<std::size_t>(level)] = true;
    clear_level(frame, work, level, run);
  }
  float coefficients[kMaxChannels] = {};
  set_coefficients(frame, splat, coefficients);
  constexpr int kNodes = kNumNodes<kProfile, kMean>;
  for (int j = run.first; j < run.last; ++j) {
    for (int n = 0; n < kNodes; ++n) {
      const SheetPlace& place = block.places[j * kNodes + n];
      const float beyond = std::abs(place.s - splat.s) - (kMean && kNodes == 1 ? 0.5F : 0.0F);
      if (beyond >= splat.reach_s) continue;
      const LevelMap map = level_map(frame, block.tile_x, block.tile_y, level, place.scale);
      Section section = section_at<kProfile, kMean>(frame, splat, place, map);
      if (!(section.room > 0)) continue;
      if constexpr (kNodes > 1) section.amplitude *= kProfileNodeWeights[n];
      add_section<kChannels, kProfile>(section, coefficients, frame.cutoff,
                                       kLevelExtents[static_cast<std::size_t>(level)],
                                       planes_of(frame, work, level, j), plane_size(level));
    }
  }
}

// Fragment-centric, for comparison: every sample visits every splat of its block [Jang 2004].
template <int kChannels, KernelProfile kProfile, bool kMean>
inline void gather_sheet(const KernelFrame& frame, KernelWorkspace& work,
                         std::span<const std::uint32_t> indices, const BlockPlace& block, int j) {
  constexpr int kNodes = kNumNodes<kProfile, kMean>;
  std::vector<Section> sections;
  std::vector<std::array<float, kMaxChannels>> coefficients;
  for (const std::uint32_t index : indices) {
    const Splat& splat = frame.binned->splats[index];
    for (int n = 0; n < kNodes; ++n) {
      const SheetPlace& place = block.places[j * kNodes + n];
      if (std::abs(place.s - splat.s) - (kMean && kNodes == 1 ? 0.5F : 0.0F) >= splat.reach_s)
        continue;
      const LevelMap map = level_map(frame, block.tile_x, block.tile_y, 0, place.scale);
      Section section = section_at<kProfile, kMean>(frame, splat, place, map);
      if (!(section.room > 0)) continue;
      if constexpr (kNodes > 1) section.amplitude *= kProfileNodeWeights[n];
      sections.push_back(section);
      set_coefficients(frame, splat, coefficients.emplace_back().data());
    }
  }
  const LevelExtent& extent = kLevelExtents[0];
  float* planes = planes_of(frame, work, 0, j);
  for (int y = 0; y < extent.size; ++y) {
    for (int x = 0; x < extent.size; x += group_size()) {
      V sums[kChannels];
      for (int c = 0; c < kChannels; ++c) sums[c] = hn::Zero(d);
      for (std::size_t i = 0; i < sections.size(); ++i) {
        const Section& section = sections[i];
        const V dx = hn::Iota(d, static_cast<float>(x) - section.x);
        const V dy = hn::Set(d, static_cast<float>(y) - section.y);
        const V q = hn::MulAdd(hn::Mul(dx, dx), hn::Set(d, section.axx),
                               hn::Mul(dy, hn::MulAdd(dx, hn::Set(d, 2.0F * section.axy),
                                                      hn::Mul(dy, hn::Set(d, section.ayy)))));
        const M is_inside = hn::Le(q, hn::Set(d, section.room));
        const V phi = hn::IfThenElseZero(
            is_inside,
            hn::Mul(hn::Set(d, section.amplitude),
                    profile_at<kProfile>(hn::Add(q, hn::Set(d, section.q_along)), frame.cutoff)));
        for (int c = 0; c < kChannels; ++c)
          sums[c] =
              hn::MulAdd(hn::Set(d, coefficients[i][static_cast<std::size_t>(c)]), phi, sums[c]);
      }
      for (int c = 0; c < kChannels; ++c) {
        // A group at the row's end writes into the next row, which is still to come.
        hn::StoreU(sums[c], d,
                   planes + static_cast<std::size_t>(c) * plane_size(0) +
                       static_cast<std::size_t>(y) * extent.stride + x);
      }
    }
  }
}

template <int kChannels, KernelProfile kProfile, bool kMean>
inline void sum_block(const KernelFrame& frame, KernelWorkspace& work,
                      std::span<const std::uint32_t> indices, const BlockPlace& block,
                      const SheetRun& run) {
  if (frame.gathers) {
    for (int j = run.first; j < run.last; ++j)
      gather_sheet<kChannels, kProfile, kMean>(frame, work, indices, block, j);
    return;
  }
  for (const std::uint32_t index : indices)
    add_splat<kChannels, kProfile, kMean>(frame, work, frame.binned->splats[index], block, run);
}

template <int kChannels, KernelProfile kProfile>
inline void sum_block_of_profile(const KernelFrame& frame, KernelWorkspace& work,
                                 std::span<const std::uint32_t> indices, const BlockPlace& block,
                                 const SheetRun& run) {
  if (frame.plan->is_mean) {
    sum_block<kChannels, kProfile, true>(frame, work, indices, block, run);
  } else {
    sum_block<kChannels, kProfile, false>(frame, work, indices, block, run);
  }
}

template <int kChannels>
inline void sum_block_of_channels(const KernelFrame& frame, KernelWorkspace& work,
                                  std::span<const std::uint32_t> indices, const BlockPlace& block,
                                  const SheetRun& run) {
  switch (frame.profile) {
    case KernelProfile::kGaussian:
      return sum_block_of_profile<kChannels, KernelProfile::kGaussian>(frame, work, indices, block,
                                                                       run);
    case KernelProfile::kCubicSpline:
      return sum_block_of_profile<kChannels, KernelProfile::kCubicSpline>(frame, work, indices,
                                                                          block, run);
    case KernelProfile::kWendlandC2:
      return sum_block_of_profile<kChannels, KernelProfile::kWendlandC2>(frame, work, indices,
                                                                         block, run);
    case KernelProfile::kEpanechnikov:
      return sum_block_of_profile<kChannels, KernelProfile::kEpanechnikov>(frame, work, indices,
                                                                           block, run);
  }
}

// Sums the block's splats on the levels of the wanted sheets; level 0 is always there.
inline void sum_splats(const KernelFrame& frame, KernelWorkspace& work,
                       std::span<const std::uint32_t> indices, const BlockPlace& block,
                       const SheetRun& run) {
  work.is_touched = {};
  work.is_touched[0] = true;
  clear_level(frame, work, 0, run);
  switch (frame.num_channels) {
    case 1:
      return sum_block_of_channels<1>(frame, work, indices, block, run);
    case 2:
      return sum_block_of_channels<2>(frame, work, indices, block, run);
    default:
      return sum_block_of_channels<3>(frame, work, indices, block, run);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
