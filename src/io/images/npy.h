// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <string>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

bool looks_like_npy(std::string_view start) noexcept;

// Reads a numpy array of shape (z, y, x) or (z, y, x, component), format versions 1 to 3, either
// order of axes in memory, either byte order; booleans become uint8. NPY knows no geometry: spacing
// is options.raw.spacing or 1. Throws Error.
Dataset read_npy(const ByteSource& source, const ReadOptions& options);

// Writes the array with shape (z, y, x) or (z, y, x, component). Geometry is lost. Throws
// Error(kFileWrite).
void write_npy(const Index3& dims, const DataArray& array, const std::string& path,
               const std::stop_token& stop = {});

// The header of a C-ordered array of native byte order, padded as numpy pads it. `shape` slowest
// first.
std::string npy_header(ScalarType type, std::span<const std::int64_t> shape);

}  // namespace ovoid::io
