// SPDX-License-Identifier: Apache-2.0
// Several volumes in one picture: the cpu back end against the reference, and what a second volume
// must not change (docs/numerics.md, "Several volumes").
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "ovoid/error.h"
#include "support/agreement.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace further_volumes_test {

VolumeFunction ripples(double phase) {
  return [phase](std::int64_t i, std::int64_t j, std::int64_t k) {
    const auto x = static_cast<double>(i), y = static_cast<double>(j), z = static_cast<double>(k);
    return 0.5 + 0.3 * std::cos(0.8 * x + 0.5 * z + phase) + 0.15 * std::sin(0.9 * y - 0.4 * z);
  };
}

Look embers() {
  Look look;
  look.transfer_function.colors = {{0, {0.9, 0.1, 0.1}}, {1, {1.0, 0.9, 0.2}}};
  look.transfer_function.opacities = {{0.4, 0}, {0.9, 0.5}};
  return look;
}

// How the second volume lies: on coarser axes along those of the first, on the first's in another
// order, or askew; shifted, so that they overlap in part.
enum class Lies { kAlong, kReordered, kAskew };

LatticeField second_field(const LatticeField& first, Lies how,
                          LatticeKind kind = LatticeKind::kCartesian) {
  const Affine3& axes = first.geometry().world_from_index;
  FieldSetup setup;
  setup.lattice = kind;
  Mat3 linear = axes.linear();
  Index3 dims{8, 9, 7};
  if (how == Lies::kAlong) linear = 1.7 * axes.linear();
  if (how == Lies::kReordered) {
    linear.col(0) = 1.4 * axes.linear().col(2);
    linear.col(1) = 1.6 * axes.linear().col(0);
    linear.col(2) = 1.5 * axes.linear().col(1);
  }
  if (how == Lies::kAskew) {
    linear = 1.6 * Eigen::AngleAxisd(0.7, Vec3(0.3, 0.5, 0.8).normalized()).toRotationMatrix() *
             axes.linear();
  }
  if (kind == LatticeKind::kBodyCentred) dims[2] *= 2;
  setup.world_from_index.linear() = linear;
  const Vec3 middle(0.5 * (dims[0] - 1), 0.5 * (dims[1] - 1), 0.5 * (dims[2] - 1));
  setup.world_from_index.translation() =
      first.world_bounds().center() + 0.15 * first.world_bounds().diagonal() - linear * middle;
  return make_stored_field(dims, ripples(0.4), {}, setup);
}

TestScene mixed_scene(bool is_parallel, Lies how) {
  TestScene scene = small_scene(Mode::kComposite, is_parallel);
  scene.further = {{second_field(scene.lattice(), how), embers()}};
  return scene;
}

// The first volume of a scene alone, drawn as it is with the others.
TestScene without_further(TestScene scene) {
  scene.further.clear();
  return scene;
}

void expect_agreement(const TestScene& scene, const std::string& name) {
  EXPECT_TRUE(backends_agree(scene, name));
  // There is something of the second volume in it.
  EXPECT_LT(compare(draw(without_further(scene)).image, draw(scene).image).psnr_db, 35) << name;
}

std::string words_of(Lies how, bool is_parallel) {
  return fmt::format("{}, {}",
                     how == Lies::kAlong   ? "along"
                     : how == Lies::kAskew ? "askew"
                                           : "reordered",
                     is_parallel ? "parallel" : "perspective");
}

constexpr Lies kAllWays[] = {Lies::kAlong, Lies::kReordered, Lies::kAskew};

// Fails if steps of two volumes that lie on different lattices are not those of the same places, or
// are mixed in other shares than the rule's.
TEST(FurtherVolumesAgreement, ViewsAndClassifications) {
  OVOID_NOT_ON_DEVICE("draws one volume");
  for (const Classification classification :
       {Classification::kRefined, Classification::kSampled, Classification::kPreintegrated}) {
    for (const bool is_parallel : {true, false}) {
      TestScene scene = mixed_scene(is_parallel, Lies::kAskew);
      scene.options.classification = classification;
      expect_agreement(scene, words_of(Lies::kAskew, is_parallel));
    }
  }
}

// Fails if colours that add are mixed in other shares, or by another opacity, than the rule's.
TEST(FurtherVolumesAgreement, AddedColors) {
  OVOID_NOT_ON_DEVICE("draws one volume");
  for (const Classification classification : {Classification::kRefined, Classification::kSampled}) {
    TestScene scene = mixed_scene(false, Lies::kAskew);
    scene.options.classification = classification;
    const Image averaged = draw(scene).image;
    scene.mixing = Mixing::kAdded;
    EXPECT_TRUE(backends_agree(scene, "added"));
    EXPECT_LT(compare(averaged, draw(scene).image).psnr_db, 45);
  }
}

