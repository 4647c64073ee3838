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

// Samples along an axis: `count` at base + i * step, relative to the region's origin.
struct AxisSamples {
  int axis;
  float base, step;
  int count;
};

// Derivatives are corrected where the frame's are (gather-inl.h).
template <bool kBorder>
inline void set_shared_taps(const LatticeFrame& frame, const Region& region,
                            const AxisSamples& samples, SharedTaps& taps) {
  const AxisEnds ends = ends_of(frame.lattice.sublattices[0], region, samples.axis);
  for (int i = 0; i < samples.count; i += group_size()) {
    const V position = hn::MulAdd(hn::Iota(d, static_cast<float>(i)), hn::Set(d, samples.step),
                                  hn::Set(d, samples.base));
    const V whole = hn::Floor(position);
    V share = hn::Set(d, 1.0F);
    const FourWeights w = four_weights_at</*kNarrow=*/false, kBorder, /*kGradient=*/true>(
        whole, hn::Sub(position, whole), frame.lattice, ends, share);
    const V correction = correction_for(w.variance, frame);
    for (int k = 0; k < 4; ++k) {
      hn::Store(w.w[k], d, taps.weight[k] + i);
      hn::Store(hn::Mul(w.slope[k], correction), d, taps.slope[k] + i);
    }
    hn::Store(share, d, taps.share + i);
    hn::Store(hn::Sub(nearest_integer(whole), hn::Set(di, region.lo[samples.axis] + 1)), di,
              taps.first + i);
  }
}

// Of all samples of sheet s of a block.
inline void set_taps(const LatticeFrame& frame, const Block& block, int s, RowsOfSheet& rows) {
  const SheetInLattice& sheet = block.sheets[s];
  const AxisSamples columns{0, sheet.base[0], sheet.per_x[0], block.place.columns};
  const AxisSamples lines{1, sheet.base[1], sheet.per_y[1], block.place.rows};
  const AxisSamples own{2, sheet.base[2], 0, 1};
  const auto set = [&](auto is_border) {
    set_shared_taps<is_border>(frame, block.region, columns, rows.x);
    set_shared_taps<is_border>(frame, block.region, lines, rows.y);
    set_shared_taps<is_border>(frame, block.region, own, rows.z);
  };
  block.region.is_interior ? set(std::false_type()) : set(std::true_type());
}

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

// Of a row: `first` holds tap 0 of the group's samples, ascending. Taps of a group of four lie
// among two groups of the lattice's samples, and so do those of wider ones.
static_assert(3 * view::kMostSpacings + 4 <= 8);
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

inline SampleBounds bounds_of(const RowBits& bits, int rows) {
  SampleBounds bounds;
  RowWord any = 0;
  for (int y = 0; y < rows; ++y) {
    if (bits[y] == 0) continue;
    any |= bits[y];
    bounds.y0 = std::min(bounds.y0, y);
    bounds.y1 = y + 1;
  }
  if (any == 0) return {};
  bounds.x0 = std::countr_zero(any);
  bounds.x1 = 64 - std::countl_zero(any);
  return bounds;
}

// Pass "slices", of the part of the lattice that the samples within the sheet's bounds read.
inline void sum_slices(const LatticeFrame& frame, const Region& region, RowsOfSheet& sheet) {
  const SampleBounds& bounds = sheet.bounds;
  const int first_column = sheet.x.first[bounds.x0];
  const int columns = sheet.x.first[bounds.x1 - 1] + 4 - first_column;
  const int first_row = sheet.y.first[bounds.y0];
  const int rows = sheet.y.first[bounds.y1 - 1] + 4 - first_row;
  const std::ptrdiff_t row = 2 * static_cast<std::ptrdiff_t>(region.row_stride);
  const std::ptrdiff_t two_slices = 4 * static_cast<std::ptrdiff_t>(region.slice_stride);
  const float* from = region.samples +
                      2 * static_cast<std::ptrdiff_t>(sheet.z.first[0]) * region.slice_stride +
                      row * first_row + 2 * first_column;
  V w[4], s[4];
  for (int k = 0; k < 4; ++k) {
    w[k] = hn::Set(d, sheet.z.weight[k][0]);
    s[k] = hn::Set(d, sheet.z.slope[k][0]);
  }
  for (int y = 0; y < rows; ++y, from += row) {
    for (int x = 0; x < columns; x += group_size()) {
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
      hn::StoreU(sum(w), d, sheet.value[y] + x);
      if (frame.takes_gradients) hn::StoreU(sum(s), d, sheet.slope[y] + x);
    }
  }
  sheet.multiply_adds = std::int64_t{4} * (frame.takes_gradients ? 2 : 1) * rows * columns;
  // Counted from the first; columns beside those within bounds read the ends.
  sheet.columns = columns;
  for (int x = 0; x < kTileSize; ++x)
    sheet.x.first[x] = std::clamp(sheet.x.first[x] - first_column, 0, columns - 4);
  for (int y = bounds.y0; y < bounds.y1; ++y) sheet.y.first[y] -= first_row;
}

