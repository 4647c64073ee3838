// SPDX-License-Identifier: Apache-2.0
// Magnified lattices: sheets from nodes against sheets worked out pixel by pixel.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "ovoid/error.h"
#include "ovoid/model.h"
#include "ovoid/sampler.h"
#include "support/agreement.h"
#include "support/scenes.h"
#include "support/where.h"
#include "view/plan/frame_plan.h"

namespace ovoid::test {
namespace post_convolution_test {

constexpr Index3 kDims{44, 40, 42};

LatticeField shells_field() { return make_stored_field(kDims, shells(kDims), {}); }

LatticeField sample_field(const char* name) {
  return make_lattice_field(make_sample(name, {.size = {48, 48, 48}}));
}

Frame drawn(TestScene scene, PostConvolution how) {
  scene.options.post_convolution = how;
  scene.options.collect_profile = true;
  return draw(scene);
}

// `pixels` per spacing in the middle of the picture.
TestScene magnified(const LatticeField& field, const Look& look, bool is_parallel, double pixels,
                    int width = 180, int height = 150) {
  const double sphere = field.world_bounds().diagonal().norm() / field.geometry().spacing()[0];
  return {field, askew_camera(field, is_parallel, sphere * pixels / height), look,
          picture(width, height)};
}

// Fails if nodes or their weights are off by a fraction of a pixel, a phase is mirrored, gradients
// are not brought up, or nodes are farther apart than the documents say.
TEST(PostConvolution, AgreesWithEveryPixelWorkedOut) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const std::vector<std::pair<const char*, LatticeField>> fields = {{"shells", shells_field()},
                                                                    {"head", sample_field("head")}};
  for (const auto& [name, field] : fields) {
    const ValueRange range = field.value_range();
    for (const TestLook& look : test_looks(range.lo, range.hi)) {
      for (const bool is_parallel : {true, false}) {
        const TestScene scene = magnified(field, look.look, is_parallel, 8);
        const Frame exact = drawn(scene, PostConvolution::kOff);
        const Frame fast = drawn(scene, PostConvolution::kAuto);
        const ImageDifference difference = compare(fast.image, exact.image);
        const std::string what =
            std::string(name) + ", " + look.name + (is_parallel ? ", parallel" : ", perspective");
        std::printf("[agreement ] %-50s %s\n", what.c_str(), difference.to_string().c_str());
        EXPECT_GE(difference.psnr_db, view::kNodeDecibels) << what;
        EXPECT_GT(difference.num_covered, 300) << what;
        // The vulkan back end takes nodes from two pixels apart: for a peak in parallel projection
        // they are nearer.
        if (tested_backend() == Backend::kCpu) {
          EXPECT_LT(fast.profile.samples_reconstructed, exact.profile.samples_reconstructed)
              << what << ": no sheet came from nodes";
        }
      }
    }
  }
}

TEST(PostConvolution, AgreesInEveryMode) {
  OVOID_NIGHTLY_ON_DEVICE();
  const LatticeField field = shells_field();
  for (const Mode mode : {Mode::kXray, Mode::kMaximum, Mode::kMean}) {
    for (const double pixels : {4.0, 7.3, 16.0, 40.0}) {
      TestScene scene =
          magnified(field, with_mode(semi_transparent_look(0, 1), mode), true, pixels);
      const Frame exact = drawn(scene, PostConvolution::kOff);
      const ImageDifference difference = compare(drawn(scene, PostConvolution::kAuto).image,
                                                 exact.image, greatest_color(exact.image));
      EXPECT_GE(difference.psnr_db, view::kNodeDecibels)
          << static_cast<int>(mode) << ", " << pixels;
    }
  }
}

// Pieces begin on a sheet and end on the next, crossings lie between the two, a mean sample is an
// integral, and kernels may scatter themselves to nodes, too.
TEST(PostConvolution, AgreesOnWhatIsNoSingleSample) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const LatticeField field = shells_field();
  const auto agrees = [](const TestScene& scene, const char* what) {
    const Frame exact = drawn(scene, PostConvolution::kOff);
    const Frame fast = drawn(scene, PostConvolution::kAuto);
    const ImageDifference difference = compare(fast.image, exact.image);
    std::printf("[agreement ] %-50s %s\n", what, difference.to_string().c_str());
    EXPECT_GE(difference.psnr_db, view::kNodeDecibels) << what;
    EXPECT_GT(difference.num_covered, 300) << what;
    // Software drivers take nodes where they are two pixels apart; an isosurface's are closer here.
    const bool is_isosurface = scene.look.mode == Mode::kIsosurface;
    if (!is_on_graphics_processor() && !(is_on_device() && is_isosurface)) {
      EXPECT_NE(fast.profile.samples_reconstructed, exact.profile.samples_reconstructed)
          << what << ": no sheet came from nodes";
    }
  };
  for (const bool is_parallel : {true, false}) {
    const TestScene plain = magnified(field, semi_transparent_look(0, 1), is_parallel, 8, 90, 70);
    TestScene scene = plain;
    scene.options.classification = Classification::kPreintegrated;
    agrees(scene, "pre-integrated");
    scene = plain;
    scene.options.slab = Slab::kMean;
    agrees(scene, "mean slabs");
    scene = plain;
    scene.options.evaluate = Evaluate::kScatter;
    agrees(scene, "scattered");
    scene = plain;
    scene.look.mode = Mode::kIsosurface;
    scene.look.isovalue = 0.6;
    agrees(scene, "isosurface");
  }
}

