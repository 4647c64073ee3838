// SPDX-License-Identifier: Apache-2.0
// What the text of a glTF file says, and what it must not: numbers that the file does not have.
#include "io/meshes/gltf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <span>
#include <string>

#include "fuzz/seeds.h"
#include "io/core/byte_source.h"
#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "io/meshes/gltf_file.h"
#include "ovoid/dataset.h"

namespace ovoid::io {
namespace gltf_test {

using testing::HasSubstr;

Dataset gltf_of(const std::string& file) {
  return read_gltf(*open_memory("a.gltf", std::as_bytes(std::span(file))), {}, open_file);
}
std::string gltf_error(const std::string& file) {
  return error_of([&] { gltf_of(file); });
}

// The text with other words in the place of some.
std::string gltf_with(const std::string& words, const std::string& other) {
  std::string file = fuzz::gltf_seeds()[1];
  const std::size_t at = file.find(words);
  EXPECT_NE(at, std::string::npos) << words;
  return file.replace(at, words.size(), other);
}

TEST(Gltf, IsToldByMagicOrName) {
  const std::string file = fuzz::gltf_seeds()[0];
  EXPECT_TRUE(is_gltf(*open_memory("a", std::as_bytes(std::span(file))), file.substr(0, 512)));
  EXPECT_TRUE(is_gltf(*open_memory("a.gltf", {}), "{"));
  EXPECT_FALSE(is_gltf(*open_memory("a.json", {}), "{"));
}

TEST(Gltf, WhatIsNotThereIsNamed) {
  const auto refused = [](const char* words, const char* other, const char* told) {
    EXPECT_THAT(gltf_error(gltf_with(words, other)), HasSubstr(told)) << other;
  };
  refused("\"count\":3,\"type\":\"VEC3\"", "\"count\":4,\"type\":\"VEC3\"",
          "accessors[0] = {...}: must end within its view of 36 bytes");
  refused("\"count\":3", "\"count\":0", "must end within its view");
  refused("\"count\":3", "\"count\":-3", "expected a whole number");
  refused("\"count\":3", "\"count\":1e11", "must end within its view");
  refused("5126", "5127", "is of no type of glTF's");
  refused("5123", "5122", "must be of unsigned whole numbers");
  refused("\"type\":\"SCALAR\"", "\"type\":\"VEC2\"", "must end within its view");
  refused("\"bufferView\":1", "\"bufferView\":2", "there are 2 bufferViews");
  refused("\"byteOffset\":36", "\"byteOffset\":37", "must end within its buffer of 42 bytes");
  refused("\"byteLength\":42", "\"byteLength\":43", "42 of its 43 bytes are there");
  refused("\"POSITION\":0", "\"POSITION\":7", "there are 2 accessors");
  refused("\"indices\":1", "\"indices\":2", "there are 2 accessors");
  refused("\"mesh\":0", "\"mesh\":1", "there are 1 meshes");
  refused("\"children\":[1]", "\"children\":[2]", "there are 2 nodes");
  refused("\"children\":[1]", "\"children\":[1,1]", "more than once");
  refused("\"children\":[1]", "\"children\":[0]", "more than once");
  refused("\"2.0\"", "\"1.0\"", "is of glTF 1.0");
  refused("\"indices\":1", "\"extensions\":{\"KHR_draco_mesh_compression\":{}}", "Draco");
  refused("\"uri\":\"data:", "\"uri\":\"nowhere/", "nowhere/");
}

// Binary and text; a node moves the triangle.
TEST(Gltf, NodesPutMeshesInTheirPlace) {
  for (const std::string& file : fuzz::gltf_seeds()) {
    const Dataset mesh = gltf_of(file);
    ASSERT_EQ(mesh.num_positions(), 3);
    const auto places = values_of<float>(mesh.positions);
    EXPECT_EQ(places, (std::vector<float>{10, 0, 0, 11, 0, 0, 10, 1, 0}));
  }
  // Twice as large, turned about z by a quarter, then moved: as text and as a matrix.
  const std::vector<float> expected{10, 0, 0, 10, 2, 0, 8, 0, 0};
  for (
      const char* const placed :
      {R"("translation":[10,0,0],"rotation":[0,0,0.7071067811865476,0.7071067811865476],"scale":[2,2,2])",
       R"("matrix":[0,2,0,0,-2,0,0,0,0,0,2,0,10,0,0,1])"}) {
    const auto places =
        values_of<float>(gltf_of(gltf_with("\"translation\":[10,0,0]", placed)).positions);
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_NEAR(places[i], expected[i], 1e-5F) << i;
  }
}

TEST(Gltf, EveryKindOfPrimitiveBecomesCells) {
  const auto types_of = [](int mode) {
    const Dataset mesh =
        gltf_of(gltf_with("\"indices\":1", "\"indices\":1,\"mode\":" + std::to_string(mode)));
    const auto types = mesh.cells.types.view();
    return std::vector<CellType>(types.begin(), types.end());
  };
  const Dataset points = gltf_of(gltf_with("\"indices\":1", "\"indices\":1,\"mode\":0"));
  EXPECT_EQ(points.kind, DatasetKind::kParticles);
  EXPECT_EQ(points.num_positions(), 3);
  EXPECT_EQ(types_of(1), std::vector(1, CellType::kPolyLine));
  for (const int mode : {2, 3}) EXPECT_EQ(types_of(mode), std::vector(1, CellType::kPolyLine));
  for (const int mode : {4, 5, 6}) EXPECT_EQ(types_of(mode), std::vector(1, CellType::kTriangle));
  EXPECT_THAT(gltf_error(gltf_with("\"indices\":1", "\"indices\":1,\"mode\":7")),
              HasSubstr("expected 0 to 6"));
}

TEST(Gltf, CutFilesAreRefused) {
  const std::string file = fuzz::gltf_seeds()[0];
  EXPECT_EQ(gltf_error(file), "");
  EXPECT_THAT(gltf_error(file.substr(0, file.size() - 1)), HasSubstr("its numbers have 44 bytes"));
  EXPECT_THAT(gltf_error(file.substr(0, 100)), HasSubstr("80 are there"));
  EXPECT_THAT(gltf_error(file.substr(0, 14)), HasSubstr("ends within its header"));
}

TEST(Gltf, FilesOfNumbersBelongToIt) {
  const TestFolder folder;
  const std::string part = folder.write("a.bin", std::string(42, 'a'));
  const std::string path =
      folder.write("a.gltf", R"({"buffers": [{"uri": "a.bin"}, {"uri": "no.bin"}]})");
  EXPECT_THAT(gltf_companions(*open_file(path)), testing::ElementsAre(part));
}

}  // namespace gltf_test
}  // namespace ovoid::io
