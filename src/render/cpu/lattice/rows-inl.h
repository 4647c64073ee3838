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
// In:  a block of lattice sheets whose samples read four taps an axis.
// Out: values, and where asked gradients, of the samples named, and which of them are defined.
#if defined(OVOID_RENDER_CPU_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_ROWS_INL_H_
#undef OVOID_RENDER_CPU_ROWS_INL_H_
#else
#define OVOID_RENDER_CPU_ROWS_INL_H_
#endif

#include "render/cpu/lattice/gather-inl.h"

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

// Four taps of a group of samples.
struct FourTaps {
  V tap[4];
};

// Of a row: `first` holds tap 0 of the group's samples, ascending. Tap k of a group lies among the
// lattice's samples from tap k of its first sample on: one group of them where samples are no
// farther apart than a spacing, else two.
static_assert(view::kMostSpacings <= 2);
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
  TapPicker() = default;
  HWY_INLINE explicit TapPicker(const std::int32_t* first)
      : base(first[0]),
        lane(hn::Sub(hn::Load(di, first), hn::Set(di, first[0]))),
        fits_one(first[group_size() - 1] - first[0] < group_size()) {}

  HWY_INLINE FourTaps operator()(const float* row) const {
    row += base;
    const auto index = hn::IndicesFromVec(d, hn::And(lane, hn::Set(di, group_size() - 1)));
    FourTaps taps;
    for (int k = 0; k < 4; ++k) taps.tap[k] = hn::TableLookupLanes(hn::LoadU(d, row + k), index);
    if (fits_one) return taps;
    const M is_near = hn::RebindMask(d, hn::Lt(lane, hn::Set(di, group_size())));
    for (int k = 0; k < 4; ++k) {
      const V far = hn::TableLookupLanes(hn::LoadU(d, row + k + group_size()), index);
      taps.tap[k] = hn::IfThenElse(is_near, taps.tap[k], far);
    }
    return taps;
  }

  int base;
  VI lane;
  bool fits_one;
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

// Four taps of a group of the lattice's samples, one of each slice.
template <bool kIsPaired>
HWY_INLINE FourTaps slice_taps(const float* from, std::ptrdiff_t slice) {
#if HWY_TARGET != HWY_SCALAR
  if constexpr (kIsPaired) {
    FourTaps taps;
    hn::LoadInterleaved2(d, from, taps.tap[0], taps.tap[1]);
    hn::LoadInterleaved2(d, from + 2 * slice, taps.tap[2], taps.tap[3]);
    return taps;
  }
#else
  if constexpr (kIsPaired) {
    return {{hn::Load(d, from), hn::Load(d, from + 1), hn::Load(d, from + 2 * slice),
             hn::Load(d, from + 2 * slice + 1)}};
  }
#endif
  return {{hn::LoadU(d, from), hn::LoadU(d, from + slice), hn::LoadU(d, from + 2 * slice),
           hn::LoadU(d, from + 3 * slice)}};
}

HWY_INLINE V weighted_sum(const FourTaps& taps, const V (&w)[4]) {
  return hn::MulAdd(
      taps.tap[0], w[0],
      hn::MulAdd(taps.tap[1], w[1], hn::MulAdd(taps.tap[2], w[2], hn::Mul(taps.tap[3], w[3]))));
}

// The slices of `rows` rows of sheet.columns samples, `from` the first of them.
template <bool kIsPaired>
inline void sum_slices_from(const float* from, const Region& region, int rows, bool has_slopes,
                            RowsOfSheet& sheet) {
  constexpr std::ptrdiff_t kFloats = kIsPaired ? 2 : 1;
  const std::ptrdiff_t slice = kFloats * region.slice_stride;
  V w[4], s[4];
  for (int k = 0; k < 4; ++k) {
    w[k] = hn::Set(d, sheet.z.weight[k][0]);
    s[k] = hn::Set(d, sheet.z.slope[k][0]);
  }
  for (int y = 0; y < rows; ++y, from += kFloats * region.row_stride) {
    for (int x = 0; x < sheet.columns; x += group_size()) {
      const FourTaps taps = slice_taps<kIsPaired>(from + kFloats * x, slice);
      const int to = y * sheet.row_stride + x;
      hn::StoreU(weighted_sum(taps, w), d, sheet.value + to);
      if (has_slopes) hn::StoreU(weighted_sum(taps, s), d, sheet.slope + to);
    }
  }
}

