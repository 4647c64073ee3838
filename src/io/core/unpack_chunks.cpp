// SPDX-License-Identifier: Apache-2.0
#include "io/core/unpack_chunks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "io/core/decompressors.h"
#include "io/core/samples.h"
#include "io/core/temporary_file.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

using Places = std::vector<std::int64_t>;  // one for each axis, the slowest first

// Goes on to the next place below `ends`, the last axis fastest; false after the last.
bool advance(Places& at, const Places& ends, std::size_t num_axes) {
  for (std::size_t a = num_axes; a-- > 0;) {
    if (++at[a] < ends[a]) return true;
    at[a] = 0;
  }
  return false;
}

// Chunk `number`, `num_bytes` unpacked.
std::vector<std::byte> unpacked(const ByteSource& source, const ChunkedStorage& storage,
                                std::size_t number, std::size_t num_bytes,
                                std::size_t sample_size) {
  const ChunkedStorage::Chunk& chunk = storage.chunks[number];
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: chunk {}: {}", source.name(), number, what));
  };
  std::vector<std::byte> packed(static_cast<std::size_t>(chunk.num_bytes));
  source.read(chunk.offset, packed);
  if (storage.is_deflated) {
    std::vector<std::byte> inflated(num_bytes);
    Inflater inflater;
    inflater.stream.next_in = reinterpret_cast<Bytef*>(packed.data());
    inflater.stream.avail_in = static_cast<uInt>(packed.size());
    inflater.stream.next_out = reinterpret_cast<Bytef*>(inflated.data());
    inflater.stream.avail_out = static_cast<uInt>(inflated.size());
    const std::string wrong = inflater.step();
    if (!wrong.empty()) fail(wrong);
    packed = std::move(inflated);
    if (!inflater.ended || inflater.stream.avail_out != 0) fail("has another size than it claims");
  }
  if (packed.size() != num_bytes) fail("has another size than it claims");
  if (!storage.is_shuffled || sample_size == 1) return packed;
  std::vector<std::byte> samples(num_bytes);
  const std::size_t count = num_bytes / sample_size;
  for (std::size_t b = 0; b < sample_size; ++b) {
    const std::byte* const plane = packed.data() + b * count;
    for (std::size_t i = 0; i < count; ++i) samples[i * sample_size + b] = plane[i];
  }
  return samples;
}

// A chunk's samples to their places.
void write_chunk(const ChunkedStorage& storage, const Places& place,
                 std::span<const std::byte> bytes, std::size_t sample_size, TemporaryFile& file) {
  const std::size_t rank = place.size();
  Places ends(rank), at(rank, 0);  // within the chunk
  for (std::size_t a = 0; a < rank; ++a)
    ends[a] = std::min(storage.chunk[a], storage.dims[a] - place[a] * storage.chunk[a]);
  // Axes that a chunk spans are written in one piece, and one axis more.
  std::size_t num_outer = rank - 1;
  while (num_outer > 0 && storage.chunk[num_outer] == storage.dims[num_outer]) --num_outer;
  std::size_t piece = sample_size;
  for (std::size_t a = num_outer; a < rank; ++a) piece *= static_cast<std::size_t>(ends[a]);
  do {
    std::int64_t to = 0, from = 0;
    for (std::size_t a = 0; a < rank; ++a) {
      to = to * storage.dims[a] + place[a] * storage.chunk[a] + at[a];
      from = from * storage.chunk[a] + at[a];
    }
    const auto size = static_cast<std::int64_t>(sample_size);
    file.write(to * size, bytes.subspan(static_cast<std::size_t>(from * size), piece));
  } while (advance(at, ends, num_outer));
}

}  // namespace

std::unique_ptr<ByteSource> unpack_chunks(const ByteSource& source, const ChunkedStorage& storage,
                                          std::size_t sample_size, const ReadOptions& options) {
  const std::size_t rank = storage.dims.size();
  std::size_t num_bytes = sample_size, chunk_bytes = sample_size;
  Places counts, place(rank, 0);
  for (std::size_t a = 0; a < rank; ++a) {
    num_bytes *= static_cast<std::size_t>(storage.dims[a]);
    chunk_bytes *= static_cast<std::size_t>(storage.chunk[a]);
    counts.push_back((storage.dims[a] - 1) / storage.chunk[a] + 1);
  }
  TemporaryFile file(source.name(), static_cast<std::int64_t>(num_bytes));
  ReadProgress progress(options, static_cast<std::int64_t>(storage.chunks.size()));
  for (std::size_t number = 0; number < storage.chunks.size(); ++number) {
    write_chunk(storage, place, unpacked(source, storage, number, chunk_bytes, sample_size),
                sample_size, file);
    advance(place, counts, rank);
    progress.advance(1);
  }
  return file.finish();
}

}  // namespace ovoid::io
