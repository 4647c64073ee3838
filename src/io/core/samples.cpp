// SPDX-License-Identifier: Apache-2.0
#include "io/core/samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <utility>

#include "data/validate.h"
#include "io/core/numbers.h"
#include "io/core/work_done.h"
#include "ovoid/error.h"

namespace ovoid {

std::optional<ScalarType> find_scalar_type(const std::string& name) noexcept {
  static constexpr std::pair<const char*, ScalarType> kNames[] = {
      {"uint8", ScalarType::kUInt8},     {"uchar", ScalarType::kUInt8},
      {"u1", ScalarType::kUInt8},        {"int8", ScalarType::kInt8},
      {"schar", ScalarType::kInt8},      {"i1", ScalarType::kInt8},
      {"uint16", ScalarType::kUInt16},   {"ushort", ScalarType::kUInt16},
      {"u2", ScalarType::kUInt16},       {"int16", ScalarType::kInt16},
      {"short", ScalarType::kInt16},     {"i2", ScalarType::kInt16},
      {"uint32", ScalarType::kUInt32},   {"uint", ScalarType::kUInt32},
      {"u4", ScalarType::kUInt32},       {"int32", ScalarType::kInt32},
      {"int", ScalarType::kInt32},       {"i4", ScalarType::kInt32},
      {"uint64", ScalarType::kUInt64},   {"ulonglong", ScalarType::kUInt64},
      {"u8", ScalarType::kUInt64},       {"int64", ScalarType::kInt64},
      {"longlong", ScalarType::kInt64},  {"i8", ScalarType::kInt64},
      {"float32", ScalarType::kFloat32}, {"float", ScalarType::kFloat32},
      {"f4", ScalarType::kFloat32},      {"float64", ScalarType::kFloat64},
      {"double", ScalarType::kFloat64},  {"f8", ScalarType::kFloat64},
  };
  for (const auto& [known, type] : kNames) {
    if (name == known) return type;
  }
  return std::nullopt;
}

namespace io {

std::string dims_text(std::span<const std::int64_t> sizes) {
  return fmt::format("{}", fmt::join(sizes, "x"));
}

std::string layout_text(std::span<const std::int64_t> sizes, ScalarType type, int num_components) {
  const std::string text = fmt::format("{} {}", dims_text(sizes), name_of(type));
  return num_components == 1 ? text : fmt::format("{} x {}", text, num_components);
}

std::string first_bytes_text(const ByteSource& source, std::int64_t offset) {
  std::string result;
  for (const char c : source.text(offset, 2)) {
    result += fmt::format("{}{:02x}", result.empty() ? "" : " ", static_cast<unsigned char>(c));
  }
  return result;
}

std::optional<std::int64_t> checked_product(std::span<const std::int64_t> factors) noexcept {
  std::int64_t product = 1;
  for (const std::int64_t factor : factors) {
    if (factor < 0 || __builtin_mul_overflow(product, factor, &product)) return std::nullopt;
  }
  return product;
}

std::int64_t checked_num_bytes(const std::string& where, std::span<const std::int64_t> sizes,
                               ScalarType type, int num_components) {
  for (const std::int64_t size : sizes) {
    if (size < 1 || size > kMaxAxisSize) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: {} has an axis of {} samples: expected 1 to {}", where,
                              dims_text(sizes), size, kMaxAxisSize));
    }
  }
  const auto num_tuples = checked_product(sizes);
  const std::array<std::int64_t, 3> factors{
      num_tuples.value_or(-1), static_cast<std::int64_t>(size_of(type)), num_components};
  const auto num_bytes = checked_product(factors);
  if (!num_bytes || *num_bytes > kMaxNumBytes) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: {} is larger than any file", where,
                                                    layout_text(sizes, type, num_components)));
  }
  return *num_bytes;
}

void check_geometry(const std::string& where, const Affine3& world_from_index) {
  Mat3 axes = world_from_index.linear();
  if (!axes.allFinite() || !world_from_index.translation().allFinite()) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: is not finite", where));
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double length = axes.col(axis).stableNorm();
    // Below or above this a volume element no longer is a normal double.
    if (!(length >= 1e-90 && length <= 1e90)) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: the samples of axis {} are {} apart: expected 1e-90 to 1e90",
                              where, "xyz"[axis], length));
    }
    axes.col(axis) /= length;
  }
  if (!(std::abs(axes.determinant()) >= data::kMinRelativeVolume)) {
    throw Error(
        ErrorCode::kFileFormat,
        fmt::format("{}: the axes lie in one plane: expected three independent directions", where));
  }
}

