// SPDX-License-Identifier: Apache-2.0
#include "data/kernels/kernel_sums.h"

#include <algorithm>

#include "data/kernels/kernel_shape.h"
#include "data/kernels/some_kernels.h"

namespace ovoid::data {

std::int64_t stride_of_sums(std::int64_t num_kernels) {
  constexpr std::int64_t kMostLookedAt = 1 << 16, kMostSums = 8192;
  return stride_for(num_kernels, kMostLookedAt) *
         stride_for(std::min(num_kernels, kMostLookedAt), kMostSums);
}

std::int64_t count_of_every(std::int64_t num_kernels, std::int64_t stride) {
  return (num_kernels + stride - 1) / stride;
}

std::vector<float> sums_at_kernels(const KernelField& field, std::int64_t stride,
                                   const PartOfPlaces& part) {
  const KernelSource& source = field.source();
  std::vector<Vec3> places;
  places.reserve(static_cast<std::size_t>(count_of_every(source.num_kernels(), stride)));
  for_every_kernel(source, stride,
                   [&](const KernelBrick& brick, const KernelView& view, std::int32_t i) {
                     places.push_back(brick.origin + offset_of(view, i));
                   });
  const KernelSampler sampler(field);
  std::vector<float> sums;
  for (const Vec3& place : part.of(places))
    sums.push_back(static_cast<float>(sampler.at(place).value));
  return sums;
}

}  // namespace ovoid::data