// On the first volume's own lattice: colours alone, from black to one colour.
Volume blue_of(const LatticeField& first) {
  FieldSetup setup;
  setup.world_from_index = first.geometry().world_from_index;
  Look look = embers();
  look.transfer_function.colors = {{0, {0, 0, 0}}, {1, {0, 0, 1}}};
  look.transfer_function.opacities = {{0, 1}, {1, 1}};
  look.shade = false;
  return {make_stored_field(first.geometry().dims, ripples(0.4), {}, setup), look};
}

// Fails if a volume that only colours shows where the field does not, or hides or lights anything.
TEST(FurtherVolumesAgreement, ColoredFields) {
  OVOID_NOT_ON_DEVICE("draws one volume");
  for (const Sheets sheets : {Sheets::kImage, Sheets::kLattice}) {
    for (const Classification classification :
         {Classification::kRefined, Classification::kSampled}) {
      TestScene scene = small_scene(Mode::kComposite, false);
      scene.options.sheets = sheets;
      scene.options.classification = classification;
      const Image alone = draw(scene).image;
      scene.further = {blue_of(scene.lattice())};
      scene.mixing = Mixing::kColored;
      EXPECT_TRUE(backends_agree(scene, "colored"));
      const Image image = draw(scene).image;
      double blue = 0;
      for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        EXPECT_EQ(image.rgba[i], 0);
        EXPECT_EQ(image.rgba[i + 1], 0);
        blue += image.rgba[i + 2];
        ASSERT_NEAR(image.rgba[i + 3], alone.rgba[i + 3], 2e-3) << i / 4;
      }
      EXPECT_GT(blue, 1);
    }
  }
}

// Pictures of the volumes alone are the measure. Fails if one is left out, or counts twice.
TEST(FurtherVolumes, MaximaAddUp) {
  OVOID_NIGHTLY_ON_DEVICE();
  TestScene scene = mixed_scene(true, Lies::kAskew);
  scene.look.mode = Mode::kMaximum;
  Look second = embers();
  second.mode = Mode::kMaximum;
  const Field other = scene.further.front().field;
  scene.further = {{other, second}};
  const Image first_alone = draw(without_further(scene)).image;
  TestScene alone = without_further(scene);
  alone.field = other;
  alone.look = second;
  const Image second_alone = draw(alone).image;
  for (const Mixing mixing : {Mixing::kAdded, Mixing::kAveraged}) {
    scene.mixing = mixing;
    const Image both = draw(scene).image;
    for (std::size_t i = 0; i < both.rgba.size(); ++i) {
      const float opacity = first_alone.rgba[i | 3] + second_alone.rgba[i | 3];
      const float scale = mixing == Mixing::kAveraged && opacity > 1 ? 1 / opacity : 1;
      ASSERT_NEAR(both.rgba[i],
                  std::min(1.0F, scale * (first_alone.rgba[i] + second_alone.rgba[i])), 1e-6F);
    }
  }
}

// Fails if a lattice that lies along the base plane is summed by wrong rows, or one that does not
// is taken for one that does.
TEST(FurtherVolumesAgreement, LatticeSheets) {
  OVOID_NOT_ON_DEVICE("draws one volume");
  for (const Lies how : kAllWays) {
    for (const bool is_parallel : {true, false}) {
      TestScene scene = mixed_scene(is_parallel, how);
      scene.options.sheets = Sheets::kLattice;
      expect_agreement(scene, "lattice sheets, " + words_of(how, is_parallel));
    }
  }
}

// Fails if the window of the base plane leaves out what only the second volume has, or if samples
// are farther apart than its own.
TEST(FurtherVolumesAgreement, LatticeSheetsOfTheFinerVolume) {
  OVOID_NOT_ON_DEVICE("draws one volume");
  TestScene scene = mixed_scene(false, Lies::kAlong);
  const Field coarse = scene.further.front().field;
  scene.further = {{scene.lattice(), scene.look}};
  scene.field = coarse;
  scene.look = embers();
  scene.options.sheets = Sheets::kLattice;
  expect_agreement(scene, "finer second volume");
}

// Fails if blocks of two volumes get out of step: other margins, planes, sheets that are finished
// late.
TEST(FurtherVolumesAgreement, DifferencesPlanesAndLattices) {
  OVOID_NOT_ON_DEVICE("draws one volume");
  TestScene scene = mixed_scene(false, Lies::kAskew);
  scene.options.gradient = GradientMethod::kCentral;
  expect_agreement(scene, "central differences");
  // One volume takes differences, the other no gradients at all.
  scene.look.shade = false;
  expect_agreement(scene, "central differences of one");
  scene.options.gradient = GradientMethod::kExact;
  const Vec3 center = scene.field.world_bounds().center();
  const Vec3 normal = Vec3(0.3, -0.8, 0.5).normalized();
  scene.options.clip_planes = {{normal, normal.dot(center)}};
  expect_agreement(scene, "clipped");
  scene.look.shade = true;
  expect_agreement(scene, "clipped and lit");
  scene.options.clip_planes.clear();
  scene.further = {
      {second_field(scene.lattice(), Lies::kAskew, LatticeKind::kBodyCentred), embers()}};
  expect_agreement(scene, "body-centred second volume");
  scene.further = {{second_field(scene.lattice(), Lies::kAlong), embers()},
                   {second_field(scene.lattice(), Lies::kReordered), semi_transparent_look(0, 1)},
                   {second_field(scene.lattice(), Lies::kAskew), embers()}};
  expect_agreement(scene, "four volumes");
}

