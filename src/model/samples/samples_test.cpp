// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "model/lattice/noise.h"
#include "model/samples/sample_formulas.h"
#include "ovoid/error.h"
#include "ovoid/model.h"

namespace ovoid {
namespace samples_test {

template <class T>
std::span<const T> values_of(const Dataset& dataset) {
  const auto& bytes = dataset.arrays.at(0).bytes.view;
  return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
}

MakeOptions sized(std::int64_t x, std::int64_t y, std::int64_t z) {
  MakeOptions options;
  options.size = {x, y, z};
  return options;
}

// Every name, at a size that is not a cube: a whole dataset within the range that it says, and the
// same one twice.
TEST(MakeSample, EveryNameMakesADataset) {
  ASSERT_FALSE(sample_names().empty());
  for (const model::SampleKind& kind : model::sample_kinds()) {
    SCOPED_TRACE(kind.name);
    EXPECT_NE(describe_sample(kind.name).find(std::to_string(kind.default_size)),
              std::string::npos);
    const Dataset dataset = make_sample(kind.name, sized(9, 8, 7));
    EXPECT_EQ(dataset.lattice.dims, (Index3{9, 8, 7}));
    const auto values = values_of<float>(dataset);
    ASSERT_EQ(values.size(), 9U * 8U * 7U * (kind.make_second != nullptr ? 2U : 1U));
    for (const float value : values) {
      ASSERT_GE(value, static_cast<float>(kind.lo) - 1e-6F);
      ASSERT_LE(value, static_cast<float>(kind.hi) + 1e-6F);
    }
    const Dataset again = make_sample(kind.name, sized(9, 8, 7));
    EXPECT_TRUE(std::ranges::equal(values, values_of<float>(again)));
    EXPECT_NO_THROW(make_lattice_field(dataset));
  }
}

// Fails if a stain is in the other's place, or a number is another sample's.
TEST(MakeSample, CellsHaveNucleiWithinMembranes) {
  const Dataset dataset = make_sample("cells", sized(40, 40, 40));
  ASSERT_EQ(dataset.array().num_components, 2);
  const auto values = values_of<float>(dataset);
  std::int64_t num_nuclei = 0, num_membranes = 0, num_both = 0;
  for (std::size_t i = 0; i < values.size(); i += 2) {
    num_nuclei += values[i] > 0.4F;
    num_membranes += values[i + 1] > 0.4F;
    num_both += values[i] > 0.4F && values[i + 1] > 0.4F;
  }
  EXPECT_GT(num_nuclei, 500);
  EXPECT_GT(num_membranes, num_nuclei);
  EXPECT_LT(num_both, num_nuclei / 20);
  EXPECT_LT(values[0] + values[1], 0.2F);  // a corner
}

// Corners stand on the corners of the cube, a single sample in its middle.
TEST(MakeSample, SpansTheCubeAtAnySize) {
  const LatticeGeometry lattice = make_sample("constant", sized(5, 3, 1)).lattice;
  EXPECT_EQ(Vec3(lattice.world_from_index * Vec3(0, 0, 0)), Vec3(-1, -1, 0));
  EXPECT_EQ(Vec3(lattice.world_from_index * Vec3(4, 2, 0)), Vec3(1, 1, 0));
  EXPECT_EQ(lattice.spacing(), Vec3(0.5, 1, 2));
}

// [METHOD 2.4] at a few positions, by hand: on the z axis the ripple is cos(12 pi) = 1; at r = 1,
// cos(0) = 1.
TEST(MakeSample, MarschnerLobb) {
  const Dataset dataset = make_sample("marschner-lobb");
  EXPECT_EQ(dataset.lattice.dims, (Index3{40, 40, 40}));
  const Dataset small = make_sample("marschner-lobb", sized(3, 3, 3));
  const auto values = values_of<float>(small);
  EXPECT_NEAR(values[4], 1.0, 1e-6);   // (0, 0, -1): (1 + 1 + 0.5) / 2.5
  EXPECT_NEAR(values[13], 0.6, 1e-6);  // (0, 0, 0): (1 + 0.5) / 2.5
  EXPECT_NEAR(values[22], 0.2, 1e-6);  // (0, 0, 1)
  EXPECT_NEAR(values[12], 0.6, 1e-6);  // (-1, 0, 0)
  const double ripple =
      std::cos(12 * std::numbers::pi * std::cos(std::numbers::pi * std::sqrt(0.5)));
  EXPECT_NEAR(values[9], (1 + 0.25 * (1 + ripple)) / 2.5, 1e-6);  // (-1, -1, 0): r = sqrt(2)
}

TEST(MakeSample, SimpleShapes) {
  const Dataset constant = make_sample("constant", sized(4, 4, 4));
  for (const float value : values_of<float>(constant)) EXPECT_EQ(value, 1.0F);
  const Dataset box = make_sample("box", sized(9, 1, 1));  // spacing 1/4, exact
  const std::vector<float> expected = {0, 0, 1, 1, 1, 1, 1, 0, 0};
  EXPECT_TRUE(std::ranges::equal(values_of<float>(box), expected));
  const Dataset flat = make_sample("flat", sized(2, 2, 2));
  EXPECT_EQ(values_of<float>(flat)[0], 0.0F);
  EXPECT_EQ(values_of<float>(flat)[7], 1.0F);
  const Dataset ball = make_sample("ball", sized(5, 1, 1));
  EXPECT_TRUE(std::ranges::equal(values_of<float>(ball), std::vector<float>{0, 0.5F, 1, 0.5F, 0}));
}

// 9 samples at 1/4 of 24 Bohr radii: the peak, 6 radii from the centre on the z axis, is hit, and
// the nodes are too: the centre.
TEST(MakeSample, OrbitalPeaksAtSixBohrRadii) {
  const Dataset orbital = make_sample("orbital", sized(1, 1, 9));
  const auto values = values_of<float>(orbital);
  EXPECT_NEAR(values[3], 1.0, 1e-6);
  EXPECT_NEAR(values[5], 1.0, 1e-6);
  EXPECT_EQ(values[4], 0.0F);
}

// The ends of the formula's range are those of the type.
TEST(MakeSample, IntegersAreScaledToTheirType) {
  MakeOptions options = sized(2, 2, 2);
  options.type = ScalarType::kUInt8;
  const Dataset bytes = make_sample("flat", options);
  EXPECT_EQ(values_of<std::uint8_t>(bytes)[0], 0);
  EXPECT_EQ(values_of<std::uint8_t>(bytes)[1],
            128);  // 1/2 - 3/12 + ... : (1, -1, -1) is 0.5 exactly, 127.5 rounds up
  EXPECT_EQ(values_of<std::uint8_t>(bytes)[7], 255);
  options.type = ScalarType::kUInt16;
  EXPECT_EQ(values_of<std::uint16_t>(make_sample("flat", options))[7], 65535);
  const Dataset head = make_sample("head", options);  // the corners are air, the least value
  EXPECT_EQ(values_of<std::uint16_t>(head)[0], 0);
  EXPECT_EQ(head.arrays[0].unit, "");  // no Hounsfield units any more
}

TEST(MakeSample, SeedsChooseTheRandomNumbers) {
  const auto blobs = [](std::uint64_t seed) {
    MakeOptions options = sized(8, 8, 8);
    options.seed = seed;
    const Dataset dataset = make_sample("gaussians", options);
    const auto values = values_of<float>(dataset);
    return std::vector<float>(values.begin(), values.end());
  };
  EXPECT_EQ(blobs(1), blobs(1));
  EXPECT_NE(blobs(1), blobs(2));
}

// What a reader of the README sees must be in there: air, brain and bone, in patient axes.
TEST(MakeSample, HeadHoldsItsTissues) {
  const Dataset head = make_sample("head", sized(64, 64, 64));
  EXPECT_EQ(head.space, Space::kLps);
  EXPECT_EQ(head.arrays[0].unit, "HU");
  const auto values = values_of<float>(head);
  const auto share = [&](float lo, float hi) {
    const auto count = std::ranges::count_if(values, [&](float v) { return v >= lo && v <= hi; });
    return static_cast<double>(count) / static_cast<double>(values.size());
  };
  EXPECT_GT(share(-1000, -999), 0.5);
  EXPECT_GT(share(5, 45), 0.05);
  EXPECT_GT(share(700, 1300), 0.01);
  EXPECT_EQ(values[values.size() - 1], -1000.0F);
}

TEST(MakeSample, NamesWhatIsWrong) {
  const auto refusal = [](const std::string& name, const MakeOptions& options) {
    try {
      make_sample(name, options);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_TRUE(
      refusal("teapot", {}).starts_with("sample 'teapot': must be one of marschner-lobb, "));
  EXPECT_TRUE(refusal("ball", sized(4, 0, 4)).starts_with("size[1] = 0"));
  EXPECT_TRUE(refusal("ball", sized(4, 4, -1)).starts_with("size[2] = -1"));
  EXPECT_TRUE(refusal("ball", sized(100000, 4, 4)).starts_with("size[0] = 100000"));
  MakeOptions options = sized(4, 4, 4);
  options.type = ScalarType::kInt32;
  EXPECT_TRUE(refusal("ball", options).starts_with("type = int32"));
  EXPECT_THROW(describe_sample("teapot"), Error);
}

// The reference values of SplitMix64 with seed 1234567.
TEST(Random, IsSplitMix64) {
  model::Random random(1234567);
  EXPECT_EQ(random.next(), 6457827717110365317U);
  EXPECT_EQ(random.next(), 3203168211198807973U);
}

// Fails if cells of the noise do not meet: a step across whole positions far above its slope (at
// most 3 per unit and axis).
TEST(SmoothNoise, IsContinuousAndBounded) {
  model::Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 at(std::floor(random.uniform(-9, 9)), random.uniform(-9, 9), random.uniform(-9, 9));
    const Vec3 step(1e-7, 0, 0);
    EXPECT_NEAR(model::smooth_noise(at - step, 3), model::smooth_noise(at + step, 3), 1e-6);
    EXPECT_LE(std::abs(model::smooth_noise(at, 3)), 1.0);
  }
}

}  // namespace samples_test
}  // namespace ovoid
