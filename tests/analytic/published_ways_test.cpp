// SPDX-License-Identifier: Apache-2.0
// The published ways of post-convolution, the reference against sums worked out by hand.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>

#include "ovoid/sampler.h"
#include "support/agreement.h"
#include "support/hand_view.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"
#include "support/tolerances.h"
#include "support/where.h"

namespace ovoid::test {
namespace published_ways_test {

VolumeFunction noise(double lo, double hi) {
  return [lo, hi](std::int64_t i, std::int64_t j, std::int64_t k) {
    std::minstd_rand random(static_cast<unsigned>(1 + i + 64 * j + 4096 * k));
    random.discard(5);
    return lo + (hi - lo) * std::uniform_real_distribution<double>()(random);
  };
}

constexpr Index3 kNoiseDims{36, 34, 30};

struct SampledField {
  LatticeField field;
  FieldSampler sampler;
  Mat3 index_from_world;
};

SampledField noise_field() {
  FieldSetup setup;
  setup.world_from_index = oblique_axes();
  const LatticeField field = make_field(kNoiseDims, noise(0.2, 0.8), setup);
  return {field, FieldSampler{Field(field)}, oblique_axes().linear().inverse()};
}

// A few spacings of the field's middle, several pixels each; in perspective from near by, so that
// groups of sheets differ. A single sheet of it shows.
TestScene sheet_scene(const LatticeField& field, const Look& look, bool is_parallel,
                      std::int64_t sheet) {
  const Vec3 center = field.world_bounds().center();
  const Vec3 direction(0.48, -0.31, 0.82);
  TestScene scene{field,
                  is_parallel ? parallel_camera(center, direction, 3)
                              : perspective_camera(center, direction, 3, 12),
                  look, picture(40, 34, 0.3)};
  scene.options.clip_planes = HandView(scene.camera, scene.options).planes_around(sheet);
  return scene;
}

// Of the same pixels fewer.
void crop(TestScene& scene, int width, int height) {
  scene.camera.parallel_scale *= 1.0 * height / scene.options.height;
  scene.camera.view_angle *= 1.0 * height / scene.options.height;
  scene.options.width = width;
  scene.options.height = height;
}

// Before, at and behind the bounds of groups.
constexpr std::array<std::int64_t, 5> kSheets = {-17, -16, -1, 3, 16};

template <class Body>
void for_each_sheet_scene(const LatticeField& field, const Look& look, const Body& body) {
  for (const bool is_parallel : {true, false}) {
    for (const std::int64_t sheet : kSheets) {
      TestScene scene = sheet_scene(field, look, is_parallel, sheet);
      for (const PostConvolution how : kPublishedWays) {
        scene.options.post_convolution = how;
        SCOPED_TRACE(std::string(name_of(how)) + (is_parallel ? ", parallel" : ", perspective") +
                     ", sheet " + std::to_string(sheet));
        body(scene, sheet);
      }
    }
  }
}

struct Spot {
  int x, y;
};
std::vector<Spot> some_spots(const RenderOptions& options, int count) {
  std::vector<Spot> spots;
  for (int n = 0; n < count; ++n)
    spots.push_back({(37 * n + 3) % options.width, (23 * n + 7) % options.height});
  return spots;
}

// Fails if nodes lie elsewhere, a group of sheets has another pitch, or a filter is another one.
TEST(PublishedWaysByHand, ReferenceSumsNodes) {
  OVOID_NOT_UNDER_ASAN();
  const SampledField noisy = noise_field();
  for_each_sheet_scene(noisy.field, with_mode(gray_look(0, 1), Mode::kMean),
                       [&](const TestScene& scene, std::int64_t sheet) {
                         const HandView view(scene.camera, scene.options);
                         const double p = view.node_step(noisy.index_from_world, sheet);
                         const Image image = draw(scene, Backend::kReference).image;
                         for (const Spot& at : some_spots(scene.options, 12)) {
                           const double expected = filtered<double>(
                               scene.options.post_convolution, at.x / p, at.y / p, 0.0,
                               [&](int i, int j) {
                                 return noisy.sampler.at(view.place(p * i, p * j, sheet)).value;
                               });
                           EXPECT_NEAR(pixel(image, at.x, at.y).r(), expected, kFloatRelative);
                         }
                       });
}

// Opacity is the gradient's length, and a sample's path the unit distance.
Look gradient_look(double path, double longest) {
  Look look = uniform_look(1);
  look.transfer_function.gradient_opacities = {{0, 0}, {longest, 1}};
  look.unit_distance = path;
  return look;
}

void expect_lengths(const TestScene& scene, const HandView& view, double longest,
                    const std::function<Vec3(const Spot&)>& gradient_at) {
  const Image image = draw(scene, Backend::kReference).image;
  for (const Spot& at : some_spots(scene.options, 6)) {
    const double opacity = gradient_at(at).norm() / longest;
    const double alpha = 1 - std::pow(1 - opacity, view.direction(at.x, at.y).norm());
    EXPECT_GT(opacity, 1e-3);
    EXPECT_LT(opacity, 1);
    EXPECT_NEAR(pixel(image, at.x, at.y).a(), alpha, kFloatRelative);
  }
}

// Fails if the nodes' gradients are not each brought up on its own.
TEST(PublishedWaysByHand, ReferenceSumsGradients) {
  OVOID_NOT_UNDER_ASAN();
  constexpr double kLongest = 2;
  const SampledField noisy = noise_field();
  for_each_sheet_scene(
      noisy.field, gradient_look(0.8 * 0.3, kLongest), [&](TestScene scene, std::int64_t sheet) {
        scene.options.gradient = GradientMethod::kExact;
        const HandView view(scene.camera, scene.options);
        const double p = view.node_step(noisy.index_from_world, sheet);
        expect_lengths(scene, view, kLongest, [&](const Spot& at) {
          return filtered<Vec3>(scene.options.post_convolution, at.x / p, at.y / p, Vec3::Zero(),
                                [&](int i, int j) {
                                  return noisy.sampler.at(view.place(p * i, p * j, sheet)).gradient;
                                });
        });
      });
}

using ValueOfNode = std::function<double(double x, double y, std::int64_t sheet)>;

// Central differences between nodes that are all defined.
Vec3 node_difference(const HandView& view, double p, int i, int j, std::int64_t sheet,
                     const ValueOfNode& value) {
  const double x = p * i, y = p * j;
  const Vec3 differences(value(x + p, y, sheet) - value(x - p, y, sheet),
                         value(x, y + p, sheet) - value(x, y - p, sheet),
                         value(x, y, sheet + 1) - value(x, y, sheet - 1));
  Mat3 derivatives;
  derivatives << view.place(x + p, y, sheet) - view.place(x - p, y, sheet),
      view.place(x, y + p, sheet) - view.place(x, y - p, sheet),
      view.place(x, y, sheet + 1) - view.place(x, y, sheet - 1);
  return derivatives.transpose().inverse() * differences;
}

// Fails if differences are taken between pixels, or nodes of the neighbouring sheets lie elsewhere.
TEST(PublishedWaysByHand, ReferenceTakesDifferencesOfNodes) {
  OVOID_NOT_UNDER_ASAN();
  constexpr double kLongest = 2;
  const SampledField noisy = noise_field();
  for_each_sheet_scene(
      noisy.field, gradient_look(0.8 * 0.3, kLongest), [&](TestScene scene, std::int64_t sheet) {
        scene.options.gradient = GradientMethod::kCentral;
        const HandView view(scene.camera, scene.options);
        const double p = view.node_step(noisy.index_from_world, sheet);
        const ValueOfNode value = [&](double x, double y, std::int64_t k) {
          return noisy.sampler.at(view.place(x, y, k)).value;
        };
        expect_lengths(scene, view, kLongest, [&](const Spot& at) {
          return filtered<Vec3>(
              scene.options.post_convolution, at.x / p, at.y / p, Vec3::Zero(),
              [&](int i, int j) { return node_difference(view, p, i, j, sheet, value); });
        });
      });
}

// The front sample of two has its own gradient, the piece behind it the field's half-way between
// them, or differences at its end.
TEST(PublishedWaysByHand, ReferenceLightsPieces) {
  OVOID_NOT_UNDER_ASAN();
  constexpr double kLongest = 2;
  const SampledField noisy = noise_field();
  for_each_sheet_scene(
      noisy.field, gradient_look(0.3, kLongest), [&](TestScene scene, std::int64_t sheet) {
        crop(scene, 22, 20);
        const HandView view(scene.camera, scene.options);
        scene.options.clip_planes = {view.planes_around(sheet - 1)[0],
                                     view.planes_around(sheet)[1]};
        scene.options.classification = Classification::kPreintegrated;
        const Spot at{7, 11};
        const double stretch = 0.9 * view.direction(at.x, at.y).norm();  // a tenth of a slab is cut
        const auto brought_up = [&](std::int64_t k, const auto& gradient) {
          const double p = view.node_step(noisy.index_from_world, k);
          return filtered<Vec3>(scene.options.post_convolution, at.x / p, at.y / p, Vec3::Zero(),
                                [&](int i, int j) { return gradient(p, i, j, k); });
        };
        const auto expect_alpha = [&](const Vec3& front, const Vec3& behind) {
          const double clear =
              std::pow((1 - front.norm() / kLongest) * (1 - behind.norm() / kLongest), stretch);
          const Image image = draw(scene, Backend::kReference).image;
          EXPECT_NEAR(pixel(image, at.x, at.y).a(), 1 - clear, kFloatRelative);
        };
        scene.options.gradient = GradientMethod::kExact;
        const Vec3 half_way =
            0.5 * (view.place(at.x, at.y, sheet - 1) + view.place(at.x, at.y, sheet));
        expect_alpha(noisy.sampler.at(view.place(at.x, at.y, sheet - 1)).gradient,
                     noisy.sampler.at(half_way).gradient);
        scene.options.gradient = GradientMethod::kCentral;
        const auto difference = [&](double p, int i, int j, std::int64_t sheet_of_node) {
          return node_difference(view, p, i, j, sheet_of_node,
                                 [&](double x, double y, std::int64_t k) {
                                   return noisy.sampler.at(view.place(x, y, k)).value;
                                 });
        };
        expect_alpha(brought_up(sheet - 1, difference), brought_up(sheet, difference));
      });
}

// Which sheets a surface lies between is the nodes' matter, where it lies between them the field's.
TEST(PublishedWaysByHand, ReferenceRefinesSurfacesOnTheField) {
  OVOID_NOT_UNDER_ASAN();
  constexpr double kIso = 0.5;
  const SampledField noisy = noise_field();
  for_each_sheet_scene(noisy.field, uniform_look(1), [&](TestScene scene, std::int64_t sheet) {
    crop(scene, 22, 20);
    const HandView view(scene.camera, scene.options);
    scene.options.clip_planes = {view.planes_around(sheet)[0], view.planes_around(sheet + 6)[1]};
    scene.look.mode = Mode::kIsosurface;
    scene.look.isovalue = kIso;
    const Image image = draw(scene, Backend::kReference).image;
    for (const Spot& at : some_spots(scene.options, 6)) {
      const auto is_below = [&](std::int64_t k, std::int64_t behind) {
        const double p = view.node_step(noisy.index_from_world, behind);
        return filtered<double>(scene.options.post_convolution, at.x / p, at.y / p, 0.0,
                                [&](int i, int j) {
                                  return noisy.sampler.at(view.place(p * i, p * j, k)).value;
                                }) < kIso;
      };
      const auto value = [&](double z) {
        return noisy.sampler
            .at(view.place(at.x, at.y, 0) + (z - view.depth(0)) * view.direction(at.x, at.y))
            .value;
      };
      std::int64_t k = sheet;
      while (k < sheet + 6 && is_below(k, k + 1) == is_below(k + 1, k + 1)) ++k;
      const double z = depth(image, at.x, at.y);
      if (k == sheet + 6) {
        EXPECT_TRUE(std::isinf(z));
        continue;
      }
      EXPECT_GE(z, view.depth(k) - 1e-5);
      EXPECT_LE(z, view.depth(k + 1) + 1e-5);
      const bool is_crossed = (value(view.depth(k)) < kIso) == is_below(k, k + 1) &&
                              (value(view.depth(k + 1)) < kIso) == is_below(k + 1, k + 1);
      if (is_crossed) {
        EXPECT_NEAR(value(z), kIso, 1e-4);
      }
    }
  });
}

// Tent times Gaussian over all samples of a lattice, its kernel the default.
double spread_by_hand(const LatticeField& field, const VolumeFunction& samples,
                      const HandView& view, double p, double x, double y, std::int64_t sheet) {
  const Affine3& axes = field.geometry().world_from_index;
  const Index3& dims = field.geometry().dims;
  const Vec3 node = view.place(x, y, sheet);
  const double distance = p * view.pixel_pitch(sheet);
  const double tau = 0.5 * (axes.linear().transpose() * view.forward).norm();
  double sum = 0, weights = 0;
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const Vec3 d =
            axes * Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)) -
            node;
        const double c = d.dot(view.forward) / tau;
        const double weight = std::max(1 - std::abs(d.dot(view.right)) / distance, 0.0) *
                              std::max(1 - std::abs(d.dot(view.up)) / distance, 0.0) *
                              (std::abs(c) <= 4 ? std::exp(-0.5 * c * c) : 0.0);
        if (weight == 0) continue;
        sum += weight * samples(i, j, k);
        weights += weight;
      }
    }
  }
  return sum / weights;
}

