// SPDX-License-Identifier: Apache-2.0
// The marks themselves: what is where, and in what colour.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "ovoid/annotate.h"
#include "ovoid/error.h"

namespace ovoid {
namespace marks_test {

constexpr int kMarksWidth = 320;
constexpr int kMarksHeight = 240;

Image blank(float alpha = 0) {
  Image image;
  image.width = kMarksWidth;
  image.height = kMarksHeight;
  image.rgba.assign(4U * kMarksWidth * kMarksHeight, 0.0F);
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = alpha;
  return image;
}

const float* pixel_of(const Image& image, int x, int y) {
  return &image.rgba[4 * (static_cast<std::size_t>(y) * image.width + x)];
}

MarkStyle plain_style() {
  MarkStyle style;
  style.halo_opacity = 0;
  return style;
}

// From +z, the box of half edge 1 at the origin fills half of the height.
Camera straight_camera(bool is_parallel) {
  Camera camera;
  camera.position = Vec3(0, 0, 10);
  camera.parallel_projection = is_parallel;
  camera.parallel_scale = 2;
  return camera;
}

Box unit_box() { return {Affine3::Identity(), Bounds3(-Vec3::Ones(), Vec3::Ones())}; }

double covered(const Image& image, int x0, int y0, int x1, int y1) {
  double sum = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) sum += pixel_of(image, x, y)[3];
  }
  return sum;
}

// ---- colour bar

ColorBar titled(const std::string& title) {
  ColorBar bar;
  bar.title = title;
  bar.unit = "K";
  return bar;
}

ColorBar ranged(double lo, double hi) {
  ColorBar bar;
  bar.range = std::pair{lo, hi};
  return bar;
}

Look unlit_look() {
  Look look = ramp_look({0, 100});
  look.shade = false;
  return look;
}

TEST(ColorBar, RowsHaveTheColoursOfTheirValues) {
  for (const Mode mode :
       {Mode::kComposite, Mode::kMaximum, Mode::kMean, Mode::kXray, Mode::kIsosurface}) {
    Look look = unlit_look();
    look.shade = true;
    look.mode = mode;
    Image image = blank();
    const PixelBox ramp = draw_color_bar(image, look, titled("t"));
    ASSERT_LT(ramp.y0, ramp.y1);
    const double lit = mode == Mode::kComposite || mode == Mode::kIsosurface ? 0.8 : 1.0;
    for (const int y : {ramp.y0, (ramp.y0 + ramp.y1) / 2, ramp.y1 - 1}) {
      const double value = color_bar_value(look, {}, ramp, y);
      EXPECT_NEAR(value, 100 * (ramp.y1 - y - 0.5) / (ramp.y1 - ramp.y0), 1e-9);
      const Rgb color = look.transfer_function.color_at(value);
      for (const int x : {ramp.x0, ramp.x1 - 1}) {
        for (std::size_t c = 0; c < 3; ++c) {
          EXPECT_NEAR(pixel_of(image, x, y)[c], lit * color[c], 1e-6) << x << ' ' << y;
        }
        EXPECT_EQ(pixel_of(image, x, y)[3], 1.0F);
      }
    }
  }
}

TEST(ColorBar, LightBeyondWhiteIsWhite) {
  Look look = unlit_look();
  look.shade = true;
  look.material.ambient = 3;
  EXPECT_EQ(shown_color(look, 100)[0], 1.0);
}

// Fails if the opacity curve is drawn where the mode knows no opacity, or where it says nothing.
TEST(ColorBar, TheOpacityCurveStandsLeftWhereThereIsOne) {
  const auto left_of_ramp = [](const Look& look) {
    Image image = blank();
    const PixelBox ramp = draw_color_bar(image, look, {}, plain_style());
    return covered(image, ramp.x0 - 14, ramp.y0, ramp.x0 - 3, ramp.y1);
  };
  Look look = unlit_look();
  EXPECT_GT(left_of_ramp(look), 100);
  look.mode = Mode::kXray;
  EXPECT_EQ(left_of_ramp(look), 0);
  look.mode = Mode::kComposite;
  look.transfer_function.opacities = {{0, 1}, {100, 1}};
  EXPECT_EQ(left_of_ramp(look), 0);
}

