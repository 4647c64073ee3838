// SPDX-License-Identifier: Apache-2.0
// Refined pieces, a back end against the reference; and what skipping, boxes and pages must not
// change of them.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "support/agreement.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"
#include "support/where.h"
#include "view/plan/frame_plan.h"

namespace ovoid::test {
namespace refined_test {

std::string view_name(bool is_parallel) { return is_parallel ? ", parallel" : ", perspective"; }

TestScene refined(TestScene scene) {
  scene.options.classification = Classification::kRefined;
  return scene;
}

// Away from nodes and levels, which have tiers of their own.
TestScene refined_pixels(TestScene scene) {
  scene.options.post_convolution = PostConvolution::kOff;
  return refined(scene);
}

// Of any look that does something at both ends of the volume's range.
void fade_by_gradient(Look& look, const Field& field) {
  const ValueRange range = field.value_range();
  const double typical = 0.2 * (static_cast<double>(range.hi) - static_cast<double>(range.lo)) /
                         field.default_sampling_distance();
  look.transfer_function.gradient_opacities = {
      {0.3 * typical, 0}, {0.8 * typical, 0.4, 0.3, 0.2}, {1.5 * typical, 1}};
}

// One sample alone is a ball of 0.09 spacings.
bool is_one_sample(const TestVolume& volume) { return volume.field.num_kernels() == 1; }

// Fails if ends, steps, faces or holes are off, or which sample comes before which.
TEST(Refined, AgreesOnEveryVolumeAndLook) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const TestVolume& volume : test_volumes()) {
    for (const TestLook& look : test_looks(volume.lo, volume.hi)) {
      for (const double distance : {0.0, 1.7}) {
        const bool is_parallel = distance > 1;
        const double unit = is_one_sample(volume) ? 0.06 : distance;
        TestScene scene{
            volume.field, askew_camera(volume.field, is_parallel, is_one_sample(volume) ? 8 : 1.4),
            look.look, picture(30, 26, unit * volume.field.default_sampling_distance())};
        EXPECT_TRUE(backends_agree(refined_pixels(scene),
                                   volume.name + ", " + look.name + view_name(is_parallel), 0.002));
      }
    }
  }
}

using Change = std::function<void(TestScene&)>;

const std::vector<std::pair<std::string, Change>>& other_options() {
  static const std::vector<std::pair<std::string, Change>> changes = {
      {"plain", [](TestScene&) {}},
      {"scatter", [](TestScene& scene) { scene.options.evaluate = Evaluate::kScatter; }},
      {"central", [](TestScene& scene) { scene.options.gradient = GradientMethod::kCentral; }},
      {"exact", [](TestScene& scene) { scene.options.gradient = GradientMethod::kExact; }},
      {"slab means", [](TestScene& scene) { scene.options.slab = Slab::kMean; }},
      {"no light", [](TestScene& scene) { scene.look.shade = false; }},
      {"fading",
       [](TestScene& scene) {
         fade_by_gradient(scene.look, scene.field);
         scene.look.shade = false;
       }},
      {"fading, lit", [](TestScene& scene) { fade_by_gradient(scene.look, scene.field); }},
      {"clipped",
       [](TestScene& scene) {
         const Vec3 center = scene.field.world_bounds().center();
         const Vec3 across(-1.0, 0.6, 0.5), other(0.1, -1.0, 0.3);
         scene.options.clip_planes = {{across, across.dot(center) - 0.7},
                                      {other, other.dot(center) - 1.3}};
       }},
      {"four sheets a spacing",
       [](TestScene& scene) {
         scene.options.sampling_distance = 0.25 * scene.field.default_sampling_distance();
       }},
      {"steep",
       [](TestScene& scene) {
         const double lo = scene.look.transfer_function.lo();
         const double span = scene.look.transfer_function.hi() - lo;
         scene.look.transfer_function.opacities = {{lo + 0.5 * span, 0}, {lo + 0.55 * span, 0.95}};
       }},
  };
  return changes;
}