// Pass "slices", of the part of the lattice that the samples within the sheet's bounds read.
inline void sum_slices(const LatticeFrame& frame, const Region& region, RowsOfSheet& sheet) {
  const SampleBounds& bounds = sheet.bounds;
  const int first_column = sheet.x.first[bounds.x0];
  const int columns = sheet.x.first[bounds.x1 - 1] + 4 - first_column;
  const int first_row = sheet.y.first[bounds.y0];
  const int rows = sheet.y.first[bounds.y1 - 1] + 4 - first_row;
  // Counted from the first; columns beside those within bounds read the ends.
  sheet.columns = columns;
  for (int x = 0; x < kTileSize; ++x)
    sheet.x.first[x] = std::clamp(sheet.x.first[x] - first_column, 0, columns - 4);
  for (int y = bounds.y0; y < bounds.y1; ++y) sheet.y.first[y] -= first_row;
  sheet.row_stride = (columns + group_size() - 1) / group_size() * group_size();
  const std::ptrdiff_t floats = region.is_paired ? 2 : 1;
  const float* const from =
      region.samples +
      floats * (static_cast<std::ptrdiff_t>(sheet.z.first[0]) * region.slice_stride +
                static_cast<std::ptrdiff_t>(region.row_stride) * first_row + first_column);
  region.is_paired ? sum_slices_from<true>(from, region, rows, frame.takes_gradients, sheet)
                   : sum_slices_from<false>(from, region, rows, frame.takes_gradients, sheet);
  sheet.multiply_adds = std::int64_t{4} * (frame.takes_gradients ? 2 : 1) * rows * columns;
}

// Pass "rows", of sample row y: `floats` of a sheet, weighted along y.
HWY_INLINE void sum_row(const RowsOfSheet& sheet, const float* floats,
                        const float (&weights)[4][kTileSize], int y, float* out) {
  V w[4];
  for (int k = 0; k < 4; ++k) w[k] = hn::Set(d, weights[k][y]);
  const std::ptrdiff_t stride = sheet.row_stride;
  floats += sheet.y.first[y] * stride;
  for (int x = 0; x < sheet.columns; x += group_size()) {
    const auto at = [&](int k) { return hn::LoadU(d, floats + k * stride + x); };
    hn::StoreU(weighted_sum({{at(0), at(1), at(2), at(3)}}, w), d, out + x);
  }
}

// Of all rows of a sheet that are named by `bits`. Row after row, before any column is summed: its
// taps straddle what has just been stored, which the processor would have to wait for.
inline void sum_row_values(RowsOfSheet& sheet, const RowBits& bits) {
  for (int y = sheet.bounds.y0; y < sheet.bounds.y1; ++y) {
    if (bits[y] != 0) sum_row(sheet, sheet.value, sheet.y.weight, y, sheet.rows[y].value);
  }
}

inline void sum_row_slopes(RowsOfSheet& sheet, const RowBits& bits) {
  for (int y = sheet.bounds.y0; y < sheet.bounds.y1; ++y) {
    if (bits[y] == 0) continue;
    sum_row(sheet, sheet.value, sheet.y.slope, y, sheet.rows[y].slope_y);
    sum_row(sheet, sheet.slope, sheet.y.weight, y, sheet.rows[y].slope_z);
  }
}

// Pass "columns", of the group of samples from x on.
HWY_INLINE V sum_columns(const RowsOfSheet& sheet, const RowOfLattice& row, const TapPicker& pick,
                         int x) {
  return sum_of_taps(pick(row.value), sheet.x.weight, x);
}

// Their gradients.
HWY_INLINE WorldVector sum_column_slopes(const LatticeFrame& frame, const RowsOfSheet& sheet,
                                         const RowOfLattice& row, const TapPicker& pick, int x) {
  return to_world(frame, sum_of_taps(pick(row.value), sheet.x.slope, x),
                  sum_of_taps(pick(row.slope_y), sheet.x.weight, x),
                  sum_of_taps(pick(row.slope_z), sheet.x.weight, x));
}

