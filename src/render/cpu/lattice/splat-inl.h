// SPDX-License-Identifier: Apache-2.0
// Stage "reconstruct" by scattering: each kernel of the region adds itself to the samples it
// covers, sheet by sheet; the method as it was published. The sums are the gathered ones in another
// order.
//
// In:  the region, the sheets of the block.
// Out: per sheet two planes, numerator and denominator; read_splat_sheet() divides them.
// On a sheet, index space is an affine function of the pixel; its inverse gives each kernel's
// rectangle of pixels at once, and the range of kernels along a row that meet the sheet. SIMD runs
// along the pixels of a row. Work is in proportion to kernels met x their footprint, so this wins
// where samples are sparse among kernels or most kernels are zero (`sum`).
#if defined(OVOID_RENDER_CPU_SPLAT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_SPLAT_INL_H_
#undef OVOID_RENDER_CPU_SPLAT_INL_H_
#else
#define OVOID_RENDER_CPU_SPLAT_INL_H_
#endif

#include "render/cpu/lattice/general-inl.h"
#include "render/cpu/lattice/load-inl.h"
#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

inline constexpr std::size_t kPlaneFloats = kMaxPlaneRows * kPlaneStride + kTapPadding;

// What is summed on one sheet; sample (x, y) at y * kPlaneStride + x.
struct SplatSums {
  float* numerator;
  float* denominator;
};

inline SplatSums splat_sums(Workspace& work, int s) {
  float* const planes = work.splats.data.get() + 2 * kPlaneFloats * s;
  return {planes, planes + kPlaneFloats};
}

// A plane of samples as kernels see it: u(x, y) = base + x per_x + y per_y, and the inverse of
// (per_x, per_y, step).
struct SplatPlane {
  float base[3], per_x[3], per_y[3], step[3];
  float inverse[3][3];   // row 0: x, row 1: y, row 2: sheets, from an index-space offset
  float half_extent[3];  // of a kernel's support box in x, y, sheets
  float support[3];      // of the box, index space
  float exponent[3];     // of Gaussians: log2 of the kernel is the sum of exponent * offset^2
  float widening[3];
};

// At `offset` sheets from sheet s, for slab means.
inline SplatPlane make_splat_plane(const LatticeFrame& frame, const SheetInLattice& sheet,
                                   float offset) {
  SplatPlane plane;
  Eigen::Matrix3f columns;
  for (int a = 0; a < 3; ++a) {
    plane.base[a] = sheet.base[a] + offset * sheet.step[a];
    plane.per_x[a] = sheet.per_x[a] + offset * sheet.step_per_x[a];
    plane.per_y[a] = sheet.per_y[a] + offset * sheet.step_per_y[a];
    plane.step[a] = sheet.step[a];
    plane.support[a] = frame.lattice.support * sheet.widening[a];
    plane.exponent[a] = -0.5F * 1.44269504F * frame.lattice.inverse_variance /
                        (sheet.widening[a] * sheet.widening[a]);
    plane.widening[a] = sheet.widening[a];
    columns(a, 0) = plane.per_x[a];
    columns(a, 1) = plane.per_y[a];
    columns(a, 2) = plane.step[a];
  }
  const Eigen::Matrix3f inverse = columns.inverse();
  for (int r = 0; r < 3; ++r) {
    plane.half_extent[r] = 1e-3F;  // rounding slack; the support is tested sample by sample
    for (int a = 0; a < 3; ++a) {
      plane.inverse[r][a] = inverse(r, a);
      plane.half_extent[r] += std::abs(inverse(r, a)) * plane.support[a];
    }
  }
  return plane;
}

HWY_INLINE float product_with(const float* row, const float* v) {
  return row[0] * v[0] + row[1] * v[1] + row[2] * v[2];
}

// Samples [x0, x1] x [y0, y1] of a plane.
struct SampleBox {
  int x0, y0, x1, y1;
};

