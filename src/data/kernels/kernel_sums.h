// SPDX-License-Identifier: Apache-2.0
// Sums at some of their kernels' centres.
#pragma once

#include <cstdint>
#include <vector>

#include "ovoid/kernel_field.h"

namespace ovoid::data {

// A part of the places where something is wanted, in the order of the kernels' bricks.
struct PartOfPlaces {
  int number = 0;
  int count = 1;  // parts

  template <class T>
  std::vector<T> of(const std::vector<T>& places) const {
    const auto end_of = [&](int parts) {
      return places.begin() +
             static_cast<std::ptrdiff_t>(places.size() * static_cast<std::size_t>(parts) /
                                         static_cast<std::size_t>(count));
    };
    return {end_of(number), end_of(number + 1)};
  }
};

// Every how many-th kernel some thousands of sums are taken at.
std::int64_t stride_of_sums(std::int64_t num_kernels);

// How many kernels that is.
std::int64_t count_of_every(std::int64_t num_kernels, std::int64_t stride);

// The values of KernelSums, or a part of them. Cost: in proportion to the kernels near the centres.
// Throws what the source throws.
std::vector<float> sums_at_kernels(const KernelField& field, std::int64_t stride,
                                   const PartOfPlaces& part = {});

}  // namespace ovoid::data