// The samples of a group of which enough kernels exist.
HWY_INLINE M has_enough_kernels(const RowsOfSheet& sheet, int x, int y) {
  const V share_yz = hn::Set(d, sheet.y.share[y] * sheet.z.share[0]);
  return hn::Ge(hn::Mul(hn::Load(d, sheet.x.share + x), share_yz), hn::Set(d, device::kLeastShare));
}

// True if the block's samples can be worked out like this.
inline bool has_rows(const LatticeFrame& frame, const Block& block) {
  return frame.has_rows && block.region.uses_four_taps;
}

// The taps of all groups of a sheet's columns.
class SheetPickers {
 public:
  explicit SheetPickers(const RowsOfSheet& sheet) {
    for (int x = 0; x < sheet.bounds.x1; x += group_size())
      pickers_[x / group_size()] = TapPicker(sheet.x.first + x);
  }
  const TapPicker& at(int x) const { return pickers_[x / group_size()]; }

 private:
  TapPicker pickers_[kTileSize];
};

// The samples named by `wanted` of sheet s of the block.
inline void reconstruct_rows(const LatticeFrame& frame, Workspace& work, int s,
                             const RowBits& wanted) {
  const Block& block = work.block;
  const std::int64_t number = block.place.number_of(s);
  RowsOfSheet& rows = work.rows[static_cast<std::size_t>(number & 1)];
  rows.bounds = bounds_of(wanted, block.place.rows);
  if (rows.bounds.is_empty()) return;
  set_taps(frame, block, s, rows);
  sum_slices(frame, block.region, rows);
  sum_row_values(rows, wanted);
  std::int64_t num_rows = 0;
  std::int64_t num_groups = 0;
  Sheet& sheet = work.ring[number];
  const SheetPickers pickers(rows);
  for (int y = rows.bounds.y0; y < rows.bounds.y1; ++y) {
    if (wanted[y] == 0) continue;
    ++num_rows;
    for_each_group(wanted[y], 0, kTileSize, [&](int x, std::uint32_t lanes) {
      ++num_groups;
      hn::StoreU(sum_columns(rows, rows.rows[y], pickers.at(x), x), d,
                 sheet.values + sheet.at(x, y));
      if (!block.region.is_interior) lanes &= bits_of(has_enough_kernels(rows, x, y));
      sheet.defined[y] |= RowWord{lanes} << x;
    });
  }
  constexpr int kTaps = 4;
  work.stats.multiply_adds +=
      rows.multiply_adds + kTaps * (num_rows * rows.columns + num_groups * group_size());
}

// Gradients of the groups that have one of the samples named by `missing`, which have values.
inline void gradients_by_rows(const LatticeFrame& frame, Workspace& work, int s,
                              const RowBits& missing) {
  const BlockPlace& place = work.block.place;
  const std::int64_t number = place.number_of(s);
  RowsOfSheet& rows = work.rows[static_cast<std::size_t>(number & 1)];
  sum_row_slopes(rows, missing);
  std::int64_t num_rows = 0;
  std::int64_t num_groups = 0;
  Sheet& sheet = work.ring[number];
  const SheetPickers pickers(rows);
  for (int y = 0; y < place.rows; ++y) {
    if (missing[y] == 0) continue;
    ++num_rows;
    for_each_group(missing[y], 0, kTileSize, [&](int x, std::uint32_t) {
      ++num_groups;
      const WorldVector slope = sum_column_slopes(frame, rows, rows.rows[y], pickers.at(x), x);
      const int at = sheet.at(x, y);
      hn::StoreU(slope.x, d, sheet.gradient[0] + at);
      hn::StoreU(slope.y, d, sheet.gradient[1] + at);
      hn::StoreU(slope.z, d, sheet.gradient[2] + at);
      sheet.has_gradient[y] |= RowWord{group_bits()} << x;
    });
  }
  constexpr int kTaps = 4;
  work.stats.gradients += num_groups * group_size();
  work.stats.multiply_adds += kTaps * (2 * num_rows * rows.columns + 3 * num_groups * group_size());
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