TEST(Refined, AgreesWithOtherOptions) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const bool is_parallel : {true, false}) {
    for (const auto& [name, change] : other_options()) {
      TestScene scene = small_scene(Mode::kComposite, is_parallel);
      change(scene);
      EXPECT_TRUE(backends_agree(refined_pixels(scene), name + view_name(is_parallel), 0.02));
    }
  }
}

TEST(Refined, AgreesOnSums) {
  OVOID_NIGHTLY_ON_DEVICE();
  FieldSetup setup;
  setup.world_from_index = oblique_axes();
  setup.reconstruction = Reconstruction::kSum;
  const Index3 dims{12, 11, 13};
  for (const bool is_parallel : {true, false}) {
    for (const Slab slab : {Slab::kMid, Slab::kMean}) {
      TestScene scene = small_scene(Mode::kComposite, is_parallel);
      scene.field = make_stored_field(dims, shells(dims), {ScalarType::kFloat32, 10, 50}, setup);
      scene.look = semi_transparent_look(-5, 50);
      scene.options.slab = slab;
      EXPECT_TRUE(backends_agree(
          refined_pixels(scene),
          "sum" + view_name(is_parallel) + (slab == Slab::kMean ? ", slab means" : "")));
    }
  }
}

TEST(Refined, AgreesOnBodyCentredLattices) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Index3 dims{11, 9, 20};
  FieldSetup setup;
  setup.world_from_index = oblique_axes();
  setup.lattice = LatticeKind::kBodyCentred;
  for (const bool is_parallel : {true, false}) {
    for (const auto& [name, change] : other_options()) {
      TestScene scene = small_scene(Mode::kComposite, is_parallel);
      scene.field =
          make_stored_field(dims, shells({11, 9, 10}), {ScalarType::kFloat32, 10, 50}, setup);
      scene.camera = askew_camera(scene.field, is_parallel, 1.3);
      change(scene);
      EXPECT_TRUE(backends_agree(refined_pixels(scene),
                                 "body-centred, " + name + view_name(is_parallel), 0.02));
    }
  }
}

Camera inner_camera(const Field& field) {
  const Bounds3 bounds = field.world_bounds();
  Camera camera;
  camera.position = bounds.center() + 0.1 * bounds.diagonal();
  camera.focal_point = bounds.center() - Vec3(0.3, 0.1, 0.2).cwiseProduct(bounds.diagonal());
  camera.view_angle = 80;
  return camera;
}

// Fails if a piece in front of the near plane is drawn, or the first one behind it is not.
TEST(Refined, AgreesFromWithin) {
  for (const bool is_set : {false, true}) {
    TestScene scene = small_scene(Mode::kComposite, false);
    if (is_set) {
      scene.field = KernelField(jittered_ellipsoids(6).source(), Reconstruction::kNormalized);
      scene.look = semi_transparent_look(0, 1);
    }
    scene.camera = inner_camera(scene.field);
    EXPECT_TRUE(
        backends_agree(refined_pixels(scene), is_set ? "set from within" : "from within", 0.5));
  }
}

// Fails if a field is longer or shorter than from face to face, wherever the sheets are.
TEST(Refined, FieldsEndAtTheirFaces) {
  OVOID_NIGHTLY_ON_DEVICE();
  constexpr double kOpacity = 0.08;
  constexpr int kLength = 7;
  TestScene scene;
  scene.field = constant_field({9, 8, kLength}, 1);
  scene.look = uniform_look(kOpacity);
  scene.look.unit_distance = 1;
  const Vec3 center = scene.field.world_bounds().center();
  scene.camera = parallel_camera(center, {0, 0, 1}, 3);
  for (const double distance : {0.0, 0.37, 1.3, 2.2}) {
    scene.options = picture(4, 4, distance);
    const Image image = draw(refined(scene)).image;
    // A sheet up to 0.02 beyond a face has samples, too.
    EXPECT_GT(center_pixel(image).a(), 1 - std::pow(1 - kOpacity, kLength) - 2e-6) << distance;
    EXPECT_LT(center_pixel(image).a(), 1 - std::pow(1 - kOpacity, kLength + 0.04)) << distance;
  }
}

