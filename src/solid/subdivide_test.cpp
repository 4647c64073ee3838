// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "ovoid/error.h"
#include "ovoid/solid.h"
#include "solid/link.h"
#include "solid/test_solids.h"

namespace ovoid::solid {
namespace subdivide_test {

double without_density(const Vec3&) { return 0; }

double cubic(double x) { return 0.3 * x * x * x - 1.1 * x * x + 0.7 * x + 2; }
double parabola(double x) { return 0.4 * x * x - 1.3 * x + 0.2; }

// Fails if a weight of the 4-point rule is another, or a neighbour is taken for another.
TEST(Subdivision, ReproducesCubicsInside) {
  constexpr int kSide = 6;
  const auto density = [](const Vec3& p) {
    return cubic(p[0]) * cubic(p[1] - 1) + cubic(5 - p[2]);
  };
  const SolidMesh level = subdivide_solid(grid_solid(kSide, density));
  EXPECT_EQ(level.num_vertices(), 11U * 11 * 11);
  int num_inside = 0;
  for (std::size_t v = 0; v < level.num_vertices(); ++v) {
    const Vec3 at = level.position(v);
    if (at.minCoeff() < 1 || at.maxCoeff() > kSide - 2) continue;
    ++num_inside;
    EXPECT_NEAR(level.densities[v], density(at), 1e-11) << at.transpose();
  }
  EXPECT_EQ(num_inside, 7 * 7 * 7);
}

// Fails if lines do not go on as parabolas where the mesh ends, or the places do not stay those of
// the finer grid.
TEST(Subdivision, ReproducesParabolasUpToTheBoundary) {
  const auto density = [](const Vec3& p) {
    return parabola(p[0]) * parabola(p[1]) * parabola(p[2]);
  };
  const SolidMesh level = subdivide_solid(grid_solid(4, density), {.levels = 2});
  for (std::size_t v = 0; v < level.num_vertices(); ++v) {
    const Vec3 at = 4 * level.position(v);
    EXPECT_NEAR((at - at.array().round().matrix()).norm(), 0, 1e-12);
    EXPECT_NEAR(level.densities[v], density(at / 4), 1e-11) << at.transpose();
  }
}

// Fails if vertices of the mesh before move or change places.
TEST(Subdivision, KeepsVertices) {
  const SolidMesh star = make_sample_control_mesh();
  const SolidMesh level = subdivide_solid(star, {.levels = 2});
  EXPECT_EQ(level.cells.size(), 64 * star.cells.size());
  for (std::size_t v = 0; v < star.num_vertices(); ++v) {
    EXPECT_EQ(level.position(v), star.position(v));
    EXPECT_EQ(level.densities[v], star.densities[v]);
  }
  const SolidMesh same = subdivide_solid(star, {.levels = 0});
  EXPECT_EQ(same.cells, star.cells);
}

// Fails if weights do not add up to 1 anywhere in a mesh with edges of three and five cells, or
// places and densities go through different ones.
TEST(Subdivision, KeepsLinearDensities) {
  SolidMesh star = make_sample_control_mesh();
  const auto density = [](const Vec3& p) { return 2 * p[0] - 3 * p[1] + 0.5 * p[2] + 7; };
  for (std::size_t v = 0; v < star.num_vertices(); ++v)
    star.densities[v] = density(star.position(v));
  const SolidMesh level = subdivide_solid(star, {.levels = 2});
  for (std::size_t v = 0; v < level.num_vertices(); ++v)
    EXPECT_NEAR(level.densities[v], density(level.position(v)), 1e-11);
}

// Cells around a corner that is missing, four around a vertex, two that share an edge or a vertex
// alone, one alone. Fails if a rule for what is rare has weights that do not add up to 1, or lets a
// line go on to nothing.
TEST(Subdivision, KeepsLinearDensitiesOfOddMeshes) {
  const auto density = [](const Vec3& p) { return p[0] - 2 * p[1] + 3 * p[2] + 1; };
  const SolidMesh grid = grid_solid(3, density);
  const std::vector<std::vector<std::size_t>> choices = {
      {0, 1, 2, 4, 5, 6}, {0, 1, 2, 3, 4, 5, 6}, {0, 3}, {0, 7}, {0, 1, 2}, {0}};
  std::vector<SolidMesh> meshes = {four_cells_solid(density)};
  for (const std::vector<std::size_t>& cells : choices) meshes.push_back(part_of(grid, cells));
  for (const SolidMesh& mesh : meshes) {
    SCOPED_TRACE(mesh.cells.size());
    const SolidMesh level = subdivide_solid(mesh, {.levels = 2});
    for (std::size_t v = 0; v < level.num_vertices(); ++v)
      ASSERT_NEAR(level.densities[v], density(level.position(v)), 1e-11);
    EXPECT_NO_THROW(make_solid_field(level));
  }
  // A cube stays a cube.
  const SolidMesh cube = subdivide_solid(meshes.back());
  EXPECT_EQ(cube.num_vertices(), 27U);
  for (std::size_t v = 0; v < 27; ++v) {
    const Vec3 at = 2 * cube.position(v);
    EXPECT_LT((at - at.array().round().matrix()).norm(), 1e-12);
  }
}

// Fails if one way through the mesh is preferred to its mirror image.
TEST(Subdivision, OfTheMirrorImageIsTheMirrorImage) {
  const SolidMesh star = make_sample_control_mesh();
  SolidMesh mirrored = star;
  for (std::size_t v = 0; v < star.num_vertices(); ++v) mirrored.positions[3 * v] *= -1;
  for (auto& cell : mirrored.cells) {
    for (std::size_t c = 0; c < 8; c += 2) std::swap(cell[c], cell[c + 1]);
  }
  const SolidMesh a = subdivide_solid(star), b = subdivide_solid(mirrored);
  ASSERT_EQ(a.num_vertices(), b.num_vertices());
  for (std::size_t v = 0; v < a.num_vertices(); ++v) {
    const Vec3 expected(-a.position(v)[0], a.position(v)[1], a.position(v)[2]);
    EXPECT_LT((b.position(v) - expected).norm(), 1e-12);
    EXPECT_NEAR(b.densities[v], a.densities[v], 1e-12);
  }
}

// The slopes along the edges from vertex 0 in the plane z = 0: what is left of them when those of
// one gradient are taken away, over these. Of a smooth solid it halves with the edges.
double kink_at_middle(const SolidMesh& level) {
  Eigen::MatrixXd ways(0, 2);
  Eigen::VectorXd slopes;
  std::vector<std::uint32_t> ends;
  for (const auto& cell : level.cells) {
    const auto corner =
        static_cast<std::size_t>(std::find(cell.begin(), cell.end(), 0U) - cell.begin());
    if (corner == 8) continue;
    for (const std::size_t bit : {1U, 2U}) ends.push_back(cell[corner ^ bit]);
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  ways.resize(static_cast<Eigen::Index>(ends.size()), 2);
  slopes.resize(ways.rows());
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const Vec3 way = level.position(ends[i]) - level.position(0);
    ways.row(static_cast<Eigen::Index>(i)) = way.head<2>() / way.norm();
    slopes[static_cast<Eigen::Index>(i)] =
        (level.densities[ends[i]] - level.densities[0]) / way.norm();
  }
  const Eigen::Vector2d gradient =
      (ways.transpose() * ways).inverse() * (ways.transpose() * slopes);
  return (slopes - ways * gradient).norm() / (ways * gradient).norm();
}

// Around edges of three, five and six cells. Fails if a rule there leaves a jump or a kink: with
// the mean of what lies opposite, or one harmonic less, the kink falls by a quarter a level.
TEST(Subdivision, ExtraordinaryEdgesAreSmooth) {
  for (const int around : {3, 5, 6}) {
    SCOPED_TRACE(around);
    const auto density = [](const Vec3& p) {
      return std::sin(2 * p[0] + 1) * std::cos(p[1]) + 0.3 * p[2];
    };
    SolidMesh level = ring_solid(around, density);
    double steepest = 0, kink = kink_at_middle(level);
    const double first_kink = kink;
    for (int l = 0; l < 4; ++l) {
      level = subdivide_solid(level);
      double most = 0;
      for (const auto& cell : level.cells) {
        for (const std::size_t bit : {1U, 2U, 4U})
          most = std::max(most, std::abs(level.densities[cell[0]] - level.densities[cell[bit]]));
      }
      if (l > 0) {
        EXPECT_LT(most, 0.65 * steepest);
      }
      steepest = most;
      EXPECT_LT(kink_at_middle(level), 0.6 * kink);
      kink = kink_at_middle(level);
    }
    EXPECT_LT(kink, first_kink / 12);
  }
}

// Fails if the weights around a vertex of `count` are not exact for quadratic functions.
TEST(Subdivision, RingsGoStraightOn) {
  for (std::size_t count = 2; count <= 9; ++count) {
    Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero(), expected;
    expected << 1, -1, 0, 1, 0, 1;
    for (std::size_t i = 0; i < count; ++i) {
      const double angle =
          2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
      const double x = std::cos(angle), y = std::sin(angle);
      sum += ring_weight(count, i) *
             (Eigen::Matrix<double, 6, 1>() << 1, x, y, x * x - y * y, x * y, x * x + y * y)
                 .finished();
    }
    // Three have no second harmonic of their own.
    if (count == 3) sum[3] = expected[3];
    EXPECT_LT((sum - expected).norm(), 1e-12) << count << ": " << sum.transpose();
  }
}

TEST(Subdivision, IsTheSameForAnyNumberOfThreads) {
  const SolidMesh star = make_sample_control_mesh();
  const SolidMesh one = subdivide_solid(star, {.levels = 2, .threads = 1});
  const SolidMesh three = subdivide_solid(star, {.levels = 2, .threads = 3});
  EXPECT_EQ(one.positions, three.positions);
  EXPECT_EQ(one.densities, three.densities);
}

std::string solid_refusal(const SolidMesh& mesh, const SubdivisionOptions& options = {}) {
  try {
    subdivide_solid(mesh, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

// Fails if what cannot be a solid is subdivided, or the message does not name it.
TEST(Subdivision, RefusesWhatIsNoSolid) {
  const SolidMesh grid = grid_solid(3, without_density);
  const auto expect = [&](const char* word, const auto& change) {
    SolidMesh mesh = grid;
    change(mesh);
    const std::string refusal = solid_refusal(mesh);
    EXPECT_NE(refusal.find(word), std::string::npos) << refusal;
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  expect("cells: none", [](SolidMesh& mesh) { mesh.cells.clear(); });
  expect("positions: 80 numbers", [](SolidMesh& mesh) { mesh.positions.pop_back(); });
  expect("positions[4] = nan", [](SolidMesh& mesh) { mesh.positions[12] = kNan; });
  expect("densities[5] = nan", [](SolidMesh& mesh) { mesh.densities[5] = kNan; });
  expect("cells[2]: vertex 99", [](SolidMesh& mesh) { mesh.cells[2][1] = 99; });
  expect("cells[2]: vertex 6 twice", [](SolidMesh& mesh) { mesh.cells[2][0] = mesh.cells[2][2]; });
  expect("positions[27]: a vertex of no cell", [](SolidMesh& mesh) {
    add_vertex(mesh, {9, 9, 9}, 0);
  });
  expect("have one face", [](SolidMesh& mesh) {
    mesh.cells.push_back(mesh.cells[0]);
    mesh.cells.push_back(mesh.cells[0]);
  });
  expect("cells[0]: inside out at vertex 0", [](SolidMesh& mesh) { mesh.positions[0] = 5; });
  expect("cells[1]: inside out", [](SolidMesh& mesh) {
    for (std::size_t c = 0; c < 8; c += 2) std::swap(mesh.cells[1][c], mesh.cells[1][c + 1]);
  });
  expect("flat at vertex", [](SolidMesh& mesh) {
    for (std::size_t v = 0; v < 27; ++v) mesh.positions[3 * v + 2] = 0;
  });
  EXPECT_NE(solid_refusal(grid, {.levels = 9}).find("levels = 9: must be 0 to 8"),
            std::string::npos);
  EXPECT_NE(
      solid_refusal(grid, {.levels = 5, .memory_limit = 1 << 20}).find("memory limit of 1048576"),
      std::string::npos);
}

}  // namespace subdivide_test
}  // namespace ovoid::solid
