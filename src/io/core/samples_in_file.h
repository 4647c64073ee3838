// SPDX-License-Identifier: Apache-2.0
// Samples of a lattice that are left in their file.
#pragma once

#include <cstdint>
#include <memory>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Whether samples of one component, which lie behind each other in one file, are left there: if
// they may be, a lattice can show them as they are, and a field of them, with coefficients, would
// take most of the memory that is left.
bool stays_in_file(ScalarType type, std::int64_t num_bytes, const ReadOptions& options);

// The samples from byte `offset` of the source, whose file is opened again. `offset + num_bytes` is
// within it. Throws what open_file does.
std::shared_ptr<const StoredSamples> samples_in_file(const ByteSource& source, std::int64_t offset,
                                                     std::int64_t num_bytes, ScalarType type,
                                                     bool is_big_endian);

}  // namespace ovoid::io