// Fails if the published ways, which classify samples, are refined all the same.
TEST(Refined, LeavesThePublishedWaysAlone) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const PostConvolution how : kPublishedWays) {
    TestScene scene = small_scene(Mode::kComposite, true);
    scene.camera = askew_camera(scene.field, true, 14);
    scene.options = picture(14, 12);
    scene.options.post_convolution = how;
    EXPECT_EQ(sheet_distance(scene.field, scene.look, scene.options),
              scene.field.default_sampling_distance());
    const Image image = draw(refined(scene)).image;
    scene.options.classification = Classification::kSampled;
    EXPECT_EQ(image, draw(scene).image) << name_of(how);
  }
}

// Fails if `auto` does not keep what it promises.
TEST(Refined, NodesKeepTheirBound) {
  OVOID_NIGHTLY_ON_DEVICE();
  const Index3 dims{30, 28, 32};
  const LatticeField field = make_stored_field(dims, shells(dims), {});
  for (const TestLook& look : test_looks(0, 1)) {
    for (const bool is_parallel : {true, false}) {
      const TestScene scene{field, askew_camera(field, is_parallel, 6), look.look, picture(90, 80)};
      const Frame exact = draw(refined_pixels(scene));
      const Frame fast = draw(refined(scene));
      const ImageDifference difference = compare(fast.image, exact.image);
      std::printf("[agreement ] nodes, %-45s %s\n", look.name.c_str(),
                  difference.to_string().c_str());
      EXPECT_GE(difference.psnr_db, view::kNodeDecibels) << look.name << view_name(is_parallel);
      EXPECT_GT(difference.num_covered, 300);
    }
  }
}

// Fails if a piece comes before or behind the wrong sheet of the trail.
TEST(Refined, AgreesWithTrails) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const LatticeKind kind : {LatticeKind::kCartesian, LatticeKind::kBodyCentred}) {
    for (const bool is_parallel : {true, false}) {
      for (const bool is_clipped : {true, false}) {
        FieldSetup setup;
        setup.world_from_index = oblique_axes();
        setup.lattice = kind;
        const Index3 dims =
            kind == LatticeKind::kBodyCentred ? Index3{11, 9, 20} : Index3{14, 12, 13};
        const VolumeFunction shape = shells(dims);
        const VolumeFunction later = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
          return 1 - shape(i, j, k);
        };
        TestScene scene = small_scene(Mode::kComposite, is_parallel);
        scene.field = make_stored_field(dims, shape, {}, setup);
        scene.look = semi_transparent_look(0, 1);
        scene.camera = askew_camera(scene.field, is_parallel, 1.3);
        if (is_clipped) other_options()[8].second(scene);
        scene = refined(scene);
        Trail trail{make_stored_field(dims, later, {}, setup), scene.look.transfer_function};
        const auto draw_trail = [&](Backend backend) {
          return Renderer(backend, 2)
              .render(with_trail(scene.scene(), trail), scene.camera, scene.options)
              .image;
        };
        const Image reference = draw_trail(Backend::kReference);
        EXPECT_TRUE(images_agree(draw_trail(tested_backend()), reference, scene,
                                 std::string("trail, ") + name_of(kind) + view_name(is_parallel) +
                                     (is_clipped ? ", clipped" : "")));
        EXPECT_LT(compare(draw(scene).image, reference).psnr_db, 40);
      }
    }
  }
}

struct NamedSet {
  std::string name;
  KernelNumbers numbers;
};

