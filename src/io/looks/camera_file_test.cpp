// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "io/core/test_folder.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace camera_file_test {

void expect_equal(const Camera& a, const Camera& b) {
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.focal_point, b.focal_point);
  EXPECT_EQ(a.view_up, b.view_up);
  EXPECT_EQ(a.parallel_projection, b.parallel_projection);
  EXPECT_EQ(a.parallel_scale, b.parallel_scale);
  EXPECT_EQ(a.view_angle, b.view_angle);
}

TEST(CameraFile, ReadsVtksWords) {
  const TestFolder folder;
  const Camera camera = read_camera(folder.write(
      "c.json", R"({"position": [1, 2.5, -3e2], "focal_point": [0, 0, 1], "view_up": [0, 0, 1],
                    "parallel_projection": true, "parallel_scale": 12.5, "view_angle": 45})"));
  Camera expected;
  expected.position = {1, 2.5, -300};
  expected.focal_point = {0, 0, 1};
  expected.view_up = {0, 0, 1};
  expected.parallel_projection = true;
  expected.parallel_scale = 12.5;
  expected.view_angle = 45;
  expect_equal(camera, expected);
}

TEST(CameraFile, MissingMembersKeepTheDefaults) {
  const TestFolder folder;
  expect_equal(read_camera(folder.write("c.json", "{}")), Camera());
  EXPECT_EQ(read_camera(folder.write("c.json", R"({"view_angle": 10})")).view_angle, 10.0);
}

TEST(CameraFile, RoundTripIsExact) {
  const TestFolder folder;
  Camera camera;
  camera.position = {0.1, 1.0 / 3, -6.02214076e23};
  camera.focal_point = {5e-324, 1e15 + 0.125, 0};
  camera.view_up = {std::sqrt(2.0), 1, 0.3};
  camera.parallel_projection = true;
  camera.parallel_scale = std::nextafter(1.0, 2.0);
  camera.view_angle = 179.99999999999997;
  write_camera(camera, folder.file("c.json"));
  expect_equal(read_camera(folder.file("c.json")), camera);
  write_camera(Camera(), folder.file("c.json"));
  expect_equal(read_camera(folder.file("c.json")), Camera());
}

TEST(CameraFile, ErrorsNameFileAndMember) {
  struct Row {
    const char* content;
    const char* named;
  };
  const Row rows[] = {
      {"[]", "c.json: []: must be an object"},
      {R"({"position": [1, 2]})", "c.json: position = [1,2]: must have 3 elements"},
      {R"({"position": [1, "2", 3]})", "c.json: position[1] = \"2\": must be a number"},
      {R"({"parallel_projection": "no"})", "parallel_projection = \"no\": must be true or false"},
      {R"({"paralel_scale": 2})", "c.json: paralel_scale = 2: unknown; a camera has position"},
      {R"({"position": [0, 0, 0]})", "c.json: camera position = (0, 0, 0): must differ"},
      {R"({"view_angle": 180})", "c.json: camera view_angle = 180"},
      {R"({"view_angle": 3)", "c.json: not JSON"},
  };
  const TestFolder folder;
  for (const Row& row : rows) {
    try {
      read_camera(folder.write("c.json", row.content));
      ADD_FAILURE() << "accepted: " << row.content;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFileFormat) << row.content;
      EXPECT_NE(std::string(error.what()).find(row.named), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(read_camera(folder.file("missing.json")), Error);
}

TEST(CameraFile, AnInvalidCameraIsNotWritten) {
  const TestFolder folder;
  Camera camera;
  camera.parallel_scale = 0;
  EXPECT_THROW(write_camera(camera, folder.file("c.json")), Error);
  EXPECT_EQ(folder.count(), 0);
}

}  // namespace camera_file_test
}  // namespace ovoid::io