// Pass "rows", of sample row y.
template <bool kGradient>
HWY_INLINE void sum_rows(const RowsOfSheet& sheet, int y, RowOfLattice& out) {
  const int first = sheet.y.first[y];
  V w[4], s[4];
  for (int k = 0; k < 4; ++k) {
    w[k] = hn::Set(d, sheet.y.weight[k][y]);
    if constexpr (kGradient) s[k] = hn::Set(d, sheet.y.slope[k][y]);
  }
  for (int x = 0; x < sheet.columns; x += group_size()) {
    const auto sum = [&](const float(&rows)[kMostAcross][kRowFloats], const V(&c)[4]) {
      const auto at = [&](int k) { return hn::LoadU(d, rows[first + k] + x); };
      return hn::MulAdd(at(0), c[0],
                        hn::MulAdd(at(1), c[1], hn::MulAdd(at(2), c[2], hn::Mul(at(3), c[3]))));
    };
    hn::StoreU(sum(sheet.value, w), d, out.value + x);
    if constexpr (kGradient) {
      hn::StoreU(sum(sheet.value, s), d, out.slope_y + x);
      hn::StoreU(sum(sheet.slope, w), d, out.slope_z + x);
    }
  }
}

// Pass "columns", of the samples of row y named by `lanes`, which are marked in `out`.
template <bool kGradient>
HWY_INLINE void sum_columns(const LatticeFrame& frame, const RowsOfSheet& sheet,
                            const RowOfLattice& row, const TapPicker& pick,
                            const SampleGroup& group, Sheet& out) {
  const int x = group.column;
  const int y = group.row;
  const int at = out.at(x, y);
  // Neighbours may have their values already.
  const M mask = mask_of(group.lanes);
  const FourTaps values = pick(row.value);
  hn::BlendedStore(sum_of_taps(values, sheet.x.weight, x), mask, d, out.values + at);
  const V share_yz = hn::Set(d, sheet.y.share[y] * sheet.z.share[0]);
  const M is_whole =
      hn::Ge(hn::Mul(hn::Load(d, sheet.x.share + x), share_yz), hn::Set(d, device::kLeastShare));
  out.defined[y] |= RowWord{bits_of(is_whole) & group.lanes} << x;
  if constexpr (kGradient) {
    const WorldVector slope = to_world(frame, sum_of_taps(values, sheet.x.slope, x),
                                       sum_of_taps(pick(row.slope_y), sheet.x.weight, x),
                                       sum_of_taps(pick(row.slope_z), sheet.x.weight, x));
    hn::BlendedStore(slope.x, mask, d, out.gradient[0] + at);
    hn::BlendedStore(slope.y, mask, d, out.gradient[1] + at);
    hn::BlendedStore(slope.z, mask, d, out.gradient[2] + at);
    out.has_gradient[y] |= RowWord{group.lanes} << x;
  }
}

// True if the block's samples can be worked out like this.
inline bool has_rows(const LatticeFrame& frame, const Block& block) {
  return frame.has_rows && block.region.uses_four_taps;
}

// Samples of a sheet whose slices are summed.
inline void add_rows(const LatticeFrame& frame, Workspace& work, int s, const RowBits& wanted,
                     const RowBits& with_gradient) {
  const std::int64_t number = work.block.place.number_of(s);
  const RowsOfSheet& rows = work.rows[static_cast<std::size_t>(number & 1)];
  const SampleBounds& bounds = rows.bounds;
  if (bounds.is_empty()) return;
  Sheet& sheet = work.ring[number];
  TapPicker pickers[kTileSize];
  const int first_group = bounds.x0 / group_size();
  for (int g = first_group; g * group_size() < bounds.x1; ++g)
    pickers[g] = TapPicker(rows.x.first + g * group_size());
  RowOfLattice row;
  constexpr int kTaps = 4;
  for (int y = bounds.y0; y < bounds.y1; ++y) {
    if (wanted[y] == 0) continue;
    work.stats.multiply_adds += kTaps * (with_gradient[y] != 0 ? 3 : 1) * rows.columns;
    with_gradient[y] != 0 ? sum_rows<true>(rows, y, row) : sum_rows<false>(rows, y, row);
    for (int g = first_group; g * group_size() < bounds.x1; ++g) {
      const int x = g * group_size();
      const SampleGroup group{s, x, y, lanes_at(wanted[y], x)};
      if (group.lanes == 0) continue;
      if (lanes_at(with_gradient[y], x) != 0) {
        sum_columns<true>(frame, rows, row, pickers[g], group, sheet);
        work.stats.gradients += std::popcount(group.lanes);
        work.stats.multiply_adds += 4 * kTaps * std::popcount(group.lanes);
      } else {
        work.stats.multiply_adds += kTaps * std::popcount(group.lanes);
        sum_columns<false>(frame, rows, row, pickers[g], group, sheet);
      }
    }
  }
}

// The samples named by `wanted` of sheet s of the block; with gradients in groups that have one
// named by `guess`, too.
inline void reconstruct_rows(const LatticeFrame& frame, Workspace& work, int s,
                             const RowBits& wanted, const RowBits& guess) {
  const Block& block = work.block;
  RowsOfSheet& rows = work.rows[static_cast<std::size_t>(block.place.number_of(s) & 1)];
  rows.bounds = bounds_of(wanted, block.place.rows);
  if (rows.bounds.is_empty()) return;
  set_taps(frame, block, s, rows);
  sum_slices(frame, block.region, rows);
  work.stats.multiply_adds += rows.multiply_adds;
  add_rows(frame, work, s, wanted, guess);
}

// Gradients of samples named by `missing`, which have values.
inline void gradients_by_rows(const LatticeFrame& frame, Workspace& work, int s,
                              const RowBits& missing) {
  add_rows(frame, work, s, missing, missing);
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
