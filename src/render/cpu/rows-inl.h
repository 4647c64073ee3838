// SPDX-License-Identifier: Apache-2.0
// Stage "reconstruct" on lattice sheets. The samples of a row share their weights along two of the
// lattice's axes, and those of a column along the third, so that the sum over 4 x 4 x 4 kernels is
// three passes of four multiply-adds each:
//
//   slices   four slices of the lattice become the lattice's samples on the sheet
//   rows     four rows of these become a row of the sheet's, one for each sample along the lattice
//   columns  four neighbours of these become a sample
//
// With the gradient each pass has as many more as derivatives it adds: 8, 12 and 16 in all.
//
// In:  a block of lattice sheets whose region is stored as pairs of slices (load-inl.h).
// Out: values, and where asked gradients, of the samples named, and which of them are defined.
#if defined(OVOID_RENDER_CPU_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_ROWS_INL_H_
#undef OVOID_RENDER_CPU_ROWS_INL_H_
#else
#define OVOID_RENDER_CPU_ROWS_INL_H_
#endif

#include "render/cpu/gather-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Samples of base planes are at most a spacing apart: so many samples of the lattice lie along a
// block's row or column, taps and groups that begin at any of them included.
inline constexpr int kMostAcross = kTileSize + 4;
inline constexpr int kRowFloats = 2 * kTileSize + kMaxLanes;

// The weights of a sheet's columns, rows, or of the sheet, along one axis: [tap][sample].
struct SharedTaps {
  alignas(64) float weight[4][kTileSize];
  alignas(64) float slope[4][kTileSize];
  alignas(64) float share[kTileSize];         // of the weights that exist
  alignas(64) std::int32_t first[kTileSize];  // tap 0, of the region
};

// Of `count` samples at base + i * step, relative to the region's origin. Derivatives are corrected
// where the frame's are (gather-inl.h).
inline void set_shared_taps(const LatticeFrame& frame, const Region& region, int axis, float base,
                            float step, int count, SharedTaps& taps) {
  for (int i = 0; i < count; i += group_size()) {
    const V position =
        hn::MulAdd(hn::Iota(d, static_cast<float>(i)), hn::Set(d, step), hn::Set(d, base));
    const V whole = hn::Floor(position);
    V share = hn::Set(d, 1.0F);
    const FourWeights w = four_weights_at</*kNarrow=*/false, /*kBorder=*/true, /*kGradient=*/true>(
        whole, hn::Sub(position, whole), frame.lattice,
        ends_of(frame.lattice.sublattices[0], region, axis), share);
    const V correction = correction_for(w.variance, frame);
    for (int k = 0; k < 4; ++k) {
      hn::Store(w.w[k], d, taps.weight[k] + i);
      hn::Store(hn::Mul(w.slope[k], correction), d, taps.slope[k] + i);
    }
    hn::Store(share, d, taps.share + i);
    hn::Store(hn::Sub(nearest_integer(whole), hn::Set(di, region.lo[axis] + 1)), di,
              taps.first + i);
  }
}

// The lattice's samples on a sheet, and their derivatives from sheet to sheet.
struct SheetOfLattice {
  alignas(64) float value[kMostAcross][kRowFloats];
  alignas(64) float slope[kMostAcross][kRowFloats];
};

// A row of a sheet, one number for each sample along the lattice.
struct RowOfLattice {
  alignas(64) float value[kRowFloats];
  alignas(64) float slope_y[kRowFloats];
  alignas(64) float slope_z[kRowFloats];
};

// Four taps of a group of samples.
struct FourTaps {
  V tap[4];
};

// Of a row: `first` holds tap 0 of the group's samples, ascending.
#if HWY_TARGET == HWY_SCALAR
struct TapPicker {
  TapPicker() = default;
  explicit TapPicker(const std::int32_t* first) : base(first[0]) {}
  HWY_INLINE FourTaps operator()(const float* row) const {
    row += base;
    return {{hn::Load(d, row), hn::Load(d, row + 1), hn::Load(d, row + 2), hn::Load(d, row + 3)}};
  }
  int base = 0;
};
#else
struct TapPicker {
  using Indices = decltype(hn::IndicesFromVec(d, hn::Zero(di)));

  HWY_INLINE static Indices indices(VI v) {
    return hn::IndicesFromVec(d, hn::And(v, hn::Set(di, group_size() - 1)));
  }
  TapPicker() = default;
  HWY_INLINE explicit TapPicker(const std::int32_t* first)
      : base(first[0]),
        lane(hn::Sub(hn::Load(di, first), hn::Set(di, first[0]))),
        fits_one(first[group_size() - 1] - first[0] + 3 < group_size()),
        index{indices(lane), indices(hn::Add(lane, hn::Set(di, 1))),
              indices(hn::Add(lane, hn::Set(di, 2))), indices(hn::Add(lane, hn::Set(di, 3)))} {}

