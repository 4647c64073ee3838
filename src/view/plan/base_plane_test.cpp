// SPDX-License-Identifier: Apache-2.0
#include "view/plan/base_plane.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/agreement.h"
#include "support/scenes.h"
#include "support/volumes.h"
#include "view/plan/frame_plan.h"
#include "view/plan/view_lattice.h"

namespace ovoid::view {
namespace base_plane_test {

constexpr double kDistance = 0.7;

LatticeField oblique_field() {
  test::FieldSetup setup;
  setup.world_from_index = test::oblique_axes();
  return test::constant_field({12, 11, 13}, 1, setup);
}

// Across the planes of two axes, from one side or the other, somewhat aslant.
Camera camera_across(const LatticeField& field, int axis, double side, bool is_parallel) {
  const Mat3 axes = field.geometry().world_from_index.linear();
  const Vec3 normal = axes.col((axis + 1) % 3).cross(axes.col((axis + 2) % 3)).normalized();
  const Vec3 direction = side * normal + Vec3(0.2, -0.1, 0.25);
  const Bounds3 bounds = field.world_bounds();
  const double half_height = 0.5 * bounds.diagonal().norm();
  return is_parallel
             ? test::parallel_camera(bounds.center(), direction, half_height)
             : test::perspective_camera(bounds.center(), direction, half_height, 4 * half_height);
}

std::optional<BasePlane> base_of(const LatticeField& field, const Camera& camera,
                                 const RenderOptions& options) {
  return base_plane(field, support_of(field, 1.0, 0.0), camera, options);
}

// The point of a pixel's ray at a depth, by the camera's own vectors.
Vec3 seen_at(const Camera& c, const RenderOptions& options, const Eigen::Vector2d& pixel,
             double depth) {
  const Vec3 n = (c.focal_point - c.position).normalized();
  const Vec3 r = n.cross(c.view_up).normalized();
  const Vec3 q = r.cross(n);
  const double aspect = static_cast<double>(options.width) / options.height;
  const double across = (2 * (pixel[0] + 0.5) / options.width - 1) * aspect;
  const double along = 1 - 2 * (pixel[1] + 0.5) / options.height;
  const double scale = c.parallel_projection
                           ? c.parallel_scale
                           : depth * std::tan(c.view_angle / 2 * std::numbers::pi / 180);
  return c.position + depth * n + scale * (across * r + along * q);
}

// Fails if samples of a lattice that lies askew, or whose rows run the other way, are taken to
// share weights, or if rows are taken for columns.
TEST(BasePlane, OfAnotherLattice) {
  const LatticeField field = oblique_field();
  const BasePlane base = *base_of(field, camera_across(field, 2, 1, true), test::picture(24, 20));
  const Mat3 axes = field.geometry().world_from_index.linear();
  const auto plane = [&](const Mat3& own) {
    LatticeGeometry other{{9, 8, 7}, Affine3::Identity()};
    other.world_from_index.linear() = own;
    return plane_for(base, other);
  };
  const PlaneOfOther own = plane_for(base, field.geometry());
  EXPECT_TRUE(own.is_aligned);
  EXPECT_EQ(own.base.order, base.order);
  EXPECT_LE(own.samples_apart, kMostSpacings * (1 + 1e-12));
  const PlaneOfOther coarser = plane(2 * axes);
  EXPECT_TRUE(coarser.is_aligned);
  EXPECT_NEAR(coarser.samples_apart, own.samples_apart / 2, 1e-12);
  // Its first axis is the field's last.
  Mat3 reordered;
  reordered << axes.col(2), axes.col(0), axes.col(1);
  const PlaneOfOther turned = plane(reordered);
  EXPECT_TRUE(turned.is_aligned);
  for (std::size_t a = 0; a < 3; ++a) EXPECT_EQ(turned.base.order[a], (base.order[a] + 1) % 3);
  Mat3 flipped = axes;
  flipped.col(base.order[0]) *= -1;
  EXPECT_FALSE(plane(flipped).is_aligned);
  Mat3 along_normal = axes;
  along_normal.col(base.order[2]) *= -1;
  EXPECT_TRUE(plane(along_normal).is_aligned);
  const Mat3 askew = Eigen::AngleAxisd(0.1, Vec3(0, 0, 1)).toRotationMatrix() * axes;
  EXPECT_FALSE(plane(askew).is_aligned);
  EXPECT_EQ(plane(askew).base.order, kOwnOrder);
}

// A grid whose spacings differ by so much that all its samples along an axis lie within a pixel:
// the warp's filter for that pixel would have as many weights as the pixel is wide.
TEST(BasePlane, IsNotOneThatAPixelCovers) {
  for (const double longest : {1e3, 1e8}) {
    test::FieldSetup setup;
    setup.world_from_index.linear().diagonal() = Vec3(1, longest, 1);
    const LatticeField field = test::constant_field({2, 5, 5}, 1, setup);
    const Camera camera = camera_across(field, 2, 1.0, true);
    EXPECT_EQ(base_of(field, camera, test::picture(9, 7)).has_value(), longest < 1e6) << longest;
  }
}

class BasePlaneOf : public ::testing::TestWithParam<bool> {};

// Fails if a sample's pixel, its depth, or its place in the lattice is another one's.
TEST_P(BasePlaneOf, EveryAxisHasSamplesOnPlanesAndInPixels) {
  const LatticeField field = oblique_field();
  const RenderOptions options = test::picture(60, 44);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {1.0, -1.0}) {
      const Camera camera = camera_across(field, axis, side, GetParam());
      const std::optional<BasePlane> base = base_of(field, camera, options);
      ASSERT_TRUE(base);
      EXPECT_EQ(base->order[2], axis);
      const ViewLattice view(*base, camera, kDistance, field.geometry());
      EXPECT_EQ(view.width(), base->width);
      for (const std::int64_t sheet : {-3, 0, 4}) {
        const SheetMap map = view.index_map(sheet);
        EXPECT_NEAR(map.per_x[1], 0, 1e-12);
        EXPECT_NEAR(map.per_x[2], 0, 1e-12);
        EXPECT_NEAR(map.per_y[0], 0, 1e-12);
        EXPECT_NEAR(map.per_y[2], 0, 1e-12);
        EXPECT_GT(map.per_x[0], 0);
        EXPECT_LE(map.per_x[0], kMostSpacings * 1.2);  // nearer sheets' are closer
        const double z = view.depth(sheet);
        for (const auto& [x, y] : {std::pair{0, 0}, std::pair{9, 2}, std::pair{3, 17}}) {
          const Vec3 place = view.world_map(sheet).at(x, y);
          const Vec3 seen =
              seen_at(camera, options, base->picture_from_base(x, y), base->depth_of(x, y, z));
          EXPECT_LT((place - seen).norm(), 1e-9);
          const Eigen::Vector2d back = base->base_from_picture(base->picture_from_base(x, y)[0],
                                                               base->picture_from_base(x, y)[1]);
          EXPECT_LT((back - Eigen::Vector2d(x, y)).norm(), 1e-9);
        }
      }
    }
  }
}

