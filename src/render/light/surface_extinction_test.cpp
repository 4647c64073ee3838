// SPDX-License-Identifier: Apache-2.0
// Surfaces in the light (docs/numerics.md) against closed forms, through a field that takes none.
#include "render/light/surface_extinction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "model/test_datasets.h"
#include "ovoid/model.h"
#include "render/light/light_sweep.h"
#include "render/light/light_volume.h"
#include "support/scenes.h"
#include "support/volumes.h"

namespace ovoid {
namespace surface_extinction_test {

constexpr int kLitEdge = 64;  // samples, and cells of light: both are 1 long
const Vec3 kLitMiddle(31.5, 31.5, 31.5);

Field clear_field() { return test::constant_field({kLitEdge, kLitEdge, kLitEdge}, 1); }

Look clear_look(const Vec3& towards_light) {
  Look look = test::uniform_look(0);
  look.shade = true;
  look.unit_distance = 1;
  look.shadows = 1;
  look.light_direction = towards_light;
  return look;
}

std::shared_ptr<const Surface> surface_of(
    const std::vector<Vec3>& places, const std::vector<std::vector<std::uint32_t>>& triangles) {
  std::vector<std::pair<CellType, std::vector<std::uint32_t>>> cells;
  for (const auto& triangle : triangles) cells.emplace_back(CellType::kTriangle, triangle);
  return make_surface(model::mesh_dataset(places, cells));
}

// A rectangle around `middle`, across `normal`.
std::shared_ptr<const Surface> plate(const Vec3& middle, const Vec3& normal, double half) {
  const Vec3 n = normal.normalized();
  const Vec3 u = half * n.unitOrthogonal();
  const Vec3 v = n.cross(u);
  return surface_of({middle - u - v, middle + u - v, middle + u + v, middle - u + v},
                    {{0, 1, 2}, {0, 2, 3}});
}

// As many segments around as make it round, open at its ends.
std::shared_ptr<const Surface> tube(const Vec3& from, const Vec3& to, double radius) {
  constexpr std::uint32_t kAround = 24;
  const Vec3 along = (to - from).normalized();
  const Vec3 u = along.unitOrthogonal();
  const Vec3 v = along.cross(u);
  std::vector<Vec3> places;
  std::vector<std::vector<std::uint32_t>> triangles;
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const double turn = 2 * std::numbers::pi * i / kAround;
    const Vec3 out = radius * (std::cos(turn) * u + std::sin(turn) * v);
    places.push_back(from + out);
    places.push_back(to + out);
    const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % kAround);
    triangles.push_back({a, b, b + 1});
    triangles.push_back({a, b + 1, a + 1});
  }
  return surface_of(places, triangles);
}

std::shared_ptr<const Surface> ball(const Vec3& middle, double radius) {
  constexpr std::uint32_t kAround = 48, kRings = 24;
  std::vector<Vec3> places;
  std::vector<std::vector<std::uint32_t>> triangles;
  for (std::uint32_t ring = 0; ring <= kRings; ++ring) {
    const double polar = std::numbers::pi * ring / kRings;
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const double turn = 2 * std::numbers::pi * i / kAround;
      places.push_back(middle + radius * Vec3(std::sin(polar) * std::cos(turn),
                                              std::sin(polar) * std::sin(turn), std::cos(polar)));
      if (ring == kRings) continue;
      const std::uint32_t a = ring * kAround + i, b = ring * kAround + (i + 1) % kAround;
      if (ring > 0) triangles.push_back({a, b, b + kAround});
      if (ring + 1 < kRings) triangles.push_back({a, b + kAround, a + kAround});
    }
  }
  return surface_of(places, triangles);
}

view::LightVolume light_of(const std::vector<Geometry>& geometry, const Look& look,
                           const Field& field = clear_field(), int threads = 2) {
  LightVolumes lights;
  return *lights.at({field, look, {}, {}, {}, nullptr, geometry}, threads, {});
}

// Of a plane's sides some lie along cells, some aslant.
std::vector<Vec3> some_directions() {
  return {{0, 0, 1}, {0, 1, 0}, {1, 0, 1}, {0.3, 0.2, 1}, {1, -1, 1}, {-0.7, 0.4, 0.5}};
}

// For plates across all of these, light from all that meets them at less than 80 degrees from their
// normals: calls body(plate's normal, light, the way towards it to a distance of 4 from the plate).
template <class Body>
void for_plates(double opacity, const Body& body) {
  for (const Vec3& normal : some_directions()) {
    const std::vector<Geometry> geometry{{plate(kLitMiddle, normal, 20), {1, 1, 1}, opacity}};
    for (const Vec3& towards : some_directions()) {
      const double cosine = normal.normalized().dot(towards.normalized());
      if (std::abs(cosine) < 0.17) continue;
      const view::LightVolume light = light_of(geometry, clear_look(towards));
      body(normal.normalized(), light, Vec3(4 / std::abs(cosine) * towards.normalized()));
    }
  }
}

