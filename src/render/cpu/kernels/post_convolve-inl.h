// SPDX-License-Identifier: Apache-2.0
// Stage "post-convolve": a plane of coarse samples becomes one of finer samples, by a separable
// filter: from a kernel set's level to the next finer one, from a lattice's nodes to pixels.
//
// Along the rows of coarse samples first, as a product with the band matrix, of which a vector of
// outputs takes the few rows that it has weights in: no shuffling, at any ratio of the two
// samplings; then down the columns of finer samples, six taps each.
#if defined(OVOID_RENDER_CPU_POST_CONVOLVE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_POST_CONVOLVE_INL_H_
#undef OVOID_RENDER_CPU_POST_CONVOLVE_INL_H_
#else
#define OVOID_RENDER_CPU_POST_CONVOLVE_INL_H_
#endif

#include <algorithm>

#include "render/cpu/kernels/filter_band.h"
#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// kRows rows of coarse samples share the loads of the weights.
template <int kRows, class Band>
HWY_INLINE void filter_rows(const float* coarse, std::ptrdiff_t stride, const Band& band,
                            int num_outputs, float (*rows)[Band::kOutputs]) {
  for (int c = 0; c < num_outputs; c += group_size()) {
    const auto& front = band.of_eight[static_cast<std::size_t>(c / 8)];
    const auto& back = band.of_eight[static_cast<std::size_t>((c + group_size() - 1) / 8)];
    const int first = front.first;
    const int past = std::max(front.past, back.past);  // outputs at the back may not be set
    V sums[kRows];
    for (V& sum : sums) sum = hn::Zero(d);
    for (int k = first; k < past; ++k) {
      const V weight = hn::Load(d, band.weight[k] + c);
      for (int r = 0; r < kRows; ++r)
        sums[r] = hn::MulAdd(hn::Set(d, coarse[r * stride + k]), weight, sums[r]);
    }
    for (int r = 0; r < kRows; ++r) hn::Store(sums[r], d, rows[r] + c);
  }
}

// Samples of a plane, row by row.
struct CoarsePlane {
  const float* samples;
  std::ptrdiff_t stride;
};
struct FinePlane {
  float* samples;
  std::ptrdiff_t stride;
};

// What of the finer plane is wanted: rows [first, last], so many columns.
struct FineRows {
  int first, last;
  int num_columns;
};

// Whole groups are written. kAdds: to what is there, and what lies behind the columns stays as it
// is.
template <bool kAdds, class Band>
inline void post_convolve(CoarsePlane coarse, const Band& x, const Band& y, FineRows wanted,
                          FinePlane fine) {
  const auto [first, last, num_columns] = wanted;
  alignas(64) float rows[Band::kInputs][Band::kOutputs];
  const int first_tap = y.taps[static_cast<std::size_t>(first)];
  const int num_rows = y.taps[static_cast<std::size_t>(last)] + kFilterTaps - first_tap;
  const float* from = coarse.samples + first_tap * coarse.stride + x.first_input;
  int row = 0;
  for (; row + 4 <= num_rows; row += 4)
    filter_rows<4>(from + row * coarse.stride, coarse.stride, x, num_columns, rows + row);
  for (; row < num_rows; ++row)
    filter_rows<1>(from + row * coarse.stride, coarse.stride, x, num_columns, rows + row);
  for (int out = first; out <= last; ++out) {
    const int tap = y.taps[static_cast<std::size_t>(out)];
    const float(*six)[Band::kOutputs] = rows + (tap - first_tap);
    V weight[kFilterTaps];
    for (int k = 0; k < kFilterTaps; ++k)
      weight[k] = hn::Set(d, y.weight[tap - y.first_input + k][out]);
    float* to = fine.samples + out * fine.stride;
    for (int c = 0; c < num_columns; c += group_size()) {
      V sum = hn::Mul(weight[0], hn::Load(d, six[0] + c));
      for (int k = 1; k < kFilterTaps; ++k)
        sum = hn::MulAdd(weight[k], hn::Load(d, six[k] + c), sum);
      // Columns behind the last have no weights: nothing is added there.
      if constexpr (kAdds) sum = hn::Add(sum, hn::LoadU(d, to + c));
      hn::StoreU(sum, d, to + c);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
