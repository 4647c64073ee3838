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

#include <hwy/cache_control.h>

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
  float tail;           // Gaussian: what amplitude * exp(-q / 2) falls to there
};

// Where sheets lie, per block: offset in splat space and scale.
struct SplatSheet {
  float s;          // number of the sheet in the frame
  float scale;      // perspective
  float per_depth;  // of the ray, per sheet: lateral position over depth
};

// Where a block lies in the picture, and its sheets (or the points of their slabs, sheet by sheet).
struct SplatBlock {
  int tile_x, tile_y;               // pixel of its corner
  float scales[view::kBlockDepth];  // of the sheets' middle planes
  SplatSheet places[view::kBlockDepth * device::kProfilePoints];
};

// exp(-q / 2).
HWY_INLINE V gaussian_at(V q) {
  return vector_exp2<true>(d, hn::Max(hn::Mul(q, hn::Set(d, -kHalfLog2E)), hn::Set(d, -126.0F)));
}

// What is taken from amplitude * exp(-q / 2), so that it ends smoothly at q = room: its tangent
// there.
HWY_INLINE V tangent_at(const Section& section, V q) {
  const float half_tail = 0.5F * section.tail;
  return hn::NegMulAdd(q, hn::Set(d, half_tail),
                       hn::Set(d, section.tail + half_tail * section.room));
}

// A profile other than the Gaussian at m^2 = q.
inline V profile_at(KernelProfile profile, V q, float cutoff) {
  const V one = hn::Set(d, 1.0F);
  const V tt = hn::Min(hn::Mul(q, hn::Set(d, 1.0F / (cutoff * cutoff))), one);
  if (profile == KernelProfile::kEpanechnikov) return hn::Sub(one, tt);
  const V t = hn::Sqrt(tt);
  const V rest = hn::Sub(one, t);
  const V square = hn::Mul(rest, rest);
  if (profile == KernelProfile::kWendlandC2)
    return hn::Mul(hn::Mul(square, square), hn::MulAdd(hn::Set(d, 4.0F), t, one));
  // 1 - 6 t^2 + 6 t^3 up to t = 1/2, then 2 (1 - t)^3.
  const V outer = hn::Mul(hn::Add(square, square), rest);
  const V inner = hn::NegMulAdd(hn::Mul(hn::Set(d, 6.0F), tt), rest, one);
  return hn::IfThenElse(hn::Lt(t, hn::Set(d, 0.5F)), inner, outer);
}

// Not less than nothing by rounding.
HWY_INLINE V smooth_end(V amplitude, V gaussian, V tangent) {
  return hn::Max(hn::MulSub(amplitude, gaussian, tangent), hn::Zero(d));
}

// A section where the part of m^2 in its plane is q.
HWY_INLINE V section_at(const KernelFrame& frame, const Section& section, V q) {
  const V amplitude = hn::Set(d, section.amplitude);
  if (frame.profile == KernelProfile::kGaussian)
    return smooth_end(amplitude, gaussian_at(q), tangent_at(section, q));
  const V whole = hn::Add(q, hn::Set(d, section.q_along));
  return hn::Mul(amplitude, profile_at(frame.profile, whole, frame.cutoff));
}

// Ends and middle of the rows of a section.
struct RowRuns {
  static constexpr int kMost = kValueRows + 16;
  alignas(64) float middle[kMost];
  alignas(64) float amplitude[kMost];
  alignas(64) float q_row[kMost];    // kProfile: of m^2, what the whole row has
  alignas(64) float tangent[kMost];  // Gaussians: tangent_at() the middle
  alignas(64) std::int32_t first[kMost];
  alignas(64) std::int32_t last[kMost];
  int row0 = 0, count = 0;
};

// How the samples of a row are worked out.
enum class RowWay {
  kRecurrent,  // Gaussian: every column's factor follows from the row before by one product
  kSlanted,    // Gaussian: an exponential per group, for cuts so thin and slanted that the products
               // would leave the range of a float
  kProfile,    // other profiles
};

