// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>

#include "io/core/samples_in_file.h"

namespace ovoid::io {

// The samples of chunks behind each other, in the file's byte order, in a temporary file. `storage`
// has been checked against the source. Memory: two chunks. Throws Error: kFileFormat for a damaged
// chunk, kCancelled, and what TemporaryFile does.
std::unique_ptr<ByteSource> unpack_chunks(const ByteSource& source, const ChunkedStorage& storage,
                                          std::size_t sample_size, const ReadOptions& options);

}  // namespace ovoid::io
