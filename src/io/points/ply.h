// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <string>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Reads the points of a PLY file, text or binary: the element "vertex", else the first one with x,
// y, z; the others, such as faces, are passed over. With scale_0..2 and rot_0..3 the points are
// kernels as 3D Gaussian splatting writes them: "scale" holds the sigmas, which the file has as
// natural logarithms, "rotation" the quaternion w x y z as the file has it. Positions are float32
// or float64, arrays have the file's types. Peak memory is that of the arrays. Throws Error.
Dataset read_ply(const ByteSource& source, const ReadOptions& options);

// Writes particles or kernels so that read_ply() gives them back: binary, little endian; float32
// sigmas within a relative 1.2e-7 max(1, |ln sigma|), since it is their logarithm that is stored.
// Integers of 8 bytes become float64. Throws Error(kFileWrite); kInvalidArgument for sigmas that
// are not above 0 and for arrays whose names mean something else in the format.
void write_ply(const Dataset& dataset, const std::string& path, const std::stop_token& stop = {});

}  // namespace ovoid::io