// Fails if light goes through between cells that a surface aslant passes through, or if a surface
// hides what lies beside it or before it.
TEST(SurfaceExtinction, BehindAnOpaquePlateThereIsNoLight) {
  double most = 0;
  for_plates(1, [&](const Vec3& normal, const view::LightVolume& light, const Vec3& towards) {
    const Vec3 u = normal.unitOrthogonal();
    for (const double aside : {-6.3, 0.0, 2.6, 7.1}) {
      const double dark = light.at(kLitMiddle + aside * u - towards).key;
      most = std::max(most, dark);
      EXPECT_LT(dark, 0.06) << normal.transpose() << " / " << towards.transpose();
      EXPECT_GT(light.at(kLitMiddle + aside * u + towards).key, 0.99);
    }
  });
  std::printf("behind an opaque plate at most %.3f\n", most);
}

// Fails if what is absorbed goes with the way of a ray through cells instead of its crossings.
TEST(SurfaceExtinction, HalfAsOpaqueLetsHalfThrough) {
  double worst = 0;
  for_plates(0.5, [&](const Vec3& normal, const view::LightVolume& light, const Vec3& towards) {
    const Vec3 u = normal.unitOrthogonal();
    for (const double aside : {-6.3, 0.0, 2.6, 7.1}) {
      const double left = light.at(kLitMiddle + aside * u - towards).key;
      worst = std::max(worst, std::abs(left - 0.5));
      EXPECT_NEAR(left, 0.5, 0.08) << normal.transpose() << " / " << towards.transpose();
    }
  });
  std::printf("behind half opacity at most %.3f from a half\n", worst);
}

TEST(SurfaceExtinction, BesideAPlateNothingChanges) {
  const std::vector<Geometry> geometry{{plate({31.5, 31.5, 45.2}, {0, 0, 1}, 8)}};
  const view::LightVolume light = light_of(geometry, clear_look({0, 0, 1}));
  for (const double x : {19.0, 21.5, 41.5, 44.0}) EXPECT_EQ(light.at({x, 31.5, 20}).key, 1) << x;
  for (const double x : {24.5, 31.5, 38.5}) EXPECT_LT(light.at({x, 31.5, 20}).key, 0.03) << x;
  EXPECT_EQ(light.at({31.5, 31.5, 50}).key, 1);
}

// Of the light that falls on a square of cells across it: how many cells' share is gone.
double shadow_area(const std::vector<Geometry>& geometry, const Vec3& towards) {
  const view::LightVolume light = light_of(geometry, clear_look(towards));
  const double steepness = towards.normalized()[2];
  double sum = 0;
  constexpr double kStep = 0.5;
  for (double y = 2; y < 62; y += kStep) {
    for (double x = 2; x < 62; x += kStep) sum += 1 - light.at({x, y, 12}).key;
  }
  return sum * kStep * kStep * steepness;
}

// The shadow of a tube of that many cells is its diameter times its length. Fails if a cell that it
// passes through is dark as a whole, or if its two sides count twice.
TEST(SurfaceExtinction, AThinTubeCastsWhatItCovers) {
  for (const double diameter : {0.15, 0.3, 0.9}) {
    for (const Vec3& along : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0.3)}) {
      for (const Vec3& towards : {Vec3(0, 0, 1), Vec3(0.3, -0.2, 1)}) {
        double mean = 0;
        const Vec3 half = 10 * along.normalized();
        constexpr int kPlaces = 2;
        for (int i = 0; i < kPlaces; ++i) {
          const Vec3 middle = Vec3(31.6, 31.7, 36.4) + i * Vec3(0.31, 0.29, 0.47);
          const Geometry geometry{tube(middle - half, middle + half, diameter / 2)};
          mean += shadow_area({geometry}, towards) / kPlaces;
        }
        const double expected = (2 * half).cross(towards.normalized()).norm() * diameter;
        // Rays are a sixteenth of a cell apart.
        EXPECT_GT(mean, (1 - 0.02 / diameter) * expected) << diameter;
        // Shadows are read between cells, which makes dark ones wider.
        EXPECT_LT(mean, (1.05 + 0.45 * diameter) * expected)
            << diameter << " along " << along.transpose() << " under " << towards.transpose();
      }
    }
  }
}

