// SPDX-License-Identifier: Apache-2.0
// The light of docs/numerics.md, "Light from a coarse volume", against closed forms and against the
// same model worked out at single places of the field itself, by random rays.
#include "render/light/light_volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "ovoid/error.h"
#include "render/light/light_sweep.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"
#include "support/thread_team.h"
#include "support/volumes.h"
#include "support/where.h"

namespace ovoid {
namespace light_volume_test {

constexpr double kOpacity = 0.05;  // of the uniform medium, per spacing
constexpr int kEdge = 96;

Look lit_look() {
  Look look = test::uniform_look(kOpacity);
  look.shade = true;
  look.unit_distance = 1;
  look.light_direction = Vec3(0, 0, 1);
  return look;
}

view::ArrivingLight light_at(const Field& field, const Look& look, const Vec3& world,
                             const std::vector<ClipPlane>& planes = {}) {
  LightVolumes lights;
  return lights.at({field, look, planes}, 2, {})->at(world);
}

// Smooth clouds in a box of kEdge samples, values in [0, 1].
double clouds(const Vec3& at) {
  double sum = 0;
  for (const auto& [center, radius] : {std::pair{Vec3(40, 45, 50), 18.0},
                                       {Vec3(60, 40, 40), 12.0},
                                       {Vec3(55, 62, 60), 14.0},
                                       {Vec3(30, 60, 30), 10.0}}) {
    sum += std::exp(-0.5 * (at - center).squaredNorm() / (0.3 * radius * radius));
  }
  return std::min(sum, 1.0);
}

Field cloud_field() {
  return test::make_field(
      {kEdge, kEdge, kEdge}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        return clouds(Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)));
      });
}

Look cloud_look() {
  Look look = lit_look();
  look.transfer_function.opacities = {{0, 0}, {0.1, 0}, {1, 0.6}};
  look.light_direction = Vec3(0.5, 0.3, 0.8);
  return look;
}

// Random numbers that are the same everywhere.
class Dice {
 public:
  double operator()() { return static_cast<double>(engine_()) * 0x1p-64; }
  Vec3 direction() {
    const double z = 2 * (*this)() - 1;
    const double turn = 2 * M_PI * (*this)();
    const double radius = std::sqrt(1 - z * z);
    return {radius * std::cos(turn), radius * std::sin(turn), z};
  }

 private:
  std::mt19937_64 engine_{20260101};
};

// What goes through the field from `at` on, without the cell around it. `distance`: as far as that.
double transmittance(const Look& look, const Vec3& at, const Vec3& towards, double cell,
                     double distance, double share_of_extinction) {
  constexpr double kStep = 0.5;
  const double first = 0.5 * cell / towards.cwiseAbs().maxCoeff();
  double depth = 0;
  for (double s = 0; s < distance && depth < 12; s += kStep) {
    const double step = std::min(kStep, distance - s);
    const Vec3 place = at + (first + s + 0.5 * step) * towards;
    if ((place.array() < -0.5).any() || (place.array() > kEdge - 0.5).any()) break;
    depth += step * share_of_extinction * extinction_of(look, clouds(place));
  }
  return std::exp(-depth);
}

double decibels(double sum_of_squares, int count) {
  return -10 * std::log10(sum_of_squares / count);
}

// Fails if regained light, the mean over directions or the factor 2 is off.
TEST(LightVolume, UniformMediumIsWithinTwoPerCent) {
  const Field field = test::constant_field({128, 128, 128}, 1);
  Look look = lit_look();
  look.occlusion = 1;
  const double reach = kReachOfDiagonal * std::sqrt(3.0) * 128;
  for (const double opacity : {0.05, 0.1, 0.3}) {
    look.transfer_function.opacities = {{1, opacity}};
    const double extinction = -std::log1p(-opacity);
    const double expected = std::min(1.0, 2 / (1 + extinction * reach));
    EXPECT_NEAR(light_at(field, look, Vec3(64, 64, 64)).around, expected, 0.02 * expected);
  }
}

