// SPDX-License-Identifier: Apache-2.0
#include "model/time/step_blend.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <type_traits>

#include "data/parallel.h"
#include "data/scalar_visit.h"
#include "ovoid/error.h"

namespace ovoid::model {
namespace {

// to[i] (+)= weight * value of the array's number first + i.
void add_values(const DataArray& array, double weight, bool is_first, std::int64_t first,
                std::span<float> to) {
  const auto scale = static_cast<float>(weight * array.value_scale);
  const auto offset = static_cast<float>(weight * array.value_offset);
  data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    const std::byte* from = array.bytes.view.data() + first * std::int64_t{sizeof(T)};
    for (std::size_t i = 0; i < to.size(); ++i) {
      const auto stored =
          static_cast<float>(data::load_scalar<T>(from, static_cast<std::int64_t>(i)));
      const float value = stored * scale + offset;
      to[i] = is_first ? value : to[i] + value;
    }
  });
}

}  // namespace

Floats new_floats(std::int64_t count) { return Floats(new float[static_cast<std::size_t>(count)]); }

DataArray float_array(const DataArray& like, const Floats& values, std::int64_t num_tuples) {
  DataArray array = like;
  array.type = ScalarType::kFloat32;
  array.value_scale = 1;
  array.value_offset = 0;
  array.num_tuples = num_tuples;
  array.bytes = {
      values,
      std::as_bytes(std::span<const float>(
          values.get(), static_cast<std::size_t>(num_tuples * std::int64_t{like.num_components})))};
  return array;
}

const DataArray& same_array(const Dataset& dataset, const DataArray& like) {
  for (const DataArray& array : dataset.arrays) {
    if (array.name == like.name && array.is_cell_data == like.is_cell_data &&
        array.num_components == like.num_components && array.num_tuples == like.num_tuples)
      return array;
  }
  throw Error(ErrorCode::kFileFormat,
              fmt::format("'{}' step {}: has no array '{}' like step 0 of the series",
                          dataset.source, dataset.step, like.name));
}

std::vector<HeldStep> hold(const Series& series, const std::vector<StepWeight>& weights,
                           std::stop_token stop) {
  std::vector<HeldStep> steps;
  steps.reserve(weights.size());
  for (const auto& [step, weight] : weights) steps.push_back({series.step(step, stop), weight});
  return steps;
}

void blend(const std::vector<HeldStep>& steps, const DataArray& like, const BlendTarget& target) {
  std::vector<const DataArray*> arrays;
  arrays.reserve(steps.size());
  for (const HeldStep& step : steps) arrays.push_back(&same_array(*step.dataset, like));
  const std::int64_t count = like.num_tuples * like.num_components;
  const std::int64_t row = target.row;
  data::parallel_ranges({(count + row - 1) / row, 1, target.threads, target.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          for (std::int64_t r = begin; r < end; ++r) {
                            const std::int64_t length = std::min(row, count - r * row);
                            const std::span<float> out(target.to + r * target.stride,
                                                       static_cast<std::size_t>(length));
                            for (std::size_t s = 0; s < steps.size(); ++s)
                              add_values(*arrays[s], steps[s].weight, s == 0 && !target.adds,
                                         r * row, out);
                          }
                        });
}

Dataset body_centred_of(const Dataset& step) {
  Dataset out = step;
  out.arrays.clear();
  out.series = SeriesKind::kSteps;
  out.lattice.kind = LatticeKind::kBodyCentred;
  out.lattice.dims[2] *= 2;
  return out;
}

}  // namespace ovoid::model
