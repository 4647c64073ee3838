// SPDX-License-Identifier: Apache-2.0
// Stage "load": the lattice samples of a block's region, from whatever type and memory they are
// kept in, as floats.
//
// In:  the region, the field's brick source.
// Out: either pairs of slices, [size.z][size.y][row_stride][2]: sample (x, y, z) and (x, y, z + 1)
// side
//      by side, as the four-tap way of reconstruction reads them; or plain samples
//      [size.z][size.y][row_stride], and the same for presence (1 or 0) if any is missing. Values
//      are stored * scale + offset, 0 where missing or outside the lattice.
//
// A sample is used by about 20 samples of the block, so it is converted once; the region of a
// 16^3 block fits the L2 cache.
#if defined(OVOID_RENDER_CPU_LOAD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_LOAD_INL_H_
#undef OVOID_RENDER_CPU_LOAD_INL_H_
#else
#define OVOID_RENDER_CPU_LOAD_INL_H_
#endif

#include <hwy/cache_control.h>

#include "render/cpu/lattice/lattice_block.h"
#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

template <typename T>
HWY_INLINE V load_as_float(const T* from) {
  if constexpr (std::is_same_v<T, float>) {
    return hn::LoadU(d, from);
  } else {
    const hn::Rebind<T, D> stored;
    return hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(stored, from)));
  }
}

inline constexpr int kMaxRowAcross = 64;  // samples at a time
inline constexpr int kPrefetchRows = 6;   // about the time of a trip to memory

// Values are stored numbers * scale + offset.
struct LoadScale {
  float scale, offset;
};

// Where a sublattice's part of the region goes.
struct LoadTarget {
  float* samples;
  float* presence;  // null: none is missing
  LoadScale map;
};

// Samples of a sublattice: [lo, hi).
struct LatticePart {
  Index3 lo, hi;
};

// All samples of a row: whole groups by `load_group`, of which the last may overlap the one before;
// rows shorter than a group one by one.
template <class LoadGroup, class LoadOne>
HWY_INLINE void for_each_sample(int count, const LoadGroup& load_group, const LoadOne& load_one) {
  const int group = group_size();
  if (count < group) {
    for (int i = 0; i < count; ++i) load_one(i);
    return;
  }
  for (int i = 0; i + group <= count; i += group) load_group(i);
  if (count % group != 0) load_group(count - group);
}