// Fails if what shows lies beyond the window, or the window is far larger.
TEST_P(BasePlaneOf, WindowHoldsTheField) {
  const LatticeField field = oblique_field();
  const RenderOptions options = test::picture(60, 44);
  const Camera camera = camera_across(field, 2, 1, GetParam());
  const std::optional<BasePlane> base = base_of(field, camera, options);
  ASSERT_TRUE(base);
  const ViewLattice image(camera, options.width, options.height, kDistance, field.geometry());
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 world =
        field.geometry().world_from_index *
        field.geometry().index_bounds().corner(static_cast<Bounds3::CornerType>(corner));
    const double depth = image.view_axis().dot(world - camera.position);
    const Vec3 origin = seen_at(camera, options, {0, 0}, depth);
    const Vec3 step_x = seen_at(camera, options, {1, 0}, depth) - origin;
    const Vec3 step_y = seen_at(camera, options, {0, 1}, depth) - origin;
    const Eigen::Vector2d pixel((world - origin).dot(step_x) / step_x.squaredNorm(),
                                (world - origin).dot(step_y) / step_y.squaredNorm());
    const Eigen::Vector2d at = base->base_from_picture(pixel[0], pixel[1]);
    EXPECT_GE(at.minCoeff(), 2.0);
    EXPECT_LE(at[0], base->width - 3.0);
    EXPECT_LE(at[1], base->height - 3.0);
  }
  EXPECT_LT(base->width * base->height, 4 * options.width * options.height);
}

INSTANTIATE_TEST_SUITE_P(Projections, BasePlaneOf, ::testing::Bool(),
                         [](const auto& test) { return test.param ? "parallel" : "perspective"; });

TEST(BasePlane, IsNoneFromWithinOrAtTheWideAngle) {
  const LatticeField field = test::constant_field({9, 9, 9}, 1);
  const RenderOptions options = test::picture(40, 30);
  const Vec3 center = field.world_bounds().center();
  EXPECT_TRUE(base_of(field, test::perspective_camera(center, {0, 0, 1}, 8, 40), options));
  EXPECT_FALSE(base_of(field, test::perspective_camera(center, {0, 0, 1}, 1, 2), options));
  EXPECT_FALSE(base_of(field, test::perspective_camera(center, {1, 1, 1}, 20, 25), options));
}

Look look_of(std::vector<OpacityPoint> opacities) {
  Look look;
  look.transfer_function.opacities = std::move(opacities);
  look.transfer_function.colors = {{0, {0, 0, 0}}, {10, {1, 1, 1}}};
  return look;
}

// Fails if a step of opacity or colour, or one along logarithms, passes for gentle.
TEST(GentleLooks, ChangeLittleEverywhere) {
  const ValueRange range{0, 10};
  EXPECT_TRUE(is_gentle(look_of({{0, 0}, {10, 1}}), range));
  EXPECT_TRUE(is_gentle(look_of({{0, 0}, {1, 0.1}, {10, 0.1}}), range));
  EXPECT_FALSE(is_gentle(look_of({{0, 0}, {1, 0.2}, {10, 0.2}}), range));
  EXPECT_FALSE(is_gentle(look_of({{0, 0, 0.5, 1}, {10, 0.5}}), range));
  EXPECT_FALSE(is_gentle(look_of({{0, 0, 0.02}, {10, 0.5}}), range));
  Look stepped = look_of({{0, 0}, {10, 0.5}});
  stepped.transfer_function.colors = {
      {0, {0, 0, 0}}, {5, {0, 0, 0}}, {5, {1, 0, 0}}, {10, {1, 1, 1}}};
  EXPECT_FALSE(is_gentle(stepped, range));
  Look logarithmic = look_of({{1, 0}, {10, 0.5}});
  logarithmic.transfer_function.scale = ValueScale::kLog;
  EXPECT_FALSE(is_gentle(logarithmic, {1, 10}));
  Look fading = look_of({{0, 0}, {10, 0.5}});
  fading.transfer_function.gradient_opacities = {{0, 0}, {1, 1}};
  EXPECT_FALSE(is_gentle(fading, range));
}

}  // namespace base_plane_test
}  // namespace ovoid::view
