// SPDX-License-Identifier: Apache-2.0
// Maximum, minimum and mean of known rays, of thick slices, and order of compositing.
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <utility>

#include "ovoid/crop.h"
#include "ovoid/renderer.h"
#include "render/reference/reference_renderer.h"
#include "support/scenes.h"
#include "support/tolerances.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace modes_test {

using reference::render;

// One sample of 1 among zeros, sheets through the samples' planes: the greatest sample is the
// kernel over E^3 at its own centre, 1 / 1.2710^3. Fails if the maximum is of colours or opacities,
// or its opacity is corrected by a path.
TEST(Maximum, OfASingleBrightSample) {
  const LatticeField field =
      make_field({9, 9, 10}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        return i == 4 && j == 4 && k == 3 ? 1.0 : 0.0;
      });
  // Focal plane at 4.5: sheets at 5 and so on, on samples.
  const Camera camera = parallel_camera({4, 4, 4.5}, {0, 0, 1}, 4.5);
  const double endless = 1 + 2 * std::exp(-2.0) + std::exp(-8.0);  // half at the cut-off
  Look look = with_mode(gray_look(0, 1, 0.25), Mode::kMaximum);
  look.unit_distance = 0.1;
  const Image image = render(field, camera, look, picture(9, 9, 1)).image;
  const double peak = std::pow(endless, -3);
  EXPECT_NEAR(center_pixel(image).a(), 0.25, kFloatRelative);
  EXPECT_NEAR(center_pixel(image).r(), 0.25 * peak, kFloatRelative);
  EXPECT_NEAR(center_depth(image), 95.5 + 3, 100 * kFloatRelative);
  EXPECT_NEAR(pixel(image, 5, 4).r(), 0.25 * peak * std::exp(-2.0), kFloatRelative);
  EXPECT_NEAR(pixel(image, 5, 3).r(), 0.25 * peak * std::exp(-4.0), kFloatRelative);
}

// Equal samples (a power of two is: numerator over denominator without rounding): the first.
// Negative ones count too; a ray without any is empty.
TEST(Maximum, OfEqualAndNegativeSamples) {
  const Camera camera = parallel_camera({3.5, 3.5, 3.5}, {0, 0, 1}, 8);
  const Image image = render(constant_field({8, 8, 8}, -4), camera,
                             with_mode(gray_look(-6, -2), Mode::kMaximum), picture(33, 33))
                          .image;
  EXPECT_NEAR(center_pixel(image).r(), 0.5, kFloatRelative);
  EXPECT_NEAR(center_depth(image), 96.5, 100 * kFloatRelative);
  EXPECT_EQ(center_front_depth(image), center_depth(image));
  EXPECT_EQ(pixel(image, 0, 16).a(), 0);
  EXPECT_TRUE(std::isinf(depth(image, 0, 16)));
}

// Fails if the least sample is not taken, or an undefined one counts as 0.
TEST(Minimum, OfASingleDarkSample) {
  const LatticeField field =
      make_field({9, 9, 10}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        return i == 4 && j == 4 && k == 3 ? -1.0 : 0.0;
      });
  const Camera camera = parallel_camera({4, 4, 4.5}, {0, 0, 1}, 4.5);
  const Look look = with_mode(gray_look(-1, 0, 0.25), Mode::kMinimum);
  const Image image = render(field, camera, look, picture(9, 9, 1)).image;
  const double peak = std::pow(1 + 2 * std::exp(-2.0) + std::exp(-8.0), -3);
  EXPECT_NEAR(center_pixel(image).r(), 0.25 * (1 - peak), kFloatRelative);
  EXPECT_NEAR(center_depth(image), 95.5 + 3, 100 * kFloatRelative);
  EXPECT_EQ(center_front_depth(image), center_depth(image));
  const Image wide =
      render(field, parallel_camera({4, 4, 4.5}, {0, 0, 1}, 20), look, picture(9, 9, 1)).image;
  EXPECT_EQ(pixel(wide, 0, 4).a(), 0);
  EXPECT_TRUE(std::isinf(depth(wide, 0, 4)));
}

// Where sheets lie, and how, must not be seen in a thick slice: of a ramp, which the kernel keeps,
// the greatest, least and mean value between two planes is exact, to a hundredth of what a sheet
// makes of it. Fails at once if samples on sheets stand for what lies between the planes.
class ThickSlices : public ::testing::TestWithParam<std::tuple<Backend, Sheets>> {};

