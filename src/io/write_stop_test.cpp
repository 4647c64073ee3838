// SPDX-License-Identifier: Apache-2.0
// A stop token stops every writer, and what was there stays. Fails if a writer does not look.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <stop_token>
#include <string>
#include <vector>

#include "io/core/test_data.h"
#include "io/core/test_folder.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace write_stop_test {

DataArray floats(const std::string& name, std::int64_t tuples, int components) {
  std::vector<float> values(static_cast<std::size_t>(tuples * components));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = 1.0F + static_cast<float>(i);
  std::vector<std::byte> bytes(values.size() * sizeof(float));
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return {name, ScalarType::kFloat32, components, tuples, "", false, own_bytes(std::move(bytes))};
}

Dataset lattice() {
  Dataset dataset;
  dataset.lattice.dims = {4, 3, 2};
  dataset.arrays.push_back(floats("a", 24, 1));
  return dataset;
}

Dataset particles() {
  Dataset dataset;
  dataset.kind = DatasetKind::kParticles;
  dataset.positions = floats("positions", 8, 3);
  dataset.arrays.push_back(floats("a", 8, 1));
  return dataset;
}

Dataset mesh() {
  Dataset dataset = particles();
  dataset.kind = DatasetKind::kMesh;
  dataset.cells.dims = {2, 2, 2};
  return dataset;
}

void expect_stop(const Dataset& dataset, const std::string& name) {
  SCOPED_TRACE(name);
  const TestFolder folder;
  const std::string path = folder.file(name);
  try {
    write_dataset(dataset, path);
  } catch (const Error& error) {
    ASSERT_EQ(error.code(), ErrorCode::kUnsupported) << error.what();
    return;  // a build without the format's library
  }
  const std::string before = folder.read(name);
  const int num_files = folder.count();
  ASSERT_FALSE(before.empty());
  std::stop_source source;
  source.request_stop();
  try {
    write_dataset(dataset, path, {source.get_token()});
    ADD_FAILURE() << "was not stopped";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCancelled) << error.what();
  }
  EXPECT_EQ(folder.read(name), before);
  EXPECT_EQ(folder.count(), num_files);
}

TEST(WriteStop, StopsEveryWriterOfDatasets) {
  for (const char* const ending :
       {"nrrd", "nhdr", "nii", "nii.gz", "npy", "raw", "vti", "vtk", "h5"})
    expect_stop(lattice(), std::string("a.") + ending);
  for (const char* const ending : {"csv", "npz", "ply"})
    expect_stop(particles(), std::string("a.") + ending);
  expect_stop(mesh(), "a.vtu");
}

TEST(WriteStop, StopsEveryWriterOfPictures) {
  const TestFolder folder;
  Image image;
  image.width = 40;
  image.height = 30;
  image.rgba.assign(4 * 40 * 30, 0.5F);
  image.depth.assign(40 * 30, 1.0F);
  image.front_depth = image.depth;
  std::stop_source source;
  source.request_stop();
  for (const char* const name : {"a.png", "a.exr", "a.npy"}) {
    try {
      write_image(image, folder.file(name), {}, {source.get_token()});
      ADD_FAILURE() << name << " was not stopped";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCancelled) << error.what();
    }
  }
  EXPECT_EQ(folder.count(), 0);
}

}  // namespace write_stop_test
}  // namespace ovoid::io
