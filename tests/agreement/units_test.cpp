// SPDX-License-Identifier: Apache-2.0
// Lengths of galaxies in centimetres, of molecules in metres; densities in grams per cubic
// centimetre. A field means the same in any unit, and its picture is the same.
#include <gtest/gtest.h>

#include <cmath>

#include "support/agreement.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace units_test {

struct Units {
  std::string name;
  double length, value;
};

const std::vector<Units>& units() {
  static const std::vector<Units> all = {{"galaxies", 0x1p72, 0x1p-96},   // 5e21, 1e-29
                                         {"molecules", 0x1p-32, 0x1p80},  // 2e-10, 1e24
                                         {"great values", 1, 0x1p124},    // 2e37
                                         {"small values", 1, 0x1p-104}};  // 5e-32
  return all;
}

Look scaled(Look look, const Units& unit) {
  for (ColorPoint& point : look.transfer_function.colors) point.x *= unit.value;
  for (OpacityPoint& point : look.transfer_function.opacities) point.x *= unit.value;
  for (OpacityPoint& point : look.transfer_function.gradient_opacities)
    point.x *= unit.value / unit.length;
  look.isovalue *= unit.value;
  return look;
}

// Lit, by light alone or with opacities that follow the gradient, and a lit surface.
std::vector<TestLook> lit_looks() {
  Look faded = semi_transparent_look(0, 1);
  faded.transfer_function.gradient_opacities = {{0, 0}, {3, 1}};
  Look surface = semi_transparent_look(0, 1);
  surface.mode = Mode::kIsosurface;
  surface.isovalue = 0.55;
  return {{"ramp", semi_transparent_look(0, 1)}, {"faded", faded}, {"surface", surface}};
}

// The back end's picture of the field in these units is the reference's of the same field in units
// of 1.
void expect_same(const Field& field, const Field& in_units, const Units& unit,
                 const std::string& name) {
  for (const TestLook& look : lit_looks()) {
    for (const bool is_parallel : {true, false}) {
      TestScene scene{field, askew_camera(field, is_parallel, 1.2), look.look, picture(40, 36)};
      scene.options.post_convolution = PostConvolution::kOff;
      Image expected = draw(scene, Backend::kReference).image;
      for (float& depth : expected.depth) depth *= static_cast<float>(unit.length);
      for (float& depth : expected.front_depth) depth *= static_cast<float>(unit.length);
      TestScene other{in_units, askew_camera(in_units, is_parallel, 1.2), scaled(look.look, unit),
                      scene.options};
      const std::string what = name + ", " + unit.name + ", " + look.name;
      EXPECT_TRUE(backends_agree(other, what));
      EXPECT_TRUE(agrees_with(expected, other, what + ", in units of 1"));
    }
  }
}

TEST(Units, OfSetsChangeNoPicture) {
  OVOID_NIGHTLY_ON_DEVICE();
  OVOID_NOT_UNDER_ASAN();
  for (const KernelNumbers& numbers : {jittered_ellipsoids(6), jittered_balls(6)}) {
    const KernelField field(numbers.source(), Reconstruction::kNormalized);
    for (const Units& unit : units()) {
      KernelNumbers other = numbers;
      for (double& x : other.centers) x *= unit.length;
      for (float& x : other.shapes) x *= static_cast<float>(unit.length);
      for (float& x : other.values[0]) x *= static_cast<float>(unit.value);
      expect_same(field, KernelField(other.source(), Reconstruction::kNormalized), unit,
                  numbers.shape == KernelShape::kBalls ? "balls" : "ellipsoids");
    }
  }
}

TEST(Units, OfLatticesChangeNoPicture) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const Index3 dims{11, 12, 10};
  FieldSetup setup;
  setup.world_from_index = oblique_axes();
  const LatticeField field = make_field(dims, shells(dims), setup);
  for (const Units& unit : units()) {
    FieldSetup other;
    other.world_from_index = Eigen::Scaling(unit.length) * setup.world_from_index;
    const VolumeFunction same = shells(dims);
    expect_same(field,
                make_field(
                    dims, [&](auto... at) { return unit.value * same(at...); }, other),
                unit, "lattice");
  }
}

TEST(Units, OfSetsChangeNoSample) {
  OVOID_NIGHTLY_ON_DEVICE();
  OVOID_NOT_UNDER_ASAN();
  const KernelNumbers numbers = jittered_balls(6);
  const KernelSampler sampler(KernelField(numbers.source(), Reconstruction::kNormalized));
  for (const Units& unit : units()) {
    KernelNumbers other = numbers;
    for (double& x : other.centers) x *= unit.length;
    for (float& x : other.shapes) x *= static_cast<float>(unit.length);
    for (float& x : other.values[0]) x *= static_cast<float>(unit.value);
    const KernelSampler in_units(KernelField(other.source(), Reconstruction::kNormalized));
    for (const Vec3& at : {Vec3(0.5, 0.5, 0.5), Vec3(0.21, 0.7, 0.43), Vec3(0.02, 0.98, 0.6)}) {
      const KernelSample expected = sampler.at(at);
      const KernelSample sample = in_units.at(unit.length * at);
      EXPECT_NEAR(sample.weight, expected.weight, 1e-6) << unit.name;
      EXPECT_NEAR(sample.value / unit.value, expected.value, 1e-6) << unit.name;
    }
  }
}

}  // namespace units_test
}  // namespace ovoid::test