// Fails if the key's light is counted from elsewhere than the cell's side.
TEST(LightVolume, KeyFallsOffAsInAUniformSlab) {
  const Field field = test::constant_field({64, 64, 64}, 1);
  Look look = lit_look();
  look.shadows = 1;
  const double extinction = -std::log1p(-kOpacity);
  for (const double depth : {4.0, 10.0, 20.0}) {
    // The upper face is at 63.5, cells are a spacing long.
    const Vec3 place(32, 32, 63 - std::round(depth));
    const double expected = std::exp(-extinction * std::round(depth));
    EXPECT_NEAR(light_at(field, look, place).key, expected, 0.02 * expected);
  }
}

// Fails if the coarse cells, the directions or the sweeps say something else than the model does.
TEST(LightVolume, IsNearToRandomRaysThroughTheFieldItself) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  const Field field = cloud_field();
  Look look = cloud_look();
  look.occlusion = look.shadows = look.scatter = 1;
  LightVolumes lights;
  const view::LightVolume& volume = *lights.at({field, look, {}}, 2, {});
  const double cell = volume.cell_edge;
  const double reach = kReachOfDiagonal * std::sqrt(3.0) * kEdge;
  const Vec3 towards = look.light_direction->normalized();
  Dice dice;
  double around_squares = 0, key_squares = 0;
  constexpr int kPlaces = 80;
  for (int n = 0; n < kPlaces;) {
    const Vec3 place(20 + 56 * dice(), 20 + 56 * dice(), 20 + 56 * dice());
    if (clouds(place) < 0.05) continue;  // nobody sees it
    ++n;
    double around = 0, scattered = 0;
    constexpr int kRays = 10000;  // noise under 41 dB
    for (int ray = 0; ray < kRays; ++ray) {
      const double distance = -reach * std::log1p(-dice());
      around += transmittance(look, place, dice.direction(), cell, distance, 1) / kRays;
    }
    constexpr int kConeRays = 2000;
    for (int ray = 0; ray < kConeRays;) {
      const Vec3 direction = dice.direction();
      if (direction.dot(towards) < std::cos(kScatterAngle)) continue;
      ++ray;
      scattered += transmittance(look, place, direction, cell, 1e9, kScatterExtinction) / kConeRays;
    }
    const double key = transmittance(look, place, towards, cell, 1e9, 1);
    const view::ArrivingLight light = volume.at(place);
    around_squares += std::pow(light.around - std::min(1.0, 2 * around), 2);
    key_squares += std::pow(light.key - (1 - (1 - key) * (1 - scattered)), 2);
  }
  RecordProperty("around_db", std::to_string(decibels(around_squares, kPlaces)));
  RecordProperty("key_db", std::to_string(decibels(key_squares, kPlaces)));
  std::printf("light around %.1f dB, key %.1f dB\n", decibels(around_squares, kPlaces),
              decibels(key_squares, kPlaces));
  EXPECT_GE(decibels(around_squares, kPlaces), 35);
  EXPECT_GE(decibels(key_squares, kPlaces), 35);
}

// Fails if threads share a sum.
TEST(LightVolume, DoesNotDependOnThreads) {
  Look look = cloud_look();
  look.occlusion = look.shadows = look.scatter = 1;
  for (const Field& field : {cloud_field(), Field(KernelField(test::jittered_ellipsoids(9).source(),
                                                              Reconstruction::kNormalized))}) {
    LightVolumes one, three;
    EXPECT_EQ(one.at({field, look, {}}, 1, {})->packed, three.at({field, look, {}}, 3, {})->packed);
  }
}