// Slant |axy| / sqrt(axx ayy) up to which kRecurrent stays in range: at the corners of the cut's
// box exponents reach 8 / (1 - slant) at cut-off 4, a float's e^-87.
inline constexpr float kMaxSlant = 0.8F;
inline constexpr float kMaxRecurrentRoom = 36.0F;  // cut-off 6

template <RowWay kWay>
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
    if constexpr (kWay != RowWay::kProfile) {
      // Slanted rows are Gaussians around their own middle; recurrent ones keep the mixed term.
      const V part =
          kWay == RowWay::kSlanted ? q : hn::Mul(hn::Mul(dy, dy), hn::Set(d, section.ayy));
      hn::Store(hn::Mul(hn::Set(d, section.amplitude), gaussian_at(part)), d, runs.amplitude + i);
      hn::Store(tangent_at(section, q), d, runs.tangent + i);
    } else {
      hn::Store(hn::Add(q, hn::Set(d, section.q_along)), d, runs.q_row + i);
    }
  }
}

// Adds coefficient[c] * phi to the channels' planes at `row`, lanes of the group at `x`.
template <int kChannels>
HWY_INLINE void add_group(const V* coefficient, V phi, float* at, std::size_t plane_size) {
  for (int c = 0; c < kChannels; ++c, at += plane_size)
    hn::StoreU(hn::MulAdd(coefficient[c], phi, hn::LoadU(d, at)), d, at);
}

HWY_INLINE V first_lanes(V phi, int count) {
  if (count >= group_size()) return phi;
  return hn::IfThenElseZero(hn::FirstN(d, static_cast<std::size_t>(count)), phi);
}

// One row after the other, an exponential for every group.
template <int kChannels, RowWay kWay>
HWY_INLINE void add_rows(const KernelFrame& frame, const Section& section, const V* coefficient,
                         const LevelExtent& extent, float* planes, std::size_t plane_size) {
  RowRuns runs;
  find_rows<kWay>(section, extent, runs);
  const V axx = hn::Set(d, section.axx);
  const V half_tail = hn::Set(d, 0.5F * section.tail);
  for (int i = 0; i < runs.count; ++i) {
    const int last = runs.last[i];
    float* row = planes + static_cast<std::size_t>(runs.row0 + i) * extent.stride;
    for (int x = runs.first[i]; x <= last; x += group_size()) {
      const V dx = hn::Iota(d, static_cast<float>(x) - runs.middle[i]);
      const V q = hn::Mul(hn::Mul(dx, dx), axx);
      V phi;
      if constexpr (kWay == RowWay::kSlanted) {
        const V tangent = hn::NegMulAdd(q, half_tail, hn::Set(d, runs.tangent[i]));
        phi = smooth_end(hn::Set(d, runs.amplitude[i]), gaussian_at(q), tangent);
      } else {
        phi =
            hn::Mul(hn::Set(d, section.amplitude),
                    profile_at(frame.profile, hn::Add(q, hn::Set(d, runs.q_row[i])), frame.cutoff));
      }
      add_group<kChannels>(coefficient, first_lanes(phi, last - x + 1), row + x, plane_size);
    }
  }
}