TEST_P(ThickSlices, OfARampAreExactWhereverSheetsLie) {
  const Vec3 slope(0.7, -0.4, 0.9);
  const FieldSetup setup{.kernel = kBSplineKernel};
  const LatticeField ramp = make_field(
      {49, 49, 49},
      [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        return slope.dot(
            Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)) -
            Vec3::Constant(24));
      },
      setup);
  const Vec3 view = Vec3(0.3, 0.2, 1).normalized();
  const Vec3 normal = Vec3(-0.2, 0.35, 0.8).normalized();
  constexpr int kEdge = 9;
  const auto [backend, sheets] = GetParam();
  Renderer renderer(backend, 1);
  for (const bool is_parallel : {true, false}) {
    const Camera camera = is_parallel ? parallel_camera(Vec3::Constant(24), view, 4, 70)
                                      : perspective_camera(Vec3::Constant(24), view, 4, 70);
    RenderOptions options = picture(kEdge, kEdge);
    options.sheets = sheets;
    const Vec3 right = view.cross(camera.view_up).normalized();
    const Vec3 up = right.cross(view);
    for (const Mode mode : {Mode::kMaximum, Mode::kMinimum, Mode::kMean}) {
      for (const double thickness : {0.02, 0.4, 1.0, 7.3}) {
        for (const double shift : {0.0, 0.13, 0.37, 0.5, 0.81}) {
          const double offset = normal.dot(Vec3::Constant(24)) + shift;
          const auto planes = slice_planes({3 * normal, 3 * offset}, thickness);
          options.clip_planes.assign(planes.begin(), planes.end());
          const double reach = 30;
          const Image image =
              renderer.render({ramp, with_mode(gray_look(-reach, reach), mode)}, camera, options)
                  .image;
          for (const auto& [x, y] : {std::pair{4, 4}, {1, 6}, {7, 2}}) {
            const Vec3 aside = (x - 4) * 8.0 / kEdge * right - (y - 4) * 8.0 / kEdge * up;
            const Vec3 eye = camera.position;
            const Vec3 origin = is_parallel ? Vec3(eye + aside) : eye;
            const Vec3 ray = is_parallel ? view : Vec3(70 * view + aside).normalized();
            const auto value_at = [&](double plane) {
              const double t = (plane - normal.dot(origin)) / normal.dot(ray);
              return slope.dot(origin + t * ray - Vec3::Constant(24));
            };
            const double enters = value_at(offset - 0.5 * thickness);
            const double leaves = value_at(offset + 0.5 * thickness);
            const double expected = mode == Mode::kMaximum   ? std::max(enters, leaves)
                                    : mode == Mode::kMinimum ? std::min(enters, leaves)
                                                             : 0.5 * (enters + leaves);
            const double seen = reach * (2 * pixel(image, x, y).r() - 1);
            EXPECT_EQ(pixel(image, x, y).a(), 1);
            EXPECT_NEAR(seen, expected, 0.01 * std::abs(slope.dot(ray)))
                << static_cast<int>(mode) << ", " << thickness << " thick at " << shift
                << (is_parallel ? ", parallel" : ", perspective");
          }
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(BackEnds, ThickSlices,
                         ::testing::Values(std::tuple{Backend::kReference, Sheets::kImage},
                                           std::tuple{Backend::kCpu, Sheets::kImage},
                                           std::tuple{Backend::kCpu, Sheets::kLattice}));

// A clip plane shortens paths: of a ramp 0..7 the mean is that of what is left. Sheets lie through
// the middles of the cells' faces, where the ramp's field is half-way, (k + 1/2) exactly; between
// them it goes straight.
TEST(Mean, OfARampIsWeightedByPath) {
  const LatticeField ramp = make_field(
      {8, 8, 8}, [](std::int64_t, std::int64_t, std::int64_t k) { return static_cast<double>(k); });
  const Camera camera = parallel_camera({3.5, 3.5, 4}, {0, 0, 1}, 4);
  const Look look = with_mode(gray_look(0, 10, 0.75), Mode::kMean);
  RenderOptions options = picture(9, 9, 1);
  options.clip_planes = {{{0, 0, 1}, 2.0}, {{0, 0, -1}, -4.25}};
  const double mean = (2 + 4.25) / 2;
  const Image image = render(ramp, camera, look, options).image;
  EXPECT_NEAR(center_pixel(image).r(), 0.75 * mean / 10, kFloatRelative);
  EXPECT_NEAR(center_pixel(image).a(), 0.75, kFloatRelative);
  EXPECT_NEAR(center_depth(image), 96 + 2.0, 100 * kFloatRelative);
  EXPECT_EQ(center_front_depth(image), center_depth(image));
  // What 8 bits cannot show has a place and is not seen.
  const Look faint = with_mode(gray_look(0, 10, 0.003), Mode::kMean);
  const Image unseen = render(ramp, camera, faint, options).image;
  EXPECT_NEAR(center_depth(unseen), 96 + 2.0, 100 * kFloatRelative);
  EXPECT_TRUE(std::isinf(center_front_depth(unseen)));
}

// The field is undefined across a hole: those slabs count neither in the sum nor in the length.
TEST(Mean, LeavesHolesOut) {
  const LatticeField torn = make_field({8, 8, 12}, [](std::int64_t, std::int64_t, std::int64_t k) {
    return k >= 4 && k <= 7 ? kMissing : 6.0;
  });
  const Camera camera = parallel_camera({3.5, 3.5, 5.5}, {0, 0, 1}, 4);
  EXPECT_NEAR(
      center_pixel(
          render(torn, camera, with_mode(gray_look(0, 10), Mode::kMean), picture(5, 5)).image)
          .r(),
      0.6, kFloatRelative);
  // 4 spacings on either side, by x-ray.
  EXPECT_NEAR(
      center_pixel(
          render(torn, camera, with_mode(gray_look(0, 10), Mode::kXray), picture(5, 5)).image)
          .r(),
      6 * 8, 100 * kFloatRelative);
}

// Front to back: what is near covers what is far. Two halves of pure colours, each of 4 slabs.
TEST(Composite, NearCoversFar) {
  const LatticeField halves = make_field(
      {8, 8, 16}, [](std::int64_t, std::int64_t, std::int64_t k) { return k < 8 ? 0.0 : 1.0; });
  Look look;
  look.transfer_function.colors = {
      {0, {1, 0, 0}}, {0.5, {1, 0, 0}}, {0.5, {0, 1, 0}}, {1, {0, 1, 0}}};
  look.transfer_function.opacities = {{0, 0.1}, {1, 0.1}};
  look.shade = false;
  look.unit_distance = 1;
  const double near = 1 - std::pow(0.9, 8);
  RenderOptions options = picture(5, 5, 1);
  options.classification = Classification::kSampled;  // no piece is of both colours
  for (const double sign : {1.0, -1.0}) {
    const Camera camera = parallel_camera({3.5, 3.5, 7.5}, {0, 0, sign}, 4);
    const Pixel at = center_pixel(render(halves, camera, look, options).image);
    EXPECT_NEAR(sign > 0 ? at.r() : at.g(), near, kFloatRelative);
    EXPECT_NEAR(sign > 0 ? at.g() : at.r(), near * (1 - near), kFloatRelative);
  }
}

// Classification comes after reconstruction: a step in the transfer function stays a step, whatever
// the zoom. Samples 0 and 1 are blurred over some spacings, yet no pixel of an unshaded maximum has
// a colour between.
TEST(Composite, ClassifiesTheReconstructedValue) {
  const LatticeField halves = make_field(
      {16, 8, 8}, [](std::int64_t i, std::int64_t, std::int64_t) { return i < 8 ? 0.0 : 1.0; });
  Look look = uniform_look(1);
  look.transfer_function.colors = {
      {0, {0, 0, 0}}, {0.5, {0, 0, 0}}, {0.5, {1, 1, 1}}, {1, {1, 1, 1}}};
  Camera camera = parallel_camera({7.5, 3.5, 3.5}, {0, 0, 1}, 1);
  camera.view_up = {0, 1, 0};
  const Image image = render(halves, camera, look, picture(64, 64)).image;
  for (int x = 0; x < 64; ++x) {
    // The camera looks along +z with y up: right is -x.
    EXPECT_EQ(pixel(image, x, 32).r(), x < 32 ? 1 : 0) << x;
  }
}

}  // namespace modes_test
}  // namespace ovoid::test
