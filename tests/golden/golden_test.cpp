// SPDX-License-Identifier: Apache-2.0
// A few whole pictures, as they were when somebody last looked at them and found them good. They
// guard what no formula says: default views and looks, sample data, the order of axes on the way
// to a file. After an intended change: OVOID_UPDATE_GOLDEN=1 golden_tests, then look at each.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "ovoid/annotate.h"
#include "ovoid/io.h"
#include "ovoid/model.h"
#include "ovoid/renderer.h"

namespace ovoid::test {
namespace golden_test {

constexpr int kWidth = 120;
constexpr int kHeight = 96;
constexpr Rgb kBackground{0.06, 0.07, 0.10};

// Steps of 1/255. Float sums differ by 1e-6 between SIMD targets: one step at a tie of rounding,
// and one more where an opacity of nearly nothing starts.
constexpr int kGreatestDifference = 2;

struct GoldenScene {
  std::string name;
  std::string sample;
  int size;
  void (*set)(Camera&, Look&, RenderOptions&);
  void (*mark)(Image&, const Camera&, const Look&, const LatticeField&) = nullptr;
};

std::ostream& operator<<(std::ostream& stream, const GoldenScene& scene) {
  return stream << scene.name;
}

std::vector<GoldenScene> scenes() {
  return {
      {"marschner-lobb", "marschner-lobb", 40, [](Camera&, Look&, RenderOptions&) {}},
      {"head", "head", 64,
       [](Camera& camera, Look& look, RenderOptions&) {
         look.transfer_function = read_transfer_function(OVOID_SOURCE_DIR "/docs/looks/head.json");
         camera.azimuth(35);
         camera.zoom(1.6);
       }},
      {"head-surface", "head", 64,
       [](Camera& camera, Look& look, RenderOptions&) {
         look.mode = Mode::kIsosurface;
         look.isovalue = 300;
         look.light_direction = Vec3(-1, -1, 1);
         camera.azimuth(-30);
         camera.elevation(20);
         camera.zoom(1.6);
       }},
      {"head-maximum", "head", 48,
       [](Camera& camera, Look& look, RenderOptions&) {
         look.mode = Mode::kMaximum;
         camera.parallel_projection = true;
         camera.azimuth(90);
       }},
      // Letters, lines, what is hidden, the triad's colours, where everything stands.
      {"head-marks", "head", 48,
       [](Camera& camera, Look& look, RenderOptions& options) {
         look.transfer_function = read_transfer_function(OVOID_SOURCE_DIR "/docs/looks/head.json");
         camera.azimuth(35);
         camera.elevation(15);
         camera.zoom(0.85);
         options.width = 360;
         options.height = 288;
       },
       [](Image& image, const Camera& camera, const Look& look, const LatticeField& field) {
         const MarkStyle style = mark_style_on(kBackground);
         ColorBar bar;
         bar.title = "head";
         bar.unit = "HU";
         draw_bounding_box(image, camera, box_of(field.geometry()), "mm", style);
         draw_axes(image, camera, Space::kLps, style);
         draw_scale_bar(image, camera, "mm", style);
         draw_color_bar(image, look, bar, style);
       }},
  };
}

struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

Picture read_png(const std::string& path) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&png, path.c_str()) == 0) return {};
  png.format = PNG_FORMAT_RGB;
  Picture picture{static_cast<int>(png.width), static_cast<int>(png.height),
                  std::vector<std::uint8_t>(PNG_IMAGE_SIZE(png))};
  if (png_image_finish_read(&png, nullptr, picture.rgb.data(), 0, nullptr) == 0) return {};
  return picture;
}

void draw(const GoldenScene& scene, const std::string& path) {
  const Dataset dataset = make_sample(scene.sample, {.size = {scene.size, scene.size, scene.size}});
  const LatticeField field = make_lattice_field(dataset);
  Camera camera = default_camera(field.world_bounds(), dataset.space, {},
                                 static_cast<double>(kWidth) / kHeight);
  Look look = ramp_look(field.value_range());
  RenderOptions options;
  options.width = kWidth;
  options.height = kHeight;
  scene.set(camera, look, options);
  Frame frame = Renderer(Backend::kCpu, 1).render({field, look}, camera, options);
  if (scene.mark != nullptr) scene.mark(frame.image, camera, look, field);
  write_image(frame.image, path, kBackground);
}

class Golden : public ::testing::TestWithParam<GoldenScene> {};

TEST_P(Golden, PictureIsTheOneLookedAt) {
  const std::string golden = fmt::format(OVOID_SOURCE_DIR "/tests/golden/{}.png", GetParam().name);
  if (std::getenv("OVOID_UPDATE_GOLDEN") != nullptr) {
    draw(GetParam(), golden);
    GTEST_SKIP() << "drawn anew: " << golden;
  }
  const std::filesystem::path folder = OVOID_TEST_OUTPUT;
  std::filesystem::create_directories(folder);
  const std::string drawn = folder / fmt::format("{}.png", GetParam().name);
  draw(GetParam(), drawn);

  const Picture expected = read_png(golden);
  const Picture actual = read_png(drawn);
  ASSERT_GT(expected.width, 0) << golden;
  ASSERT_EQ(actual.width, expected.width) << golden;
  ASSERT_EQ(actual.height, expected.height) << golden;
  ASSERT_EQ(actual.rgb.size(), expected.rgb.size());
  int greatest = 0;
  for (std::size_t i = 0; i < expected.rgb.size(); ++i)
    greatest = std::max(greatest, std::abs(int{actual.rgb[i]} - int{expected.rgb[i]}));
  EXPECT_LE(greatest, kGreatestDifference) << "see " << drawn << " and " << golden;
}

INSTANTIATE_TEST_SUITE_P(Scenes, Golden, ::testing::ValuesIn(scenes()), [](const auto& info) {
  std::string name = info.param.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

}  // namespace golden_test
}  // namespace ovoid::test