// One row: `presence` null for types that cannot miss.
template <typename T>
HWY_INLINE void load_row(const T* from, int count, LoadScale map, float* samples, float* presence) {
  const V scale = hn::Set(d, map.scale);
  const V offset = hn::Set(d, map.offset);
  const auto load_group = [&](int i) {
    V v = load_as_float(from + i);
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
  for_each_sample(count, load_group, [&](int i) {
    const float v = static_cast<float>(from[i]);
    const bool exists = std::isfinite(v);
    samples[i] = exists ? v * map.scale + map.offset : 0.0F;
    if (presence != nullptr) presence[i] = exists ? 1.0F : 0.0F;
  });
}

// Two rows of neighbouring slices, side by side; `after` null: zeros.
template <typename T>
HWY_INLINE void load_row_pair(const T* row, const T* after, int count, LoadScale map,
                              float* pairs) {
  const V scale = hn::Set(d, map.scale);
  const V offset = hn::Set(d, map.offset);
  const auto load_group = [&](int i) {
    const V a = hn::MulAdd(load_as_float(row + i), scale, offset);
    const V b =
        after == nullptr ? hn::Zero(d) : hn::MulAdd(load_as_float(after + i), scale, offset);
#if HWY_TARGET == HWY_SCALAR
    hn::Store(a, d, pairs + 2 * i);
    hn::Store(b, d, pairs + 2 * i + 1);
#else
    hn::StoreInterleaved2(a, b, d, pairs + 2 * i);
#endif
  };
  for_each_sample(count, load_group, [&](int i) {
    pairs[2 * i] = static_cast<float>(row[i]) * map.scale + map.offset;
    pairs[2 * i + 1] =
        after == nullptr ? 0.0F : static_cast<float>(after[i]) * map.scale + map.offset;
  });
}

// The part of the region that `view` shows, as pairs. Parts come in order of z: the second of a
// pair whose slice another view shows is set when that view's turn comes.
template <typename T>
void load_part_pairs(const Region& region, const BrickView& view, const LatticePart& part,
                     const LoadTarget& target) {
  const auto& [lo, hi] = part;
  const T* data = static_cast<const T*>(view.data);
  const auto to_region = [&](std::int64_t index, int a) {
    return static_cast<std::ptrdiff_t>(index - region.origin[a]) - region.lo[a];
  };
  const int count = static_cast<int>(hi[0] - lo[0]);
  for (std::int64_t z = lo[2]; z < hi[2]; ++z) {
    for (std::int64_t y = lo[1]; y < hi[1]; ++y) {
      const T* from = data + (lo[0] - view.lo[0]) + (y - view.lo[1]) * view.stride_y +
                      (z - view.lo[2]) * view.stride_z;
      const std::ptrdiff_t to = to_region(z, 2) * region.slice_stride +
                                to_region(y, 1) * region.row_stride + to_region(lo[0], 0);
      // The slice behind is new; its rows are too short for the hardware to guess the next one.
      if (y + kPrefetchRows < hi[1] && z + 1 < hi[2]) {
        const T* ahead = from + view.stride_z + kPrefetchRows * view.stride_y;
        hwy::Prefetch(ahead);
        hwy::Prefetch(ahead + count - 1);
      }
      load_row_pair(from, z + 1 < hi[2] ? from + view.stride_z : nullptr, count, target.map,
                    target.samples + 2 * to);
      if (z > lo[2] || to_region(z, 2) == 0) continue;
      float* before = target.samples + 2 * (to - region.slice_stride) + 1;
      for (int i = 0; i < count; ++i)
        before[2 * i] = static_cast<float>(from[i]) * target.map.scale + target.map.offset;
    }
  }
}

// The part of the region that `view` shows.
template <typename T>
void load_part(const Region& region, const BrickView& view, const LatticePart& part,
               const LoadTarget& target) {
  const auto& [lo, hi] = part;
  const T* data = static_cast<const T*>(view.data);
  const auto to_region = [&](std::int64_t index, int a) {
    return static_cast<int>(index - region.origin[a]) - region.lo[a];
  };
  const int count = static_cast<int>(hi[0] - lo[0]);
  for (std::int64_t z = lo[2]; z < hi[2]; ++z) {
    for (std::int64_t y = lo[1]; y < hi[1]; ++y) {
      const T* from = data + (lo[0] - view.lo[0]) + (y - view.lo[1]) * view.stride_y +
                      (z - view.lo[2]) * view.stride_z;
      const std::ptrdiff_t to = static_cast<std::ptrdiff_t>(to_region(z, 2)) * region.slice_stride +
                                static_cast<std::ptrdiff_t>(to_region(y, 1)) * region.row_stride +
                                to_region(lo[0], 0);
      load_row(from, count, target.map, target.samples + to,
               target.presence == nullptr ? nullptr : target.presence + to);
    }
  }
}

template <typename T>
void load_part_as(const Region& region, const BrickView& view, const LatticePart& part,
                  const LoadTarget& target) {
  if (region.is_paired) {
    load_part_pairs<T>(region, view, part, target);
  } else {
    load_part<T>(region, view, part, target);
  }
}

// The same where the axis from sheet to sheet is that along which samples lie side by side: rows of
// the region run from row to row of `view`, its slices along the rows. `part` and `view` are in the
// field's own order.
template <typename T>
void load_part_across(const Region& region, const BrickView& view, const LatticePart& part,
                      const LoadTarget& target) {
  const auto& [lo, hi] = part;
  const T* data = static_cast<const T*>(view.data);
  const auto to_region = [&](std::int64_t index, int a) {
    return static_cast<std::ptrdiff_t>(index - region.origin[a]) - region.lo[a];
  };
  const int count = static_cast<int>(hi[0] - lo[0]);
  const std::ptrdiff_t first_slice = to_region(lo[0], 2);
  const std::ptrdiff_t floats = region.is_paired ? 2 : 1;
  const std::ptrdiff_t slice = floats * region.slice_stride;
  alignas(64) float row[kMaxRowAcross + kTapPadding];
  alignas(64) float presence[kMaxRowAcross + kTapPadding];
  for (std::int64_t z = lo[2]; z < hi[2]; ++z) {
    for (std::int64_t y = lo[1]; y < hi[1]; ++y) {
      const T* from = data + (lo[0] - view.lo[0]) + (y - view.lo[1]) * view.stride_y +
                      (z - view.lo[2]) * view.stride_z;
      const std::ptrdiff_t to =
          first_slice * slice + floats * (to_region(z, 1) * region.row_stride + to_region(y, 0));
      for (int first = 0; first < count; first += kMaxRowAcross) {
        const int some = std::min(count - first, kMaxRowAcross);
        load_row(from + first, some, target.map, row,
                 target.presence == nullptr ? nullptr : presence);
        float* out = target.samples + to + first * slice;
        if (region.is_paired) {
          if (first_slice + first > 0) out[1 - slice] = row[0];
          row[some] = 0;  // of the slice behind, whose turn comes
          for (int i = 0; i < some; ++i) std::memcpy(out + i * slice, row + i, 2 * sizeof(float));
        } else {
          for (int i = 0; i < some; ++i) out[i * slice] = row[i];
          if (target.presence == nullptr) continue;
          float* const exists = target.presence + to + first * slice;
          for (int i = 0; i < some; ++i) exists[i * slice] = presence[i];
        }
      }
    }
  }
}

// A brick view or a part with its axes in the order of the frame.
template <class Box>
inline void put_in_order(Box& box, const view::AxisOrder& order) {
  const Index3 lo = box.lo;
  const Index3 hi = box.hi;
  for (std::size_t i = 0; i < 3; ++i) {
    box.lo[i] = lo[static_cast<std::size_t>(order[i])];
    box.hi[i] = hi[static_cast<std::size_t>(order[i])];
  }
}

template <typename T>
void load_part_in_order(const Region& region, BrickView view, LatticePart part,
                        const view::AxisOrder& order, const LoadTarget& target) {
  if (order[2] == 0) return load_part_across<T>(region, view, part, target);
  if (order[2] == 1) {
    put_in_order(view, order);
    std::swap(view.stride_y, view.stride_z);
    put_in_order(part, order);
  }
  load_part_as<T>(region, view, part, target);
}

inline void load_typed_part(const Region& region, const BrickView& view, const LatticePart& part,
                            const view::AxisOrder& order, const LoadTarget& target) {
  switch (view.type) {
    case ScalarType::kUInt8:
      return load_part_in_order<std::uint8_t>(region, view, part, order, target);
    case ScalarType::kInt8:
      return load_part_in_order<std::int8_t>(region, view, part, order, target);
    case ScalarType::kUInt16:
      return load_part_in_order<std::uint16_t>(region, view, part, order, target);
    case ScalarType::kInt16:
      return load_part_in_order<std::int16_t>(region, view, part, order, target);
    default:
      return load_part_in_order<float>(region, view, part, order, target);
  }
}

// Does a brick that the region touches lack samples?
inline bool region_misses(const BrickSource& source, const Index3& lo, const Index3& hi) {
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

// May this block take the four-tap way of reconstruction? Decided before loading, which stores the
// region accordingly.
inline bool can_use_four_taps(const LatticeFrame& frame, const Block& block) {
  return frame.has_four_taps && !block.region.has_missing && !block.widens_kernels();
}

// Behind every row, and behind the last.
inline void clear_padding(const Region& region, float* floats) {
  const int num_rows = region.size[1] * region.size[2];
  for (int row = 0; row < num_rows; ++row) {
    std::fill_n(floats + static_cast<std::ptrdiff_t>(row) * region.row_stride + region.size[0],
                kTapPadding, 0.0F);
  }
  std::fill_n(floats + static_cast<std::ptrdiff_t>(num_rows) * region.row_stride, kTapPadding,
              0.0F);
}

// What of the region lies in a sublattice, in the field's own order.
inline LatticePart part_in_lattice(const Region& region, const device::Sublattice& sublattice,
                                   const view::AxisOrder& order) {
  LatticePart part{};
  for (int i = 0; i < 3; ++i) {
    const auto a = static_cast<std::size_t>(order[static_cast<std::size_t>(i)]);
    const std::int64_t first = region.origin[i] + region.lo[i];
    const std::int64_t size = sublattice.dims[i];
    part.lo[a] = std::clamp<std::int64_t>(first, 0, size - 1);
    part.hi[a] = std::clamp<std::int64_t>(first + region.size[i], part.lo[a] + 1, size);
  }
  return part;
}

// Sublattice s of `count` in what a source shows: every so many-th layer.
inline BrickView sublattice_view(BrickView view, int s, int count) {
  if (count == 1) return view;
  const auto first_at_or_behind = [&](std::int64_t layer) {
    return (std::max<std::int64_t>(layer - s, 0) + count - 1) / count;
  };
  const std::int64_t first = first_at_or_behind(view.lo[2]);
  view.data = static_cast<const std::byte*>(view.data) +
              (first * count + s - view.lo[2]) * view.stride_z *
                  static_cast<std::ptrdiff_t>(size_of(view.type));
  view.hi[2] = first_at_or_behind(view.hi[2]);
  view.lo[2] = first;
  view.stride_z *= count;
  return view;
}

// A sublattice's samples. A view may show more than its brick: walks over the region in the steps
// that the views allow. Returns the bytes that were read.
inline std::int64_t load_sublattice(const LatticeFrame& frame, const Region& region, int s,
                                    const LoadTarget& target) {
  const BrickSource& source = frame.field->source();
  const view::AxisOrder& order = frame.lattice_plan->order;
  const auto [lo, hi] = part_in_lattice(region, frame.lattice.sublattices[s], order);
  const int edge = source.brick_edge();
  std::int64_t bytes = 0;
  Index3 at = lo;
  while (at[2] < hi[2]) {
    std::int64_t next_z = hi[2];
    for (at[1] = lo[1]; at[1] < hi[1];) {
      std::int64_t next_y = hi[1];
      for (at[0] = lo[0]; at[0] < hi[0];) {
        const BrickView view =
            sublattice_view(source.acquire(at[0] / edge, at[1] / edge, at[2] / edge, 0.0), s,
                            frame.lattice.num_sublattices);
        const Index3 part_hi{std::min(hi[0], view.hi[0]), std::min(hi[1], view.hi[1]),
                             std::min(hi[2], view.hi[2])};
        next_y = std::min(next_y, part_hi[1]);
        next_z = std::min(next_z, part_hi[2]);
        load_typed_part(region, view, {at, part_hi}, order, target);
        bytes += (part_hi[0] - at[0]) * (part_hi[1] - at[1]) * (part_hi[2] - at[2]) *
                 static_cast<std::int64_t>(size_of(view.type));
        at[0] = part_hi[0];
      }
      at[1] = next_y;
    }
    at[2] = next_z;
  }
  return bytes;
}

// `is_scattered`: the region is for kernels that splat themselves, which read it plainly.
inline void load_region(const LatticeFrame& frame, Workspace& work, bool is_scattered) {
  Region& region = work.block.region;
  const auto [lo, hi] =
      part_in_lattice(region, frame.lattice.sublattices[0], frame.lattice_plan->order);
  region.has_missing = region_misses(frame.field->source(), lo, hi);
  region.uses_four_taps = !is_scattered && can_use_four_taps(frame, work.block);
  region.is_paired = region.uses_four_taps && !frame.has_only_rows;
  region.row_stride = region.size[0] + (region.is_paired ? 0 : kTapPadding);
  region.slice_stride = region.row_stride * region.size[1];
  const std::size_t floats_per_sample = region.is_paired ? 2 : 1;
  const std::size_t own_count =
      floats_per_sample * (region.slice_stride * region.size[2] + kTapPadding);
  const std::size_t count = own_count * static_cast<std::size_t>(frame.lattice.num_sublattices);
  region.sublattice_stride = static_cast<std::ptrdiff_t>(own_count);
  float* samples = work.sample_memory.reserve(count);
  region.samples = samples;
  float* presence = region.has_missing ? work.presence_memory.reserve(count) : nullptr;
  region.presence = presence;
  // Padding and places outside the lattice are read under zero weights; they must not hold what
  // times zero is not zero.
  if (!region.is_interior) {
    std::fill_n(samples, count, 0.0F);
    if (presence != nullptr) std::fill_n(presence, count, 0.0F);
  }
  for (int s = 0; s < frame.lattice.num_sublattices; ++s) {
    const LoadTarget target{samples + s * region.sublattice_stride,
                            presence == nullptr ? nullptr : presence + s * region.sublattice_stride,
                            {frame.lattice.value_scale, frame.lattice.value_offset}};
    if (region.is_interior && !region.is_paired) {
      clear_padding(region, target.samples);
      if (target.presence != nullptr) clear_padding(region, target.presence);
    }
    work.stats.bytes_loaded += load_sublattice(frame, region, s, target);
  }
  work.stats.kernels_loaded += frame.lattice.num_sublattices * region.num_samples();
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
