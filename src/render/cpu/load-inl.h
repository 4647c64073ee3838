// SPDX-License-Identifier: Apache-2.0
// Stage "load": the lattice samples of a block's region, from whatever type and memory they are
// kept in, as floats.
//
// In:  the region, the field's brick source.
// Out: samples [size.z][size.y][row_stride], value * scale + offset, 0 where missing; the same for
// presence (1 or 0) if any is. A sample is used by about 20 samples of the block, so it is
// converted once; the region of a 16^3 block fits the L2 cache.
#if defined(OVOID_RENDER_CPU_LOAD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_LOAD_INL_H_
#undef OVOID_RENDER_CPU_LOAD_INL_H_
#else
#define OVOID_RENDER_CPU_LOAD_INL_H_
#endif

#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

template <typename T>
HWY_INLINE V LoadAsFloat(const T* from) {
  if constexpr (std::is_same_v<T, float>) {
    return hn::LoadU(d, from);
  } else {
    const hn::Rebind<T, D> stored;
    return hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(stored, from)));
  }
}

struct LoadScale {
  float scale, offset;
};

// One row: `presence` null for types that cannot miss.
template <typename T>
HWY_INLINE void LoadRow(const T* from, int count, LoadScale map, float* samples, float* presence) {
  const int group = GroupSize();
  const V scale = hn::Set(d, map.scale);
  const V offset = hn::Set(d, map.offset);
  const auto load_group = [&](int i) {
    V v = LoadAsFloat(from + i);
    if constexpr (std::is_same_v<T, float>) {
      const M exists = hn::Eq(hn::Sub(v, v), hn::Zero(d));  // false for NaN and infinities
      v = hn::IfThenElseZero(exists, hn::MulAdd(v, scale, offset));
      if (presence != nullptr)
        hn::StoreU(hn::IfThenElseZero(exists, hn::Set(d, 1.0F)), d, presence + i);
    } else {
      v = hn::MulAdd(v, scale, offset);
    }
    hn::StoreU(v, d, samples + i);
  };
  int i = 0;
  for (; i + group <= count; i += group) load_group(i);
  if (i == count) return;
  if (count >= group) {
    load_group(count - group);  // overlaps the group before
    return;
  }
  for (; i < count; ++i) {
    const float v = static_cast<float>(from[i]);
    const bool exists = std::isfinite(v);
    samples[i] = exists ? v * map.scale + map.offset : 0.0F;
    if (presence != nullptr) presence[i] = exists ? 1.0F : 0.0F;
  }
}

// The part of the region that `view` shows, [lo, hi) in lattice indices.
template <typename T>
void LoadPart(const Block& block, const BrickView& view, const Index3& lo, const Index3& hi,
              LoadScale map, float* samples, float* presence) {
  const T* data = static_cast<const T*>(view.data);
  const auto to_region = [&](std::int64_t index, int a) {
    return static_cast<int>(index - block.origin[a]) - block.region_lo[a];
  };
  const int count = static_cast<int>(hi[0] - lo[0]);
  for (std::int64_t z = lo[2]; z < hi[2]; ++z) {
    for (std::int64_t y = lo[1]; y < hi[1]; ++y) {
      const T* from = data + (lo[0] - view.lo[0]) + (y - view.lo[1]) * view.stride_y +
                      (z - view.lo[2]) * view.stride_z;
      const std::ptrdiff_t to = static_cast<std::ptrdiff_t>(to_region(z, 2)) * block.slice_stride +
                                static_cast<std::ptrdiff_t>(to_region(y, 1)) * block.row_stride +
                                to_region(lo[0], 0);
      LoadRow(from, count, map, samples + to, presence == nullptr ? nullptr : presence + to);
    }
  }
}