std::vector<NamedSet> test_sets() {
  KernelNumbers spline = jittered_balls(8);
  spline.profile = KernelProfile::kCubicSpline;
  return {{"ellipsoids", jittered_ellipsoids(9)},
          {"stretched 30 to 1", jittered_ellipsoids(7, 5.5)},
          {"balls", jittered_balls(9)},
          {"cubic splines", spline}};
}

TEST(Refined, AgreesOnEverySetAndLook) {
  OVOID_NIGHTLY_ON_DEVICE();
  OVOID_NOT_UNDER_ASAN();
  for (const NamedSet& set : test_sets()) {
    const KernelField field(set.numbers.source(), Reconstruction::kNormalized);
    for (const TestLook& look : test_looks(0, 1)) {
      for (const bool is_parallel : {true, false}) {
        const TestScene scene{field, askew_camera(field, is_parallel, is_parallel ? 1.0 : 1.6),
                              look.look, picture(72, 66)};
        EXPECT_TRUE(backends_agree(refined_pixels(scene),
                                   set.name + ", " + look.name + view_name(is_parallel), 0.002));
      }
    }
  }
}

TEST(Refined, AgreesOnSetsWithOtherOptions) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const Reconstruction sum : {Reconstruction::kNormalized, Reconstruction::kSum}) {
    const KernelField field(jittered_ellipsoids(7).source(), sum);
    const KernelField colored(field.shared_source(), sum, 0, 1);
    for (const bool is_parallel : {true, false}) {
      const std::string name = std::string(sum == Reconstruction::kSum ? "sums, " : "set, ");
      for (const auto& [what, change] : other_options()) {
        if (what == "exact" || what == "central") continue;  // sets have differences alone
        TestScene scene{field, askew_camera(field, is_parallel, 1.3), semi_transparent_look(0, 1),
                        picture(50, 40)};
        change(scene);
        if (what == "clipped")
          scene.options.clip_planes = {{{-1, 0.6, 0.5}, -0.1}, {{0.2, 1, 0}, 0.3}};
        if (what == "scatter") scene.options.evaluate = Evaluate::kGather;  // fragment-centric
        EXPECT_TRUE(
            backends_agree(refined_pixels(scene), name + what + view_name(is_parallel), 0.02));
      }
      TestScene scene{colored, askew_camera(colored, is_parallel, 1.3), semi_transparent_look(0, 1),
                      picture(50, 40)};
      scene.look.color_function = ramp_look(colored.color_range()).transfer_function;
      EXPECT_TRUE(
          backends_agree(refined_pixels(scene), name + "own colour" + view_name(is_parallel)));
    }
  }
}

// Lattices and sets whose looks leave much out; distances of sheets that differ.
std::vector<TestScene> scenes_to_skip() {
  std::vector<TestScene> scenes;
  for (const TestVolume& volume : test_volumes()) {
    for (const TestLook& look : test_looks(volume.lo, volume.hi)) {
      const bool is_parallel = scenes.size() % 2 == 0;
      const double distance = scenes.size() % 3 == 0 ? 2.5 : 0.5;
      scenes.push_back({volume.field, askew_camera(volume.field, is_parallel, 1.4), look.look,
                        picture(60, 50, distance * volume.field.default_sampling_distance())});
    }
  }
  for (const Reconstruction sum : {Reconstruction::kNormalized, Reconstruction::kSum}) {
    const KernelField field(jittered_ellipsoids(9).source(), sum);
    for (const TestLook& look : test_looks(0, 1)) {
      TestScene scene{field, askew_camera(field, false, 1.5), look.look, picture(130, 100)};
      scenes.push_back(scene);
      scene.options.clip_planes = {{{-1, 0.6, 0.5}, -0.1}, {{0, 0, 1}, 0.55}};
      scenes.push_back(scene);
    }
  }
  return scenes;
}

