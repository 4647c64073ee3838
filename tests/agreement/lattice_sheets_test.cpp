// SPDX-License-Identifier: Apache-2.0
// Lattice sheets: the cpu against the reference's base plane and warp, and both against pictures of
// image sheets whose distance and pixels are finer.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "ovoid/error.h"
#include "support/agreement.h"
#include "support/scenes.h"
#include "support/where.h"
#include "view/plan/base_plane.h"
#include "view/plan/frame_plan.h"

namespace ovoid::test {
namespace lattice_sheets_test {

TestScene on_lattice(TestScene scene) {
  scene.options.sheets = Sheets::kLattice;
  return scene;
}

std::string projection_of(bool is_parallel) { return is_parallel ? ", parallel" : ", perspective"; }

class LatticeSheets : public ::testing::Test {
 protected:
  void SetUp() override {
    if (tested_backend() == Backend::kVulkan) GTEST_SKIP() << "backend vulkan has image sheets";
  }
};

// Views across planes of the lattice, one for each of its axes, from both sides; somewhat aslant.
std::vector<Vec3> views_of(const Field& field) {
  const Mat3 axes = field.lattice()->geometry().world_from_index.linear();
  std::vector<Vec3> views;
  for (int a = 0; a < 3; ++a) {
    const Vec3 normal = axes.col((a + 1) % 3).cross(axes.col((a + 2) % 3)).normalized();
    for (const double side : {1.0, -1.0})
      views.emplace_back((side * normal + Vec3(0.21, -0.17, 0.26)).normalized());
  }
  return views;
}

Camera camera_from(const Field& field, const Vec3& direction, bool is_parallel, double fill) {
  const Bounds3 bounds = field.world_bounds();
  const double half_height = 0.5 * bounds.diagonal().norm() / fill;
  const double distance = (is_parallel ? 5 : 4) * half_height;
  return is_parallel ? parallel_camera(bounds.center(), direction, half_height, distance)
                     : perspective_camera(bounds.center(), direction, half_height, distance);
}

// In perspective some rays may be at over 60 degrees; a base plane may be far larger than the
// picture.
bool must_be_image_sheets(const TestScene& scene) {
  return !view::base_plane(scene.lattice(), view::support_of(scene.lattice(), 1.0, 0.0),
                           scene.camera, scene.options);
}

// Fails if an axis is taken for another one, or samples lie elsewhere.
TEST_F(LatticeSheets, AgreeInEveryModeAndView) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (int m = 0; m < 5; ++m) {
    for (const bool is_parallel : {true, false}) {
      TestScene scene = small_scene(kModes[m], is_parallel);
      int number = 0;
      for (const Vec3& direction : views_of(scene.field)) {
        scene.camera = camera_from(scene.field, direction, is_parallel, 1.3);
        EXPECT_TRUE(backends_agree(
            on_lattice(scene), fmt::format("lattice sheets, {}, view {}{}", kModeNames[m], ++number,
                                           projection_of(is_parallel))));
      }
    }
  }
}

// Fails if faces, holes, stored types or a lattice of one slice or sample are off.
TEST_F(LatticeSheets, AgreeOnEveryVolumeAndLook) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const TestVolume& volume : test_volumes()) {
    const bool is_one_sample = volume.field.num_kernels() == 1;
    for (const TestLook& look : test_looks(volume.lo, volume.hi)) {
      for (const bool is_parallel : {true, false}) {
        TestScene scene{volume.field,
                        camera_from(volume.field, views_of(volume.field)[4], is_parallel,
                                    is_one_sample ? 8 : 1.4),
                        look.look, picture(30, 26)};
        if (must_be_image_sheets(scene)) continue;
        if (is_one_sample)
          scene.options.sampling_distance = 0.06 * volume.field.default_sampling_distance();
        EXPECT_TRUE(backends_agree(on_lattice(scene),
                                   fmt::format("lattice sheets, {}, {}{}", volume.name, look.name,
                                               projection_of(is_parallel)),
                                   0.002));
      }
    }
  }
}

using Change = std::function<void(TestScene&)>;