void complete_plane(Mat3& axes) {
  const Vec3 normal = axes.col(0).stableNormalized().cross(axes.col(1).stableNormalized());
  axes.col(2) = normal * std::min(axes.col(0).stableNorm(), axes.col(1).stableNorm());
}

SampleBuffer::~SampleBuffer() { std::free(data_); }

void SampleBuffer::reserve(std::int64_t size) {
  if (size <= capacity_) return;
  // realloc moves pages of large blocks instead of copying them, so growing does not need both
  // blocks at once.
  void* grown = std::realloc(data_, static_cast<std::size_t>(size));
  if (grown == nullptr) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("memory for {} bytes of samples: the system has none left", size));
  }
  data_ = static_cast<std::byte*>(grown);
  capacity_ = size;
}

std::span<std::byte> SampleBuffer::extend(std::int64_t count, std::int64_t expected_size) {
  const std::int64_t needed = size_ + count;
  if (needed > capacity_) {
    constexpr std::int64_t kFirst = std::int64_t{1} << 20;
    const std::int64_t wanted = std::max(kFirst, 2 * capacity_);
    reserve(std::max(needed, std::min(wanted, expected_size)));
  }
  const std::span<std::byte> added(data_ + size_, static_cast<std::size_t>(count));
  size_ = needed;
  return added;
}

Bytes SampleBuffer::release() {
  Bytes result;
  result.view = bytes();
  size_ = capacity_ = 0;
  result.owner = std::shared_ptr<const void>(
      std::exchange(data_, nullptr), [](const void* data) { std::free(const_cast<void*>(data)); });
  return result;
}

void ReadProgress::advance(std::int64_t count) {
  if (options_.stop.stop_requested())
    throw Error(ErrorCode::kCancelled, "reading: stopped by the caller");
  add_work_done(count);
  done_ = std::min(done_ + count, total_);
  if (options_.progress && total_ > 0)
    options_.progress(static_cast<double>(done_) / static_cast<double>(total_));
}

void append_plain(const ByteSource& source, std::int64_t offset, std::int64_t count,
                  SampleBuffer& out, ReadProgress& progress) {
  out.reserve(out.size() + count);
  while (count > 0) {
    const std::int64_t chunk = std::min(count, ReadProgress::kChunk);
    source.read(offset, out.extend(chunk, 0));
    progress.advance(chunk);
    offset += chunk;
    count -= chunk;
  }
}

void shorten_notes(std::vector<std::string>& notes) {
  constexpr std::size_t kKept = 10;
  if (notes.size() <= kKept) return;
  const std::size_t num_dropped = notes.size() - kKept;
  notes.resize(kKept);
  notes.push_back(fmt::format("and {} more notes of this kind", num_dropped));
}

namespace {

template <typename Word>
void swap_words(std::span<std::byte> bytes) noexcept {
  for (std::size_t i = 0; i + sizeof(Word) <= bytes.size(); i += sizeof(Word)) {
    Word word;
    std::memcpy(&word, bytes.data() + i, sizeof(Word));
    word = swapped(word);
    std::memcpy(bytes.data() + i, &word, sizeof(Word));
  }
}

}  // namespace

void swap_bytes(std::span<std::byte> bytes, std::size_t sample_size) noexcept {
  if (sample_size == 2) swap_words<std::uint16_t>(bytes);
  if (sample_size == 4) swap_words<std::uint32_t>(bytes);
  if (sample_size == 8) swap_words<std::uint64_t>(bytes);
}

void transpose_items(const std::byte* from, std::byte* to, std::int64_t rows, std::int64_t columns,
                     std::size_t item_size) noexcept {
  constexpr std::int64_t kBlock = 32;
  for (std::int64_t row0 = 0; row0 < rows; row0 += kBlock) {
    for (std::int64_t column0 = 0; column0 < columns; column0 += kBlock) {
      for (std::int64_t row = row0; row < std::min(rows, row0 + kBlock); ++row) {
        for (std::int64_t column = column0; column < std::min(columns, column0 + kBlock);
             ++column) {
          std::memcpy(to + static_cast<std::size_t>(column * rows + row) * item_size,
                      from + static_cast<std::size_t>(row * columns + column) * item_size,
                      item_size);
        }
      }
    }
  }
}

}  // namespace io
}  // namespace ovoid
