// SPDX-License-Identifier: Apache-2.0
#include "io/core/short_floats.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "io/images/test_volumes.h"

namespace ovoid::io {
namespace short_floats_test {

// By the definition of IEEE 754, slowly.
double half_by_definition(unsigned bits) {
  const int exponent = static_cast<int>(bits >> 10U & 31U);
  const double fraction = (bits & 1023U) / 1024.0;
  const double size =
      exponent == 0 ? std::ldexp(fraction, -14) : std::ldexp(1 + fraction, exponent - 15);
  return (bits & 0x8000U) != 0 ? -size : size;
}

// All that there are.
TEST(ShortFloats, HalvesAreTheirNumbers) {
  for (unsigned bits = 0; bits < 65536; ++bits) {
    const auto half = static_cast<std::uint16_t>(bits);
    const float value = float_of(half, ShortFloat::kHalf);
    ASSERT_EQ(std::signbit(value), (bits & 0x8000U) != 0) << bits;
    if ((bits & 0x7c00U) != 0x7c00U) {
      ASSERT_EQ(value, half_by_definition(bits)) << bits;
      ASSERT_EQ(bits_of(value, ShortFloat::kHalf), half) << bits;
    } else {
      ASSERT_EQ(std::isinf(value), (bits & 1023U) == 0) << bits;
      ASSERT_EQ(std::isnan(value), (bits & 1023U) != 0) << bits;
    }
  }
}

TEST(ShortFloats, OthersAreRounded) {
  const auto half = [](float value) { return bits_of(value, ShortFloat::kHalf); };
  EXPECT_EQ(half(1 + 0x1p-11F), half(1.0F)) << "half-way, to even";
  EXPECT_EQ(half(1 + 3 * 0x1p-11F), half(1 + 0x1p-9F));
  EXPECT_EQ(half(65519.0F), 0x7bff);
  EXPECT_EQ(half(65520.0F), 0x7c00);
  EXPECT_EQ(half(-1e30F), 0xfc00);
  EXPECT_EQ(half(0x1p-24F), 1);
  EXPECT_EQ(half(0x1p-26F), 0);
  EXPECT_EQ(half(2047.9F * 0x1p-25F), 0x400) << "the greatest subnormal's neighbour";
  EXPECT_EQ(half(std::numeric_limits<float>::quiet_NaN()), 0x7e00);
  const auto brain = [](float value) { return bits_of(value, ShortFloat::kBrain); };
  EXPECT_EQ(brain(1.0F), 0x3f80);
  EXPECT_EQ(brain(1 + 0x1p-8F), 0x3f80);
  EXPECT_EQ(brain(1 + 3 * 0x1p-8F), 0x3f82);
  EXPECT_EQ(float_of(0xc0a0, ShortFloat::kBrain), -5.0F);
  EXPECT_TRUE(std::isnan(float_of(brain(std::nanf("")), ShortFloat::kBrain)));
}

class InMemory final : public StoredSamples {
 public:
  explicit InMemory(std::vector<std::uint16_t> bits) : bits_(std::move(bits)) {}
  std::int64_t num_bytes() const noexcept override { return std::ssize(bits_) * 2; }
  std::int64_t memory_for_pages() const noexcept override { return 7; }
  void read(std::int64_t offset, std::span<std::byte> out) const override {
    const auto all = std::as_bytes(std::span(bits_));
    std::copy_n(all.begin() + offset, out.size(), out.begin());
  }

 private:
  std::vector<std::uint16_t> bits_;
};

TEST(ShortFloats, ArraysBecomeFloat32) {
  const std::vector<std::uint16_t> bits{0x3c00, 0xc000, 0x3800};
  DataArray array = make_array<std::uint16_t>("v", ScalarType::kUInt16, bits);
  widen_short_floats(ShortFloat::kNone, array);
  EXPECT_EQ(array.type, ScalarType::kUInt16);
  widen_short_floats(ShortFloat::kHalf, array);
  EXPECT_EQ(array.type, ScalarType::kFloat32);
  EXPECT_EQ(values_of<float>(array), (std::vector<float>{1, -2, 0.5F}));
  DataArray left = array;
  left.bytes = {};
  left.stored = std::make_shared<InMemory>(bits);
  widen_short_floats(ShortFloat::kHalf, left);
  EXPECT_EQ(left.stored->num_bytes(), 12);
  EXPECT_EQ(left.stored->memory_for_pages(), 7);
  std::vector<float> two(2);
  left.stored->read(4, std::as_writable_bytes(std::span(two)));
  EXPECT_EQ(two, (std::vector<float>{-2, 0.5F}));
}

}  // namespace short_floats_test
}  // namespace ovoid::io