TEST_F(LatticeSheets, AgreeWithOtherOptions) {
  OVOID_NIGHTLY_ON_DEVICE();
  const std::vector<std::pair<std::string, Change>> changes = {
      {"sampled", [](TestScene& s) { s.options.classification = Classification::kSampled; }},
      {"pre-integrated",
       [](TestScene& s) { s.options.classification = Classification::kPreintegrated; }},
      {"exact", [](TestScene& s) { s.options.gradient = GradientMethod::kExact; }},
      {"slab means", [](TestScene& s) { s.options.slab = Slab::kMean; }},
      {"no light", [](TestScene& s) { s.look.shade = false; }},
      {"a light", [](TestScene& s) { s.look.light_direction = Vec3(0.3, 0.5, 1); }},
      {"studio", [](TestScene& s) { s.look.light = Light::kStudio; }},
      {"further lights",
       [](TestScene& s) {
         s.look.further_lights = {{Vec3(3, 1, -2), 0.7}, {Vec3(-1, 2, 0.5), 0.4}};
       }},
      {"clipped",
       [](TestScene& s) {
         const Vec3 center = s.field.world_bounds().center();
         const Vec3 across(-1.0, 0.6, 0.5);
         s.options.clip_planes = {{across, across.dot(center) - 0.7}};
       }},
      {"four sheets a spacing",
       [](TestScene& s) {
         s.options.sampling_distance = 0.25 * s.field.default_sampling_distance();
       }},
      {"magnified",
       [](TestScene& s) {
         s.camera.zoom(9);
         s.options.post_convolution = PostConvolution::kOff;
       }},
      {"small", [](TestScene& s) { s.options.width = 7, s.options.height = 5; }},
      {"one pixel", [](TestScene& s) { s.options.width = s.options.height = 1; }},
      {"few pixels of a part",
       [](TestScene& s) {
         s.options.width = s.options.height = 4;
         s.camera.zoom(2);
       }},
  };
  for (const bool is_parallel : {true, false}) {
    for (const auto& [name, change] : changes) {
      TestScene scene = small_scene(Mode::kComposite, is_parallel);
      scene.camera = camera_from(scene.field, views_of(scene.field)[4], is_parallel, 1.3);
      change(scene);
      EXPECT_TRUE(backends_agree(on_lattice(scene),
                                 "lattice sheets, " + name + projection_of(is_parallel)));
    }
  }
}

// Kernels of every kind, sums, and two sublattices: ways of their own to form a sample.
TEST_F(LatticeSheets, AgreeForEveryKindOfField) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Index3 dims{12, 11, 14};
  for (const bool is_parallel : {true, false}) {
    for (const LatticeKind lattice : {LatticeKind::kCartesian, LatticeKind::kBodyCentred}) {
      for (const Reconstruction how : {Reconstruction::kNormalized, Reconstruction::kSum}) {
        for (const LatticeKernel& kernel : {LatticeKernel(), kBSplineKernel, kCatmullRomKernel}) {
          FieldSetup setup;
          setup.world_from_index = oblique_axes();
          setup.lattice = lattice;
          setup.reconstruction = how;
          setup.kernel = kernel;
          TestScene scene = small_scene(Mode::kComposite, is_parallel);
          scene.field =
              make_stored_field(dims, shells(dims), {ScalarType::kUInt16, 0, 4000}, setup);
          scene.look = semi_transparent_look(0, 4000);
          const std::string name =
              fmt::format("lattice sheets, {} {} {}{}", name_of(lattice),
                          how == Reconstruction::kSum ? "sum" : "mean",
                          static_cast<int>(kernel.kind), projection_of(is_parallel));
          for (const Vec3& direction : views_of(scene.field)) {
            scene.camera = camera_from(scene.field, direction, is_parallel, 1.3);
            EXPECT_TRUE(backends_agree(on_lattice(scene), name));
          }
        }
      }
    }
  }
}

