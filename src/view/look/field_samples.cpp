// SPDX-License-Identifier: Apache-2.0
#include "view/look/field_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <numeric>
#include <vector>

#include "data/kernels/kernel_shape.h"
#include "data/out_of_memory.h"

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
  const KernelShape shape = field.source().shape();
  FieldSamples samples;
  std::vector<float> weights;
  if (field.sums() != nullptr) {
    samples.values = field.sums()->values;
  } else {
    for_values_at_kernels(
        field, data::kWantedSamples,
        [&](const KernelBrick& /*brick*/, const KernelView& view, std::int32_t i, float value) {
          const std::array<float, 6> numbers = data::shape_numbers(view, shape, i);
          samples.values.push_back(value);
          weights.push_back(static_cast<float>(
              std::sqrt(std::abs(data::factor_of(shape, numbers.data()).determinant()))));
        });
    samples.values = repeated(samples.values, weights);
  }
  std::sort(samples.values.begin(), samples.values.end());
  return samples;
} catch (const std::bad_alloc&) {
  data::throw_out_of_memory("samples of the field, to choose a look",
                            data::kWantedSamples * sizeof(float));
}

}  // namespace ovoid::view
