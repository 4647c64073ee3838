// SPDX-License-Identifier: Apache-2.0
// Weighted sums over the steps of a series, array by array.
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/series.h"
#include "ovoid/slices.h"

namespace ovoid::model {

using Floats = std::shared_ptr<float[]>;
Floats new_floats(std::int64_t count);  // not set

// An array of values with the name and unit of another one.
DataArray float_array(const DataArray& like, const Floats& values, std::int64_t num_tuples);

// The array of a step that is what `like` is in another. Throws Error(kFileFormat).
const DataArray& same_array(const Dataset& dataset, const DataArray& like);

struct HeldStep {
  std::shared_ptr<const Dataset> dataset;
  double weight;
};
std::vector<HeldStep> hold(const Series& series, const std::vector<StepWeight>& weights,
                           std::stop_token stop);

// Where a sum goes: rows of `row` numbers, every one `stride` numbers behind the one before.
struct BlendTarget {
  float* to;
  std::int64_t row, stride;
  bool adds = false;  // to what is there, which else is not read
  int threads = 0;
  std::stop_token stop{};
};

// The weighted sum of the values of one array over the steps. Row by row, so that it stays in the
// cache from step to step. Throws Error(kCancelled).
void blend(const std::vector<HeldStep>& steps, const DataArray& like, const BlendTarget& target);

// The same for an array as it is in memory.
inline BlendTarget whole(float* to, int threads, std::stop_token stop, bool adds = false) {
  constexpr std::int64_t kRow = 8192;  // 32 KiB
  return {to, kRow, kRow, adds, threads, std::move(stop)};
}

// One half of a body-centred lattice, whose layers alternate with the other's.
inline BlendTarget every_second_layer(float* to, std::int64_t layer, int half, int threads,
                                      std::stop_token stop, bool adds = false) {
  return {to + half * layer, layer, 2 * layer, adds, threads, std::move(stop)};
}

// The dataset of both halves of a staggered series, without arrays. `step`: one of the even ones.
Dataset body_centred_of(const Dataset& step);

}  // namespace ovoid::model
