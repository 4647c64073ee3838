// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "model/test_datasets.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "ovoid/renderer.h"
#include "render/passes/scene_limits.h"
#include "support/compare.h"
#include "support/scenes.h"

namespace ovoid {
namespace scene_frame_test {

using test::parallel_camera;
using test::pixel;

constexpr int kSceneSide = 64;
constexpr Rgb kSceneRed{0.8, 0.2, 0.1};

// From -z, 20 away from the origin, 8 up and down: four pixels per unit.
Camera towards_z() { return parallel_camera({0, 0, 0}, {0, 0, 1}, 8, 20); }

RenderOptions of_scene() {
  RenderOptions options;
  options.width = options.height = kSceneSide;
  return options;
}

Look without_light(double opacity = 0.1) {
  Look look = test::uniform_look(opacity, {0, 0, 1});
  look.shade = false;
  look.unit_distance = 1;
  return look;
}

// The value 1 in cells that fill [-4, 4]^3.
LatticeField cube_field() {
  Dataset dataset;
  dataset.lattice.dims = {8, 8, 8};
  dataset.lattice.world_from_index = Affine3(Eigen::Translation3d(-3.5, -3.5, -3.5));
  dataset.arrays = {model::array_of_numbers("v", 1, std::vector<float>(512, 1.0F))};
  return make_lattice_field(dataset);
}

// A rectangle of two triangles across the view.
std::shared_ptr<const Surface> sheet_at(double z, double half = 20) {
  return make_surface(
      model::mesh_dataset({{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}},
                          {{CellType::kTriangle, {0, 1, 2}}, {CellType::kTriangle, {0, 2, 3}}}));
}

// A closed box of triangles.
std::shared_ptr<const Surface> box_surface(const Vec3& lo, const Vec3& hi) {
  std::vector<Vec3> points;
  for (int i = 0; i < 8; ++i)
    points.emplace_back((i & 1) != 0 ? hi.x() : lo.x(), (i & 2) != 0 ? hi.y() : lo.y(),
                        (i & 4) != 0 ? hi.z() : lo.z());
  std::vector<std::pair<CellType, std::vector<std::uint32_t>>> cells;
  const std::uint32_t sides[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                     {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  for (const auto& s : sides) {
    cells.emplace_back(CellType::kTriangle, std::vector{s[0], s[1], s[2]});
    cells.emplace_back(CellType::kTriangle, std::vector{s[0], s[2], s[3]});
  }
  return make_surface(model::mesh_dataset(points, cells));
}

Frame drawn_with(const Field& field, const Look& look, std::vector<Geometry> geometry,
                 const RenderOptions& options = of_scene(), Backend backend = Backend::kCpu,
                 int threads = 1) {
  Scene scene(field, look);
  scene.surfaces = std::move(geometry);
  return Renderer(backend, threads).render(scene, towards_z(), options);
}

// Light that comes through so much of the field is (1 - 0.1)^length.
TEST(Geometry, AnOpaqueSurfaceIsSeenThroughWhatIsBeforeIt) {
  for (const double z : {-2.0, 0.3, 3.0}) {
    const Frame frame = drawn_with(cube_field(), without_light(), {{sheet_at(z), kSceneRed}});
    const double through = std::pow(0.9, z + 4);
    const auto middle = pixel(frame.image, 32, 32);
    EXPECT_NEAR(middle.r(), through * 0.8, 2e-3) << z;
    EXPECT_NEAR(middle.b(), through * 0.1 + (1 - through), 2e-3) << z;
    EXPECT_NEAR(middle.a(), 1, 1e-4);
    EXPECT_NEAR(test::depth(frame.image, 32, 32), 20 + z, 0.6) << z;
  }
}

TEST(Geometry, StandsWhereThereIsNoField) {
  for (const double z : {-15.0, -4.5, 30.0}) {
    const Frame frame = drawn_with(cube_field(), without_light(), {{sheet_at(z, 30), kSceneRed}});
    const double before = z < 0 ? 1 : std::pow(0.9, 8);
    EXPECT_NEAR(pixel(frame.image, 32, 32).r(), before * 0.8, 2e-3) << z;
    EXPECT_NEAR(pixel(frame.image, 2, 60).r(), 0.8, 1e-5) << z;  // beside the cube
    EXPECT_NEAR(test::depth(frame.image, 2, 60), 20 + z, 1e-3) << z;
  }
}

// Values are the x of places: from black at -20 to white at 20.
TEST(Geometry, ValuesGiveColors) {
  Geometry geometry{sheet_at(-6), kSceneRed};
  geometry.colors.emplace();
  geometry.colors->colors = {{-20, {0, 0, 0}}, {20, {1, 1, 1}}};
  geometry.colors->opacities = {{-20, 0}, {20, 0}};  // these do not count
  const Frame frame = drawn_with(cube_field(), without_light(), {geometry});
  const auto left = pixel(frame.image, 15, 32), right = pixel(frame.image, 48, 32);
  EXPECT_NEAR(std::min(left.r(), right.r()), 0.4, 0.01);
  EXPECT_NEAR(std::max(left.r(), right.r()), 0.6, 0.01);
  EXPECT_NEAR(left.r(), left.g(), 1e-5);
  EXPECT_EQ(left.a(), 1);
  geometry.colors->opacities = {{-20, 0}, {20, 2}};
  EXPECT_THROW(drawn_with(cube_field(), without_light(), {geometry}), Error);
}

TEST(Geometry, LayersAreSeenThroughEachOther) {
  const Geometry near{sheet_at(-6), kSceneRed, 0.5};
  const Geometry far{sheet_at(6), {0, 1, 0}, 0.25};
  // The order in which they are given is of no account.
  for (const bool near_first : {true, false}) {
    const Frame frame = drawn_with(cube_field(), without_light(),
                                   near_first ? std::vector{near, far} : std::vector{far, near});
    const double through = 0.5 * std::pow(0.9, 8);
    EXPECT_NEAR(pixel(frame.image, 32, 32).r(), 0.5 * 0.8, 1e-5);
    EXPECT_NEAR(pixel(frame.image, 32, 32).g(), 0.5 * 0.2 + through * 0.25, 2e-3);
    EXPECT_NEAR(pixel(frame.image, 32, 32).a(), 1 - through * 0.75, 2e-3);
  }
}

// 4.3 x 2.9 units, 16 pixels each; and no dark or thick outline: all that is seen has its colour.
TEST(Geometry, OutlinesAreAsLargeAsTheSurface) {
  const auto box = box_surface({-2.05, -1.1, 1}, {2.25, 1.8, 3});
  LatticeField nothing = cube_field();
  const Frame frame = drawn_with(nothing, without_light(0), {{box, kSceneRed}});
  double area = 0;
  for (int y = 0; y < kSceneSide; ++y) {
    for (int x = 0; x < kSceneSide; ++x) {
      const auto at = pixel(frame.image, x, y);
      area += at.a();
      ASSERT_NEAR(at.r(), 0.8 * at.a(), 1e-5);
    }
  }
  EXPECT_NEAR(area / 16, 4.3 * 2.9, 0.02 * 4.3 * 2.9);
}

TEST(Geometry, ClipPlanesCutTheFieldAlone) {
  RenderOptions options = of_scene();
  options.clip_planes = {{{1, 0, 0}, 0}};
  const Frame frame =
      drawn_with(cube_field(), without_light(), {{sheet_at(0), kSceneRed}}, options);
  EXPECT_NEAR(pixel(frame.image, 22, 32).r(), 0.8, 1e-5);
  EXPECT_NEAR(pixel(frame.image, 42, 32).r(), 0.8 * std::pow(0.9, 4), 2e-3);
}

TEST(Geometry, LimitsOfAFieldStay) {
  const auto mesh = box_surface({-3, -3, -3}, {3, 3, 3});
  RenderOptions options = of_scene();
  auto limits = std::make_shared<DepthLimits>();
  limits->width = limits->height = kSceneSide;
  limits->first.push_back(0);
  for (int i = 0; i < kSceneSide * kSceneSide; ++i) {
    if (i % kSceneSide < kSceneSide / 2) {
      limits->stops.push_back({18, true, false, {}});
      limits->stops.push_back({21, false, false, {0, 0.5F, 0, 0.5F}});
    }
    limits->first.push_back(static_cast<std::uint32_t>(limits->stops.size()));
  }
  options.depth_limits = limits;
  const DepthLimits layers =
      layers_of({sheet_at(0), kSceneRed}, towards_z(), without_light(), options, 1, {}, nullptr);
  const DepthLimits all = merged_limits({&layers, 1}, nullptr, options, 1, {});
  all.validate();
  const auto stops = all.of_pixel(20, 32);
  ASSERT_EQ(stops.size(), 3U);
  EXPECT_EQ(stops[1].depth, 20);
  EXPECT_TRUE(stops[1].is_field_behind);
  EXPECT_FALSE(stops[2].is_field_behind);
  EXPECT_EQ(stops[2].rgba[1], 0.5F);
  ASSERT_EQ(all.of_pixel(40, 32).size(), 1U);
  EXPECT_FALSE(all.of_pixel(40, 32)[0].is_field_behind);
}

TEST(Geometry, BackEndsAgreeWhateverTheThreads) {
  Look look = test::gray_look(-1, 2, 0.05);
  look.shade = true;
  const std::vector<Geometry> geometry{{box_surface({-5, -1, -1}, {5, 1, 1}), kSceneRed},
                                       {sheet_at(2), {0, 1, 0}, 0.3, true}};
  for (const Mode mode : {Mode::kComposite, Mode::kIsosurface}) {
    look.mode = mode;
    look.isovalue = 0.5;
    const Image cpu = drawn_with(cube_field(), look, geometry).image;
    const Image reference =
        drawn_with(cube_field(), look, geometry, of_scene(), Backend::kReference).image;
    EXPECT_GT(test::compare(cpu, reference).psnr_db, 56) << static_cast<int>(mode);
    EXPECT_EQ(drawn_with(cube_field(), look, geometry, of_scene(), Backend::kCpu, 3).image.rgba,
              cpu.rgba);
  }
}

// A dense cube in the middle of nothing shadows the sheet behind it, away from the light.
TEST(Geometry, TheFieldShadowsIt) {
  Dataset dataset;
  dataset.lattice.dims = {16, 16, 16};
  dataset.lattice.world_from_index = Affine3(Eigen::Translation3d(-7.5, -7.5, -7.5));
  std::vector<float> values;
  for (int i = 0; i < 16 * 16 * 16; ++i) {
    const auto is_middle = [](int n) { return 5 <= n && n <= 10; };
    values.push_back(is_middle(i % 16) && is_middle(i / 16 % 16) && is_middle(i / 256) ? 1.0F : 0);
  }
  dataset.arrays = {model::array_of_numbers("v", 1, values)};
  const LatticeField field = make_lattice_field(dataset);
  Look look = without_light();
  look.transfer_function.opacities = {{0.3, 0}, {1, 0.9}};
  look.shade = true;
  look.light = Light::kSingle;
  look.light_direction = Vec3(1, 0, -0.7);  // from the right, and from the eye's side
  look.material = {0.1, 0.9, 0, 1};
  const auto brightness = [&](double shadows, int x) {
    look.shadows = shadows;
    return pixel(drawn_with(field, look, {{sheet_at(5), {1, 0, 0}}}).image, x, 32).r();
  };
  const int left = 4 * (8 - 5), right = 4 * (8 + 5);
  EXPECT_LT(brightness(1, left), 0.7 * brightness(0, left));
  EXPECT_NEAR(brightness(1, right), brightness(0, right), 0.02);
}

// Lit from the eye's side and from the right, so that what stands to the right of the cube and
// before it shadows it.
Look under_a_key(double shadows, double occlusion = 0) {
  Look look = without_light(0.95);
  look.shade = true;
  look.light = Light::kSingle;
  look.light_direction = Vec3(1, 0, -1);
  look.material = {0.1, 0.9, 0, 1};
  look.shadows = shadows;
  look.occlusion = occlusion;
  return look;
}

// 4 before the cube; its shadow falls on the cube's middle.
std::vector<Geometry> before_the_cube(double opacity) {
  return {{box_surface({2, -3, -8.1}, {6, 3, -8}), kSceneRed, opacity}};
}

// Fails if surfaces cast nothing on the field, or if they do where nobody asks for it.
TEST(Geometry, ShadowsTheField) {
  const auto blue = [&](double shadows, const std::vector<Geometry>& geometry, int x) {
    return pixel(drawn_with(cube_field(), under_a_key(shadows), geometry).image, x, 32).b();
  };
  const int shadowed = 32, beside = 18;
  EXPECT_LT(blue(1, before_the_cube(1), shadowed), 0.4 * blue(1, {}, shadowed));
  const double half = blue(1, before_the_cube(1 - std::sqrt(0.5)), shadowed);
  const double unlit = 0.1;  // ambient
  EXPECT_NEAR((half - unlit) / (blue(1, {}, shadowed) - unlit), 0.5, 0.1);
  // Cells of light are 1 wide, and this is 1.4 beside the shadow.
  EXPECT_NEAR(blue(1, before_the_cube(1), beside), blue(1, {}, beside), 0.1);
  EXPECT_NEAR(blue(0, before_the_cube(1), shadowed), blue(0, {}, shadowed), 1e-4);
}

// Fails if what is cast on a mesh's walls is not seen, or if they lose what they have without
// surfaces.
TEST(Geometry, ShadowsTheWallsOfAMesh) {
  const auto mesh =
      make_surface(model::mesh_dataset({{-4, -4, -4},
                                        {4, -4, -4},
                                        {4, 4, -4},
                                        {-4, 4, -4},
                                        {-4, -4, 4},
                                        {4, -4, 4},
                                        {4, 4, 4},
                                        {-4, 4, 4}},
                                       {{CellType::kHexahedron, {0, 1, 2, 3, 4, 5, 6, 7}}}));
  ASSERT_TRUE(mesh->encloses_mesh());
  Renderer renderer(Backend::kCpu, 1);
  Look look = under_a_key(1);
  const auto blue = [&](const std::vector<Geometry>& geometry, int x) {
    Scene scene(cube_field(), look);
    scene.volumes.front().boundary = mesh;
    scene.volumes.front().walls = {1, false};
    scene.surfaces = geometry;
    return pixel(renderer.render(scene, towards_z(), of_scene()).image, x, 32).b();
  };
  EXPECT_LT(blue(before_the_cube(1), 32), 0.4 * blue({}, 32));
  EXPECT_NEAR(blue(before_the_cube(1), 18), blue({}, 18), 0.02);
  RenderOptions options = of_scene();
  options.depth_limits = std::make_shared<DepthLimits>();
  Scene twice(cube_field(), look);
  twice.volumes.front().boundary = mesh;
  twice.volumes.front().walls = {1, false};
  twice.surfaces = before_the_cube(1);
  EXPECT_THROW(renderer.render(twice, towards_z(), options), Error);
}

TEST(Geometry, CastsAlikeOnAllBackEnds) {
  for (const Mode mode : {Mode::kComposite, Mode::kIsosurface}) {
    Look look = under_a_key(0.9, 0.7);
    look.scatter = 0.5;
    look.mode = mode;
    look.isovalue = 0.5;
    const Image cpu = drawn_with(cube_field(), look, before_the_cube(0.7)).image;
    const Image reference =
        drawn_with(cube_field(), look, before_the_cube(0.7), of_scene(), Backend::kReference).image;
    EXPECT_GT(test::compare(cpu, reference).psnr_db, 56) << static_cast<int>(mode);
    EXPECT_EQ(drawn_with(cube_field(), look, before_the_cube(0.7), of_scene(), Backend::kCpu, 3)
                  .image.rgba,
              cpu.rgba);
  }
}

// Slices are annotations.
TEST(FieldSlices, CastNothing) {
  Renderer renderer(Backend::kCpu, 1);
  const Look look = under_a_key(1, 0.8);
  Scene scene(cube_field(), look);
  scene.surfaces = before_the_cube(1);
  const auto picture = [&] { return renderer.render(scene, towards_z(), of_scene()).image; };
  const Image without = picture();
  // Through the cube, far from what is seen of it.
  scene.slices = {{{0, 0, 1}, 3.9, test::uniform_look(1).transfer_function, 1}};
  const Image with = picture();
  EXPECT_NEAR(pixel(with, 40, 32).b(), pixel(without, 40, 32).b(), 1e-3);
}

// A ramp along x, and gray from -4 to 4: the slice shows x, where the cube is.
TEST(FieldSlices, ShowTheFieldAtTheirDepth) {
  Dataset dataset;
  dataset.lattice.dims = {8, 8, 8};
  dataset.lattice.world_from_index = Affine3(Eigen::Translation3d(-3.5, -3.5, -3.5));
  std::vector<float> values;
  for (int i = 0; i < 512; ++i) values.push_back(static_cast<float>(i % 8) - 3.5F);
  dataset.arrays = {model::array_of_numbers("v", 1, values)};
  const LatticeField field = make_lattice_field(dataset, {.kernel = kCatmullRomKernel});
  FieldSlice slice{{0, 0, 2}, 2, test::gray_look(-4, 4).transfer_function};  // z = 1
  Renderer renderer(Backend::kCpu, 1);
  const auto picture = [&](double opacity, double z = 1) {
    slice.opacity = opacity;
    slice.offset = 2 * z;
    Scene scene(field, without_light(0));
    scene.slices = {slice};
    return renderer.render(scene, towards_z(), of_scene()).image;
  };
  const Image opaque = picture(1);
  for (const int x : {24, 30, 36, 40}) {
    const double world = (x + 0.5) / 4 - 8;  // pixels are a quarter wide
    EXPECT_NEAR(pixel(opaque, x, 32).r(), (world + 4) / 8, 0.02) << x;
    EXPECT_NEAR(test::depth(opaque, x, 32), 21, 1e-3);
  }
  EXPECT_EQ(pixel(opaque, 4, 4).a(), 0);  // beside the cube
  EXPECT_NEAR(pixel(picture(0.25), 30, 32).a(), 0.25, 1e-5);
  EXPECT_EQ(pixel(picture(1, 6), 30, 32).a(), 0);    // behind it
  EXPECT_EQ(pixel(picture(1, -30), 30, 32).a(), 0);  // behind the eye
}

TEST(FieldSlices, CrossEachOtherAndSurfaces) {
  const TransferFunction white = test::uniform_look(1).transfer_function;
  Scene scene(cube_field(), without_light(0));
  scene.slices = {{{0, 0, 1}, 1, white, 0.5}, {{0, 0, 1}, -1, white, 0.5}};
  scene.surfaces = {{sheet_at(0), {0, 0, 0}}};
  const Image image = Renderer(Backend::kCpu, 1).render(scene, towards_z(), of_scene()).image;
  EXPECT_NEAR(pixel(image, 32, 32).r(), 0.5, 1e-5);  // the far one is behind black
  EXPECT_NEAR(pixel(image, 32, 32).a(), 1, 1e-5);
}

// The light of the scene goes before that of the look. Fails if there are two, or none.
TEST(Scenes, HaveOneLight) {
  const Look lit = under_a_key(1, 0.5);
  Scene by_look(cube_field(), lit);
  by_look.surfaces = before_the_cube(1);
  Scene by_scene = by_look;
  by_scene.volumes.front().look.lighting() = {};
  by_scene.lighting = lit.lighting();
  Renderer renderer(Backend::kCpu, 1);
  const Image expected = renderer.render(by_look, towards_z(), of_scene()).image;
  EXPECT_EQ(renderer.render(by_scene, towards_z(), of_scene()).image.rgba, expected.rgba);
  by_scene.lighting.reset();
  EXPECT_NE(renderer.render(by_scene, towards_z(), of_scene()).image.rgba, expected.rgba);
}

// Two plates, one in the other's shadow, and nothing else. Fails if what has no volume has no
// light of its own.
TEST(Scenes, SurfacesAloneThrowShadows) {
  Scene scene;
  scene.surfaces = {{box_surface({-7, -7, 4}, {7, 7, 5})},
                    {box_surface({-2, -2, -5}, {2, 2, -4.5})}};
  Lighting light;
  light.light_direction = Vec3(0.8, 0, -1);  // from the right, and from the eye's side
  Renderer renderer(Backend::kCpu, 1);
  const auto at = [&](double shadows, int x) {
    light.shadows = shadows;
    scene.lighting = light;
    return pixel(renderer.render(scene, towards_z(), of_scene()).image, x, 32).r();
  };
  const int shadowed = 5, lit = 56;  // the shadow falls 7 to the left
  EXPECT_LT(at(1, shadowed), 0.7 * at(0, shadowed));
  EXPECT_NEAR(at(1, lit), at(0, lit), 0.05);
}

// As beside a field that nobody sees. Fails if what has no volume is not drawn, or in another
// light.
TEST(Scenes, SurfacesAloneAreAsBesideNothing) {
  for (const double opacity : {1.0, 0.4}) {
    Scene alone;
    alone.surfaces = {{box_surface({-3, -2, -1}, {2, 3, 4}), kSceneRed, opacity}, {sheet_at(6, 4)}};
    Look unseen;
    unseen.transfer_function.colors = {{0, {0, 0, 0}}};
    unseen.transfer_function.opacities = {{0, 0}};
    Scene beside(cube_field(), unseen);
    beside.surfaces = alone.surfaces;
    Renderer renderer(Backend::kCpu, 2);
    const Image image = renderer.render(alone, towards_z(), of_scene()).image;
    EXPECT_GT(pixel(image, 30, 32).a(), 0.3);
    EXPECT_EQ(image.rgba, renderer.render(beside, towards_z(), of_scene()).image.rgba);
  }
}

// Fails if a flat or single surface has no room around it.
TEST(Scenes, FlatSurfacesAloneAreDrawn) {
  Scene alone;
  alone.surfaces = {{sheet_at(0, 4), kSceneRed}};
  for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
    const Image image = Renderer(backend, 1).render(alone, towards_z(), of_scene()).image;
    EXPECT_EQ(pixel(image, 32, 32).a(), 1);
    EXPECT_NEAR(test::depth(image, 32, 32), 20, 1e-3);
    EXPECT_EQ(pixel(image, 4, 32).a(), 0);
  }
}

// The field is drawn where the mesh and the caller's limits both say so: half of a cube that is 8
// deep.
TEST(Scenes, ABoundaryAndLimitsAreInOneFrame) {
  Scene scene(cube_field(), without_light());
  scene.volumes.front().boundary =
      make_surface(model::mesh_dataset({{-2, -2, -2},
                                        {2, -2, -2},
                                        {2, 2, -2},
                                        {-2, 2, -2},
                                        {-2, -2, 2},
                                        {2, -2, 2},
                                        {2, 2, 2},
                                        {-2, 2, 2}},
                                       {{CellType::kHexahedron, {0, 1, 2, 3, 4, 5, 6, 7}}}));
  RenderOptions options = of_scene();
  auto limits = std::make_shared<DepthLimits>();
  limits->width = limits->height = kSceneSide;
  limits->first.push_back(0);
  for (int i = 0; i < kSceneSide * kSceneSide; ++i) {
    limits->stops.push_back({-100, true, false, {}});
    limits->stops.push_back({21, false, false, {}});
    limits->first.push_back(static_cast<std::uint32_t>(limits->stops.size()));
  }
  options.depth_limits = limits;
  Renderer renderer(Backend::kCpu, 1);
  const Image image = renderer.render(scene, towards_z(), options).image;
  EXPECT_NEAR(pixel(image, 32, 32).a(), 1 - std::pow(0.9, 3), 2e-3);  // from 18 to 21
  EXPECT_EQ(pixel(image, 32 + 12, 32).a(), 0);  // in the cube, not in the mesh
  scene.volumes.front().walls = {0.5, false};
  EXPECT_THROW(renderer.render(scene, towards_z(), options), Error);
}

TEST(Geometry, RefusesAndStops) {
  const auto refused = [](const char* words, const Geometry& geometry,
                          Look look = without_light()) {
    try {
      drawn_with(cube_field(), look, {geometry});
      FAIL() << words;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  refused("has no surface", {});
  refused("opacity = 0", {sheet_at(0), kSceneRed, 0});
  refused("color", {sheet_at(0), {0, 2, 0}});
  refused("color", {sheet_at(0), {0, std::nan(""), 0}});
  FieldSlice bad;
  bad.normal = Vec3::Zero();
  EXPECT_THROW(bad.validate(), Error);
  bad = {{0, 0, 1}, std::nan("")};
  EXPECT_THROW(bad.validate(), Error);
  bad = {};
  bad.opacity = 1.5;
  EXPECT_THROW(bad.validate(), Error);
  for (const Mode mode : {Mode::kMaximum, Mode::kMean, Mode::kXray})
    refused("modes composite and isosurface", {sheet_at(0), kSceneRed},
            test::with_mode(without_light(), mode));
  std::stop_source stop;
  stop.request_stop();
  RenderHooks hooks;
  hooks.stop = stop.get_token();
  Scene scene(cube_field(), without_light());
  scene.surfaces = {{sheet_at(0), kSceneRed}};
  try {
    Renderer(Backend::kCpu, 1).render(scene, towards_z(), of_scene(), hooks);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCancelled);
  }
}

}  // namespace scene_frame_test
}  // namespace ovoid
