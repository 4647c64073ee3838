// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/resident_lattice.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>

#include "ovoid/error.h"

namespace ovoid {
namespace resident_lattice_test {

template <class T>
Bytes bytes_of(const std::vector<T>& values) {
  return {nullptr, std::as_bytes(std::span<const T>(values))};
}

LatticeGeometry lattice_of(const Index3& dims) {
  LatticeGeometry geometry;
  geometry.dims = dims;
  return geometry;
}

std::vector<std::int16_t> ramp(std::int64_t count) {
  std::vector<std::int16_t> values(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::int16_t>(i);
  return values;
}

// Fails if samples are copied, or the strides are not those of a linear array.
TEST(ResidentLattice, ShowsTheCallersArray) {
  const std::vector<std::int16_t> samples = ramp(10 * 7 * 5);
  const ResidentLattice lattice(lattice_of({10, 7, 5}), ScalarType::kInt16, bytes_of(samples));
  const BrickView view = lattice.acquire(2, 1, 1, 0.0);
  EXPECT_EQ(view.data, samples.data());
  EXPECT_EQ(view.type, ScalarType::kInt16);
  EXPECT_EQ(view.lo, (Index3{0, 0, 0}));
  EXPECT_EQ(view.hi, (Index3{10, 7, 5}));
  EXPECT_EQ(view.stride_y, 10);
  EXPECT_EQ(view.stride_z, 70);
}

// Samples 0 to 19 along x, reach 2: brick 0 sees 0 to 6, brick 2 (cells 8 to 12) 6 to 14, brick 4
// 14 to 19.
TEST(ResidentLattice, BrickRangesAreOfValues) {
  const std::vector<std::int16_t> samples = ramp(20);
  const ResidentLattice plain(lattice_of({20, 1, 1}), ScalarType::kInt16, bytes_of(samples));
  const auto expect_range = [](const ValueRange& range, float lo, float hi) {
    EXPECT_EQ(range.lo, lo);
    EXPECT_EQ(range.hi, hi);
  };
  EXPECT_EQ(plain.range_reach(), 2.0);
  expect_range(plain.brick_range(0, 0, 0), 0, 6);
  expect_range(plain.brick_range(2, 0, 0), 6, 14);
  expect_range(plain.brick_range(4, 0, 0), 14, 19);
  // A negative scale turns the ends around.
  const ResidentLattice scaled(lattice_of({20, 1, 1}), ScalarType::kInt16, bytes_of(samples),
                               {2.0, -0.5, 100.0, 1, {}});
  EXPECT_EQ(scaled.value_scale(), -0.5);
  EXPECT_EQ(scaled.value_offset(), 100.0);
  expect_range(scaled.brick_range(2, 0, 0), 93, 97);
}

TEST(ResidentLattice, KnowsWhereSamplesAreMissing) {
  std::vector<float> samples(40, 3.0F);
  samples[20] = std::numeric_limits<float>::quiet_NaN();
  const ResidentLattice lattice(lattice_of({40, 1, 1}), ScalarType::kFloat32, bytes_of(samples));
  EXPECT_EQ(lattice.num_missing(), 1);
  // Sample 20 is within 2 of the closed cells of bricks 4 (16 to 20) and 5 (20 to 24), not of 3 (to
  // 16) or 6 (from 24).
  for (int b = 0; b < 10; ++b) EXPECT_EQ(lattice.has_missing(b, 0, 0), b == 4 || b == 5) << b;
  const std::vector<float> whole(40, 3.0F);
  const ResidentLattice dense(lattice_of({40, 1, 1}), ScalarType::kFloat32, bytes_of(whole));
  EXPECT_FALSE(dense.has_missing(5, 0, 0));
}

TEST(ResidentLattice, RangeIsEmptyWhereNothingExists) {
  const std::vector<float> samples(8, std::numeric_limits<float>::infinity());
  const ResidentLattice lattice(lattice_of({8, 1, 1}), ScalarType::kFloat32, bytes_of(samples),
                                {2.0, 2.0, 1.0, 1, {}});
  EXPECT_TRUE(lattice.brick_range(0, 0, 0).is_empty());
  EXPECT_EQ(lattice.num_missing(), 8);
}

// The promise of 1.1 times the stored samples.
TEST(ResidentLattice, CostsThreePercentMoreThanItsSamples) {
  const std::vector<std::uint8_t> samples(64 * 64 * 64, 1);
  const ResidentLattice lattice(lattice_of({64, 64, 64}), ScalarType::kUInt8, bytes_of(samples));
  EXPECT_EQ(lattice.resident_bytes(), samples.size() + samples.size() / 32);
  std::vector<float> holed(64 * 64 * 64, 1.0F);
  holed[0] = std::numeric_limits<float>::quiet_NaN();
  const ResidentLattice with_hole(lattice_of({64, 64, 64}), ScalarType::kFloat32, bytes_of(holed));
  EXPECT_LT(with_hole.resident_bytes(), holed.size() * sizeof(float) * 104 / 100);
}

TEST(ResidentLattice, RefusesWhatItCannotShow) {
  const std::vector<float> samples(64, 1.0F);
  const LatticeGeometry geometry = lattice_of({4, 4, 4});
  const auto refusal = [&](ScalarType type, Bytes bytes, const ResidentLatticeOptions& options) {
    try {
      const ResidentLattice lattice(geometry, type, std::move(bytes), options);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const Bytes good = bytes_of(samples);
  EXPECT_EQ(refusal(ScalarType::kFloat32, good, {}), "accepted");
  EXPECT_TRUE(refusal(ScalarType::kInt32, good, {}).starts_with("type = int32"));
  EXPECT_TRUE(refusal(ScalarType::kUInt8, good, {}).starts_with("samples: 256 bytes, must be 64"));
  const std::vector<float> longer(65, 1.0F);
  const Bytes misaligned = {nullptr, std::as_bytes(std::span(longer)).subspan(1, 256)};
  EXPECT_TRUE(
      refusal(ScalarType::kFloat32, misaligned, {}).starts_with("samples: must be aligned"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refusal(ScalarType::kFloat32, good, {-1.0}).starts_with("range_reach = -1"));
  EXPECT_TRUE(refusal(ScalarType::kFloat32, good, {nan}).starts_with("range_reach = nan"));
  EXPECT_TRUE(refusal(ScalarType::kFloat32, good, {2.0, 0.0}).starts_with("value_scale = 0"));
  EXPECT_TRUE(refusal(ScalarType::kFloat32, good, {2.0, 1.0, nan}).starts_with("value_offset"));
}

TEST(LatticeField, TakesTheRangeOfItsSamples) {
  const std::vector<std::int16_t> samples = ramp(20);
  LatticeGeometry geometry = lattice_of({20, 1, 1});
  geometry.world_from_index = Eigen::Scaling(2.0, 0.5, 3.0);
  const auto source =
      std::make_shared<ResidentLattice>(geometry, ScalarType::kInt16, bytes_of(samples));
  const LatticeField field(source, {}, Reconstruction::kNormalized);
  EXPECT_EQ(field.value_range().lo, 0);
  EXPECT_EQ(field.value_range().hi, 19);
  EXPECT_EQ(field.num_kernels(), 20);
  EXPECT_EQ(field.default_sampling_distance(), 0.5);
  const LatticeField told(source, {}, Reconstruction::kSum, {-1, 1});
  EXPECT_EQ(told.value_range().hi, 1);
}

// Back ends keep what they made of a field under its identity.
TEST(LatticeField, CopiesShareTheIdentityOthersDoNot) {
  const std::vector<std::int16_t> samples = ramp(20);
  const auto source = std::make_shared<ResidentLattice>(lattice_of({20, 1, 1}), ScalarType::kInt16,
                                                        bytes_of(samples));
  const LatticeField one(source, {}, Reconstruction::kNormalized);
  const LatticeField two(source, {}, Reconstruction::kNormalized);
  const LatticeField copy = one;
  EXPECT_NE(one.id(), two.id());
  EXPECT_NE(one.id(), LatticeField().id());
  EXPECT_EQ(one.id(), copy.id());
  EXPECT_EQ(one.version(), copy.version());
}

TEST(LatticeField, RefusesNoSourceAndKernelsOutOfRange) {
  EXPECT_THROW(LatticeField(nullptr, {}, Reconstruction::kSum), Error);
  const std::vector<std::int16_t> samples = ramp(1);
  const auto source = std::make_shared<ResidentLattice>(lattice_of({1, 1, 1}), ScalarType::kInt16,
                                                        bytes_of(samples));
  EXPECT_THROW(LatticeField(source, {0.0, 4.0}, Reconstruction::kSum), Error);
}

}  // namespace resident_lattice_test
}  // namespace ovoid