TEST(ColorBar, AnIsovalueIsMarked) {
  const auto left_of_ramp = [](double isovalue) {
    Look look = unlit_look();
    look.mode = Mode::kIsosurface;
    look.isovalue = isovalue;
    Image image = blank();
    const PixelBox ramp = draw_color_bar(image, look, {}, plain_style());
    return covered(image, ramp.x0 - 9, ramp.y0, ramp.x0 - 2, ramp.y1);
  };
  EXPECT_GT(left_of_ramp(50), 10);
  EXPECT_EQ(left_of_ramp(500), 0);
}

// Fails if an isovalue has more digits than its place in the bar can be told apart by.
TEST(ColorBar, AnIsovalueIsAsLongAsTheRangeNeeds) {
  const auto left_end = [](double isovalue, ValueScale scale) {
    Look look = unlit_look();
    look.mode = Mode::kIsosurface;
    look.isovalue = isovalue;
    look.transfer_function.scale = scale;
    Image image = blank();
    const PixelBox ramp = draw_color_bar(image, look, ranged(1, 100), plain_style());
    int x = 0;
    while (x < ramp.x0 && covered(image, x, ramp.y0, x + 1, ramp.y1) == 0) ++x;
    return ramp.x0 - x;
  };
  EXPECT_EQ(left_end(100 / 3.0, ValueScale::kLinear), left_end(33.3, ValueScale::kLinear));
  EXPECT_LT(left_end(33, ValueScale::kLinear), left_end(33.3, ValueScale::kLinear));
  EXPECT_EQ(left_end(100 / 3.0, ValueScale::kLog), left_end(33.33, ValueScale::kLog));
  EXPECT_LT(left_end(33, ValueScale::kLog), left_end(33.33, ValueScale::kLog));
}

TEST(ColorBar, ColoursBeyondTheRangeArePointedEnds) {
  Look look = unlit_look();
  Image image = blank();
  const PixelBox plain = draw_color_bar(image, look, {}, plain_style());
  const int middle = (plain.x0 + plain.x1) / 2;
  EXPECT_LT(pixel_of(image, middle, plain.y1 + 4)[3], 0.5F);
  look.transfer_function.below_color = Rgb{1, 0, 1};
  image = blank();
  const PixelBox pointed = draw_color_bar(image, look, {}, plain_style());
  const float* const end = pixel_of(image, middle, pointed.y1 + 4);
  EXPECT_GT(end[3], 0.5F);
  EXPECT_FLOAT_EQ(end[0], end[2]);  // magenta
  EXPECT_GT(end[0], 2 * end[1]);
}

TEST(ColorBar, EntriesAreSwatches) {
  Look look = unlit_look();
  ColorBar bar;
  bar.entries = {{10, "bone"}, {90, ""}};
  Image image = blank();
  const PixelBox all = draw_color_bar(image, look, bar);
  const Rgb first = shown_color(look, 10);
  const Rgb last = shown_color(look, 90);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_FLOAT_EQ(pixel_of(image, all.x0, all.y0)[c], static_cast<float>(first[c]));
    EXPECT_FLOAT_EQ(pixel_of(image, all.x1 - 1, all.y1 - 1)[c], static_cast<float>(last[c]));
  }
  bar.entries.assign(5000, {10, "many"});
  draw_color_bar(image, look, bar);  // as many as fit
}

// Labels 0 (transparent), 1, 5 and 6, each from half-way to half-way.
TransferFunction label_function() {
  TransferFunction tf;
  const double borders[] = {-0.5, 0.5, 3, 5.5, 6.5};
  for (std::size_t i = 0; i < 4; ++i) {
    const Rgb color{0.2 * static_cast<double>(i), 0.5, 0.1};
    tf.colors.insert(tf.colors.end(), {{borders[i], color}, {borders[i + 1], color}});
    const double opacity = i == 0 ? 0 : 1;
    tf.opacities.push_back({.x = borders[i], .opacity = opacity});
    tf.opacities.push_back({.x = borders[i + 1], .opacity = opacity});
  }
  return tf;
}