// Fails if the two come to a pixel's stops at different times.
TEST(FurtherVolumesAgreement, DepthLimits) {
  OVOID_NOT_ON_DEVICE("draws one volume");
  for (const Classification classification : {Classification::kRefined, Classification::kSampled}) {
    TestScene scene = mixed_scene(false, Lies::kAskew);
    scene.options.classification = classification;
    scene.options.depth_limits = random_limits(scene, 8);
    expect_agreement(scene, "depth limits");
  }
}

// Fails if what one volume absorbs does not darken the other.
TEST(FurtherVolumesAgreement, LightFromACoarseVolume) {
  OVOID_NOT_ON_DEVICE("draws one volume");
  TestScene scene = mixed_scene(true, Lies::kAskew);
  scene.look.occlusion = 0.8;
  scene.look.shadows = 0.7;
  scene.look.light = Light::kStudio;
  expect_agreement(scene, "occlusion and shadows");
  // The first volume shows nothing, but for a clear look's shadow; the second is no darker alone.
  TestScene lit = scene;
  lit.look.occlusion = lit.look.shadows = 0;
  EXPECT_LT(compare(draw(lit).image, draw(scene).image).psnr_db, 40);
}

// Fails if a look that is as steep as a step, or opaque, is drawn in other steps in company.
TEST(FurtherVolumesAgreement, SteepLooks) {
  OVOID_NOT_ON_DEVICE("draws one volume");
  TestScene scene = mixed_scene(true, Lies::kAskew);
  scene.options.width = 48;
  scene.options.height = 40;
  Look opaque = embers();
  opaque.transfer_function.opacities = {{0.55, 0}, {0.6, 1}};
  scene.further = {{second_field(scene.lattice(), Lies::kAskew), opaque}};
  expect_agreement(scene, "an opaque second volume");
  scene.look.transfer_function.opacities = {{28, 0}, {30, 1}};
  expect_agreement(scene, "two opaque volumes");
}

// Of extinctions that add it makes no difference who is first.
TEST(FurtherVolumes, DoNotDependOnTheirOrder) {
  OVOID_NOT_ON_DEVICE("draws one volume");
  for (const Sheets sheets : {Sheets::kImage, Sheets::kAuto}) {
    TestScene scene = mixed_scene(false, Lies::kAskew);
    scene.options.sheets = sheets;
    const Volume second = scene.further.front();
    TestScene swapped = scene;
    swapped.field = second.field;
    swapped.look = second.look;
    swapped.further = {{scene.lattice(), scene.look}};
    EXPECT_GE(compare(draw(scene).image, draw(swapped).image).psnr_db, 100);
  }
}

// A volume that is drawn twice, each time with half of its extinction, is the volume: but for the
// number of steps, which half an opacity needs fewer of.
TEST(FurtherVolumes, TwoHalvesMakeAWhole) {
  OVOID_NOT_ON_DEVICE("draws one volume");
  TestScene whole = small_scene(Mode::kComposite, false);
  whole.options.sampling_distance = 0.05;
  TestScene halves = whole;
  // Opacities between two points go straight, not extinctions: a constant one is halved exactly.
  whole.look.transfer_function.opacities = {{20, 0.3}};
  halves.look.transfer_function.opacities = {{20, 1 - std::sqrt(1 - 0.3)}};
  halves.further = {{halves.lattice(), halves.look}};
  EXPECT_GE(compare(draw(halves).image, draw(whole).image).psnr_db, 60);
  EXPECT_GE(compare(draw(halves, Backend::kReference).image, draw(whole).image).psnr_db, 60);
}