// In perspective near sheets have many pixels per node and far ones none: from the middle of the
// volume, where the nearest sheets lie at the eye. Fails at seams between patches of other pitches.
TEST(PostConvolution, AgreesFromWithin) {
  OVOID_NIGHTLY_ON_DEVICE();
  const LatticeField field = sample_field("head");
  const ValueRange range = field.value_range();
  TestScene scene = magnified(field, semi_transparent_look(range.lo, range.hi), false, 6, 200, 170);
  const Vec3 middle = field.world_bounds().center();
  const Vec3 forward = (scene.camera.focal_point - scene.camera.position).normalized();
  const double spacing = field.geometry().spacing()[0];
  scene.camera.position = middle - 8 * spacing * forward;
  scene.camera.focal_point = middle + 8 * spacing * forward;
  scene.camera.view_angle = 60;
  const Frame exact = drawn(scene, PostConvolution::kOff);
  const Frame fast = drawn(scene, PostConvolution::kAuto);
  EXPECT_LT(fast.profile.samples_reconstructed, exact.profile.samples_reconstructed);
  const ImageDifference difference = compare(fast.image, exact.image);
  EXPECT_GE(difference.psnr_db, view::kNodeDecibels) << difference.to_string();
}

// Clip planes cut pixels, not nodes; and nothing may hang on pixels turning opaque.
TEST(PostConvolution, ClipPlanesStaySharp) {
  OVOID_NIGHTLY_ON_DEVICE();
  const LatticeField field = shells_field();
  TestScene scene = magnified(field, semi_transparent_look(0, 1), false, 8);
  const Vec3 normal(-1, 0.6, 0.5);
  for (const bool stops : {true, false}) {
    scene.options.stop_opaque = stops;
    for (const bool is_clipped : {true, false}) {
      scene.options.clip_planes.clear();
      if (is_clipped)
        scene.options.clip_planes = {{normal, normal.dot(field.world_bounds().center())}};
      const ImageDifference difference = compare(drawn(scene, PostConvolution::kAuto).image,
                                                 drawn(scene, PostConvolution::kOff).image);
      EXPECT_GE(difference.psnr_db, view::kNodeDecibels) << difference.to_string();
    }
  }
}

// Missing samples make holes that nodes would not see.
TEST(PostConvolution, HolesStayAsTheyAre) {
  OVOID_NIGHTLY_ON_DEVICE();
  const VolumeFunction whole = shells(kDims);
  const LatticeField field =
      make_stored_field(kDims,
                        [&](std::int64_t i, std::int64_t j, std::int64_t k) {
                          return (i + 2 * j + 3 * k) % 97 == 0 ? kMissing : whole(i, j, k);
                        },
                        {});
  const TestScene scene = magnified(field, semi_transparent_look(0, 1), true, 8);
  const ImageDifference difference = compare(drawn(scene, PostConvolution::kAuto).image,
                                             drawn(scene, PostConvolution::kOff).image);
  EXPECT_GE(difference.psnr_db, 60) << difference.to_string();
}

