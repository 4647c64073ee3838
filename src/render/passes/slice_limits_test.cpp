// SPDX-License-Identifier: Apache-2.0
// What slices show beside values: their outline, and labels. Fails if lines are not where something
// ends or not as wide as said, or if a label's colour is where the label is not.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "model/own_array.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "ovoid/renderer.h"
#include "support/compare.h"
#include "support/scenes.h"

namespace ovoid {
namespace slice_limits_test {

using test::pixel;

constexpr int kSliceSide = 96;  // pixels, four of them per unit of the world
constexpr Rgb kLineColor{0, 1, 0};

// The value 1 in [-8, 8]^3.
LatticeField even_field() {
  Dataset dataset;
  dataset.lattice.dims = {16, 16, 16};
  dataset.lattice.world_from_index = Affine3(Eigen::Translation3d(-7.5, -7.5, -7.5));
  dataset.arrays = {model::array_of_numbers("v", 1, std::vector<float>(16 * 16 * 16, 1.0F))};
  return make_lattice_field(dataset);
}

// Label 1 where x < 0, 2 elsewhere, but nothing where y > 4; on the samples of the field.
LabelSurfaces halves() {
  Dataset dataset;
  dataset.lattice.dims = {16, 16, 16};
  dataset.lattice.world_from_index = Affine3(Eigen::Translation3d(-7.5, -7.5, -7.5));
  std::vector<float> values;
  for (int i = 0; i < 16 * 16 * 16; ++i)
    values.push_back(i / 16 % 16 >= 12 ? 0.0F : i % 16 < 8 ? 1.0F : 2.0F);
  dataset.arrays = {model::array_of_numbers("labels", 1, std::move(values))};
  LatticeModelOptions options;
  options.kernel = kLabelKernel;
  LabelSurfaces labels;
  labels.map = make_label_map(make_lattice_field(dataset, options), 1);
  labels.styles = {{.label = 1, .name = {}, .color = {1, 0, 0}},
                   {.label = 2, .name = {}, .color = {0, 0, 1}}};
  labels.shows_surfaces = false;
  return labels;
}

// Black, seen from -z with y down.
FieldSlice black_slice() {
  FieldSlice slice;
  slice.colors.colors = {{0, {0, 0, 0}}};
  return slice;
}

Image sliced(const FieldSlice& slice, const LabelSurfaces& labels, int threads = 1) {
  RenderOptions options;
  options.width = options.height = kSliceSide;
  Look look = test::uniform_look(0);
  look.shade = false;
  Scene scene(even_field(), look);
  scene.slices = {slice};
  scene.labels = labels;
  return Renderer(Backend::kCpu, threads)
      .render(scene, test::parallel_camera({0, 0, 0}, {0, 0, 1}, 12, 40), options)
      .image;
}

// How many pixels of a row or column one channel covers.
double covered(const Image& image, std::size_t channel, int row, int from, int to) {
  double sum = 0;
  for (int x = from; x < to; ++x) sum += static_cast<double>(pixel(image, x, row).rgba[channel]);
  return sum;
}

double color_in(const test::Pixel& pixel) { return pixel.r() + pixel.g() + pixel.b(); }

TEST(SliceOutlines, LieWhereTheFieldEnds) {
  FieldSlice slice = black_slice();
  slice.outline = kLineColor;
  const Image image = sliced(slice, {});
  // The field is in pixels 16 to 80; lines are one and a half wide.
  EXPECT_NEAR(covered(image, 1, 48, 0, 48), 1.5, 0.15);
  EXPECT_NEAR(covered(image, 1, 48, 48, 96), 1.5, 0.15);
  EXPECT_GT(pixel(image, 16, 48).g(), 0.9);
  EXPECT_EQ(pixel(image, 13, 48).a(), 0);
  EXPECT_EQ(pixel(image, 20, 48).g(), 0);
  EXPECT_EQ(pixel(image, 20, 48).a(), 1);
  EXPECT_GT(pixel(image, 48, 16).g(), 0.9);  // above, and below
  EXPECT_GT(pixel(image, 48, 79).g(), 0.9);
  EXPECT_EQ(pixel(image, 8, 8).a(), 0);  // none goes on beyond a corner
  slice.outline.reset();
  EXPECT_EQ(covered(sliced(slice, {}), 1, 48, 0, 96), 0);
}

TEST(SliceOutlines, OfObliquePlanesFollowTheBox) {
  FieldSlice slice = black_slice();
  slice.normal = {0, 1, 1};  // y from -8 to 8, as z leaves the box there
  slice.outline = kLineColor;
  const Image image = sliced(slice, {});
  EXPECT_NEAR(covered(image, 1, 48, 0, 48), 1.5, 0.15);
  EXPECT_GT(pixel(image, 48, 16).g(), 0.9);
  EXPECT_EQ(pixel(image, 48, 48).g(), 0);
}

TEST(SliceLabels, LinesLieWithinTheirLabels) {
  const LabelSurfaces labels = halves();
  const Image image = sliced(black_slice(), labels);
  double of_one = 0, of_two = 0;
  for (int x = 20; x < 76; ++x) {
    of_one += pixel(image, x, 36).r();
    of_two += pixel(image, x, 36).b();
  }
  EXPECT_NEAR(of_one, 1.5, 0.5);
  EXPECT_NEAR(of_two, 1.5, 0.5);
  const bool is_one_on_the_left = pixel(image, 47, 36).r() > 0.5;
  for (int x = 20; x < 76; ++x) {
    const bool is_of_one = (x < 48) == is_one_on_the_left;
    EXPECT_EQ(pixel(image, x, 36).rgba[is_of_one ? 2 : 0], 0) << x;
  }
  // Where they end at y = 4, pixel 64 from above, each has its line, and the slice is as it was.
  for (const int x : {30, 66}) {
    const bool is_of_one = (x < 48) == is_one_on_the_left;
    EXPECT_GT(pixel(image, x, 63).rgba[is_of_one ? 0 : 2], 0.9F) << x;
    EXPECT_EQ(color_in(pixel(image, x, 67)), 0) << x;
    EXPECT_EQ(color_in(pixel(image, x, 56)), 0) << x;
    EXPECT_EQ(pixel(image, x, 56).a(), 1) << x;
  }
}

TEST(SliceLabels, AreasCoverTheirLabels) {
  LabelSurfaces labels = halves();
  labels.slice_lines = 0;
  labels.slice_areas = 0.25;
  const Image image = sliced(black_slice(), labels);
  EXPECT_NEAR(color_in(pixel(image, 30, 36)), 0.25, 1e-6);
  EXPECT_NEAR(color_in(pixel(image, 47, 36)), 0.25, 1e-6);
  EXPECT_EQ(color_in(pixel(image, 30, 67)), 0);
  labels.styles[0].opacity = labels.styles[1].opacity = 0;  // hidden
  EXPECT_EQ(color_in(pixel(sliced(black_slice(), labels), 30, 36)), 0);
}

TEST(SliceLabels, ShowWhereASliceIsSeeThroughAndFadeWithIt) {
  LabelSurfaces labels = halves();
  labels.slice_areas = 1;
  FieldSlice slice = black_slice();
  slice.colors.opacities = {{0, 0}};
  slice.opacity = 0.5;
  const Image image = sliced(slice, labels);
  EXPECT_NEAR(pixel(image, 30, 36).a(), 0.5, 1e-6);
  EXPECT_NEAR(color_in(pixel(image, 30, 36)), 0.5, 1e-6);
  EXPECT_EQ(pixel(image, 30, 67).a(), 0);
}

TEST(SliceLabels, ThreadsLeaveNoTrace) {
  LabelSurfaces labels = halves();
  labels.slice_areas = 0.3;
  EXPECT_EQ(sliced(black_slice(), labels, 1).rgba, sliced(black_slice(), labels, 5).rgba);
}

// Without a slice flat labels are not there, but where they say so the field is not either.
TEST(SliceLabels, FlatOnesHaveNoSurfaces) {
  LabelSurfaces labels = halves();
  RenderOptions options;
  options.width = options.height = kSliceSide;
  Look look = test::uniform_look(0.1);
  look.shade = false;
  const auto camera = test::parallel_camera({0, 0, 0}, {0, 0, 1}, 12, 40);
  Renderer renderer(Backend::kCpu, 1);
  const auto drawn = [&] {
    Scene scene(even_field(), look);
    scene.labels = labels;
    return renderer.render(scene, camera, options).image;
  };
  EXPECT_EQ(drawn().rgba, renderer.render({even_field(), look}, camera, options).image.rgba);
  labels.styles[0].shows_field = labels.styles[1].shows_field = false;
  EXPECT_EQ(pixel(drawn(), 30, 36).a(), 0);
  EXPECT_GT(pixel(drawn(), 30, 72).a(), 0);
}

TEST(SliceLabels, RefuseImpossibleOpacities) {
  LabelSurfaces labels = halves();
  for (const double bad : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    labels.slice_lines = bad;
    EXPECT_THROW(sliced(black_slice(), labels), Error);
    labels.slice_lines = 1;
    labels.slice_areas = bad;
    EXPECT_THROW(sliced(black_slice(), labels), Error);
    labels.slice_areas = 0;
    FieldSlice slice = black_slice();
    slice.outline = Rgb{0, bad, 0};
    EXPECT_THROW(slice.validate(), Error);
  }
}

}  // namespace slice_limits_test
}  // namespace ovoid