// Where one volume alone shows something, the picture is that volume's own.
TEST(FurtherVolumes, AloneAreAsWithoutTheOthers) {
  OVOID_NOT_ON_DEVICE("draws one volume");
  TestScene scene = mixed_scene(false, Lies::kAskew);
  scene.options.sampling_distance = 0.4;
  // The other lies elsewhere in the world, and shows a part of itself at the picture's border.
  FieldSetup setup;
  setup.world_from_index = scene.lattice().geometry().world_from_index;
  setup.world_from_index.translation() += Vec3(14, 0, 0);
  const LatticeField aside = make_stored_field({12, 11, 13}, ripples(0), {}, setup);
  scene.further = {{aside, embers()}};
  const Image both = draw(scene).image;
  const Image own = draw(without_further(scene)).image;
  TestScene other = without_further(scene);
  other.field = aside;
  other.look = embers();
  const Image others = draw(other).image;
  int num_own = 0, num_others = 0;
  for (std::size_t i = 0; i < both.rgba.size(); i += 4) {
    const bool shows_own = own.rgba[i + 3] > 0, shows_other = others.rgba[i + 3] > 0;
    if (shows_own == shows_other) continue;
    (shows_own ? num_own : num_others) += 1;
    // Blocks are cut to the size of the one that reads more, which sums may show in the last digit.
    for (std::size_t c = 0; c < 4; ++c)
      EXPECT_NEAR(both.rgba[i + c], (shows_own ? own : others).rgba[i + c], 1e-5);
  }
  EXPECT_GT(num_own, 50);
  EXPECT_GT(num_others, 5);
}

// Fails if what is skipped, or who draws which tile, can be seen.
TEST(FurtherVolumes, ShortcutsAndThreadsChangeNothing) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const Sheets sheets : {Sheets::kImage, Sheets::kLattice}) {
    TestScene scene = mixed_scene(false, Lies::kAlong);
    scene.options.sheets = sheets;
    scene.options.width = 90;
    scene.options.height = 70;
    const auto draw_by = [&](int threads) {
      return Renderer(Backend::kCpu, threads)
          .render(scene.scene(), scene.camera, scene.options)
          .image;
    };
    const Image expected = draw_by(1);
    EXPECT_EQ(draw_by(3).rgba, expected.rgba);
    scene.options.skip_irrelevant = false;
    scene.options.stop_opaque = false;
    EXPECT_EQ(draw_by(2).rgba, expected.rgba);
  }
}

// A picture of large pixels takes coarser fields of both.
TEST(FurtherVolumes, HaveLevels) {
  OVOID_NOT_ON_DEVICE("draws one volume");
  const Index3 dims{80, 80, 80};
  TestScene scene;
  scene.field = make_field(dims, shells(dims));
  scene.look = semi_transparent_look(0, 1);
  scene.options = picture(24, 24);
  scene.camera = askew_camera(scene.field, true);
  FieldSetup finer;
  finer.world_from_index = scaled_axes(Vec3(0.5, 0.5, 0.5), Vec3(20, 20, 20));
  scene.further = {{make_field(dims, ripples(0), finer), embers()}};
  const Frame frame = draw(scene);
  scene.options.post_convolution = PostConvolution::kOff;
  const Frame every = draw(scene);
  EXPECT_GE(compare(frame.image, every.image).psnr_db, 25);
  // Both are once coarser, and so are their sheets.
  EXPECT_LT(static_cast<double>(frame.profile.samples_reconstructed),
            0.6 * static_cast<double>(every.profile.samples_reconstructed));
}

void expect_refused(const TestScene& scene, ErrorCode code, const std::string& words) {
  for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
    try {
      draw(scene, backend);
      ADD_FAILURE() << "was drawn: " << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  }
}

// Fails if what cannot be drawn is, or the words do not say why.
TEST(FurtherVolumes, RefuseWhatTheyCannotBeDrawnWith) {
  OVOID_NIGHTLY_ON_DEVICE();
  const TestScene good = mixed_scene(true, Lies::kAlong);
  TestScene bad = good;
  bad.further = {{LatticeField(), embers()}};
  expect_refused(bad, ErrorCode::kInvalidArgument, "volumes[1].field");
  const Volume one = good.further.front();
  bad.further = {one, one, one, one};
  expect_refused(bad, ErrorCode::kInvalidArgument, "volumes: 5 given, must be at most 4");
  Volume other = one;
  other.look.mode = Mode::kMaximum;
  bad.further = {one, other};
  expect_refused(bad, ErrorCode::kUnsupported, "volumes[2].look");
  for (const Mode mode : {Mode::kXray, Mode::kMean, Mode::kIsosurface}) {
    bad = good;
    bad.look.mode = mode;
    expect_refused(bad, ErrorCode::kUnsupported, "modes composite");
  }
  bad = good;
  bad.mixing = Mixing::kColored;
  expect_refused(bad, ErrorCode::kUnsupported, "another lattice");
  bad = good;
  bad.options.post_convolution = PostConvolution::kCubic;
  expect_refused(bad, ErrorCode::kUnsupported, "post-convolution");
  bad = good;
  bad.further = {};
  EXPECT_EQ(draw(bad).image.rgba, draw(without_further(good)).image.rgba);
}

}  // namespace further_volumes_test
}  // namespace ovoid::test