// A lone sample of 1: every pixel shows its share of the weights. Then noise, and its differences.
TEST(PublishedWaysByHand, ReferenceSpreadsSamples) {
  OVOID_NOT_UNDER_ASAN();
  FieldSetup setup;
  setup.world_from_index = oblique_axes();
  const VolumeFunction lone = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return i == 9 && j == 8 && k == 8 ? 1.0 : 0.0;
  };
  for (const VolumeFunction& samples : {lone, noise(0.2, 0.8)}) {
    const LatticeField field = make_field({18, 17, 16}, samples, setup);
    const Mat3 index_from_world = field.geometry().world_from_index.linear().inverse();
    for (const bool is_parallel : {true, false}) {
      for (const PostConvolution how : kPublishedWays) {
        TestScene scene =
            sheet_scene(field, with_mode(gray_look(0, 1), Mode::kMean), is_parallel, 1);
        scene.options.width = scene.options.height = 12;
        scene.camera.parallel_scale = 1.2;
        scene.camera.view_angle = 12;
        scene.options.post_convolution = how;
        scene.options.spread = Spread::kBilinear;
        const HandView view(scene.camera, scene.options);
        const double p = view.node_step(index_from_world, 1);
        const ValueOfNode value = [&](double x, double y, std::int64_t k) {
          return spread_by_hand(field, samples, view, p, x, y, k);
        };
        const Image image = draw(scene, Backend::kReference).image;
        double greatest = 0;
        for (const Spot& at : some_spots(scene.options, 9)) {
          const double expected = filtered<double>(
              how, at.x / p, at.y / p, 0.0, [&](int i, int j) { return value(p * i, p * j, 1); });
          EXPECT_NEAR(pixel(image, at.x, at.y).r(), std::max(expected, 0.0), kFloatRelative);
          greatest = std::max(greatest, expected);
        }
        EXPECT_GT(greatest, 0.01);
        scene.look = gradient_look(0.8 * 0.3, 2);
        const Image slopes = draw(scene, Backend::kReference).image;
        const Spot at{7, 4};
        const double length =
            filtered<Vec3>(how, at.x / p, at.y / p, Vec3::Zero(), [&](int i, int j) {
              return node_difference(view, p, i, j, 1, value);
            }).norm();
        EXPECT_NEAR(pixel(slopes, at.x, at.y).a(),
                    1 - std::pow(1 - length / 2, view.direction(at.x, at.y).norm()),
                    kFloatRelative);
      }
    }
  }
}