// Fails if what is cut away still takes light.
TEST(LightVolume, WhatIsCutAwayCastsNoShadow) {
  const Field field = test::constant_field({64, 64, 64}, 1);
  Look look = lit_look();
  look.transfer_function.opacities = {{1, 0.9}};
  look.shadows = look.occlusion = 1;
  EXPECT_LT(light_at(field, look, Vec3(32, 32, 30)).key, 0.01);
  const std::vector<ClipPlane> lower_half = {{Vec3(0, 0, -1), -32}};
  const view::ArrivingLight light = light_at(field, look, Vec3(32, 32, 33), lower_half);
  EXPECT_GT(light.key, 0.95);
  EXPECT_GT(light.around, 0.9);
}

// Fails if a set of kernels absorbs otherwise than the lattice that it stands for.
TEST(LightVolume, KernelsAbsorbAsTheirLatticeDoes) {
  test::KernelNumbers balls = test::lattice_balls(24, 4);
  for (std::size_t i = 0; i < balls.values[0].size(); ++i) {
    const Vec3 at(balls.centers[3 * i], balls.centers[3 * i + 1], balls.centers[3 * i + 2]);
    balls.values[0][i] = static_cast<float>(clouds(at * 4));
  }
  const Field set = KernelField(balls.source(), Reconstruction::kNormalized);
  const Field lattice = test::make_field({24, 24, 24}, [](std::int64_t i, std::int64_t j,
                                                          std::int64_t k) {
    return clouds(4 * Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)));
  });
  Look look = cloud_look();
  look.occlusion = look.shadows = 1;
  for (const Vec3& place : {Vec3(10, 11, 12), Vec3(14, 10, 9), Vec3(8, 14, 8)}) {
    const view::ArrivingLight a = light_at(set, look, place);
    const view::ArrivingLight b = light_at(lattice, look, place);
    EXPECT_NEAR(a.around, b.around, 0.08);
    EXPECT_NEAR(a.key, b.key, 0.08);
  }
}

// Fails if light jumps where the direction passes from one axis of the sweeps to another.
TEST(LightVolume, TurningTheLightByADegreeChangesLittle) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  const Field field = cloud_field();
  Look look = cloud_look();
  look.shadows = look.scatter = 1;
  LightVolumes lights;
  std::vector<float> before;
  for (int degree = 0; degree <= 90; degree += 1) {
    const double angle = degree * M_PI / 180;
    look.light_direction = Vec3(std::cos(angle), 0.2, std::sin(angle));
    const std::vector<float>& packed = lights.at({field, look, {}}, 2, {})->packed;
    double squares = 0;
    for (std::size_t i = 0; i < before.size(); ++i)
      squares +=
          std::pow(view::unpacked_light(packed[i]).key - view::unpacked_light(before[i]).key, 2);
    if (!before.empty()) {
      EXPECT_GE(decibels(squares, static_cast<int>(before.size())), 34) << degree;
    }
    before = packed;
  }
}

// Fails if the volume stays while what it is made of changes, or is made for looks without light.
TEST(LightVolume, FollowsTheLook) {
  const Field field = cloud_field();
  Look look = cloud_look();
  LightVolumes lights;
  EXPECT_EQ(lights.at({field, look, {}}, 2, {}), nullptr);
  look.occlusion = 1;
  const std::vector<float> whole = lights.at({field, look, {}}, 2, {})->packed;
  look.occlusion = 0.5;
  EXPECT_NE(lights.at({field, look, {}}, 2, {})->packed, whole);
  look.occlusion = 1;
  EXPECT_EQ(lights.at({field, look, {}}, 2, {})->packed, whole);
  look.transfer_function.opacities.back().opacity = 0.9;
  EXPECT_NE(lights.at({field, look, {}}, 2, {})->packed, whole);
  look.mode = Mode::kMaximum;
  EXPECT_EQ(lights.at({field, look, {}}, 2, {}), nullptr);
}

// Fails if a stopped frame does not stop here.
TEST(LightVolume, CanBeStopped) {
  std::stop_source stop;
  stop.request_stop();
  Look look = cloud_look();
  look.occlusion = 1;
  LightVolumes lights;
  try {
    lights.at({cloud_field(), look, {}}, 2, stop.get_token());
    FAIL() << "went on";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCancelled);
  }
}

