// SPDX-License-Identifier: Apache-2.0
#include "io/core/point_arrays.h"

#include <cstring>
#include <type_traits>
#include <utility>

#include "data/scalar_visit.h"
#include "io/core/samples.h"

namespace ovoid::io {

DataArray new_array(DataArray description, std::byte*& to) {
  const std::int64_t num_bytes = description.num_tuples * description.num_components *
                                 static_cast<std::int64_t>(size_of(description.type));
  SampleBuffer buffer;
  to = buffer.extend(num_bytes, num_bytes).data();
  description.bytes = buffer.release();
  return description;
}

DataArray floating_values(const DataArray& array) {
  if (is_floating(array.type)) return array;
  DataArray description = array;
  description.type = ScalarType::kFloat64;
  std::byte* to = nullptr;
  DataArray result = new_array(std::move(description), to);
  data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    for (std::int64_t i = 0; i < array.num_tuples * array.num_components; ++i) {
      const auto value = static_cast<double>(data::load_scalar<T>(array.bytes.view.data(), i));
      std::memcpy(to + static_cast<std::size_t>(i) * sizeof(double), &value, sizeof(double));
    }
  });
  return result;
}

DataArray take_components(const DataArray& array, int first, int count) {
  DataArray description = array;
  description.num_components = count;
  std::byte* to = nullptr;
  DataArray result = new_array(std::move(description), to);
  const std::size_t item = size_of(array.type);
  const std::size_t from_stride = item * static_cast<std::size_t>(array.num_components);
  const std::size_t stride = item * static_cast<std::size_t>(count);
  const std::byte* from = array.bytes.view.data() + item * static_cast<std::size_t>(first);
  for (std::int64_t i = 0; i < array.num_tuples; ++i, from += from_stride, to += stride)
    std::memcpy(to, from, stride);
  return result;
}

}  // namespace ovoid::io