// Along an axis every node sees its neighbours alike, so a ramp is a ramp on the nodes, which a
// tent and Keys' filter keep, but not a sum of Gaussians.
TEST(PublishedWaysByHand, RampsStayRamps) {
  OVOID_NOT_UNDER_ASAN();
  const LatticeField field =
      make_field({30, 30, 30}, [](std::int64_t i, std::int64_t j, std::int64_t) {
        return (static_cast<double>(i) + 0.5 * static_cast<double>(j)) / 45;
      });
  TestScene scene{field, parallel_camera(field.world_bounds().center(), Vec3(0, 0, 1), 17 / 5.3),
                  with_mode(gray_look(0, 1), Mode::kMean), picture(40, 34, 1)};
  scene.camera.view_up = Vec3(0, 1, 0);
  scene.options.clip_planes = HandView(scene.camera, scene.options).planes_around(0);
  for (const PostConvolution how : kPublishedWays) {
    scene.options.post_convolution = how;
    const Image image = draw(scene, Backend::kReference).image;
    const double step_x = std::abs(pixel(image, 39, 0).r() - pixel(image, 0, 0).r()) / 39;
    double greatest = 0;
    for (int y = 0; y < 34; ++y) {
      for (int x = 1; x < 39; ++x) {
        const double step = std::abs(pixel(image, x, y).r() - pixel(image, x - 1, y).r());
        greatest = std::max(greatest, std::abs(step - step_x));
      }
    }
    if (how == PostConvolution::kGaussian) {
      EXPECT_GT(greatest, 0.05 * step_x);
    } else {
      EXPECT_LT(greatest, 2 * kFloatRelative);
      EXPECT_NEAR(step_x, 1 / 45.0 / 5.3, kFloatRelative);
    }
  }
}