// Exactly between two axes or three; along an axis; and spacings a hundred times as wide.
TEST_F(LatticeSheets, AgreeInExtremeViews) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Index3 dims{12, 11, 13};
  int num_drawn = 0;
  for (const double thickness : {1.0, 100.0}) {
    FieldSetup setup;
    setup.world_from_index.linear() = Vec3(1, 1, thickness).asDiagonal();
    const Field field = make_stored_field(dims, shells(dims), {ScalarType::kUInt8, 0, 255}, setup);
    for (const bool is_parallel : {true, false}) {
      for (const Vec3& direction :
           {Vec3(1, 1, 1), Vec3(1, 1, 0), Vec3(0, 1, -1), Vec3(1, 0, 0), Vec3(0, 0, -1)}) {
        TestScene scene{field, camera_from(field, direction, is_parallel, 1.3),
                        semi_transparent_look(0, 255), picture(24, 20)};
        if (must_be_image_sheets(scene)) continue;
        EXPECT_TRUE(backends_agree(
            on_lattice(scene),
            fmt::format("lattice sheets, spacing {}, from {} {} {}{}", thickness, direction.x(),
                        direction.y(), direction.z(), projection_of(is_parallel)),
            0.002));
        ++num_drawn;
      }
    }
  }
  EXPECT_GE(num_drawn, 14);
}

double largest_difference(const Image& a, const Image& b) { return compare(a, b).max_float; }

// Fails if a sample's value depends on which others are worked out with it.
TEST_F(LatticeSheets, SkippingAndStoppingChangeNoByte) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    for (const Mode mode : kModes) {
      TestScene scene = on_lattice(small_scene(mode, is_parallel));
      scene.camera = camera_from(scene.field, views_of(scene.field)[0], is_parallel, 1.3);
      scene.options.width = 150;
      scene.options.height = 90;
      scene.look.transfer_function.opacities = {{28, 0}, {36, 0.9}};
      const Image all = draw(scene).image;
      scene.options.skip_irrelevant = false;
      EXPECT_EQ(largest_difference(draw(scene).image, all), 0) << static_cast<int>(mode);
      scene.options.stop_opaque = false;
      EXPECT_EQ(largest_difference(draw(scene).image, all), 0) << static_cast<int>(mode);
    }
  }
}

// The mean of 4 x 4 pixels.
Image averaged(const Image& fine) {
  Image image;
  image.width = fine.width / 4;
  image.height = fine.height / 4;
  image.rgba.assign(4 * static_cast<std::size_t>(image.width) * image.height, 0.0F);
  image.depth.assign(static_cast<std::size_t>(image.width) * image.height, 0.0F);
  image.front_depth = image.depth;
  for (int y = 0; y < fine.height; ++y) {
    for (int x = 0; x < fine.width; ++x) {
      const auto from = 4 * (static_cast<std::size_t>(y) * fine.width + x);
      const auto to = 4 * (static_cast<std::size_t>(y / 4) * image.width + x / 4);
      for (std::size_t c = 0; c < 4; ++c) image.rgba[to + c] += fine.rgba[from + c] / 16;
    }
  }
  return image;
}

TestScene opaque_waves(bool is_parallel, const Vec3& direction,
                       LatticeKind kind = LatticeKind::kCartesian) {
  const Index3 dims{40, 40, kind == LatticeKind::kBodyCentred ? 80 : 40};
  const LatticeGeometry lattice{dims, Affine3::Identity(), kind};
  FieldSetup setup;
  setup.kernel = kBSplineKernel;
  setup.lattice = kind;
  TestScene scene;
  scene.field = make_stored_field(
      dims,
      [lattice](std::int64_t i, std::int64_t j, std::int64_t k) {
        const Vec3 at = 0.25 * lattice.index_position({i, j, k});
        const double x = at.x();
        const double y = at.y();
        const double z = at.z();
        return 0.5 + 0.16 * (std::sin(x) * std::cos(y) + std::sin(y) * std::cos(z) +
                             std::sin(z) * std::cos(x));
      },
      {ScalarType::kFloat32, 0, 1}, setup);
  scene.look = semi_transparent_look(0, 1);
  scene.look.transfer_function.opacities = {{0.55, 0}, {0.6, 0.9}};
  scene.camera = camera_from(scene.field, direction, is_parallel, 1.0);
  scene.options = picture(96, 96);
  return scene;
}

