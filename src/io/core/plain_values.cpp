// SPDX-License-Identifier: Apache-2.0
#include "io/core/plain_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "data/scalar_visit.h"
#include "io/core/samples.h"

namespace ovoid::io {
namespace {

struct Span {
  double lo = std::numeric_limits<double>::infinity();
  double hi = -std::numeric_limits<double>::infinity();
};

Span value_span(const DataArray& array, std::int64_t count) {
  return data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    Span span;
    for (std::int64_t i = 0; i < count; ++i) {
      const double value = static_cast<double>(data::load_scalar<T>(array.bytes.view.data(), i)) *
                               array.value_scale +
                           array.value_offset;
      span.lo = std::min(span.lo, value);
      span.hi = std::max(span.hi, value);
    }
    return span;
  });
}

bool holds(ScalarType type, const Span& span) {
  return data::visit_scalar(type, [&]<class T>(std::type_identity<T>) {
    return span.lo >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
           span.hi <= static_cast<double>(std::numeric_limits<T>::max());
  });
}

bool is_integer(double x) { return std::floor(x) == x && std::abs(x) < 0x1p53; }

// Doubles hold every integer of these exactly.
constexpr std::array kIntegers = {ScalarType::kUInt8,  ScalarType::kInt8,  ScalarType::kInt16,
                                  ScalarType::kUInt16, ScalarType::kInt32, ScalarType::kUInt32};

ScalarType plain_type(const DataArray& array, std::int64_t count) {
  const std::size_t stored_size = size_of(array.type);
  const bool is_exact = !is_floating(array.type) && stored_size <= 4 &&
                        is_integer(array.value_scale) && is_integer(array.value_offset);
  if (is_exact) {
    const Span span = value_span(array, count);
    for (const ScalarType type : kIntegers) {
      if (size_of(type) >= stored_size && holds(type, span)) return type;
    }
  }
  const bool is_small = stored_size <= 2 || array.type == ScalarType::kFloat32;
  return is_small ? ScalarType::kFloat32 : ScalarType::kFloat64;
}

}  // namespace

DataArray plain_values(const DataArray& array) {
  if (!array.is_scaled()) return array;
  const auto count = static_cast<std::int64_t>(array.bytes.view.size() / size_of(array.type));
  DataArray plain = array;
  plain.type = plain_type(array, count);
  plain.value_scale = 1.0;
  plain.value_offset = 0.0;
  SampleBuffer buffer;
  const std::int64_t num_bytes = count * static_cast<std::int64_t>(size_of(plain.type));
  std::byte* const to = buffer.extend(num_bytes, num_bytes).data();
  data::visit_scalar(array.type, [&]<class From>(std::type_identity<From>) {
    data::visit_scalar(plain.type, [&]<class To>(std::type_identity<To>) {
      for (std::int64_t i = 0; i < count; ++i) {
        const auto value = static_cast<To>(
            static_cast<double>(data::load_scalar<From>(array.bytes.view.data(), i)) *
                array.value_scale +
            array.value_offset);
        std::memcpy(to + static_cast<std::size_t>(i) * sizeof(To), &value, sizeof(To));
      }
    });
  });
  plain.bytes = buffer.release();
  return plain;
}

}  // namespace ovoid::io