inline SampleBox box_of_bits(const RowBits& bits, int rows) {
  SampleBox box{0, rows, -1, -1};
  RowWord columns = 0;
  for (int y = 0; y < rows; ++y) {
    if (bits[y] == 0) continue;
    box.y0 = std::min(box.y0, y);
    box.y1 = y;
    columns |= bits[y];
  }
  if (columns == 0) return box;
  box.x0 = std::countr_zero(columns);
  box.x1 = 63 - std::countl_zero(columns);
  return box;
}

// A kernel at an index position.
struct PlacedKernel {
  const float* center;
  float value, weight;
};

// Adds one kernel to a plane's samples.
template <bool kPiecewise>
HWY_INLINE void splat_kernel(const LatticeFrame& frame, const SampleBox& box,
                             const SplatPlane& plane, const PlacedKernel& kernel,
                             const SplatSums& sums) {
  float* HWY_RESTRICT const numerator = sums.numerator;
  float* HWY_RESTRICT const denominator = sums.denominator;
  const float* const center = kernel.center;
  const float from_base[3] = {center[0] - plane.base[0], center[1] - plane.base[1],
                              center[2] - plane.base[2]};
  const float x = product_with(plane.inverse[0], from_base);
  const float y = product_with(plane.inverse[1], from_base);
  const int x0 = std::max(box.x0, static_cast<int>(std::ceil(x - plane.half_extent[0])));
  const int x1 = std::min(box.x1, static_cast<int>(std::floor(x + plane.half_extent[0])));
  const int y0 = std::max(box.y0, static_cast<int>(std::ceil(y - plane.half_extent[1])));
  const int y1 = std::min(box.y1, static_cast<int>(std::floor(y + plane.half_extent[1])));
  const V scaled_value = hn::Set(d, kernel.value * kernel.weight);
  const V scaled_one = hn::Set(d, kernel.weight);
  for (int row = y0; row <= y1; ++row) {
    for (int column = x0; column <= x1; column += group_size()) {
      const V px = hn::Iota(d, static_cast<float>(column));
      V log = hn::Zero(d);
      V product = hn::Set(d, 1.0F);
      M covered = hn::Lt(px, hn::Set(d, static_cast<float>(box.x1 + 1)));
      for (int a = 0; a < 3; ++a) {
        const V offset =
            hn::MulAdd(px, hn::Set(d, plane.per_x[a]),
                       hn::Set(d, static_cast<float>(row) * plane.per_y[a] - from_base[a]));
        covered = hn::And(covered, hn::Le(hn::Abs(offset), hn::Set(d, plane.support[a])));
        if constexpr (kPiecewise) {
          product = hn::Mul(product,
                            axis_weight(d, AxisKernel(frame.lattice, plane.widening[a]), offset));
        } else {
          log = hn::MulAdd(hn::Mul(offset, offset), hn::Set(d, plane.exponent[a]), log);
        }
      }
      const V all = kPiecewise ? product : vector_exp2(d, hn::Max(log, hn::Set(d, -126.0F)));
      const V phi = hn::IfThenElseZero(covered, all);
      const int at = row * kPlaneStride + column;
      hn::StoreU(hn::MulAdd(phi, scaled_value, hn::LoadU(d, numerator + at)), d, numerator + at);
      // Of `sum` no more than whether a kernel reaches: negative weights count, too.
      const V share = kPiecewise && frame.is_sum ? hn::Abs(phi) : phi;
      hn::StoreU(hn::MulAdd(share, scaled_one, hn::LoadU(d, denominator + at)), d,
                 denominator + at);
    }
  }
}

