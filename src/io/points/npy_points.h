// SPDX-License-Identifier: Apache-2.0
// NumPy's arrays as points: an NPY of positions, or an NPZ of named arrays.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <string>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Up to so many rows a table of 3 or 4 columns may as well be a matrix, or its transpose.
inline constexpr std::int64_t kMaxUnclearPoints = 4;

// Is the shape (N, 3), or (N, 4), with N > kMaxUnclearPoints?
bool is_npy_of_points(std::span<const std::int64_t> shape) noexcept;

// Positions, and of four columns the last one as the array "value"; options.share alone is read.
// Throws Error.
Dataset read_npy_points(const ByteSource& source, const ReadOptions& options);

// The arrays of an NPZ. Without positions they are volumes (io/images/npz_volume.h), as they are
// with options.raw.axis_order. Points: `positions`, (N, 3), or the only one called like positions;
// the others of N rows are arrays, what does not fit is left out with a note. Peak memory is that
// of the arrays, or options.share of them, and, while it is unpacked, all of one more. Throws
// Error.
Dataset read_npz(const ByteSource& source, const ReadOptions& options);

// Writes positions and arrays under their names, stored. Throws Error(kFileWrite, kUnsupported).
void write_npz(const Dataset& dataset, const std::string& path, const std::stop_token& stop = {});

}  // namespace ovoid::io