// Exactly where one of 6 x 6 nodes is undefined, pixels are those of `off`.
TEST(PublishedWaysByHand, PixelsNearUndefinedNodesAreWorkedOut) {
  OVOID_NOT_UNDER_ASAN();
  const VolumeFunction samples = noise(0.2, 0.8);
  const LatticeField field =
      make_field(kNoiseDims, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        const bool is_hole =
            std::abs(i - 18) <= 1 && std::abs(j - 17) <= 1 && std::abs(k - 15) <= 1;
        return is_hole ? kMissing : samples(i, j, k);
      });
  const FieldSampler sampler{Field(field)};
  // Of samples, as the published ways are: means would be those of pieces between planes.
  TestScene scene = sheet_scene(field, gray_look(0, 1), false, 2);
  scene.options.classification = Classification::kSampled;
  crop(scene, 80, 68);
  scene.options.post_convolution = PostConvolution::kOff;
  const Image exact = draw(scene, Backend::kReference).image;
  scene.options.post_convolution = PostConvolution::kAuto;
  EXPECT_EQ(draw(scene, Backend::kReference).image.rgba, exact.rgba);
  const HandView view(scene.camera, scene.options);
  const double p = view.node_step(Mat3::Identity(), 2);
  for (const PostConvolution how : kPublishedWays) {
    scene.options.post_convolution = how;
    const Image image = draw(scene, Backend::kReference).image;
    int num_alone = 0, num_same = 0;
    for (int y = 0; y < scene.options.height; ++y) {
      for (int x = 0; x < scene.options.width; ++x) {
        bool is_alone = false;
        for (int n = 0; n < 36; ++n) {
          const Vec3 node = view.place(p * (std::floor(x / p) - 2 + n % 6),
                                       p * (std::floor(y / p) - 2 + n / 6), 2);
          is_alone = is_alone || !sampler.at(node).is_defined;
        }
        const bool is_same = pixel(image, x, y).rgba == pixel(exact, x, y).rgba;
        num_alone += is_alone ? 1 : 0;
        num_same += is_same ? 1 : 0;
        EXPECT_TRUE(is_same || !is_alone) << x << ", " << y;
      }
    }
    EXPECT_GT(num_alone, 100);
    EXPECT_LT(num_alone, 4500);
    EXPECT_LT(num_same, num_alone + 5);
  }
}

