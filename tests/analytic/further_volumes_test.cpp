// SPDX-License-Identifier: Apache-2.0
// Two homogeneous boxes that overlap: extinctions add, and in the part that they share colours are
// mixed in proportion to their extinction (docs/numerics.md, "Several volumes").
#include <gtest/gtest.h>

#include <cmath>

#include "support/scenes.h"
#include "support/tolerances.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace further_volumes_test {

// Along z a box is 8 long; the second begins where half of the first is passed.
constexpr double kFirstBox = 0.21;  // opacities over a length of 1
constexpr double kSecondBox = 0.34;
constexpr double kBoxPart = 4;  // first alone, both, second alone

struct TwoBoxLaw {
  double red = 0, green = 0, alpha = 0;

  void pass(double opacity_red, double opacity_green) {
    const double red_depth = -kBoxPart * std::log1p(-opacity_red);
    const double green_depth = -kBoxPart * std::log1p(-opacity_green);
    const double share = (1 - alpha) * (1 - std::exp(-red_depth - green_depth));
    red += share * red_depth / (red_depth + green_depth);
    green += share * green_depth / (red_depth + green_depth);
    alpha += share;
  }
};

Image two_boxes(Backend backend, Classification classification, double distance, Sheets sheets) {
  const Index3 dims{8, 8, 8};
  FieldSetup behind;
  behind.world_from_index = scaled_axes(Vec3(1, 1, 1), Vec3(0, 0, kBoxPart));
  RenderOptions options = picture(5, 5, distance);
  options.classification = classification;
  options.sheets = sheets;
  Scene scene(constant_field(dims, 0.5), uniform_look(kFirstBox, {1, 0, 0}));
  scene.volumes.push_back({constant_field(dims, 0.7, behind), uniform_look(kSecondBox, {0, 1, 0})});
  return Renderer(backend, 1)
      .render(scene, parallel_camera({3.5, 3.5, 5.5}, {0, 0, 1}, 3), options)
      .image;
}

// Refined pieces lie across the boxes' faces here, in the middle: of such a piece half of the one
// is mixed with all of the other, though a quarter of each stands before the other.
double of_pieces(double distance) {
  return 0.25 * distance * distance * std::log1p(-kFirstBox) * std::log1p(-kSecondBox);
}

// Distances that divide the parts, so that slabs end on the boxes' faces. Fails if a colour gets
// another share, the front one more than its own, or a length is off by anything.
TEST(FurtherVolumes, TwoBoxesMixAsTheirExtinctions) {
  TwoBoxLaw law;
  law.pass(kFirstBox, 0);
  law.pass(kFirstBox, kSecondBox);
  law.pass(0, kSecondBox);
  for (const Classification classification :
       {Classification::kRefined, Classification::kSampled, Classification::kPreintegrated}) {
    for (const double distance : {1.0, 0.5, 0.25}) {
      const double bound = classification == Classification::kRefined ? of_pieces(distance) : 0;
      const Image image = two_boxes(Backend::kReference, classification, distance, Sheets::kImage);
      EXPECT_NEAR(center_pixel(image).a(), law.alpha, kFloatRelative) << distance;
      EXPECT_NEAR(center_pixel(image).r(), law.red, bound + kFloatRelative) << distance;
      EXPECT_NEAR(center_pixel(image).g(), law.green, bound + kFloatRelative) << distance;
      EXPECT_EQ(center_pixel(image).b(), 0);
    }
  }
  // The cpu's logarithms err by some 1e-6.
  for (const Sheets sheets : {Sheets::kImage, Sheets::kLattice}) {
    const Image image = two_boxes(Backend::kCpu, Classification::kRefined, 0.25, sheets);
    EXPECT_NEAR(center_pixel(image).a(), law.alpha, 2e-5);
    EXPECT_NEAR(center_pixel(image).r(), law.red, of_pieces(0.25) + 2e-5);
    EXPECT_NEAR(center_pixel(image).g(), law.green, of_pieces(0.25) + 2e-5);
  }
}

}  // namespace further_volumes_test
}  // namespace ovoid::test
