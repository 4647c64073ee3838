// SPDX-License-Identifier: Apache-2.0
// What may stand in a scene together. Fails if something is let through that no pass draws, or if
// the words do not say which part it is.
#include "ovoid/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "ovoid/error.h"
#include "ovoid/kernel_field.h"
#include "support/kernel_sets.h"
#include "support/volumes.h"

namespace ovoid {
namespace scene_test {

Scene of_lattice() { return {test::constant_field({4, 4, 4}, 1), ramp_look({0, 1})}; }

Scene of_kernels() {
  return {KernelField(test::jittered_balls(3).source(), Reconstruction::kNormalized),
          ramp_look({0, 1})};
}

Geometry triangle() {
  auto surface = std::make_shared<Surface>();
  surface->places = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  surface->triangles.push_back({.corners = {0, 1, 2}});
  for (const Vec3& place : surface->places) surface->bounds.extend(place);
  return {surface};
}

void expect_refused(const Scene& scene, ErrorCode code, const std::string& words) {
  try {
    scene.validate();
    ADD_FAILURE() << "accepted; expected: " << words;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << words;
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

TEST(Scene, WhatIsWrongInItselfIsNamed) {
  constexpr ErrorCode kWrong = ErrorCode::kInvalidArgument;
  expect_refused({}, kWrong, "nothing in it");
  Scene empty = of_lattice();
  empty.volumes.push_back({});
  expect_refused(empty, kWrong, "volumes[1].field");
  Scene many = of_lattice();
  many.volumes.assign(Scene::kMaxVolumes + 1, many.volumes.front());
  expect_refused(many, kWrong, "volumes: 5 given, must be at most 4");
  for (const double opacity : {-0.1, 1.1, std::nan("")}) {
    Scene walls = of_lattice();
    walls.volumes.front().walls.opacity = opacity;
    expect_refused(walls, kWrong, "walls.opacity");
  }
  Scene sliced;
  sliced.slices.push_back({});
  expect_refused(sliced, kWrong, "slices: there is no volume");
  Scene cut;
  cut.surfaces = {triangle()};
  cut.plane.emplace();
  expect_refused(cut, kWrong, "plane: there is no volume");
  Scene bad = of_lattice();
  bad.surfaces.push_back({});
  expect_refused(bad, kWrong, "has no surface");
}

TEST(Scene, PartsThatAreNotDrawnTogetherAreNamed) {
  const auto with_trail = [](Scene scene) {
    scene.volumes.front().trail = std::make_shared<Trail>();
    return scene;
  };
  const auto with_points = [](Scene scene) {
    scene.volumes.front().points.emplace();
    return scene;
  };
  const auto with_plane = [](Scene scene) {
    scene.plane.emplace();
    return scene;
  };
  const auto with_surface = [](Scene scene) {
    scene.surfaces = {triangle()};
    return scene;
  };
  const auto refused = [](const Scene& scene, const char* words) {
    expect_refused(scene, ErrorCode::kUnsupported, words);
  };
  refused(with_points(of_lattice()), "points: are for sets of kernels");
  refused(with_points(with_trail(of_kernels())), "points: are drawn without a trail");
  refused(with_points(with_plane(of_kernels())), "points: not with a value plane");
  refused(with_points(with_surface(of_kernels())), "points: not with surfaces");
  refused(with_trail(with_plane(of_lattice())), "trail: not with a value plane");
  refused(with_trail(with_surface(of_lattice())), "trail: not with surfaces");
  refused(with_plane(with_surface(of_lattice())), "value plane: not with surfaces");
  Scene mixed = of_lattice();
  mixed.volumes.push_back(of_kernels().volumes.front());
  refused(mixed, "volumes[1]: is a set of kernels");
  Scene trailing = of_lattice();
  trailing.volumes.push_back(with_trail(of_lattice()).volumes.front());
  refused(trailing, "volumes[1]: has a trail");
}

TEST(Scene, WhatIsDrawnTogetherIsAccepted) {
  Scene scene = of_lattice();
  scene.volumes.push_back(scene.volumes.front());
  scene.surfaces = {triangle()};
  scene.slices.resize(2);
  EXPECT_NO_THROW(scene.validate());
  EXPECT_TRUE(scene.has_scenery());
  Scene alone;
  alone.surfaces = {triangle()};
  EXPECT_NO_THROW(alone.validate());
  Scene points = of_kernels();
  points.volumes.front().points.emplace();
  EXPECT_NO_THROW(points.validate());
}

}  // namespace scene_test
}  // namespace ovoid
