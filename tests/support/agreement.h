// SPDX-License-Identifier: Apache-2.0
// What the agreement tests draw: volumes, looks and views, each with something in it that a back
// end could get wrong; and the comparison of a back end with the reference.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "ovoid/renderer.h"
#include "support/compare.h"
#include "support/volumes.h"

namespace ovoid::test {

// A volume in memory of its own, of one stored type. `shape` is in [0, 1] (or kMissing, for
// kFloat32 only); the stored numbers are lo + shape * (hi - lo), rounded for whole-numbered types.
struct StoredRange {
  ScalarType type = ScalarType::kFloat32;
  double lo = 0;
  double hi = 1;
};
LatticeField make_stored_field(const Index3& dims, const VolumeFunction& shape,
                               const StoredRange& stored, const FieldSetup& setup = {});

// The published ways take the reference so long under sanitizers that pictures are smaller there.
#ifdef OVOID_SANITIZED
inline constexpr int kPublishedShrink = 2;
#else
inline constexpr int kPublishedShrink = 1;
#endif

// A function of period some samples with a slope everywhere, in [0, 1]: shells, no symmetry.
VolumeFunction shells(const Index3& dims);

struct TestVolume {
  std::string name;
  LatticeField field;
  double lo;  // the values' nominal range; a constant volume has none of its own
  double hi;
};
// uint8 with anisotropic spacing; int16 on oblique left-handed axes with a value scale and offset;
// float32 with holes; one slice; one sample.
std::vector<TestVolume> test_volumes();

struct TestLook {
  std::string name;
  Look look;
};
// Two with an opacity peak 2 % of the range wide, an opaque and a semi-transparent ramp, and one
// whose colour has a step.
std::vector<TestLook> test_looks(double lo, double hi);
Look semi_transparent_look(double lo, double hi);

inline constexpr Mode kModes[] = {Mode::kComposite, Mode::kXray,       Mode::kMaximum,
                                  Mode::kMean,      Mode::kIsosurface, Mode::kMinimum};
inline constexpr const char* kModeNames[] = {"composite", "xray",       "maximum",
                                             "mean",      "isosurface", "minimum"};

struct TestScene {
  Field field;
  Camera camera;
  Look look;
  RenderOptions options;
  std::vector<Volume> further{};  // behind the first
  Mixing mixing = Mixing::kAveraged;

  const LatticeField& lattice() const { return *field.lattice(); }
  Scene scene() const;
};

Scene with_trail(Scene scene, Trail trail);

// A view from no axis' direction that shows the whole field, its bounding sphere `fill` times as
// high as the picture.
Camera askew_camera(const Field& field, bool is_parallel, double fill = 1.0);

inline constexpr std::array kPublishedWays = {PostConvolution::kBilinear,
                                              PostConvolution::kGaussian, PostConvolution::kCubic};
const char* name_of(PostConvolution published);

// Limits for a scene's picture: stops at random, at most `reach` from the focal distance, half of
// them with a colour; up to eight in a pixel, and none in every ninth. Some pixels are covered in
// part.
std::shared_ptr<const DepthLimits> random_limits(const TestScene& scene, double reach);

// 12 x 11 x 13 samples on oblique axes with all of it in a picture of 24 x 20: small enough for the
// reference's slab means.
TestScene small_scene(Mode mode, bool is_parallel);

// The back end that is held to the reference: cpu, or what the environment's OVOID_TEST_BACKEND
// names. So all of these tests are run for every back end.
Backend tested_backend();
// Whether it draws on a graphics processor, where kAuto takes no nodes and no levels.
bool is_on_graphics_processor();

// Mesa's software driver compiles shaders for every scene, which takes seconds. Of two choices, say
// look and projection by number, vulkan draws every second pair: each choice with some of the
// other.
bool is_left_out(int first, int second);

// With a renderer of its own on two threads; of the vulkan back end, which takes seconds to start
// where a processor is its device, one for all.
Frame draw(const TestScene& scene, Backend backend = tested_backend());

// Draws the scene with both back ends and holds the tested one to `tolerance` and
// kAgreementOtherDepths; prints one line with what was measured. `least_covered`: share of the
// picture that must show something, so that an empty scene does not pass for agreement.
::testing::AssertionResult backends_agree(const TestScene& scene, const std::string& name,
                                          double least_covered = 0.05,
                                          ImageTolerance tolerance = {});

// The same with the reference's picture at hand.
::testing::AssertionResult agrees_with(const Image& reference, const TestScene& scene,
                                       const std::string& name, double least_covered = 0.05,
                                       ImageTolerance tolerance = {});

// The same with both pictures at hand.
::testing::AssertionResult images_agree(const Image& image, const Image& reference,
                                        const TestScene& scene, const std::string& name,
                                        double least_covered = 0.05, ImageTolerance tolerance = {});

// Every way to evaluate the scene against one picture of the reference.
void expect_agreement_however_evaluated(TestScene scene, const std::string& name,
                                        double least_covered = 0.05);

}  // namespace ovoid::test