// exp(-1/2 (axx dx^2 + 2 axy dx dy)) for all columns of the cut's box is carried from row to row:
// the next row's is this one's times exp(-axy dx). Balls have no mixed term and one factor for all
// rows. So a group costs a product, not an exponential.
template <int kChannels>
HWY_INLINE void add_rows_recurrent(const Section& section, const V* coefficient,
                                   const LevelExtent& extent, float* planes,
                                   std::size_t plane_size) {
  const float det = section.axx * section.ayy - section.axy * section.axy;
  const float reach = std::sqrt(section.room * section.ayy / det);
  const float left = std::ceil(std::max(section.x - reach, 0.0F));
  const float right = std::floor(std::min(section.x + reach, static_cast<float>(extent.size - 1)));
  if (!(left <= right)) return;
  RowRuns runs;
  find_rows<RowWay::kRecurrent>(section, extent, runs);
  if (runs.count == 0) return;
  const int x0 = static_cast<int>(left);
  const int columns = static_cast<int>(right) - x0 + 1;
  alignas(64) float factor[kValueStride + kPlanePadding];
  alignas(64) float step[kValueStride + kPlanePadding];
  const bool is_slanted = section.axy != 0.0F;
  const float dy0 = static_cast<float>(runs.row0) - section.y;
  for (int x = 0; x < columns; x += group_size()) {
    const V dx = hn::Iota(d, left + static_cast<float>(x) - section.x);
    const V mixed = hn::Mul(dx, hn::Set(d, 2.0F * section.axy));
    const V q =
        hn::Mul(dx, hn::MulAdd(dx, hn::Set(d, section.axx), hn::Set(d, 2.0F * section.axy * dy0)));
    hn::Store(
        vector_exp2<true>(d, hn::Max(hn::Mul(q, hn::Set(d, -kHalfLog2E)), hn::Set(d, -126.0F))), d,
        factor + x);
    if (is_slanted) hn::Store(vector_exp2(d, hn::Mul(mixed, hn::Set(d, -kHalfLog2E))), d, step + x);
  }
  const V bend = hn::Set(d, 0.5F * section.tail * section.axx);
  for (int i = 0; i < runs.count; ++i) {
    // By rounding a row may seem to begin or end a column beyond the box.
    const int first = std::max(runs.first[i] - x0, 0);
    const int count = std::min(runs.last[i] - x0, columns - 1) - first + 1;
    float* row = planes + static_cast<std::size_t>(runs.row0 + i) * extent.stride + x0 + first;
    const V amplitude = hn::Set(d, runs.amplitude[i]);
    const V tangent_of_row = hn::Set(d, runs.tangent[i]);
    const float from_middle = static_cast<float>(x0 + first) - runs.middle[i];
    for (int x = 0; x < count; x += group_size()) {
      const V dx = hn::Iota(d, from_middle + static_cast<float>(x));
      const V tangent = hn::NegMulAdd(hn::Mul(dx, dx), bend, tangent_of_row);
      const V phi = smooth_end(amplitude, hn::LoadU(d, factor + first + x), tangent);
      add_group<kChannels>(coefficient, first_lanes(phi, count - x), row + x, plane_size);
    }
    if (!is_slanted) continue;
    for (int x = 0; x < columns; x += group_size())
      hn::Store(hn::Mul(hn::Load(d, factor + x), hn::Load(d, step + x)), d, factor + x);
  }
}

// Adds coefficient[c] * phi to the planes of one sheet.
template <int kChannels, bool kIsGaussian>
HWY_INLINE void add_section(const KernelFrame& frame, const Section& section,
                            const float* coefficients, const LevelExtent& extent, float* planes,
                            std::size_t plane_size) {
  V coefficient[kChannels];
  for (int c = 0; c < kChannels; ++c) coefficient[c] = hn::Set(d, coefficients[c]);
  if constexpr (!kIsGaussian) {
    add_rows<kChannels, RowWay::kProfile>(frame, section, coefficient, extent, planes, plane_size);
  } else {
    const bool is_tame =
        section.axy * section.axy <= kMaxSlant * kMaxSlant * section.axx * section.ayy &&
        section.room <= kMaxRecurrentRoom;
    if (is_tame) {
      add_rows_recurrent<kChannels>(section, coefficient, extent, planes, plane_size);
    } else {
      add_rows<kChannels, RowWay::kSlanted>(frame, section, coefficient, extent, planes,
                                            plane_size);
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
          (static_cast<float>(frame.kernel_plan->space.center_x - tile_x) - middle) / step - lo,
          (static_cast<float>(frame.kernel_plan->space.center_y - tile_y) - middle) / step - lo};
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
          cutoff * cutoff - along,
          is_gaussian ? std::exp(-0.5F * cutoff * cutoff) : 0.0F};
}