TEST(PublishedWaysByHand, BelowTheLeastPitchEveryPixelIsWorkedOut) {
  OVOID_NOT_UNDER_ASAN();
  const LatticeField field = make_field(kNoiseDims, noise(0.2, 0.8));
  for (const double pixels : {1.44, 1.46}) {
    TestScene scene{
        field, parallel_camera(field.world_bounds().center(), Vec3(0.48, -0.31, 0.82), 9 / pixels),
        with_mode(gray_look(0, 1), Mode::kMaximum), picture(20, 18, 1)};
    scene.options.post_convolution = PostConvolution::kOff;
    const Image exact = draw(scene, Backend::kReference).image;
    for (const PostConvolution how : kPublishedWays) {
      scene.options.post_convolution = how;
      EXPECT_EQ(draw(scene, Backend::kReference).image.rgba == exact.rgba, pixels < 1.45);
    }
  }
}

// Up to three sigmas from where a ball is nearest to a sheet's pixels.
std::vector<Spot> spots_around(const RenderOptions& options, const HandView& view,
                               std::int64_t sheet, const Vec3& center, double sigma) {
  Spot nearest{0, 0};
  const auto distance = [&](const Spot& at) {
    return (view.place(at.x, at.y, sheet) - center).norm();
  };
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      if (distance({x, y}) < distance(nearest)) nearest = {x, y};
    }
  }
  const double half = 0.5 * sigma / view.pixel_pitch(sheet);
  std::vector<Spot> spots;
  for (const Spot& to : {Spot{0, 0}, {1, 1}, {-2, 1}, {0, -3}, {4, 2}, {-1, 5}, {-5, -3}}) {
    spots.push_back(
        {std::clamp(nearest.x + static_cast<int>(std::round(half * to.x)), 0, options.width - 1),
         std::clamp(nearest.y + static_cast<int>(std::round(half * to.y)), 0, options.height - 1)});
  }
  return spots;
}