TEST(ColorBar, LabelsAreFoundAgain) {
  const std::vector<ColorBarEntry> entries = label_entries(label_function());
  ASSERT_EQ(entries.size(), 3U);
  EXPECT_EQ(entries[0].name, "1");
  EXPECT_EQ(entries[1].name, "5");
  EXPECT_EQ(entries[2].value, 6);

  EXPECT_TRUE(label_entries(unlit_look().transfer_function).empty());
  EXPECT_TRUE(label_entries({}).empty());
  TransferFunction moved = label_function();
  moved.map_range(-1, 10);
  EXPECT_TRUE(label_entries(moved).empty());
  TransferFunction ramp = label_function();
  ramp.colors[3].rgb[0] += 0.1;
  EXPECT_TRUE(label_entries(ramp).empty());
}

TEST(ColorBar, RangesOfAnyKindAreDrawn) {
  const double infinity = std::numeric_limits<double>::infinity();
  const Look look = unlit_look();
  for (const auto& [lo, hi] : {std::pair{5.0, 5.0},
                               {-1e308, 1e308},
                               {1e-300, 2e-300},
                               {0.0, 5e-324},
                               {1e9, 1e9 + 1},
                               {-0.0, 0.0}}) {
    Image image = blank();
    draw_color_bar(image, look, ranged(lo, hi));
    EXPECT_GT(covered(image, 0, 0, kMarksWidth, kMarksHeight), 0) << lo << ' ' << hi;
  }
  for (const auto& [lo, hi] : {std::pair{2.0, 1.0}, {0.0, infinity}, {std::nan(""), 1.0}}) {
    Image image = blank();
    EXPECT_THROW(draw_color_bar(image, look, ranged(lo, hi)), Error);
  }
}

TEST(ColorBar, LogarithmicScalesSpreadByPowers) {
  Look look = unlit_look();
  look.transfer_function.scale = ValueScale::kLog;
  const ColorBar bar = ranged(1, 10000);
  EXPECT_NEAR(color_bar_value(look, bar, {0, 0, 1, 3}, 1), 100, 1e-9);
}

// ---- box

// Fails if edges behind the volume are drawn over it, or those before it under it: the volume is
// opaque in the middle.
TEST(BoundingBox, BackEdgesAreHiddenFrontEdgesAreNot) {
  Image image = blank(1.0F);
  draw_bounding_box(image, straight_camera(false), unit_box(), {}, plain_style());
  // Front face: z = 1, depth 9; back face: depth 11. Height 2 * tan(15 deg) * depth is 240 px.
  const auto edge_x = [](double depth) {
    return static_cast<int>(std::floor(160 - 120 / (std::tan(std::acos(-1) / 12) * depth)));
  };
  EXPECT_GT(pixel_of(image, edge_x(9), 120)[0], 0.4F);
  EXPECT_EQ(pixel_of(image, edge_x(11), 120)[0], 0.0F);

  Image half = blank(0.75F);
  draw_bounding_box(half, straight_camera(false), unit_box(), {}, plain_style());
  const float seen = pixel_of(half, edge_x(11), 120)[0] + pixel_of(half, edge_x(11) - 1, 120)[0];
  EXPECT_GT(seen, 0.02F);
  EXPECT_LT(seen, 0.25F);
}

TEST(BoundingBox, IsWhereTheCameraSeesIt) {
  Image image = blank();
  draw_bounding_box(image, straight_camera(true), unit_box(), {}, plain_style());
  // 60 pixels per world unit: the left edge at 100, the right one at 220.
  EXPECT_GT(covered(image, 99, 100, 101, 101), 0.9);
  EXPECT_GT(covered(image, 219, 100, 221, 101), 0.9);
  EXPECT_EQ(covered(image, 103, 63, 217, 177), 0);
}

// The eye within: what lies before it is drawn, nothing throws and nothing fills the picture.
TEST(BoundingBox, MayHoldTheEye) {
  Camera camera = straight_camera(false);
  camera.position = Vec3(0.3, 0.2, 0.5);
  Image image = blank();
  draw_bounding_box(image, camera, unit_box());
  EXPECT_LT(covered(image, 0, 0, kMarksWidth, kMarksHeight), 0.3 * kMarksWidth * kMarksHeight);
}

