// SPDX-License-Identifier: Apache-2.0
// For tests: series of lattices by formula.
#pragma once

#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/series.h"

namespace ovoid {

// The value of the sample at an index position (of the even steps) in a step.
using StepFormula = std::function<double(const Vec3& position, std::int64_t step)>;

class FormulaSteps final : public StepSource {
 public:
  FormulaSteps(SeriesKind kind, Index3 dims, std::vector<double> times, StepFormula value,
               Affine3 world = Affine3::Identity())
      : kind_(kind),
        dims_(dims),
        times_(std::move(times)),
        value_(std::move(value)),
        world_(world) {}

  SeriesKind kind() const noexcept override { return kind_; }
  const std::string& name() const noexcept override { return name_; }
  std::int64_t num_steps() const noexcept override {
    return static_cast<std::int64_t>(times_.size());
  }
  const std::vector<double>& times() const noexcept override { return times_; }
  bool has_times() const noexcept override { return true; }

  Dataset read(std::int64_t step, std::stop_token /*stop*/) const override {
    const bool is_shifted = kind_ == SeriesKind::kStaggered && step % 2 == 1;
    const Vec3 shift = Vec3::Constant(is_shifted ? 0.5 : 0.0);
    Dataset dataset;
    dataset.source = name_;
    dataset.lattice.dims = dims_;
    dataset.lattice.world_from_index = world_;
    dataset.lattice.world_from_index.translate(shift);
    dataset.num_steps = num_steps();
    dataset.step = step;
    dataset.times = times_;
    dataset.series = kind_;
    const auto count = static_cast<std::size_t>(num_samples(dims_));
    const auto memory = std::make_shared<float[]>(count);
    std::size_t i = 0;
    for (std::int64_t z = 0; z < dims_[2]; ++z) {
      for (std::int64_t y = 0; y < dims_[1]; ++y) {
        for (std::int64_t x = 0; x < dims_[0]; ++x)
          memory[i++] = static_cast<float>(value_(
              Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)) + shift,
              step));
      }
    }
    DataArray array;
    array.name = "value";
    array.num_tuples = static_cast<std::int64_t>(count);
    array.bytes = {memory, std::as_bytes(std::span<const float>(memory.get(), count))};
    dataset.arrays.push_back(array);
    return dataset;
  }

 private:
  SeriesKind kind_;
  Index3 dims_;
  std::string name_ = "formula";
  std::vector<double> times_;
  StepFormula value_;
  Affine3 world_;
};

inline std::vector<float> values_of(const Dataset& dataset) {
  const auto* values = reinterpret_cast<const float*>(dataset.arrays[0].bytes.view.data());
  return {values, values + dataset.arrays[0].num_tuples};
}

inline std::vector<double> even_times(int count, double distance = 1) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) times.push_back(i * distance);
  return times;
}

// Of a staggered series whose T is 1.
inline std::vector<double> staggered_times(int count) {
  return even_times(count, 1 / std::numbers::sqrt2);
}

}  // namespace ovoid
