// SPDX-License-Identifier: Apache-2.0
// Label maps: which label holds where, and what rays meet, against the definition in
// docs/numerics.md, "Labels", in double precision without bricks, cells or steps. Fails if a
// surface lies elsewhere, faces another way than a sphere's does, or if something thin is lost.
#include "ovoid/labels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "labels/label_rays.h"
#include "model/own_array.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "support/volumes.h"

namespace ovoid {
namespace label_map_test {

using labels::Bodies;
using labels::LabelCrossing;
using labels::LabelRay;
using labels::Rank;
using LabelAt = std::function<float(std::int64_t i, std::int64_t j, std::int64_t k)>;

LatticeField label_field(const Index3& dims, const LabelAt& label_at) {
  std::vector<float> values;
  for (std::int64_t k = 0; k < dims[2]; ++k)
    for (std::int64_t j = 0; j < dims[1]; ++j)
      for (std::int64_t i = 0; i < dims[0]; ++i) values.push_back(label_at(i, j, k));
  Dataset dataset;
  dataset.lattice.dims = dims;
  dataset.arrays = {model::array_of_numbers("labels", 1, std::move(values))};
  LatticeModelOptions options;
  options.kernel = kLabelKernel;
  return make_lattice_field(dataset, options);
}

std::shared_ptr<const LabelMap> label_map(const Index3& dims, const LabelAt& label_at) {
  return make_label_map(label_field(dims, label_at), 1);
}

std::shared_ptr<const LabelMap> ball_map(double radius, const Vec3& center, std::int64_t side) {
  return label_map({side, side, side}, [&](auto i, auto j, auto k) {
    const Vec3 at(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
    return (at - center).norm() <= radius ? 1.0F : 0.0F;
  });
}

// All labels but the first are opaque.
Bodies all_opaque(const LabelMap& map) {
  Bodies bodies;
  bodies.all = {{false, false}, {true, true}};
  for (std::size_t r = 0; r < map.labels().size(); ++r) bodies.of_rank.push_back(r == 0 ? 0 : 1);
  return bodies;
}

// --- the definition

double spline(double x) {
  const double a = std::abs(x);
  if (a >= 2) return 0;
  return a < 1 ? (4 - 6 * a * a + 3 * a * a * a) / 6 : std::pow(2 - a, 3) / 6;
}

// Scores of labels that nothing of is lost; ranks of samples, which go on beyond the map.
class ScoreByDefinition {
 public:
  explicit ScoreByDefinition(const LabelMap& map) : map_(map) {
    double sum = 0;
    for (int i = -2; i <= 2; ++i) sum += std::exp(-0.5 * i * i / 0.49);
    for (int i = -2; i <= 2; ++i)
      weights_[static_cast<std::size_t>(i + 2)] = std::exp(-0.5 * i * i / 0.49) / sum;
  }

  // Of labels that `is_in` says are meant.
  double at(const Vec3& u, const std::function<bool(Rank)>& is_in) const {
    std::array<std::array<double, 8>, 3> kernel{};  // the two smoothings along each axis
    std::array<std::int64_t, 3> first{};
    for (std::size_t a = 0; a < 3; ++a) {
      const double place = u[static_cast<Eigen::Index>(a)];
      first[a] = static_cast<std::int64_t>(std::floor(place)) - 3;
      for (std::size_t i = 0; i < 8; ++i) {
        for (int g = -2; g <= 2; ++g)
          kernel[a][i] += weights_[static_cast<std::size_t>(g + 2)] *
                          spline(place - static_cast<double>(first[a] + static_cast<int>(i) + g));
      }
    }
    double score = 0;
    for (std::size_t z = 0; z < 8; ++z)
      for (std::size_t y = 0; y < 8; ++y)
        for (std::size_t x = 0; x < 8; ++x) {
          const Rank rank =
              map_.grid().rank_at(first[0] + static_cast<int>(x), first[1] + static_cast<int>(y),
                                  first[2] + static_cast<int>(z));
          if (is_in(rank)) score += kernel[0][x] * kernel[1][y] * kernel[2][z];
        }
    return score;
  }

 private:
  const LabelMap& map_;
  std::array<double, 5> weights_{};
};

// Bodies along a ray, as trace() and as the definition have them: nowhere where one of two leads by
// more than a little do they differ. Returns how many crossings there were.
int expect_bodies_of_definition(const LabelMap& map, const Bodies& bodies, const LabelRay& ray) {
  constexpr double kClear = 0.03;
  constexpr int kPlaces = 400;
  const ScoreByDefinition scores(map);
  std::vector<LabelCrossing> crossings;
  Rank rank = 0;
  Bodies::Id body = labels::trace(map.grid(), bodies, ray, &rank, crossings);
  std::size_t next = 0;
  for (int i = 0; i <= kPlaces; ++i) {
    const double t = std::lerp(ray.begin, ray.end, static_cast<double>(i) / kPlaces);
    while (next < crossings.size() && crossings[next].t <= t) body = crossings[next++].behind;
    const Vec3 place = ray.origin + t * ray.direction;
    std::vector<double> of_body;
    for (std::size_t b = 0; b < bodies.all.size(); ++b)
      of_body.push_back(scores.at(place, [&](Rank r) { return bodies.of(r) == b; }));
    const auto best = std::max_element(of_body.begin(), of_body.end());
    const double lead = *best - of_body[body];
    EXPECT_LT(lead, kClear) << "at " << place.transpose() << ", body " << body << ", expected "
                            << best - of_body.begin();
    if (bodies.all[body].is_opaque) break;
  }
  return static_cast<int>(crossings.size());
}

// Three blobs that overlap, in a map whose edges they cross, and a background.
float blob_label(std::int64_t i, std::int64_t j, std::int64_t k) {
  const Vec3 at(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
  const std::array<Vec3, 3> centers{Vec3(8, 9, 10), Vec3(15, 12, 9), Vec3(11, 19, 14)};
  for (std::size_t b = 0; b < centers.size(); ++b)
    if ((at - centers[b]).norm() < 6.3 + 0.7 * static_cast<double>(b))
      return static_cast<float>(3 * b + 2);
  return 0;
}

LabelRay random_ray(std::mt19937& random, const Vec3& size) {
  std::uniform_real_distribution<double> unit(0, 1);
  LabelRay ray;
  const Vec3 from(unit(random) * size.x(), unit(random) * size.y(), -0.5);
  const Vec3 to(unit(random) * size.x(), unit(random) * size.y(), size.z() - 0.5);
  ray.origin = from;
  ray.direction = (to - from) / 20;
  ray.end = 20;
  return ray;
}

TEST(LabelMap, RaysMeetTheBodiesOfTheDefinition) {
  const auto map = label_map({27, 25, 22}, blob_label);
  ASSERT_EQ(map->labels(), (std::vector<int>{0, 2, 5, 8}));
  Bodies apart;  // nothing is opaque, all are bodies of their own
  for (std::size_t r = 0; r < 4; ++r) {
    apart.all.push_back({r > 0, false});
    apart.of_rank.push_back(static_cast<Bodies::Id>(r));
  }
  Bodies two = all_opaque(*map);
  two.all[1].is_opaque = false;
  std::mt19937 random(20);
  int num_apart = 0;
  int num_two = 0;
  for (int i = 0; i < 60; ++i) {
    const LabelRay ray = random_ray(random, {26, 24, 22});
    num_apart += expect_bodies_of_definition(*map, apart, ray);
    num_two += expect_bodies_of_definition(*map, two, ray);
  }
  EXPECT_GT(num_two, 60);
  EXPECT_GT(num_apart, num_two);
}

TEST(LabelMap, NothingIsSearchedBehindAnOpaqueSurface) {
  const auto map = label_map({27, 25, 22}, blob_label);
  std::mt19937 random(21);
  for (int i = 0; i < 40; ++i) {
    const LabelRay ray = random_ray(random, {26, 24, 22});
    std::vector<LabelCrossing> crossings;
    Rank rank = 0;
    labels::trace(map->grid(), all_opaque(*map), ray, &rank, crossings);
    EXPECT_LE(crossings.size(), 1U);
  }
}

// Where several labels are one body, too, as at a cut.
TEST(LabelMap, ARayBeginsInTheLabelThatWinsThere) {
  const auto map = label_map({27, 25, 22}, blob_label);
  Bodies one;
  one.all = {{true, false}};
  one.of_rank.assign(4, 0);
  std::mt19937 random(22);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 400; ++i) {
    const Vec3 at(26 * unit(random), 24 * unit(random), 21 * unit(random));
    std::vector<LabelCrossing> crossings;
    Rank rank = labels::kNoLabel;
    labels::trace(map->grid(), one, {at, Vec3::UnitZ(), 0, 21 - at.z()}, &rank, crossings);
    EXPECT_EQ(map->labels()[rank], map->label_at(at)) << at.transpose();
    EXPECT_TRUE(crossings.empty());
  }
}

// Rays from all sides towards the middle of a ball.
TEST(LabelMap, ASpheresNormalsAreWithinFiveDegrees) {
  for (const double radius : {6.0, 10.0, 20.0, 40.0, 60.0}) {
    const auto side = static_cast<std::int64_t>(2 * radius + 16);
    const Vec3 center = Vec3::Constant(0.5 * static_cast<double>(side)) + Vec3(0.13, 0.37, -0.21);
    const auto map = ball_map(radius, center, side);
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    double worst = 0;
    double sum = 0;
    constexpr int kRays = 4000;
    for (int i = 0; i < kRays; ++i) {
      Vec3 from(normal(random), normal(random), normal(random));
      if (i % 4 == 0) from = Vec3(1, 0.3 * normal(random), 0.3 * normal(random));  // terraces
      from.normalize();
      const LabelRay ray{center + (radius + 5) * from, -from, 0, radius};
      std::vector<LabelCrossing> crossings;
      Rank rank = 0;
      labels::trace(map->grid(), all_opaque(*map), ray, &rank, crossings);
      ASSERT_EQ(crossings.size(), 1U);
      EXPECT_EQ(crossings[0].rank, 1);
      const double miss = radius + 5 - crossings[0].t - radius;
      EXPECT_LT(std::abs(miss), 0.55);
      sum += miss;
      const double cosine = -crossings[0].into.normalized().dot(from);
      worst = std::max(worst, std::acos(std::clamp(cosine, -1.0, 1.0)));
    }
    EXPECT_LT(worst * 180 / std::numbers::pi, 5.0) << "radius " << radius;
    EXPECT_LT(std::abs(sum / kRays), 0.2) << "radius " << radius;
  }
}

TEST(LabelMap, ALineOneSampleThinIsKept) {
  const auto map =
      label_map({40, 20, 20}, [](auto, auto j, auto k) { return j == 9 && k == 11 ? 7.0F : 0.0F; });
  for (double x = 2; x < 38; x += 0.37) {
    EXPECT_EQ(map->label_at({x, 9, 11}), 7) << x;
    const LabelRay ray{{x, 0, 11}, Vec3::UnitY(), 0, 19};
    std::vector<LabelCrossing> crossings;
    Rank rank = 0;
    labels::trace(map->grid(), all_opaque(*map), ray, &rank, crossings);
    ASSERT_EQ(crossings.size(), 1U) << x;
    EXPECT_NEAR(crossings[0].t, 8.7, 0.3);
  }
  EXPECT_EQ(map->label_at({20, 8, 11}), 0);
}

TEST(LabelMap, AWallOneSampleThinIsKeptAndASingleSampleIsNot) {
  const auto map = label_map({30, 30, 30}, [](auto i, auto j, auto k) {
    if (i == 8) return 1.0F;
    return i == 20 && j == 15 && k == 15 ? 2.0F : 0.0F;
  });
  EXPECT_EQ(map->label_at({8, 14.6, 3.3}), 1);
  EXPECT_EQ(map->label_at({20, 15, 15}), 0);
}

TEST(LabelMap, ALabelIsFoundUpToTheFacesOfTheMap) {
  const auto map =
      label_map({16, 9, 5}, [](auto i, auto, auto) { return i < 8 ? -3.0F : 1000.0F; });
  EXPECT_EQ(map->labels(), (std::vector<int>{-3, 1000}));
  EXPECT_EQ(map->label_at({-0.49, 0, 4.49}), -3);
  EXPECT_EQ(map->label_at({15.49, 8.49, -0.49}), 1000);
  EXPECT_EQ(map->label_at({15.51, 8, 0}), std::nullopt);
}

TEST(LabelMap, AMissingSampleHasNoLabel) {
  const auto map = label_map({24, 24, 24}, [](auto i, auto, auto) {
    return i < 12 ? 4.0F : std::numeric_limits<float>::quiet_NaN();
  });
  EXPECT_EQ(map->labels(), std::vector<int>{4});
  EXPECT_EQ(map->label_at({3, 12, 12}), 4);
  EXPECT_EQ(map->label_at({20, 12, 12}), std::nullopt);
}

// More than a byte holds, and more than a brick tells apart.
TEST(LabelMap, ManyLabelsAreTold) {
  const auto cell = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return static_cast<float>(1 + i / 4 + 10 * (j / 4) + 100 * (k / 4));
  };
  const auto map = label_map({40, 40, 12}, cell);
  EXPECT_EQ(map->labels().size(), 300U);
  int num_right = 0;
  for (std::int64_t i = 1; i < 40; i += 4) {
    for (std::int64_t j = 1; j < 40; j += 4) {
      for (std::int64_t k = 1; k < 12; k += 4) {
        const Vec3 at(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        if (map->label_at(at + Vec3::Constant(0.5)) == static_cast<int>(cell(i, j, k))) ++num_right;
      }
    }
  }
  EXPECT_EQ(num_right, 300);
}

void expect_no_map(const LatticeField& field, ErrorCode code, const std::string& part) {
  try {
    make_label_map(field);
    ADD_FAILURE() << "no error, expected " << part;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code);
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(LabelMap, WhatIsNoLabelIsRefused) {
  expect_no_map(label_field({4, 4, 4}, [](auto i, auto, auto) { return 0.25F * float(i); }),
                ErrorCode::kInvalidArgument, "0.25");
  expect_no_map(label_field({4, 4, 4}, [](auto, auto, auto) { return 1e9F; }),
                ErrorCode::kInvalidArgument, "1e+09");
  expect_no_map({}, ErrorCode::kInvalidArgument, "empty");
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(make_label_map(label_field({40, 40, 40}, blob_label), 2, stop.get_token()), Error);
}

TEST(LabelMap, StylesAreTheTablesWhereItSaysSo) {
  const auto map = label_map({27, 25, 22}, blob_label);
  LabelEntry entry;
  entry.label = 5;
  entry.name = "heart";
  entry.color = Rgb{1, 0, 0};
  entry.opacity = 0.5;
  const std::vector<LabelStyle> styles = label_styles(*map, {entry, {99, "elsewhere", {}, {}}});
  ASSERT_EQ(styles.size(), 4U);
  EXPECT_EQ(styles[0].opacity, 0);  // the background
  EXPECT_EQ(styles[1].opacity, 1);
  EXPECT_EQ(styles[2].name, "heart");
  EXPECT_EQ(styles[2].color, (Rgb{1, 0, 0}));
  EXPECT_EQ(styles[2].opacity, 0.5);
  EXPECT_NE(styles[1].color, styles[3].color);
}

TEST(LabelMap, TheLookByValueIsTheStyles) {
  const auto map = label_map({27, 25, 22}, blob_label);
  std::vector<LabelStyle> styles = label_styles(*map);
  styles[1].opacity = 0;  // 2
  styles[2].color = {1, 0, 0};
  styles[2].opacity = 0.5;
  const TransferFunction tf = label_look(styles).transfer_function;
  EXPECT_EQ(tf.opacity_at(0), 0);
  EXPECT_EQ(tf.opacity_at(2), 0);
  EXPECT_NEAR(tf.opacity_at(5), 0.495, 1e-9);
  EXPECT_NEAR(tf.opacity_at(8), 0.99, 1e-9);
  EXPECT_EQ(tf.color_at(5), (Rgb{1, 0, 0}));
}

// No label is 0: what the faces show is not drawn, whatever the corners are.
TEST(LabelMap, TheBackgroundIsWhatTheFacesShow) {
  const auto map = label_map({20, 20, 20}, [](auto i, auto j, auto k) {
    const bool is_corner = i % 19 == 0 && j % 19 == 0 && k % 19 == 0;
    return is_corner ? 9.0F : i > 5 && i < 14 && j > 5 && j < 14 && k > 5 && k < 14 ? 3.0F : 7.0F;
  });
  for (const LabelStyle& style : label_styles(*map))
    EXPECT_EQ(style.opacity, style.label == 7 ? 0 : 1) << style.label;
}

TEST(LabelMap, StylesThatAreWrongAreNamed) {
  LabelSurfaces surfaces;
  surfaces.styles = {{.label = 3}, {.label = 3}};
  EXPECT_THROW(surfaces.validate(), Error);
  surfaces.styles = {{.label = 3, .opacity = 1.5}};
  EXPECT_THROW(surfaces.validate(), Error);
  surfaces.styles = {{.label = 3, .color = {0, 0, -1}}};
  EXPECT_THROW(surfaces.validate(), Error);
}

}  // namespace label_map_test
}  // namespace ovoid
