// SPDX-License-Identifier: Apache-2.0
#include "io/hdf5/short_numbers.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "data/scalar_visit.h"
#include "io/hdf5/hdf5_lattice_format.h"
#include "io/hdf5/hdf5_writer.h"

namespace ovoid::io {
namespace {

ScalarType shortest_type(std::int64_t least, std::int64_t greatest) {
  constexpr std::array kTypes = {ScalarType::kUInt8, ScalarType::kInt8,   ScalarType::kUInt16,
                                 ScalarType::kInt16, ScalarType::kUInt32, ScalarType::kInt32};
  for (const ScalarType type : kTypes) {
    const bool holds = data::visit_scalar(type, [&]<class T>(std::type_identity<T>) {
      return static_cast<double>(least) >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
             static_cast<double>(greatest) <= static_cast<double>(std::numeric_limits<T>::max());
    });
    if (holds) return type;
  }
  return ScalarType::kInt64;
}

}  // namespace

ShortNumbers::ShortNumbers(const std::vector<std::int64_t>& numbers) {
  if (numbers.empty()) return;
  const auto [least, greatest] = std::minmax_element(numbers.begin(), numbers.end());
  type = shortest_type(*least, *greatest);
  bytes.resize(numbers.size() * size_of(type));
  data::visit_scalar(type, [&]<class T>(std::type_identity<T>) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const auto number = static_cast<T>(numbers[i]);
      std::memcpy(bytes.data() + i * sizeof(T), &number, sizeof(T));
    }
  });
}

std::int64_t packed_bytes(const ShortNumbers& numbers) {
  // Of a dataset's description, and of a chunk's place and checksum.
  constexpr std::int64_t kOfDataset = 300, kOfChunk = 64;
  const std::size_t size = size_of(numbers.type);
  std::int64_t sum = kOfDataset;
  std::vector<Bytef> shuffled, packed;
  for (std::size_t at = 0; at < numbers.bytes.size(); at += static_cast<std::size_t>(kChunkBytes)) {
    const std::size_t count =
        std::min(numbers.bytes.size() - at, static_cast<std::size_t>(kChunkBytes)) / size;
    shuffled.clear();
    for (std::size_t b = 0; b < size; ++b) {
      for (std::size_t i = 0; i < count; ++i)
        shuffled.push_back(static_cast<Bytef>(numbers.bytes[at + i * size + b]));
    }
    packed.resize(compressBound(static_cast<uLong>(shuffled.size())));
    auto length = static_cast<uLongf>(packed.size());
    compress2(packed.data(), &length, shuffled.data(), static_cast<uLong>(shuffled.size()),
              kDeflateLevel);
    sum += static_cast<std::int64_t>(length) + kOfChunk;
  }
  return sum;
}

}  // namespace ovoid::io