inline void LoadTypedPart(const Block& block, const BrickView& view, const Index3& lo,
                          const Index3& hi, LoadScale map, float* samples, float* presence) {
  switch (view.type) {
    case ScalarType::kUInt8:
      return LoadPart<std::uint8_t>(block, view, lo, hi, map, samples, presence);
    case ScalarType::kInt8:
      return LoadPart<std::int8_t>(block, view, lo, hi, map, samples, presence);
    case ScalarType::kUInt16:
      return LoadPart<std::uint16_t>(block, view, lo, hi, map, samples, presence);
    case ScalarType::kInt16:
      return LoadPart<std::int16_t>(block, view, lo, hi, map, samples, presence);
    default:
      return LoadPart<float>(block, view, lo, hi, map, samples, presence);
  }
}

// Does a brick that the region touches lack samples?
inline bool RegionMisses(const BrickSource& source, const Index3& lo, const Index3& hi) {
  const int edge = source.brick_edge();
  for (std::int64_t bz = lo[2] / edge; bz <= (hi[2] - 1) / edge; ++bz) {
    for (std::int64_t by = lo[1] / edge; by <= (hi[1] - 1) / edge; ++by) {
      for (std::int64_t bx = lo[0] / edge; bx <= (hi[0] - 1) / edge; ++bx) {
        if (source.has_missing(bx, by, bz)) return true;
      }
    }
  }
  return false;
}

inline void Load(const CpuFrame& frame, Workspace& work) {
  Block& block = work.block;
  const BrickSource& source = frame.field->source();
  block.row_stride = block.region_size[0] + kTapPadding;
  block.slice_stride = block.row_stride * block.region_size[1];
  const std::size_t count =
      static_cast<std::size_t>(block.slice_stride) * block.region_size[2] + kTapPadding;
  Index3 lo{};
  Index3 hi{};
  for (int a = 0; a < 3; ++a) {
    lo[a] = block.origin[a] + block.region_lo[a];
    hi[a] = lo[a] + block.region_size[a];
  }
  block.has_missing = RegionMisses(source, lo, hi);
  float* samples = work.samples.reserve(count);
  float* presence = block.has_missing ? work.presence.reserve(count) : nullptr;
  // The padding is read under zero weights; it must not hold what times zero is not zero.
  for (int z = 0; z < block.region_size[2]; ++z) {
    for (int y = 0; y < block.region_size[1]; ++y) {
      const std::ptrdiff_t end = static_cast<std::ptrdiff_t>(z) * block.slice_stride +
                                 y * block.row_stride + block.region_size[0];
      std::fill(samples + end, samples + end + kTapPadding, 0.0F);
      if (presence != nullptr) std::fill(presence + end, presence + end + kTapPadding, 0.0F);
    }
  }
  std::fill(samples + count - kTapPadding, samples + count, 0.0F);
  if (presence != nullptr) std::fill(presence + count - kTapPadding, presence + count, 0.0F);
  const LoadScale map{frame.value_scale, frame.value_offset};

  // A view may show more than its brick: walk over the region in the steps that the views allow.
  const int edge = source.brick_edge();
  Index3 at = lo;
  while (at[2] < hi[2]) {
    std::int64_t next_z = hi[2];
    for (at[1] = lo[1]; at[1] < hi[1];) {
      std::int64_t next_y = hi[1];
      for (at[0] = lo[0]; at[0] < hi[0];) {
        const BrickView view = source.acquire(at[0] / edge, at[1] / edge, at[2] / edge, 0.0);
        const Index3 part_hi{std::min(hi[0], view.hi[0]), std::min(hi[1], view.hi[1]),
                             std::min(hi[2], view.hi[2])};
        next_y = std::min(next_y, part_hi[1]);
        next_z = std::min(next_z, part_hi[2]);
        LoadTypedPart(block, view, at, part_hi, map, samples, presence);
        at[0] = part_hi[0];
      }
      at[1] = next_y;
    }
    at[2] = next_z;
  }
  work.stats.kernels_loaded +=
      num_samples({block.region_size[0], block.region_size[1], block.region_size[2]});
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
