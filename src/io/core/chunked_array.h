// SPDX-License-Identifier: Apache-2.0
// Lattices from arrays of any number of axes in any order, which lie in chunks: Zarr, and NPY and
// HDF5 where the order of axes is given.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/core/channel.h"
#include "io/core/short_floats.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// An array that is cut into chunks of one shape; those at an end are whole, too.
struct ChunkedArray {
  static constexpr std::int64_t kMostChunkBytes = (std::int64_t{1} << 31) - 1;

  std::string where;                // for messages: "a.zarr/0"
  std::string name = "values";      // of the dataset's array
  std::vector<Channel> channels{};  // empty: numbered
  std::string axes{};               // a letter for each axis (axis_order.h), the slowest first
  std::vector<std::int64_t> shape{}, chunk{};  // samples along each axis
  ScalarType type = ScalarType::kUInt8;
  ShortFloat short_float = ShortFloat::kNone;  // which `type`, uint16, are the bits of
  bool is_big_endian = false;
  bool is_first_fastest = false;    // within a chunk the first axis varies fastest, else the last
  std::array<std::byte, 8> fill{};  // a stored sample of chunks that are not there, native order
  // Fills `out`, a chunk's bytes, with the samples of the chunk that has this number along each
  // axis; false, and nothing done, if it is not there. Called from many threads. Throws Error.
  std::function<bool(std::span<const std::int64_t> number, std::span<std::byte> out)> read{};
  // Of a reader's process, whose chunks nobody else can read: the place in the file (samples_told)
  // of `count` of the samples along the slowest axis, from `first` on, the last axis fastest; null
  // if they lie otherwise. Empty: chunks are read where they are asked for.
  std::function<std::shared_ptr<const StoredSamples>(std::int64_t first, std::int64_t count)>
      stored_rows{};

  std::int64_t size_of_axis(char letter) const;  // 1 if there is none
  Index3 dims() const { return {size_of_axis('x'), size_of_axis('y'), size_of_axis('z')}; }
  // Channels are the components of one array if their axis is the last, else arrays of their own.
  bool has_components() const { return axes.ends_with('c'); }
  std::int64_t num_channels() const { return has_components() ? 1 : size_of_axis('c'); }
  std::string channel_name(std::int64_t channel) const;
};

// Throws Error unless the array can be a lattice: kFileFormat for sizes that no file has,
// kUnsupported for chunks of more than kMostChunkBytes, too many channels or time steps, or an axis
// of more than one sample that is none of those known.
void check_chunked(const ChunkedArray& array);

// Reads one time step of the arrays, which are checked and agree in dims and steps, into `dataset`:
// lattice.dims, num_steps, step and arrays. The step is options.step or the first that varies, with
// a note. options.array names the one array, or channel, that is read. Where memory does not hold
// the step, and options say so, it stays in its file: chunks are then read when they are needed,
// and those used last are kept. Peak memory: the step, and two chunks for each thread. Throws
// Error: kInvalidArgument for a step or array that is not there, kOutOfMemory, what `read` throws.
void read_chunked(const std::vector<ChunkedArray>& arrays, const ReadOptions& options,
                  Dataset& dataset);

// A channel of one step that stays in its file, of an array without components. Throws
// Error(kOutOfMemory) unless a layer of chunks fits into half of `memory_for_pages`: a frame would
// unpack every chunk over and over.
std::shared_ptr<const StoredSamples> stored_chunks(const ChunkedArray& array, std::int64_t step,
                                                   std::int64_t channel,
                                                   std::int64_t memory_for_pages);

// --- for those two ------------------------------------------------------------------------------

std::int64_t num_chunk_bytes(const ChunkedArray& array);

// A chunk's samples in native byte order, num_chunk_bytes() of them; false if it is not there.
bool load_chunk(const ChunkedArray& array, std::span<const std::int64_t> number,
                std::span<std::byte> out);

// Samples of a chunk: the first and how many along each axis, and, where they go, the bytes from
// one to the next.
struct ChunkBox {
  std::vector<std::int64_t> first, count, to_strides;
};

// Copies them out of a chunk that was loaded; writes the array's fill value where `chunk` is empty.
void copy_chunk_box(const ChunkedArray& array, std::span<const std::byte> chunk,
                    const ChunkBox& box, std::byte* to);

}  // namespace ovoid::io
