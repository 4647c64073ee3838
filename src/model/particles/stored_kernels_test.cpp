// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "model/test_datasets.h"
#include "ovoid/model.h"
#include "support/numbers.h"

namespace ovoid::model {
namespace stored_kernels_test {

// Two ellipsoids, the second turned by 90 degrees about z; its quaternion is not of length 1.
Dataset two_stored() {
  Dataset dataset = points_dataset(DatasetKind::kKernels, {{0, 0, 0}, {1, 2, 3}}, {5, 6});
  dataset.arrays.push_back(array_of_numbers<float>("scale", 3, {1, 2, 3, 4, 1, 2}));
  dataset.arrays.push_back(array_of_numbers<float>("rotation", 4, {1, 0, 0, 0, 7, 0, 0, 7}));
  return dataset;
}

TEST(StoredKernels, AreAsStored) {
  Dataset dataset = two_stored();
  KernelField field = make_kernel_field(dataset);
  EXPECT_EQ(field.reconstruction(), Reconstruction::kSum);
  EXPECT_EQ(field.source().cutoff(), 4);
  auto kernels = kernels_of(field);
  ASSERT_EQ(kernels.size(), 2U);
  EXPECT_LT((kernels[0].covariance() - Mat3(Vec3(1, 4, 9).asDiagonal())).norm(), 1e-5);
  EXPECT_LT((kernels[1].covariance() - Mat3(Vec3(1, 16, 4).asDiagonal())).norm(), 1e-5);
  EXPECT_EQ(kernels[0].weight, 1);
  EXPECT_EQ(kernels[1].values[0], 6);
  dataset.arrays.push_back(array_of_numbers<float>("weight", 1, {0.5F, 2}));
  kernels = kernels_of(make_kernel_field(dataset));
  EXPECT_EQ(kernels[1].weight, 2);
  dataset.arrays.erase(dataset.arrays.begin());
  KernelModelReport report;
  kernels = kernels_of(make_kernel_field(dataset, {}, &report));
  EXPECT_EQ(kernels[0].values[0], 1);
  EXPECT_EQ(report.notes.size(), 1U);
}

// There and back: the same covariances, weights and values, for every sample's kernels, of 1:1000
// ones too.
TEST(StoredKernels, RoundTrip) {
  Dataset blobs = make_sample("blobs", {.count = 300});
  Dataset thin = two_stored();
  thin.arrays[1] = array_of_numbers<float>("scale", 3, {1, 1e-3F, 1, 1e-3F, 1, 1});
  thin.arrays[2] = array_of_numbers<float>("rotation", 4, {1, 2, 3, 4, -1, 0.5F, 0.1F, 0});
  for (const Dataset& dataset : {blobs, thin, make_sample("galaxy", {.count = 100})}) {
    const KernelField field = make_kernel_field(dataset);
    const Dataset again = make_kernel_dataset(field);
    EXPECT_EQ(again.kind, DatasetKind::kKernels);
    const auto before = kernels_of(field);
    const auto after = kernels_of(make_kernel_field(again));
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t i = 0; i < before.size(); ++i) {
      EXPECT_EQ(before[i].weight, after[i].weight);
      EXPECT_EQ(before[i].values, after[i].values);
      const Mat3 ratio = before[i].factor.inverse() * after[i].factor;
      EXPECT_LT((ratio * ratio.transpose() - Mat3::Identity()).norm(), 2e-3) << before[i].factor;
    }
  }
}

TEST(StoredKernels, RefusesByNameAndIndex) {
  const auto refused = [](const char* name, int components, std::vector<float> numbers,
                          const std::string& words) {
    Dataset bad = two_stored();
    std::erase_if(bad.arrays, [&](const DataArray& array) { return array.name == name; });
    if (!numbers.empty()) bad.arrays.push_back(array_of_numbers(name, components, numbers));
    EXPECT_NE(model_refusal(bad).find(words), std::string::npos) << model_refusal(bad);
  };
  refused("scale", 3, {1, 1, 1, 1, 0, 1}, "scale[1][1] = 0: must be > 0");
  refused("scale", 3, {1, 1, kNanF, 1, 1, 1}, "scale[0][2] = nan: must be > 0");
  refused("scale", 3, {1, 1, 1}, "1 tuples, must be 2");
  refused("scale", 2, {1, 1, 1, 1}, "2 components, must be 3");
  refused("scale", 3, {}, "need an array 'scale'");
  refused("rotation", 4, {1, 0, 0, 0, 0, 0, 0, 0}, "rotation[1] = 0 0 0 0");
  refused("rotation", 4, {1, 0, 0, kInfinityF, 1, 0, 0, 0}, "rotation[0] = 1 0 0 inf");
  refused("weight", 1, {1, 0}, "weight[1] = 0: must be > 0");
  refused("weight", 1, {-1, 1}, "weight[0] = -1: must be > 0");
  refused("v", 1, {kNanF, kNanF}, "2 have no finite value of 'v'");
}

}  // namespace stored_kernels_test
}  // namespace ovoid::model
