// SPDX-License-Identifier: Apache-2.0
#include "io/core/short_floats.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "io/core/samples.h"

namespace ovoid::io {
namespace {

constexpr std::uint32_t kSign = 0x8000;

// Shifted into a float32 the exponent is too small by the difference of the biases, 127 - 15: a
// factor of 2^112 makes up for it, also where the half is subnormal. Infinity and NaN have the
// greatest exponent of both.
float float_of_half(std::uint16_t bits) noexcept {
  const std::uint32_t sign = (bits & kSign) << 16U, rest = bits & ~kSign;
  if (rest >= 0x7c00U) return std::bit_cast<float>(sign | 0x7f800000U | (rest & 0x3ffU) << 13U);
  const float value = std::bit_cast<float>(rest << 13U) * 0x1p112F;
  return std::bit_cast<float>(sign | std::bit_cast<std::uint32_t>(value));
}

std::uint16_t bits_of_half(float value) noexcept {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const auto sign = static_cast<std::uint16_t>(bits >> 16U & kSign);
  if (std::isnan(value)) return sign | 0x7e00U;
  const double size = std::abs(static_cast<double>(value));
  if (size >= 65520)
    return sign | 0x7c00U;  // half-way from the greatest to the next, which is even
  const int exponent = std::max(size > 0 ? std::ilogb(size) : -14, -14);
  const double steps = std::nearbyint(std::ldexp(size, 10 - exponent));  // 0 to 2048
  return static_cast<std::uint16_t>(sign + ((exponent + 14) << 10) + static_cast<int>(steps));
}

// Those that stay in their file, widened when they are read.
class WidenedSamples final : public StoredSamples {
 public:
  WidenedSamples(ShortFloat kind, std::shared_ptr<const StoredSamples> bits)
      : kind_(kind), bits_(std::move(bits)) {}

  std::int64_t num_bytes() const noexcept override { return 2 * bits_->num_bytes(); }
  std::int64_t memory_for_pages() const noexcept override { return bits_->memory_for_pages(); }
  void read(std::int64_t offset, std::span<std::byte> out) const override {
    std::vector<std::byte> bits(out.size() / 2);
    bits_->read(offset / 2, bits);
    widen(bits, kind_, out.data());
  }

 private:
  ShortFloat kind_;
  std::shared_ptr<const StoredSamples> bits_;
};

}  // namespace

const char* name_of(ShortFloat kind) noexcept {
  return kind == ShortFloat::kHalf ? "float16" : kind == ShortFloat::kBrain ? "bfloat16" : "";
}

const char* stored_name(ScalarType type, ShortFloat kind) noexcept {
  return kind == ShortFloat::kNone ? name_of(type) : name_of(kind);
}

float float_of(std::uint16_t bits, ShortFloat kind) noexcept {
  return kind == ShortFloat::kHalf ? float_of_half(bits)
                                   : std::bit_cast<float>(std::uint32_t{bits} << 16U);
}

std::uint16_t bits_of(float value, ShortFloat kind) noexcept {
  if (kind == ShortFloat::kHalf) return bits_of_half(value);
  const auto bits = std::bit_cast<std::uint32_t>(value);
  if (std::isnan(value)) return static_cast<std::uint16_t>(bits >> 16U | 0x40U);
  return static_cast<std::uint16_t>((bits + 0x7fffU + (bits >> 16U & 1U)) >> 16U);
}

void widen(std::span<const std::byte> bits, ShortFloat kind, std::byte* to) noexcept {
  for (std::size_t i = 0; i + 1 < bits.size(); i += 2) {
    std::uint16_t one = 0;
    std::memcpy(&one, bits.data() + i, 2);
    const float value = float_of(one, kind);
    std::memcpy(to + 2 * i, &value, sizeof(float));
  }
}

void widen_short_floats(ShortFloat kind, DataArray& array) {
  if (kind == ShortFloat::kNone) return;
  array.type = ScalarType::kFloat32;
  if (array.stored) {
    array.stored = std::make_shared<WidenedSamples>(kind, array.stored);
    return;
  }
  SampleBuffer buffer;
  const auto num_bytes = 2 * static_cast<std::int64_t>(array.bytes.view.size());
  widen(array.bytes.view, kind, buffer.extend(num_bytes, num_bytes).data());
  array.bytes = buffer.release();
}

}  // namespace ovoid::io
