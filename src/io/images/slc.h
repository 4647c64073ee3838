// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

bool looks_like_slc(std::string_view start) noexcept;

// Reads a volume of VolVis (.slc): 8 bits, as it is or run-length encoded slice by slice; spacing,
// no origin and no patient space. Source: [Avila 1994]. Throws Error.
Dataset read_slc(const ByteSource& source, const ReadOptions& options);

}  // namespace ovoid::io