TEST(BoundingBox, RefusesBoxesThatAreNone) {
  Image image = blank();
  const Camera camera = straight_camera(false);
  EXPECT_THROW(draw_bounding_box(image, camera, Box{}), Error);
  Box flat = unit_box();
  flat.world_from_box.linear().col(2).setZero();
  EXPECT_THROW(draw_bounding_box(image, camera, flat), Error);
}

// ---- axes

// The colour that is strongest around a place in the lower left corner.
char strongest_color(const Image& image, double right, double down) {
  const int x = 38 + static_cast<int>(right);  // the origin is 3.8 lines of 10 pixels in
  const int y = kMarksHeight - 38 + static_cast<int>(down);
  std::array<float, 3> sum{};
  for (int dy = -2; dy <= 2; ++dy) {
    for (int dx = -2; dx <= 2; ++dx) {
      for (std::size_t c = 0; c < 3; ++c) sum[c] += pixel_of(image, x + dx, y + dy)[c];
    }
  }
  const auto most = std::max_element(sum.begin(), sum.end()) - sum.begin();
  return sum[static_cast<std::size_t>(most)] < 1 ? ' ' : "xyz"[most];
}

// Fails if an axis is drawn where it does not point.
TEST(Axes, PointWhereTheyPoint) {
  Image image = blank();
  draw_axes(image, straight_camera(false), Space::kNone, plain_style());
  EXPECT_EQ(strongest_color(image, 16, 0), 'x');
  EXPECT_EQ(strongest_color(image, 0, -16), 'y');
  EXPECT_EQ(strongest_color(image, -16, 0), ' ');
  EXPECT_EQ(strongest_color(image, 0, 0), 'z');  // towards the eye

  Camera rolled = straight_camera(false);
  rolled.roll(90);
  image = blank();
  draw_axes(image, rolled, Space::kNone, plain_style());
  // The picture turns against the camera: what pointed right now points up or down with y.
  const Vec3 right = (rolled.focal_point - rolled.position).cross(rolled.view_up).normalized();
  EXPECT_EQ(strongest_color(image, 16 * right.y(), 0), 'y');
  EXPECT_EQ(strongest_color(image, 0, -16 * rolled.view_up.normalized().x()), 'x');

  Camera behind = straight_camera(true);
  behind.position = Vec3(0, 0, -10);
  image = blank();
  draw_axes(image, behind, Space::kNone, plain_style());
  EXPECT_EQ(strongest_color(image, -16, 0), 'x');
}

TEST(Axes, PatientDirectionsHaveTwoEnds) {
  Image none = blank();
  Image lps = blank();
  Image ras = blank();
  const Camera camera = straight_camera(false);
  draw_axes(none, camera, Space::kNone);
  draw_axes(lps, camera, Space::kLps);
  draw_axes(ras, camera, Space::kRas);
  EXPECT_NE(none, lps);
  EXPECT_NE(lps, ras);  // L and R change places
  EXPECT_GT(covered(lps, 0, 0, 38, kMarksHeight), covered(none, 0, 0, 38, kMarksHeight));
}

// From between -x and +y both arms lie one over the other, y before x. Fails if the letter x shows
// beside or under the y.
TEST(Axes, OfTwoLettersThatOverlapTheNearerStays) {
  Camera camera = straight_camera(true);
  camera.view_up = Vec3(0, 0, 1);
  // Pixels of either colour where the letter of an arm of this length in the picture belongs.
  const auto letter_at = [&](double length) {
    Image image = blank();
    draw_axes(image, camera, Space::kNone, plain_style());
    const int middle = 38 - static_cast<int>(23 * length + 7.5);
    std::array<int, 2> counts{};
    for (int y = kMarksHeight - 38 - 6; y < kMarksHeight - 38 + 7; ++y) {
      for (int x = middle - 4; x < middle + 5; ++x) {
        const float* const pixel = pixel_of(image, x, y);
        if (pixel[0] != pixel[1]) ++counts[pixel[0] > pixel[1] ? 0 : 1];
      }
    }
    return counts;
  };
  camera.position = Vec3(-10, 10, 0);
  EXPECT_EQ(letter_at(std::sqrt(0.5))[0], 0);
  EXPECT_GT(letter_at(std::sqrt(0.5))[1], 8);
  // A little to the side both have room.
  camera.position = Vec3(-10, 3, 0);
  EXPECT_GT(letter_at(3 / std::sqrt(109.0))[0], 4);
  EXPECT_GT(letter_at(10 / std::sqrt(109.0))[1], 8);
}