// The picture does not depend on who draws which patch.
TEST(PostConvolution, ThreadsChangeNothing) {
  OVOID_NIGHTLY_ON_DEVICE();
  const TestScene scene = magnified(shells_field(), semi_transparent_look(0, 1), false, 8);
  Renderer one(Backend::kCpu, 1);
  Renderer four(Backend::kCpu, 4);
  const auto image_of = [&](Renderer& renderer) {
    return renderer.render({scene.field, scene.look}, scene.camera, scene.options).image;
  };
  EXPECT_EQ(image_of(one).rgba, image_of(four).rgba);
}

constexpr int kSheetSize = 128;

// A slice of a deep volume that is the same all along z, seen along z, as gray as the field. Clip
// planes keep the sheets of one patch that is nowhere near a face.
TestScene slice_scene(const LatticeField& field, double pixels, double roll_degrees) {
  const Vec3 center = field.world_bounds().center();
  Camera camera = parallel_camera(center, Vec3(0, 0, 1), 0.5 * kSheetSize / pixels);
  const double roll = roll_degrees * std::numbers::pi / 180;
  camera.view_up = Vec3(std::sin(roll), std::cos(roll), 0);
  TestScene scene{field, camera, with_mode(gray_look(0, 1), Mode::kMean),
                  picture(kSheetSize, kSheetSize, 1.0)};
  scene.options.clip_planes = {{{0, 0, 1}, center.z() - 3}, {{0, 0, -1}, -center.z() - 3}};
  return scene;
}

LatticeField deep_field(const VolumeFunction& slice) {
  constexpr std::int64_t kEdge = 90;
  std::vector<double> values;
  for (std::int64_t j = 0; j < kEdge; ++j) {
    for (std::int64_t i = 0; i < kEdge; ++i) values.push_back(slice(i, j, 0));
  }
  return make_stored_field({kEdge, kEdge, 120},
                           [&](std::int64_t i, std::int64_t j, std::int64_t) {
                             return values[static_cast<std::size_t>(j * kEdge + i)];
                           },
                           {});
}

// What a pixel of such a picture shows, and where it lies in the world.
double gray_of(const Image& image, int x, int y) {
  return static_cast<double>(image.rgba[static_cast<std::size_t>(4 * (y * kSheetSize + x))]);
}
Vec3 place_of(const Camera& camera, double pixels, double x, double y) {
  const Vec3 right = Vec3(0, 0, 1).cross(camera.view_up).normalized();
  const double middle = 0.5 * kSheetSize - 0.5;
  return camera.focal_point +
         (right * (x - middle) - camera.view_up.normalized() * (y - middle)) / pixels;
}

double published_filter(PostConvolution how, double distance) {
  const double x = std::abs(distance);
  if (how == PostConvolution::kBilinear) return x < 1 ? 1 - x : 0;
  if (how == PostConvolution::kGaussian) return x < 2 ? std::exp(-2 * x * x) : 0;
  if (x < 1) return 1.5 * x * x * x - 2.5 * x * x + 1;
  return x < 2 ? -0.5 * x * x * x + 2.5 * x * x - 4 * x + 2 : 0;
}

// Against the definition, worked out here in double: a node per spacing from the picture's corner,
// weights over their sum. Fails if a filter, its phases or the nodes' places are off.
TEST(PostConvolution, PublishedFiltersAreWhatTheyAreCalled) {
  OVOID_NIGHTLY_ON_DEVICE();
  const LatticeField field = deep_field(shells({90, 90, 1}));
  const FieldSampler sampler{Field(field)};
  for (const double pixels : {3.0, 4.0, 5.3}) {
    const TestScene scene = slice_scene(field, pixels, 27);
    for (const PostConvolution how :
         {PostConvolution::kBilinear, PostConvolution::kGaussian, PostConvolution::kCubic}) {
      const Image image = drawn(scene, how).image;
      for (int n = 0; n < 40; ++n) {
        const int x = (37 * n + 5) % kSheetSize, y = (71 * n + 11) % kSheetSize;
        const double node_x = std::floor(x / pixels), node_y = std::floor(y / pixels);
        double sum = 0, weights = 0;
        for (int j = -2; j <= 3; ++j) {
          for (int i = -2; i <= 3; ++i) {
            const double weight = published_filter(how, node_x + i - x / pixels) *
                                  published_filter(how, node_y + j - y / pixels);
            const Vec3 place =
                place_of(scene.camera, pixels, pixels * (node_x + i), pixels * (node_y + j));
            if (weight != 0) sum += weight * sampler.at(place).value;
            weights += weight;
          }
        }
        ASSERT_NEAR(gray_of(image, x, y), sum / weights, 1e-4)
            << static_cast<int>(how) << ", " << pixels << " pixels, at " << x << ", " << y;
      }
    }
  }
}