  HWY_INLINE FourTaps operator()(const float* row) const {
    const V near = hn::LoadU(d, row + base);
    FourTaps taps;
    for (int k = 0; k < 4; ++k) taps.tap[k] = hn::TableLookupLanes(near, index[k]);
    if (fits_one) return taps;
    const V far = hn::LoadU(d, row + base + group_size());
    for (int k = 0; k < 4; ++k) {
      const M is_near = hn::RebindMask(d, hn::Lt(lane, hn::Set(di, group_size() - k)));
      taps.tap[k] = hn::IfThenElse(is_near, taps.tap[k], hn::TableLookupLanes(far, index[k]));
    }
    return taps;
  }

  int base;
  VI lane;
  bool fits_one;
  Indices index[4];
};
#endif

HWY_INLINE V sum_of_taps(const FourTaps& taps, const float (*weights)[kTileSize], int i) {
  const auto w = [&](int k) { return hn::Load(d, weights[k] + i); };
  return hn::MulAdd(
      taps.tap[0], w(0),
      hn::MulAdd(taps.tap[1], w(1), hn::MulAdd(taps.tap[2], w(2), hn::Mul(taps.tap[3], w(3)))));
}

// The samples of a sheet to be worked out: bounds of those named by bits.
struct SampleBounds {
  int x0 = kTileSize, x1 = 0, y0 = kTileSize, y1 = 0;
};

inline SampleBounds bounds_of(const RowBits& bits, int rows) {
  SampleBounds bounds;
  RowWord any = 0;
  for (int y = 0; y < rows; ++y) {
    if (bits[y] == 0) continue;
    any |= bits[y];
    bounds.y0 = std::min(bounds.y0, y);
    bounds.y1 = y + 1;
  }
  if (any == 0) return bounds;
  bounds.x0 = std::countr_zero(any);
  bounds.x1 = 64 - std::countl_zero(any);
  return bounds;
}

// Taps of a sheet along the three axes, and what is summed along the last of them.
struct SheetTaps {
  SharedTaps x, y, z;
  SheetOfLattice lattice;
};

// Pass "slices", of the part of the lattice that samples within `bounds` read.
template <bool kGradient>
inline void sum_slices(const Region& region, const SampleBounds& bounds, SheetTaps& taps) {
  const int first_column = taps.x.first[bounds.x0];
  const int end_column = taps.x.first[bounds.x1 - 1] + 4;
  const int first_row = taps.y.first[bounds.y0];
  const int end_row = taps.y.first[bounds.y1 - 1] + 4;
  const std::ptrdiff_t row = 2 * static_cast<std::ptrdiff_t>(region.row_stride);
  const std::ptrdiff_t two_slices = 4 * static_cast<std::ptrdiff_t>(region.slice_stride);
  const float* from = region.samples +
                      2 * static_cast<std::ptrdiff_t>(taps.z.first[0]) * region.slice_stride +
                      row * first_row + 2 * first_column;
  V w[4], s[4];
  for (int k = 0; k < 4; ++k) {
    w[k] = hn::Set(d, taps.z.weight[k][0]);
    s[k] = hn::Set(d, taps.z.slope[k][0]);
  }
  for (int y = first_row; y < end_row; ++y, from += row) {
    for (int x = 0; x < end_column - first_column; x += group_size()) {
      V a0, a1, a2, a3;
#if HWY_TARGET == HWY_SCALAR
      a0 = hn::Load(d, from + 2 * x);
      a1 = hn::Load(d, from + 2 * x + 1);
      a2 = hn::Load(d, from + two_slices + 2 * x);
      a3 = hn::Load(d, from + two_slices + 2 * x + 1);
#else
      hn::LoadInterleaved2(d, from + 2 * x, a0, a1);
      hn::LoadInterleaved2(d, from + two_slices + 2 * x, a2, a3);
#endif
      const auto sum = [&](const V(&c)[4]) {
        return hn::MulAdd(a0, c[0], hn::MulAdd(a1, c[1], hn::MulAdd(a2, c[2], hn::Mul(a3, c[3]))));
      };
      hn::StoreU(sum(w), d, taps.lattice.value[y - first_row] + x);
      if constexpr (kGradient) hn::StoreU(sum(s), d, taps.lattice.slope[y - first_row] + x);
    }
  }
}

