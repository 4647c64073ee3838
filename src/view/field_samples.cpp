// SPDX-License-Identifier: Apache-2.0
#include "view/field_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <numeric>
#include <vector>

#include "data/kernel_shape.h"
#include "data/out_of_memory.h"
#include "data/some_kernels.h"

namespace ovoid::view {

namespace {

// As many values, each as often as its weight says, the mean one once.
std::vector<float> repeated(const std::vector<float>& values, const std::vector<float>& weights) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (!(sum > 0) || !std::isfinite(sum)) return values;
  const double per_weight = static_cast<double>(values.size()) / sum;
  std::vector<float> out;
  out.reserve(values.size());
  double due = 0.5;
  for (std::size_t i = 0; i < values.size(); ++i) {
    due += weights[i] * per_weight;
    for (; due >= 1; --due) out.push_back(values[i]);
  }
  return out.empty() ? values : out;
}

}  // namespace

FieldSamples take_samples(const KernelField& field) try {
  constexpr std::int64_t kWantedSums = 4096;
  const KernelSource& source = field.source();
  const bool is_sum = field.reconstruction() == Reconstruction::kSum;
  ValuesAtKernels values(field);
  FieldSamples samples;
  std::vector<float> weights;
  data::for_some_kernels(
      source, is_sum ? kWantedSums : data::kWantedSamples,
      [&](const KernelBrick& brick, const KernelView& view, std::int32_t i) {
        samples.values.push_back(static_cast<float>(values.at(brick, view, i)));
        if (is_sum) return;
        const std::array<float, 6> shape = data::shape_numbers(view, source.shape(), i);
        const double volume = data::factor_of(source.shape(), shape.data()).determinant();
        weights.push_back(static_cast<float>(std::sqrt(std::abs(volume))));
      });
  if (!is_sum) samples.values = repeated(samples.values, weights);
  std::sort(samples.values.begin(), samples.values.end());
  return samples;
} catch (const std::bad_alloc&) {
  data::throw_out_of_memory("samples of the field, to choose a look",
                            data::kWantedSamples * sizeof(float));
}

}  // namespace ovoid::view