// A random slice without frequencies beyond `limit` cycles per spacing, in about [0, 1].
VolumeFunction band_limited(double limit) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit;
  std::vector<std::array<double, 4>> waves;  // amplitude, frequencies, phase
  while (waves.size() < 400) {
    const double u = (2 * unit(random) - 1) * limit, v = (2 * unit(random) - 1) * limit;
    if (std::hypot(u, v) <= limit) waves.push_back({0.012, u, v, unit(random)});
  }
  return [waves](std::int64_t i, std::int64_t j, std::int64_t) {
    double sum = 0.5;
    for (const auto& [amplitude, u, v, phase] : waves)
      sum +=
          amplitude * std::sin(2 * std::numbers::pi *
                               (u * static_cast<double>(i) + v * static_cast<double>(j) + phase));
    return sum;
  };
}

// The published account of the blur [Neophytou 2003]: two low-passes in a row lose more the more
// the volume holds, Keys' filter loses least, and what auto does loses nothing to speak of.
TEST(PostConvolution, WhatTheWaysLose) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  double cubic_of_smooth = 0, cubic_of_rough = 0;
  for (const double limit : {0.15, 0.3, 0.45}) {
    const LatticeField field = deep_field(band_limited(limit));
    const TestScene scene = slice_scene(field, 4, 27);
    const Image exact = drawn(scene, PostConvolution::kOff).image;
    const auto psnr = [&](PostConvolution how) {
      return compare(drawn(scene, how).image, exact).psnr_db;
    };
    const double bilinear = psnr(PostConvolution::kBilinear);
    const double gaussian = psnr(PostConvolution::kGaussian);
    const double cubic = psnr(PostConvolution::kCubic), kept = psnr(PostConvolution::kAuto);
    std::printf(
        "[loss      ] up to %.2f cycles: bilinear %.1f, Gaussian %.1f, cubic %.1f, auto %.1f dB\n",
        limit, bilinear, gaussian, cubic, kept);
    EXPECT_GT(bilinear, gaussian);
    EXPECT_GT(cubic, bilinear + 2);
    EXPECT_GT(kept, cubic + 10);
    if (limit < 0.2) cubic_of_smooth = cubic;
    cubic_of_rough = cubic;
  }
  EXPECT_GT(cubic_of_smooth, cubic_of_rough + 10);
}

// Convolving after classification and light is wrong: a picture of a node per spacing, brought up
// by the same filter that auto uses.
TEST(PostConvolution, ConvolvingAfterShadingIsWorse) {
  OVOID_NIGHTLY_ON_DEVICE();
  const LatticeField field = sample_field("head");
  const ValueRange range = field.value_range();
  TestScene scene = magnified(field, semi_transparent_look(range.lo, range.hi), true, 8, 160, 160);
  const Image exact = drawn(scene, PostConvolution::kOff).image;
  const double before = compare(drawn(scene, PostConvolution::kAuto).image, exact).psnr_db;
  // Every third pixel: as far apart as auto's nodes.
  constexpr int kStep = 3;
  Image after = exact;
  const auto lagrange = [](double t, int k) {
    double weight = 1;
    for (int m = -2; m <= 3; ++m) {
      if (m != k) weight *= (t - m) / (k - m);
    }
    return weight;
  };
  for (int y = 12; y < 148; ++y) {
    for (int x = 12; x < 148; ++x) {
      for (std::size_t c = 0; c < 4; ++c) {
        double sum = 0;
        for (int j = -2; j <= 3; ++j) {
          for (int i = -2; i <= 3; ++i) {
            const int from_x = (x / kStep + i) * kStep, from_y = (y / kStep + j) * kStep;
            sum += lagrange(x % kStep / 3.0, i) * lagrange(y % kStep / 3.0, j) *
                   static_cast<double>(
                       exact.rgba[static_cast<std::size_t>(4 * (from_y * 160 + from_x)) + c]);
          }
        }
        after.rgba[static_cast<std::size_t>(4 * (y * 160 + x)) + c] = static_cast<float>(sum);
      }
    }
  }
  const double behind = compare(after, exact).psnr_db;
  std::printf("[loss      ] convolved before classification %.1f dB, after shading %.1f dB\n",
              before, behind);
  EXPECT_GT(before, behind + 6);
}