// The kernels of one sublattice's region, as far as it goes, that reach a plane.
template <class Visit>
inline void for_each_kernel_of(const device::Sublattice& sublattice, const Region& region,
                               std::ptrdiff_t from, const SplatPlane& plane, const Visit& visit) {
  const float* samples = region.samples + from;
  const float* presence = region.has_missing ? region.presence + from : nullptr;
  const auto [lo, hi] = part_in_lattice(region, sublattice, view::kOwnOrder);
  const int last_in_row = static_cast<int>(hi[0] - lo[0]) - 1;
  const float slope = plane.inverse[2][0];
  const bool is_steep = std::abs(slope) > 1e-6F;
  const float kernels_per_sheet = is_steep ? 1 / slope : 0.0F;
  const float half_width = std::abs(plane.half_extent[2] * kernels_per_sheet);
  for (std::int64_t z = lo[2]; z < hi[2]; ++z) {
    for (std::int64_t y = lo[1]; y < hi[1]; ++y) {
      float center[3] = {static_cast<float>(lo[0] - region.origin[0]) + sublattice.offset,
                         static_cast<float>(y - region.origin[1]) + sublattice.offset,
                         static_cast<float>(z - region.origin[2]) + sublattice.offset};
      // Kernels of the row that meet the sheet: |sheet + i * slope| <= half extent.
      const float from_base[3] = {center[0] - plane.base[0], center[1] - plane.base[1],
                                  center[2] - plane.base[2]};
      const float sheet = product_with(plane.inverse[2], from_base);
      int first = 0;
      int last = last_in_row;
      if (is_steep) {
        const float middle = -sheet * kernels_per_sheet;
        const float lowest = middle - half_width;
        const float highest = middle + half_width;
        if (highest < 0 || lowest > static_cast<float>(last_in_row)) continue;
        if (lowest > 0) first = static_cast<int>(std::ceil(lowest));
        if (highest < static_cast<float>(last_in_row)) last = static_cast<int>(highest);
      } else if (std::abs(sheet) > plane.half_extent[2]) {
        continue;
      }
      const std::ptrdiff_t row = (z - region.origin[2] - region.lo[2]) * region.slice_stride +
                                 (y - region.origin[1] - region.lo[1]) * region.row_stride +
                                 (lo[0] - region.origin[0] - region.lo[0]);
      const float x0 = center[0];
      for (int i = first; i <= last; ++i) {
        if (presence != nullptr && presence[row + i] == 0.0F) continue;
        center[0] = x0 + static_cast<float>(i);
        visit(center, samples[row + i]);
      }
    }
  }
}

// The kernels of the region, as far as the lattice goes, that reach a plane: visit(center, value).
template <class Visit>
inline void for_each_kernel(const LatticeFrame& frame, const Region& region,
                            const SplatPlane& plane, const Visit& visit) {
  for (int s = 0; s < frame.lattice.num_sublattices; ++s)
    for_each_kernel_of(frame.lattice.sublattices[s], region, s * region.sublattice_stride, plane,
                       visit);
}

// Room for the planes of all sheets of the block.
inline void reserve_splat_planes(Workspace& work) {
  work.splats.reserve(2 * kPlaneFloats * static_cast<std::size_t>(work.block.place.num_sheets));
}

inline void clear_splat_planes(const SplatSums& sums) {
  std::fill_n(sums.numerator, 2 * kPlaneFloats, 0.0F);
}

// All kernels of the region onto the wanted samples of a sheet.
inline void splat_sheet(const LatticeFrame& frame, Workspace& work, int s, const RowBits& wanted) {
  const Block& block = work.block;
  const SplatSums sums = splat_sums(work, s);
  clear_splat_planes(sums);
  const SampleBox box = box_of_bits(wanted, block.place.rows);
  if (box.x1 < 0) return;
  for (int point = 0; point < frame.lattice.num_slab_points; ++point) {
    const device::SlabPoint slab = frame.lattice.slab[point];
    const SplatPlane plane = make_splat_plane(frame, block.sheets[s], slab.offset);
    for_each_kernel(frame, block.region, plane, [&](const float* center, float value) {
      const PlacedKernel kernel{center, value, slab.weight};
      if (frame.is_piecewise) {
        splat_kernel<true>(frame, box, plane, kernel, sums);
      } else {
        splat_kernel<false>(frame, box, plane, kernel, sums);
      }
    });
  }
}