// Of further volumes extinctions are added. Fails if one is left out, put elsewhere, or cut off
// where it reaches beyond the first.
TEST(LightVolume, IsOfAllVolumes) {
  const LatticeField box = test::constant_field({32, 32, 32}, 1);
  const Vec3 middle(15.5, 15.5, 15.5);
  Look look = lit_look();
  look.occlusion = 0.8;
  look.shadows = 1;
  look.light_direction = Vec3(1, 0, 0);
  const auto light_of = [&](double opacity, const std::vector<FurtherVolume>& further) {
    Look own = look;
    own.transfer_function.opacities = {{0, opacity}};
    const Field field = box;
    LightVolumes lights;
    return lights.at({field, own, {}, further}, 2, {})->at(middle);
  };
  const auto thin = [&](const LatticeField& field, double opacity) {
    FurtherVolume volume{field, look};
    volume.look.transfer_function.opacities = {{0, opacity}};
    return volume;
  };
  const view::ArrivingLight whole = light_of(1 - 0.95 * 0.95, {});
  const view::ArrivingLight halves = light_of(0.05, {thin(box, 0.05)});
  EXPECT_NEAR(halves.around, whole.around, 2e-3);
  EXPECT_NEAR(halves.key, whole.key, 2e-3);
  // One that lies towards the light, beside the first, hides more of it; one behind hides none.
  const view::ArrivingLight alone = light_of(0.05, {});
  test::FieldSetup beside;
  beside.world_from_index = test::scaled_axes(Vec3(1, 1, 1), Vec3(32, 0, 0));
  const view::ArrivingLight hidden =
      light_of(0.05, {thin(test::constant_field({32, 32, 32}, 1, beside), 0.05)});
  EXPECT_NEAR(hidden.key, alone.key * std::pow(0.95, 32), 0.03);
  beside.world_from_index = test::scaled_axes(Vec3(1, 1, 1), Vec3(-32, 0, 0));
  const view::ArrivingLight behind =
      light_of(0.05, {thin(test::constant_field({32, 32, 32}, 1, beside), 0.05)});
  EXPECT_NEAR(behind.key, alone.key, 2e-3);
}

// To the bit that of one process; each makes some slabs, or where there are few, none.
TEST(LightVolume, ATeamMakesItTogether) {
  const KernelField kernels(test::jittered_ellipsoids(9).source(), Reconstruction::kNormalized);
  const KernelField sum(test::jittered_balls(7).source(), Reconstruction::kSum);
  for (const Field& field : {cloud_field(), Field(kernels), Field(sum)}) {
    Look look = cloud_look();
    look.occlusion = look.shadows = 1;
    LightVolumes lights;
    const view::LightVolume alone = *lights.at({field, look, {}}, 2, {});
    for (const int count : {2, 3, 40}) {
      testing::Room room(count);
      const auto together =
          testing::run_as_team(room, [&](const std::shared_ptr<KernelTeam>& team) {
            LightVolumes own;
            return *own.at({field, look, {}}, 1, {}, team.get());
          });
      for (const view::LightVolume& volume : together) {
        EXPECT_EQ(volume.dims, alone.dims);
        EXPECT_TRUE(volume.packed == alone.packed) << count << " processes";
      }
    }
  }
}

// Fails if a place that is no number, as of a surface's corner out of all sight, is looked up.
TEST(LightVolume, PlacesThatAreNone) {
  view::LightVolume volume;
  volume.dims = {2, 3, 4};
  volume.packed.assign(24, view::packed_light({0.5, 1}));
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  constexpr double kFar = std::numeric_limits<double>::infinity();
  for (const double x : {kNone, kFar, -kFar, 1e300})
    EXPECT_NEAR(volume.at(Vec3(x, 1, x)).around, 0.5, 2e-4) << x;
}

}  // namespace light_volume_test
}  // namespace ovoid
