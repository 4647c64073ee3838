// SPDX-License-Identifier: Apache-2.0
// For tests: series of lattices by formula, and of datasets that are given.
#pragma once

#include <functional>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "model/time/lattice_steps.h"

namespace ovoid {

// The value of the sample at an index position (of the even steps) in a step.
using StepFormula = std::function<double(const Vec3& position, std::int64_t step)>;

class FormulaSteps final : public model::LatticeSteps {
 public:
  FormulaSteps(SeriesKind kind, Index3 dims, std::vector<double> times, StepFormula value,
               Affine3 world = Affine3::Identity())
      : LatticeSteps(kind, "formula"), value_(std::move(value)) {
    set_steps({dims, world}, std::move(times));
  }

 private:
  Dataset make(std::int64_t step, const LatticeGeometry& lattice,
               const std::stop_token& /*stop*/) const override {
    const bool is_shifted = kind() == SeriesKind::kStaggered && step % 2 == 1;
    const Vec3 shift = Vec3::Constant(is_shifted ? 0.5 : 0.0);
    const Index3& dims = lattice.dims;
    const auto count = static_cast<std::size_t>(num_samples(dims));
    const auto memory = std::make_shared<float[]>(count);
    std::size_t n = 0;
    for (std::int64_t z = 0; z < dims[2]; ++z) {
      for (std::int64_t y = 0; y < dims[1]; ++y) {
        for (std::int64_t x = 0; x < dims[0]; ++x)
          memory[n++] = static_cast<float>(value_(lattice.index_position({x, y, z}) + shift, step));
      }
    }
    DataArray array;
    array.name = "value";
    array.num_tuples = static_cast<std::int64_t>(count);
    array.bytes = {memory, std::as_bytes(std::span<const float>(memory.get(), count))};
    Dataset dataset;
    dataset.source = name();
    dataset.arrays.push_back(array);
    return dataset;
  }

  StepFormula value_;
};

// Steps that are there.
class GivenSteps final : public StepSource {
 public:
  GivenSteps(std::vector<Dataset> steps, std::vector<double> times)
      : steps_(std::move(steps)), times_(std::move(times)) {}
  const std::string& name() const noexcept override { return name_; }
  std::int64_t num_steps() const noexcept override {
    return static_cast<std::int64_t>(times_.size());
  }
  const std::vector<double>& times() const noexcept override { return times_; }
  bool has_times() const noexcept override { return true; }
  Dataset read(std::int64_t step, std::stop_token /*stop*/) const override {
    Dataset dataset = steps_[static_cast<std::size_t>(step)];
    dataset.step = step;
    return dataset;
  }

 private:
  std::string name_ = "given";
  std::vector<Dataset> steps_;
  std::vector<double> times_;
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
