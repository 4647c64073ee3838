// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/chunked_array.h"
#include "io/images/npy_header.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

bool looks_like_npy(std::string_view start) noexcept;

// Reads a numpy array, format versions 1 to 3, either order of axes in memory, either byte order;
// booleans become uint8. Which axis is which says options.raw.axis_order, else usual_axis_order().
// One time step is read, and channels become arrays. NPY knows no geometry: spacing is
// options.raw.spacing or 1. Throws Error.
Dataset read_npy(const ByteSource& source, const ReadOptions& options);

// The axes of an array that is to be a lattice (io/core/axis_order.h). Throws Error: kUnsupported,
// kInvalidArgument for an order that does not fit.
std::string npy_axes(const std::string& name, const NpyHeader& header, const ReadOptions& options);

// The array as read_chunked() takes it. `source`: an NPY file, or what an NPZ holds of one; it may
// be read from many threads. Throws Error.
ChunkedArray npy_array(const std::shared_ptr<const ByteSource>& source, const NpyHeader& header,
                       const std::string& axes, std::vector<std::string>& notes);

// Writes the array with shape (z, y, x) or (z, y, x, component). Geometry is lost. Throws
// Error(kFileWrite).
void write_npy(const Index3& dims, const DataArray& array, const std::string& path,
               const std::stop_token& stop = {});

// The header of a C-ordered array of native byte order, padded as numpy pads it. `shape` slowest
// first.
std::string npy_header(ScalarType type, std::span<const std::int64_t> shape);

}  // namespace ovoid::io