// The sum of all kernels of an endless lattice at a sample (its slab's mean).
inline float endless_sum(const LatticeFrame& frame, Workspace& work, const SheetInLattice& sheet,
                         int column, int row) {
  const int capacity = tap_capacity(frame, sheet);
  float* memory = work.taps.reserve(static_cast<std::size_t>(6) * capacity);
  float sum = 0;
  const float x = static_cast<float>(column);
  const float y = static_cast<float>(row);
  for (int point = 0; point < frame.lattice.num_slab_points; ++point) {
    float u[3];
    for (int a = 0; a < 3; ++a) {
      const float step = sheet.step[a] + x * sheet.step_per_x[a] + y * sheet.step_per_y[a];
      u[a] = sheet.base[a] + x * sheet.per_x[a] + y * sheet.per_y[a] +
             frame.lattice.slab[point].offset * step;
    }
    for (int s = 0; s < frame.lattice.num_sublattices; ++s) {
      const device::Sublattice& sublattice = frame.lattice.sublattices[s];
      float product = frame.lattice.slab[point].weight;
      for (int a = 0; a < 3; ++a) {
        AxisTaps taps;
        taps.weight = memory;
        taps.derivative = memory + capacity;
        fill_axis(frame.lattice, work.block.region, sublattice,
                  {a, u[a] - sublattice.offset, sheet.widening[a]}, taps);
        product *= taps.endless;
      }
      sum += product;
    }
  }
  return sum;
}

// Is a sample of `sum` defined, whose weights add up to e?
inline bool is_sum_defined(const LatticeFrame& frame, const Region& region,
                           const SheetInLattice& sheet, int column, int row, float e) {
  if (region.has_missing) return e > 0;
  const float x = static_cast<float>(column);
  const float y = static_cast<float>(row);
  float u[3];
  float step[3];
  for (int a = 0; a < 3; ++a) {
    u[a] = sheet.base[a] + x * sheet.per_x[a] + y * sheet.per_y[a];
    step[a] = sheet.step[a] + x * sheet.step_per_x[a] + y * sheet.step_per_y[a];
  }
  return meets_support(frame, region, sheet, u, step);
}

// The quotients of what was splatted.
inline void read_splat_sheet(const LatticeFrame& frame, Workspace& work, int s,
                             const RowBits& wanted) {
  const Block& block = work.block;
  const Region& region = block.region;
  const SheetInLattice& in_lattice = block.sheets[s];
  const float* const w = in_lattice.widening;
  const float mass = w[0] * w[1] * w[2];
  const SplatSums sums = splat_sums(work, s);
  Sheet& sheet = work.ring[block.place.number_of(s)];
  for (int y = 0; y < block.place.rows; ++y) {
    sheet.defined[y] = 0;
    for (RowWord bits = wanted[y]; bits != 0; bits &= bits - 1) {
      const int x = std::countr_zero(bits);
      const float n = sums.numerator[y * kPlaneStride + x];
      const float e = sums.denominator[y * kPlaneStride + x];
      if (frame.is_sum) {
        if (!is_sum_defined(frame, region, in_lattice, x, y, e)) continue;
        sheet.values[sheet.at(x, y)] = frame.lattice.sum_weight / mass * n;
      } else {
        if (!(e > 0)) continue;
        const bool is_whole = region.is_interior && !region.has_missing;
        if (!is_whole && !(e >= device::kLeastShare * endless_sum(frame, work, in_lattice, x, y)))
          continue;
        sheet.values[sheet.at(x, y)] = n / e;
      }
      sheet.defined[y] |= RowWord{1} << x;
    }
  }
}

// Scatter if asked to. Left to itself, gather: it reads each tap once for a sample that is needed,
// scatter pays for samples that are not.
inline bool should_scatter(const LatticeFrame& frame) {
  return frame.options->evaluate == Evaluate::kScatter;
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