// ---- scale bar

// Fails if the bar is not as long as it says: 60 pixels per unit, and 0.22 of 320 pixels is 1.17.
TEST(ScaleBar, IsAsLongAsItSays) {
  Image image = blank();
  draw_scale_bar(image, straight_camera(true), "mm", plain_style());
  int greatest = 0;
  for (int y = 180; y < kMarksHeight; ++y) {
    int run = 0;
    for (int x = 0; x < kMarksWidth; ++x) {
      run = pixel_of(image, x, y)[3] > 0.5F ? run + 1 : 0;
      greatest = std::max(greatest, run);
    }
  }
  EXPECT_NEAR(greatest, 60, 2);

  Camera perspective = straight_camera(false);
  Image other = blank();
  draw_scale_bar(other, perspective, "mm", plain_style());
  EXPECT_NE(image, other);
}

TEST(ScaleBar, SurvivesScalesOfAnyKind) {
  for (const double scale : {1e-300, 1e-12, 1e12, 1e300}) {
    Camera camera = straight_camera(true);
    camera.parallel_scale = scale;
    Image image = blank();
    draw_scale_bar(image, camera);
    EXPECT_GT(covered(image, 0, 0, kMarksWidth, kMarksHeight), 10) << scale;
  }
}

// ---- all of them

// Fails if a mark writes outside a picture, however small.
TEST(Marks, FitPicturesOfAnySize) {
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 40}, {40, 2}, {33, 31}, {700, 20}}) {
    Image image;
    image.width = width;
    image.height = height;
    image.rgba.assign(4U * static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                      0.0F);
    draw_bounding_box(image, straight_camera(false), unit_box(), "mm");
    draw_axes(image, straight_camera(false), Space::kLps);
    draw_scale_bar(image, straight_camera(false), "mm");
    draw_color_bar(image, unlit_look(), titled("a name that is long"));
    for (const float value : image.rgba) EXPECT_TRUE(value >= 0 && value <= 1.0001F);
  }
}

TEST(Marks, RefuseImagesAndStylesThatAreNone) {
  Image image = blank();
  image.rgba.pop_back();
  EXPECT_THROW(draw_axes(image, straight_camera(false), Space::kNone), Error);
  Image empty;
  EXPECT_THROW(draw_color_bar(empty, unlit_look(), {}), Error);
  image = blank();
  for (const auto& spoil : std::initializer_list<std::function<void(MarkStyle&)>>{
           [](MarkStyle& s) { s.text_px = -1; }, [](MarkStyle& s) { s.text_px = 1e9; },
           [](MarkStyle& s) { s.halo_opacity = 2; }, [](MarkStyle& s) { s.halo_size = -1; }}) {
    MarkStyle style;
    spoil(style);
    EXPECT_THROW(draw_scale_bar(image, straight_camera(false), {}, style), Error);
  }
  Camera bad = straight_camera(false);
  bad.view_angle = 0;
  EXPECT_THROW(draw_axes(image, bad, Space::kNone), Error);
}

// Ink and halo must be far apart, whatever the background.
TEST(Marks, StylesSuitTheirBackground) {
  const Rgb white{1, 1, 1};
  const Rgb black{0, 0, 0};
  EXPECT_LT(mark_style_on(white).ink[1], 0.2);
  EXPECT_GT(mark_style_on(black).ink[1], 0.8);
  EXPECT_GT(mark_style_on({}).ink[1], 0.8);
  EXPECT_GT(mark_style_on({}).halo_size, mark_style_on(black).halo_size);
}

}  // namespace marks_test
}  // namespace ovoid
