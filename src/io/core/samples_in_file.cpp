// SPDX-License-Identifier: Apache-2.0
#include "io/core/samples_in_file.h"

#include <algorithm>
#include <bit>

#include "io/core/memory.h"
#include "io/core/samples.h"

namespace ovoid::io {
namespace {

// Of what memory is left a field may take so much; a frame takes its own.
constexpr double kMostOfMemory = 0.9;

// Beside the samples a field by the default kernel has coefficients, one for each.
std::int64_t bytes_of_field(ScalarType type, std::int64_t num_bytes) {
  const auto sample = static_cast<std::int64_t>(size_of(type));
  return num_bytes + num_bytes / sample * (type == ScalarType::kFloat32 ? 4 : 2);
}

// What is kept of samples that stay in their file: a quarter of what is left, within reason.
constexpr std::int64_t kLeastPages = std::int64_t{8} << 20;
constexpr std::int64_t kMostPages = std::int64_t{4} << 30;

bool can_be_shown(ScalarType type) {
  return type == ScalarType::kUInt8 || type == ScalarType::kInt8 || type == ScalarType::kUInt16 ||
         type == ScalarType::kInt16 || type == ScalarType::kFloat32;
}

class SamplesInFile final : public StoredSamples {
 public:
  SamplesInFile(std::unique_ptr<ByteSource> source, std::int64_t offset, std::int64_t num_bytes,
                std::size_t sample_size, bool is_swapped)
      : source_(std::move(source)),
        offset_(offset),
        num_bytes_(num_bytes),
        sample_size_(sample_size),
        is_swapped_(is_swapped),
        memory_for_pages_(std::clamp(available_memory() / 4, kLeastPages, kMostPages)) {}

  std::int64_t num_bytes() const noexcept override { return num_bytes_; }
  std::int64_t memory_for_pages() const noexcept override { return memory_for_pages_; }
  void read(std::int64_t offset, std::span<std::byte> out) const override {
    source_->read(offset_ + offset, out);
    if (is_swapped_) swap_bytes(out, sample_size_);
  }

 private:
  std::unique_ptr<ByteSource> source_;
  std::int64_t offset_, num_bytes_;
  std::size_t sample_size_;
  bool is_swapped_;
  std::int64_t memory_for_pages_;
};

}  // namespace

bool stays_in_file(ScalarType type, std::int64_t num_bytes, const ReadOptions& options) {
  return options.may_stay_in_file && can_be_shown(type) &&
         static_cast<double>(bytes_of_field(type, num_bytes)) >
             kMostOfMemory * static_cast<double>(available_memory());
}

std::shared_ptr<const StoredSamples> samples_in_file(const ByteSource& source, std::int64_t offset,
                                                     std::int64_t num_bytes, ScalarType type,
                                                     bool is_big_endian) {
  const bool is_native_big = std::endian::native == std::endian::big;
  return std::make_shared<SamplesInFile>(open_file(source.name()), offset, num_bytes, size_of(type),
                                         size_of(type) > 1 && is_big_endian != is_native_big);
}

}  // namespace ovoid::io
