// SPDX-License-Identifier: Apache-2.0
// The colour bar tells the truth: its swatch for a value is the colour in which a thick box of that
// value is drawn.
#include <gtest/gtest.h>

#include <cstdlib>

#include "ovoid/annotate.h"
#include "ovoid/renderer.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace color_bar_test {

// Steps of 1/255: the rounding of both, where they lie on either side of a half.
constexpr int kSwatchDifference = 1;

Look colorful_look(const std::string& map, Mode mode, bool shade) {
  Look look;
  look.transfer_function = color_map(map);
  look.transfer_function.map_range(-50, 150);
  look.transfer_function.opacities = {{-50, 0.9}, {150, 0.9}};
  look.mode = mode;
  look.shade = shade;
  return look;
}

// A box far thicker than what its opacity lets through, seen from aside.
Image drawn_box(double value, const Look& look) {
  const LatticeField field = constant_field({40, 40, 40}, value);
  Camera camera = default_camera(field.world_bounds());
  camera.azimuth(30);
  camera.elevation(20);
  RenderOptions options;
  options.width = options.height = 32;
  return Renderer(Backend::kCpu, 1).render({field, look}, camera, options).image;
}

// Fails if bar and volume disagree: other light, other colour space, other row.
TEST(ColorBarTruth, TheSwatchHasTheColourOfAThickBox) {
  const Rgb background{0.2, 0.4, 0.6};
  for (const char* const map : {"viridis", "cool-to-warm", "turbo"}) {
    for (const bool shade : {true, false}) {
      Look look = colorful_look(map, Mode::kComposite, shade);
      look.material.ambient = 0.15;
      look.material.specular = 0.6;
      Image bar;
      bar.width = 240;
      bar.height = 180;
      bar.rgba.assign(4U * 240U * 180U, 0.0F);
      const PixelBox ramp = draw_color_bar(bar, look, {}, mark_style_on(background));
      const auto bar_bytes = to_rgba8(bar, background);
      for (const int part : {0, 1, 2, 3, 4}) {
        const int y = ramp.y0 + part * (ramp.y1 - 1 - ramp.y0) / 4;
        const double value = color_bar_value(look, {}, ramp, y);
        const auto box_bytes = to_rgba8(drawn_box(value, look), background);
        const std::size_t in_bar = 4U * (static_cast<std::size_t>(y) * 240U +
                                         static_cast<std::size_t>((ramp.x0 + ramp.x1) / 2));
        const std::size_t in_box = 4U * (16U * 32U + 16U);
        for (std::size_t c = 0; c < 3; ++c) {
          EXPECT_NEAR(int{bar_bytes[in_bar + c]}, int{box_bytes[in_box + c]}, kSwatchDifference)
              << map << " shade " << shade << " value " << value << " channel " << c;
        }
      }
    }
  }
}

// Modes without light, and their opacity is the function's own: straight colours are compared.
TEST(ColorBarTruth, ModesWithoutLightShowTheFunctionsColour) {
  for (const Mode mode : {Mode::kMaximum, Mode::kMean}) {
    const Look look = colorful_look("plasma", mode, true);
    for (const double value : {-40.0, 20.0, 133.0}) {
      const auto box_bytes = to_rgba8(drawn_box(value, look));
      const Rgb shown = shown_color(look, value);
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(box_bytes[4U * (16U * 32U + 16U) + c], 255 * shown[c], kSwatchDifference)
            << value << ' ' << c;
      }
    }
  }
}

}  // namespace color_bar_test
}  // namespace ovoid::test
