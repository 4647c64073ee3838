// SPDX-License-Identifier: Apache-2.0
// What the checks of VTK's two formats share.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "io/core/byte_source.h"
#include "ovoid/error.h"

namespace ovoid::io {

// More would be no image's, and VTK takes some memory and time for each before it reads a value.
inline constexpr std::int64_t kMaxVtkArrays = 10000;
inline constexpr std::int64_t kMaxVtkComponents = 1 << 20;

// Throws Error(code) with the file's name in front.
[[noreturn]] void fail_header(const ByteSource& source, const std::string& what,
                              ErrorCode code = ErrorCode::kFileFormat);

// Samples of an image, 0 if it is empty (dims[0] == 0). Throws Error(kFileFormat) naming `field` if
// they are more than any file holds.
std::int64_t num_points(const ByteSource& source, const std::string& field,
                        const std::array<std::int64_t, 3>& dims);
// Its cells; an axis of one sample counts as one cell.
std::int64_t num_cells(const std::array<std::int64_t, 3>& dims);

}  // namespace ovoid::io
