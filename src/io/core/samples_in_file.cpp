// SPDX-License-Identifier: Apache-2.0
#include "io/core/samples_in_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "io/core/memory.h"
#include "io/core/samples.h"
#include "io/core/unpack_chunks.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Of what memory is left a field may take so much; a frame takes its own.
constexpr double kMostOfMemory = 0.9;

// Beside the samples a field by the default kernel has coefficients, one for each.
std::int64_t bytes_of_field(ScalarType type, std::int64_t num_bytes) {
  const auto sample = static_cast<std::int64_t>(size_of(type));
  return num_bytes + num_bytes / sample * (type == ScalarType::kFloat32 ? 4 : 2);
}

// Of what is kept of samples that stay in their file.
constexpr std::int64_t kLeastPages = std::int64_t{8} << 20;
constexpr std::int64_t kMostPages = std::int64_t{4} << 30;

std::int64_t own_memory(const ReadOptions& options) {
  return available_memory() / std::max(options.processes_beside, 1);
}

bool can_be_shown(ScalarType type) {
  return type == ScalarType::kUInt8 || type == ScalarType::kInt8 || type == ScalarType::kUInt16 ||
         type == ScalarType::kInt16 || type == ScalarType::kFloat32;
}

void check(bool is_right, const ByteSource& source) {
  if (is_right) return;
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: the samples do not lie where it says", source.name()));
}

void check_place(const ByteSource& source, const StoredPlace& place) {
  const std::int64_t size = source.size();
  check(can_be_shown(place.type) && place.num_bytes > 0, source);
  if (!place.chunked) {
    check(place.offset >= 0 && place.num_bytes <= size && place.offset <= size - place.num_bytes,
          source);
    return;
  }
  const ChunkedStorage& chunked = *place.chunked;
  check(!chunked.dims.empty() && chunked.dims.size() == chunked.chunk.size(), source);
  double num_samples = 1, in_chunk = 1, num_chunks = 1;
  for (std::size_t a = 0; a < chunked.dims.size(); ++a) {
    check(chunked.dims[a] >= 1 && chunked.dims[a] <= kMaxAxisSize && chunked.chunk[a] >= 1 &&
              chunked.chunk[a] <= kMaxAxisSize,
          source);
    num_samples *= static_cast<double>(chunked.dims[a]);
    in_chunk *= static_cast<double>(chunked.chunk[a]);
    const std::int64_t num_along = (chunked.dims[a] - 1) / chunked.chunk[a] + 1;
    num_chunks *= static_cast<double>(num_along);
  }
  const auto sample = static_cast<double>(size_of(place.type));
  check(num_samples * sample == static_cast<double>(place.num_bytes) &&
            in_chunk * sample <= static_cast<double>(ChunkedStorage::kMostChunkBytes) &&
            num_chunks <= static_cast<double>(ChunkedStorage::kMostChunks) &&
            num_chunks == static_cast<double>(chunked.chunks.size()),
        source);
  for (const ChunkedStorage::Chunk& chunk : chunked.chunks)
    check(chunk.offset >= 0 && chunk.num_bytes >= 0 && chunk.num_bytes <= size &&
              chunk.offset <= size - chunk.num_bytes,
          source);
}

class SamplesInFile final : public StoredSamples {
 public:
  // `offset`: of the samples in the source.
  SamplesInFile(std::unique_ptr<ByteSource> source, std::int64_t offset, const StoredPlace& place,
                std::int64_t memory_for_pages)
      : source_(std::move(source)),
        offset_(offset),
        num_bytes_(place.num_bytes),
        sample_size_(size_of(place.type)),
        is_swapped_(sample_size_ > 1 &&
                    place.is_big_endian != (std::endian::native == std::endian::big)),
        memory_for_pages_(memory_for_pages) {}

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

class SamplesTold final : public StoredSamples {
 public:
  explicit SamplesTold(const StoredPlace& place) : place_(place) {}

  const StoredPlace& place() const noexcept { return place_; }
  std::int64_t num_bytes() const noexcept override { return place_.num_bytes; }
  std::int64_t memory_for_pages() const noexcept override { return 0; }
  void read(std::int64_t /*offset*/, std::span<std::byte> /*out*/) const override {
    throw Error(ErrorCode::kUnsupported, "samples of which only the place is known");
  }

 private:
  StoredPlace place_;
};

}  // namespace

bool stays_in_file(ScalarType type, std::int64_t num_bytes, const ReadOptions& options) {
  return options.may_stay_in_file && would_stay_in_file(type, num_bytes, options);
}

std::int64_t memory_for_pages(const ReadOptions& options) {
  std::int64_t bytes = own_memory(options) / 4;
  if (options.memory_limit > 0) bytes = std::min(bytes, options.memory_limit);
  return std::clamp(bytes, kLeastPages, kMostPages);
}

std::shared_ptr<const StoredSamples> samples_in_file(const ByteSource& source,
                                                     const StoredPlace& place,
                                                     const ReadOptions& options) {
  check_place(source, place);
  if (!place.chunked)
    return std::make_shared<SamplesInFile>(open_file(source.name()), place.offset, place,
                                           memory_for_pages(options));
  return std::make_shared<SamplesInFile>(
      unpack_chunks(source, *place.chunked, size_of(place.type), options), 0, place,
      memory_for_pages(options));
}

std::shared_ptr<const StoredSamples> samples_unpacked(std::unique_ptr<ByteSource> file,
                                                      ScalarType type, const ReadOptions& options) {
  StoredPlace place;
  place.type = type;
  place.is_big_endian = std::endian::native == std::endian::big;
  place.num_bytes = file->size();
  return std::make_shared<SamplesInFile>(std::move(file), 0, place, memory_for_pages(options));
}

std::shared_ptr<const StoredSamples> samples_told(const StoredPlace& place) {
  return std::make_shared<SamplesTold>(place);
}

const StoredPlace& stored_place(const StoredSamples& samples) {
  return dynamic_cast<const SamplesTold&>(samples).place();
}

}  // namespace ovoid::io

namespace ovoid {

bool would_stay_in_file(ScalarType type, std::int64_t num_bytes, const ReadOptions& options) {
  return io::can_be_shown(type) && io::bytes_of_field(type, num_bytes) > memory_for_field(options);
}

std::int64_t memory_for_field(const ReadOptions& options) {
  const auto most =
      static_cast<std::int64_t>(io::kMostOfMemory * static_cast<double>(io::own_memory(options)));
  return options.memory_limit > 0 ? std::min(most, options.memory_limit) : most;
}

}  // namespace ovoid