// Kernels that are scattered know no nodes.
TEST(PublishedWaysByHand, ScatteringKnowsNodesToo) {
  OVOID_NOT_UNDER_ASAN();
  TestScene scene =
      sheet_scene(noise_field().field, with_mode(gray_look(0, 1), Mode::kMean), true, 3);
  const Image off = draw(scene, Backend::kReference).image;
  scene.options.post_convolution = PostConvolution::kCubic;
  const Image cubic = draw(scene, Backend::kReference).image;
  EXPECT_NE(cubic.rgba, off.rgba);
  scene.options.evaluate = Evaluate::kScatter;
  EXPECT_EQ(draw(scene, Backend::kReference).image.rgba, cubic.rgba);
  EXPECT_TRUE(agrees_with(cubic, scene, "scattered"));
}

// One ball on the level that its sigma has half a sample on at the sheet's depth, brought down
// level by level.
void check_levels(const TestScene& scene, std::int64_t sheet, const Vec3& center, double sigma) {
  const HandView view(scene.camera, scene.options);
  const PostConvolution how = scene.options.post_convolution;
  int level = 0;
  while (level < 6 && sigma / view.pixel_pitch(sheet) >= 0.5 * (2 << level)) ++level;
  const std::function<double(int, int, int)> sample = [&](int l, int i, int j) {
    // A quarter of a coarse sample before or behind one.
    if (l < level)
      return filtered<double>(how, 0.5 * i - 0.25, 0.5 * j - 0.25, 0.0,
                              [&](int ci, int cj) { return sample(l + 1, ci, cj); });
    const double step = 1 << l, middle = 0.5 * (step - 1);
    const Vec3 place = view.place(step * i + middle, step * j + middle, sheet);
    const double q = (place - center).squaredNorm() / (sigma * sigma);
    return q <= 16 ? 0.5 * (std::exp(-0.5 * q) - std::exp(-8.0) * (1 + 0.5 * (16 - q))) : 0.0;
  };
  const Image image = draw(scene, Backend::kReference).image;
  double greatest = 0;
  for (const Spot& at : spots_around(scene.options, view, sheet, center, sigma)) {
    const double expected = sample(0, at.x, at.y);
    const Pixel there = pixel(image, at.x, at.y);
    const bool is_defined = expected != 0;
    EXPECT_EQ(there.a() > 0, is_defined);
    EXPECT_NEAR(there.r(), is_defined ? expected + 0.1 : 0, kFloatRelative) << "level " << level;
    greatest = std::max(greatest, expected);
  }
  EXPECT_GT(greatest, 0.01);
}

TEST(PublishedWaysByHand, ReferenceBringsLevelsDown) {
  OVOID_NOT_UNDER_ASAN();
  constexpr double kPixels = 7;  // per world unit, at the focal point
  const Vec3 center(0.1, -0.2, 0.3), focal_point(0.1, 0.05, 0.3), direction(0.48, -0.31, 0.82);
  for (const double sigma_px : {0.97, 1.9, 2.1, 4.5}) {
    KernelNumbers ball;
    ball.shape = KernelShape::kBalls;
    const double sigma = static_cast<double>(static_cast<float>(sigma_px / kPixels));
    ball.add(center, Vec3::Constant(sigma), Mat3::Identity(), {0.5F});
    ball.weights[0] = 1;
    const KernelField field(ball.source(), Reconstruction::kSum);
    for (const bool is_parallel : {true, false}) {
      for (const std::int64_t sheet : {-8, 2, 8}) {
        TestScene scene{field,
                        is_parallel ? parallel_camera(focal_point, direction, 17 / kPixels)
                                    : perspective_camera(focal_point, direction, 17 / kPixels, 2),
                        with_mode(gray_look(-0.1, 0.9), Mode::kMean), picture(41, 34, 0.2 * sigma)};
        scene.options.clip_planes = HandView(scene.camera, scene.options).planes_around(sheet);
        for (const PostConvolution how : kPublishedWays) {
          scene.options.post_convolution = how;
          SCOPED_TRACE(std::string(name_of(how)) + ", sigma " + std::to_string(sigma_px) +
                       (is_parallel ? ", parallel" : ", perspective"));
          check_levels(scene, sheet, center, sigma);
        }
      }
    }
  }
}

}  // namespace published_ways_test
}  // namespace ovoid::test