// The mean over the slab around the plane t sheets behind the centre, as one Gaussian: the weight
// that lies in the slab, at the mean of its places, wider by their variance [METHOD 5.2, step 6].
// `lean` is the ray's own slope, pixels per sheet.
HWY_INLINE Section mean_section(const Splat& splat, float t, float cutoff, float lean_x,
                                float lean_y, const LevelMap& map) {
  const float sigma = 1.0F / std::sqrt(splat.inverse_var_s);
  const float from = std::clamp(t - 0.5F, -splat.reach_s, splat.reach_s) / sigma;
  const float to = std::clamp(t + 0.5F, -splat.reach_s, splat.reach_s) / sigma;
  const SlabMoments moments = slab_moments(from, to);
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
  const float amplitude = moments.weight * sigma / std::sqrt(det * det3);
  const float room = device::slab_room(from, to, moments, cutoff * cutoff);
  return {map.offset_x + map.factor * (splat.x + splat.mx * t + mx * (mean - t)),
          map.offset_y + map.factor * (splat.y + splat.my * t + my * (mean - t)),
          cyy * per_sample,
          -cxy * per_sample,
          cxx * per_sample,
          amplitude,
          0.0F,
          room,
          amplitude * std::exp(-0.5F * room)};
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

// The coarsest level whose samples show the splat on a sheet of that scale.
HWY_INLINE int level_for(const KernelFrame& frame, const Splat& splat, float scale) {
  const float sigma = splat.minor * scale / frame.least_level_sigma;
  if (!(sigma >= 2.0F)) return 0;
  return std::min(frame.max_level, static_cast<int>(std::ilogb(sigma)));
}

HWY_INLINE SplatSheet sheet_place(const KernelFrame& frame, float sheet) {
  const view::SplatSpace& space = frame.kernel_plan->space;
  if (space.is_parallel) return {sheet, 1.0F, 0.0F};
  const double depth = space.depth_of(sheet);
  return {sheet, static_cast<float>(space.scale(depth)),
          static_cast<float>(space.sampling_distance / depth)};
}

// Where on its slab a sample is taken: Gaussian sections are integrated in closed form, other
// profiles' means are taken at points.
HWY_INLINE int num_points(const KernelFrame& frame) {
  return frame.takes_means && frame.profile != KernelProfile::kGaussian ? device::kProfilePoints
                                                                        : 1;
}

// Runs `body(section)` for the sections that make up a splat's part of sheet j on a level.
template <class Body>
HWY_INLINE void for_each_section(const KernelFrame& frame, const Splat& splat,
                                 const SplatBlock& block, int j, int level, const Body& body) {
  const bool is_gaussian = frame.profile == KernelProfile::kGaussian;
  const int points = num_points(frame);
  for (int n = 0; n < points; ++n) {
    const SplatSheet& place = block.places[j * points + n];
    const float t = place.s - splat.s;
    const bool is_section = frame.takes_means && is_gaussian;
    if (std::abs(t) - (is_section ? 0.5F : 0.0F) >= splat.reach_s) continue;
    const LevelMap map = level_map(frame, block.tile_x, block.tile_y, level, place.scale);
    Section section;
    if (is_section) {
      section = mean_section(splat, t, frame.cutoff, (splat.x + splat.mx * t) * place.per_depth,
                             (splat.y + splat.my * t) * place.per_depth, map);
    } else {
      section = middle_section(splat, t, frame.cutoff, is_gaussian, map);
      if (points > 1) section.amplitude *= device::kProfilePointWeights[n];
    }
    if (section.room > 0) body(section);
  }
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

template <int kChannels, bool kIsGaussian>
HWY_INLINE void add_splat(const KernelFrame& frame, KernelWorkspace& work, const Splat& splat,
                          const SplatBlock& block, const SheetRun& run) {
  float coefficients[kMaxChannels] = {};
  set_coefficients(frame, splat, coefficients);
  for (int j = run.first; j < run.last; ++j) {
    const int level = level_for(frame, splat, block.scales[j]);
    const auto l = static_cast<std::size_t>(level);
    if (!work.is_touched[l]) {
      work.is_touched[l] = true;
      clear_level(frame, work, level, run);
    }
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
