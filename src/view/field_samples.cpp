// SPDX-License-Identifier: Apache-2.0
#include "view/field_samples.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <optional>

#include "data/out_of_memory.h"
#include "data/some_kernels.h"

namespace ovoid::view {

FieldSamples take_samples(const KernelField& field) try {
  constexpr std::int64_t kWantedSums = 4096;
  const KernelSource& source = field.source();
  const bool is_sum = field.reconstruction() == Reconstruction::kSum;
  std::optional<KernelSampler> sampler;
  if (is_sum) sampler.emplace(field);
  FieldSamples samples;
  data::for_some_kernels(
      source, is_sum ? kWantedSums : data::kWantedSamples,
      [&](const KernelBrick& brick, const KernelView& view, std::int32_t i) {
        const Vec3 offset(view.center[0][i], view.center[1][i], view.center[2][i]);
        samples.values.push_back(is_sum
                                     ? static_cast<float>(sampler->at(brick.origin + offset).value)
                                     : view.value[static_cast<std::size_t>(field.attribute())][i]);
      });
  std::sort(samples.values.begin(), samples.values.end());
  return samples;
} catch (const std::bad_alloc&) {
  data::throw_out_of_memory("samples of the field, to choose a look",
                            data::kWantedSamples * sizeof(float));
}

double quantile(std::span<const float> sorted, double q) {
  const double place = std::clamp(q, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(static_cast<double>(sorted[below]), static_cast<double>(sorted[above]),
                   place - static_cast<double>(below));
}

}  // namespace ovoid::view