// Fails if a piece is left out that shows, at a brick's or a block's border most of all.
TEST(Refined, SkippingChangesNoByte) {
  OVOID_NIGHTLY_ON_DEVICE();
  int number = -1;
  for (TestScene scene : scenes_to_skip()) {
    ++number;
    if (tested_backend() == Backend::kVulkan && number % 4 != 1)
      continue;  // software takes minutes
    scene = refined(scene);
    const Image skipped = draw(scene).image;
    scene.options.skip_irrelevant = false;
    scene.options.stop_opaque = false;
    const Image whole = draw(scene).image;
    EXPECT_TRUE(whole == skipped) << number;
  }
}

// Fails if pieces between two boxes of a lattice that does not fit, or two pages of a set, are
// drawn twice or not at all.
TEST(RefinedOnDevice, PiecesAreWholeAcrossBoxesAndPages) {
  OVOID_NIGHTLY_ON_DEVICE();
  if (tested_backend() != Backend::kVulkan) GTEST_SKIP() << "another back end is tested";
  const auto draw_within = [](const TestScene& scene, std::uint64_t bytes) {
    return Renderer(RendererSetup{.backend = Backend::kVulkan, .device_memory = bytes})
        .render({scene.field, scene.look}, scene.camera, scene.options)
        .image;
  };
  const Index3 dims{40, 36, 44};
  for (int way = 0; way < 5; ++way) {
    TestScene scene;
    scene.field = make_stored_field(dims, shells(dims), {ScalarType::kUInt8, 0, 255});
    scene.camera = askew_camera(scene.field, way == 1, 1.3);
    scene.look = semi_transparent_look(0, 255);
    scene.options = picture(40, 36);
    scene = refined_pixels(scene);
    if (way == 2) scene.options.gradient = GradientMethod::kCentral;
    if (way >= 3) {
      scene.camera = askew_camera(scene.field, way == 3, 6);
      scene.options.post_convolution = PostConvolution::kAuto;
    }
    const Image whole = draw(scene).image;
    const Image in_boxes = draw_within(scene, 64U << 10U);
    EXPECT_TRUE(in_boxes == whole) << way << ": " << compare(in_boxes, whole).to_string();
  }
  TestScene set;
  set.field = KernelField(jittered_ellipsoids(24).source(), Reconstruction::kNormalized);
  set.camera = askew_camera(set.field, false, 1.3);
  set.look = semi_transparent_look(0, 1);
  set.options = picture(80, 160);
  set = refined_pixels(set);
  EXPECT_TRUE(draw_within(set, 720U << 10U).rgba == draw(set).image.rgba);
}

// Fails if 16 bits are taken where they decide about the number of steps, or never.
TEST(RefinedOnDevice, HalfSheetsKeepTheirTier) {
  OVOID_NIGHTLY_ON_DEVICE();
  if (tested_backend() != Backend::kVulkan) GTEST_SKIP() << "another back end is tested";
  const KernelField field(jittered_ellipsoids(9).source(), Reconstruction::kNormalized);
  for (const double opacity : {0.05, 0.9}) {
    TestScene scene{field, askew_camera(field, false, 1.3), semi_transparent_look(0, 1),
                    picture(56, 44)};
    scene.look.shade = false;
    // At unit distances of a sheet the opacity is the look's own.
    scene.look.unit_distance = 0.5 * field.default_sampling_distance();
    scene.look.transfer_function.opacities = {{0, 0}, {1, opacity}};
    scene = refined(scene);
    const Frame whole = draw(scene);
    scene.options.sheet_precision = SheetPrecision::kHalf;
    const Frame half = draw(scene);
    EXPECT_EQ(half.profile.notice.empty(), opacity < 0.5) << half.profile.notice;
    EXPECT_EQ(half.profile.notice.empty(), half.image.rgba != whole.image.rgba);
    const ImageDifference lost = compare(half.image, whole.image);
    EXPECT_GE(lost.psnr_db, kHalfSheetsPsnrDb) << lost.to_string();
    EXPECT_LE(lost.max_8bit, kHalfSheets8BitDifference) << lost.to_string();
  }
}

}  // namespace refined_test
}  // namespace ovoid::test