// Fails if the two layers of what is closed count as one, or more.
TEST(SurfaceExtinction, AClosedSurfaceHasTwoLayers) {
  for (const double radius : {3.0, 9.0}) {
    const std::vector<Geometry> geometry{{ball({31.5, 31.5, 40}, radius), {1, 1, 1}, 0.5}};
    for (const Vec3& towards : {Vec3(0, 0, 1), Vec3(0.4, 0.3, 1)}) {
      const Vec3 behind = Vec3(31.5, 31.5, 40) - 15 * towards.normalized();
      EXPECT_NEAR(light_of(geometry, clear_look(towards)).at(behind).key, 0.25, 0.04) << radius;
    }
  }
}

// A wall that fills half of the sky takes, of what comes from so far as R, exp(-d / (R cosine)).
TEST(SurfaceExtinction, NearAWallHalfOfTheLightIsLeft) {
  ExtinctionLattice lattice;
  lattice.dims = {kLitEdge, kLitEdge, kLitEdge};
  lattice.extinction.assign(std::size_t{kLitEdge} * kLitEdge * kLitEdge, 0.0F);
  const std::vector<Geometry> wall{{plate({31.5, 31.5, 20}, {0, 0, 1}, 200)}};
  add_surfaces(wall, 2, {}, lattice);
  constexpr double kReach = 30;
  const std::vector<float> light =
      mean_arriving_light(lattice, directions_of_sphere(64), {1, 1 / kReach}, 2, {});
  const Affine3 cell_from_world = lattice.world_from_cell.inverse();
  const auto at = [&](const Vec3& world) {
    const Vec3 cell = cell_from_world * world;
    const auto index = [&](int a) { return static_cast<std::int64_t>(std::lround(cell[a])); };
    return light[static_cast<std::size_t>(
        (index(2) * lattice.dims[1] + index(1)) * lattice.dims[0] + index(0))];
  };
  for (const double distance : {2.0, 5.0, 15.0}) {
    double taken = 0;  // the second exponential integral
    constexpr int kSteps = 1000;
    for (int i = 0; i < kSteps; ++i)
      taken += std::exp(-distance / (kReach * (i + 0.5) / kSteps)) / kSteps;
    EXPECT_NEAR(at({31, 31, 20 + distance}), 1 - 0.5 * taken, 0.04) << distance;
    EXPECT_NEAR(at({31, 31, 20 - distance}), 1 - 0.5 * taken, 0.04) << distance;
  }
}

// Where light is read, two cells from the surface (kEdgesAway). Fails if a surface is blotched by
// its own cells.
TEST(SurfaceExtinction, ABallDoesNotShadowItsOwnLitSide) {
  double least_key = 1, least_around = 1;
  for (const double radius : {2.0, 12.0, 25.0}) {
    const std::vector<Geometry> geometry{{ball(kLitMiddle, radius)}};
    for (const Vec3& towards : {Vec3(0, 0, 1), Vec3(0.4, -0.7, 0.5)}) {
      Look look = clear_look(towards);
      look.occlusion = 1;
      const view::LightVolume light = light_of(geometry, look);
      for (int i = 0; i < 400; ++i) {
        const double z = 1 - 2 * (i + 0.5) / 400, turn = 2.39996 * i;
        const double rest = std::sqrt(1 - z * z);
        const Vec3 normal(rest * std::cos(turn), rest * std::sin(turn), z);
        const view::ArrivingLight arriving =
            light.arriving_at(kLitMiddle + radius * normal, normal, normal, 1, view::kEdgesAway);
        least_around = std::min(least_around, arriving.around);
        const double cosine = normal.dot(towards.normalized());
        if (cosine > 0.1) least_key = std::min(least_key, arriving.key);
        if (cosine > 0.5) EXPECT_GT(arriving.key, 0.98) << radius << ' ' << cosine;
      }
    }
  }
  std::printf("on balls: key at least %.3f, around %.3f\n", least_key, least_around);
  EXPECT_GT(least_key, 0.92);
  EXPECT_GT(least_around, 0.99);
}

