// SPDX-License-Identifier: Apache-2.0
// What a sheet has of a splat: its section. Where it lies on the samples of a level, how wide it
// is, and what it is worth at a place.
#if defined(OVOID_RENDER_CPU_SECTIONS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_SECTIONS_INL_H_
#undef OVOID_RENDER_CPU_SECTIONS_INL_H_
#else
#define OVOID_RENDER_CPU_SECTIONS_INL_H_
#endif

#include <algorithm>
#include <cmath>

#include "render/cpu/kernels/kernel_block.h"
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
  int tile_x, tile_y;            // pixel of its corner
  float tail;                    // Gaussian: what a kernel of height 1 falls to at its cut
  alignas(64) float sheets[16];  // the sheets' numbers in the frame
  alignas(64) float scales[16];  // of the sheets' middle planes
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

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
