// SPDX-License-Identifier: Apache-2.0
#include "io/hdf5/stored_level.h"

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

#include "data/scalar_visit.h"
#include "io/hdf5/hdf5_lattice_format.h"
#include "io/hdf5/hdf5_writer.h"
#include "ovoid/lattice_file.h"

namespace ovoid {
namespace io {
namespace {

template <class T>
bool holds(std::int64_t least, std::int64_t greatest) {
  return least >= std::numeric_limits<T>::min() && greatest <= std::numeric_limits<T>::max();
}

template <class Number>
std::vector<std::byte> stored_as(ScalarType type, const std::vector<Number>& numbers) {
  std::vector<std::byte> bytes(numbers.size() * size_of(type));
  data::visit_scalar(type, [&]<class T>(std::type_identity<T>) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const auto number = static_cast<T>(numbers[i]);
      std::memcpy(bytes.data() + i * sizeof(T), &number, sizeof(T));
    }
  });
  return bytes;
}

}  // namespace

StoredLevel::StoredLevel(const LatticeLevel& level) {
  std::vector<std::uint32_t> between;
  std::int64_t before = -1, most = 0;
  for (const std::int64_t node : level.nodes) {
    between.push_back(static_cast<std::uint32_t>(node - before - 1));
    most = std::max(most, node - before - 1);
    before = node;
  }
  gap_type = holds<std::uint8_t>(0, most)    ? ScalarType::kUInt8
             : holds<std::uint16_t>(0, most) ? ScalarType::kUInt16
                                             : ScalarType::kUInt32;
  gaps = stored_as(gap_type, between);
  if (level.weights.empty()) return;
  const auto [lo, hi] = std::minmax_element(level.weights.begin(), level.weights.end());
  weight_type = holds<std::int8_t>(*lo, *hi)    ? ScalarType::kInt8
                : holds<std::int16_t>(*lo, *hi) ? ScalarType::kInt16
                                                : ScalarType::kInt32;
  weights = stored_as(weight_type, level.weights);
}

namespace {

// Shuffled and deflated as the library does, chunk by chunk.
std::int64_t packed_bytes(const std::vector<std::byte>& values, std::size_t size) {
  // Of a dataset's description, and of a chunk's place and checksum.
  constexpr std::int64_t kOfDataset = 300, kOfChunk = 64;
  std::int64_t sum = kOfDataset;
  std::vector<Bytef> shuffled, packed;
  for (std::size_t at = 0; at < values.size(); at += static_cast<std::size_t>(kChunkBytes)) {
    const std::size_t count =
        std::min(values.size() - at, static_cast<std::size_t>(kChunkBytes)) / size;
    shuffled.clear();
    for (std::size_t b = 0; b < size; ++b) {
      for (std::size_t i = 0; i < count; ++i)
        shuffled.push_back(static_cast<Bytef>(values[at + i * size + b]));
    }
    packed.resize(compressBound(static_cast<uLong>(shuffled.size())));
    auto length = static_cast<uLongf>(packed.size());
    compress2(packed.data(), &length, shuffled.data(), static_cast<uLong>(shuffled.size()),
              kDeflateLevel);
    sum += static_cast<std::int64_t>(length) + kOfChunk;
  }
  return sum;
}

}  // namespace
}  // namespace io

std::int64_t lattice_levels_bytes(const LatticeLevels& levels) {
  constexpr std::int64_t kOfFile = 6144;  // of groups and attributes, in blocks of 2 KiB
  std::int64_t sum = kOfFile;
  for (const LatticeLevel& level : levels.levels) {
    if (level.nodes.empty()) continue;
    const io::StoredLevel stored(level);
    sum += io::packed_bytes(stored.gaps, size_of(stored.gap_type)) +
           io::packed_bytes(stored.weights, size_of(stored.weight_type));
  }
  return sum;
}

}  // namespace ovoid
