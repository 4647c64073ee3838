// SPDX-License-Identifier: Apache-2.0
#include "experiments/fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

namespace ovoid::experiments {

KernelChoice default_choice() {
  return {"default: B-spline, prefilter", kBSplineKernel, Reconstruction::kNormalized, true};
}

KernelChoice published_choice() {
  return {"plain sum, sigma 0.5", {0.5, 4.0}, Reconstruction::kSum, false};
}

KernelChoice catmull_rom_choice() {
  return {"Catmull-Rom", kCatmullRomKernel, Reconstruction::kNormalized, false};
}

KernelChoice normalized_choice(double sigma, double reach, bool prefilter) {
  return {fmt::format("normalized, sigma {:.2f}, reach {:.1f}{}", sigma, reach,
                      prefilter ? ", prefilter" : ""),
          {sigma, reach / sigma},
          Reconstruction::kNormalized,
          prefilter};
}

LatticeField field_of(const Dataset& dataset, const KernelChoice& choice) {
  LatticeModelOptions options;
  options.kernel = choice.kernel;
  options.reconstruction = choice.reconstruction;
  options.prefilter = choice.prefilter;
  return make_lattice_field(dataset, options);
}

Dataset dataset_of(const Index3& dims, const SampleFunction& function) {
  auto values = std::make_shared<std::vector<float>>();
  values->reserve(static_cast<std::size_t>(num_samples(dims)));
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        values->push_back(static_cast<float>(function(i, j, k)));
      }
    }
  }
  DataArray array;
  array.name = "value";
  array.num_tuples = num_samples(dims);
  array.bytes.view = std::as_bytes(std::span<const float>(*values));
  array.bytes.owner = std::move(values);
  Dataset dataset;
  dataset.lattice.dims = dims;
  dataset.arrays.push_back(std::move(array));
  return dataset;
}

PointField kernel_points(const Dataset& dataset, const KernelChoice& choice,
                         GradientMethod gradient) {
  const auto evaluator =
      std::make_shared<const reference::FieldEvaluator>(field_of(dataset, choice));
  const double spacing = dataset.lattice.spacing()[0];
  return [evaluator, spacing, gradient](const Vec3& position) {
    reference::FieldSample sample = evaluator->at_index(position);
    if (gradient == GradientMethod::kCorrected) {
      sample.gradient = evaluator->corrected_gradient(sample.gradient, position, Vec3::Ones());
    }
    sample.gradient *= spacing;
    return sample;
  };
}

PointField trilinear_points(const Dataset& dataset) {
  const DataArray& array = dataset.array();
  const auto* values = reinterpret_cast<const float*>(array.bytes.view.data());
  const Index3 dims = dataset.lattice.dims;
  return [values, dims, owner = array.bytes.owner](const Vec3& position) {
    Index3 cell;
    Vec3 share;
    for (int a = 0; a < 3; ++a) {
      cell[a] = std::clamp<std::int64_t>(static_cast<std::int64_t>(position[a]), 0, dims[a] - 2);
      share[a] = position[a] - static_cast<double>(cell[a]);
    }
    reference::FieldSample sample;
    sample.is_defined = true;
    for (int corner = 0; corner < 8; ++corner) {
      const Index3 step{corner & 1, (corner >> 1) & 1, corner >> 2};
      Vec3 weight;
      Vec3 slope;
      for (int a = 0; a < 3; ++a) {
        weight[a] = step[a] == 1 ? share[a] : 1 - share[a];
        slope[a] = step[a] == 1 ? 1 : -1;
      }
      const auto value = static_cast<double>(
          values[(cell[0] + step[0]) +
                 dims[0] * ((cell[1] + step[1]) + dims[1] * (cell[2] + step[2]))]);
      sample.value += value * weight.prod();
      sample.gradient +=
          value * Vec3(slope[0] * weight[1] * weight[2], weight[0] * slope[1] * weight[2],
                       weight[0] * weight[1] * slope[2]);
    }
    return sample;
  };
}

}  // namespace ovoid::experiments
