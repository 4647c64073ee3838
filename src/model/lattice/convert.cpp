// SPDX-License-Identifier: Apache-2.0
#include "model/lattice/convert.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "data/lattice/resident_lattice.h"
#include "data/parallel.h"
#include "data/scalar_visit.h"
#include "ovoid/error.h"
#include "ovoid/model.h"

namespace ovoid::model {

namespace {

// Tuples per task: large enough that handing them out costs nothing, small enough to stop soon.
constexpr std::int64_t kGrain = std::int64_t{1} << 18;

// Rounded to the nearest float; what float32 cannot hold is missing, as NaN and infinities are.
template <class T>
float to_float(T value) noexcept {
  if constexpr (std::is_same_v<T, double>) {
    if (!(std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max()))) {
      return std::numeric_limits<float>::quiet_NaN();
    }
  }
  return static_cast<float>(value);
}

// What a stored number of the array stands for.
template <class T>
auto value_of(const DataArray& array, T stored) noexcept {
  return static_cast<double>(stored) * array.value_scale + array.value_offset;
}

// In double: squares of what float32 can hold neither overflow nor vanish there.
template <class T>
float magnitude(const DataArray& array, std::int64_t tuple) noexcept {
  double sum = 0;
  for (int c = 0; c < array.num_components; ++c) {
    const double value = value_of(
        array, data::load_scalar<T>(array.bytes.view.data(), tuple * array.num_components + c));
    sum += value * value;
  }
  return to_float(std::sqrt(sum));
}

// to[i] = one scalar of tuple i, begin <= i < end.
template <class From, class To>
void take(const DataArray& array, int component, std::int64_t begin, std::int64_t end, To* to) {
  const std::byte* bytes = array.bytes.view.data();
  const int components = array.num_components;
  if constexpr (std::is_same_v<From, To> && !std::is_same_v<To, float>) {
    for (std::int64_t i = begin; i < end; ++i) {
      to[i] = data::load_scalar<From>(bytes, i * components + component);
    }
  } else if (component == LatticeModelOptions::kMagnitude) {
    for (std::int64_t i = begin; i < end; ++i) {
      to[i] = static_cast<To>(magnitude<From>(array, i));
    }
  } else if (array.is_scaled()) {
    for (std::int64_t i = begin; i < end; ++i) {
      to[i] = static_cast<To>(
          to_float(value_of(array, data::load_scalar<From>(bytes, i * components + component))));
    }
  } else {
    for (std::int64_t i = begin; i < end; ++i) {
      to[i] = static_cast<To>(to_float(data::load_scalar<From>(bytes, i * components + component)));
    }
  }
}

// A new array of To for all tuples.
template <class From, class To>
std::shared_ptr<To[]> taken(const DataArray& array, const ComponentOptions& options) {
  auto to = std::make_shared_for_overwrite<To[]>(static_cast<std::size_t>(array.num_tuples));
  data::parallel_ranges({array.num_tuples, kGrain, options.threads, options.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          take<From>(array, options.component, begin, end, to.get());
                        });
  return to;
}

template <class To>
Bytes bytes_of(std::shared_ptr<To[]> samples, std::int64_t count) {
  const std::span<const To> view(samples.get(), static_cast<std::size_t>(count));
  return {std::move(samples), std::as_bytes(view)};
}

bool is_aligned(const DataArray& array) {
  return reinterpret_cast<std::uintptr_t>(array.bytes.view.data()) % size_of(array.type) == 0;
}

}  // namespace

ScalarSamples take_component(const DataArray& array, const ComponentOptions& options) {
  const bool is_magnitude = options.component == LatticeModelOptions::kMagnitude;
  if (!is_magnitude && (options.component < 0 || options.component >= array.num_components)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("component = {}: array '{}' has components 0 to {} and their magnitude",
                            options.component, array.name, array.num_components - 1));
  }
  const bool keep_type = ResidentLattice::can_show(array.type) && !is_magnitude &&
                         !options.as_float32 &&
                         !(array.is_scaled() && array.type == ScalarType::kFloat32);
  if (keep_type && array.num_components == 1 && is_aligned(array)) {
    return {array.type, array.bytes, nullptr, array.value_scale, array.value_offset};
  }
  return data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) -> ScalarSamples {
    if constexpr (std::is_integral_v<T> && sizeof(T) <= 2) {
      if (keep_type) {
        return {array.type, bytes_of(taken<T, T>(array, options), array.num_tuples), nullptr,
                array.value_scale, array.value_offset};
      }
    }
    std::shared_ptr<float[]> samples = taken<T, float>(array, options);
    float* writable = samples.get();
    return {ScalarType::kFloat32, bytes_of(std::move(samples), array.num_tuples), writable, 1.0,
            0.0};
  });
}

}  // namespace ovoid::model
