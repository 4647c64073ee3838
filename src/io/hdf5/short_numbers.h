// SPDX-License-Identifier: Apache-2.0
// Lists of whole numbers as a lattice file holds them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ovoid/lattice.h"

namespace ovoid::io {

// In the shortest type that holds all, native byte order: of no sign unless one is negative.
struct ShortNumbers {
  ShortNumbers() = default;
  explicit ShortNumbers(const std::vector<std::int64_t>& numbers);

  std::size_t count() const { return bytes.size() / size_of(type); }

  ScalarType type = ScalarType::kUInt8;
  std::vector<std::byte> bytes;
};

// Of such a list in a file, shuffled and deflated as the library does, chunk by chunk: never less
// than it takes.
std::int64_t packed_bytes(const ShortNumbers& numbers);

}  // namespace ovoid::io
