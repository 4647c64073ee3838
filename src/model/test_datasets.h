// SPDX-License-Identifier: Apache-2.0
// Datasets for tests of kernel models, and their kernels one by one.
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "data/cell_builder.h"
#include "data/kernels/kernel_shape.h"
#include "model/own_array.h"
#include "ovoid/error.h"
#include "ovoid/model.h"

namespace ovoid::model {

struct OneKernel {
  Vec3 center;
  Mat3 factor;
  double weight = 0;
  std::vector<float> values;

  Mat3 covariance() const { return factor * factor.transpose(); }
};

// Sorted by x, then y, then z.
inline std::vector<OneKernel> kernels_of(const KernelField& field) {
  std::vector<OneKernel> kernels;
  const KernelSource& source = field.source();
  for (std::int64_t b = 0; b < source.num_bricks(); ++b) {
    const KernelView view = source.acquire(b, 0.0);
    for (std::int32_t i = 0; i < view.count; ++i) {
      const auto numbers = data::shape_numbers(view, source.shape(), i);
      OneKernel kernel;
      kernel.center = source.brick(b).origin + data::offset_of(view, i);
      kernel.factor = data::factor_of(source.shape(), numbers.data());
      kernel.weight = static_cast<double>(data::weight_of(view, i));
      for (std::size_t a = 0; a < source.attributes().size(); ++a)
        kernel.values.push_back(view.value[a][i]);
      kernels.push_back(std::move(kernel));
    }
  }
  std::sort(kernels.begin(), kernels.end(), [](const OneKernel& a, const OneKernel& b) {
    return std::lexicographical_compare(a.center.begin(), a.center.end(), b.center.begin(),
                                        b.center.end());
  });
  return kernels;
}

// Positions, and a value per position, which is its x unless said otherwise.
inline Dataset points_dataset(DatasetKind kind, const std::vector<Vec3>& points,
                              std::vector<float> values = {}) {
  Dataset dataset;
  dataset.source = "some.vtu";
  dataset.kind = kind;
  std::vector<double> numbers;
  const bool is_own = values.empty();
  for (const Vec3& point : points) {
    numbers.insert(numbers.end(), {point[0], point[1], point[2]});
    if (is_own) values.push_back(static_cast<float>(point[0]));
  }
  dataset.positions = array_of_numbers("positions", 3, std::move(numbers));
  dataset.arrays.push_back(array_of_numbers("v", 1, std::move(values)));
  return dataset;
}

// A structured grid whose nodes stand where `place` puts whole coordinates.
inline Dataset grid_dataset(const Index3& dims, const std::function<Vec3(const Vec3&)>& place) {
  std::vector<Vec3> points;
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i)
        points.push_back(
            place({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)}));
    }
  }
  Dataset dataset = points_dataset(DatasetKind::kMesh, points);
  dataset.cells.dims = dims;
  return dataset;
}

// A mesh of cells of given types.
inline Dataset mesh_dataset(
    const std::vector<Vec3>& points,
    const std::vector<std::pair<CellType, std::vector<std::uint32_t>>>& cells) {
  Dataset dataset = points_dataset(DatasetKind::kMesh, points);
  data::CellBuilder builder;
  for (const auto& [type, nodes] : cells) builder.add(type, nodes);
  dataset.cells = std::move(builder).finish();
  return dataset;
}

inline std::string model_refusal(const Dataset& dataset, const KernelModelOptions& options = {}) {
  try {
    make_kernel_field(dataset, options);
  } catch (const Error& error) {
    return error.code() == ErrorCode::kInvalidArgument ? error.what() : "another code";
  }
  return "accepted";
}

}  // namespace ovoid::model
