// SPDX-License-Identifier: Apache-2.0
#include "render/passes/mesh_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "model/test_datasets.h"
#include "ovoid/error.h"
#include "render/light/solid_lattice.h"
#include "render/passes/boundary_limits.h"
#include "render/passes/surface_frame.h"
#include "support/scenes.h"

namespace ovoid {
namespace mesh_frame_test {

// `surface` outlives the call.
Frame render_mesh(Renderer& renderer, const Field& field, const Surface& surface,
                  const Camera& camera, const Look& look, const SurfaceStyle& walls = {},
                  const RenderOptions& options = {}, const RenderHooks& hooks = {}) {
  Scene scene(field, look);
  scene.volumes.front().boundary = {std::shared_ptr<const void>(), &surface};
  scene.volumes.front().walls = walls;
  return renderer.render(scene, camera, options, hooks);
}

using model::mesh_dataset;
using test::parallel_camera;
using test::perspective_camera;
using test::pixel;

constexpr int kPixels = 64;

RenderOptions small_options() {
  RenderOptions options;
  options.width = options.height = kPixels;
  return options;
}

struct Box {
  Vec3 lo, hi;
  int n = 4;  // cells along each side
};

// Boxes of hexahedra, each with nodes of its own; values are x.
Dataset mesh_of(const std::vector<Box>& boxes) {
  std::vector<Vec3> points;
  std::vector<std::pair<CellType, std::vector<std::uint32_t>>> cells;
  for (const auto& [lo, hi, n] : boxes) {
    const auto first = static_cast<std::uint32_t>(points.size());
    const auto side = static_cast<std::uint32_t>(n) + 1;
    for (std::uint32_t i = 0; i < side * side * side; ++i) {
      const Vec3 at(i % side, i / side % side, i / (side * side));
      points.emplace_back(lo + (at / n).cwiseProduct(hi - lo));
      if ((at.array() == n).any()) continue;
      std::vector<std::uint32_t> nodes;
      for (const std::uint32_t level : {0U, side * side}) {
        for (const std::uint32_t corner : {0U, 1U, 1 + side, side})
          nodes.push_back(first + i + corner + level);
      }
      cells.emplace_back(CellType::kHexahedron, nodes);
    }
  }
  return mesh_dataset(points, cells);
}

Dataset box_mesh(const Vec3& lo, const Vec3& hi, int n = 4) { return mesh_of({{lo, hi, n}}); }

DepthLimits limits_of(const Surface& surface, const Camera& camera, double opacity = 0,
                      const RenderOptions& options = small_options()) {
  const DepthLimits limits =
      boundary_limits(surface, camera, test::gray_look(-10, 10), {opacity, false}, options, 1);
  limits.validate();
  return limits;
}

// Where a pixel's ray is within the mesh.
std::vector<std::pair<double, double>> spans_of(const DepthLimits& limits, int x, int y) {
  std::vector<std::pair<double, double>> spans;
  bool was_inside = false;
  for (const DepthLimits::Stop& stop : limits.of_pixel(x, y)) {
    if (stop.is_field_behind && !was_inside)
      spans.emplace_back(stop.depth, std::numeric_limits<double>::infinity());
    if (!stop.is_field_behind && was_inside) spans.back().second = stop.depth;
    was_inside = stop.is_field_behind;
  }
  return spans;
}

// From -z, 20 away from the origin, 8 up and down.
Camera from_below() { return parallel_camera({0, 0, 0}, {0, 0, 1}, 8, 20); }

TEST(BoundaryLimits, AreWhereRaysComeInAndGoOut) {
  const auto surface = make_surface(box_mesh({-3, -2, -1}, {3, 2, 4}));
  const DepthLimits limits = limits_of(*surface, from_below());
  using Spans = std::vector<std::pair<double, double>>;
  EXPECT_EQ(spans_of(limits, 32, 32), (Spans{{19, 24}}));
  EXPECT_EQ(limits.of_pixel(32, 32).size(), 2U);
  EXPECT_EQ(limits.coverage[32 * kPixels + 32], 1);
  EXPECT_TRUE(limits.of_pixel(2, 2).empty());
  EXPECT_EQ(limits.coverage[2 * kPixels + 2], 0);
}

// On slanted faces, in perspective: where the ray through the pixel's first place meets them.
TEST(BoundaryLimits, FollowSlantedFacesInPerspective) {
  const auto surface = make_surface(box_mesh({-3, -3, -3}, {3, 3, 3}));
  const Camera camera = perspective_camera({0, 0, 0}, Vec3(0.4, 0.3, 1), 8, 25);
  const DepthLimits limits = limits_of(*surface, camera);
  const Vec3 axis = (camera.focal_point - camera.position).normalized();
  const Vec3 right = axis.cross(camera.view_up).normalized();
  const Vec3 up = right.cross(axis);
  const double scale = kPixels / (2 * std::tan(camera.view_angle * std::acos(-1.0) / 360));
  int num_checked = 0;
  for (int y = 0; y < kPixels; ++y) {
    for (int x = 0; x < kPixels; ++x) {
      if (limits.coverage[static_cast<std::size_t>(y * kPixels + x)] < 1) continue;
      const auto spans = spans_of(limits, x, y);
      ASSERT_EQ(spans.size(), 1U);
      const Vec3 ray = axis + ((x + 0.375 - 32) * right - (y + 0.125 - 32) * up) / scale;
      const Vec3 a = (Vec3::Constant(-3) - camera.position).cwiseQuotient(ray);
      const Vec3 b = (Vec3::Constant(3) - camera.position).cwiseQuotient(ray);
      EXPECT_NEAR(spans[0].first, a.cwiseMin(b).maxCoeff(), 1e-5) << x << ' ' << y;
      EXPECT_NEAR(spans[0].second, a.cwiseMax(b).minCoeff(), 1e-5) << x << ' ' << y;
      ++num_checked;
    }
  }
  EXPECT_GT(num_checked, 700);
}

TEST(BoundaryLimits, SeveralPiecesAreSeveralSpans) {
  const Dataset mesh = mesh_of({{{-3, -3, -6}, {3, 3, -4}}, {{-3, -3, 1}, {3, 3, 5}}});
  using Spans = std::vector<std::pair<double, double>>;
  EXPECT_EQ(spans_of(limits_of(*make_surface(mesh), from_below()), 30, 33),
            (Spans{{14, 16}, {21, 25}}));
}

// Four cells meet nine: none of the faces between them is shared, and the mesh goes on.
TEST(BoundaryLimits, CellsOfDifferentSizesMeetWithoutAGap) {
  const Dataset mesh = mesh_of({{{-3, -3, -2}, {3, 3, 0}, 2}, {{-3, -3, 0}, {3, 3, 3}, 3}});
  const auto surface = make_surface(mesh);
  const DepthLimits limits = limits_of(*surface, from_below(), 0.5);
  for (int y = 22; y < 42; ++y) {
    for (int x = 22; x < 42; ++x) {
      ASSERT_EQ(limits.of_pixel(x, y).size(), 2U) << x << ' ' << y;
      EXPECT_EQ(limits.of_pixel(x, y)[0].depth, 18);
      EXPECT_EQ(limits.of_pixel(x, y)[1].depth, 23);
    }
  }
}

TEST(BoundaryLimits, TheEyeMayBeInside) {
  const auto surface = make_surface(box_mesh({-3, -3, -3}, {3, 3, 3}));
  Camera camera = perspective_camera({0, 0, 2}, {0, 0, 1}, 2, 1);
  const auto spans = spans_of(limits_of(*surface, camera), 32, 32);
  ASSERT_EQ(spans.size(), 1U);
  EXPECT_EQ(spans[0].first, -std::numeric_limits<double>::infinity());
  EXPECT_NEAR(spans[0].second, 2, 1e-6);
}

// Without its front, and without its back, a box is taken to go on there.
TEST(BoundaryLimits, OpenBoundariesAreWholeOnTheirOtherSide) {
  for (const double missing : {-3.0, 3.0}) {
    Surface open = *make_surface(box_mesh({-3, -3, -3}, {3, 3, 3}));
    std::erase_if(open.triangles, [&](const Surface::Triangle& triangle) {
      return std::all_of(triangle.corners.begin(), triangle.corners.end(),
                         [&](std::uint32_t c) { return open.places[c].z() == missing; });
    });
    const auto spans = spans_of(limits_of(open, from_below()), 32, 32);
    ASSERT_EQ(spans.size(), 1U);
    const double infinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(spans[0].first, missing < 0 ? -infinity : 17);
    EXPECT_EQ(spans[0].second, missing < 0 ? 23 : infinity);
  }
}

// Turned by any angle a box's outline is its projection's to half a pixel.
TEST(BoundaryLimits, OutlinesAreWithinHalfAPixel) {
  const auto surface = make_surface(box_mesh({-3, -2, -1}, {3, 2, 1}));
  for (const double turn : {0.1, 0.7, 1.3}) {
    const Vec3 direction(std::sin(turn), 0.4, std::cos(turn));
    const Camera camera = parallel_camera({0, 0, 0}, direction, 5, 20);
    const Vec3 axis = direction.normalized();
    const Vec3 right = axis.cross(camera.view_up).normalized();
    const Vec3 up = right.cross(axis);
    const DepthLimits limits = limits_of(*surface, camera);
    // How far, in pixels, a pixel's middle is inside of the outline: the projection is an
    // intersection of strips, one for each direction across the picture that an edge has.
    const auto depth_inside = [&](double x, double y) {
      double least = 1e9;
      for (int a = 0; a < 3; ++a) {
        const Vec3 edge = Vec3::Unit(a);
        const Vec3 flat(edge.dot(right), edge.dot(up), 0);
        const Vec3 across = Vec3(-flat.y(), flat.x(), 0).normalized();
        double half = 0;
        for (int b = 0; b < 3; ++b) {
          const Vec3 other = Vec3::Unit(b) * Vec3(3, 2, 1)[b];
          half += std::abs(across.dot(Vec3(other.dot(right), other.dot(up), 0)));
        }
        least = std::min(least, half - std::abs(across.dot(Vec3(x, y, 0))));
      }
      return least * kPixels / 10;
    };
    for (int y = 0; y < kPixels; ++y) {
      for (int x = 0; x < kPixels; ++x) {
        const double inside = depth_inside((x + 0.5 - 32) / 6.4, (32 - y - 0.5) / 6.4);
        const float coverage = limits.coverage[static_cast<std::size_t>(y * kPixels + x)];
        if (inside > 0.5) {
          EXPECT_GT(coverage, 0.5) << x << ' ' << y;
        } else if (inside < -0.5) {
          EXPECT_LT(coverage, 0.5) << x << ' ' << y;
        }
      }
    }
  }
}

// Fails if triangles that share a side cover each other's part of a pixel.
TEST(BoundaryLimits, WallsHaveNoSeamsAndTheSurfacesColours) {
  const auto surface = make_surface(box_mesh({-3, -3, -3}, {3, 3, 3}, 7));
  const Camera camera = parallel_camera({0, 0, 0}, Vec3(0.4, 0.3, 1), 8, 25);
  const DepthLimits limits = limits_of(*surface, camera, 0.3);
  const Image whole =
      paint_surface(*surface, camera, test::gray_look(-10, 10), {}, small_options()).image;
  int num_whole = 0;
  for (int y = 0; y < kPixels; ++y) {
    for (int x = 0; x < kPixels; ++x) {
      if (limits.coverage[static_cast<std::size_t>(y * kPixels + x)] < 1) continue;
      const auto stops = limits.of_pixel(x, y);
      ASSERT_EQ(stops.size(), 2U) << x << ' ' << y;
      for (const auto& stop : stops) EXPECT_NEAR(stop.rgba[3], 0.3, 1e-6);
      EXPECT_NEAR(stops[0].rgba[0], 0.3 * pixel(whole, x, y).r(), 1e-5) << x << ' ' << y;
      ++num_whole;
    }
  }
  EXPECT_GT(num_whole, 600);
}

TEST(BoundaryLimits, FacesWithoutValuesBoundAndAreNoWalls) {
  Surface surface = *make_surface(box_mesh({-3, -3, -3}, {3, 3, 3}));
  for (auto& triangle : surface.triangles) triangle.values[0] = NAN;
  const DepthLimits limits = limits_of(surface, from_below(), 1);
  ASSERT_EQ(limits.of_pixel(32, 32).size(), 2U);
  for (const auto& stop : limits.of_pixel(32, 32)) EXPECT_EQ(stop.rgba[3], 0);
}

TEST(BoundaryLimits, ClipPlanesTakeWallsAndLeaveTheMesh) {
  const auto surface = make_surface(box_mesh({-3, -3, -3}, {3, 3, 3}));
  RenderOptions options = small_options();
  options.clip_planes = {{Vec3(0, 0, 1), 0}};
  const DepthLimits limits = limits_of(*surface, from_below(), 0.5, options);
  ASSERT_EQ(limits.of_pixel(32, 32).size(), 2U);
  EXPECT_EQ(limits.of_pixel(32, 32)[0].rgba[3], 0);
  EXPECT_EQ(limits.of_pixel(32, 32)[1].rgba[3], 0.5F);
}

// A flat cell within a box is a wall, and the field goes on behind it.
TEST(BoundaryLimits, FlatCellsBoundNothing) {
  Surface surface = *make_surface(box_mesh({-3, -3, -3}, {3, 3, 3}));
  Surface::Triangle flat;
  for (const Vec3& at : {Vec3(-9, -9, 1), Vec3(9, -9, 1), Vec3(0, 18, 1)}) {
    flat.corners[surface.places.size() % 3] = static_cast<std::uint32_t>(surface.places.size());
    surface.places.push_back(at);
  }
  const auto first = static_cast<std::uint32_t>(surface.places.size() - 3);
  flat.corners = {first, first + 1, first + 2};
  flat.normals.fill(Eigen::Vector3f(0, 0, 1));
  flat.values.fill(2.0F);
  surface.triangles.push_back(flat);
  const DepthLimits limits = limits_of(surface, from_below(), 0.5);
  const auto stops = limits.of_pixel(32, 32);
  ASSERT_EQ(stops.size(), 3U);
  EXPECT_EQ(stops[1].depth, 21);
  EXPECT_EQ(stops[1].rgba[3], 0.5F);
  EXPECT_TRUE(stops[1].is_field_behind);
  // Outside of the box the flat cell is all there is.
  ASSERT_EQ(limits.of_pixel(32, 52).size(), 1U);
  EXPECT_FALSE(limits.of_pixel(32, 52)[0].is_field_behind);
}

TEST(BoundaryLimits, CellsInsideOutAndAnyNumberOfThreads) {
  const std::vector<Vec3> points = {{-4, -4, 0}, {4, -4, 0}, {0, 5, 0}, {0, 0, 6}};
  const auto right = make_surface(mesh_dataset(points, {{CellType::kTetrahedron, {0, 1, 2, 3}}}));
  const auto wrong = make_surface(mesh_dataset(points, {{CellType::kTetrahedron, {0, 2, 1, 3}}}));
  const DepthLimits a = limits_of(*right, from_below());
  const DepthLimits b = boundary_limits(*wrong, from_below(), test::gray_look(-10, 10), {0, false},
                                        small_options(), 3);
  EXPECT_EQ(a.first, b.first);
  EXPECT_EQ(a.coverage, b.coverage);
  for (std::size_t i = 0; i < a.stops.size(); ++i) {
    ASSERT_NEAR(a.stops[i].depth, b.stops[i].depth, 1e-5);
    ASSERT_EQ(a.stops[i].is_field_behind, b.stops[i].is_field_behind);
  }
}

// Of cells, too, whose kernels stand half a cell from the faces: nothing is missing at a corner.
TEST(MeshFrame, FieldsOfCellsAreWholeUpToTheCorners) {
  Dataset mesh = box_mesh({-3, -3, -3}, {3, 3, 3}, 4);
  mesh.arrays = {model::array_of_numbers("c", 1, std::vector<float>(4 * 4 * 4, 3.0F))};
  mesh.arrays[0].is_cell_data = true;
  const auto surface = make_surface(mesh);
  const KernelField field = make_kernel_field(mesh);
  Look look = test::gray_look(-10, 10, 0.1);
  look.unit_distance = 1;
  Renderer renderer(Backend::kCpu, 1);
  const Image image =
      render_mesh(renderer, field, *surface, from_below(), look, {0, false}, small_options()).image;
  for (int y = 20; y < 44; ++y) {
    for (int x = 20; x < 44; ++x)
      ASSERT_NEAR(pixel(image, x, y).a(), 1 - std::pow(0.9, 6), 2e-3) << x << ' ' << y;
  }
}

// What is opaque covers what the mesh covers. Of a value per cell the tips of corners are missing,
// where an eighth of all kernels, less than kLeastWeight, is near: less than a pixel each.
TEST(MeshFrame, CornersAreNotRounded) {
  for (const bool is_cell_data : {false, true}) {
    Dataset mesh = box_mesh({-3, -3, -3}, {3, 3, 3}, 4);
    const std::size_t num = is_cell_data ? 64 : 125;
    mesh.arrays = {model::array_of_numbers("c", 1, std::vector<float>(num, 3.0F))};
    mesh.arrays[0].is_cell_data = is_cell_data;
    const auto surface = make_surface(mesh);
    const KernelField field = make_kernel_field(mesh);
    Look look = test::gray_look(-10, 10);
    const Camera camera = parallel_camera({0, 0, 0}, Vec3(1, 0.7, 0.9), 6, 20);
    Renderer renderer(Backend::kCpu, 1);
    const Image image =
        render_mesh(renderer, field, *surface, camera, look, {0, false}, small_options()).image;
    const DepthLimits limits = limits_of(*surface, camera);
    double missing = 0;
    for (std::size_t i = 0; i < limits.coverage.size(); ++i)
      missing += std::abs(image.rgba[4 * i + 3] - limits.coverage[i]);
    EXPECT_LT(missing, is_cell_data ? 3 : 0.1);
  }
}

// Light goes through a box as through so much of its matter, right up to its faces: by Beer's law.
TEST(MeshFrame, ThePictureEndsWhereTheMeshEnds) {
  Dataset mesh = box_mesh({-3, -2, -1}, {3, 2, 4}, 6);
  mesh.arrays[0] = model::array_of_numbers("v", 1, std::vector<float>(7 * 7 * 7, 3.0F));
  const auto surface = make_surface(mesh);
  const KernelField field = make_kernel_field(mesh);
  Look look = test::gray_look(-10, 10, 0.1);
  look.shade = false;
  look.unit_distance = 1;
  Renderer renderer(Backend::kCpu, 1);
  const Frame frame =
      render_mesh(renderer, field, *surface, from_below(), look, {0, false}, small_options());
  for (int y = 25; y < 39; ++y) {
    for (int x = 21; x < 43; ++x) {
      ASSERT_NEAR(pixel(frame.image, x, y).a(), 1 - std::pow(0.9, 5), 2e-3) << x << ' ' << y;
      ASSERT_NEAR(pixel(frame.image, x, y).r() / pixel(frame.image, x, y).a(), 0.65, 2e-3);
    }
  }
  double sum = 0;
  for (std::size_t i = 3; i < frame.image.rgba.size(); i += 4) sum += frame.image.rgba[i];
  EXPECT_NEAR(sum / 16, 6 * 4 * (1 - std::pow(0.9, 5)), 0.05);  // 16 pixels per area
}

// A lid shows the field on the cut, and closes it.
TEST(MeshFrame, CutsHaveLids) {
  const Dataset mesh = box_mesh({-3, -3, -3}, {3, 3, 3}, 12);
  const auto surface = make_surface(mesh);
  const KernelField field = make_kernel_field(mesh);
  RenderOptions options = small_options();
  // Keeps what is behind a plane that rises with x.
  const Vec3 normal = Vec3(0.5, 0, 1);
  options.clip_planes = {{normal, 0.4}};
  Look look = test::gray_look(-10, 10, 0.02);
  look.shade = true;
  Renderer renderer(Backend::kCpu, 1);
  const Image image = render_mesh(renderer, field, *surface, from_below(), look, {}, options).image;
  const double right = (from_below().focal_point - from_below().position)
                           .normalized()
                           .cross(from_below().view_up)
                           .normalized()
                           .x();
  for (int y = 22; y < 42; ++y) {
    for (int x = 22; x < 42; ++x) {
      const double at_x = right * (x + 0.5 - 32) / 4;
      ASSERT_NEAR(pixel(image, x, y).a(), 1, 1e-5) << x << ' ' << y;
      ASSERT_NEAR(pixel(image, x, y).r(), (at_x + 10) / 20, 4e-3) << x << ' ' << y;
      ASSERT_NEAR(test::depth(image, x, y), 20 + 0.4 - 0.5 * at_x, 0.13) << x << ' ' << y;
    }
  }
}

// As large as the mesh, whatever its place in the cells.
TEST(SolidLattice, HoldsTheVolumeOfTheMesh) {
  const std::vector<Vec3> points = {{-4, -4, 0.1}, {4, -3, 0}, {0, 5, 0.3}, {0.2, 0, 6}};
  const Dataset tetrahedron = mesh_dataset(points, {{CellType::kTetrahedron, {0, 1, 2, 3}}});
  const double volume =
      std::abs((points[1] - points[0]).cross(points[2] - points[0]).dot(points[3] - points[0])) / 6;
  const ExtinctionLattice lattice = solid_lattice(*make_surface(tetrahedron), {}, 1, {});
  const double edge = lattice.cell_edge();
  double sum = 0;
  for (const float extinction : lattice.extinction) sum += extinction;
  EXPECT_NEAR(sum * edge * edge * edge / (kOpaqueExtinction / edge), volume, 0.01 * volume);
  // It is where the mesh is: full in its middle, empty beside it.
  const Vec3 middle = (points[0] + points[1] + points[2] + points[3]) / 4;
  const auto at = [&](const Vec3& place) {
    const Vec3 cell = lattice.world_from_cell.inverse() * place;
    const auto index = [&](int a) { return static_cast<std::size_t>(std::lround(cell[a])); };
    return lattice.extinction[(index(2) * static_cast<std::size_t>(lattice.dims[1]) + index(1)) *
                                  static_cast<std::size_t>(lattice.dims[0]) +
                              index(0)];
  };
  EXPECT_NEAR(at(middle), kOpaqueExtinction / edge, 1e-4);
  EXPECT_EQ(at({-3, 3, 4}), 0);
  EXPECT_EQ(at({3.5, -3.2, 4}), 0);
}

// A floor is darkest in the corner beneath a roof; in the open it is as light as without occlusion.
TEST(MeshFrame, OpaqueSurfacesTakeOcclusion) {
  const Dataset mesh = mesh_of(
      {{{-6, -4, 0}, {6, 4, 1}, 8}, {{-6, -4, 1}, {-5, 4, 4}, 6}, {{-6, -4, 3}, {0, 4, 4}, 6}});
  const auto surface = make_surface(mesh);
  const KernelField field = make_kernel_field(mesh);
  Look look = test::gray_look(-1e6, 1e6);
  look.shade = true;
  look.light = Light::kStudio;
  look.material = {0.5, 0.5, 0, 1};
  // From the open side, a little from above.
  const Camera camera = parallel_camera({0, 0, 1}, Vec3(-1, 0, -0.4), 6, 30);
  const auto draw_with = [&](double occlusion) {
    look.occlusion = occlusion;
    Renderer renderer(Backend::kCpu, 1);
    return render_mesh(renderer, field, *surface, camera, look, {}, small_options()).image;
  };
  const Image open = draw_with(0);
  const Image occluded = draw_with(1);
  // Of a place on the floor.
  const Vec3 right = (camera.focal_point - camera.position).cross(camera.view_up).normalized();
  const Vec3 up = right.cross(camera.focal_point - camera.position).normalized();
  const auto brightness = [&](const Image& image, double x) {
    const Vec3 place = Vec3(x, 0.1, 1) - camera.focal_point;
    return pixel(image, static_cast<int>(kPixels * (0.5 + place.dot(right) / 12)),
                 static_cast<int>(kPixels * (0.5 - place.dot(up) / 12)))
        .r();
  };
  EXPECT_LT(brightness(occluded, -4.75), 0.7 * brightness(open, -4.75));
  EXPECT_LT(brightness(occluded, -3.75), 0.92 * brightness(open, -3.75));
  EXPECT_GT(brightness(occluded, -3.75), 1.2 * brightness(occluded, -4.75));
  for (const double x : {2.0, 3.0, 4.0, 5.0})
    EXPECT_NEAR(brightness(occluded, x), brightness(open, x), 1e-3);
}

// See-through walls are lit by what arrives; what they hide stays.
TEST(MeshFrame, SeeThroughWallsTakeOcclusion) {
  const Dataset mesh = box_mesh({-3, -3, -3}, {3, 3, 3});
  const auto surface = make_surface(mesh);
  Look look = test::gray_look(-1e6, 1e6);
  look.shade = true;
  look.material = {1, 0, 0, 1};
  view::LightVolume half;
  half.dims = {2, 2, 2};
  half.packed.assign(8, view::packed_light({0.5, 1}));
  const Camera camera = parallel_camera({0, 0, 0}, Vec3(-1, 0.3, -0.4), 6, 30);
  const DepthLimits open = boundary_limits(*surface, camera, look, {0.5}, small_options());
  const DepthLimits dim =
      boundary_limits(*surface, camera, look, {0.5}, small_options(), 1, {}, &half);
  ASSERT_EQ(open.stops.size(), dim.stops.size());
  int num_walls = 0;
  for (std::size_t i = 0; i < open.stops.size(); ++i) {
    EXPECT_EQ(dim.stops[i].rgba[3], open.stops[i].rgba[3]);
    EXPECT_NEAR(dim.stops[i].rgba[0], open.stops[i].rgba[0] / 2, 1e-3);
    num_walls += open.stops[i].rgba[0] > 0.1F ? 1 : 0;
  }
  EXPECT_GT(num_walls, 100);
}

// What arrives is what the field within lets through.
TEST(MeshFrame, SeeThroughWallsAreDarkBeneathARoof) {
  const Dataset mesh = mesh_of(
      {{{-6, -4, 0}, {6, 4, 1}, 8}, {{-6, -4, 1}, {-5, 4, 4}, 6}, {{-6, -4, 3}, {0, 4, 4}, 6}});
  const auto surface = make_surface(mesh);
  const KernelField field = make_kernel_field(mesh);
  Look look = test::gray_look(-1e6, 1e6);  // opaque within
  look.shade = true;
  look.light = Light::kStudio;
  look.material = {0.5, 0.5, 0, 1};
  const Camera camera = parallel_camera({0, 0, 1}, Vec3(-1, 0, -0.4), 6, 30);
  const auto draw_with = [&](double occlusion) {
    look.occlusion = occlusion;
    Renderer renderer(Backend::kCpu, 1);
    return render_mesh(renderer, field, *surface, camera, look, {0.9}, small_options()).image;
  };
  const Image open = draw_with(0);
  const Image occluded = draw_with(1);
  const Vec3 up = (camera.focal_point - camera.position)
                      .cross(camera.view_up)
                      .normalized()
                      .cross(camera.focal_point - camera.position)
                      .normalized();
  const Vec3 right = (camera.focal_point - camera.position).cross(camera.view_up).normalized();
  const auto share = [&](double x) {
    const Vec3 place = Vec3(x, 0.1, 1) - camera.focal_point;
    const int column = static_cast<int>(kPixels * (0.5 + place.dot(right) / 12));
    const int row = static_cast<int>(kPixels * (0.5 - place.dot(up) / 12));
    return pixel(occluded, column, row).r() / pixel(open, column, row).r();
  };
  EXPECT_LT(share(-4.5), 0.75);
  EXPECT_GT(share(4.0), 0.9);
}

// Where nothing is known of a boundary the field is drawn as ever.
TEST(MeshFrame, WithoutABoundaryTheFieldIsWhole) {
  const Dataset mesh = box_mesh({-3, -3, -3}, {3, 3, 3});
  Surface surface = *make_surface(mesh);
  surface.leaves_out_cells = true;
  const KernelField field = make_kernel_field(mesh);
  const Look look = test::gray_look(-10, 10, 0.1);
  Renderer renderer(Backend::kCpu, 1);
  EXPECT_EQ(
      render_mesh(renderer, field, surface, from_below(), look, {0, false}, small_options()).image,
      renderer.render({field, look}, from_below(), small_options()).image);
}

TEST(MeshFrame, RefusesAndStops) {
  const Dataset mesh = box_mesh({-3, -3, -3}, {3, 3, 3});
  const auto surface = make_surface(mesh);
  const KernelField field = make_kernel_field(mesh);
  const Look look = test::gray_look(-10, 10, 0.1);
  Renderer renderer(Backend::kCpu, 1);
  EXPECT_THROW(render_mesh(renderer, field, *surface, from_below(), look, {-0.1, false}), Error);
  EXPECT_THROW(render_mesh(renderer, field, *surface, from_below(), look, {1.1, false}), Error);
  RenderOptions limited = small_options();
  limited.depth_limits = std::make_shared<DepthLimits>(limits_of(*surface, from_below()));
  EXPECT_THROW(render_mesh(renderer, field, *surface, from_below(), look, {}, limited), Error);
  std::stop_source stop;
  stop.request_stop();
  RenderHooks hooks;
  hooks.stop = stop.get_token();
  for (const double opacity : {0.0, 0.5, 1.0}) {
    EXPECT_THROW(render_mesh(renderer, field, *surface, from_below(), look, {opacity, false},
                             small_options(), hooks),
                 Error);
  }
}

}  // namespace mesh_frame_test
}  // namespace ovoid
