// SPDX-License-Identifier: Apache-2.0
// Samples of a lattice that are left in their file.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Whether samples of one component are left in a file, their own or a temporary one: if they may
// be, a lattice can show them as they are, and a field of them, with coefficients, would take most
// of the memory that is left.
bool stays_in_file(ScalarType type, std::int64_t num_bytes, const ReadOptions& options);

// How much of samples that stay in their file may be kept in memory: a quarter of what is left,
// within reason.
std::int64_t memory_for_pages(const ReadOptions& options);

// How samples lie in chunks, which may be packed: an array with axes from slow to fast is cut along
// all of them, and chunks at an end are whole, too.
struct ChunkedStorage {
  static constexpr std::int64_t kMostChunkBytes = std::int64_t{64} << 20;
  static constexpr std::int64_t kMostChunks = std::int64_t{1} << 20;

  std::vector<std::int64_t> dims;   // samples
  std::vector<std::int64_t> chunk;  // samples of a chunk
  bool is_shuffled = false;         // byte planes first, before deflate
  bool is_deflated = false;
  struct Chunk {
    std::int64_t offset = 0, num_bytes = 0;
  };
  std::vector<Chunk> chunks;  // in the file, the last axis fastest
};

// Where samples lie in a file: behind each other, or in chunks.
struct StoredPlace {
  ScalarType type = ScalarType::kUInt8;
  bool is_big_endian = false;
  std::int64_t offset = 0;     // not of chunks
  std::int64_t num_bytes = 0;  // unpacked
  std::shared_ptr<const ChunkedStorage> chunked{};
};

// The samples, whose file is opened again; those in chunks are unpacked to a temporary file now.
// Throws what open_file() and unpack_chunks() do, and Error(kFileFormat) for a place that is not
// within the file or contradicts itself.
std::shared_ptr<const StoredSamples> samples_in_file(const ByteSource& source,
                                                     const StoredPlace& place,
                                                     const ReadOptions& options);

// Samples of native byte order that a reader has unpacked to a file, from its front to its end.
std::shared_ptr<const StoredSamples> samples_unpacked(std::unique_ptr<ByteSource> file,
                                                      ScalarType type, const ReadOptions& options);

// What a reader's process tells its host: nobody can read them. stored_place() is for these alone.
std::shared_ptr<const StoredSamples> samples_told(const StoredPlace& place);
const StoredPlace& stored_place(const StoredSamples& samples);

}  // namespace ovoid::io
