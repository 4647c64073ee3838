// SPDX-License-Identifier: Apache-2.0
// Pictures of labels: whose colours are seen where, alone and with a field. Fails if a pixel has
// the colour of a label that is not there, if a label hides what is before it, or if the field is
// drawn where labels say that it is not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "model/own_array.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "ovoid/renderer.h"
#include "support/compare.h"
#include "support/scenes.h"

namespace ovoid {
namespace label_limits_test {

using test::parallel_camera;
using test::pixel;

constexpr int kLabelSide = 96;  // pixels

// Labels 1 and 5 side by side along x, each a box, in samples -12 to 11 of the world, and a ball of
// 3 far from both.
LatticeField box_labels() {
  Dataset dataset;
  dataset.lattice.dims = {24, 24, 24};
  dataset.lattice.world_from_index = Affine3(Eigen::Translation3d(-11.5, -11.5, -11.5));
  std::vector<float> values;
  for (int k = 0; k < 24; ++k) {
    for (int j = 0; j < 24; ++j) {
      for (int i = 0; i < 24; ++i) {
        const bool is_in_boxes = i >= 3 && i < 21 && j >= 10 && j < 21 && k >= 4 && k < 20;
        const bool is_in_ball = std::hypot(i - 12, j - 4, k - 12) < 3;
        values.push_back(is_in_boxes ? (i < 12 ? 1.0F : 5.0F) : is_in_ball ? 3.0F : 0.0F);
      }
    }
  }
  dataset.arrays = {model::array_of_numbers("labels", 1, std::move(values))};
  LatticeModelOptions options;
  options.kernel = kLabelKernel;
  return make_lattice_field(dataset, options);
}

// The value 1 where the labels are.
LatticeField haze_field() {
  Dataset dataset;
  dataset.lattice.dims = {24, 24, 24};
  dataset.lattice.world_from_index = Affine3(Eigen::Translation3d(-11.5, -11.5, -11.5));
  dataset.arrays = {model::array_of_numbers("v", 1, std::vector<float>(24 * 24 * 24, 1.0F))};
  return make_lattice_field(dataset);
}

LabelSurfaces box_surfaces() {
  LabelSurfaces surfaces;
  surfaces.map = make_label_map(box_labels(), 1);
  surfaces.styles = {{.label = 1, .color = {1, 0, 0}},
                     {.label = 3, .color = {0, 1, 0}},
                     {.label = 5, .color = {0, 0, 1}}};
  return surfaces;
}

void hide_field(LabelSurfaces& surfaces) {
  surfaces.shows_field_elsewhere = false;
  for (LabelStyle& style : surfaces.styles) style.shows_field = false;
}

Look plain_look() {
  Look look = test::uniform_look(0.1, {1, 1, 1});
  look.shade = false;
  look.unit_distance = 1;
  return look;
}

RenderOptions label_picture() {
  RenderOptions options;
  options.width = options.height = kLabelSide;
  return options;
}

Image image_of(const LabelSurfaces& surfaces, const RenderOptions& options = label_picture(),
               Backend backend = Backend::kCpu, int threads = 1,
               const Camera& camera = parallel_camera({0, 0, 0}, {0, 0, 1}, 12, 40)) {
  Scene scene(haze_field(), plain_look());
  scene.labels = surfaces;
  return Renderer(backend, threads).render(scene, camera, options).image;
}

double share_of(const Image& image, std::size_t channel) {
  double sum = 0;
  for (std::size_t i = channel; i < image.rgba.size(); i += 4) sum += image.rgba[i];
  return sum / (kLabelSide * kLabelSide);
}

// Between labels 1 and 5 lies 3, whose colour alone is green; every boundary pixel is looked at.
TEST(LabelPictures, NoBoundaryPixelHasAThirdLabelsColour) {
  LabelSurfaces surfaces = box_surfaces();
  hide_field(surfaces);
  for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(0.3, -0.2, 1), Vec3(-1, 0.4, 0.6)}) {
    const Camera camera = parallel_camera({0, 4, 0}, axis, 12, 40);
    surfaces.styles[1].opacity = 0;
    const Image image = image_of(surfaces, label_picture(), Backend::kCpu, 1, camera);
    int num_seen = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
      EXPECT_EQ(image.rgba[i + 1], 0) << "pixel " << i / 4;
      // What is seen is all of the two, also where they meet.
      EXPECT_NEAR(image.rgba[i] + image.rgba[i + 2], image.rgba[i + 3], 1e-5);
      num_seen += image.rgba[i + 3] > 0.5 ? 1 : 0;
    }
    EXPECT_GT(num_seen, 1000);
  }
}

