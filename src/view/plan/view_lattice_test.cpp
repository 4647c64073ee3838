// SPDX-License-Identifier: Apache-2.0
#include "view/plan/view_lattice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/scenes.h"
#include "support/volumes.h"

namespace ovoid::view {
namespace view_lattice_test {

LatticeGeometry lattice() { return {{20, 30, 10}, test::oblique_axes()}; }

Camera camera(bool is_parallel) {
  Camera c;
  c.position = {100, -60, -40};
  c.focal_point = {122, -50, 15};
  c.view_up = {0.1, 1, 0.3};
  c.parallel_projection = is_parallel;
  c.parallel_scale = 17;
  c.view_angle = 35;
  return c;
}

// Where docs/numerics.md has the sample of pixel (x, y) on a sheet, written out by vectors.
Vec3 sample_position(const Camera& c, int width, int height, double ds, double x, double y,
                     double sheet) {
  const Vec3 n = (c.focal_point - c.position).normalized();
  const Vec3 r = n.cross(c.view_up).normalized();
  const Vec3 q = r.cross(n);
  const double z = (c.focal_point - c.position).norm() + (sheet + 0.5) * ds;
  const double across = (2 * (x + 0.5) / width - 1) * width / height;
  const double along = 1 - 2 * (y + 0.5) / height;
  const double scale = c.parallel_projection
                           ? c.parallel_scale
                           : z * std::tan(c.view_angle / 2 * std::numbers::pi / 180);
  return c.position + z * n + scale * (across * r + along * q);
}

class ViewLatticeTest : public ::testing::TestWithParam<bool> {};

// Fails if a sheet's map is off by half a pixel or sheet, mirrored, or not affine as promised.
TEST_P(ViewLatticeTest, SamplesLieWhereTheyAreDefined) {
  constexpr double kDs = 0.7;
  const ViewLattice view(camera(GetParam()), 64, 48, kDs, lattice());
  const Affine3 index_from_world = lattice().world_from_index.inverse();
  for (const std::int64_t sheet : {-20, -1, 0, 35}) {
    for (const auto& [x, y] : {std::pair{0, 0}, std::pair{63, 0}, std::pair{13, 47}}) {
      const auto s = static_cast<double>(sheet);
      const Vec3 expected = sample_position(camera(GetParam()), 64, 48, kDs, x, y, s);
      // Positions of some hundred units, some roundings each: 1e-13; 10 times that.
      EXPECT_LT((view.world_map(sheet).at(x, y) - expected).norm(), 1e-12);
      EXPECT_LT((view.index_map(sheet).at(x, y) - index_from_world * expected).norm(), 1e-12);
      const Vec3 next = sample_position(camera(GetParam()), 64, 48, kDs, x, y, s + 1);
      EXPECT_LT((kDs * view.ray_direction().at(x, y) - (next - expected)).norm(), 1e-12);
    }
    const Vec3 step = view.world_map(sheet).per_x;
    EXPECT_NEAR(step.norm(), std::abs(view.pitch(sheet)), 1e-12);
  }
  EXPECT_NEAR(view.ray_direction().at(5, 7).dot(view.view_axis()), 1.0, 1e-14);
}

// Fails if a sheet that can meet the box is left out, or far more than those are given.
TEST_P(ViewLatticeTest, SheetsMeetingABox) {
  const ViewLattice view(camera(GetParam()), 64, 48, 0.7, lattice());
  const Bounds3 box = lattice().index_bounds();
  const ViewLattice::SheetRange range = view.sheets_meeting(box);
  double nearest = 1e300;
  double farthest = -1e300;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 world =
        lattice().world_from_index * box.corner(static_cast<Bounds3::CornerType>(corner));
    const double depth = view.view_axis().dot(world - camera(true).position);
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
  }
  nearest = std::max(nearest, view.near_depth());
  EXPECT_LE(view.depth(range.first - 1), nearest);
  EXPECT_GE(view.depth(range.last), farthest);
  EXPECT_GE(view.depth(range.first + 1), nearest);
  EXPECT_LE(view.depth(range.last - 2), farthest);
}

INSTANTIATE_TEST_SUITE_P(Projections, ViewLatticeTest, ::testing::Bool(),
                         [](const auto& test) { return test.param ? "parallel" : "perspective"; });

// Fails if a perspective camera sees what lies at or before its near plane, or a parallel one has
// such a plane.
TEST(ViewLattice, NearPlane) {
  Camera c = camera(false);
  const Vec3 center = lattice().world_bounds().center();
  c.focal_point += center - c.position;
  c.position = center;
  const ViewLattice inside(c, 64, 48, 0.7, lattice());
  EXPECT_EQ(inside.near_depth(), 0.35);
  const auto range = inside.sheets_meeting(lattice().index_bounds());
  ASSERT_LT(range.first, range.last);
  EXPECT_GT(inside.depth(range.first), 0.35);
  EXPECT_LE(inside.depth(range.first - 1), 0.35);

  Camera beyond = c;
  beyond.position += 1000 * (c.focal_point - c.position).normalized();
  beyond.focal_point = beyond.position + (c.focal_point - c.position);
  const auto none =
      ViewLattice(beyond, 64, 48, 0.7, lattice()).sheets_meeting(lattice().index_bounds());
  EXPECT_GE(none.first, none.last);
  beyond.parallel_projection = true;
  const auto all =
      ViewLattice(beyond, 64, 48, 0.7, lattice()).sheets_meeting(lattice().index_bounds());
  EXPECT_LT(all.first, all.last);
}

}  // namespace view_lattice_test
}  // namespace ovoid::view