// A steep look is no farther from the mean of 4 x 4 rays whose samples are eight times as close
// than image sheets are. Fails if the warp blurs what classification made sharp.
TEST_F(LatticeSheets, AreAsNearToTheMeanOfFinerRaysAsImageSheets) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    for (const Vec3& direction : {Vec3(0.48, -0.31, 0.82), Vec3(0.6, -0.5, 0.8)}) {
      TestScene scene = opaque_waves(is_parallel, direction);
      const Image on_image = draw(scene).image;
      const Image picture = draw(on_lattice(scene)).image;
      scene.options.width *= 4;
      scene.options.height *= 4;
      scene.options.sampling_distance = 1.0 / 16;
      scene.options.post_convolution = PostConvolution::kOff;
      const Image fine = averaged(draw(scene).image);
      const double own = compare(picture, fine).psnr_db;
      const double of_image = compare(on_image, fine).psnr_db;
      std::printf("[converged ] %.1f dB, image sheets %.1f dB\n", own, of_image);
      EXPECT_GT(own, of_image - 0.1);
    }
  }
}

// Just before and just behind where the main axis changes, the picture differs by less than by a
// turn of half a degree.
TEST_F(LatticeSheets, NothingPopsWhereTheMainAxisChanges) {
  OVOID_NIGHTLY_ON_DEVICE();
  const auto drawn_at = [](double degrees) {
    const double angle = degrees * std::numbers::pi / 180;
    TestScene scene = opaque_waves(true, {std::sin(angle), 0.2, std::cos(angle)});
    scene.options = picture(240, 240);
    return draw(on_lattice(scene)).image;
  };
  const Image before = drawn_at(44.999);
  const double step = compare(before, drawn_at(45.001)).psnr_db;
  const double turn = compare(before, drawn_at(44.5)).psnr_db;
  std::printf("[turn      ] %.1f dB, where the axis changes %.1f dB\n", turn, step);
  EXPECT_GT(step, turn);
}

// A magnified base plane is drawn from few samples, where these make a smooth picture: near enough
// to that of all samples, and far fewer. Fails if what lies between is filled wrongly, or what is
// sharp is filled at all.
TEST_F(LatticeSheets, MagnifiedPicturesAreThoseOfAllSamples) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const std::vector<std::vector<OpacityPoint>> looks = {
      {{0.2, 0}, {1, 0.2}}, {{0.55, 0}, {0.6, 0.9}}, {{0.4, 0}, {0.5, 0.3}, {0.6, 0}}};
  for (const bool is_parallel : {true, false}) {
    for (const double zoom : {4.0, 9.0, 20.0}) {
      for (const std::vector<OpacityPoint>& opacities : looks) {
        TestScene scene = on_lattice(opaque_waves(is_parallel, Vec3(0.48, -0.31, 0.82)));
        scene.look.transfer_function.opacities = opacities;
        // Other modes go the same way, whatever their look.
        if (zoom == 9.0 && opacities.size() == 3) scene.look.mode = Mode::kMaximum;
        if (zoom == 4.0 && opacities.size() == 3) scene.look.mode = Mode::kMean;
        scene.camera.zoom(zoom);
        scene.options.width = 300;
        scene.options.height = 260;
        const Frame few = draw(scene);
        scene.options.post_convolution = PostConvolution::kOff;
        const Frame all = draw(scene);
        const ImageDifference difference = compare(few.image, all.image);
        const double share = static_cast<double>(few.profile.samples_reconstructed) /
                             static_cast<double>(all.profile.samples_reconstructed);
        std::printf("[magnified ] %4.0f times%s: %.1f dB, %.2f of the samples\n", zoom,
                    projection_of(is_parallel).c_str(), difference.psnr_db, share);
        EXPECT_GE(difference.psnr_db, view::kNodeDecibels);
        EXPECT_LT(share, 0.8);
      }
    }
  }
}