// Pass "rows", of sample row y.
template <bool kGradient>
HWY_INLINE void sum_rows(const SheetTaps& taps, int y, int first_row, int columns,
                         RowOfLattice& out) {
  const int first = taps.y.first[y] - first_row;
  V w[4], s[4];
  for (int k = 0; k < 4; ++k) {
    w[k] = hn::Set(d, taps.y.weight[k][y]);
    if constexpr (kGradient) s[k] = hn::Set(d, taps.y.slope[k][y]);
  }
  for (int x = 0; x < columns; x += group_size()) {
    const auto sum = [&](const float(&rows)[kMostAcross][kRowFloats], const V(&c)[4]) {
      const auto at = [&](int k) { return hn::LoadU(d, rows[first + k] + x); };
      return hn::MulAdd(at(0), c[0],
                        hn::MulAdd(at(1), c[1], hn::MulAdd(at(2), c[2], hn::Mul(at(3), c[3]))));
    };
    hn::StoreU(sum(taps.lattice.value, w), d, out.value + x);
    if constexpr (kGradient) {
      hn::StoreU(sum(taps.lattice.value, s), d, out.slope_y + x);
      hn::StoreU(sum(taps.lattice.slope, w), d, out.slope_z + x);
    }
  }
}

// True if the block's samples can be worked out like this.
inline bool has_rows(const LatticeFrame& frame, const Block& block) {
  return frame.has_rows && block.region.uses_four_taps;
}

// Adds the samples named by `wanted` to sheet s of the block, which are marked in the sheet.
template <bool kGradient>
inline void reconstruct_rows(const LatticeFrame& frame, Workspace& work, int s,
                             const RowBits& wanted) {
  const Block& block = work.block;
  const Region& region = block.region;
  const SheetInLattice& place = block.sheets[s];
  Sheet& sheet = work.ring[block.place.number_of(s)];
  const SampleBounds bounds = bounds_of(wanted, block.place.rows);
  if (bounds.x0 >= bounds.x1) return;
  SheetTaps taps;
  set_shared_taps(frame, region, 0, place.base[0], place.per_x[0], block.place.columns, taps.x);
  set_shared_taps(frame, region, 1, place.base[1], place.per_y[1], block.place.rows, taps.y);
  set_shared_taps(frame, region, 2, place.base[2], 0.0F, 1, taps.z);
  sum_slices<kGradient>(region, bounds, taps);
  const int first_column = taps.x.first[bounds.x0];
  const int columns = taps.x.first[bounds.x1 - 1] + 4 - first_column;
  const int first_row = taps.y.first[bounds.y0];
  // Columns beside those that are wanted read the ends.
  for (int x = 0; x < kTileSize; ++x) {
    taps.x.first[x] =
        std::clamp(taps.x.first[x], first_column, first_column + columns - 4) - first_column;
  }
  TapPicker pickers[kTileSize];
  const int first_group = bounds.x0 / group_size();
  for (int g = first_group; g * group_size() < bounds.x1; ++g)
    pickers[g] = TapPicker(taps.x.first + g * group_size());
  RowOfLattice row;
  for (int y = bounds.y0; y < bounds.y1; ++y) {
    if (wanted[y] == 0) continue;
    sum_rows<kGradient>(taps, y, first_row, columns, row);
    const V share_yz = hn::Set(d, taps.y.share[y] * taps.z.share[0]);
    for (int g = first_group; g * group_size() < bounds.x1; ++g) {
      const int x = g * group_size();
      const std::uint32_t lanes = lanes_at(wanted[y], x);
      if (lanes == 0) continue;
      // Neighbours may have their values already.
      const M mask = mask_of(lanes);
      const int at = sheet.at(x, y);
      const FourTaps values = pickers[g](row.value);
      hn::BlendedStore(sum_of_taps(values, taps.x.weight, x), mask, d, sheet.values + at);
      const M is_whole =
          hn::Ge(hn::Mul(hn::Load(d, taps.x.share + x), share_yz), hn::Set(d, device::kLeastShare));
      sheet.defined[y] |= RowWord{bits_of(is_whole) & lanes} << x;
      if constexpr (kGradient) {
        const WorldVector slope = to_world(frame, sum_of_taps(values, taps.x.slope, x),
                                           sum_of_taps(pickers[g](row.slope_y), taps.x.weight, x),
                                           sum_of_taps(pickers[g](row.slope_z), taps.x.weight, x));
        hn::BlendedStore(slope.x, mask, d, sheet.gradient[0] + at);
        hn::BlendedStore(slope.y, mask, d, sheet.gradient[1] + at);
        hn::BlendedStore(slope.z, mask, d, sheet.gradient[2] + at);
        sheet.has_gradient[y] |= RowWord{lanes} << x;
        work.stats.gradients += std::popcount(lanes);
      }
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