// The field's box is 64 long, so that it grows by at most 32 to each side.
TEST(SurfaceExtinction, TheBoxGrowsForWhatIsNear) {
  const Look look = clear_look({0, 0, 1});
  const auto with = [&](double z) {
    return light_of({{plate({31.5, 31.5, z}, {0, 0, 1}, 8)}}, look);
  };
  const view::LightVolume none = light_of({}, look);
  EXPECT_EQ(with(40).dims, none.dims);
  const view::LightVolume near = with(80);
  EXPECT_GT(near.dims[2], none.dims[2]);
  EXPECT_EQ(near.dims[0], none.dims[0]);
  EXPECT_LT(near.at({31.5, 31.5, 30}).key, 0.03);
  EXPECT_EQ(near.at({12, 31.5, 30}).key, 1);
  const view::LightVolume far = with(200);
  EXPECT_EQ(far.packed, none.packed);
  // A floor as wide as can be: what is beyond is light.
  const view::LightVolume floor = light_of({{plate({31.5, 31.5, -4}, {0, 0, 1}, 1000)}}, look);
  EXPECT_LE(floor.dims[0], 2 * none.dims[0] + 1);
  EXPECT_LT(floor.at({31.5, 31.5, -8}).key, 0.03);
  EXPECT_EQ(floor.at({200, 31.5, -8}).key, 1);
}

// Surfaces do not change how far light from everywhere goes.
TEST(SurfaceExtinction, WhatIsFarFromASurfaceStaysAsItIs) {
  Look look = clear_look({0, 0, 1});
  look.transfer_function.opacities = {{0, 0.05}};
  look.occlusion = 1;
  const view::LightVolume none = light_of({}, look);
  const view::LightVolume with = light_of({{ball({31.5, 31.5, 80}, 1)}}, look);
  EXPECT_NEAR(with.at(kLitMiddle).around, none.at(kLitMiddle).around, 2e-3);
}

TEST(SurfaceExtinction, CellsLargerThanTheBudgetAreNotAdded) {
  ExtinctionLattice lattice;
  lattice.dims = {128, 128, 128};
  lattice.extinction.assign(std::size_t{128} * 128 * 128, 0.0F);
  const std::vector<Geometry> all{{plate({64, 64, -40}, {0, 0, 1}, 300)}};
  const GrownSides sides = add_surfaces(all, 2, {}, lattice);
  EXPECT_LE(lattice.dims[0] * lattice.dims[1] * lattice.dims[2], kMostCellsWithSurfaces);
  EXPECT_GT(sides.before[0], 0);
  EXPECT_TRUE(sides.is_cut_before[0] && sides.is_cut_behind[1]);
  EXPECT_FALSE(sides.is_cut_behind[2]);
}

TEST(SurfaceExtinction, DoesNotDependOnThreads) {
  const std::vector<Geometry> geometry{{ball({20, 31, 36}, 11)},
                                       {plate(kLitMiddle, {1, 2, 3}, 15), {1, 1, 1}, 0.4},
                                       {tube({5, 9, 11}, {50, 60, 55}, 0.4)}};
  Look look = clear_look({0.3, 0.4, 1});
  look.occlusion = look.scatter = 1;
  EXPECT_EQ(light_of(geometry, look, clear_field(), 1).packed,
            light_of(geometry, look, clear_field(), 3).packed);
}

TEST(SurfaceExtinction, WhatHasNoValueIsNotThere) {
  Surface surface = *plate(kLitMiddle, {0, 0, 1}, 20);
  for (Surface::Triangle& triangle : surface.triangles) triangle.values[1] = std::nanf("");
  const Geometry geometry{std::make_shared<const Surface>(surface)};
  EXPECT_EQ(light_of({geometry}, clear_look({0, 0, 1})).packed,
            light_of({}, clear_look({0, 0, 1})).packed);
}

// Fails if a surface that is moved, hidden or more opaque leaves its old light.
TEST(SurfaceExtinction, LightFollowsTheSurfaces) {
  const Field field = clear_field();
  const Look look = clear_look({0, 0, 1});
  LightVolumes lights;
  const auto light = [&](const std::vector<Geometry>& geometry, const Vec3& at) {
    return lights.at({field, look, {}, {}, {}, nullptr, geometry}, 2, {})->at(at).key;
  };
  const Vec3 below(31.5, 31.5, 20);
  Geometry one{plate(kLitMiddle, {0, 0, 1}, 20)};
  EXPECT_LT(light({one}, below), 0.03);
  one.opacity = 0.5;
  EXPECT_NEAR(light({one}, below), 0.5, 0.03);
  EXPECT_EQ(light({}, below), 1);
  one.opacity = 1;
  for (const double x : {-20.0, 31.5, 90.0}) {  // the one before is gone, its memory is used again
    one.surface = nullptr;
    one.surface = plate({x, 31.5, 40}, {0, 0, 1}, 20);
    EXPECT_EQ(light({one}, below) < 0.03, x == 31.5) << x;
  }
  Look dark = look;
  dark.shadows = 0;
  EXPECT_EQ(lights.at({field, dark, {}, {}, {}, nullptr, std::span(&one, 1)}, 2, {}), nullptr);
}

}  // namespace surface_extinction_test
}  // namespace ovoid