// Lines of a steep look are thinner than samples apart: every sample is drawn.
TEST_F(LatticeSheets, SteepLooksHaveAllSamples) {
  OVOID_NIGHTLY_ON_DEVICE();
  TestScene scene = on_lattice(opaque_waves(true, Vec3(0.48, -0.31, 0.82)));
  scene.look.transfer_function.opacities = {{0.5, 0}, {0.505, 0.5}, {0.51, 0}};
  scene.camera.zoom(9);
  const Image few = draw(scene).image;
  scene.options.post_convolution = PostConvolution::kOff;
  EXPECT_EQ(largest_difference(draw(scene).image, few), 0);
}

// Body-centred lattices: where fewer samples are summed, or fewer kernels, than on image sheets,
// and there alone. Fails if small or magnified pictures are drawn on image sheets, or all of them
// on lattice sheets.
TEST_F(LatticeSheets, AutoTakesThemOfBodyCentredLatticesInSmallAndMagnifiedPictures) {
  OVOID_NIGHTLY_ON_DEVICE();
  TestScene scene = opaque_waves(true, Vec3(0.48, -0.31, 0.82), LatticeKind::kBodyCentred);
  scene.look.transfer_function.opacities = {{0.2, 0}, {1, 0.2}};
  const struct {
    int size;
    Sheets expected;
  } cases[] = {{40, Sheets::kLattice}, {120, Sheets::kImage}, {260, Sheets::kLattice}};
  for (const auto& [size, expected] : cases) {
    scene.options.width = scene.options.height = size;
    const auto drawn_on = [&](Sheets sheets) {
      scene.options.sheets = sheets;
      return draw(scene).image;
    };
    const Image taken = drawn_on(Sheets::kAuto);
    EXPECT_EQ(largest_difference(taken, drawn_on(expected)), 0) << size;
    const Sheets other = expected == Sheets::kLattice ? Sheets::kImage : Sheets::kLattice;
    EXPECT_GT(largest_difference(taken, drawn_on(other)), 1e-3) << size;
  }
}

// Fails if the rule for body-centred lattices is taken for Cartesian ones, whose samples share no
// weights under a wider kernel.
TEST_F(LatticeSheets, AutoLeavesWideKernelsOfCartesianLatticesOnImageSheets) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Index3 dims{20, 20, 20};
  FieldSetup setup;
  setup.kernel = {0.8, 3};
  TestScene scene = opaque_waves(true, Vec3(0.48, -0.31, 0.82));
  scene.field = make_stored_field(dims, shells(dims), {ScalarType::kFloat32, 0, 1}, setup);
  scene.look.transfer_function.opacities = {{0.2, 0}, {1, 0.2}};
  scene.camera = camera_from(scene.field, Vec3(0.48, -0.31, 0.82), true, 1.0);
  for (const int size : {20, 200}) {
    scene.options.width = scene.options.height = size;
    scene.options.sheets = Sheets::kAuto;
    const Image taken = draw(scene).image;
    scene.options.sheets = Sheets::kImage;
    EXPECT_EQ(largest_difference(taken, draw(scene).image), 0) << size;
  }
}

void expect_refused(const TestScene& scene, const std::string& reason) {
  try {
    draw(on_lattice(scene));
    FAIL() << "was drawn, should say: " << reason;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUnsupported);
    EXPECT_NE(std::string(error.what()).find(reason), std::string::npos) << error.what();
  }
}

TEST_F(LatticeSheets, SayWhatTheyCannotDraw) {
  OVOID_NIGHTLY_ON_DEVICE();
  const TestScene plain = small_scene(Mode::kComposite, false);
  TestScene scene = plain;
  scene.options.gradient = GradientMethod::kCentral;
  expect_refused(scene, "central differences");
  scene = plain;
  scene.options.evaluate = Evaluate::kScatter;
  expect_refused(scene, "scattered");
  scene = plain;
  scene.options.post_convolution = PostConvolution::kCubic;
  expect_refused(scene, "post-convolution");
  scene = plain;
  scene.camera.position = scene.field.world_bounds().center();
  scene.camera.focal_point = scene.camera.position + Vec3(0, 0, 1);
  expect_refused(scene, "camera in front of the whole volume");
  scene = plain;
  scene.camera.view_angle = 150;
  expect_refused(scene, "60 degrees");
}

}  // namespace lattice_sheets_test
}  // namespace ovoid::test
