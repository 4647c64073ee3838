// SPDX-License-Identifier: Apache-2.0
#include "array_facts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

namespace ovoid::cli {
namespace {

template <typename T>
void add_facts(std::span<const std::byte> bytes, ArrayFacts& facts) {
  const std::byte* at = bytes.data();
  for (std::size_t i = 0; i < bytes.size() / sizeof(T); ++i, at += sizeof(T)) {
    T stored;
    std::memcpy(&stored, at, sizeof(T));  // a file's bytes need not be aligned
    const auto value = static_cast<double>(stored);
    if (!std::isfinite(value)) {
      ++facts.num_missing;
      continue;
    }
    facts.lo = std::min(facts.lo, value);
    facts.hi = std::max(facts.hi, value);
  }
}

// Piece by piece where the numbers are in a file.
template <typename T>
ArrayFacts facts_of_samples(const DataArray& array) {
  ArrayFacts facts;
  if (array.stored == nullptr) {
    add_facts<T>(array.bytes.view, facts);
    return facts;
  }
  constexpr std::int64_t kPiece = std::int64_t{1} << 22;
  std::vector<std::byte> piece;
  for (std::int64_t at = 0; at < array.stored->num_bytes(); at += kPiece) {
    piece.resize(static_cast<std::size_t>(std::min(kPiece, array.stored->num_bytes() - at)));
    array.stored->read(at, piece);
    add_facts<T>(piece, facts);
  }
  return facts;
}

ArrayFacts stored_facts_of(const DataArray& array) {
  switch (array.type) {
    case ScalarType::kUInt8:
      return facts_of_samples<std::uint8_t>(array);
    case ScalarType::kInt8:
      return facts_of_samples<std::int8_t>(array);
    case ScalarType::kUInt16:
      return facts_of_samples<std::uint16_t>(array);
    case ScalarType::kInt16:
      return facts_of_samples<std::int16_t>(array);
    case ScalarType::kUInt32:
      return facts_of_samples<std::uint32_t>(array);
    case ScalarType::kInt32:
      return facts_of_samples<std::int32_t>(array);
    case ScalarType::kUInt64:
      return facts_of_samples<std::uint64_t>(array);
    case ScalarType::kInt64:
      return facts_of_samples<std::int64_t>(array);
    case ScalarType::kFloat32:
      return facts_of_samples<float>(array);
    case ScalarType::kFloat64:
      return facts_of_samples<double>(array);
  }
  return {};
}

}  // namespace

ArrayFacts facts_of(const DataArray& array) {
  ArrayFacts facts = stored_facts_of(array);
  if (!array.is_scaled() || facts.lo > facts.hi) return facts;
  facts.lo = facts.lo * array.value_scale + array.value_offset;
  facts.hi = facts.hi * array.value_scale + array.value_offset;
  if (facts.lo > facts.hi) std::swap(facts.lo, facts.hi);
  return facts;
}

}  // namespace ovoid::cli
