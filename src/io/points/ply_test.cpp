// SPDX-License-Identifier: Apache-2.0
#include "io/points/ply.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "io/read_source.h"

namespace ovoid::io {
namespace ply_test {

using Floats = std::vector<float>;

const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";
const std::string kFace = "element face 2\nproperty list uchar int vertex_indices\n";

Dataset read_bytes(const std::string& bytes) {
  return read_source(*open_memory("a.ply", std::as_bytes(std::span(bytes))), {});
}

std::string ply_error(const std::string& bytes) {
  return error_of([&] { read_bytes(bytes); });
}

std::string head(const std::string& format, const std::string& elements) {
  return "ply\nformat " + format + " 1.0\ncomment hello\n" + elements + "end_header\n";
}

// As it lies in a file of the other byte order.
template <typename T>
std::string reversed(T value) {
  std::string bytes(reinterpret_cast<const char*>(&value), sizeof(T));
  std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

TEST(Ply, Text) {
  const Dataset dataset = read_bytes(head("ascii", kFace + "element vertex 2\n" + kXyz +
                                                       "property uchar red\nproperty double v\n") +
                                     "3 0 1 2\n3 0 1 2\n0 0.5 1 255 1e-300\n\n2 3 -4e1 0 nan\n");
  EXPECT_EQ(dataset.kind, DatasetKind::kParticles);
  EXPECT_EQ(values_of<float>(dataset.positions), (Floats{0, 0.5F, 1, 2, 3, -40}));
  EXPECT_EQ(values_of<std::uint8_t>(dataset.array("red")), (std::vector<std::uint8_t>{255, 0}));
  EXPECT_EQ(values_of<double>(dataset.array("v"))[0], 1e-300);
  EXPECT_TRUE(std::isnan(values_of<double>(dataset.array("v"))[1]));
}

TEST(Ply, BigEndianBehindLists) {
  std::string bytes = head("binary_big_endian", kFace + "element vertex 2\nproperty short a\n" +
                                                    kXyz + "property int b\n");
  bytes += std::string("\x01", 1) + reversed<std::int32_t>(7) + std::string(1, '\0');
  for (int i = 0; i < 2; ++i) {
    bytes += reversed<std::int16_t>(static_cast<std::int16_t>(-i)) + reversed<float>(1.5F) +
             reversed<float>(2) + reversed<float>(3) + reversed<std::int32_t>(100000 + i);
  }
  const Dataset dataset = read_bytes(bytes);
  EXPECT_EQ(values_of<float>(dataset.positions), (Floats{1.5F, 2, 3, 1.5F, 2, 3}));
  EXPECT_EQ(values_of<std::int16_t>(dataset.array("a")), (std::vector<std::int16_t>{0, -1}));
  EXPECT_EQ(values_of<std::int32_t>(dataset.array("b")),
            (std::vector<std::int32_t>{100000, 100001}));
}

TEST(Ply, GaussianSplatting) {
  std::string properties = kXyz;
  for (const char* const name : {"nx", "f_dc_0", "f_rest_0", "opacity", "scale_0", "scale_1",
                                 "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    properties += std::string("property float ") + name + "\n";
  const Floats first{1, 2, 3, 0, 0.25F, 0.5F, -1, 0, 1, -2, 1, 0, 0, 0};
  const Floats second{4, 5, 6, 0, 0.75F, 0.5F, 2, 0, 0, 0, 2, 3, 4, 5};
  const Dataset dataset =
      read_bytes(head("binary_little_endian", "element vertex 2\n" + properties) + bytes_of(first) +
                 bytes_of(second));
  EXPECT_EQ(dataset.kind, DatasetKind::kKernels);
  EXPECT_EQ(values_of<float>(dataset.array("scale")),
            (Floats{1, std::exp(1.0F), static_cast<float>(std::exp(-2.0)), 1, 1, 1}));
  EXPECT_EQ(values_of<float>(dataset.array("rotation")), (Floats{1, 0, 0, 0, 2, 3, 4, 5}));
  EXPECT_EQ(dataset.array("rotation").num_components, 4);
  EXPECT_EQ(values_of<float>(dataset.array("f_dc_0")), (Floats{0.25F, 0.75F}));
  EXPECT_EQ(dataset.array().name, "opacity");
  ASSERT_EQ(dataset.notes.size(), 1U);
  EXPECT_NE(dataset.notes[0].find("colours (f_dc_*, f_rest_*) are not drawn"), std::string::npos);
}

TEST(Ply, ErrorsNameWhatIsWrong) {
  const std::string xyz = "element vertex 9\n" + kXyz;
  EXPECT_EQ(
      ply_error(head("binary_little_endian", xyz) + "12345"),
      "file-format: a.ply: element 'vertex' claims 9 records of 12 bytes: the file has 5 bytes "
      "for them");
  EXPECT_EQ(
      ply_error(head("binary_little_endian", "element vertex 1000000000000\n" + kXyz)),
      "file-format: a.ply: element 'vertex' claims 1000000000000 records of 12 bytes: the file "
      "has 0 bytes for them");
  EXPECT_EQ(ply_error(head("ascii", "element vertex 2\n" + kXyz) + "1 2 3\n1 2 red\n"),
            "file-format: a.ply: line 10: property 'z' is 'red': expected float32");
  EXPECT_EQ(
      ply_error(head("ascii", "element vertex 1\n" + kXyz + "property uchar c\n") + "1 2 3 256\n")
          .substr(0, 45),
      "file-format: a.ply: line 10: property 'c' is ");
  EXPECT_EQ(ply_error(head("ascii", "element vertex 2\n" + kXyz) + "1 2 3\n       \n"),
            "file-format: a.ply: ends after 1 of 2 records of element 'vertex'");
  EXPECT_EQ(ply_error("ply\nelement vertex 1\n"),
            "file-format: a.ply: PLY header, line 2: the header has no 'end_header'");
  EXPECT_EQ(ply_error(head("ascii", "element vertex 1\nproperty float128 x\n")),
            "file-format: a.ply: PLY header, line 5: type 'float128': expected char to double");
  EXPECT_EQ(ply_error(head("ascii", "element vertex 1\nproperty float x\nproperty float x\n")),
            "file-format: a.ply: PLY header, line 6: property 'x' stands twice");
  EXPECT_EQ(ply_error(head("ascii", "element face 1\nproperty float a\n") + "1\n"),
            "file-format: a.ply: has no element 'vertex', nor one with x, y and z");
  EXPECT_EQ(ply_error(head("binary_little_endian", kFace + xyz) + "\xff"),
            "file-format: a.ply: ends within the lists of element 'face'");
}

Dataset kernels(ScalarType type) {
  Dataset dataset;
  dataset.kind = DatasetKind::kKernels;
  dataset.positions = make_array("positions", ScalarType::kFloat32, Floats{1, 2, 3, 4, 5, 6}, 3);
  dataset.arrays.push_back(make_array("value", ScalarType::kFloat32, Floats{7, 8}));
  dataset.arrays.push_back(make_array("velocity field", ScalarType::kInt16,
                                      std::vector<std::int16_t>{1, 2, 3, 4, 5, 6}, 3));
  dataset.arrays.push_back(make_array("weight", ScalarType::kFloat32, Floats{1, 2}));
  if (type == ScalarType::kFloat32)
    dataset.arrays.push_back(make_array("scale", type, Floats{1e-6F, 0.1F, 1, 2, 300, 1e9F}, 3));
  else
    dataset.arrays.push_back(
        make_array("scale", type, std::vector<double>{1e-6, 0.1, 1, 2, 300, 1e9}, 3));
  dataset.arrays.push_back(
      make_array("rotation", ScalarType::kFloat32, Floats{1, 0, 0, 0, 0.5F, 0.5F, 0.5F, 0.5F}, 4));
  return dataset;
}

TEST(Ply, KernelsRoundTrip) {
  const TestFolder folder;
  const Dataset dataset = kernels(ScalarType::kFloat32);
  write_dataset(dataset, folder.file("a.ply"));
  const Dataset again = read_dataset({folder.file("a.ply")});
  EXPECT_EQ(again.kind, DatasetKind::kKernels);
  EXPECT_EQ(values_of<float>(again.positions), values_of<float>(dataset.positions));
  for (const char* const name : {"value", "weight", "rotation"})
    EXPECT_EQ(values_of<float>(again.array(name)), values_of<float>(dataset.array(name))) << name;
  EXPECT_EQ(values_of<std::int16_t>(again.array("velocity_field")),
            values_of<std::int16_t>(dataset.array("velocity field")));
  EXPECT_EQ(again.array("velocity_field").num_components, 3);
  EXPECT_EQ(again.array().name, "value");
  const auto sigmas = values_of<float>(dataset.array("scale")),
             read = values_of<float>(again.array("scale"));
  ASSERT_EQ(read.size(), sigmas.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    // The bound that ply.h states.
    const double bound = 1.2e-7 * std::max(1.0, std::abs(std::log(double{sigmas[i]})));
    EXPECT_NEAR(read[i] / sigmas[i], 1, bound) << i;
  }
}

TEST(Ply, KernelsInDoublesRoundTrip) {
  const TestFolder folder;
  write_dataset(kernels(ScalarType::kFloat64), folder.file("a.ply"));
  const auto read = values_of<double>(read_dataset({folder.file("a.ply")}).array("scale"));
  const auto sigmas = values_of<double>(kernels(ScalarType::kFloat64).array("scale"));
  ASSERT_EQ(read.size(), sigmas.size());
  for (std::size_t i = 0; i < read.size(); ++i) EXPECT_NEAR(read[i] / sigmas[i], 1, 1e-14) << i;
}

// How kernels are summed stands in comments, which other readers pass over.
TEST(Ply, KernelsSayHowTheyAreSummed) {
  const TestFolder folder;
  Dataset dataset = kernels(ScalarType::kFloat32);
  write_dataset(dataset, folder.file("a.ply"));
  EXPECT_EQ(read_dataset({folder.file("a.ply")}).reconstruction, std::nullopt);
  dataset.reconstruction = Reconstruction::kNormalized;
  dataset.cutoff = 3.5;
  write_dataset(dataset, folder.file("a.ply"));
  const Dataset again = read_dataset({folder.file("a.ply")});
  EXPECT_EQ(again.reconstruction, Reconstruction::kNormalized);
  EXPECT_EQ(again.cutoff, 3.5);
  const std::string points = "element vertex 1\n" + kXyz;
  EXPECT_EQ(read_bytes(head("ascii", "comment ovoid cutoff 2\n" + points) + "1 2 3\n").cutoff,
            std::nullopt);  // particles are no kernels
  EXPECT_EQ(ply_error(head("ascii", "comment ovoid cutoff 99\n" + points) + "1 2 3\n"),
            "file-format: a.ply: PLY header, line 4: cutoff '99': expected 1 to 16");
  EXPECT_EQ(ply_error(head("ascii", "comment ovoid reconstruction mean\n" + points) + "1 2 3\n"),
            "file-format: a.ply: PLY header, line 4: reconstruction 'mean': expected normalized or "
            "sum");
}

TEST(Ply, WhatCannotBeWritten) {
  const TestFolder folder;
  Dataset dataset = kernels(ScalarType::kFloat32);
  dataset.arrays[3] = make_array("scale", ScalarType::kFloat32, Floats{1, 1, 1, 0, 1, 1}, 3);
  EXPECT_EQ(error_of([&] { write_dataset(dataset, folder.file("a.ply")); }),
            "invalid-argument: scale[1] = 0: must be > 0");
  dataset = kernels(ScalarType::kFloat32);
  dataset.arrays[0].name = "x";
  EXPECT_EQ(error_of([&] { write_dataset(dataset, folder.file("a.ply")); }),
            "invalid-argument: array 'x': PLY has a property 'x' already: rename it");
  EXPECT_EQ(
      error_of([&] { write_dataset(kernels(ScalarType::kFloat32), folder.file("a.csv")); }),
      "unsupported: " + folder.file("a.csv") + ": .csv holds particles, the dataset is kernels");
  dataset.arrays[0].num_tuples = 1;
  EXPECT_EQ(error_of([&] { write_dataset(dataset, folder.file("a.ply")); }).substr(0, 45),
            "invalid-argument: array 'x': has 1 tuples of ");
  EXPECT_EQ(folder.count(), 0);
}

}  // namespace ply_test
}  // namespace ovoid::io