// A ramp has one gradient: a plane through it, shaded, is one colour, without a trace of the nodes.
TEST(PostConvolution, FlatSurfacesHaveNoPattern) {
  OVOID_NIGHTLY_ON_DEVICE();
  const LatticeField field =
      make_stored_field({32, 32, 32},
                        [](std::int64_t i, std::int64_t j, std::int64_t k) {
                          return (static_cast<double>(i) + 0.7 * static_cast<double>(j) +
                                  1.9 * static_cast<double>(k)) /
                                 120;
                        },
                        {});
  Look look = uniform_look(1);
  look.shade = true;
  look.transfer_function.opacities = {{0.44, 0}, {0.4401, 1}};
  TestScene scene = magnified(field, look, true, 16, 100, 90);
  scene.options.sampling_distance = 0.2;
  const Frame fast = drawn(scene, PostConvolution::kAuto);
  EXPECT_LT(fast.profile.samples_reconstructed,
            drawn(scene, PostConvolution::kOff).profile.samples_reconstructed);
  float least = 1, greatest = 0;
  for (int y = 20; y < 70; ++y) {
    for (int x = 20; x < 80; ++x) {
      const float red = fast.image.rgba[static_cast<std::size_t>(4 * (y * 100 + x))];
      least = std::min(least, red);
      greatest = std::max(greatest, red);
    }
  }
  EXPECT_GT(least, 0.2);
  EXPECT_LT(greatest - least, 1.0 / 255);
}

// Views and pictures at the ends of what is possible: a thousand pixels per spacing, fewer pixels
// than a filter has taps, a hundred spacings per pixel, and a picture too wide for one row of
// patches to be anything but sliced.
TEST(PostConvolution, ExtremesAgree) {
  OVOID_NIGHTLY_ON_DEVICE();
  const LatticeField field = shells_field();
  struct Extreme {
    double pixels;
    int width, height;
  };
  for (const Extreme& at : {Extreme{1000, 64, 50}, Extreme{8, 3, 2}, Extreme{8, 1, 1},
                            Extreme{0.01, 40, 40}, Extreme{6, 20000, 3}}) {
    for (const bool is_parallel : {true, false}) {
      TestScene scene = magnified(field, semi_transparent_look(0, 1), is_parallel, at.pixels,
                                  at.width, at.height);
      for (const PostConvolution how : {PostConvolution::kAuto, PostConvolution::kCubic}) {
        if (is_published(how)) scene.options.classification = Classification::kSampled;
        SCOPED_TRACE(fmt::format("{} pixels per spacing, {} x {}", at.pixels, at.width, at.height));
        try {
          const Image exact = drawn(scene, PostConvolution::kOff).image;
          const ImageDifference difference = compare(drawn(scene, how).image, exact);
          EXPECT_GE(difference.psnr_db, how == PostConvolution::kAuto ? view::kNodeDecibels : 30)
              << difference.to_string();
        } catch (const Error& error) {
          // Software drivers refuse more kernels for a sample than they can sum in time.
          if (error.code() != ErrorCode::kUnsupported || !is_on_device() ||
              is_on_graphics_processor())
            ADD_FAILURE() << error.what();
        }
      }
    }
  }
}

}  // namespace post_convolution_test
}  // namespace ovoid::test