// Boxes of 9 x 11 samples each, in pixels a quarter of a sample wide, and a ball of 4 to 5 across.
TEST(LabelPictures, OutlinesCoverTheirShare) {
  LabelSurfaces surfaces = box_surfaces();
  hide_field(surfaces);
  const Image image = image_of(surfaces);
  constexpr double kPicture = 24 * 24;
  EXPECT_NEAR(share_of(image, 0), 9 * 11 / kPicture, 0.004);
  EXPECT_NEAR(share_of(image, 2), 9 * 11 / kPicture, 0.004);
  EXPECT_GT(share_of(image, 1), 3.14159 * 4 / kPicture);
  EXPECT_LT(share_of(image, 1), 3.14159 * 6.25 / kPicture);
}

TEST(LabelPictures, ThreadsAndBackEndsDrawTheSame) {
  const LabelSurfaces surfaces = box_surfaces();
  const Image one = image_of(surfaces);
  EXPECT_EQ(one.rgba, image_of(surfaces, label_picture(), Backend::kCpu, 3).rgba);
  const Image reference = image_of(surfaces, label_picture(), Backend::kReference);
  for (std::size_t i = 0; i < one.rgba.size(); ++i)
    ASSERT_NEAR(one.rgba[i], reference.rgba[i], 2e-3) << i;
}

// Haze of opacity 0.1 per unit before a label, from the map's face at -12 to the box's at -8.
TEST(LabelPictures, TheFieldBeforeALabelIsSeen) {
  const Image image = image_of(box_surfaces());
  const auto red = pixel(image, 30, 72).rgba;
  const double haze = 1 - std::pow(0.9, 4.0);
  EXPECT_NEAR(red[0], 1, 0.01);
  EXPECT_NEAR(red[1], haze, 0.01);
  EXPECT_NEAR(red[3], 1, 1e-4);
}

TEST(LabelPictures, ASeeThroughLabelHasTwoFaces) {
  LabelSurfaces surfaces = box_surfaces();
  hide_field(surfaces);
  surfaces.styles[0].opacity = 0.5;
  const auto red = pixel(image_of(surfaces), 30, 72).rgba;
  EXPECT_NEAR(red[0], 0.75, 1e-4);
  EXPECT_NEAR(red[3], 0.75, 1e-4);
}

TEST(LabelPictures, TheFieldIsDrawnWhereLabelsSay) {
  LabelSurfaces surfaces = box_surfaces();
  hide_field(surfaces);
  surfaces.styles[0].shows_field = true;
  surfaces.styles[0].opacity = 0;
  const Image inside = image_of(surfaces);
  EXPECT_NEAR(pixel(inside, 30, 72).a(), 1 - std::pow(0.9, 16.0), 0.01);
  EXPECT_EQ(pixel(inside, 48, 90).a(), 0);  // nothing but background

  surfaces.shows_field_elsewhere = true;
  surfaces.styles[0].shows_field = false;
  const Image outside = image_of(surfaces);
  EXPECT_NEAR(pixel(outside, 30, 72).a(), 1 - std::pow(0.9, 8.0), 0.01);
  EXPECT_NEAR(pixel(outside, 48, 90).a(), 1 - std::pow(0.9, 24.0), 0.01);
}

TEST(LabelPictures, AClipPlaneCutsALabelOpenInItsColour) {
  LabelSurfaces surfaces = box_surfaces();
  hide_field(surfaces);
  RenderOptions options = label_picture();
  options.clip_planes = {{Vec3(0, 0, 1), 0}};
  Look lit = plain_look();
  lit.shade = true;
  Scene scene(haze_field(), lit);
  scene.labels = surfaces;
  const Image image = Renderer(Backend::kCpu, 1)
                          .render(scene, parallel_camera({0, 0, 0}, {0.5, 0, 1}, 12, 40), options)
                          .image;
  const auto center = pixel(image, 48 - 16, 24).rgba;
  EXPECT_EQ(center[3], 1);
  EXPECT_TRUE(center[0] == 1 || center[2] == 1) << center[0] << " " << center[2];
}

TEST(LabelPictures, OtherModesAreRefused) {
  Look look = plain_look();
  look.mode = Mode::kMaximum;
  Scene scene(haze_field(), look);
  scene.labels = box_surfaces();
  EXPECT_THROW(Renderer(Backend::kCpu, 1)
                   .render(scene, parallel_camera({0, 0, 0}, {0, 0, 1}, 12, 40), label_picture()),
               Error);
}

}  // namespace label_limits_test
}  // namespace ovoid
