// SPDX-License-Identifier: Apache-2.0
// What every reader of a regular volume needs: sizes that cannot overflow, memory that grows with
// what was really read, progress, and the words for messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// No axis is longer than this; it keeps products of an axis and a sample's size far from overflow.
inline constexpr std::int64_t kMaxAxisSize = (std::int64_t{1} << 31) - 1;

// Nor is any volume or any offset in a file; sums of a few of these cannot overflow.
inline constexpr std::int64_t kMaxNumBytes = std::int64_t{1} << 60;

// "64x64x93", and "64x64x93 int16" or "64x64x93 int16 x 3" for messages.
std::string dims_text(std::span<const std::int64_t> sizes);
std::string layout_text(std::span<const std::int64_t> sizes, ScalarType type,
                        int num_components = 1);

// The first bytes of a source from `offset` as hexadecimal: "1f 8b".
std::string first_bytes_text(const ByteSource& source, std::int64_t offset);

// The product of all factors; empty if one is negative or the product exceeds the range of int64.
std::optional<std::int64_t> checked_product(std::span<const std::int64_t> factors) noexcept;

// Bytes of an array. `where` names file and field for the message. Throws Error(kFileFormat) unless
// every size is in [1, kMaxAxisSize] and the product is at most kMaxNumBytes.
std::int64_t checked_num_bytes(const std::string& where, std::span<const std::int64_t> sizes,
                               ScalarType type, int num_components = 1);

// Throws Error(kFileFormat) naming `where` unless the axes are finite and span space
// (data::kMinRelativeVolume).
void check_geometry(const std::string& where, const Affine3& world_from_index);

// The slice of a 2-D file gets a third axis: normal to it, as long as the shorter of its own two.
void complete_plane(Mat3& axes);

// Memory for samples that grows in place, so that a reader holds what it has read and not what a
// header claims. Aligned for every scalar type.
class SampleBuffer {
 public:
  SampleBuffer() = default;
  ~SampleBuffer();
  SampleBuffer(SampleBuffer&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)),
        size_(std::exchange(other.size_, 0)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  SampleBuffer(const SampleBuffer&) = delete;
  SampleBuffer& operator=(const SampleBuffer&) = delete;

  std::int64_t size() const noexcept { return size_; }
  std::span<std::byte> bytes() noexcept { return {data_, static_cast<std::size_t>(size_)}; }

  // Makes room for `size` bytes in all, at once; size() stays. Throws Error(kOutOfMemory).
  void reserve(std::int64_t size);
  // Adds uninitialised bytes behind the present ones and returns them. Memory at least doubles, but
  // never passes `expected_size` until more is really needed. Throws Error(kOutOfMemory).
  std::span<std::byte> extend(std::int64_t count, std::int64_t expected_size);
  // Takes back the last `count` bytes.
  void shrink(std::int64_t count) noexcept { size_ -= count; }

  // The bytes as a dataset keeps them; the buffer is empty afterwards.
  Bytes release();

 private:
  std::byte* data_ = nullptr;
  std::int64_t size_ = 0;
  std::int64_t capacity_ = 0;
};

// Tells the caller how far a read is, and stops it.
class ReadProgress {
 public:
  // `total`: bytes of the files (not of the decoded data) that will be read.
  ReadProgress(const ReadOptions& options, std::int64_t total) : options_(options), total_(total) {}

  // Bytes that a reader should process between two calls of advance(): about 10 ms of work.
  static constexpr std::int64_t kChunk = std::int64_t{4} << 20;

  // Throws Error(kCancelled) when the caller asked to stop.
  void advance(std::int64_t count);

 private:
  const ReadOptions& options_;
  std::int64_t total_;
  std::int64_t done_ = 0;
};

// Appends `count` bytes of the source from `offset` to the buffer. The caller has checked that they
// exist.
void append_plain(const ByteSource& source, std::int64_t offset, std::int64_t count,
                  SampleBuffer& out, ReadProgress& progress);

// Keeps a list of notes readable: the first ten, and how many more there are.
void shorten_notes(std::vector<std::string>& notes);

// Reverses the bytes of every `sample_size`-byte sample.
void swap_bytes(std::span<std::byte> bytes, std::size_t sample_size) noexcept;

// [rows, columns] -> [columns, rows] for items of `item_size` bytes; the two must not overlap.
// Works on square blocks, so that reads and writes both stay in the cache.
void transpose_items(const std::byte* from, std::byte* to, std::int64_t rows, std::int64_t columns,
                     std::size_t item_size) noexcept;

}  // namespace ovoid::io
